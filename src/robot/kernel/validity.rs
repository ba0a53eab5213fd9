//! Whether a shape is valid and resolved by the quadrature nodes.

use std::f64::consts::PI;

use crate::lie::{LANES, Lanes, Twist, VectorSpace};
use crate::model::Flaw;
use crate::robot::plan::Plan;
use crate::robot::plan::piece::PiecePlan;
use crate::robot::turning::Turning;

/// Gauss-Legendre quadrature converges once there are more than pi nodes in a full turn of what it integrates
/// (Trefethen 2000, Spectral Methods in MATLAB, chapter 9; the nodes are farthest apart in the middle, by pi / 2 of
/// the mean): here, while the rod turns by less than this between neighbouring nodes. Beyond, poses are those of
/// another shape.
const LARGEST_TURN: f64 = PI;

/// The flaw of a shape, if it has one.
pub(crate) fn flaw<G: Turning>(plan: &Plan<G>, q: &[f64]) -> Option<Flaw> {
    inversion(plan, q).or_else(|| shortage(plan, q).map(|shortage| Flaw::Unresolved { shortage }))
}

/// Where the rod is turned inside out.
fn inversion<G: Turning>(plan: &Plan<G>, q: &[f64]) -> Option<Flaw> {
    for link in &plan.links {
        let mut start = 0.0;
        for piece in &plan.pieces[link.rod.clone()] {
            if let Some((x, stretch)) = piece.stretch.as_ref().and_then(|stretch| stretch.inverted(q)) {
                return Some(Flaw::Inverted { at: start + x * piece.length, stretch });
            }
            start += piece.length;
        }
    }
    None
}

/// How many times as many nodes the shape takes as there are, as far as its coordinates say; `None` where the rod
/// turns by less than half a turn between all neighbouring nodes.
fn shortage<G: Turning>(plan: &Plan<G>, q: &[f64]) -> Option<f64> {
    let turn = |piece: &PiecePlan<G>| {
        // No basis function exceeds one: mostly the coordinates alone tell.
        let angular = piece.components.iter().filter(|component| component.index < G::ANGULAR);
        let bound: f64 =
            angular.flat_map(|component| &q[component.first..][..component.modes]).map(|q| q.abs()).sum();
        let bound = (bound + piece.largest_reference_curvature) * piece.largest_gap;
        if bound < LARGEST_TURN { bound } else { largest_turn(piece, q) }
    };
    let turns = plan.pieces.iter().map(turn);
    let largest = turns.fold(0.0, |largest: f64, turn| if turn <= largest { largest } else { turn });
    let is_resolved = largest < LARGEST_TURN;
    (!is_resolved).then_some(largest / LARGEST_TURN)
}

/// The largest turn between neighbouring nodes, by the curvature at both of them, that of the reference strain
/// included; NaN where that is not finite.
fn largest_turn<G: Turning>(piece: &PiecePlan<G>, q: &[f64]) -> f64 {
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
