//! Linear algebra, rotations and rigid motions, nonlinear equations; independent of mechanics.

pub mod hermite;
pub mod lie;
pub mod linalg;
pub mod memory;
pub mod parallel;
pub mod pencil;
pub mod roots;
pub mod tape;
