//! Accelerations of places.

use super::kinematics::position;
use crate::numerics::lie::{Cross, LANES, Lanes, Twist, Vector};
use crate::robot::plan::Plan;
use crate::robot::plan::point::Place;
use crate::robot::state::surroundings::Surroundings;
use crate::robot::state::{Station, Workspace};
use crate::robot::turning::Turning;

/// Angular acceleration of a place and acceleration of its point, in world axes, with the motion up to date.
///
/// The sweeps compute the acceleration of the body's point at the origin, `A = V'` minus gravity. The
/// velocity of a point p of the body is `v + w x p`, so that its acceleration is `a + w' x p + w x (v + w x
/// p)` (Featherstone 2008, section 2.11).
pub(crate) fn acceleration<G: Turning>(
    plan: &Plan<G>,
    work: &Workspace<G>,
    place: &Place,
) -> [Vector<f64>; 2] {
    let [velocity, acceleration] = motion(plan, work, place);
    let point = position(plan, work, place);
    let of_point = velocity.linear + velocity.angular.cross(point);
    let Surroundings { base, gravity, .. } = &work.surroundings;
    let linear =
        acceleration.linear + *gravity + acceleration.angular.cross(point) + velocity.angular.cross(of_point);
    let turned = |v| base.rotation.apply(v);
    [turned(G::axial_in_space(plan.frame, acceleration.angular)), turned(G::in_space(plan.frame, linear))]
}

/// Velocity, and acceleration minus gravity, at a place, about the origin, with the motion up to date.
fn motion<G: Turning>(plan: &Plan<G>, work: &Workspace<G>, place: &Place) -> [Twist<G, f64>; 2] {
    let piece = &plan.pieces[place.piece];
    let station = if place.weights.is_empty() { piece.joined.end } else { piece.joined.begin };
    let Station { mut velocity, mut acceleration, .. } = work.stations[station];
    for (i, &weight) in place.weights.iter().enumerate() {
        let node = piece.first_pack + i / LANES;
        let at_node = |rate: &Twist<G, G::Pack>| rate.map(|component: &G::Pack| component.lane(i % LANES));
        velocity += at_node(&work.rate[node]) * weight;
        acceleration += at_node(&work.acceleration_rate[node]) * weight;
    }
    [velocity, acceleration]
}
