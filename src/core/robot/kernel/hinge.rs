//! Joints with one coordinate. In the inertial frame such a joint is a node of weight one: with its unit
//! twist s in the axes of the preceding place and S = Ad_g s, everything beyond it moves by `V + S qd` and
//! `A + S qdd + ad_V (S qd)`, and the force of the coordinate is `S . F`.

use super::adjoint::carried;
use crate::numerics::lie::{LANES, Lanes, Scalar, Twist, Wrench, sine_cosine};
use crate::robot::effects::joint_forces;
use crate::robot::plan::Plan;
use crate::robot::plan::hinge::Hinge;
use crate::robot::plan::piece::PiecePlan;
use crate::robot::state::{Placement, Station, Workspace};
use crate::robot::turning::Turning;

/// Sine and cosine of half the angles of all hinges, several at a time.
#[inline(always)]
pub(crate) fn half_angles<G: Turning>(plan: &Plan<G>, work: &mut Workspace<G>, q: &[f64]) {
    for (half, coordinates) in work.half_angles.iter_mut().zip(plan.hinges.chunks(LANES)) {
        let mut angles = G::Pack::splat(0.0);
        for (lane, &k) in coordinates.iter().enumerate() {
            angles.set_lane(lane, 0.5 * q[k]);
        }
        *half = sine_cosine(angles).into();
    }
}

/// Pose beyond the hinge, and S.
#[inline(always)]
pub(crate) fn place<G: Turning>(
    piece: &PiecePlan<G>,
    hinge: &Hinge<G>,
    work: &mut Workspace<G>,
    q: &[f64],
    place: Placement<G>,
) -> Placement<G> {
    let Placement { mut orientation, mut rotation, mut position } = place;
    let q = q[piece.first];
    work.hinges[hinge.index] = carried(&rotation, position, hinge.twist, hinge.advances);
    if hinge.advances {
        position += G::rotate(&rotation, hinge.twist.linear * q);
    }
    if hinge.turns {
        let (pack, lane) = (hinge.index / LANES, hinge.index % LANES);
        let half = work.half_angles[pack].map(|entry| entry.lane(lane));
        let (turn, matrix) = G::turn_about(hinge.twist.angular, q, half);
        rotation = G::compose(&rotation, &matrix);
        if piece.joined.is_followed_by_nodes {
            orientation = G::turned(orientation, turn);
        }
    }
    Placement { orientation, rotation, position }
}

/// Motion beyond the hinge, from the motion before it.
#[inline(always)]
pub(crate) fn drive<G: Turning>(
    piece: &PiecePlan<G>,
    hinge: &Hinge<G>,
    work: &Workspace<G>,
    [qd, qdd]: [&[f64]; 2],
    (velocity, acceleration): (Twist<G, f64>, Twist<G, f64>),
) -> (Twist<G, f64>, Twist<G, f64>) {
    let shape = work.hinges[hinge.index];
    let rate = shape * qd[piece.first];
    (velocity + rate, acceleration + velocity.bracket_add(rate, shape * qdd[piece.first]))
}

/// Force of the coordinate, including the joint's own forces.
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

/// S, ad_V S, (ad_A + ad_V ad_V) S and ad_S^T F of a unit of the coordinate.
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
