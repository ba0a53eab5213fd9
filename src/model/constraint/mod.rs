//! Equations of motion with constraints `g(q, t) = 0`, held by multipliers: `tau + G^T lambda = 0`, `G = dg/dq`.
//!
//! Constraints may be redundant, as those of a planar mechanism whose loops are closed by hinges with six
//! rows, or of a mechanism at a singular position. [`Independent`] selects independent rows; the other rows
//! get no multipliers, and are satisfied automatically unless they conflict.

pub(crate) mod closing;
mod independent;
pub(crate) mod one_sided;
pub(crate) mod projection;
pub(crate) mod saddle;

pub(crate) use independent::{Independent, inverse_length};
pub(crate) use saddle::Saddle;
