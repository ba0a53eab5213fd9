//! Whether a shape is valid and resolved by the quadrature nodes.

use std::f64::consts::PI;

use crate::model::InvalidShape;
use crate::numerics::lie::{LANES, Lanes, Twist, VectorSpace};
use crate::robot::plan::Plan;
use crate::robot::plan::piece::PiecePlan;
use crate::robot::turning::Turning;

/// Gauss-Legendre quadrature converges if there are more than pi nodes per full turn of the integrand
/// (Trefethen 2000, Spectral Methods in MATLAB, chapter 9; nodes are farthest apart in the middle, pi / 2
/// times the mean distance): here, if the rod rotates by less than this between neighbouring nodes. Beyond,
/// computed poses belong to another shape.
const LARGEST_TURN: f64 = PI;

/// Problem of a shape; `None` for a valid one.
pub(crate) fn invalid_shape<G: Turning>(plan: &Plan<G>, q: &[f64]) -> Option<InvalidShape> {
    inversion(plan, q).or_else(|| shortage(plan, q).map(|shortage| InvalidShape::Unresolved { shortage }))
}

/// Whether the rod is turned inside out, and where.
fn inversion<G: Turning>(plan: &Plan<G>, q: &[f64]) -> Option<InvalidShape> {
    for link in &plan.links {
        let mut start = 0.0;
        for piece in &plan.pieces[link.rod.clone()] {
            if let Some((x, stretch)) = piece.stretch.as_ref().and_then(|stretch| stretch.inverted(q)) {
                return Some(InvalidShape::Inverted { at: start + x * piece.length, stretch });
            }
            start += piece.length;
        }
    }
    None
}

/// Required number of nodes over the present one, as estimated from the coordinates; `None` if the rod
/// rotates by less than half a turn between all neighbouring nodes.
fn shortage<G: Turning>(plan: &Plan<G>, q: &[f64]) -> Option<f64> {
    let turn = |piece: &PiecePlan<G>| {
        // Basis functions never exceed one, so that usually the coordinates suffice as a bound.
        let mut curvature = piece.largest_reference_curvature;
        for component in piece.components.iter().filter(|component| component.index < G::ANGULAR) {
            for q in &q[component.first..][..component.modes] {
                curvature += q.abs();
            }
        }
        let bound = curvature * piece.largest_gap;
        if bound < LARGEST_TURN { bound } else { largest_turn(piece, q) }
    };
    let turns = plan.pieces.iter().map(turn);
    let largest = turns.fold(0.0, |largest: f64, turn| if turn <= largest { largest } else { turn });
    let is_resolved = largest < LARGEST_TURN;
    (!is_resolved).then_some(largest / LARGEST_TURN)
}

/// Largest rotation between neighbouring nodes, from the curvature at both of them including the reference
/// strain; NaN if not finite.
pub(super) fn largest_turn<G: Turning>(piece: &PiecePlan<G>, q: &[f64]) -> f64 {
    let curvature = |node: usize| {
        let field = piece.field(q, node / LANES);
        let angular = Twist::<G, f64> {
            angular: G::map_axial(&field.angular, |pack: &G::Pack| pack.lane(node % LANES)),
            linear: VectorSpace::zero(),
        };
        let total = angular.angular + piece.reference_curvature[node];
        total.dot(total).sqrt()
    };
    let nodes = &piece.gauss.nodes;
    let ends = |i: usize| (if i == 0 { 0.0 } else { nodes[i - 1] }, nodes.get(i + 1).copied().unwrap_or(1.0));
    let turns = (0..nodes.len()).map(|i| {
        let (before, after) = ends(i);
        curvature(i) * piece.length * (nodes[i] - before).max(after - nodes[i])
    });
    turns.fold(0.0, |largest: f64, turn| if turn <= largest { largest } else { turn })
}
