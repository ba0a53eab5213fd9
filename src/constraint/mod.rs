//! Equations of motion with constraints `g(q, t) = 0`, held by multipliers: `tau + G^T lambda = 0`, `G = dg/dq`.
//!
//! Constraints may be redundant: those of a mechanism in a plane that hinges of six rows close, or of one that passes a
//! singular position. [`Independent`] picks rows that determine the others; the others get no multipliers in a solve, and
//! hold by themselves where they do not conflict.

mod as_springs;
mod independent;
pub(crate) mod one_sided;
pub(crate) mod projection;
pub(crate) mod saddle;

pub(crate) use as_springs::AsSprings;
pub(crate) use independent::{Independent, inverse_length};
pub(crate) use saddle::{MassSaddle, Saddle};
