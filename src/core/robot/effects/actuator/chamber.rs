//! Fluidic chambers along rods.

use super::path::Along;
use crate::description::signal::Signal;

/// A chamber along rods with caps at its ends. With the constant area A of its cross-section in the section's
/// plane, its volume is `V = A int u_x dX` with the slope u of its middle line in the section's axes. The
/// generalised forces of a pressure p, `p dV/dq`, then do not depend on q.
#[derive(Clone, Debug, PartialEq)]
pub struct Chamber {
    /// The name.
    pub name: String,
    /// Path of the chamber.
    pub path: Vec<Along>,
    /// Area A of the chamber in the section's plane, in m^2.
    pub area: f64,
    /// Pressure above that of the surroundings, in pascals.
    pub pressure: Signal<1>,
}
