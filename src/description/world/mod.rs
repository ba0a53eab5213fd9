//! The surroundings of a robot: the fluid, and the motion of its base.
//!
//! ```
//! use lissom::world::Fluid;
//!
//! let water = Fluid { drag_coefficients: [1.1, 0.01], ..Fluid::ideal(1000.0) };
//! water.validate()?;
//! # Ok::<(), lissom::error::InvalidInput>(())
//! ```

pub(crate) mod base_motion;
pub mod described;
mod prescribed;
pub(crate) mod smooth;

pub use crate::robot::effects::fluid::Fluid;
pub use base_motion::{BaseMotion, BaseRotation, quaternion_motion};
