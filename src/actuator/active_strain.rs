//! Actuated reference strains: muscles, shape-memory wires, swimming gaits.

use crate::error::Checker;
use crate::rod::{Profile, STRAINS};
use crate::signal::Signal;

/// A reference strain `amount(t) shape(X)` of a rod, added to the reference strain of its segments: the
/// material's force is `H (strain - reference)`.
#[derive(Clone, Debug, PartialEq)]
pub struct ActiveStrain {
    /// The name.
    pub name: String,
    /// Index of the link in the robot.
    pub link: usize,
    /// Index of the strain component (0 to 5).
    pub strain: usize,
    /// Shape along the whole rod of the link, in units of the strain per unit amount.
    pub shape: Profile<1>,
    /// The amplitude.
    pub amount: Signal<1>,
}

impl ActiveStrain {
    pub(super) fn check(&self, check: &mut Checker) {
        check.require(self.strain < STRAINS, "strain", self.strain, "the place of a strain component");
        self.amount.check(check, "amount");
    }
}
