//! Linear algebra, rotations and rigid motions, nonlinear equations: what does not know of mechanics.

pub(crate) mod hermite;
pub mod lie;
pub mod linalg;
pub(crate) mod memory;
pub mod parallel;
pub(crate) mod pencil;
pub mod roots;
pub(crate) mod tape;
