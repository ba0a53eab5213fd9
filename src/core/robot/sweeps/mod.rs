//! Sweeps along a rod with their memory, run with the best instruction set of the machine.

mod actuators;
mod constraints;
mod contacts;
mod instants;
mod places;
mod sections;

pub(crate) use constraints::WidestGap;

use std::sync::Arc;

use crate::model::Energy;
use crate::numerics::lie::{Sweep, Twist, Vector, Wrench};
use crate::numerics::linalg::Matrix;
use crate::robot::compile;
use crate::robot::description::Robot;
use crate::robot::effects;
use crate::robot::effects::contact::detection;
use crate::robot::effects::support::force::Held;
use crate::robot::kernel::momentum::Momentum;
use crate::robot::kernel::{
    elasticity, energy, inputs, inverse_dynamics, kinematics, lone_rod, momentum, tangent, time,
};
use crate::robot::plan::Plan;
use crate::robot::state::Workspace;
use crate::robot::state::tangent::{Tangent, TangentWorkspace};
use crate::robot::turning::Turning;

/// A rod compiled for one geometry, with its memory.
#[derive(Clone, Debug)]
pub(crate) struct Sweeps<G: Turning> {
    plan: Arc<Plan<G>>,
    /// The plan before [`Self::decide`] fixed forces.
    undecided: Option<Arc<Plan<G>>>,
    work: Workspace<G>,
    tangent: TangentWorkspace<G>,
    zeros: Vec<f64>,
    /// Whether an effect dissipates energy.
    dissipates: bool,
    /// Whether this is a [`lone_rod`].
    is_lone_rod: bool,
}

struct Motion<'a, G: Turning> {
    plan: &'a Plan<G>,
    work: &'a mut Workspace<G>,
    state: [&'a [f64]; 3],
}

impl<G: Turning> Sweep for Motion<'_, G> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let [q, qd, qdd] = self.state;
        inverse_dynamics::update(self.plan, self.work, q, qd, qdd);
    }
}

struct Projection<'a, G: Turning> {
    plan: &'a Plan<G>,
    work: &'a mut Workspace<G>,
    q: &'a [f64],
    qd: &'a [f64],
    tau: &'a mut [f64],
}

impl<G: Turning> Sweep for Projection<'_, G> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        inverse_dynamics::project(self.plan, self.work, self.q, self.qd, self.tau);
    }
}

struct WeightedTangent<'a, G: Turning> {
    plan: &'a Plan<G>,
    work: &'a Workspace<G>,
    memory: &'a mut TangentWorkspace<G>,
    weights: [f64; 3],
    tangent: Tangent<'a>,
}

impl<G: Turning> Sweep for WeightedTangent<'_, G> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Self { plan, work, memory, weights, tangent } = self;
        tangent::weighted_tangent(plan, work, memory, weights, tangent);
    }
}

struct ForcesAndMass<'a, G: Turning> {
    plan: &'a Plan<G>,
    work: &'a Workspace<G>,
    memory: &'a mut TangentWorkspace<G>,
    state: [&'a [f64]; 2],
    tau: &'a mut [f64],
    mass: &'a mut Matrix,
}

impl<G: Turning> Sweep for ForcesAndMass<'_, G> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Self { plan, work, memory, state, tau, mass } = self;
        lone_rod::forces_and_mass(plan, work, memory, state, tau, mass);
    }
}

impl<G: Turning> Sweeps<G> {
    /// Creates memory and selects the best instruction set for a plan.
    pub(crate) fn new(plan: Plan<G>) -> Self {
        let mut work = Workspace::new(&plan);
        time::set_constant_commands(&plan, &mut work);
        let (tangent, zeros) = (TangentWorkspace::new(&plan), vec![0.0; plan.n]);
        let (dissipates, is_lone_rod) = (effects::dissipates(&plan), lone_rod::is_lone(&plan));
        Self { work, tangent, zeros, dissipates, is_lone_rod, plan: Arc::new(plan), undecided: None }
    }

    /// Sweeps for the same robot with one piece per link, including links that are otherwise merged.
    pub(crate) fn taken_apart(&self, robot: &Robot) -> Self {
        Self::new(compile::plan_of_every_link(robot, self.plan.frame))
    }

    /// Copies the time of other sweeps of this robot, and everything that depends on it.
    pub(crate) fn take_time(&mut self, other: &Self) {
        let (work, from) = (&mut self.work, &other.work);
        work.stations[0] = from.stations[0];
        (work.time, work.surroundings) = (from.time, from.surroundings);
        work.effects.acting.clone_from(&from.effects.acting);
        work.inputs.clone_from(&from.inputs);
        work.effects.loops.multipliers.clone_from(&from.effects.loops.multipliers);
        work.effects.loops.slack.clone_from(&from.effects.loops.slack);
        work.effects.loops.world_ends.clone_from(&from.effects.loops.world_ends);
        work.effects.actuation.commands.clone_from(&from.effects.actuation.commands);
        work.effects.actuation.slidings.clone_from(&from.effects.actuation.slidings);
        work.effects.actuation.world_points.clone_from(&from.effects.actuation.world_points);
        work.effects.anchors.clone_from(&from.effects.anchors);
        work.forget();
    }

    /// Sweeps for another robot in the same frame.
    pub(crate) fn with_robot(&self, robot: &Robot) -> Self {
        Self::new(compile::plan(robot, self.plan.frame))
    }

    pub(crate) fn plan(&self) -> &Plan<G> {
        &self.plan
    }

    /// Whether the motion dissipates energy.
    pub(crate) fn is_damped(&self) -> bool {
        self.has_retardation() || self.dissipates
    }

    pub(crate) fn has_retardation(&self) -> bool {
        self.plan.pieces.iter().any(|piece| piece.retardation_time > 0.0)
    }

    /// Whether forces other than damping depend on velocities, because of the base motion or of an effect.
    pub(crate) fn has_velocity_forces(&self) -> bool {
        self.plan.world.motion.is_some() || effects::depends_on_velocity(&self.plan)
    }

    /// Whether the base moves, or forces without a potential act.
    pub(crate) fn is_driven(&self) -> bool {
        self.plan.world.motion.is_some() || effects::drives(&self.plan)
    }

    fn update_kinematics(&mut self, q: &[f64]) {
        let Self { plan, work, .. } = self;
        kinematics::run(plan, work, q);
    }

    fn update_motion(&mut self, state: [&[f64]; 3]) {
        self.update_kinematics(state[0]);
        let Self { plan, work, .. } = self;
        plan.instructions.run::<G::Pack, _>(Motion { plan, work, state });
    }

    fn project(&mut self, q: &[f64], qd: &[f64], tau: &mut [f64]) {
        let Self { plan, work, .. } = self;
        plan.instructions.run::<G::Pack, _>(Projection { plan, work, q, qd, tau });
    }

    fn differentiate(&mut self, weights: [f64; 3], tangent: Tangent<'_>) {
        let Self { plan, work, tangent: memory, .. } = self;
        plan.instructions.run::<G::Pack, _>(WeightedTangent { plan, work, memory, weights, tangent });
    }

    /// Calls with a vector of n zeros.
    fn with_zeros<T>(&mut self, f: impl FnOnce(&mut Self, &[f64]) -> T) -> T {
        let zeros = std::mem::take(&mut self.zeros);
        let result = f(self, &zeros);
        self.zeros = zeros;
        result
    }

    /// Updates the motion of a state without accelerations.
    fn update_velocities(&mut self, q: &[f64], qd: &[f64]) {
        self.with_zeros(|sweeps, zeros| sweeps.update_motion([q, qd, zeros]));
    }

    pub(crate) fn inverse_dynamics(&mut self, state: [&[f64]; 3], tau: &mut [f64]) {
        self.update_motion(state);
        let [q, qd, _] = state;
        self.project(q, qd, tau);
    }

    pub(crate) fn weighted_tangent(&mut self, state: [&[f64]; 3], weights: [f64; 3], tangent: Tangent<'_>) {
        self.update_motion(state);
        self.differentiate(weights, tangent);
    }

    /// Derivative with respect to the inputs, n x m.
    pub(crate) fn input_tangent(&mut self, state: [&[f64]; 3], tangent: &mut Matrix) {
        self.update_motion(state);
        inputs::tangent(&self.plan, &mut self.work, &mut self.tangent.effects.actuation, tangent);
    }

    /// Generalised forces, 3 x n, of weight and loads if all of them acted along an axis of the base, and magnitudes of the constraint
    /// wrenches of joints ([`turned_loads`](crate::model::Elastic::turned_loads)).
    pub(crate) fn turned_loads(&mut self, q: &[f64], forces: &mut Matrix, constraint_loads: &mut [f64]) {
        let frame = self.plan.frame;
        let size = |v: Vector<f64>| v.dot(v).sqrt();
        let (surroundings, acting) = (self.work.surroundings, self.work.effects.acting.clone());
        let motion = (self.work.stations[0].velocity, self.work.stations[0].acceleration);
        let gravity = size(G::in_space(frame, surroundings.gravity));
        let mut tau = [vec![0.0; self.plan.n], vec![0.0; self.plan.n]];
        let mut without = Vec::new();
        for axis in [None, Some(0), Some(1), Some(2)] {
            let along = |part: f64| {
                let unit = Vector::from(std::array::from_fn(|k| if Some(k) == axis { 1.0 } else { 0.0 }));
                unit * part
            };
            self.work.motion_is_known = false;
            self.work.surroundings.gravity = G::vector_of(frame, along(gravity));
            self.work.stations[0].acceleration.linear = -self.work.surroundings.gravity;
            for (acting, own) in self.work.effects.acting.iter_mut().zip(&acting) {
                acting.force = G::vector_of(frame, along(size(G::in_space(frame, own.force))));
                acting.moment = G::axial_of(frame, along(size(G::axial_in_space(frame, own.moment))));
            }
            match axis {
                None => {
                    self.forces_at_rest(q, &mut tau[0]);
                    without.clone_from(&self.work.through);
                }
                Some(row) => {
                    self.forces_at_rest(q, &mut tau[1]);
                    for (k, (with, without)) in tau[1].iter().zip(&tau[0]).enumerate() {
                        forces[(row, k)] = with - without;
                    }
                    self.add_constraint_loads(&without, constraint_loads);
                }
            }
        }
        (self.work.surroundings, self.work.effects.acting) = (surroundings, acting);
        (self.work.stations[0].velocity, self.work.stations[0].acceleration) = motion;
        self.work.motion_is_known = false;
    }

    /// Adds magnitudes of products of the twists of joints and their constraint wrenches, less the given wrenches.
    fn add_constraint_loads(&self, without: &[Wrench<G, f64>], forces: &mut [f64]) {
        let (plan, work) = (&*self.plan, &self.work);
        let size = |v: Vector<f64>| v.dot(v).sqrt();
        let linear = |v| size(G::in_space(plan.frame, v));
        let angular = |v| size(G::axial_in_space(plan.frame, v));
        for piece in plan.pieces.iter().filter(|piece| piece.is_joint) {
            let wrench = work.through[piece.joined.end] - without[piece.joined.end];
            let (moment, force) = (angular(wrench.moment), linear(wrench.force));
            if let Some(hinge) = &piece.hinge {
                let twist = work.hinges[hinge.index];
                forces[piece.first] += angular(twist.angular) * moment + linear(twist.linear) * force;
                continue;
            }
            // A spherical joint turns about a single point.
            let mut place = Twist::<G, G::Pack>::zero();
            for (position, weight) in work.position[piece.node_packs()].iter().zip(&piece.weights) {
                place.linear += *position * *weight;
            }
            let load = moment + linear(place.sum().linear) * force;
            forces[piece.coordinates()].iter_mut().for_each(|own| *own += load);
        }
    }

    pub(crate) fn mass_matrix(&mut self, q: &[f64], mass: Tangent<'_>) {
        self.update_kinematics(q);
        self.differentiate([0.0, 0.0, 1.0], mass);
    }

    pub(crate) fn is_lone_rod(&self) -> bool {
        self.is_lone_rod
    }

    /// `tau(q, qd, 0)` and the mass matrix of a [`lone_rod`].
    pub(crate) fn forces_and_mass(&mut self, state: [&[f64]; 2], tau: &mut [f64], mass: &mut Matrix) {
        self.update_kinematics(state[0]);
        let Self { plan, work, tangent: memory, .. } = self;
        plan.instructions.run::<G::Pack, _>(ForcesAndMass { plan, work, memory, state, tau, mass });
    }

    pub(crate) fn energy(&mut self, q: &[f64], qd: &[f64]) -> Energy {
        self.update_velocities(q, qd);
        energy::energy(&self.plan, &self.work, q)
    }

    pub(crate) fn momentum(&mut self, q: &[f64], qd: &[f64]) -> Momentum {
        self.update_velocities(q, qd);
        momentum::momentum(&self.plan, &self.work)
    }

    pub(crate) fn dissipated_power(&mut self, q: &[f64], qd: &[f64]) -> f64 {
        let power = elasticity::power_of_damping(&self.plan, qd);
        if !self.dissipates {
            return power;
        }
        if !self.plan.effects.contacts.pairs.is_empty() {
            // Usually nothing is near, and the shape is sufficient.
            if !self.has_left_contact() {
                self.update_kinematics(q);
                let contact = &self.work.effects.contact;
                if contact.touches.is_empty() && !detection::is_known(&self.plan, contact, q) {
                    detection::update_candidates(&self.plan, &mut self.work);
                }
            }
            if !effects::may_dissipate(&self.plan, &self.work) {
                return power;
            }
        }
        self.update_velocities(q, qd);
        power + effects::dissipated_power(&self.plan, &self.work)
    }

    /// Replaces moments and forces of the supports' springs (six numbers per support) by these values; `None`
    /// undoes that.
    pub(crate) fn hold_springs(&mut self, forces: Option<&[f64]>) {
        self.work.motion_is_known = false;
        for (a, anchor) in self.work.effects.anchors.iter_mut().enumerate() {
            anchor.hold(forces.map(|forces| {
                [0, 3].map(|part| Vector::from(std::array::from_fn(|i| forces[6 * a + part + i])))
            }));
        }
    }

    /// Springs of the supports, in order.
    pub(crate) fn springs(&mut self, q: &[f64]) -> Vec<Held> {
        self.update_kinematics(q);
        let (plan, work) = (&*self.plan, &self.work);
        let points = plan.points.iter().zip(&work.points);
        let mut found: Vec<_> = points
            .flat_map(|(point, state)| point.effects.anchors.iter().map(move |&anchor| (anchor, state)))
            .map(|(a, state)| (a, work.effects.anchors[a].springs(plan.frame, state)))
            .collect();
        found.sort_by_key(|(a, _)| *a);
        found.into_iter().map(|(_, springs)| springs).collect()
    }

    /// `tau(q, 0, 0)`.
    pub(crate) fn forces_at_rest(&mut self, q: &[f64], tau: &mut [f64]) {
        self.with_zeros(|sweeps, zeros| sweeps.inverse_dynamics([q, zeros, zeros], tau));
    }

    /// Derivative of the forces at rest.
    pub(crate) fn tangent_at_rest(&mut self, q: &[f64], tangent: Tangent<'_>) {
        self.with_zeros(|sweeps, zeros| sweeps.weighted_tangent([q, zeros, zeros], [1.0, 0.0, 0.0], tangent));
    }

    pub(crate) fn supplied_power(&mut self, state: [&[f64]; 3]) -> f64 {
        self.update_motion(state);
        energy::supplied_power(&self.plan, &self.work)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::description::rod::{Profile, Section, Segment, Shape};
    use crate::numerics::lie::{Instructions, Planar, Plane, Spatial};
    use crate::robot::description::{Robot, Rod};
    use crate::robot::effects::fluid::Fluid;

    /// A fixed state.
    fn state(n: usize) -> [Vec<f64>; 3] {
        [1.0, 2.0, 10.0].map(|size| (0..n).map(|i| size * (1.7 * i as f64).cos()).collect())
    }

    /// Forces, tangent and mass matrix.
    fn results<G: Turning>(plan: &Plan<G>) -> (Vec<f64>, Matrix, Matrix) {
        let mut sweeps = Sweeps::new(plan.clone());
        let n = plan.n;
        let [q, qd, qdd] = state(n);
        let (mut tau, mut tangent, mut mass) = (vec![0.0; n], Matrix::zeros(n, n), Matrix::zeros(n, n));
        sweeps.inverse_dynamics([&q, &qd, &qdd], &mut tau);
        sweeps.weighted_tangent([&q, &qd, &qdd], [1e-4, 1e-2, 1.0], Tangent::Dense(&mut tangent));
        sweeps.mass_matrix(&q, Tangent::Dense(&mut mass));
        (tau, tangent, mass)
    }

    /// The same from kernels called directly, with the baseline instruction set.
    fn portable_results<G: Turning>(plan: &Plan<G>) -> (Vec<f64>, Matrix, Matrix) {
        let (mut work, mut memory) = (Workspace::new(plan), TangentWorkspace::new(plan));
        let n = plan.n;
        let [q, qd, qdd] = state(n);
        let (mut tau, mut tangent, mut mass) = (vec![0.0; n], Matrix::zeros(n, n), Matrix::zeros(n, n));
        kinematics::update(plan, &mut work, &q);
        inverse_dynamics::update(plan, &mut work, &q, &qd, &qdd);
        inverse_dynamics::project(plan, &mut work, &q, &qd, &mut tau);
        let to = Tangent::Dense(&mut tangent);
        tangent::weighted_tangent(plan, &work, &mut memory, [1e-4, 1e-2, 1.0], to);
        tangent::weighted_tangent(plan, &work, &mut memory, [0.0, 0.0, 1.0], Tangent::Dense(&mut mass));
        (tau, tangent, mass)
    }

    #[test]
    fn a_rod_alone_has_the_forces_and_the_mass_of_every_robot() {
        fn check<G: Turning>(plan: Plan<G>) {
            let n = plan.n;
            let mut sweeps = Sweeps::new(plan);
            assert!(sweeps.is_lone_rod());
            let [q, qd, _] = state(n);
            let (zeros, mut tau, mut mass) = (vec![0.0; n], vec![0.0; n], Matrix::zeros(n, n));
            sweeps.inverse_dynamics([&q, &qd, &zeros], &mut tau);
            sweeps.mass_matrix(&q, Tangent::Dense(&mut mass));
            let (mut own_tau, mut own_mass) = (vec![0.0; n], Matrix::zeros(n, n));
            sweeps.forces_and_mass([&q, &qd], &mut own_tau, &mut own_mass);
            let largest = tau.iter().fold(0.0_f64, |largest, x| largest.max(x.abs()));
            for (own, tau) in own_tau.iter().zip(&tau) {
                assert!((own - tau).abs() <= 1e-13 * largest, "{own_tau:?} {tau:?}");
            }
            assert!((own_mass - &mass).amax() <= 1e-14 * mass.amax());
        }
        let segment = |modes, section| Segment {
            modes,
            section,
            retardation_time: 0.1,
            ..Segment::straight(0.7, 0.02, 1e6, 4e5, 1000.0)
        };
        let rod = |modes, section| Robot::from(&Rod::new(vec![segment(modes, section)]));
        let size = |size: f64| Profile::linear([[size]; 2]);
        let (round, flat) = (
            Section::circle([0.02, 0.01]),
            Section::Shape(Shape::Rectangle { width: size(0.02), height: size(0.01) }),
        );
        let planar = rod([0, 5, 0, 2, 0, 1], round.clone());
        check(compile::plan::<Planar<true>>(&planar, Plane::ABOUT_Y));
        for section in [round, flat] {
            check(compile::plan::<Spatial<true>>(&rod([2, 3, 4, 1, 1, 1], section), ()));
        }
    }

    #[test]
    fn wide_instructions_give_the_bits_of_portable_ones() {
        fn check<G: Turning>(plan: &Plan<G>) {
            let results = results(plan);
            assert!(results.0.iter().any(|&force| force != 0.0));
            assert_eq!(results, portable_results(plan));
        }
        if !Instructions::of_machine().has_fused() {
            return;
        }
        let segment = |modes| Segment {
            modes,
            section: Section::circle([0.02, 0.01]),
            ..Segment::straight(0.7, 0.02, 1e6, 4e5, 1000.0)
        };
        let planar = Rod { tip_mass: 0.1, ..Rod::new(vec![segment([0, 5, 0, 2, 0, 1]); 2]) };
        let spatial = Rod { tip_force: [0.1, 0.2, 0.3], ..Rod::new(vec![segment([2, 3, 4, 1, 1, 1]); 2]) };
        let fluid = Fluid { viscous_drag: [0.1; 2], velocity: [1.0; 3], ..Fluid::ideal(900.0) };
        let immersed = Rod { fluid: Some(fluid), ..spatial.clone() };
        let [planar, spatial, immersed] = [&planar, &spatial, &immersed].map(Robot::from);
        check(&compile::plan::<Planar<true>>(&planar, Plane::ABOUT_Y));
        check(&compile::plan::<Spatial<true>>(&spatial, ()));
        check(&compile::plan::<Spatial<true>>(&immersed, ()));
        check(&compile::plan::<Spatial<true>>(&spatial, ()).with_nothing_skipped());
    }
}
