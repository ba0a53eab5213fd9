//! The fluid around a rod, as plain data.

use crate::error::{Checker, InvalidInput};

/// A fluid of infinite extent around the whole rod, uniform and steady far from it.
///
/// Let `v_n` and `v_t` be the velocities of a section relative to the fluid, perpendicular to and along its
/// axis, rho the fluid's density, A the section's area and d the diameter of the circle with the same area.
/// Per metre of the unstretched rod, the fluid exerts
///
/// ```text
/// - c_n v_n - c_t v_t                                              viscous drag
/// - 1/2 rho d (C_n |v_n| v_n + pi C_t |v_t| v_t)                   quadratic drag (Morison and others 1950; Taylor 1952)
/// - d/dt (C_a rho A v_n), and the moment - v x C_a rho A v_n       added mass (Kirchhoff's equations; Lamb 1932, section 124)
/// - rho A g                                                        buoyancy
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Fluid {
    /// Density rho in kg/m^3.
    pub density: f64,
    /// Velocity of the fluid far from the rod, in the world, in m/s.
    pub velocity: [f64; 3],
    /// Viscous drag per length and velocity, perpendicular to the axis and along it, `c_n` and `c_t`, in N
    /// s/m^2.
    pub viscous_drag: [f64; 2],
    /// Coefficients of the quadratic drag, perpendicular to the axis and along it, `C_n` and `C_t`.
    pub drag_coefficients: [f64; 2],
    /// Coefficient of the added mass, `C_a`; one for a circle in an inviscid fluid.
    pub added_mass_coefficient: f64,
    /// Whether buoyancy acts on the rod.
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
        let mut check = Checker::new();
        check.non_negative(self.density, "density", "kg/m^3");
        check.finite(&self.velocity, "velocity");
        for (i, value) in self.viscous_drag.into_iter().enumerate() {
            check.non_negative(value, &format!("viscous_drag[{i}]"), "N s/m^2");
        }
        for (i, value) in self.drag_coefficients.into_iter().enumerate() {
            check.non_negative(value, &format!("drag_coefficients[{i}]"), "no unit");
        }
        check.non_negative(self.added_mass_coefficient, "added_mass_coefficient", "no unit");
        check.finish()
    }

    /// Whether the fluid exerts drag.
    pub(crate) fn has_drag(&self) -> bool {
        let is_quadratic = self.density > 0.0 && self.drag_coefficients != [0.0; 2];
        is_quadratic || self.viscous_drag != [0.0; 2]
    }

    /// Whether buoyancy acts under this gravity.
    pub(crate) fn bears(&self, gravity: [f64; 3]) -> bool {
        self.is_buoyant && self.density > 0.0 && gravity != [0.0; 3]
    }

    pub(crate) fn has_added_mass(&self) -> bool {
        self.density * self.added_mass_coefficient > 0.0
    }
}
