//! Circular sections: stiffness and inertia per length at a place of a segment.

use std::f64::consts::PI;

use super::description::{STRAINS, Segment};

/// What a section gives to the rod at one X.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Section {
    /// Stiffness per length of each strain: diag(G J, E I, E I, E A, k_s G A, k_s G A).
    pub stiffness: [f64; STRAINS],
    /// Area A, in m^2.
    pub area: f64,
    /// Mass per length rho A, in kg/m.
    pub mass: f64,
    /// Rotary inertia per length about a diameter, rho I, in kg m; about the axis it is twice that.
    pub rotary_inertia: f64,
}

impl Section {
    /// The section of `segment` at the fraction `x` in [0, 1] of its length.
    pub fn at(segment: &Segment, x: f64) -> Self {
        let radius = segment.radius[0] + (segment.radius[1] - segment.radius[0]) * x;
        let area = PI * radius.powi(2);
        let second_moment = PI * radius.powi(4) / 4.0;
        let polar_moment = 2.0 * second_moment;
        let (young, shear) = (segment.young_modulus, segment.shear_modulus);
        Self {
            stiffness: [
                shear * polar_moment,
                young * second_moment,
                young * second_moment,
                young * area,
                segment.shear_correction * shear * area,
                segment.shear_correction * shear * area,
            ],
            area,
            mass: segment.density * area,
            rotary_inertia: segment.density * second_moment,
        }
    }
}
