//! Sections: stiffness and inertia per length at a place of a segment.
//!
//! `shape` knows plane figures, `torsion` the rectangle's torsion constant, `given` what is not computed from a figure.

mod given;
mod shape;
mod torsion;

pub use given::GivenSection;
pub use shape::Shape;

use std::convert::Infallible;

use super::body;
use super::description::{STRAIN_NAMES, STRAINS, Segment};
use super::profile::{Profile, Variation};
use crate::error::{Checker, InvalidInput, Number};

/// Where a section that varies is looked at: at so many places beside the stations of its tables.
const PLACES: usize = 256;

/// What a section's numbers may be in SI units, far beyond all rods: products of three of them stay doubles with all their digits.
pub(super) const SMALLEST: f64 = 1e-100;
pub(super) const LARGEST: f64 = 1e100;

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
    pub(super) fn variations(&self) -> Vec<Variation<'_>> {
        match self {
            Self::Shape(shape) => shape.variations(),
            Self::Given(given) => given.variations(),
        }
    }

    /// How far it reaches from the rod's axis along y and along z at the fraction `x` in [0, 1] of the segment, in metres: for
    /// pictures and slenderness. Of a given section that of the ellipse with its radii of gyration.
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
    pub(super) fn check(&self, check: &mut Checker, length: f64, modes: &[usize; STRAINS]) {
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

    /// Whether its stiffness is a polynomial along the rod between any two stations, of a circle the fourth power of the radius.
    pub(super) fn is_polynomial(&self) -> bool {
        !matches!(
            self,
            Self::Shape(Shape::HollowCircle { .. } | Shape::Rectangle { .. } | Shape::Ellipse { .. })
        ) || self.is_constant()
    }

    /// Degree of the polynomials, between any two stations, that mass and inertia per length are. Of a shape whose sizes follow
    /// functions that of a polynomial that follows to rounding: less than sizes to the fourth power could have.
    pub(super) fn degree_of_inertia(&self) -> usize {
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

/// Where in (0, 1) tables have stations, in their order.
fn breaks(variations: &[Variation<'_>]) -> Vec<f64> {
    let mut breaks: Vec<f64> =
        variations.iter().flat_map(fractions).filter(|&x| x > 0.0 && x < 1.0).collect();
    breaks.sort_by(f64::total_cmp);
    breaks.dedup();
    breaks
}

/// The stations of a table as fractions of its length.
fn fractions<'a>(variation: &Variation<'a>) -> impl Iterator<Item = f64> + use<'a> {
    let stations = variation.stations;
    let end = stations.last().copied().unwrap_or(1.0);
    stations.iter().map(move |station| station / end)
}

/// What is wrong with numbers along a segment of this length, at the first place where anything is.
fn validate_along(
    variations: &[Variation<'_>],
    length: f64,
    validate: impl Fn(f64) -> Result<(), InvalidInput>,
) -> Result<(), InvalidInput> {
    if variations.is_empty() {
        return validate(0.0);
    }
    let evenly = (0..=PLACES).map(|i| i as f64 / PLACES as f64);
    let mut places: Vec<f64> = evenly.chain(variations.iter().flat_map(fractions)).collect();
    places.sort_by(f64::total_cmp);
    places.into_iter().try_for_each(|x| {
        validate(x).map_err(|mut error| {
            for problem in &mut error.problems {
                problem.found += &format!(" at X = {}", x * length);
            }
            error
        })
    })
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
            Section::Given(given) => given.at(x),
        }
    }

    /// Everything that is wrong with the numbers of `segment` together, whose parts are right each for itself: stiffness or mass
    /// that overflows or vanishes.
    pub(super) fn validate(segment: &Segment) -> Result<(), InvalidInput> {
        let numbers =
            format!("sizes and material that give numbers between {SMALLEST:e} and {LARGEST:e} in SI units");
        validate_along(&segment.section.variations(), segment.length, |x| {
            let Self { stiffness, mass, inertia, .. } = Self::at(segment, x);
            let mut check = Checker::new();
            for (strain, name) in STRAIN_NAMES.into_iter().enumerate() {
                let own = stiffness[strain][strain];
                let is_stiff = segment.modes[strain] == 0 || own >= SMALLEST;
                let found = format!("a stiffness of {} against {name}", Number(own));
                let row = stiffness[strain].iter().all(|entry| entry.abs() <= LARGEST);
                check.require(is_stiff && row, "section", found, &numbers);
            }
            let found = format!("a mass of {} kg/m", Number(mass));
            check.require((SMALLEST..=LARGEST).contains(&mass), "section", found, &numbers);
            let largest = inertia.iter().flatten().fold(0.0_f64, |largest, entry| largest.max(entry.abs()));
            let is_light = inertia.iter().flatten().all(|entry| entry.abs() <= LARGEST);
            let found = format!("a moment of inertia of {} kg m", Number(largest));
            check.require(is_light, "section", found, &numbers);
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
