//! Loads that are spread along a part of the rod.

use super::load::{Extent, Frame};
use super::plan::{Load, Plan, SegmentPlan, packed};
use super::turning::Turning;
use super::workspace::Workspace;
use crate::lie::Wrench;

/// What of a load acts on one segment.
#[derive(Clone, Debug)]
pub(super) struct Spread<G: Turning> {
    pub(super) load: usize,
    /// How densely it acts at the nodes: for the integral over the part of the segment between two places,
    /// `sum_l (u_l(to) - u_l(from)) f_l`, the differences of the weights over the quadrature weights.
    pub(super) density: Vec<G::Pack>,
}

/// Tells the segments what is spread along them.
pub(super) fn compile<G: Turning>(segments: &mut [SegmentPlan<G>], loads: &[Load<G>]) {
    let mut start = 0.0;
    for segment in segments {
        let end = start + segment.length;
        let mut integral = None;
        for (load, Load { extent, .. }) in loads.iter().enumerate() {
            let &Extent::Along([from, to]) = extent else { continue };
            if to <= start || from >= end {
                continue;
            }
            let gauss = &segment.gauss;
            let integral = integral.get_or_insert_with(|| gauss.integral());
            let up_to = |x: f64| integral.weights_up_to(((x - start) / segment.length).clamp(0.0, 1.0));
            let (from, to) = (up_to(from), up_to(to));
            let density = packed(from.len(), |i| (to[i] - from[i]) / gauss.weights[i]);
            segment.spread.push(Spread { load, density });
        }
        start = end;
    }
}

impl<G: Turning> Spread<G> {
    /// Whether the load keeps its direction in the world.
    #[inline(always)]
    pub(super) fn is_dead(&self, plan: &Plan<G>) -> bool {
        plan.loads[self.load].frame == Frame::World
    }

    /// The wrench per length at the nodes of a pack, about these nodes.
    #[inline(always)]
    pub(super) fn wrench(
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

/// Takes the spread loads off what the motion of a segment needs.
#[inline(always)]
pub(super) fn act<G: Turning>(plan: &Plan<G>, segment: &SegmentPlan<G>, work: &mut Workspace<G>) {
    for spread in &segment.spread {
        for pack in 0..segment.packs {
            let node = segment.first_pack + pack;
            let wrench = spread.wrench(plan, work, pack, &work.rotation[node]);
            work.force[node] = work.force[node] - wrench.at(work.position[node]);
        }
    }
}
