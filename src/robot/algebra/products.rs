//! Numbers of products of packs and of scalars.

use std::ops::AddAssign;

use crate::lie::LANES;

/// Numbers of products of packs and of scalars.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Products {
    /// Products of packs.
    pub(crate) packs: u64,
    /// Products of scalars.
    pub(crate) singles: u64,
}

impl Products {
    /// Total number of products of doubles.
    pub(crate) fn total(self) -> u64 {
        LANES as u64 * self.packs + self.singles
    }
}

impl AddAssign for Products {
    fn add_assign(&mut self, other: Self) {
        self.packs += other.packs;
        self.singles += other.singles;
    }
}
