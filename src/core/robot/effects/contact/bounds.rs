//! Balls around curves, by the places of their ends and the slopes at their nodes.

use super::curve::LONGER;
use crate::numerics::lie::{LANES, Lanes as _, VectorSpace as _};
use crate::robot::effects::contact::broad_phase;
use crate::robot::effects::contact::plan::Curve;
use crate::robot::plan::Plan;
use crate::robot::plan::piece::PiecePlan;
use crate::robot::state::Workspace;
use crate::robot::turning::Turning;

/// Largest radius of the ball around both ends of a curve, as a part of its length ([`stretched`] times as long), and by how much that
/// radius grows per slope.
const HALF_LENGTH: f64 = 0.5;
pub(super) const LARGEST_RADIUS: f64 = HALF_LENGTH * LONGER;

/// By which factor a piece is longer than without strain, at most, by the slopes at its nodes.
#[inline(always)]
pub(super) fn stretched<G: Turning>(piece: &PiecePlan<G>, work: &Workspace<G>, nodes: usize) -> f64 {
    if !piece.is_extensible {
        return 1.0;
    }
    let squares = work.slope[piece.node_packs()].iter().map(|slope| slope.dot(*slope));
    let lanes = squares.flat_map(|squares| (0..LANES).map(move |lane| squares.lane(lane)));
    LONGER * lanes.take(nodes).fold(0.0, f64::max).sqrt()
}

/// See [`around_ends`].
#[inline(always)]
pub(super) fn ball_around_ends<G: Turning>(
    plan: &Plan<G>,
    work: &Workspace<G>,
    curve: &Curve<G::Pack>,
) -> broad_phase::Ball {
    around_ends(plan, work, curve, stretch_of(plan, work, curve))
}

/// The same of a curve.
#[inline(always)]
pub(super) fn stretch_of<G: Turning>(plan: &Plan<G>, work: &Workspace<G>, curve: &Curve<G::Pack>) -> f64 {
    // Samples are the nodes and both ends.
    stretched(&plan.pieces[curve.piece], work, curve.samples.len() - 2)
}

/// The ball around the middle of both ends of a curve: it is as far from both together as it is long at most.
#[inline(always)]
pub(super) fn around_ends<G: Turning>(
    plan: &Plan<G>,
    work: &Workspace<G>,
    curve: &Curve<G::Pack>,
    stretched: f64,
) -> broad_phase::Ball {
    let joined = &plan.pieces[curve.piece].joined;
    let [begin, end] =
        [joined.begin, joined.end].map(|station| G::in_space(plan.frame, work.stations[station].position));
    ((begin + end) * 0.5, HALF_LENGTH * stretched * curve.length + curve.thickest)
}
