//! Sections: stiffness and inertia per length at a place of a segment.
//!
//! `shape` knows plane figures, `torsion` the rectangle's torsion constant, `given` what is not computed from a figure.

mod given;
mod shape;
mod torsion;

pub use given::GivenSection;
pub use shape::Shape;

use super::body;
use super::description::{STRAINS, Segment};
use crate::error::{Checker, InvalidInput};

/// What a segment looks like across.
#[derive(Clone, Debug, PartialEq)]
pub enum Section {
    /// A plane figure of the segment's material, its sizes linear between base and tip.
    Shape(Shape<[f64; 2]>),
    /// Stiffness and inertia as they are.
    Given(Box<GivenSection>),
}

impl Section {
    /// A circle with these radii at base and tip, in metres.
    pub fn circle(radius: [f64; 2]) -> Self {
        Self::Shape(Shape::Circle { radius })
    }

    /// Whether it is the same everywhere.
    pub fn is_constant(&self) -> bool {
        match self {
            Self::Shape(shape) => shape.is_constant(),
            Self::Given(_) => true,
        }
    }

    /// How far it reaches from the rod's axis along y and along z at the fraction `x` in [0, 1] of the segment, in metres: for
    /// pictures and slenderness. Of a given section that of the ellipse with its radii of gyration.
    pub fn half_extents(&self, x: f64) -> [f64; 2] {
        match self {
            Self::Shape(shape) => shape.at(x).half_extents(),
            Self::Given(given) => {
                // An ellipse's radius of gyration is half its semi-axis. What reaches along y turns about z.
                [2, 1].map(|axis| 2.0 * (given.inertia[axis][axis] / given.mass).sqrt())
            }
        }
    }

    /// Everything that is wrong with this section by itself.
    pub fn validate(&self) -> Result<(), InvalidInput> {
        match self {
            Self::Shape(shape) => {
                let mut check = Checker::new();
                shape.check(&mut check);
                check.finish()
            }
            Self::Given(given) => given.validate(),
        }
    }

    /// Notes everything that is wrong with this section in a segment with these modes.
    pub(super) fn check(&self, check: &mut Checker, modes: &[usize; STRAINS]) {
        match self {
            // A circle is known by its radius alone.
            Self::Shape(Shape::Circle { .. }) => check.all(self.validate()),
            Self::Shape(_) => _ = check.nested("section", self.validate()),
            Self::Given(given) => {
                if check.nested("section", self.validate()).is_some() {
                    given.check_stiffness(check, modes);
                }
            }
        }
    }

    /// Whether its stiffness is a polynomial along the rod, of degree four at most.
    pub(super) fn is_polynomial(&self) -> bool {
        matches!(self, Self::Shape(Shape::Circle { .. })) || self.is_constant()
    }
}

/// Factors by which the shear stiffness is less than G A.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ShearCorrection {
    /// Of shear along y and along z.
    Factors([f64; 2]),
    /// Those of Cowper (1966) for the shape and Poisson's ratio ([`Shape::cowper`]).
    Cowper,
}

impl From<f64> for ShearCorrection {
    fn from(factor: f64) -> Self {
        Self::Factors([factor; 2])
    }
}

/// What a section gives to the rod at one place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SectionProperties {
    /// Stiffness per length of the strains, [`super::STRAIN_NAMES`]: of a shape diag(G J_t, E I_y, E I_z, E A, k_y G A, k_z G A).
    pub stiffness: [[f64; STRAINS]; STRAINS],
    /// Area within its outline in m^2, that of a hollow circle's hole included: what a fluid makes way for. Zero of a given section.
    pub outline_area: f64,
    /// Mass per length in kg/m: rho A.
    pub mass: f64,
    /// Centre of mass seen from the rod's axis, in the section's axes, in metres.
    pub centre: [f64; 3],
    /// Inertia tensor per length about the centre of mass, in the section's axes, in kg m: of a shape
    /// rho diag(I_y + I_z, I_y, I_z), with the polar moment in place of the torsion constant.
    pub inertia: [[f64; 3]; 3],
}

impl SectionProperties {
    /// Those of `segment` at the fraction `x` in [0, 1] of its length.
    pub fn at(segment: &Segment, x: f64) -> Self {
        match &segment.section {
            Section::Shape(shape) => Self::of_shape(segment, &shape.at(x)),
            Section::Given(given) => {
                let [y, z] = given.centre;
                Self {
                    stiffness: given.stiffness,
                    outline_area: 0.0,
                    mass: given.mass,
                    centre: [0.0, y, z],
                    inertia: given.inertia,
                }
            }
        }
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

    /// The matrix that takes a twist of the section, (angular velocity; velocity of the rod's axis), to its momentum per length.
    pub fn inertia_matrix(&self) -> [[f64; 6]; 6] {
        let rotary = self.inertia_about_axis();
        let [x, y, z] = self.centre.map(|offset| self.mass * offset);
        let turned = [[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]];
        std::array::from_fn(|i| {
            std::array::from_fn(|j| match (i < 3, j < 3) {
                (true, true) => rotary[i][j],
                (true, false) => turned[i][j - 3],
                (false, true) => -turned[i - 3][j],
                (false, false) => f64::from(u8::from(i == j)) * self.mass,
            })
        })
    }

    /// Inertia tensor per length about the rod's axis.
    pub(super) fn inertia_about_axis(&self) -> [[f64; 3]; 3] {
        body::carried_inertia(self.mass, self.centre, &self.inertia)
    }
}

/// The diagonal matrix with these entries.
pub fn diagonal<const N: usize>(entries: [f64; N]) -> [[f64; N]; N] {
    std::array::from_fn(|i| std::array::from_fn(|j| if i == j { entries[i] } else { 0.0 }))
}
