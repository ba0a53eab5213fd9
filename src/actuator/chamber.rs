//! Fluidic chambers along rods.

use super::path::Along;
use crate::error::Checker;
use crate::signal::Signal;

/// A chamber along rods with caps at its ends. Its area is that of its cut with the sections, so that its volume is
/// `V = A int u_x dX` with the slope u of its middle line in the axes of the section, and the generalised forces of a
/// pressure p, `p dV/dq`, do not depend on q.
#[derive(Clone, Debug, PartialEq)]
pub struct Chamber {
    /// The name.
    pub name: String,
    /// Its way.
    pub path: Vec<Along>,
    /// Area A of its cut with the section, in m^2.
    pub area: f64,
    /// Pressure over that around, in pascals.
    pub pressure: Signal<1>,
}

impl Chamber {
    pub(super) fn check(&self, check: &mut Checker) {
        check.require(!self.path.is_empty(), "path", "no parts", "a part along a rod");
        for (i, along) in self.path.iter().enumerate() {
            check.nested(&format!("path[{i}]"), along.validate());
        }
        check.positive(self.area, "area", "square metres");
        self.pressure.check(check, "pressure");
    }
}
