//! The recursions along a rod.

pub(crate) mod acceleration;
mod adjoint;
pub(crate) mod by_inertia;
pub(crate) mod by_length;
pub(crate) mod elasticity;
pub(crate) mod energy;
pub(crate) mod hinge;
pub(crate) mod inputs;
pub(crate) mod inverse_dynamics;
pub(crate) mod kinematics;
pub(crate) mod lines;
pub(crate) mod lone_rod;
pub(crate) mod loops;
pub(crate) mod missing_strain;
pub(crate) mod momentum;
mod points;
pub(crate) mod section;
pub(crate) mod sizes;
pub(crate) mod tangent;
pub(crate) mod time;
pub(crate) mod tree;
pub(crate) mod validity;
