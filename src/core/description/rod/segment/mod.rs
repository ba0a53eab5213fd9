//! A segment of a rod, as plain data.

pub(crate) mod described;

use super::basis::Basis;
use super::profile::{AlongSegment, Profile};
use super::section::{GivenSection, Section, ShearCorrection};
use super::strain::{STRAIGHT, STRAINS};
use crate::error::{InvalidInput, Number};

/// Maximum number of modes of one strain component in one segment: beyond, Legendre modes are ill-conditioned
/// and do not increase accuracy.
pub const MAX_MODES: usize = 64;

/// Maximum number of quadrature nodes that can be requested for a segment.
pub const MAX_NODES: usize = 256;

/// Maximum number of quadrature nodes that a segment uses automatically, for its reference strain and for
/// long tables. An evaluation costs the square of the number, a million multiplications.
pub const MAX_OWN_NODES: usize = 1024;

/// Allowable loads of a segment, for reports only: no force and no motion depends on it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Allowable {
    /// Smallest radius of bending of the axis, in metres.
    pub bend_radius: Option<f64>,
    /// Largest strain along the rod in the outermost fibre.
    pub strain: Option<f64>,
    /// Largest stress along the rod in the outermost fibre, in pascals.
    pub stress: Option<f64>,
}

/// A piece of rod with one kind of section.
#[derive(Clone, Debug, PartialEq)]
pub struct Segment {
    /// Length in metres.
    pub length: f64,
    /// Cross-section.
    pub section: Section,
    /// Young's modulus E in pascals; zero (as G and the density) for a section with given stiffness and
    /// inertia.
    pub young_modulus: f64,
    /// Shear modulus G in pascals.
    pub shear_modulus: f64,
    /// Poisson's ratio, if it was given instead of the shear modulus. It enters no computation, but
    /// determines how the shear modulus follows a change of Young's modulus.
    pub given_poisson_ratio: Option<f64>,
    /// Density in kg/m^3.
    pub density: f64,
    /// Number of modes of each strain component, in the order of [`STRAIN_NAMES`](crate::description::rod::STRAIN_NAMES).
    /// For piecewise constant strains the number of pieces; for Hermite cubics twice the number of knots. In
    /// these two bases all strains with modes have the same number.
    pub modes: [usize; STRAINS],
    /// Whether the numbers of modes are left to a requested accuracy: `modes` stands in until a choice of modes replaces it.
    pub modes_are_open: bool,
    /// Basis of the modes.
    pub basis: Basis,
    /// Kelvin-Voigt retardation time mu in seconds: damping is mu times stiffness.
    pub retardation_time: f64,
    /// Strain of the stress-free segment.
    pub reference_strain: Profile<STRAINS>,
    /// Magnetisation in the axes of the sections, in A/m.
    pub magnetisation: Profile<3>,
    /// Shear correction factors k in the shear stiffness k G A of a shape; one by default.
    pub shear_correction: ShearCorrection,
    /// Number of quadrature nodes, rounded up to a multiple of four; `None` uses the number that the modes
    /// need for bends up to about half a turn (`docs/rod.md`).
    pub nodes: Option<usize>,
    /// Allowable loads.
    pub allowable: Allowable,
}

impl Segment {
    /// Properties along the segment on which effects act, per area of its section.
    pub(crate) fn of_effects(&self) -> [(&'static str, &dyn AlongSegment); 1] {
        [("magnetisation", &self.magnetisation)]
    }

    /// A straight elastic segment of constant radius, without modes: a start for `..` syntax.
    pub fn straight(length: f64, radius: f64, young_modulus: f64, shear_modulus: f64, density: f64) -> Self {
        Self {
            length,
            section: Section::circle([radius; 2]),
            young_modulus,
            shear_modulus,
            given_poisson_ratio: None,
            density,
            modes: [0; STRAINS],
            modes_are_open: false,
            basis: Basis::Legendre,
            retardation_time: 0.0,
            reference_strain: STRAIGHT.into(),
            magnetisation: [0.0; 3].into(),
            shear_correction: 1.0.into(),
            nodes: None,
            allowable: Allowable::default(),
        }
    }

    /// A straight segment with a given section, without modes: a start for `..` syntax.
    pub fn given(length: f64, section: GivenSection) -> Self {
        let section = Section::Given(Box::new(section));
        Self { section, ..Self::straight(length, 0.0, 0.0, 0.0, 0.0) }
    }

    /// Mass times the distance of the sections' centres of mass from the axis, integrated along the segment,
    /// in section axes.
    pub(crate) fn mass_offset(&self) -> [f64; 3] {
        match &self.section {
            Section::Shape(_) => [0.0; 3],
            Section::Given(given) => {
                let [y, z] = given.first_moment().map(|moment| moment * self.length);
                [0.0, y, z]
            }
        }
    }

    /// Poisson's ratio of an isotropic material, E / (2 G) - 1.
    pub(crate) fn poisson_ratio(&self) -> f64 {
        self.young_modulus / (2.0 * self.shear_modulus) - 1.0
    }

    /// Number of generalised coordinates of this segment.
    pub fn coordinates(&self) -> usize {
        self.modes.iter().sum()
    }
}

/// Shear modulus of an isotropic material, G = E / (2 (1 + nu)), in the unit of Young's modulus.
///
/// # Errors
/// If Poisson's ratio is outside (-1, 0.5].
pub fn shear_modulus(young_modulus: f64, poisson_ratio: f64) -> Result<f64, InvalidInput> {
    if poisson_ratio > -1.0 && poisson_ratio <= 0.5 {
        Ok(young_modulus / (2.0 * (1.0 + poisson_ratio)))
    } else {
        let expected = "a Poisson's ratio in (-1, 0.5]";
        Err(InvalidInput::new("poisson_ratio", Number(poisson_ratio), expected))
    }
}
