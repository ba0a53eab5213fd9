//! Loads that are spread along a part of the rod.

use crate::lie::Wrench;
use crate::load::Frame;
use crate::robot::plan::Plan;
use crate::robot::plan::load::Spread;
use crate::robot::plan::piece::PiecePlan;
use crate::robot::state::Workspace;
use crate::robot::turning::Turning;

impl<G: Turning> Spread<G> {
    /// Whether the load keeps its direction in the world.
    #[inline(always)]
    pub(crate) fn is_dead(&self, plan: &Plan<G>) -> bool {
        plan.loads[self.load].frame == Frame::World
    }

    /// The wrench per length at the nodes of a pack, about these nodes.
    #[inline(always)]
    pub(crate) fn wrench(
        &self,
        plan: &Plan<G>,
        work: &Workspace<G>,
        pack: usize,
        rotation: &G::Rotation<G::Pack>,
    ) -> Wrench<G, G::Pack> {
        let wrench = work.acting[self.load].splat() * self.density[pack];
        if self.is_dead(plan) { wrench } else { wrench.rotated(rotation) }
    }
}

/// Takes the spread loads off what the motion of a piece needs.
#[inline(always)]
pub(crate) fn act<G: Turning>(plan: &Plan<G>, piece: &PiecePlan<G>, work: &mut Workspace<G>) {
    for spread in &piece.spread {
        for pack in 0..piece.packs {
            let node = piece.first_pack + pack;
            let wrench = spread.wrench(plan, work, pack, &work.rotation[node]);
            work.force[node] = work.force[node] - wrench.at(work.position[node]);
        }
    }
}
