//! Equilibria, vibrations, inverse kinematics and inverse statics.

pub mod actuate;
pub(crate) mod at_rest;
pub mod curve;
pub(crate) mod growing;
pub mod modes;
pub(crate) mod normalised;
pub mod reach;
pub(crate) mod refined;
pub mod refined_modes;
pub(crate) mod small_motions;
pub(crate) mod spectrum;
pub(crate) mod spring_forces;
pub mod stability;
pub mod statics;
pub(crate) mod ties;
pub(crate) mod unresolved_vibrations;
pub(crate) mod weakly_active;
