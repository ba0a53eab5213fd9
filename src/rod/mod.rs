//! Cosserat rods with a strain parametrisation.

mod description;

pub use description::{MAX_COORDINATES, MAX_MODES, Rod, STRAIGHT, STRAIN_NAMES, STRAINS, Segment};
