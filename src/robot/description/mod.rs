//! Robots as plain data: a tree of links, with loads, actuators, loops and contacts. A rod is a robot with
//! one link that is welded to the world.

mod actuation;
mod carriers;
mod driven;
mod link;
mod mimic;
mod named;
mod names;
mod robot;
mod rod;
mod span;

pub use actuation::Inputs;
pub use driven::Driven;
pub use link::{Link, described};
pub(crate) use mimic::{Origin, origin};
pub(crate) use named::{LinkNames, Named};
pub(crate) use names::number_default_names;
pub use robot::{MAX_COORDINATES, Robot};
pub use rod::Rod;
pub(crate) use span::Spans;
