//! Whether a shape is one that the rod can have and that its quadrature nodes can follow.

use std::f64::consts::PI;

use super::piece::Piece;
use super::plan::{Plan, SegmentPlan};
use super::quadrature::Gauss;
use super::turning::Turning;
use crate::lie::{LANES, Lanes, Twist, VectorSpace};
use crate::model::Flaw;

/// The strain along the rod among those of a piece.
const STRETCH: usize = 3;

/// Gauss-Legendre quadrature converges once there are more than pi nodes in a full turn of what it integrates (Trefethen 2000,
/// Spectral Methods in MATLAB, chapter 9; the nodes are farthest apart in the middle, by pi / 2 of the mean): here, while the rod turns
/// by less than this between neighbouring nodes. Beyond, poses are those of another shape.
const LARGEST_TURN: f64 = PI;

/// What is wrong with a shape, if anything is.
pub(super) fn flaw<G: Turning>(plan: &Plan<G>, q: &[f64]) -> Option<Flaw> {
    inversion(plan, q).or_else(|| shortage(plan, q).map(|shortage| Flaw::Unresolved { shortage }))
}

/// The stretch of a segment at its nodes and at both ends: it must stay positive there.
#[derive(Clone, Debug)]
pub(super) struct Stretch {
    /// The first of its coordinates.
    first: usize,
    /// Fractions of the segment's length, with the basis and the reference stretch there.
    places: Vec<(f64, Vec<f64>, f64)>,
    smallest_reference: f64,
}

impl Stretch {
    /// That of a piece whose stretch begins at coordinate `first`.
    pub(super) fn new(piece: &Piece, gauss: &Gauss, first: usize) -> Self {
        let at = |x: f64| {
            let mut basis = vec![0.0; piece.modes[STRETCH]];
            piece.basis.values(x, &mut basis);
            (x, basis, piece.reference(x)[STRETCH])
        };
        let places: Vec<_> = [0.0].iter().chain(&gauss.nodes).chain(&[1.0]).map(|&x| at(x)).collect();
        let smallest_reference = places.iter().fold(f64::INFINITY, |smallest, place| smallest.min(place.2));
        Self { first, places, smallest_reference }
    }

    /// The smallest stretch, and where, if it is not positive anywhere.
    fn inverted(&self, q: &[f64]) -> Option<(f64, f64)> {
        let q = &q[self.first..][..self.places[0].1.len()];
        // No basis function exceeds one: mostly the coordinates alone tell.
        let bound: f64 = q.iter().map(|q| q.abs()).sum();
        if bound < self.smallest_reference {
            return None;
        }
        let stretches = self.places.iter().map(|(x, basis, reference)| {
            (*x, reference + basis.iter().zip(q).map(|(basis, q)| basis * q).sum::<f64>())
        });
        stretches.filter(|(_, stretch)| *stretch <= 0.0).min_by(|a, b| a.1.total_cmp(&b.1))
    }
}

/// Where the rod is turned inside out.
fn inversion<G: Turning>(plan: &Plan<G>, q: &[f64]) -> Option<Flaw> {
    let mut start = 0.0;
    for segment in &plan.segments {
        if let Some((x, stretch)) = segment.stretch.as_ref().and_then(|stretch| stretch.inverted(q)) {
            return Some(Flaw::Inverted { at: start + x * segment.length, stretch });
        }
        start += segment.length;
    }
    None
}

/// How many times as many nodes the shape takes as there are, as far as its coordinates say; `None` where the rod turns by less than
/// half a turn between all neighbouring nodes.
fn shortage<G: Turning>(plan: &Plan<G>, q: &[f64]) -> Option<f64> {
    let turn = |segment: &SegmentPlan<G>| {
        // No basis function exceeds one: mostly the coordinates alone tell.
        let angular = segment.components.iter().filter(|component| component.index < G::ANGULAR);
        let bound: f64 =
            angular.flat_map(|component| &q[component.first..][..component.modes]).map(|q| q.abs()).sum();
        let bound = (bound + segment.largest_reference_curvature) * segment.largest_gap;
        if bound < LARGEST_TURN { bound } else { largest_turn(segment, q) }
    };
    let turns = plan.segments.iter().map(turn);
    let largest = turns.fold(0.0, |largest: f64, turn| if turn <= largest { largest } else { turn });
    let is_resolved = largest < LARGEST_TURN;
    (!is_resolved).then_some(largest / LARGEST_TURN)
}

/// The largest turn between neighbouring nodes, by the curvature at both of them, that of the reference strain included; NaN where that is not finite.
fn largest_turn<G: Turning>(segment: &SegmentPlan<G>, q: &[f64]) -> f64 {
    let curvature = |node: usize| {
        let field = segment.field(q, node / LANES);
        let angular = Twist::<G, f64> {
            angular: G::map_axial(&field.angular, |pack: &G::Pack| pack.lane(node % LANES)),
            linear: VectorSpace::zero(),
        };
        let total = angular.angular + segment.reference_curvature[node];
        total.dot(total).sqrt()
    };
    let nodes = &segment.gauss.nodes;
    let ends = |i: usize| (if i == 0 { 0.0 } else { nodes[i - 1] }, nodes.get(i + 1).copied().unwrap_or(1.0));
    let turns = (0..nodes.len()).map(|i| {
        let (before, after) = ends(i);
        curvature(i) * segment.length * (nodes[i] - before).max(after - nodes[i])
    });
    turns.fold(0.0, |largest: f64, turn| if turn <= largest { largest } else { turn })
}
