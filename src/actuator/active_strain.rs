//! Actuated reference strains: muscles, shape-memory wires, swimming gaits.

use crate::error::Checker;
use crate::rod::{Profile, STRAINS};
use crate::signal::Signal;

/// A reference strain `amount(t) shape(X)` of a rod, beside the one that its segments have: the material answers
/// `H (strain - reference)`.
#[derive(Clone, Debug, PartialEq)]
pub struct ActiveStrain {
    /// The name.
    pub name: String,
    /// The link, by its place among those of a robot.
    pub link: usize,
    /// The strain component, by its place among the six.
    pub strain: usize,
    /// Along the whole of the link's rod, in units of the strain for an amount of one.
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
