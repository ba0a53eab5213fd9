//! Numbers of products of packs and of scalars.

use std::ops::AddAssign;

use crate::lie::LANES;

/// Products of packs and of single numbers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Products {
    /// Of packs.
    pub(crate) packs: u64,
    /// Of single numbers.
    pub(crate) singles: u64,
}

impl Products {
    /// Of doubles.
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
