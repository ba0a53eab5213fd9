//! Sections: stiffness and inertia per length at a point of a segment.
//!
//! `shape` contains plane figures, `torsion` the torsion constant of rectangles, `given` sections with given
//! properties.

pub(crate) mod along;
pub(crate) mod described;
mod given;
mod properties;
mod shape;
mod torsion;

pub use given::GivenSection;
pub use properties::{SectionProperties, diagonal};
pub use shape::Shape;

use std::convert::Infallible;

use crate::description::rod::profile::{Profile, Variation};
use crate::description::rod::strain::STRAINS;
use crate::error::{Checker, InvalidInput};

/// Cross-section of a segment.
#[derive(Clone, Debug, PartialEq)]
pub enum Section {
    /// A plane figure of the segment's material, with sizes in metres.
    Shape(Shape<Profile<1>>),
    /// Given stiffness and inertia.
    Given(Box<GivenSection>),
}

impl Section {
    /// A circle with these radii at base and tip, in metres, linear in between.
    pub fn circle(radius: [f64; 2]) -> Self {
        Self::Shape(Shape::Circle { radius: Profile::linear(radius.map(|radius| [radius])) })
    }

    /// Whether the section is constant.
    pub fn is_constant(&self) -> bool {
        match self {
            Self::Shape(shape) => shape.is_constant(),
            Self::Given(given) => given.is_constant(),
        }
    }

    /// Variations of the non-constant properties.
    pub(crate) fn variations(&self) -> Vec<Variation<'_>> {
        match self {
            Self::Shape(shape) => shape.variations(),
            Self::Given(given) => given.variations(),
        }
    }

    /// Stations of the parameters that are functions of the arc length, other than linear sizes; none of smooth ones.
    fn functions(&self) -> Vec<&[f64]> {
        match self {
            Self::Shape(shape) => {
                let functions = shape.sizes().into_iter().filter(|(_, size)| size.ends().is_none());
                functions.map(|(_, size)| size.stations()).collect()
            }
            Self::Given(given) => given.functions(),
        }
    }

    /// Whether parameters are functions of the arc length, other than linear sizes.
    pub fn varies(&self) -> bool {
        !self.functions().is_empty()
    }

    /// Half extents along y and z at the fraction `x` in [0, 1] of the segment, in metres, for pictures and
    /// slenderness. For given properties, those of the ellipse with the same radii of gyration.
    pub fn half_extents(&self, x: f64) -> [f64; 2] {
        match self {
            Self::Shape(shape) => shape.at(x).half_extents(),
            Self::Given(given) => {
                let given = given.at(x);
                // The radius of gyration of an ellipse is half its semi-axis. The extent along y follows from
                // the inertia about z.
                [2, 1].map(|axis| 2.0 * (given.inertia[axis][axis] / given.mass).sqrt())
            }
        }
    }

    /// Reports every problem of this section along a segment of this length in metres, independent of its
    /// modes.
    pub fn validate(&self, length: f64) -> Result<(), InvalidInput> {
        match self {
            Self::Shape(shape) => shape.validate(length),
            Self::Given(given) => given.validate(length),
        }
    }

    /// Reports every problem of this section in a segment of this length with these modes.
    pub(crate) fn check(&self, check: &mut Checker, length: f64, modes: &[usize; STRAINS]) {
        match self {
            // Problems of a circle are reported at `radius` itself, without `section`.
            Self::Shape(Shape::Circle { .. }) => check.all(self.validate(length)),
            Self::Shape(_) => _ = check.nested("section", self.validate(length)),
            Self::Given(given) => {
                if check.nested("section", self.validate(length)).is_some() {
                    check.nested("section", given.validate_stiffness(length, modes));
                }
            }
        }
    }

    /// Whether the stiffness is a polynomial along the rod between stations; for a circle it is the fourth
    /// power of the radius.
    pub(crate) fn is_polynomial(&self) -> bool {
        !matches!(
            self,
            Self::Shape(Shape::HollowCircle { .. } | Shape::Rectangle { .. } | Shape::Ellipse { .. })
        ) || self.is_constant()
    }

    /// Polynomial degree, between stations, of mass and inertia per length. For shapes with sizes
    /// approximated by polynomials, the degree of a polynomial that is accurate to rounding, which is less
    /// than that of the sizes' fourth power.
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

/// Factors of the shear stiffness relative to G A.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ShearCorrection {
    /// Factors for shear along y and along z.
    Factors([f64; 2]),
    /// Cowper's (1966) factors for the shape and Poisson's ratio ([`Shape::cowper`]).
    Cowper,
}

impl From<f64> for ShearCorrection {
    fn from(factor: f64) -> Self {
        Self::Factors([factor; 2])
    }
}
