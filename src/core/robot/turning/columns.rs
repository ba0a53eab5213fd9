//! Columns of S: twists of everything beyond a node due to a strain there, and the resulting motion of places
//! with the coordinates.

use super::Turning;
use crate::numerics::lie::{Cross, Geometry, Lanes as _, Twist, VectorSpace, Wrench};
use crate::robot::plan::Plan;
use crate::robot::plan::piece::PiecePlan;
use crate::robot::state::Workspace;

/// Twist about the origin, for a unit of the strain component `index` at a node with this rotation and
/// position, of everything beyond the node: a column of `Ad_g`.
#[inline(always)]
pub(crate) fn shape<G: Turning>(
    rotation: &G::Rotation<G::Pack>,
    position: G::Vector<G::Pack>,
    index: usize,
) -> Twist<G, G::Pack> {
    if index < G::ANGULAR {
        let axis = G::angular_axis(rotation, index);
        Twist { angular: axis, linear: position.cross(axis) }
    } else {
        Twist { angular: VectorSpace::zero(), linear: G::linear_axis(rotation, index - G::ANGULAR) }
    }
}

/// Pieces that move a place, each with the weights of the integral up to that place.
#[inline(always)]
pub(crate) fn each<P>(moved_by: &[(usize, Vec<P>)]) -> impl Iterator<Item = (usize, &[P])> {
    moved_by.iter().map(|(piece, weights)| (*piece, weights.as_slice()))
}

/// S and ad_V S at the nodes of a piece for a unit of each strain component. The second is valid only if the
/// motion is up to date.
pub(crate) type AtNodes<G> = [[Twist<G, <G as Geometry>::Pack>; 2]];

/// Computes them: entry `[component * packs + pack]`.
#[inline(always)]
pub(crate) fn write_at_nodes<G: Turning>(
    piece: &PiecePlan<G>,
    work: &Workspace<G>,
    at_nodes: &mut AtNodes<G>,
) {
    for (component, at_nodes) in piece.components.iter().zip(at_nodes.chunks_exact_mut(piece.packs.max(1))) {
        for (node, at_node) in piece.node_packs().zip(at_nodes) {
            *at_node = at_node_of(work, node, component.index);
        }
    }
}

#[inline(always)]
fn at_node_of<G: Turning>(work: &Workspace<G>, node: usize, index: usize) -> [Twist<G, G::Pack>; 2] {
    let shape = shape(&work.rotation[node], work.position[node], index);
    [shape, work.velocity[node].bracket(shape)]
}

/// Calls `visit` for the coordinates that move a place, each with its `Psi = int S` up to the place and `int
/// ad_V S`. The second is valid only if the motion is up to date.
#[inline(always)]
pub(crate) fn visit<'a, G: Turning>(
    plan: &Plan<G>,
    work: &Workspace<G>,
    moved_by: impl IntoIterator<Item = (usize, &'a [G::Pack])>,
    mut visit: impl FnMut(usize, [Twist<G, f64>; 2]),
) {
    for (p, weights) in moved_by {
        let piece = &plan.pieces[p];
        let at = |c: usize, pack: usize| at_node_of(work, piece.first_pack + pack, piece.components[c].index);
        visit_piece(work, piece, weights, at, &mut visit);
    }
}

/// Calls `visit` for the coordinates of a piece, as [`visit`] does; `at` returns S and ad_V S for a component and a
/// pack.
#[inline(always)]
pub(crate) fn visit_piece<G: Turning>(
    work: &Workspace<G>,
    piece: &PiecePlan<G>,
    weights: &[G::Pack],
    at: impl Fn(usize, usize) -> [Twist<G, G::Pack>; 2],
    visit: &mut impl FnMut(usize, [Twist<G, f64>; 2]),
) {
    if let Some(hinge) = &piece.hinge {
        let shape = work.hinges[hinge.index];
        visit(piece.first, [shape, work.stations[piece.joined.end].velocity.bracket(shape)]);
        return;
    }
    for (c, component) in piece.components.iter().enumerate() {
        for (degree, basis) in piece.basis.chunks_exact(piece.packs).take(component.modes).enumerate() {
            let mut sums = [Twist::zero(); 2];
            for (pack, (&weight, &basis)) in weights.iter().zip(basis).enumerate() {
                let [shape, rate] = at(c, pack);
                let weight = weight * basis;
                sums[0] = sums[0].add_scaled(shape, weight);
                sums[1] = sums[1].add_scaled(rate, weight);
            }
            let [shape, rate] = sums;
            visit(component.first + degree, [shape.sum(), rate.sum()]);
        }
    }
}

/// Writes `Psi = int S` up to a place and `int ad_V S` for the coordinates of a piece, from S and ad_V S at its nodes and the weights of
/// the integral.
#[inline(always)]
pub(crate) fn write_columns<G: Turning>(
    work: &Workspace<G>,
    piece: &PiecePlan<G>,
    weights: &[G::Pack],
    at_nodes: &AtNodes<G>,
    columns: &mut [[Twist<G, f64>; 2]],
) {
    let at = |c: usize, pack: usize| at_nodes[c * piece.packs + pack];
    visit_piece(work, piece, weights, at, &mut |k, column| columns[k - piece.first] = column);
}

/// Adds, for the coordinates of a piece of a rod, the power of a wrench on the sum of S at the nodes with these weights.
#[inline(always)]
pub(crate) fn add_powers<G: Turning>(
    work: &Workspace<G>,
    piece: &PiecePlan<G>,
    weights: &[G::Pack],
    wrench: Wrench<G, f64>,
    row: &mut [f64],
) {
    let wrench = wrench.splat();
    for component in &piece.components {
        for (pack, (node, &weight)) in piece.node_packs().zip(weights).enumerate() {
            let shape = shape(&work.rotation[node], work.position[node], component.index);
            let power = shape.dot(wrench) * weight;
            let bases = piece.basis.chunks_exact(piece.packs).take(component.modes);
            for (degree, basis) in bases.enumerate() {
                row[component.first + degree] += (power * basis[pack]).sum();
            }
        }
    }
}
