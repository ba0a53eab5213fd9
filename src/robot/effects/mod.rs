//! Effects that act on a robot: one folder per effect, listed in [`all`]. The sweeps use only the traits in [`kinds`].

pub mod actuator;
pub(crate) mod all;
pub mod contact;
pub mod fluid;
pub(crate) mod joint_forces;
pub(crate) mod kinds;
pub mod load;
pub mod loops;
pub mod magnet;
pub mod support;
