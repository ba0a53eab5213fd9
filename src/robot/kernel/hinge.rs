//! Joints of one coordinate. In the inertial frame one is a node of weight one: with its unit twist s in the axes of the
//! place before it and S = Ad_g s, what lies behind moves by `V + S qd` and `A + S qdd + ad_V (S qd)`, and the force of
//! the coordinate is `S . F`.

use super::inverse_dynamics::carried;
use crate::lie::{Twist, Wrench};
use crate::robot::effect::joint_forces;
use crate::robot::plan::hinge::Hinge;
use crate::robot::plan::piece::PiecePlan;
use crate::robot::state::{Station, Workspace};
use crate::robot::turning::Turning;

/// Where what lies behind it is, and S.
#[inline(always)]
pub(crate) fn place<G: Turning>(piece: &PiecePlan<G>, hinge: &Hinge<G>, work: &mut Workspace<G>, q: &[f64]) {
    let Station { mut orientation, mut rotation, mut position, .. } = work.stations[piece.joined.begin];
    let q = q[piece.first];
    work.hinges[hinge.index] = carried(&rotation, position, hinge.twist, !hinge.turns);
    if hinge.turns {
        orientation = G::turned(orientation, G::turn_by(hinge.twist.angular * q));
        rotation = G::matrix(orientation);
    } else {
        position += G::rotate(&rotation, hinge.twist.linear * q);
    }
    let end = &mut work.stations[piece.joined.end];
    (end.orientation, end.rotation, end.position) = (orientation, rotation, position);
}

/// The motion of what lies behind it.
#[inline(always)]
pub(crate) fn drive<G: Turning>(
    piece: &PiecePlan<G>,
    hinge: &Hinge<G>,
    work: &mut Workspace<G>,
    [qd, qdd]: [&[f64]; 2],
) {
    let shape = work.hinges[hinge.index];
    let Station { velocity, acceleration, .. } = work.stations[piece.joined.begin];
    let rate = shape * qd[piece.first];
    let end = &mut work.stations[piece.joined.end];
    end.velocity = velocity + rate;
    end.acceleration = acceleration + velocity.bracket_add(rate, shape * qdd[piece.first]);
}

/// The force of its coordinate, with that of what acts on it.
#[inline(always)]
pub(crate) fn project<G: Turning>(
    piece: &PiecePlan<G>,
    hinge: &Hinge<G>,
    work: &Workspace<G>,
    state: [f64; 3],
) -> f64 {
    let force = work.hinges[hinge.index].dot(work.through[piece.joined.end]);
    hinge.forces.as_ref().map_or(force, |forces| force + joint_forces::act(forces, state))
}

/// S, ad_V S, (ad_A + ad_V ad_V) S and ad_S^T F: what a coordinate changes behind it, and before it.
#[inline(always)]
pub(crate) fn shapes<G: Turning>(
    piece: &PiecePlan<G>,
    hinge: &Hinge<G>,
    work: &Workspace<G>,
) -> ([Twist<G, f64>; 3], Wrench<G, f64>) {
    let shape = work.hinges[hinge.index];
    let Station { velocity, acceleration, .. } = work.stations[piece.joined.end];
    let rate = velocity.bracket(shape);
    let second = velocity.bracket_add(rate, acceleration.bracket(shape));
    ([shape, rate, second], shape.bracket_transposed(work.through[piece.joined.end]))
}
