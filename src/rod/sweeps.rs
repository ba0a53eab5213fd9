//! The sweeps along a rod with their memory, run with the best instruction set that the machine has.

use std::sync::Arc;

use super::anchor::Held;
use super::base::Base;
use super::description::Rod;
use super::kinematics::{self, Place, Pose};
use super::plan::Plan;
use super::tangent::{self, Tangent, TangentWorkspace};
use super::turning::Turning;
use super::workspace::Workspace;
use super::{energy, inverse_dynamics, surroundings};
use crate::error::Interrupted;
use crate::lie::{Lanes, Vector, VectorSpace, Wrench};
use crate::model::Energy;

/// Whether this machine multiplies and adds in one instruction: 64-bit ARM does, and x86-64 with the wide instruction sets
/// that pulp knows.
pub(super) fn machine_has_fused() -> bool {
    cfg!(lissom_dev)
        || cfg!(any(target_arch = "x86_64", target_arch = "aarch64"))
            && !matches!(pulp::Arch::new(), pulp::Arch::Scalar)
}

/// Runs a sweep with the instructions that all machines have. Never inlined: these copies are only needed once.
#[inline(never)]
fn run_portably<Sweep: pulp::NullaryFnOnce>(sweep: Sweep) -> Sweep::Output {
    sweep.call()
}

/// A rod compiled for one geometry, with its memory.
#[derive(Clone, Debug)]
pub(super) struct Sweeps<G: Turning> {
    arch: pulp::Arch,
    is_plain: bool,
    plan: Arc<Plan<G>>,
    work: Workspace<G>,
    tangent: TangentWorkspace<G>,
    zeros: Vec<f64>,
}

// The sweeps are compiled once for every instruction set that pulp knows, and once for plain rods. They are structs, not closures: what pulp compiles
// must be inlined into its caller, which a closure promises to nobody.

struct Kinematics<'a, G: Turning> {
    plan: &'a Plan<G>,
    work: &'a mut Workspace<G>,
    q: &'a [f64],
}

impl<G: Turning> pulp::NullaryFnOnce for Kinematics<'_, G> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        kinematics::update(self.plan, self.work, self.q);
    }
}

struct Motion<'a, G: Turning, const PLAIN: bool> {
    plan: &'a Plan<G>,
    work: &'a mut Workspace<G>,
    state: [&'a [f64]; 3],
}

impl<G: Turning, const PLAIN: bool> pulp::NullaryFnOnce for Motion<'_, G, PLAIN> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let [q, qd, qdd] = self.state;
        inverse_dynamics::update::<G, PLAIN>(self.plan, self.work, q, qd, qdd);
    }
}

struct Projection<'a, G: Turning, const PLAIN: bool> {
    plan: &'a Plan<G>,
    work: &'a mut Workspace<G>,
    q: &'a [f64],
    qd: &'a [f64],
    tau: &'a mut [f64],
}

impl<G: Turning, const PLAIN: bool> pulp::NullaryFnOnce for Projection<'_, G, PLAIN> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        inverse_dynamics::project::<G, PLAIN>(self.plan, self.work, self.q, self.qd, self.tau);
    }
}

struct WeightedTangent<'a, G: Turning, const PLAIN: bool> {
    plan: &'a Plan<G>,
    work: &'a Workspace<G>,
    memory: &'a mut TangentWorkspace<G>,
    weights: [f64; 3],
    tangent: Tangent<'a>,
}

impl<G: Turning, const PLAIN: bool> pulp::NullaryFnOnce for WeightedTangent<'_, G, PLAIN> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Self { plan, work, memory, weights, tangent } = self;
        tangent::weighted_tangent::<G, PLAIN>(plan, work, memory, weights, tangent);
    }
}

impl<G: Turning> Sweeps<G> {
    /// Memory and the machine's best instructions for a plan.
    pub(super) fn new(plan: Plan<G>) -> Self {
        Self {
            arch: pulp::Arch::new(),
            is_plain: plan.is_plain() && !cfg!(lissom_dev),
            work: Workspace::new(&plan),
            tangent: TangentWorkspace::new(&plan),
            zeros: vec![0.0; plan.n],
            plan: Arc::new(plan),
        }
    }

    /// Those for another rod in the same frame.
    pub(super) fn with_rod(&self, rod: &Rod) -> Self {
        Self::new(Plan::new(rod, self.plan.frame))
    }

    pub(super) fn plan(&self) -> &Plan<G> {
        &self.plan
    }

    /// Runs a sweep with the instructions that its packs are for. Fused packs are not compiled for machines without fused
    /// instructions, where they would be slow.
    #[inline(always)]
    fn run<Sweep: pulp::NullaryFnOnce>(arch: pulp::Arch, sweep: Sweep) -> Sweep::Output {
        if !G::Pack::FUSED || cfg!(lissom_dev) {
            return run_portably(sweep);
        }
        #[cfg(target_arch = "x86_64")]
        match arch {
            pulp::Arch::V4(simd) => pulp::Simd::vectorize(simd, sweep),
            pulp::Arch::V3(simd) => pulp::Simd::vectorize(simd, sweep),
            _ => unreachable!("fused packs are chosen for machines with fused instructions"),
        }
        #[cfg(not(target_arch = "x86_64"))]
        arch.dispatch(sweep)
    }

    fn update_kinematics(&mut self, q: &[f64]) {
        let Self { arch, plan, work, .. } = self;
        Self::run(*arch, Kinematics { plan, work, q });
    }

    fn update_motion(&mut self, state: [&[f64]; 3]) {
        self.update_kinematics(state[0]);
        let Self { arch, is_plain, plan, work, .. } = self;
        if *is_plain && !cfg!(lissom_dev) {
            Self::run(*arch, Motion::<G, true> { plan, work, state });
        } else {
            Self::run(*arch, Motion::<G, false> { plan, work, state });
        }
    }

    fn project(&mut self, q: &[f64], qd: &[f64], tau: &mut [f64]) {
        let Self { arch, is_plain, plan, work, .. } = self;
        if *is_plain && !cfg!(lissom_dev) {
            Self::run(*arch, Projection::<G, true> { plan, work, q, qd, tau });
        } else {
            Self::run(*arch, Projection::<G, false> { plan, work, q, qd, tau });
        }
    }

    fn differentiate(&mut self, weights: [f64; 3], tangent: Tangent<'_>) {
        let Self { arch, is_plain, plan, work, tangent: memory, .. } = self;
        if *is_plain && !cfg!(lissom_dev) {
            Self::run(*arch, WeightedTangent::<G, true> { plan, work, memory, weights, tangent });
        } else {
            Self::run(*arch, WeightedTangent::<G, false> { plan, work, memory, weights, tangent });
        }
    }

    /// Calls with as many zeros as there are coordinates.
    fn with_zeros<T>(&mut self, f: impl FnOnce(&mut Self, &[f64]) -> T) -> T {
        let zeros = std::mem::take(&mut self.zeros);
        let result = f(self, &zeros);
        self.zeros = zeros;
        result
    }

    /// The motion of a state without accelerations.
    fn update_velocities(&mut self, q: &[f64], qd: &[f64]) {
        self.with_zeros(|sweeps, zeros| sweeps.update_motion([q, qd, zeros]));
    }

    /// Takes what varies with time at this time.
    pub(super) fn set_time(&mut self, t: f64) -> Result<(), Interrupted> {
        if self.plan.varies_in_time && self.work.time != t {
            surroundings::set(&self.plan, &mut self.work, t)?;
        }
        Ok(())
    }

    /// The time that is set, where a load is not finite then; NaN where none could be set.
    pub(super) fn time_without_loads(&self) -> Option<f64> {
        let is_finite = |wrench: &Wrench<G, f64>| {
            (wrench.force.dot(wrench.force) + wrench.moment.dot(wrench.moment)).is_finite()
        };
        (!self.work.acting.iter().all(is_finite)).then_some(self.work.time)
    }

    /// The base at the time that is set.
    pub(super) fn base(&self) -> Base {
        self.work.surroundings.base
    }

    /// Places the base of a rod without base motion.
    pub(super) fn place_base(&mut self, base: &Base) {
        surroundings::place(&self.plan, &mut self.work, base);
    }

    pub(super) fn place(&self, x: f64) -> Place {
        kinematics::place(&self.plan.segments, x)
    }

    pub(super) fn pose(&mut self, q: &[f64], place: &Place) -> Pose {
        self.update_kinematics(q);
        kinematics::pose(&self.plan, &self.work, q, place)
    }

    /// Angular velocity of a place and velocity of its point, in world axes.
    pub(super) fn velocity(&mut self, q: &[f64], qd: &[f64], place: &Place) -> [Vector<f64>; 2] {
        self.update_velocities(q, qd);
        kinematics::velocity(&self.plan, &self.work, place)
    }

    pub(super) fn inverse_dynamics(&mut self, state: [&[f64]; 3], tau: &mut [f64]) {
        self.update_motion(state);
        let [q, qd, _] = state;
        self.project(q, qd, tau);
    }

    pub(super) fn weighted_tangent(&mut self, state: [&[f64]; 3], weights: [f64; 3], tangent: Tangent<'_>) {
        self.update_motion(state);
        self.differentiate(weights, tangent);
    }

    pub(super) fn mass_matrix(&mut self, q: &[f64], mass: Tangent<'_>) {
        self.update_kinematics(q);
        self.differentiate([0.0, 0.0, 1.0], mass);
    }

    pub(super) fn energy(&mut self, q: &[f64], qd: &[f64]) -> Energy {
        self.update_velocities(q, qd);
        energy::energy(&self.plan, &self.work, q)
    }

    pub(super) fn dissipated_power(&mut self, q: &[f64], qd: &[f64]) -> f64 {
        let power = energy::power_of_damping(&self.plan, qd);
        if !self.plan.is_resisted() {
            return power;
        }
        self.update_velocities(q, qd);
        power + energy::power_of_resistance(&self.plan, &self.work)
    }

    /// Takes moments and forces (six numbers for each support) for those of the springs, until it gets none.
    pub(super) fn hold_springs(&mut self, forces: Option<&[f64]>) {
        self.work.motion_is_known = false;
        for (a, anchor) in self.work.anchors.iter_mut().enumerate() {
            anchor.hold(forces.map(|forces| {
                [0, 3].map(|part| Vector::from(std::array::from_fn(|i| forces[6 * a + part + i])))
            }));
        }
    }

    /// The springs of the supports, in their order.
    pub(super) fn springs(&mut self, q: &[f64]) -> Vec<Held> {
        self.update_kinematics(q);
        let (plan, work) = (&*self.plan, &self.work);
        let points = plan.points.iter().zip(&work.points);
        let mut found: Vec<_> = points
            .flat_map(|(point, state)| point.anchors.iter().map(move |&anchor| (anchor, state)))
            .map(|(a, state)| (a, work.anchors[a].springs(plan.frame, state)))
            .collect();
        found.sort_by_key(|(a, _)| *a);
        found.into_iter().map(|(_, springs)| springs).collect()
    }

    /// `tau(q, 0, 0)`.
    pub(super) fn forces_at_rest(&mut self, q: &[f64], tau: &mut [f64]) {
        self.with_zeros(|sweeps, zeros| sweeps.inverse_dynamics([q, zeros, zeros], tau));
    }

    /// Its derivative.
    pub(super) fn tangent_at_rest(&mut self, q: &[f64], tangent: Tangent<'_>) {
        self.with_zeros(|sweeps, zeros| sweeps.weighted_tangent([q, zeros, zeros], [1.0, 0.0, 0.0], tangent));
    }

    pub(super) fn supplied_power(&mut self, state: [&[f64]; 3]) -> f64 {
        self.update_motion(state);
        energy::supplied_power(&self.plan, &self.work)
    }

    /// Moment and force that the base exerts on the rod, in world axes.
    pub(super) fn base_wrench(&mut self, state: [&[f64]; 3]) -> [Vector<f64>; 2] {
        self.update_motion(state);
        let Wrench { moment, force } = self.work.base_wrench;
        let rotation = &self.work.surroundings.base.rotation;
        let frame = self.plan.frame;
        [G::axial_in_space(frame, moment), G::in_space(frame, force)].map(|v| rotation.apply(v))
    }

    /// Position of a place in the frame of the base.
    pub(super) fn position(&mut self, q: &[f64], place: &Place) -> Vector<f64> {
        self.update_kinematics(q);
        G::in_space(self.plan.frame, kinematics::position(&self.plan, &self.work, place))
    }
}

#[cfg(test)]
mod tests {
    use super::super::description::{Rod, Segment};
    use super::super::section::Section;
    use super::*;
    use crate::lie::{Planar, Plane, Spatial};
    use crate::linalg::Matrix;

    /// All instruction sets of this machine that fused packs are compiled for.
    fn instruction_sets() -> Vec<pulp::Arch> {
        #[cfg(target_arch = "x86_64")]
        {
            use pulp::x86::{V3, V4};
            let wide = [V3::try_new().map(pulp::Arch::V3), V4::try_new().map(pulp::Arch::V4)];
            wide.into_iter().flatten().collect()
        }
        #[cfg(not(target_arch = "x86_64"))]
        vec![pulp::Arch::new()]
    }

    /// Forces, tangent and mass matrix of a fixed state.
    fn results<G: Turning>(plan: &Plan<G>, arch: pulp::Arch, is_plain: bool) -> (Vec<f64>, Matrix, Matrix) {
        let mut sweeps = Sweeps { arch, is_plain, ..Sweeps::new(plan.clone()) };
        let n = plan.n;
        let [q, qd, qdd] =
            [1.0, 2.0, 10.0].map(|size| (0..n).map(|i| size * (1.7 * i as f64).cos()).collect::<Vec<_>>());
        let (mut tau, mut tangent, mut mass) = (vec![0.0; n], Matrix::zeros(n, n), Matrix::zeros(n, n));
        sweeps.inverse_dynamics([&q, &qd, &qdd], &mut tau);
        sweeps.weighted_tangent([&q, &qd, &qdd], [1e-4, 1e-2, 1.0], Tangent::Dense(&mut tangent));
        sweeps.mass_matrix(&q, Tangent::Dense(&mut mass));
        (tau, tangent, mass)
    }

    #[test]
    fn every_instruction_set_gives_the_same_bits_with_sweeps_for_plain_rods_or_for_all() {
        fn check<G: Turning>(plan: &Plan<G>) {
            assert!(plan.is_plain());
            let both = |arch| [true, false].map(|is_plain| results(plan, arch, is_plain));
            let results: Vec<_> = instruction_sets().into_iter().flat_map(both).collect();
            for pair in results.windows(2) {
                assert!(pair[0].0.iter().any(|&force| force != 0.0));
                assert_eq!(pair[0], pair[1]);
            }
        }
        let segment = |modes| Segment {
            modes,
            section: Section::circle([0.02, 0.01]),
            ..Segment::straight(0.7, 0.02, 1e6, 4e5, 1000.0)
        };
        let planar = Rod { tip_mass: 0.1, ..Rod::new(vec![segment([0, 5, 0, 2, 0, 1]); 2]) };
        let spatial = Rod { tip_force: [0.1, 0.2, 0.3], ..Rod::new(vec![segment([2, 3, 4, 1, 1, 1]); 2]) };
        check(&Plan::<Planar<true>>::new(&planar, Plane::ABOUT_Y));
        check(&Plan::<Spatial<true>>::new(&spatial, ()));
    }
}
