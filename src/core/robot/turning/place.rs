//! Positions and rotations at places of a rod.

use std::ops::Range;

use super::Turning;
use crate::numerics::lie::{LANES, Lanes};
use crate::robot::plan::link::LinkPlan;
use crate::robot::plan::piece::PiecePlan;
use crate::robot::plan::point::Place;
use crate::robot::plan::space::Passage;
use crate::robot::state::Workspace;

/// Place at arc length `x` of an unstretched rod of these pieces, clamped to [0, L].
pub(crate) fn at_arc_length<G: Turning>(pieces: &[PiecePlan<G>], rod: Range<usize>, x: f64) -> Place {
    let (mut s, mut start) = (rod.start, 0.0);
    while s + 1 < rod.end && x > start + pieces[s].length {
        start += pieces[s].length;
        s += 1;
    }
    // Rounding of the summed lengths must not lead outside.
    at_fraction(pieces, s, ((x - start) / pieces[s].length).clamp(0.0, 1.0))
}

/// Place on a link: at the arc length `x` of its rod (the tip if `None`), or at the base of a rigid link.
pub(crate) fn on_link<G: Turning>(pieces: &[PiecePlan<G>], link: &LinkPlan, x: Option<f64>) -> Place {
    if link.rod.is_empty() {
        let passage = Passage { step: 0.0, basis: Vec::new(), reference: Vec::new() };
        let (piece, weights) = (link.base, Vec::new());
        return Place { piece, x: 1.0, before: 0, passage, weights, beside: link.beside };
    }
    at_arc_length(pieces, link.rod.clone(), x.unwrap_or(f64::INFINITY))
}

/// Place at the fraction `x` of piece `s`.
pub(crate) fn at_fraction<G: Turning>(pieces: &[PiecePlan<G>], s: usize, x: f64) -> Place {
    let piece = &pieces[s];
    let before = piece.gauss.nodes.partition_point(|&node| node <= x);
    let from = if before == 0 { 0.0 } else { piece.gauss.nodes[before - 1] };
    let passage = G::passage(piece, from, x);
    let weights = piece.gauss.weights_up_to(x).into_iter().map(|weight| weight * piece.length).collect();
    Place { piece: s, x, before, passage, weights, beside: None }
}

/// Rotation at the end of a piece.
#[inline(always)]
pub(crate) fn rotation_of_end<G: Turning>(piece: &PiecePlan<G>, work: &Workspace<G>) -> G::Rotation<f64> {
    let end = &work.stations[piece.joined.end];
    if piece.packs == 0 { end.rotation } else { G::matrix(end.orientation) }
}

/// Rotation at a place, if the rotations of the nodes are up to date.
#[inline(always)]
pub(crate) fn rotation_at<G: Turning>(
    piece: &PiecePlan<G>,
    work: &Workspace<G>,
    q: &[f64],
    place: &Place,
) -> G::Rotation<f64> {
    // The place is the end of the piece.
    if place.weights.is_empty() {
        return rotation_of_end(piece, work);
    }
    let before = match place.before {
        0 => G::matrix(work.stations[piece.joined.begin].orientation),
        i => {
            let packs = &work.rotation[piece.first_pack + (i - 1) / LANES];
            G::map_rotation(packs, |entry: &G::Pack| entry.lane((i - 1) % LANES))
        }
    };
    G::compose(&before, &G::pass(piece, q, &place.passage))
}
