//! Positions of the links of a robot in its plan.

use std::ops::Range;

use super::point::Offset;

/// Position of a link in the plan.
#[derive(Clone, Debug)]
pub(crate) struct LinkPlan {
    /// Pieces of the link, of joint and rod; empty if it is merged with the link to which it is welded.
    pub(crate) pieces: Range<usize>,
    /// Pieces of its rod; empty for a rigid link.
    pub(crate) rod: Range<usize>,
    /// For a rigid link, the piece at whose end its base is located, and the offset of the base from that
    /// end.
    pub(crate) base: usize,
    pub(crate) beside: Option<Offset>,
}
