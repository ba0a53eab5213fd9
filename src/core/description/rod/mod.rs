//! Rods as plain data: segments with their sections, strain modes and reference strains.
//!
//! ```
//! use lissom::rod::Segment;
//!
//! let wire = Segment { modes: [0, 3, 0, 0, 0, 0], ..Segment::straight(1.0, 1e-3, 210e9, 80e9, 7800.0) };
//! wire.validate()?;
//! assert_eq!(wire.coordinates(), 3);
//! # Ok::<(), lissom::error::InvalidInput>(())
//! ```

#[doc(hidden)]
pub mod arc_length;
mod basis;
pub(crate) mod nodes;
#[doc(hidden)]
pub mod piece;
mod profile;
mod quadrature;
pub(crate) mod section;
mod sections;
mod segment;
pub(crate) mod stiffness;
mod strain;
mod validation;

/// Segments and sections as users describe them.
pub mod described {
    pub use super::profile::Size;
    pub use super::section::described::{Circle, Ellipse, Given, HollowCircle, Rectangle, Section};
    pub use super::segment::described::{ModeChoice, Modes, Segment};
}

pub use basis::{Basis, legendre};
pub use nodes::reference_turns;
pub use profile::{MAX_DEGREE, MAX_STATIONS, Parts, Profile, Unsampled};
pub use quadrature::{Gauss, Integral};
pub use section::{GivenSection, Section, SectionProperties, Shape, ShearCorrection, diagonal};
pub use segment::{Allowable, MAX_MODES, MAX_NODES, MAX_OWN_NODES, Segment, shear_modulus};
pub use stiffness::generalised_stiffness;
pub use strain::{STRAIGHT, STRAIN_NAMES, STRAINS};
