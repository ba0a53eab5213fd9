//! What acts on a robot: one file an effect.

pub(crate) mod anchor;
pub(crate) mod elasticity;
pub(crate) mod immersion;
pub(crate) mod point_tangent;
pub(crate) mod points;
pub(crate) mod spread;
