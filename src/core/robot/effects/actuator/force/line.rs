//! Straight parts of tendons: forces between two points along the line that joins them. With a fixed
//! direction they are dead loads, which the sweeps handle. The change of direction adds
//! `F D^T (1 - t t^T) D / l` to the tangent, with the relative displacement D of the second end.

use crate::numerics::lie::{Twist, Vector, VectorSpace, Wrench};
use crate::robot::effects::actuator::plan::{End, Line};
use crate::robot::effects::actuator::state::LineState;
use crate::robot::plan::Plan;
use crate::robot::state::Workspace;
use crate::robot::turning::Turning;

/// Straight parts shorter than this, in metres, have no direction and exert no force.
const SHORTEST: f64 = 1e-14;

/// Position and velocity of an end, in space and the frame of the plan, which follows the base.
fn end<G: Turning>(plan: &Plan<G>, work: &Workspace<G>, end: &End<G::Pack>) -> [Vector<f64>; 2] {
    let frame = plan.frame;
    match *end {
        End::InWorld(i) => work.effects.actuation.world_points[i],
        End::On { point, beside, .. } => {
            let state = &work.points[point];
            let beside = G::rotate(&state.rotation, G::vector_of(frame, beside));
            let position = G::in_space(frame, state.position + beside);
            let Twist { angular, linear } = state.velocity;
            let turning = G::axial_in_space(frame, angular).cross(position);
            [position, G::in_space(frame, linear) + turning]
        }
    }
}

/// Converts a direction in the axes of an end to space and the frame of the plan.
fn turned<G: Turning>(
    plan: &Plan<G>,
    work: &Workspace<G>,
    end: &End<G::Pack>,
    v: Vector<f64>,
) -> Vector<f64> {
    match *end {
        End::InWorld(_) => v,
        End::On { point, .. } => {
            G::in_space(plan.frame, G::rotate(&work.points[point].rotation, G::vector_of(plan.frame, v)))
        }
    }
}

/// Evaluates all straight parts, with the motion of all points up to date, and adds their lengths to those of
/// their tendons.
pub(super) fn measure<G: Turning>(plan: &Plan<G>, work: &mut Workspace<G>, q: &[f64]) {
    for (i, line) in plan.effects.actuation.lines.iter().enumerate() {
        let [[from, from_velocity], [to, to_velocity]] = line.ends.each_ref().map(|e| end(plan, work, e));
        let (way, velocity) = (to - from, to_velocity - from_velocity);
        let length = way.dot(way).sqrt();
        let inverse_length = if length > SHORTEST { length.recip() } else { 0.0 };
        let direction = way * inverse_length;
        let rate = direction.dot(velocity);
        let LineState { ratio, angle, mut guide_exits, .. } = work.effects.actuation.lines[i];
        for (e, guide_exit) in line.guide_exits.iter().enumerate() {
            let Some(guide_exit) = guide_exit else { continue };
            let u = guide_exit.changes.iter().fold(guide_exit.start, |u, &(k, change)| u + change * q[k]);
            let inverse = u.dot(u).sqrt().recip();
            guide_exits[e] = (turned(plan, work, &line.ends[e], u * inverse), inverse);
        }
        work.effects.actuation.lines[i] = LineState {
            ends: [from, to],
            direction,
            inverse_length,
            velocity,
            rate,
            ratio,
            angle,
            guide_exits,
        };
        work.effects.actuation.lengths[line.actuator] += length;
        work.effects.actuation.rates[line.actuator] += rate;
    }
}

/// Second time derivative of a straight part's length, with the motion of all points up to date: of `|d|`
/// with the vector d between its ends. Points of bodies accelerate by `a + w' x p + w x (v + w x p)` (see
/// `kernel::acceleration`), points of the world do not.
pub(super) fn acceleration<G: Turning>(plan: &Plan<G>, work: &Workspace<G>, line: usize) -> f64 {
    let gravity = G::in_space(plan.frame, work.surroundings.gravity);
    let of_end = |e: &End<G::Pack>| {
        let &End::On { point, .. } = e else { return Vector::zero() };
        let [position, velocity] = end(plan, work, e);
        let Twist { angular, linear } = work.points[point].acceleration;
        let turning = G::axial_in_space(plan.frame, work.points[point].velocity.angular);
        G::in_space(plan.frame, linear)
            + gravity
            + G::axial_in_space(plan.frame, angular).cross(position)
            + turning.cross(velocity)
    };
    let [from, to] = plan.effects.actuation.lines[line].ends.each_ref().map(of_end);
    let &LineState { direction, inverse_length, velocity, rate, .. } = &work.effects.actuation.lines[line];
    direction.dot(to - from) + (velocity.dot(velocity) - rate * rate) * inverse_length
}

/// Force on an end of a straight part, and its point of attack.
fn force_on<G: Turning>(
    plan: &Plan<G>,
    work: &Workspace<G>,
    pulled: usize,
) -> (Wrench<G, f64>, G::Vector<f64>) {
    let (i, end) = (pulled / 2, pulled % 2);
    let state = &work.effects.actuation.lines[i];
    let force = work.effects.actuation.forces[plan.effects.actuation.lines[i].actuator].value * state.ratio;
    let sign = if end == 0 { 1.0 } else { -1.0 };
    let force = G::vector_of(plan.frame, state.direction * (sign * force));
    let position = G::vector_of(plan.frame, state.ends[end]);
    (Wrench { moment: VectorSpace::zero(), force }, position)
}

/// Adds the forces of all straight parts to those at their points.
pub(super) fn pull<G: Turning>(plan: &Plan<G>, work: &mut Workspace<G>) {
    for (i, line) in plan.effects.actuation.lines.iter().enumerate() {
        for (e, end) in line.ends.iter().enumerate() {
            if let &End::On { point, .. } = end {
                let (wrench, position) = force_on(plan, work, 2 * i + e);
                let needed = work.points[point].force - wrench.at(position);
                work.points[point].force = needed;
            }
        }
    }
}

/// Dead wrenches of straight parts at a point, and their points of attack.
pub(super) fn dead_at<'a, G: Turning>(
    plan: &'a Plan<G>,
    work: &'a Workspace<G>,
    pulled: &'a [usize],
) -> impl Iterator<Item = (Wrench<G, f64>, G::Vector<f64>)> + 'a {
    pulled.iter().map(|&pulled| force_on(plan, work, pulled))
}

/// Derivatives of the relative position of the ends, and of the length rate, with respect to a coordinate
/// that moves an end (sign 1 for the second, -1 for the first), from its twist Psi and `int ad_V S`. With the
/// velocity v of the end, `dv/dq = [Psi, V] + int ad_V S` at the end, plus the change due to its own
/// displacement.
pub(crate) fn changes<G: Turning>(
    plan: &Plan<G>,
    work: &Workspace<G>,
    line: usize,
    end: usize,
    [psi, psi_rate]: [Twist<G, f64>; 2],
) -> (Vector<f64>, f64) {
    let frame = plan.frame;
    let state = &work.effects.actuation.lines[line];
    let &End::On { point, .. } = &plan.effects.actuation.lines[line].ends[end] else {
        return (Vector::zero(), 0.0);
    };
    let position = state.ends[end];
    let velocity = work.points[point].velocity;
    let at = |twist: Twist<G, f64>| {
        G::in_space(frame, twist.linear) + G::axial_in_space(frame, twist.angular).cross(position)
    };
    let sign = if end == 0 { -1.0 } else { 1.0 };
    let moved = at(psi);
    let change =
        at(psi.bracket(velocity) + psi_rate) + G::axial_in_space(frame, velocity.angular).cross(moved);
    let across = moved - state.direction * state.direction.dot(moved);
    let of_rate = state.velocity.dot(across) * state.inverse_length + state.direction.dot(change);
    (moved * sign, sign * of_rate)
}

/// Derivative of the direction of an embedded part that continues at an end, with respect to a coordinate
/// that moves the end, from its twist.
pub(crate) fn turns_at_exits<G: Turning>(
    plan: &Plan<G>,
    work: &Workspace<G>,
    [line, end]: [usize; 2],
    psi: Twist<G, f64>,
) -> Vector<f64> {
    let (direction, _) = work.effects.actuation.lines[line].guide_exits[end];
    G::axial_in_space(plan.frame, psi.angular).cross(direction)
}

/// Adds the derivatives, with respect to strains, of the directions of embedded parts that continue at the
/// ends of a straight part.
pub(crate) fn add_bending_at_exits<G: Turning>(
    plan: &Plan<G>,
    work: &Workspace<G>,
    line: usize,
    turned_by: &mut [[Vector<f64>; 2]],
) {
    let Line { ends, guide_exits, .. } = &plan.effects.actuation.lines[line];
    for (e, guide_exit) in guide_exits.iter().enumerate() {
        let Some(guide_exit) = guide_exit else { continue };
        let (direction, inverse) = work.effects.actuation.lines[line].guide_exits[e];
        for &(k, change) in &guide_exit.changes {
            let change = turned(plan, work, &ends[e], change);
            turned_by[k][e] += (change - direction * direction.dot(change)) * inverse;
        }
    }
}
