//! A compiled rod with its memory: what the integrators work with.

use std::sync::Arc;

use super::choice::{Kernel, Solve};
use super::compile;
use super::description::Rod;
use super::effect::support::Held;
use super::kernel::kinematics::Pose;
use super::kernel::{chain, elasticity, validity};
use super::plan::point::Place;
use super::state::tangent::Tangent;
use super::sweeps::Sweeps;
use super::tell::{Explanation, Multiplications, cost};
use crate::error::{Interrupted, InvalidInput};
use crate::lie::{Instructions, Planar, Plane, Spatial, Vector};
use crate::linalg::{ChainMatrix, Matrix};
use crate::model::{Chain, Discretised, Elastic, Energy, Flaw, InTime, Model};
use crate::rod::{MAX_NODES, STRAINS, piece};
use crate::springs::Springs;
use crate::world::BaseMotion;

/// A Cosserat rod ready to be moved. Clones share what does not change and have memory of their own.
#[derive(Clone, Debug)]
pub struct RodModel {
    sweeps: AnySweeps,
    /// Those of the rod without its loads, where that is more than stiffness times coordinates: where it has supports.
    unloaded: Option<Box<AnySweeps>>,
    solve: Solve,
    multiplications: Multiplications,
    explanation: Arc<Explanation>,
    rod: Arc<Rod>,
    /// What is taken for the forces of the supports' springs.
    held: Option<Vec<f64>>,
}

#[derive(Clone, Debug)]
enum AnySweeps {
    Planar(Sweeps<Planar<true>>),
    Spatial(Sweeps<Spatial<true>>),
    #[cfg(feature = "portable")]
    PortablePlanar(Sweeps<Planar<false>>),
    #[cfg(feature = "portable")]
    PortableSpatial(Sweeps<Spatial<false>>),
}

impl AnySweeps {
    /// The sweeps for a valid rod, in a plane where one is given, with fused packs or, where they are compiled, with
    /// portable ones.
    fn new(rod: &Rod, plane: Option<Plane>, is_fused: bool) -> Self {
        #[cfg(feature = "portable")]
        if !is_fused {
            return match plane {
                Some(plane) => Self::PortablePlanar(Sweeps::new(compile::plan(rod, plane))),
                None => Self::PortableSpatial(Sweeps::new(compile::plan(rod, ()))),
            };
        }
        let _ = is_fused;
        match plane {
            Some(plane) => Self::Planar(Sweeps::new(compile::plan(rod, plane))),
            None => Self::Spatial(Sweeps::new(compile::plan(rod, ()))),
        }
    }

    /// The sweeps for another rod, of the same kind.
    fn with_rod(&self, rod: &Rod) -> Self {
        match self {
            Self::Planar(sweeps) => Self::Planar(sweeps.with_rod(rod)),
            Self::Spatial(sweeps) => Self::Spatial(sweeps.with_rod(rod)),
            #[cfg(feature = "portable")]
            Self::PortablePlanar(sweeps) => Self::PortablePlanar(sweeps.with_rod(rod)),
            #[cfg(feature = "portable")]
            Self::PortableSpatial(sweeps) => Self::PortableSpatial(sweeps.with_rod(rod)),
        }
    }

    /// The same sweeps with everything computed that could be skipped.
    fn with_nothing_skipped(&self) -> Self {
        match self {
            Self::Spatial(sweeps) => Self::Spatial(Sweeps::new(sweeps.plan().clone().with_nothing_skipped())),
            #[cfg(feature = "portable")]
            Self::PortableSpatial(sweeps) => {
                Self::PortableSpatial(Sweeps::new(sweeps.plan().clone().with_nothing_skipped()))
            }
            _ => unreachable!("in a plane, something is skipped"),
        }
    }

    fn kernel(&self) -> Kernel {
        match self {
            Self::Planar(_) => Kernel::Planar,
            Self::Spatial(_) => Kernel::Spatial,
            #[cfg(feature = "portable")]
            Self::PortablePlanar(_) => Kernel::Planar,
            #[cfg(feature = "portable")]
            Self::PortableSpatial(_) => Kernel::Spatial,
        }
    }
}

/// Calls a method of whatever sweeps there are.
macro_rules! on_sweeps {
    ($model:expr, $sweeps:ident => $call:expr) => {
        match $model {
            AnySweeps::Planar($sweeps) => $call,
            AnySweeps::Spatial($sweeps) => $call,
            #[cfg(feature = "portable")]
            AnySweeps::PortablePlanar($sweeps) => $call,
            #[cfg(feature = "portable")]
            AnySweeps::PortableSpatial($sweeps) => $call,
        }
    };
}

impl RodModel {
    /// Compiles `rod` for the simplest kernel, the best instructions of this machine and the cheapest solve; refuses
    /// a rod that is not valid, with everything that is wrong with it.
    pub fn new(rod: &Rod) -> Result<Self, InvalidInput> {
        Self::with_solve(rod, Solve::cheapest(rod))
    }

    /// The same with a solve that need not be the cheapest: to compare them.
    pub fn with_solve(rod: &Rod, solve: Solve) -> Result<Self, InvalidInput> {
        Self::check(rod)?;
        Ok(Self::with(
            rod,
            AnySweeps::new(rod, Kernel::plane(rod), Instructions::of_machine().has_fused()),
            solve,
        ))
    }

    /// Compiles `rod` for the instructions that all machines have, even where there are better ones: to compare them.
    #[cfg(feature = "portable")]
    pub fn portable(rod: &Rod) -> Result<Self, InvalidInput> {
        Self::check(rod)?;
        Ok(Self::with(rod, AnySweeps::new(rod, Kernel::plane(rod), false), Solve::cheapest(rod)))
    }

    /// Compiles `rod` for the spatial kernel even where a planar one would do: to compare them.
    pub fn spatial(rod: &Rod) -> Result<Self, InvalidInput> {
        Self::check(rod)?;
        Ok(Self::with(
            rod,
            AnySweeps::new(rod, None, Instructions::of_machine().has_fused()),
            Solve::cheapest(rod),
        ))
    }

    /// Compiles `rod` for the spatial kernel with everything computed that could be skipped, zeros included: to compare
    /// them.
    pub fn with_nothing_skipped(rod: &Rod) -> Result<Self, InvalidInput> {
        Self::check(rod)?;
        let sweeps = AnySweeps::new(rod, None, Instructions::of_machine().has_fused()).with_nothing_skipped();
        Ok(Self::with(rod, sweeps, Solve::cheapest(rod)))
    }

    /// Refuses a rod that is not valid, and a machine that this build has no sweeps for.
    fn check(rod: &Rod) -> Result<(), InvalidInput> {
        rod.validate()?;
        if !Instructions::of_machine().are_compiled() {
            let expected = "one with AVX2 and FMA, or a build with the feature `portable`";
            return Err(InvalidInput::new("this machine", "one without fused multiply-add", expected));
        }
        Ok(())
    }

    fn with(rod: &Rod, sweeps: AnySweeps, solve: Solve) -> Self {
        let nodes = nodes(rod, &on_sweeps!(&sweeps, sweeps => sweeps.plan().nodes()));
        let cost = on_sweeps!(&sweeps, sweeps => cost::multiplications(sweeps.plan(), solve));
        let explanation = Explanation::new(rod, sweeps.kernel(), solve, &nodes, &cost);
        let unloaded = (!rod.supports.is_empty()).then(|| Box::new(sweeps.with_rod(&rod.unloaded())));
        let rod = Arc::new(rod.clone());
        Self {
            sweeps,
            unloaded,
            solve,
            multiplications: cost,
            explanation: Arc::new(explanation),
            rod,
            held: None,
        }
    }

    /// The rod without its loads, where that is not stiffness alone; it rests where the base is.
    fn unloaded(&mut self) -> Option<&mut AnySweeps> {
        let unloaded = self.unloaded.as_deref_mut()?;
        if self.rod.base_motion.is_some() {
            let base = on_sweeps!(&self.sweeps, sweeps => sweeps.base());
            on_sweeps!(&mut *unloaded, sweeps => sweeps.place_base(&base));
            // Anchors are seen anew from there.
            on_sweeps!(&mut *unloaded, sweeps => sweeps.hold_springs(self.held.as_deref()));
        }
        Some(unloaded)
    }

    /// What it was compiled from.
    pub fn description(&self) -> &Rod {
        &self.rod
    }

    /// What is computed for this rod, what is skipped, and why.
    pub fn explanation(&self) -> &Explanation {
        &self.explanation
    }

    /// The multiplications that one evaluation of each kind takes.
    pub fn multiplications(&self) -> Multiplications {
        self.multiplications
    }

    /// The kernel in use.
    pub fn kernel(&self) -> Kernel {
        self.sweeps.kernel()
    }

    /// How linear systems are solved.
    pub fn solve(&self) -> Solve {
        self.solve
    }

    /// Quadrature nodes of each segment.
    pub fn nodes(&self) -> Vec<usize> {
        nodes(&self.rod, &on_sweeps!(&self.sweeps, sweeps => sweeps.plan().nodes()))
    }

    /// The pose at arc length `x` of the unstretched rod, 0 <= x <= L (clamped there): the body axes and the position in
    /// the world.
    pub fn pose(&mut self, q: &[f64], x: f64) -> Pose {
        self.pose_at(q, &self.place(x))
    }

    /// The place at arc length `x` of the unstretched rod, clamped to [0, L], for [`Self::pose_at`].
    pub fn place(&self, x: f64) -> Place {
        on_sweeps!(&self.sweeps, sweeps => sweeps.place(x))
    }

    /// The pose at a place of this rod. Several places of one state cost little more than one.
    pub fn pose_at(&mut self, q: &[f64], place: &Place) -> Pose {
        on_sweeps!(&mut self.sweeps, sweeps => sweeps.pose(q, place))
    }

    /// Moment and force that the base exerts on the rod in a motion, about the base and in world axes; of a planar
    /// rod what lies in its plane.
    pub fn base_wrench(&mut self, q: &[f64], qd: &[f64], qdd: &[f64]) -> [Vector<f64>; 2] {
        on_sweeps!(&mut self.sweeps, sweeps => sweeps.base_wrench([q, qd, qdd]))
    }

    /// Angular velocity of the section at a place and velocity of its point, in world axes, that of a base that moves
    /// included.
    pub fn velocity_at(&mut self, q: &[f64], qd: &[f64], place: &Place) -> [Vector<f64>; 2] {
        on_sweeps!(&mut self.sweeps, sweeps => sweeps.velocity(q, qd, place))
    }

    /// The Jacobian of the pose at a place, 6 x n: angular velocity and velocity of its point, in world axes, for
    /// unit rates of the coordinates; `Psi = int S`, moved from the base to the point. Its transpose takes a moment
    /// and a force that act there to generalised forces. What a moving base contributes has nothing to do with the
    /// coordinates. Costs about an inverse dynamics for every few coordinates.
    pub fn jacobian_at(&mut self, q: &[f64], place: &Place, jacobian: &mut Matrix) {
        on_sweeps!(&mut self.sweeps, sweeps => sweeps.jacobian(q, place, jacobian));
    }
}

impl RodModel {
    /// By virtual work: what the rod needs against a unit of each force.
    fn find_jacobian_of_springs(&mut self, q: &[f64], jacobian: &mut Matrix) {
        let (n, length) = (q.len(), self.rod.length());
        let held = self.held.clone();
        let mut elastic = vec![0.0; n];
        on_sweeps!(&self.sweeps, sweeps => elasticity::forces(sweeps.plan(), q, &mut elastic));
        // Forces of the size of the rod's own lose no digits beside them.
        let size = elastic.iter().fold(0.0, |size: f64, tau| size.max(tau.abs()));
        let moment = if size > 0.0 { size / length } else { 1.0 };
        let mut tau = elastic.clone();
        let mut forces = vec![0.0; jacobian.nrows()];
        let Some(unloaded) = self.unloaded() else { return };
        for i in 0..forces.len() {
            let unit = if i % 6 < 3 { moment } else { moment / length };
            forces[i] = unit;
            on_sweeps!(&mut *unloaded, sweeps => sweeps.hold_springs(Some(&forces)));
            on_sweeps!(&mut *unloaded, sweeps => sweeps.forces_at_rest(q, &mut tau));
            forces[i] = 0.0;
            for j in 0..n {
                jacobian[(i, j)] = (elastic[j] - tau[j]) / unit;
            }
        }
        on_sweeps!(&mut *unloaded, sweeps => sweeps.hold_springs(held.as_deref()));
    }
}

/// Nodes of each segment, from those of the pieces.
fn nodes(rod: &Rod, of_pieces: &[usize]) -> Vec<usize> {
    let mut of_pieces = of_pieces.iter();
    rod.segments.iter().map(|segment| of_pieces.by_ref().take(piece::number(segment)).sum()).collect()
}

impl Model for RodModel {
    fn n(&self) -> usize {
        on_sweeps!(&self.sweeps, sweeps => sweeps.plan().n)
    }

    fn inverse_dynamics(&mut self, q: &[f64], qd: &[f64], qdd: &[f64], tau: &mut [f64]) {
        on_sweeps!(&mut self.sweeps, sweeps => sweeps.inverse_dynamics([q, qd, qdd], tau));
    }

    fn weighted_tangent(
        &mut self,
        q: &[f64],
        qd: &[f64],
        qdd: &[f64],
        weights: [f64; 3],
        tangent: &mut Matrix,
    ) {
        let tangent = Tangent::Dense(tangent);
        on_sweeps!(&mut self.sweeps, sweeps => sweeps.weighted_tangent([q, qd, qdd], weights, tangent));
    }

    /// By the products that both form, the factorisation included.
    fn tangent_cost(&self) -> f64 {
        let Multiplications { residual, tangent, factorisation, .. } = self.multiplications;
        (tangent + factorisation) as f64 / residual.max(1) as f64
    }

    /// `M = int Psi^T N Psi`, which is the tangent with respect to `qdd`: symmetric to rounding because the quadrature
    /// sums by parts exactly, so that half of it is computed.
    fn mass_matrix(&mut self, q: &[f64], mass: &mut Matrix) {
        on_sweeps!(&mut self.sweeps, sweeps => sweeps.mass_matrix(q, Tangent::Dense(mass)));
    }

    fn chain(&self) -> Option<Chain> {
        (self.solve == Solve::Chain).then(|| {
            on_sweeps!(&self.sweeps, sweeps => {
                let plan = sweeps.plan();
                Chain { tangent: chain::tangent(plan), mass: chain::mass(plan) }
            })
        })
    }

    fn chain_tangent(
        &mut self,
        q: &[f64],
        qd: &[f64],
        qdd: &[f64],
        weights: [f64; 3],
        tangent: &mut ChainMatrix,
    ) {
        let tangent = Tangent::Chain(tangent);
        on_sweeps!(&mut self.sweeps, sweeps => sweeps.weighted_tangent([q, qd, qdd], weights, tangent));
    }

    fn chain_mass_matrix(&mut self, q: &[f64], mass: &mut ChainMatrix) {
        on_sweeps!(&mut self.sweeps, sweeps => sweeps.mass_matrix(q, Tangent::Chain(mass)));
    }

    fn energy(&mut self, q: &[f64], qd: &[f64]) -> Energy {
        on_sweeps!(&mut self.sweeps, sweeps => sweeps.energy(q, qd))
    }

    fn dissipated_power(&mut self, q: &[f64], qd: &[f64]) -> f64 {
        on_sweeps!(&mut self.sweeps, sweeps => sweeps.dissipated_power(q, qd))
    }

    fn tip(&mut self, q: &[f64]) -> [f64; 3] {
        let tip = self.place(f64::INFINITY);
        on_sweeps!(&mut self.sweeps, sweeps => sweeps.position(q, &tip)).to_array()
    }

    fn length(&self) -> f64 {
        self.rod.length()
    }

    fn is_damped(&self) -> bool {
        on_sweeps!(&self.sweeps, sweeps => sweeps.is_damped())
    }

    fn has_velocity_forces(&self) -> bool {
        on_sweeps!(&self.sweeps, sweeps => sweeps.has_velocity_forces())
    }

    /// Of follower loads, of loads that vary in time, of moments (one that keeps its direction in space has no
    /// potential), and of a base that is moved.
    fn supplied_power(&mut self, q: &[f64], qd: &[f64], qdd: &[f64]) -> f64 {
        on_sweeps!(&mut self.sweeps, sweeps => sweeps.supplied_power([q, qd, qdd]))
    }

    fn is_driven(&self) -> bool {
        on_sweeps!(&self.sweeps, sweeps => sweeps.is_driven())
    }
}

impl Elastic for RodModel {
    /// `K q`, and what the supports answer.
    fn elastic_forces(&mut self, q: &[f64], tau: &mut [f64]) {
        match self.unloaded() {
            Some(unloaded) => on_sweeps!(unloaded, sweeps => sweeps.forces_at_rest(q, tau)),
            None => on_sweeps!(&self.sweeps, sweeps => elasticity::forces(sweeps.plan(), q, tau)),
        }
    }

    fn elastic_tangent(&mut self, q: &[f64], tangent: &mut Matrix) {
        match self.unloaded() {
            Some(unloaded) => {
                on_sweeps!(unloaded, sweeps => sweeps.tangent_at_rest(q, Tangent::Dense(tangent)));
            }
            None => on_sweeps!(&self.sweeps, sweeps => elasticity::stiffness(sweeps.plan(), tangent)),
        }
    }

    /// Moment and force of every support, in the axes of the base.
    fn springs(&self) -> usize {
        6 * self.rod.supports.len()
    }

    fn linearise_springs(&mut self, q: &[f64], springs: &mut Springs) {
        let found = on_sweeps!(&mut self.sweeps, sweeps => sweeps.springs(q));
        springs.energy = found.iter().map(|held| held.energy).sum();
        for (a, Held { forces, stiffness, firm, .. }) in found.into_iter().enumerate() {
            for half in 0..2 {
                let first = 6 * a + 3 * half;
                springs.forces[first..first + 3].copy_from_slice(&forces[half].to_array());
                elasticity::write_roots(&stiffness[half], firm[half], first, springs);
            }
        }
        self.find_jacobian_of_springs(q, &mut springs.jacobian);
    }

    fn hold_springs(&mut self, forces: Option<&[f64]>) {
        self.held = forces.map(<[f64]>::to_vec);
        on_sweeps!(&mut self.sweeps, sweeps => sweeps.hold_springs(forces));
        if let Some(unloaded) = &mut self.unloaded {
            on_sweeps!(&mut **unloaded, sweeps => sweeps.hold_springs(forces));
        }
    }

    /// A radian over the rod's length, and a stretch or shear of one.
    fn typical_coordinates(&self, sizes: &mut [f64]) {
        on_sweeps!(&self.sweeps, sweeps => elasticity::typical_coordinates(sweeps.plan(), sizes));
    }
}

impl InTime for RodModel {
    fn horizon(&self, t: f64) -> f64 {
        self.rod.horizon(t)
    }

    fn shortest_period(&self) -> f64 {
        self.rod.shortest_period()
    }

    fn time_span(&self) -> [f64; 2] {
        self.rod.base_motion.as_ref().map_or([f64::NEG_INFINITY, f64::INFINITY], BaseMotion::span)
    }

    fn varies_in_time(&self) -> bool {
        on_sweeps!(&self.sweeps, sweeps => sweeps.plan().varies_in_time)
    }

    fn not_finite(&self) -> Option<String> {
        let t = on_sweeps!(&self.sweeps, sweeps => sweeps.time_without_loads())?;
        self.rod.not_finite(t)
    }

    #[inline]
    fn set_time(&mut self, t: f64) -> Result<(), Interrupted> {
        on_sweeps!(&mut self.sweeps, sweeps => sweeps.set_time(t))
    }
}

impl Discretised for RodModel {
    fn flaw(&self, q: &[f64]) -> Option<Flaw> {
        on_sweeps!(&self.sweeps, sweeps => validity::flaw(sweeps.plan(), q))
    }

    fn is_discretised(&self) -> bool {
        true
    }

    /// Of the six strains of every segment, where more modes leave the others as they are.
    fn modes(&self) -> Option<Vec<usize>> {
        let is_nested = self.rod.segments.iter().all(|segment| segment.basis.is_nested());
        is_nested.then(|| self.rod.segments.iter().flat_map(|segment| segment.modes).collect())
    }

    fn with_modes(&self, modes: &[usize]) -> Option<Self> {
        const MORE_NODES: usize = 8;
        let mut other = Rod::clone(&self.rod);
        for ((segment, modes), nodes) in
            other.segments.iter_mut().zip(modes.as_chunks::<STRAINS>().0).zip(self.nodes())
        {
            let more = modes
                .iter()
                .max()
                .copied()
                .unwrap_or(0)
                .saturating_sub(segment.modes.into_iter().max().unwrap_or(0));
            segment.modes = *modes;
            segment.nodes = Some((nodes / piece::number(segment) + MORE_NODES.max(more)).min(MAX_NODES));
        }
        Self::new(&other).ok()
    }

    fn with_nodes_times(&self, factor: usize) -> Option<Self> {
        let mut finer = Rod::clone(&self.rod);
        for (segment, nodes) in finer.segments.iter_mut().zip(self.nodes()) {
            let of_piece = nodes / piece::number(segment);
            segment.nodes.get_or_insert(factor * of_piece);
        }
        (finer != *self.rod).then(|| Self::new(&finer).ok()).flatten()
    }
}
