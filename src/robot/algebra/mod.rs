//! Inertias and linear responses about the origin; distances.

pub(crate) mod convex_mesh;
pub(crate) mod distance;
pub(crate) mod edge;
pub(crate) mod ellipse;
pub(crate) mod elliptic_tube;
pub(crate) mod height_field;
pub(crate) mod inertia;
pub(crate) mod obstacle;
pub(crate) mod response;
pub(crate) mod tie;
pub(crate) mod touch;
