//! Inertias and linear responses about the origin; distances.

pub(crate) mod inertia;
pub(crate) mod response;
pub(crate) mod tie;
