//! Forces on joint coordinates: spring, damping, friction, stops and armature.
//!
//! These are forces on coordinates rather than wrenches at places: the hinge evaluates them and their
//! derivatives.

use crate::description::joint::{Joint, JointForces};
use crate::error::Number;
use crate::model::{Energy, REACHED};
use crate::robot::description::{Link, Robot};
use crate::robot::effects::kinds::{
    Dissipation, NoCoordinateForce, NoSupply, NoVelocityDependence, NotAlongRods, NotAtPoints, StoredEnergy,
};
use crate::robot::plan::Plan;
use crate::robot::state::Workspace;
use crate::robot::turning::Turning;

/// Force required for a motion (q, qd, qdd) of the coordinate.
#[inline(always)]
pub(crate) fn act(forces: &JointForces, [q, qd, qdd]: [f64; 3]) -> f64 {
    at_rest(forces, q) + dissipative(forces, q, qd) + forces.armature * qdd
}

/// Conservative part of the force: of the spring and the stops.
#[inline(always)]
pub(crate) fn at_rest(forces: &JointForces, q: f64) -> f64 {
    forces.stiffness * (q - forces.rest) + forces.limit_stiffness * beyond(forces, q)
}

/// Derivative of [`at_rest`].
#[inline(always)]
pub(crate) fn stiffness(forces: &JointForces, q: f64) -> f64 {
    let is_beyond = beyond(forces, q) != 0.0;
    forces.stiffness + if is_beyond { forces.limit_stiffness } else { 0.0 }
}

/// Dissipative part of the force.
#[inline(always)]
fn dissipative(forces: &JointForces, q: f64, qd: f64) -> f64 {
    let JointForces { damping, friction, friction_velocity, .. } = *forces;
    damping * qd + friction * qd / qd.hypot(friction_velocity) + of_stop(forces, q, qd)
}

/// Signed distance of the coordinate beyond a limit.
#[inline(always)]
fn beyond(forces: &JointForces, q: f64) -> f64 {
    let Some([lower, upper]) = forces.limits else { return 0.0 };
    (q - upper).max(0.0) + (q - lower).min(0.0)
}

/// Distances of coordinates beyond their nearest stops, negative before them, in radians or in units of `length`.
pub(crate) fn beyond_stops<G: Turning>(plan: &Plan<G>, q: &[f64], length: f64) -> impl Iterator<Item = f64> {
    plan.pieces.iter().filter_map(move |piece| {
        let (k, hinge) = (piece.first, piece.hinge.as_ref()?);
        let [lower, upper] = hinge.forces.as_ref()?.limits?;
        let unit = if hinge.turns { 1.0 } else { length };
        Some((q[k] - upper).max(lower - q[k]) / unit)
    })
}

/// Coordinates whose stops only just touch ([`REACHED`]); `sizes` are typical coordinates.
pub(crate) fn reached_stops<G: Turning>(
    plan: &Plan<G>,
    q: &[f64],
    sizes: &[f64],
) -> impl Iterator<Item = usize> {
    all(plan).filter_map(move |(k, forces)| {
        let beyond = beyond(forces, q[k]).abs();
        (beyond > 0.0 && beyond <= REACHED * sizes[k].max(q[k].abs())).then_some(k)
    })
}

/// A stop that acts.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ActiveStop {
    /// Index of the coordinate.
    coordinate: usize,
    /// The limit, and the distance of the coordinate beyond it.
    limit: f64,
    beyond: f64,
    /// Spring force of the stop.
    force: f64,
}

/// The stop with the largest force in a shape.
pub(crate) fn most_loaded_stop<G: Turning>(plan: &Plan<G>, q: &[f64]) -> Option<ActiveStop> {
    let active_stops = all(plan).filter_map(|(coordinate, forces)| {
        let beyond = beyond(forces, q[coordinate]);
        let force = forces.limit_stiffness * beyond.abs();
        (beyond != 0.0).then_some(ActiveStop {
            coordinate,
            limit: q[coordinate] - beyond,
            beyond: beyond.abs(),
            force,
        })
    });
    active_stops.max_by(|a, b| a.force.total_cmp(&b.force))
}

/// A sentence about a stop at which a run or a search has failed, or that it would reach next.
pub(crate) fn advice(robot: &Robot, stop: ActiveStop, is_ahead: bool) -> String {
    let ActiveStop { coordinate, limit, beyond, force } = stop;
    let mut next = 0;
    let joined = robot.links.iter().find(|link| {
        let first = next;
        next += link.joint.coordinates().len() + link.coordinates() - link.joint_coordinates().len();
        (first..next).contains(&coordinate)
    });
    let Some(Link { name, joint, .. }) = joined else { return String::new() };
    let [unit, of_force] = if matches!(joint, Joint::Prismatic { .. }) { ["m", "N"] } else { ["rad", "N m"] };
    if is_ahead {
        return format!(
            " The joint of \"{name}\" reaches its stop at {} {unit} in the next step.",
            Number(limit)
        );
    }
    format!(
        " The joint of \"{name}\" is {beyond:.1e} {unit} beyond its stop at {} {unit}, which presses with {force:.1e} {of_force}: if that \
         holds the run, take less `limit_stiffness`, or a `dt` that is shorter than the impact.",
        Number(limit),
    )
}

/// Removes the stops of a coordinate.
pub(crate) fn remove_stops<G: Turning>(plan: &mut Plan<G>, k: usize) {
    let of_coordinate = plan.pieces.iter_mut().filter(|piece| piece.first == k);
    let hinges = of_coordinate.filter_map(|piece| piece.hinge.as_mut());
    hinges.filter_map(|hinge| hinge.forces.as_mut()).for_each(|forces| forces.limits = None);
}

/// Contribution of a stop's dissipation, limited such that the stop never pulls.
#[inline(always)]
fn of_stop(forces: &JointForces, q: f64, qd: f64) -> f64 {
    let beyond = beyond(forces, q);
    let rate = forces.limit_dissipation * if beyond < 0.0 { -qd } else { qd };
    forces.limit_stiffness * beyond * rate.max(-1.0)
}

/// `w_q d/dq + w_v d/dqd + w_a d/dqdd` of [`act`].
#[inline(always)]
pub(crate) fn tangent(forces: &JointForces, [q, qd]: [f64; 2], [w_q, w_v, w_a]: [f64; 3]) -> f64 {
    let JointForces { damping, friction, friction_velocity, limit_stiffness, limit_dissipation, .. } =
        *forces;
    let beyond = beyond(forces, q);
    let side = if beyond < 0.0 { -1.0 } else { 1.0 };
    let rate = limit_dissipation * side * qd;
    let size = qd.hypot(friction_velocity);
    let mut of_velocity = damping + friction * friction_velocity * friction_velocity / (size * size * size);
    let mut of_place = stiffness(forces, q);
    if beyond != 0.0 {
        of_place += limit_stiffness * rate.max(-1.0);
        if rate > -1.0 {
            of_velocity += limit_stiffness * beyond * limit_dissipation * side;
        }
    }
    w_q * of_place + w_v * of_velocity + w_a * forces.armature
}

/// Hinges with forces, by their coordinates.
pub(crate) fn all<G: Turning>(plan: &Plan<G>) -> impl Iterator<Item = (usize, &JointForces)> {
    let hinges = plan.pieces.iter().filter_map(|piece| Some((piece.first, piece.hinge.as_ref()?)));
    hinges.filter_map(|(k, hinge)| Some((k, hinge.forces.as_ref()?)))
}

/// Forces on all joints.
pub(crate) struct OnJoints;

impl<G: Turning> StoredEnergy<G> for OnJoints {
    fn add_energy(plan: &Plan<G>, work: &Workspace<G>, energy: &mut Energy) {
        for (k, forces) in all(plan) {
            let (q, qd) = (work.motion_of[k], work.motion_of[plan.n + k]);
            let (turn, beyond) = (q - forces.rest, beyond(forces, q));
            energy.elastic +=
                0.5 * (forces.stiffness * turn * turn + forces.limit_stiffness * beyond * beyond);
            energy.kinetic += 0.5 * forces.armature * qd * qd;
        }
    }
}

impl<G: Turning> Dissipation<G> for OnJoints {
    fn dissipates(plan: &Plan<G>) -> bool {
        let dissipates = |forces: &JointForces| {
            let of_stops = forces.limit_stiffness * forces.limit_dissipation;
            [forces.damping, forces.friction, of_stops].into_iter().any(|x| x > 0.0)
        };
        all(plan).any(|(_, forces)| dissipates(forces))
    }

    fn dissipated_power(plan: &Plan<G>, work: &Workspace<G>) -> f64 {
        let power = |(k, forces): (usize, &JointForces)| {
            let (q, qd) = (work.motion_of[k], work.motion_of[plan.n + k]);
            dissipative(forces, q, qd) * qd
        };
        all(plan).map(power).sum()
    }
}

impl NotAlongRods for OnJoints {}
impl NotAtPoints for OnJoints {}
impl NoCoordinateForce for OnJoints {}
impl NoSupply for OnJoints {}
impl NoVelocityDependence for OnJoints {}
