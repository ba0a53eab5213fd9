//! The crate through its public interface. A single program, because every test program compiles and links
//! the generic code of the crate again: `cargo test --test crate newmark::` runs one file of it.

mod actuators;
mod contact;
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
