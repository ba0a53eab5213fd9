//! Equilibria, vibrations, and what is needed to reach a pose.

pub mod actuate;
pub(crate) mod at_rest;
pub mod curve;
pub(crate) mod growing;
pub mod modes;
pub(crate) mod natural;
pub mod reach;
pub(crate) mod reached;
pub(crate) mod refined;
pub(crate) mod settled;
pub(crate) mod small_motions;
pub(crate) mod spectrum;
pub mod stability;
pub mod statics;
pub(crate) mod ties;
pub(crate) mod unseen;
