//! Columns of S: twists of everything beyond a node due to a strain there, and the resulting motion of places
//! with the coordinates.

use super::Turning;
use crate::lie::{Cross, Twist, VectorSpace};
use crate::robot::plan::Plan;
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

/// Calls `f` for the coordinates that move a place, each with its `Psi = int S` up to the place and `int ad_V
/// S`. The second is valid only if the motion is up to date.
#[inline(always)]
pub(crate) fn visit<'a, G: Turning>(
    plan: &Plan<G>,
    work: &Workspace<G>,
    moved_by: impl IntoIterator<Item = (usize, &'a [G::Pack])>,
    mut visit: impl FnMut(usize, [Twist<G, f64>; 2]),
) {
    for (p, weights) in moved_by {
        let piece = &plan.pieces[p];
        if let Some(hinge) = &piece.hinge {
            let shape = work.hinges[hinge.index];
            visit(piece.first, [shape, work.stations[piece.joined.end].velocity.bracket(shape)]);
            continue;
        }
        for component in &piece.components {
            for (degree, basis) in piece.basis.chunks_exact(piece.packs).take(component.modes).enumerate() {
                let mut sums = [Twist::zero(); 2];
                for ((node, &weight), &basis) in piece.node_packs().zip(weights).zip(basis) {
                    let shape = shape(&work.rotation[node], work.position[node], component.index);
                    let weight = weight * basis;
                    sums[0] = sums[0].add_scaled(shape, weight);
                    sums[1] = sums[1].add_scaled(work.velocity[node].bracket(shape), weight);
                }
                let [shape, rate] = sums;
                visit(component.first + degree, [shape.sum(), rate.sum()]);
            }
        }
    }
}
