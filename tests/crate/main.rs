//! The crate as its users see it. One program, because every test program is compiled and linked with the crate's generic code
//! once more: `cargo test --test crate newmark::` runs one file of it.

mod actuators;
mod limits;
mod newmark;
mod ode;
mod pendulum;
mod radau;
mod rod;
mod roots;
mod scene;
mod statics;
mod stepping;
mod surroundings;
mod tree;
