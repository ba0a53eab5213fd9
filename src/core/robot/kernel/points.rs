//! Concentrated effects at places of a rod: forces, moments, rigid bodies, springs to the world.
//!
//! A place X inside a piece has the weights u_l of the integral up to it: it moves by `Psi(X) = sum_l u_l
//! S_l`. A wrench W at X has the generalised forces `Psi_j(X) . W = sum_l w_l S_j,l . (u_l / w_l) W` with the
//! quadrature weights w_l: node l carries the share u_l / w_l of it. Therefore the piece need not be divided
//! at X, the load is not smeared, and the summation by parts of the tangent remains exact.

use crate::numerics::lie::{Lanes, Twist, VectorSpace, Wrench};
use crate::robot::effects;
use crate::robot::plan::Plan;
use crate::robot::plan::piece::PiecePlan;
use crate::robot::plan::point::Inside;
use crate::robot::state::Workspace;
use crate::robot::turning::Turning;
use crate::robot::turning::place;

impl<G: Turning> Inside<G> {
    /// Integral, up to the place, of values given at the nodes.
    #[inline(always)]
    pub(crate) fn integral(&self, values: &[Twist<G, G::Pack>]) -> Twist<G, f64> {
        let mut sum = Twist::zero();
        for (&weight, &value) in self.up_to.iter().zip(values) {
            sum += value * weight;
        }
        sum.sum()
    }
}

/// Positions, rotations and inertia at the points of a piece, with the kinematics of the piece up to date.
#[inline(always)]
pub(crate) fn find<G: Turning>(plan: &Plan<G>, piece: &PiecePlan<G>, work: &mut Workspace<G>, q: &[f64]) {
    for p in piece.points.all() {
        let point = &plan.points[p];
        let (position, rotation) = match &point.inside {
            Some(inside) => {
                let mut change = G::Vector::<G::Pack>::zero();
                for (&weight, &slope) in inside.up_to.iter().zip(&work.slope[piece.node_packs()]) {
                    change += slope * weight;
                }
                let position = work.stations[piece.joined.begin].position
                    + G::map_vector(&change, |pack: &G::Pack| pack.sum());
                let is_oriented = point.is_oriented;
                let rotation = is_oriented.then(|| place::rotation_at(piece, work, q, &point.place));
                (position, rotation)
            }
            None => {
                let position = work.stations[piece.joined.end].position;
                (position, point.is_oriented.then(|| place::rotation_of_end(piece, work)))
            }
        };
        stand(plan, p, work, rotation.unwrap_or_else(G::unrotated), position);
    }
}

/// Updates a point for this rotation and position.
#[inline(always)]
pub(crate) fn stand<G: Turning>(
    plan: &Plan<G>,
    p: usize,
    work: &mut Workspace<G>,
    rotation: G::Rotation<f64>,
    position: G::Vector<f64>,
) {
    let point = &plan.points[p];
    let state = &mut work.points[p];
    (state.position, state.rotation) = (position, rotation);
    if let Some(body) = &point.body {
        state.inertia = body.carried(&rotation, position);
    }
    if let Some(station) = point.carries {
        let station = &mut work.stations[station];
        station.orientation = G::orientation(&rotation);
        (station.rotation, station.position) = (rotation, position);
    }
}

/// Motion and force at the points of a piece, with the motion of the piece up to date.
#[inline(always)]
pub(crate) fn drive<G: Turning>(plan: &Plan<G>, piece: &PiecePlan<G>, work: &mut Workspace<G>) {
    for p in piece.points.all() {
        let motion = match &plan.points[p].inside {
            Some(inside) => {
                let nodes = piece.node_packs();
                let base = &work.stations[piece.joined.begin];
                let velocity = base.velocity + inside.integral(&work.rate[nodes.clone()]);
                let acceleration = base.acceleration + inside.integral(&work.acceleration_rate[nodes]);
                (velocity, acceleration)
            }
            None => {
                let end = &work.stations[piece.joined.end];
                (end.velocity, end.acceleration)
            }
        };
        take(plan, p, work, motion);
    }
}

/// Updates a point for this velocity and acceleration.
#[inline(always)]
pub(crate) fn take<G: Turning>(
    plan: &Plan<G>,
    p: usize,
    work: &mut Workspace<G>,
    motion: (Twist<G, f64>, Twist<G, f64>),
) {
    let point = &plan.points[p];
    let mut state = work.points[p];
    (state.velocity, state.acceleration) = motion;
    state.force = Wrench::zero();
    if point.body.is_some() {
        state.momentum = state.inertia.momentum(state.velocity);
        state.force =
            state.inertia.momentum(state.acceleration) - state.velocity.bracket_transposed(state.momentum);
    }
    effects::act_at(plan, work, point, &mut state);
    work.points[p] = state;
    if let Some(station) = point.carries {
        let station = &mut work.stations[station];
        (station.velocity, station.acceleration) = motion;
    }
}

/// Wrench required by the points at the end of a piece.
#[inline(always)]
pub(crate) fn at_end<G: Turning>(piece: &PiecePlan<G>, work: &Workspace<G>) -> Wrench<G, f64> {
    let mut sum = Wrench::zero();
    for point in &work.points[piece.points.at_end.clone()] {
        sum += point.force;
    }
    sum
}

/// Adds the wrenches required by the points inside a piece to the internal wrench at the nodes; returns their
/// sum.
#[inline(always)]
pub(crate) fn carry<G: Turning>(
    plan: &Plan<G>,
    piece: &PiecePlan<G>,
    work: &mut Workspace<G>,
) -> Wrench<G, f64> {
    let mut sum = Wrench::zero();
    for p in piece.points.inside.clone() {
        let mut force = work.points[p].force;
        if let Some(station) = plan.points[p].carries {
            force += work.carried[station];
        }
        sum += force;
        let force = force.splat();
        let internal = &mut work.internal[piece.node_packs()];
        for (internal, &share) in internal.iter_mut().zip(&plan.points[p].reach().share) {
            *internal += force * share;
        }
    }
    sum
}
