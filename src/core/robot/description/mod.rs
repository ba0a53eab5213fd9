//! Robots as plain data: a tree of links, with loads, actuators, loops and contacts. A rod is a robot with
//! one link that is welded to the world.

mod actuation;
mod carriers;
pub mod described;
mod driven;
mod inertia;
mod length;
mod link;
mod mimic;
mod named;
mod names;
mod robot;
mod rod;
mod signals;
mod span;
mod timed;

pub use actuation::Inputs;
pub use driven::Driven;
pub use link::Link;
pub use mimic::{Origin, origin};
pub use robot::{MAX_COORDINATES, Robot};
pub use rod::Rod;
pub use signals::SignalOf;
pub use span::Spans;
pub(crate) use span::Tightness;
