//! Actuated reference strains: muscles, shape-memory wires, swimming gaits.

use crate::description::rod::{Profile, STRAIN_NAMES};
use crate::description::schema::Described;
use crate::description::signal::Signal;

/// A reference strain `amount(t) shape(X)` of a rod, added to the reference strain of its segments: the
/// material's force is `H (strain - reference)`.
#[derive(Clone, Debug, PartialEq)]
pub struct ActiveStrain {
    /// The name.
    pub name: String,
    /// Index of the link in the robot.
    pub link: usize,
    /// The strain.
    pub strain: Strain,
    /// Shape along the whole rod of the link, in units of the strain per unit amount.
    pub shape: Profile<1>,
    /// The amplitude.
    pub amount: Signal<1>,
}

/// A component of the strain.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Described)]
pub enum Strain {
    /// Torsion about the rod's axis.
    Torsion,
    /// Bending about the y axis.
    BendY,
    /// Bending about the z axis.
    BendZ,
    /// Stretch along the rod.
    Stretch,
    /// Shear along the y axis.
    ShearY,
    /// Shear along the z axis.
    ShearZ,
}

impl Strain {
    /// Its name.
    pub fn name(self) -> &'static str {
        STRAIN_NAMES[self as usize]
    }
}
