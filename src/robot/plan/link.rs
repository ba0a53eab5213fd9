//! Where the links of a robot are in its plan.

use std::ops::Range;

/// Where a link is.
#[derive(Clone, Debug)]
pub(crate) struct LinkPlan {
    /// Its first piece: the one at whose end its base is, where it has none of its own.
    pub(crate) first: usize,
    /// The pieces of its rod; none where it is rigid.
    pub(crate) rod: Range<usize>,
    /// The piece at whose end its base is, where it is rigid.
    pub(crate) base: usize,
}
