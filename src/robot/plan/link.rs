//! Positions of the links of a robot in its plan.

use std::ops::Range;

use super::point::Offset;

/// Where a link is.
#[derive(Clone, Debug)]
pub(crate) struct LinkPlan {
    /// Its own pieces, of joint and rod; none where it is one with what it is welded to.
    pub(crate) pieces: Range<usize>,
    /// The pieces of its rod; none where it is rigid.
    pub(crate) rod: Range<usize>,
    /// The piece at whose end its base is, where it is rigid, and where the base is fixed beside that end.
    pub(crate) base: usize,
    pub(crate) beside: Option<Offset>,
}
