//! Prescribed motions of bases.

pub(crate) mod base_motion;
pub mod described;
mod prescribed;
pub(crate) mod smooth;

pub use base_motion::{BaseMotion, BaseRotation, quaternion_motion};

/// Acceleration of gravity by default, in m/s^2: the value of textbooks, along -z.
pub const STANDARD_GRAVITY: [f64; 3] = [0.0, 0.0, -9.81];
