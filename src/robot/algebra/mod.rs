//! Inertia and responses of bodies, seen from the origin.

pub(crate) mod inertia;
pub(crate) mod obstacle;
pub(crate) mod products;
pub(crate) mod response;
pub(crate) mod tie;
pub(crate) mod touch;
