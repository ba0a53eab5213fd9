//! Sections: stiffness and inertia per length at a place of a segment.
//!
//! `shape` knows plane figures, `torsion` the rectangle's torsion constant, `given` what is not computed from a figure.

pub(crate) mod along;
mod given;
mod properties;
mod shape;
mod torsion;

pub use given::GivenSection;
pub use properties::{SectionProperties, diagonal};
pub use shape::Shape;

use std::convert::Infallible;

use crate::error::{Checker, InvalidInput};
use crate::rod::profile::{Profile, Variation};
use crate::rod::strain::STRAINS;

/// What a segment looks like across.
#[derive(Clone, Debug, PartialEq)]
pub enum Section {
    /// A plane figure of the segment's material, its sizes in metres.
    Shape(Shape<Profile<1>>),
    /// Stiffness and inertia as they are.
    Given(Box<GivenSection>),
}

impl Section {
    /// A circle with these radii at base and tip, in metres, linear in between.
    pub fn circle(radius: [f64; 2]) -> Self {
        Self::Shape(Shape::Circle { radius: Profile::linear(radius.map(|radius| [radius])) })
    }

    /// Whether it is the same everywhere.
    pub fn is_constant(&self) -> bool {
        match self {
            Self::Shape(shape) => shape.is_constant(),
            Self::Given(given) => given.is_constant(),
        }
    }

    /// How its numbers vary, of those that do.
    pub(crate) fn variations(&self) -> Vec<Variation<'_>> {
        match self {
            Self::Shape(shape) => shape.variations(),
            Self::Given(given) => given.variations(),
        }
    }

    /// How far it reaches from the rod's axis along y and along z at the fraction `x` in [0, 1] of the segment, in
    /// metres: for pictures and slenderness. Of a given section that of the ellipse with its radii of gyration.
    pub fn half_extents(&self, x: f64) -> [f64; 2] {
        match self {
            Self::Shape(shape) => shape.at(x).half_extents(),
            Self::Given(given) => {
                let given = given.at(x);
                // An ellipse's radius of gyration is half its semi-axis. What reaches along y turns about z.
                [2, 1].map(|axis| 2.0 * (given.inertia[axis][axis] / given.mass).sqrt())
            }
        }
    }

    /// Everything that is wrong with this section by itself, along a segment of this length in metres.
    pub fn validate(&self, length: f64) -> Result<(), InvalidInput> {
        match self {
            Self::Shape(shape) => shape.validate(length),
            Self::Given(given) => given.validate(length),
        }
    }

    /// Notes everything that is wrong with this section in a segment of this length with these modes.
    pub(crate) fn check(&self, check: &mut Checker, length: f64, modes: &[usize; STRAINS]) {
        match self {
            // A circle is known by its radius alone.
            Self::Shape(Shape::Circle { .. }) => check.all(self.validate(length)),
            Self::Shape(_) => _ = check.nested("section", self.validate(length)),
            Self::Given(given) => {
                if check.nested("section", self.validate(length)).is_some() {
                    check.nested("section", given.validate_stiffness(length, modes));
                }
            }
        }
    }

    /// Whether its stiffness is a polynomial along the rod between any two stations, of a circle the fourth power of
    /// the radius.
    pub(crate) fn is_polynomial(&self) -> bool {
        !matches!(
            self,
            Self::Shape(Shape::HollowCircle { .. } | Shape::Rectangle { .. } | Shape::Ellipse { .. })
        ) || self.is_constant()
    }

    /// Degree of the polynomials, between any two stations, that mass and inertia per length are. Of a shape whose
    /// sizes follow functions that of a polynomial that follows to rounding: less than sizes to the fourth power
    /// could have.
    pub(crate) fn degree_of_inertia(&self) -> usize {
        let shape = match self {
            Self::Given(given) => return given.degree_of_inertia(),
            Self::Shape(shape) => shape,
        };
        let variations = shape.variations();
        let degree = 4 * variations.iter().map(|variation| variation.degree).max().unwrap_or(0);
        if degree <= 4 || variations.iter().any(|variation| !variation.stations.is_empty()) {
            return degree;
        }
        let followed = Profile::sampled(|x| {
            let shape = shape.at(x);
            let [about_y, about_z] = shape.second_moments();
            Ok::<_, Infallible>([shape.area(), about_y, about_z])
        });
        followed.map_or(degree, |polynomial| polynomial.degree().min(degree))
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
