//! What surrounds a robot: the fluid, and the motion of what it stands on.

pub(crate) mod base_motion;
mod fluid;
mod prescribed;
pub(crate) mod smooth;

pub use base_motion::{BaseMotion, BaseRotation, quaternion_motion};
pub use fluid::Fluid;
