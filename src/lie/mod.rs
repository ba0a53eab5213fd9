//! SO(3) and SE(3): vectors, rotations, twists and wrenches.
//!
//! Everything is generic over a [`Scalar`]: `f64` for one point of a rod, [`Pack`] for several points at once.
//! Twists are (angular; linear) and wrenches (moment; force), both seen from the origin of the inertial frame.

mod pack;
mod rotation;
mod symmetric;
mod twist;
mod vector;

pub use pack::{LANES, Pack, Packed, Scalar, weighted_sum};
pub use rotation::{Quaternion, Rotation};
pub use symmetric::Symmetric;
pub use twist::{Twist, Wrench};
pub use vector::Vector;
