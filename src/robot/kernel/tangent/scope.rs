//! What the steps of a tangent work on.

use crate::robot::plan::Plan;
use crate::robot::plan::piece::PiecePlan;
use crate::robot::state::Workspace;
use crate::robot::state::tangent::Weights;
use crate::robot::turning::Turning;

/// The piece at hand, and what there is to be done for it.
pub(super) struct Scope<'a, G: Turning> {
    pub(super) plan: &'a Plan<G>,
    pub(super) piece: &'a PiecePlan<G>,
    pub(super) work: &'a Workspace<G>,
    pub(super) weights: Weights,
    /// Whether points lie inside it.
    pub(super) has_points: bool,
    /// Whether wrenches along it keep their direction, and matter.
    pub(super) has_dead: bool,
    /// Whether anything responds along it.
    pub(super) has_responses: bool,
}
