//! Number and positions of the quadrature nodes of a piece of a segment.

use std::f64::consts::PI;

use super::piece::Piece;
use super::quadrature::Gauss;
use crate::lie::LANES;

/// Nodes that a segment needs beyond its number of modes: two integrations (strain to velocity, velocity to force) and
/// a rotation by up to about half a turn cost this many degrees of the polynomials; see `docs/rod.md` for the measured
/// error.
const NODES_BEYOND_MODES: usize = 9;

/// A linearly tapered radius enters the second moment of area with its fourth power, and takes so many nodes.
const NODES_FOR_TAPER: usize = 4;

/// Nodes that every rule of a row needs beyond its share, by the part of the segment that the widest one covers.
const NODES_AT_KINKS: f64 = 3.0;

/// The nodes of a piece: whole packs of them, the same number between any two places where the basis, the reference
/// strain or the section has a kink.
pub(crate) fn quadrature(piece: &Piece) -> Gauss {
    let breaks = piece.breaks();
    Gauss::composite(nodes_of_rule(piece, &breaks) as usize, &breaks)
}

/// How many nodes a piece takes; infinite where no number of them would do.
pub(crate) fn number_of_nodes(piece: &Piece) -> f64 {
    let breaks = piece.breaks();
    nodes_of_rule(piece, &breaks) * (breaks.len() + 1) as f64
}

/// Nodes between any two of its breaks.
fn nodes_of_rule(piece: &Piece, breaks: &[f64]) -> f64 {
    let rules = breaks.len() + 1;
    let of_rule = match (piece.segment.nodes, rules) {
        (Some(nodes), _) => nodes.div_ceil(rules) as f64,
        (None, 1) => needed(piece),
        (None, _) => (needed(piece) * widest(breaks)).ceil() + NODES_AT_KINKS,
    };
    // Whole packs: the rounding up costs nothing and buys accuracy.
    let lanes = (0..LANES).map(|more| of_rule + more as f64);
    lanes.into_iter().find(|of_rule| (rules as f64 * of_rule) % LANES as f64 == 0.0).unwrap_or(of_rule)
}

/// Nodes that a piece without kinks takes.
fn needed(piece: &Piece) -> f64 {
    let beyond = NODES_BEYOND_MODES + nodes_for_taper(piece.segment.section.degree_of_inertia());
    (piece.degree() + 1 + beyond) as f64 + nodes_for_turns(piece)
}

/// Nodes for a reference strain that turns the rod by more than the half turn that [`NODES_BEYOND_MODES`] are for.
/// Polynomials follow `exp(i k x)` on (-1, 1) once their degree is beyond k (Boyd 2001, section 2.4): half the turn
/// in radians. Products of two such functions are integrated by half as many nodes as they have degrees.
pub(crate) fn nodes_for_turns(piece: &Piece) -> f64 {
    (0.5 * (turn(piece) - PI)).max(0.0).ceil()
}

/// By how much the reference strain turns a piece, in radians.
pub(crate) fn turn(piece: &Piece) -> f64 {
    /// Places that are looked at.
    const LOOKS: usize = 32;
    let places: Vec<f64> = (0..=LOOKS).map(|i| i as f64 / LOOKS as f64).collect();
    largest_reference_curvature(piece, &places) * piece.length()
}

/// The largest curvature or twist of the reference strain at these places.
pub(crate) fn largest_reference_curvature(piece: &Piece, places: &[f64]) -> f64 {
    let curvature = |&x: &f64| {
        let [a, b, c, ..] = piece.reference(x);
        (a * a + b * b + c * c).sqrt()
    };
    places.iter().map(curvature).fold(0.0, f64::max)
}

/// Nodes for inertia of this degree along the rod. Beyond a linear taper, each node integrates two degrees more.
fn nodes_for_taper(degree: usize) -> usize {
    degree.min(NODES_FOR_TAPER) + degree.saturating_sub(NODES_FOR_TAPER).div_ceil(2)
}

/// The largest distance between these places of (0, 1), and of its ends.
fn widest(breaks: &[f64]) -> f64 {
    let ends = breaks.iter().chain(&[1.0]);
    [0.0].iter().chain(breaks).zip(ends).map(|(from, to)| to - from).fold(0.0, f64::max)
}
