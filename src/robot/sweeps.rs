//! Sweeps along a rod with their memory, run with the best instruction set of the machine.

use std::sync::Arc;

use super::algebra::tie::Row;
use super::compile;
use super::description::Robot;
use super::kernel::by_length::ByLength;
use super::kernel::kinematics::Pose;
use super::kernel::momentum::Momentum;
use super::kernel::sizes::{Extent, Motions};
use super::kernel::{
    acceleration, by_inertia, by_length, elasticity, energy, inputs, inverse_dynamics, kinematics, lines,
    loops, momentum, section, sizes, tangent, time,
};
use super::plan::Plan;
use super::plan::point::Place;
use super::state::Workspace;
use super::state::tangent::{Tangent, TangentWorkspace};
use super::turning::Turning;
use super::turning::place;
use crate::description::rod::STRAINS;
use crate::description::world::base_motion::Base;
use crate::error::Interrupted;
use crate::model::springs::Cords;
use crate::model::{Energy, Holder, InertiaMatrix, Radius, SectionPlace};
use crate::numerics::lie::{Cross, Sweep, Vector, VectorSpace, Wrench};
use crate::numerics::linalg::Matrix;
use crate::robot::effects::actuator::force as actuation;
use crate::robot::effects::actuator::plan::Law;
use crate::robot::effects::all as effects;
use crate::robot::effects::contact::query::Touching;
use crate::robot::effects::contact::{detection, force as contact, query, tunnelling};
use crate::robot::effects::joint_forces;
use crate::robot::effects::support::force::Held;

/// A rod compiled for one geometry, with its memory.
#[derive(Clone, Debug)]
pub(crate) struct Sweeps<G: Turning> {
    plan: Arc<Plan<G>>,
    work: Workspace<G>,
    tangent: TangentWorkspace<G>,
    zeros: Vec<f64>,
    /// Whether an effect takes energy out.
    dissipates: bool,
}

/// Largest difference of coordinates for which the set of touching surfaces is not recomputed.
const SAME_SHAPE: f64 = 1e-4;

/// Whether two shapes are close enough to share contact detection, which depends only on the shape.
/// Differences within the tolerance of Newton's method do not matter.
fn is_same_shape(known: &[f64], q: &[f64]) -> bool {
    let is_near = |(known, q): (&f64, &f64)| (known - q).abs() <= SAME_SHAPE * (1.0 + q.abs());
    known.len() == q.len() && known.iter().zip(q).all(is_near)
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

impl<G: Turning> Sweeps<G> {
    /// Creates memory and selects the best instruction set for a plan.
    pub(crate) fn new(plan: Plan<G>) -> Self {
        let mut work = Workspace::new(&plan);
        time::tell(&plan, &mut work);
        let (tangent, zeros) = (TangentWorkspace::new(&plan), vec![0.0; plan.n]);
        Self { work, tangent, zeros, dissipates: effects::dissipates(&plan), plan: Arc::new(plan) }
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
        work.acting.clone_from(&from.acting);
        work.inputs.clone_from(&from.inputs);
        work.loops.multipliers.clone_from(&from.loops.multipliers);
        work.loops.slack.clone_from(&from.loops.slack);
        work.loops.world_ends.clone_from(&from.loops.world_ends);
        work.actuation.commands.clone_from(&from.actuation.commands);
        work.actuation.slidings.clone_from(&from.actuation.slidings);
        work.actuation.world_points.clone_from(&from.actuation.world_points);
        work.anchors.clone_from(&from.anchors);
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
        self.plan.pieces.iter().any(|piece| piece.retardation_time > 0.0) || self.dissipates
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

    /// Evaluates everything that varies in time at this time.
    pub(crate) fn set_time(&mut self, t: f64) -> Result<(), Interrupted> {
        if self.plan.varies_in_time && self.work.time != t {
            time::set(&self.plan, &mut self.work, t)?;
        }
        Ok(())
    }

    /// Sets the time with the change of the velocity of the base added to its acceleration.
    pub(crate) fn set_time_in_jump(&mut self, t: f64) -> Result<(), Interrupted> {
        if self.plan.varies_in_time { time::set_in_jump(&self.plan, &mut self.work, t) } else { Ok(()) }
    }

    /// From now on, tables are seen in steps of the size `dt`, as in [`Sight`](crate::description::signal::Sight).
    pub(crate) fn set_steps(&mut self, dt: f64) {
        time::set_steps(&mut self.work, dt);
    }

    /// From now on, what jumps at `t` is as it is after that.
    pub(crate) fn pass_jump(&mut self, t: f64) {
        time::pass_jump(&mut self.work, t);
    }

    /// From now on, loads are those of earlier times by `lag` seconds; false if none varies in time.
    pub(crate) fn lag_loads(&mut self, lag: f64) -> bool {
        let vary = self.plan.loads.iter().any(|load| load.varies_in_time);
        if vary {
            time::lag_loads(&mut self.work, lag);
        }
        vary
    }

    /// Appends place, velocity and acceleration of a moving base, direction by direction.
    pub(crate) fn prescribed(&self, to: &mut Vec<[f64; 3]>) {
        if self.plan.world.motion.is_some() {
            to.extend(self.work.surroundings.base.shifts());
        }
    }

    /// Sets the inputs.
    pub(crate) fn set_inputs(&mut self, inputs: &[f64]) {
        if !inputs.is_empty() {
            time::set_inputs(&self.plan, &mut self.work, inputs);
        }
    }

    /// The time that is set, if a load or a command is not finite at this time; NaN if no time could be set.
    pub(crate) fn time_without_loads(&self) -> Option<f64> {
        let is_finite = |wrench: &Wrench<G, f64>| {
            (wrench.force.dot(wrench.force) + wrench.moment.dot(wrench.moment)).is_finite()
        };
        let is_known = self.work.acting.iter().all(is_finite)
            && self.work.actuation.commands.iter().all(|command| command.is_finite());
        (!is_known).then_some(self.work.time)
    }

    /// The base at the time that is set.
    pub(crate) fn base(&self) -> Base {
        self.work.surroundings.base
    }

    /// Sets the pose of a rod's base without base motion.
    pub(crate) fn place_base(&mut self, base: &Base) {
        time::place(&self.plan, &mut self.work, base);
    }

    /// Place at arc length `x` of a link's rod, by default its tip; the base for a rigid link.
    pub(crate) fn place(&self, link: usize, x: Option<f64>) -> Place {
        place::on_link(&self.plan.pieces, &self.plan.links[link], x)
    }

    pub(crate) fn pose(&mut self, q: &[f64], place: &Place) -> Pose {
        self.update_kinematics(q);
        kinematics::pose(&self.plan, &self.work, q, place)
    }

    /// Jacobian of the pose of a place, 6 x n, in world axes.
    pub(crate) fn jacobian(&mut self, q: &[f64], place: &Place, jacobian: &mut Matrix) {
        self.update_kinematics(q);
        kinematics::jacobian(&self.plan, &self.work, place, jacobian);
    }

    /// What coordinates move in a shape: sections, these bodies, and ends of loops, tendons and contacts. Allocates.
    pub(crate) fn motions(&mut self, q: &[f64], bodies: &[Extent]) -> Motions {
        self.with_zeros(|sweeps, zeros| sweeps.update_motion([q, zeros, zeros]));
        let Self { plan, work, tangent, .. } = self;
        let extents = [&sizes::sections(plan)[..], bodies].concat();
        sizes::motions(plan, work, tangent, &extents)
    }

    /// Angular velocity of a place and velocity of its point, in world axes.
    pub(crate) fn velocity(&mut self, q: &[f64], qd: &[f64], place: &Place) -> [Vector<f64>; 2] {
        self.update_velocities(q, qd);
        kinematics::velocity(&self.plan, &self.work, place)
    }

    /// Angular acceleration of a place and acceleration of its point, in world axes.
    pub(crate) fn acceleration(&mut self, state: [&[f64]; 3], place: &Place) -> [Vector<f64>; 2] {
        self.update_motion(state);
        acceleration::acceleration(&self.plan, &self.work, place)
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
        inputs::tangent(&self.plan, &mut self.work, &mut self.tangent.actuation, tangent);
    }

    /// Places of the nodes of rods.
    pub(crate) fn section_places(&self) -> Vec<SectionPlace> {
        by_inertia::places(&self.plan)
    }

    /// Adds the derivatives of the power in a virtual motion with respect to the inertia of sections. Allocates.
    pub(crate) fn add_power_by_inertia(
        &mut self,
        state: [&[f64]; 3],
        rates: &[f64],
        by_inertia: &mut [InertiaMatrix],
    ) {
        self.update_motion(state);
        let motion = by_inertia::Motion::of(&self.work);
        self.update_velocities(state[0], rates);
        motion.add(&self.plan, &self.work, by_inertia);
    }

    /// Number of segments whose lengths affect only their rods.
    pub(crate) fn free_lengths(&self) -> usize {
        by_length::segments(&self.plan)
    }

    /// Adds the derivatives of the power in a virtual motion with respect to the lengths of segments. Allocates.
    pub(crate) fn add_power_by_length(&mut self, state: [&[f64]; 3], rates: &[f64], by_length: &mut [f64]) {
        let mut tau = vec![0.0; self.plan.n];
        self.inverse_dynamics(state, &mut tau);
        let Self { plan, work, .. } = self;
        let [q, ..] = state;
        plan.instructions.run::<G::Pack, _>(ByLength { plan, work, q, rates, tau: &tau, by_length });
    }

    /// Sets the multipliers of constraints.
    pub(crate) fn set_multipliers(&mut self, multipliers: &[f64]) {
        if self.work.loops.multipliers != multipliers {
            self.work.loops.multipliers.copy_from_slice(multipliers);
            self.work.motion_is_known = false;
        }
    }

    /// Updates everything on which constraints depend in a shape: poses, and lengths of inextensible tendons.
    fn update_constraints(&mut self, q: &[f64]) {
        self.update_kinematics(q);
        // Lengths are evaluated with the motion, at any velocity.
        if !self.plan.loops.lengths.is_empty() && !self.work.motion_is_known {
            self.with_zeros(|sweeps, zeros| sweeps.update_motion([q, zeros, zeros]));
        }
    }

    /// Gaps g(q) of closed loops and inextensible tendons.
    pub(crate) fn gaps(&mut self, q: &[f64], gaps: &mut [f64]) {
        self.update_constraints(q);
        loops::values(&self.plan, &self.work, q, gaps);
    }

    /// Changes the sign of gaps of angles in ties whose ends are turned away from each other, in the shape evaluated last. Returns
    /// the largest [`loops::turned_away`].
    pub(crate) fn away_from_half_turns(&self, gaps: &mut [f64]) -> f64 {
        let mut most = 0.0_f64;
        for tie in &self.plan.loops.ties {
            if let Some(by) = loops::turned_away(&self.plan, &self.work, tie) {
                most = most.max(by);
                let of_tie = gaps[tie.first..].iter_mut().zip(&tie.rows);
                of_tie.filter(|(_, row)| matches!(row, Row::Angle { .. })).for_each(|(gap, _)| *gap = -*gap);
            }
        }
        most
    }

    /// The constraint with the largest gap beside these sizes, this gap, and its size.
    pub(crate) fn widest_gap(&mut self, q: &[f64], sizes: &[f64]) -> Option<(Holder, f64, f64)> {
        if self.plan.loops.held_by.is_empty() {
            return None;
        }
        self.update_constraints(q);
        let mut gaps = std::mem::take(&mut self.work.loops.gaps);
        loops::values(&self.plan, &self.work, q, &mut gaps);
        let mut widest: Option<(Holder, f64, f64)> = None;
        for ((&held, gap), &size) in self.plan.loops.held_by.iter().zip(&gaps).zip(sizes) {
            if gap.is_nan()
                || widest.is_none_or(|(_, widest, of_widest)| gap.abs() * of_widest > widest * size)
            {
                widest = Some((held, gap.abs(), size));
            }
        }
        self.work.loops.gaps = gaps;
        let Self { plan, work, .. } = self;
        let turned = plan.loops.ties.iter().find_map(|tie| {
            let by = loops::turned_away(plan, work, tie)?;
            Some((plan.loops.held_by[tie.first], by, 1.0))
        });
        turned.or(widest)
    }

    /// Excess of the lengths of all inextensible tendons over the commanded lengths, and its rates.
    pub(crate) fn excesses(&mut self, q: &[f64], qd: &[f64]) -> Vec<[f64; 2]> {
        self.update_velocities(q, qd);
        time::find_command_rates(&self.plan, &mut self.work);
        let state = &self.work.actuation;
        let excess =
            |&i: &usize| [state.lengths[i] - state.commands[i], state.rates[i] - state.command_rates[i][0]];
        self.plan.loops.lengths.iter().map(excess).collect()
    }

    /// Whether any joint has stops or any tendon a stiffness.
    pub(crate) fn has_stops(&self) -> bool {
        joint_forces::all(&self.plan).any(|(_, forces)| forces.limits.is_some()) || self.has_cables()
    }

    fn has_cables(&self) -> bool {
        self.plan.actuation.actuators.iter().any(|actuator| actuator.law.is_cable())
    }

    /// By how much joints are beyond their nearest stops, and tendons with a stiffness longer than commanded; negative before
    /// that, in radians or metres.
    pub(crate) fn beyond_stops(&mut self, q: &[f64], beyond: &mut Vec<f64>) {
        beyond.clear();
        beyond.extend(joint_forces::beyond_stops(&self.plan, q));
        if !self.has_cables() {
            return;
        }
        self.with_zeros(|sweeps, zeros| sweeps.update_motion([q, zeros, zeros]));
        let state = &self.work.actuation;
        let cables = self.plan.actuation.actuators.iter().enumerate();
        let cables = cables.filter(|(_, actuator)| actuator.law.is_cable());
        beyond.extend(cables.map(|(i, _)| state.lengths[i] - state.commands[i]));
    }

    /// Which inextensible tendons are slack.
    pub(crate) fn slack(&self) -> &[bool] {
        &self.work.loops.slack
    }

    /// Sets which inextensible tendons are slack.
    pub(crate) fn set_slack(&mut self, slack: &[bool]) {
        self.work.loops.slack.copy_from_slice(slack);
    }

    /// Moment, about the second end of a tie, and force of the first end on the second one for these
    /// multipliers, in world axes.
    pub(crate) fn tie_wrench(&mut self, q: &[f64], tie: usize, multipliers: &[f64]) -> [Vector<f64>; 2] {
        self.update_kinematics(q);
        let [moment, force] = loops::wrench(&self.plan, &self.work, tie, multipliers);
        let base = &self.work.surroundings.base.rotation;
        [base.apply(-moment), base.apply(-force)]
    }

    /// `dg/dt`.
    pub(crate) fn gap_rates(&mut self, q: &[f64], qd: &[f64], rates: &mut [f64]) {
        self.update_velocities(q, qd);
        time::find_command_rates(&self.plan, &mut self.work);
        loops::rates(&self.plan, &self.work, rates);
    }

    /// `d2g/dt2`.
    pub(crate) fn gap_accelerations(&mut self, state: [&[f64]; 3], accelerations: &mut [f64]) {
        self.update_motion(state);
        let Self { plan, work, tangent, .. } = self;
        time::find_command_rates(plan, work);
        if !plan.loops.lengths.is_empty() {
            lines::find(plan, work, &mut tangent.actuation);
        }
        loops::accelerations(plan, work, &mut tangent.actuation, accelerations);
    }

    /// `dg/dq`, rows x n.
    pub(crate) fn gap_jacobian(&mut self, q: &[f64], jacobian: &mut Matrix) {
        self.update_constraints(q);
        let Self { plan, work, tangent, .. } = self;
        loops::find(plan, work, &mut tangent.loops);
        if !plan.loops.lengths.is_empty() {
            lines::find(plan, work, &mut tangent.actuation);
        }
        loops::jacobian(plan, work, &tangent.loops, &mut tangent.actuation, jacobian);
    }

    /// Disables contact forces, or enables them again.
    pub(crate) fn leave_contact(&mut self, is_left: bool) {
        self.work.contact.is_left = is_left;
        self.work.motion_is_known = false;
    }

    /// Surfaces are no stiffer than those that such a force, pair by pair, presses into each other by their thickness; `None` undoes
    /// that. Returns whether any are softer than their own stiffness.
    pub(crate) fn soften_contact(&mut self, forces: Option<&[f64]>) -> bool {
        self.work.motion_is_known = false;
        let pairs = self.plan.contacts.pairs.iter().zip(&mut self.work.contact.stiffest);
        let mut is_softer = false;
        for (p, (pair, stiffest)) in pairs.enumerate() {
            *stiffest = forces.map_or(f64::INFINITY, |forces| pair.yielding_to(forces[p]));
            is_softer |= *stiffest < pair.law.stiffness;
        }
        is_softer
    }

    /// The largest overlap over the thickness of the thinner surface.
    pub(crate) fn deepest_overlap(&mut self, q: &[f64]) -> f64 {
        self.find_touches(q);
        let pairs = &self.plan.contacts.pairs;
        let touches = self.work.contact.touches.iter();
        touches.map(|touch| touch.meeting.overlap / pairs[touch.pair].thickness).fold(0.0, f64::max)
    }

    /// What coordinates move of the surfaces of every pair of contacts, and how many motions belong to each pair. Allocates.
    pub(crate) fn motions_of_contact(&mut self, q: &[f64]) -> (Motions, Vec<usize>) {
        self.with_zeros(|sweeps, zeros| sweeps.update_motion([q, zeros, zeros]));
        sizes::motions_of_contact(&self.plan, &self.work)
    }

    /// What contacts and actuators could do for a unit of each coordinate. Allocates.
    pub(crate) fn work_of_interactions(&mut self, q: &[f64]) -> Vec<f64> {
        self.with_zeros(|sweeps, zeros| sweeps.update_motion([q, zeros, zeros]));
        let Self { plan, work, tangent, .. } = self;
        let mut most = sizes::work_of_contact(plan, work);
        lines::find(plan, work, &mut tangent.actuation);
        for (i, actuator) in plan.actuation.actuators.iter().enumerate() {
            let force = work.actuation.forces[i].value.abs();
            for &k in &actuator.reaches {
                most[k] += force * actuation::reach(plan, work, &tangent.actuation, i, k);
            }
        }
        most
    }

    /// Selects the linearisation of friction.
    pub(crate) fn follow_friction(&mut self, length: Option<f64>) {
        let followed = &mut self.tangent.contact.followed;
        followed.is_new |= length.is_none();
        followed.length = length;
    }

    /// Commands of actuators; NaN until a required time is set.
    pub(crate) fn commands(&self) -> &[f64] {
        &self.work.actuation.commands
    }

    /// Length, rate and force of an actuator, and the gradient of its length.
    pub(crate) fn actuator(&mut self, q: &[f64], qd: &[f64], i: usize) -> ([f64; 3], &[f64]) {
        self.update_velocities(q, qd);
        let Self { plan, work, tangent, .. } = self;
        lines::find(plan, work, &mut tangent.actuation);
        let state = &work.actuation;
        let numbers = [state.lengths[i], state.rates[i], state.forces[i].value];
        (numbers, actuation::gradient(plan, work, &mut tangent.actuation, i))
    }

    /// The tendons of a commanded length without friction, by their actuators.
    pub(crate) fn cords(&self) -> impl Iterator<Item = (usize, f64)> {
        let plan = &self.plan;
        plan.actuation.actuators.iter().enumerate().filter_map(|(i, actuator)| match actuator.law {
            Law::Cable { stiffness, .. } if actuator.friction.is_none() => Some((i, stiffness)),
            Law::Inextensible { .. } => Some((i, f64::INFINITY)),
            _ => None,
        })
    }

    /// These tendons in a shape.
    pub(crate) fn linearise_cords(&mut self, q: &[f64], cords: &mut Cords) {
        self.with_zeros(|sweeps, zeros| sweeps.update_motion([q, zeros, zeros]));
        let Self { plan, work, tangent, .. } = self;
        lines::find(plan, work, &mut tangent.actuation);
        for (row, (i, stiffness)) in self.cords().collect::<Vec<_>>().into_iter().enumerate() {
            let Self { plan, work, tangent, .. } = &mut *self;
            let state = &work.actuation;
            cords.stiffness[row] = stiffness;
            cords.excesses[row] = state.lengths[i] - state.commands[i];
            let ends = plan.actuation.lines.iter().zip(&state.lines).filter(|(line, _)| line.actuator == i);
            let far = ends.flat_map(|(_, line)| line.ends).map(|end| end.dot(end).sqrt());
            cords.spans[row] = state.lengths[i].abs() + state.commands[i].abs() + far.sum::<f64>();
            let gradient = actuation::gradient(plan, work, &mut tangent.actuation, i);
            cords.jacobian.row_mut(row).copy_from_slice(gradient);
            for k in 0..plan.n {
                cords.reach[(row, k)] = actuation::reach(plan, work, &tangent.actuation, i, k);
            }
        }
    }

    /// Replaces tensions of these tendons; `None` undoes that.
    pub(crate) fn hold_cords(&mut self, tensions: Option<&[f64]>) {
        self.work.motion_is_known = false;
        for (row, (i, _)) in self.cords().collect::<Vec<_>>().into_iter().enumerate() {
            self.work.actuation.held[i] = tensions.map(|tensions| tensions[row]);
        }
    }

    /// Generalised forces, 3 x n, of weight and loads if all of them acted along an axis of the base.
    pub(crate) fn turned_loads(&mut self, q: &[f64], forces: &mut Matrix) {
        let frame = self.plan.frame;
        let size = |v: Vector<f64>| v.dot(v).sqrt();
        let (surroundings, acting) = (self.work.surroundings, self.work.acting.clone());
        let motion = (self.work.stations[0].velocity, self.work.stations[0].acceleration);
        let gravity = size(G::in_space(frame, surroundings.gravity));
        let mut tau = [vec![0.0; self.plan.n], vec![0.0; self.plan.n]];
        for axis in [None, Some(0), Some(1), Some(2)] {
            let along = |part: f64| {
                let unit = Vector::from(std::array::from_fn(|k| if Some(k) == axis { 1.0 } else { 0.0 }));
                unit * part
            };
            self.work.motion_is_known = false;
            self.work.surroundings.gravity = G::vector_of(frame, along(gravity));
            self.work.stations[0].acceleration.linear = -self.work.surroundings.gravity;
            for (acting, own) in self.work.acting.iter_mut().zip(&acting) {
                acting.force = G::vector_of(frame, along(size(G::in_space(frame, own.force))));
                acting.moment = G::axial_of(frame, along(size(G::axial_in_space(frame, own.moment))));
            }
            match axis {
                None => self.forces_at_rest(q, &mut tau[0]),
                Some(row) => {
                    self.forces_at_rest(q, &mut tau[1]);
                    for (k, (with, without)) in tau[1].iter().zip(&tau[0]).enumerate() {
                        forces[(row, k)] = with - without;
                    }
                }
            }
        }
        (self.work.surroundings, self.work.acting) = (surroundings, acting);
        (self.work.stations[0].velocity, self.work.stations[0].acceleration) = motion;
        self.work.motion_is_known = false;
    }

    /// The actuator with a force in a straight part that has collapsed.
    pub(crate) fn collapsed(&mut self, q: &[f64]) -> Option<usize> {
        // Any velocities: lengths do not depend on them, but forces may.
        self.update_velocities(q, q);
        self.shortest_line()?;
        self.update_velocities(q, &vec![0.0; q.len()]);
        self.shortest_line().filter(|&actuator| self.work.actuation.forces[actuator].value != 0.0)
    }

    /// The actuator with a straight part shorter than the limit.
    fn shortest_line(&self) -> Option<usize> {
        let actuation = &self.plan.actuation;
        let is_short = |ends: &[Vector<f64>; 2], shortest: f64| {
            let way = ends[1] - ends[0];
            way.dot(way).sqrt() < shortest
        };
        let mut lines = actuation.lines.iter().zip(&self.work.actuation.lines);
        lines
            .find(|(line, state)| line.can_shrink() && is_short(&state.ends, line.shortest))
            .map(|(line, _)| line.actuator)
    }

    pub(crate) fn mass_matrix(&mut self, q: &[f64], mass: Tangent<'_>) {
        self.update_kinematics(q);
        self.differentiate([0.0, 0.0, 1.0], mass);
    }

    pub(crate) fn energy(&mut self, q: &[f64], qd: &[f64]) -> Energy {
        self.update_velocities(q, qd);
        energy::energy(&self.plan, &self.work, q)
    }

    pub(crate) fn momentum(&mut self, q: &[f64], qd: &[f64]) -> Momentum {
        self.update_velocities(q, qd);
        momentum::momentum(&self.plan, &self.work)
    }

    /// Moment, about the place where a link's joint begins, and force transmitted through the joint, in world
    /// axes.
    pub(crate) fn joint_wrench(&mut self, state: [&[f64]; 3], link: usize) -> [Vector<f64>; 2] {
        self.update_motion(state);
        let joined = &self.plan.pieces[self.plan.links[link].pieces.start].joined;
        let Wrench { moment, force } = self.work.through[joined.end];
        let about = moment - self.work.stations[joined.begin].position.cross(force);
        let rotation = &self.work.surroundings.base.rotation;
        let frame = self.plan.frame;
        [G::axial_in_space(frame, about), G::in_space(frame, force)].map(|v| rotation.apply(v))
    }

    /// Strain at a place of a rod.
    pub(crate) fn strain(&self, q: &[f64], place: &Place) -> [f64; STRAINS] {
        section::strain(&self.plan, q, place)
    }

    /// Moment and force through a section, about its point and in its axes, from the balance of everything
    /// beyond.
    pub(crate) fn internal_wrench(&mut self, state: [&[f64]; 3], place: &Place) -> [Vector<f64>; 2] {
        self.update_motion(state);
        let Wrench { moment, force } = section::internal_wrench(&self.plan, &self.work, state[0], place);
        let frame = self.plan.frame;
        [G::axial_in_space(frame, moment), G::in_space(frame, force)]
    }

    /// The same from the law of the material.
    pub(crate) fn material_wrench(&self, q: &[f64], qd: &[f64], place: &Place) -> [Vector<f64>; 2] {
        let [about_x, about_y, about_z, x, y, z] =
            section::material_wrench(&self.plan, &self.work, q, qd, place);
        [Vector { x: about_x, y: about_y, z: about_z }, Vector { x, y, z }]
    }

    pub(crate) fn dissipated_power(&mut self, q: &[f64], qd: &[f64]) -> f64 {
        let power = elasticity::power_of_damping(&self.plan, qd);
        if !self.dissipates {
            return power;
        }
        if !self.plan.contacts.pairs.is_empty() {
            // Usually nothing is near, and the shape is sufficient.
            self.update_kinematics(q);
            detection::see_near(&self.plan, &mut self.work);
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
        for (a, anchor) in self.work.anchors.iter_mut().enumerate() {
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
            .flat_map(|(point, state)| point.anchors.iter().map(move |&anchor| (anchor, state)))
            .map(|(a, state)| (a, work.anchors[a].springs(plan.frame, state)))
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

    /// Stores the approach velocities of surfaces that touch in a motion; false if none do.
    pub(crate) fn note_rates(&mut self, motion: [&[f64]; 3]) -> bool {
        // Forces have just been computed nearby.
        if self.work.motion_is_known && self.work.contact.touches.is_empty() {
            return false;
        }
        self.update_motion(motion);
        query::note_rates(&mut self.work);
        !self.work.contact.touches.is_empty()
    }

    /// Whether an impact is too hard for a step of size `h` that ends in a motion of the same shape.
    pub(crate) fn is_jolted(&mut self, motion: [&[f64]; 3], h: f64) -> bool {
        self.update_motion(motion);
        query::is_jolted(&self.plan, &self.work, h)
    }

    /// The hardest impact in a step that ends in a motion of the same shape.
    pub(crate) fn hardest_impact(&mut self, motion: [&[f64]; 3]) -> Option<query::Hardest> {
        self.update_motion(motion);
        query::hardest_impact(&self.plan, &self.work)
    }

    /// Whether surfaces touch in the state evaluated last.
    pub(crate) fn is_touched(&self) -> bool {
        !self.work.contact.touches.is_empty()
    }

    /// Whether surfaces have touched in any state evaluated since the last call.
    pub(crate) fn take_touched(&mut self) -> bool {
        std::mem::take(&mut self.work.contact.has_touched)
    }

    /// Whether surfaces in the state evaluated last are so close that they may touch in the next one.
    pub(crate) fn may_touch(&self) -> bool {
        contact::may_touch(&self.work.contact)
    }

    /// Stores the positions of surfaces in a shape, from which [`Self::have_passed`] continues.
    pub(crate) fn note_surfaces(&mut self, q: &[f64]) {
        // With a moving base the world moves even if the shape does not.
        let is_noted = self.plan.world.motion.is_none() && is_same_shape(&self.work.contact.noted.of, q);
        if tunnelling::is_possible(&self.plan) && !is_noted {
            self.see_surfaces(q);
            tunnelling::note(&mut self.work);
        }
    }

    /// Whether surfaces have passed through each other on the straight path to a shape, which is then stored.
    pub(crate) fn have_passed(&mut self, q: &[f64], radius: Radius) -> bool {
        if self.work.contact.is_left || !tunnelling::is_possible(&self.plan) {
            return false;
        }
        self.see_surfaces(q);
        let have_passed = tunnelling::has_passed(&self.plan, &mut self.work, radius);
        tunnelling::note(&mut self.work);
        have_passed
    }

    fn see_surfaces(&mut self, q: &[f64]) {
        if !is_same_shape(&self.work.kinematics_of, q) {
            self.update_kinematics(q);
        }
        detection::see(&self.plan, &mut self.work);
    }

    /// A contact whose surfaces overlap by more than a radius, and its overlap.
    pub(crate) fn sunk(&mut self, q: &[f64]) -> Option<(usize, f64)> {
        self.find_touches(q);
        query::sunk(&self.plan, &self.work)
    }

    /// Energy of the overlaps in the shape that was looked at last.
    pub(crate) fn overlap_energy(&self) -> f64 {
        query::overlap_energy(&self.work)
    }

    /// Whether any surfaces overlap.
    pub(crate) fn overlaps(&mut self, q: &[f64]) -> bool {
        self.find_touches(q);
        self.is_touched()
    }

    /// Finds what touches in a shape, at any velocities.
    fn find_touches(&mut self, q: &[f64]) {
        if !self.work.motion_is_known || !is_same_shape(&self.work.kinematics_of, q) {
            self.with_zeros(|sweeps, zeros| sweeps.update_motion([q, zeros, zeros]));
        }
    }

    /// Contact points in a state.
    pub(crate) fn touches(&mut self, q: &[f64], qd: &[f64]) -> Vec<Touching> {
        self.update_velocities(q, qd);
        query::told(&self.plan, &self.work).collect()
    }

    /// Moment and force that the base exerts on the rod, in world axes.
    pub(crate) fn base_wrench(&mut self, state: [&[f64]; 3]) -> [Vector<f64>; 2] {
        self.update_motion(state);
        let Wrench { moment, force } = self.work.carried[0];
        let rotation = &self.work.surroundings.base.rotation;
        let frame = self.plan.frame;
        [G::axial_in_space(frame, moment), G::in_space(frame, force)].map(|v| rotation.apply(v))
    }

    /// Position of a place, or of an offset from it, in the frame of the base.
    pub(crate) fn beside(&mut self, q: &[f64], place: &Place, offset: Option<Vector<f64>>) -> Vector<f64> {
        let position = self.position(q, place);
        let Some(mut offset) = offset else { return position };
        if let Some(beside) = place.beside {
            offset = beside.orientation.rotation().apply(offset);
        }
        let piece = &self.plan.pieces[place.piece];
        let rotation = place::rotation_at(piece, &self.work, q, place);
        let offset = G::rotate(&rotation, G::vector_of(self.plan.frame, offset));
        position + G::in_space(self.plan.frame, offset)
    }

    /// Position of a place in the frame of the base.
    pub(crate) fn position(&mut self, q: &[f64], place: &Place) -> Vector<f64> {
        self.update_kinematics(q);
        G::in_space(self.plan.frame, kinematics::position(&self.plan, &self.work, place))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::description::rod::{Section, Segment};
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
