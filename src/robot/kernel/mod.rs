//! The recursions along a rod.

pub(crate) mod chain;
pub(crate) mod elasticity;
pub(crate) mod energy;
pub(crate) mod inverse_dynamics;
pub(crate) mod kinematics;
mod points;
mod shape;
pub(crate) mod tangent;
pub(crate) mod time;
pub(crate) mod validity;
