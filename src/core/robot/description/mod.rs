//! Robots as plain data: a tree of links, with loads, actuators, loops and contacts. A rod is a robot with
//! one link that is welded to the world.

mod actuation;
mod carriers;
pub mod described;
mod driven;
mod given;
mod inertia;
mod link;
mod mimic;
mod named;
mod names;
mod robot;
mod rod;
mod span;
mod timed;

pub use actuation::Inputs;
pub use driven::Driven;
pub use given::GivenSignal;
pub use link::Link;
pub use mimic::{Origin, origin};
pub use robot::{MAX_COORDINATES, Robot};
pub use rod::Rod;
pub use span::Spans;
