//! Descriptions of robots, their equations of motion, and numerics. A crate of its own, which need not be compiled again when only
//! solvers and bindings change. Use the crate `lissom`, which exports the public items; items with `#[doc(hidden)]` are public for
//! that crate alone.

pub mod description;
pub mod error;
pub mod model;
pub mod numerics;
pub mod robot;
