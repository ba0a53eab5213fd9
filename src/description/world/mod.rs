//! Prescribed motions of bases.

pub(crate) mod base_motion;
pub mod described;
mod prescribed;
pub(crate) mod smooth;

pub use base_motion::{BaseMotion, BaseRotation, quaternion_motion};
