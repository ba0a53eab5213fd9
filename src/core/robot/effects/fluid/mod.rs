//! The fluid around a rod, as plain data.

pub(crate) mod along_rods;
pub(crate) mod around_bodies;
pub(crate) mod compile;
pub(crate) mod plan;

use crate::description::schema::{Described, Item};
use crate::error::InvalidInput;

/// An unbounded fluid around the whole rod, with uniform and steady flow far from it.
///
/// By default, buoyancy and the added mass of a circular section in an inviscid fluid act, and there is no drag, because the
/// drag coefficients depend on the Reynolds number and the roughness of the rod. With the velocity of a section relative to the
/// fluid, ``v_n`` across the axis of the section and ``v_t`` along it, and the section's diameter d (that of the circle of the
/// same area) and area A, the fluid exerts per metre of the unstretched rod
///
/// ``- c_n v_n - c_t v_t - 1/2 density d (C_n |v_n| v_n + pi C_t |v_t| v_t)``
///
/// in drag (quadratic: Morison and others 1950; Taylor 1952), ``- d/dt (C_a density A v_n)`` and the moment
/// ``- v x C_a density A v_n`` by its added mass (Kirchhoff's equations; Lamb 1932, section 124), and its buoyancy.
#[derive(Clone, Debug, PartialEq, Described)]
#[part(positional = 2, example = include_str!("fluid_example.txt"))]
pub struct Fluid {
    /// Density.
    #[part(unit = "kg/m^3", non_negative)]
    pub density: f64,
    /// Velocity of the fluid far from the rod in world axes.
    #[part(unit = "m/s", default)]
    pub velocity: [f64; 3],
    /// ``c_n`` and ``c_t``: drag per length and velocity, across and along the axis.
    #[part(unit = "N s/m^2", non_negative, default)]
    pub viscous_drag: [f64; 2],
    /// ``C_n`` and ``C_t`` of the quadratic drag. Water around a smooth cable at Reynolds numbers from 1e3 to 1e5: about
    /// (1.2, 0.01).
    #[part(non_negative, default)]
    pub drag_coefficients: [f64; 2],
    /// ``C_a``: added mass across the axis, relative to the mass of the displaced fluid. One for a circle in an inviscid fluid.
    #[part(non_negative, default = 1.0)]
    pub added_mass_coefficient: f64,
    /// Whether buoyancy acts.
    #[part(key = "buoyancy", default = true)]
    pub is_buoyant: bool,
}

impl Fluid {
    /// An inviscid fluid at rest with buoyancy and the added mass of a circular rod: a start for `..` syntax.
    pub fn ideal(density: f64) -> Self {
        Self {
            density,
            velocity: [0.0; 3],
            viscous_drag: [0.0; 2],
            drag_coefficients: [0.0; 2],
            added_mass_coefficient: 1.0,
            is_buoyant: true,
        }
    }

    /// Reports every problem of this fluid.
    pub fn validate(&self) -> Result<(), InvalidInput> {
        Item::validate(self)
    }

    /// Whether the fluid exerts drag.
    pub(crate) fn has_drag(&self) -> bool {
        let is_quadratic = self.density > 0.0 && self.drag_coefficients != [0.0; 2];
        is_quadratic || self.viscous_drag != [0.0; 2]
    }

    /// Whether buoyancy acts under this gravity.
    pub(crate) fn has_buoyancy(&self, gravity: [f64; 3]) -> bool {
        self.is_buoyant && self.density > 0.0 && gravity != [0.0; 3]
    }

    pub(crate) fn has_added_mass(&self) -> bool {
        self.density * self.added_mass_coefficient > 0.0
    }
}
