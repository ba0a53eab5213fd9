//! The recursions along a rod.

pub(crate) mod chain;
pub(crate) mod energy;
pub(crate) mod inverse_dynamics;
pub(crate) mod kinematics;
mod shape;
pub(crate) mod tangent;
pub(crate) mod time;
pub(crate) mod validity;
