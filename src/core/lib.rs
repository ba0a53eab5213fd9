//! Robots and what they are made of: numerics, descriptions, equations of motion. A crate of its own, so that it is compiled beside
//! solvers and bindings, and once when only these change. Use the crate `lissom`, which exports what is public;
//! what is `#[doc(hidden)]` is public for that crate alone.

pub mod description;
pub mod error;
pub mod model;
pub mod numerics;
pub mod robot;
