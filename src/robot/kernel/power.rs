//! What the forces along rods do in a virtual motion, segment by segment.

use crate::lie::{Lanes, Wrench};
use crate::robot::plan::Plan;
use crate::robot::state::Workspace;
use crate::robot::turning::Turning;

/// The power `int V . f` of forces per length at the nodes of each segment, in their order, with the virtual motion up to date.
///
/// As integrals sum by parts exactly, `rates . Q` is the sum of these over all segments, and what acts at points.
pub(crate) fn of_segments<G: Turning>(
    plan: &Plan<G>,
    work: &Workspace<G>,
    forces: &[Wrench<G, G::Pack>],
    powers: &mut [f64],
) {
    powers.fill(0.0);
    let mut segments = 0;
    for piece in plan.links.iter().flat_map(|link| &plan.pieces[link.rod.clone()]) {
        segments += usize::from(piece.part().begins_segment());
        let nodes = piece.node_packs();
        let velocity = &work.velocity[nodes.clone()];
        for ((velocity, force), &weight) in velocity.iter().zip(&forces[nodes]).zip(&piece.weights) {
            powers[segments - 1] += (velocity.dot(*force) * weight).sum();
        }
    }
}
