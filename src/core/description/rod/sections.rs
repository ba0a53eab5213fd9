//! Sections of a segment: stiffness and inertia at its points.

use super::section::along::{LARGEST, SMALLEST};
use super::section::{Section, SectionProperties, Shape, ShearCorrection, along, diagonal};
use super::segment::Segment;
use super::strain::STRAIN_NAMES;
use crate::error::{Checker, InvalidInput, Number};

impl SectionProperties {
    /// Properties of `segment` at the fraction `x` in [0, 1] of its length.
    pub fn at(segment: &Segment, x: f64) -> Self {
        match &segment.section {
            Section::Shape(shape) => Self::of_shape(segment, &shape.at(x)),
            Section::Given(given) => given.at(x),
        }
    }

    /// Reports problems of combined values of `segment`, whose parts are valid separately: stiffness or mass
    /// that overflows or vanishes.
    pub(crate) fn validate(segment: &Segment) -> Result<(), InvalidInput> {
        let refuse = |check: &mut Checker, found: String| {
            let numbers = format!("numbers between {SMALLEST:e} and {LARGEST:e} in SI units");
            check.refuse("section", found, format!("sizes and material that give {numbers}"));
        };
        along::validate_along(&segment.section.variations(), segment.length, |x| {
            let Self { stiffness, mass, inertia, .. } = Self::at(segment, x);
            let mut check = Checker::new();
            for (strain, name) in STRAIN_NAMES.into_iter().enumerate() {
                let diagonal = stiffness[strain][strain];
                let is_stiff = segment.modes[strain] == 0 || diagonal >= SMALLEST;
                if !is_stiff || !stiffness[strain].iter().all(|entry| entry.abs() <= LARGEST) {
                    refuse(&mut check, format!("a stiffness of {} against {name}", Number(diagonal)));
                }
            }
            if !(SMALLEST..=LARGEST).contains(&mass) {
                refuse(&mut check, format!("a mass of {} kg/m", Number(mass)));
            }
            if !inertia.iter().flatten().all(|entry| entry.abs() <= LARGEST) {
                let largest =
                    inertia.iter().flatten().fold(0.0_f64, |largest, entry| largest.max(entry.abs()));
                refuse(&mut check, format!("a moment of inertia of {} kg m", Number(largest)));
            }
            check.finish()
        })
    }

    fn of_shape(segment: &Segment, shape: &Shape<f64>) -> Self {
        let (young, shear, density) = (segment.young_modulus, segment.shear_modulus, segment.density);
        let area = shape.area();
        let [about_y, about_z] = shape.second_moments();
        let [shear_y, shear_z] = match segment.shear_correction {
            ShearCorrection::Factors(factors) => factors,
            ShearCorrection::Cowper => shape.cowper(segment.poisson_ratio()),
        };
        Self {
            stiffness: diagonal([
                shear * shape.torsion_constant(),
                young * about_y,
                young * about_z,
                young * area,
                shear_y * shear * area,
                shear_z * shear * area,
            ]),
            outline_area: shape.outline_area(),
            mass: density * area,
            centre: [0.0; 3],
            inertia: diagonal([density * about_y + density * about_z, density * about_y, density * about_z]),
        }
    }
}
