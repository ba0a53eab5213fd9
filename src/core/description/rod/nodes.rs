//! Number and positions of the quadrature nodes of a piece of a segment.

use std::f64::consts::{PI, TAU};

use super::piece::{self, Piece};
use super::quadrature::Gauss;
use super::segment::Segment;
use crate::numerics::lie::LANES;

/// Number of nodes that a segment needs beyond its number of modes. Two integrations (strain to velocity,
/// velocity to force) and a rotation by up to about half a turn increase the degrees of the polynomials by
/// this much; see `docs/methods/rods.md` for the measured error.
const NODES_BEYOND_MODES: usize = 9;

/// A linearly tapered radius enters the second moment of area with its fourth power, and requires this many
/// nodes.
const NODES_FOR_TAPER: usize = 4;

/// Nodes of every rule of a composite one beyond its share of the nodes; the share is the fraction of the
/// segment that the widest rule covers.
const NODES_AT_KINKS: f64 = 3.0;

/// Quadrature of a piece: a multiple of the pack size, with the same number of nodes between any two kinks of
/// the basis, the reference strain or the section.
pub(crate) fn quadrature(piece: &Piece) -> Gauss {
    let breaks = piece.breaks();
    Gauss::composite(nodes_of_rule(piece, &breaks) as usize, &breaks)
}

/// Number of nodes of a piece; infinite if no number would suffice.
pub(crate) fn number_of_nodes(piece: &Piece) -> f64 {
    let breaks = piece.breaks();
    nodes_of_rule(piece, &breaks) * (breaks.len() + 1) as f64
}

/// Number of nodes between two breaks.
fn nodes_of_rule(piece: &Piece, breaks: &[f64]) -> f64 {
    let rules = breaks.len() + 1;
    let of_rule = match (piece.segment.nodes, rules) {
        (Some(nodes), _) => nodes.div_ceil(rules) as f64,
        (None, 1) => needed(piece),
        (None, _) => (needed(piece) * widest(breaks)).ceil() + NODES_AT_KINKS,
    };
    // Rounding up to whole packs costs no time and increases accuracy.
    let lanes = (0..LANES).map(|more| of_rule + more as f64);
    lanes.into_iter().find(|of_rule| (rules as f64 * of_rule) % LANES as f64 == 0.0).unwrap_or(of_rule)
}

/// Number of nodes for a piece without kinks.
fn needed(piece: &Piece) -> f64 {
    let beyond = NODES_BEYOND_MODES + nodes_for_taper(piece.segment.section.degree_of_inertia());
    (piece.degree() + 1 + beyond) as f64 + nodes_for_turns(piece)
}

/// Nodes for a reference strain that rotates the rod by more than the half turn covered by
/// [`NODES_BEYOND_MODES`]. Polynomials approximate `exp(i k x)` on (-1, 1) once their degree exceeds k (Boyd
/// 2001, section 2.4), which is half the rotation in radians. Integrating products of two such functions
/// needs half as many nodes as their total degree.
pub(crate) fn nodes_for_turns(piece: &Piece) -> f64 {
    (0.5 * (turn(piece) - PI)).max(0.0).ceil()
}

/// Rotation of a piece by its reference strain, in radians.
pub(crate) fn turn(piece: &Piece) -> f64 {
    /// Number of sample points.
    const SAMPLES: usize = 32;
    if piece.segment.reference_strain.constant().is_some() {
        return largest_reference_curvature(piece, &[0.0]) * piece.length();
    }
    let places: Vec<f64> = (0..=SAMPLES).map(|i| i as f64 / SAMPLES as f64).collect();
    largest_reference_curvature(piece, &places) * piece.length()
}

/// How often a segment turns by its reference strain, at the rate of the largest curvature or twist of each piece.
pub fn reference_turns(segment: &Segment) -> f64 {
    piece::of(segment).map(|piece| turn(&piece)).sum::<f64>() / TAU
}

/// Largest curvature or twist of the reference strain at these points.
pub(crate) fn largest_reference_curvature(piece: &Piece, places: &[f64]) -> f64 {
    let curvature = |&x: &f64| {
        let [a, b, c, ..] = piece.reference(x);
        (a * a + b * b + c * c).sqrt()
    };
    places.iter().map(curvature).fold(0.0, f64::max)
}

/// Nodes for an inertia of this degree along the rod. Beyond a linear taper, each node integrates two more
/// degrees.
fn nodes_for_taper(degree: usize) -> usize {
    degree.min(NODES_FOR_TAPER) + degree.saturating_sub(NODES_FOR_TAPER).div_ceil(2)
}

/// Largest distance between these points of (0, 1), including both ends.
fn widest(breaks: &[f64]) -> f64 {
    let ends = breaks.iter().chain(&[1.0]);
    [0.0].iter().chain(breaks).zip(ends).map(|(from, to)| to - from).fold(0.0, f64::max)
}
