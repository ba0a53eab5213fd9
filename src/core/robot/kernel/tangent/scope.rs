//! Context of the steps of a tangent.

use crate::robot::plan::Plan;
use crate::robot::plan::piece::PiecePlan;
use crate::robot::state::Workspace;
use crate::robot::state::tangent::Weights;
use crate::robot::turning::Turning;

/// The current piece, and which terms it needs.
pub(super) struct Scope<'a, G: Turning> {
    pub(super) plan: &'a Plan<G>,
    pub(super) piece: &'a PiecePlan<G>,
    pub(super) work: &'a Workspace<G>,
    pub(super) weights: Weights,
    /// Whether there are points inside the piece.
    pub(super) has_points: bool,
    /// Whether dead loads act along the piece and matter.
    pub(super) has_dead: bool,
    /// Whether there are responses along the piece.
    pub(super) has_responses: bool,
}
