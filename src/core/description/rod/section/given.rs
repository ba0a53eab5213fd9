//! Sections with given stiffness and inertia.

use nalgebra::Matrix6;

use super::along::LARGEST;
use super::along::{breaks, validate_along};
use super::properties::SectionProperties;
use crate::description::body;
use crate::description::rod::profile::{Profile, Variation};
use crate::description::rod::quadrature::Gauss;
use crate::description::rod::strain::{STRAIN_NAMES, STRAINS};
use crate::error::{Checker, InvalidInput};

/// Tolerated asymmetry of a stiffness matrix relative to its entries: rounding errors of the input.
const SYMMETRY_TOLERANCE: f64 = 1e-9;

/// Smallest eigenvalue of a stiffness matrix with unit diagonal; below, the matrix is singular to rounding.
const LEAST_EIGENVALUE: f64 = 1e-12;

/// A section given by its stiffness and inertia per length, for composites, profiles computed elsewhere, or
/// test cases. Matrices are stored row by row.
#[derive(Clone, Debug, PartialEq)]
pub struct GivenSection {
    /// Stiffness per length H of the strains in the order of [`STRAIN_NAMES`]: a symmetric matrix, positive
    /// definite on the strains that have modes. Units: N m^2 between angular strains, N between linear ones,
    /// N m between an angular and a linear strain.
    pub stiffness: Profile<{ STRAINS * STRAINS }>,
    /// Mass per length in kg/m.
    pub mass: Profile<1>,
    /// Inertia tensor per length about the centre of mass, in the section's axes, in kg m: a symmetric
    /// matrix.
    pub inertia: Profile<9>,
    /// Centre of mass along y and z, relative to the rod's axis, in metres.
    pub centre: Profile<2>,
}

impl GivenSection {
    /// Properties at the fraction `x` in [0, 1] of the length from base to tip.
    pub fn at(&self, x: f64) -> SectionProperties {
        let [y, z] = self.centre.at(x);
        SectionProperties {
            stiffness: matrix(&self.stiffness.at(x)),
            outline_area: 0.0,
            mass: self.mass.at(x)[0],
            centre: [0.0, y, z],
            inertia: matrix(&self.inertia.at(x)),
        }
    }

    /// Whether the section is constant.
    pub fn is_constant(&self) -> bool {
        self.variations().is_empty()
    }

    /// Variations of the non-constant properties.
    pub(crate) fn variations(&self) -> Vec<Variation<'_>> {
        let Self { stiffness, mass, inertia, centre } = self;
        [stiffness.variation(), mass.variation(), inertia.variation(), centre.variation()]
            .into_iter()
            .flatten()
            .collect()
    }

    /// Stations of the parameters that are functions of the arc length; none of smooth ones.
    pub(crate) fn functions(&self) -> Vec<&[f64]> {
        let Self { stiffness, mass, inertia, centre } = self;
        let varies = [
            stiffness.constant().is_none(),
            mass.constant().is_none(),
            inertia.constant().is_none(),
            centre.constant().is_none(),
        ];
        let stations = [stiffness.stations(), mass.stations(), inertia.stations(), centre.stations()];
        stations.into_iter().zip(varies).filter(|(_, varies)| *varies).map(|(stations, _)| stations).collect()
    }

    /// Polynomial degree, between stations, of the inertia about the rod's axis.
    pub(crate) fn degree_of_inertia(&self) -> usize {
        let degree = |variation: Option<Variation<'_>>| variation.map_or(0, |variation| variation.degree);
        let of_offset = degree(self.mass.variation()) + 2 * degree(self.centre.variation());
        degree(self.inertia.variation()).max(of_offset)
    }

    /// Reports every problem of this section along a segment of this length, independent of its modes.
    pub(crate) fn validate(&self, length: f64) -> Result<(), InvalidInput> {
        let Self { stiffness, mass, inertia, centre } = self;
        let mut check = Checker::new();
        check.nested("stiffness", stiffness.validate(length));
        check.nested("mass", mass.validate(length));
        check.nested("inertia", inertia.validate(length));
        check.nested("centre", centre.validate(length));
        check.all(validate_along(&self.variations(), length, |x| validate(&self.at(x))));
        check.finish()
    }

    /// Pairs of strains with modes that the stiffness couples, in order.
    pub(crate) fn coupled(&self, modes: &[usize; STRAINS]) -> impl Iterator<Item = [usize; 2]> {
        let pairs = (0..STRAINS).flat_map(|i| (i + 1..STRAINS).map(move |j| [i, j]));
        let is_coupled = |i, j| self.stiffness.is_entry_constant(STRAINS * i + j) != Some(0.0);
        pairs.filter(move |&[i, j]| modes[i] > 0 && modes[j] > 0 && is_coupled(i, j))
    }

    /// Rejects a stiffness for which a motion in these strains would store no energy.
    pub(crate) fn validate_stiffness(
        &self,
        length: f64,
        modes: &[usize; STRAINS],
    ) -> Result<(), InvalidInput> {
        let variation = Vec::from_iter(self.stiffness.variation());
        validate_along(&variation, length, |x| check_definite(&matrix(&self.stiffness.at(x)), modes))
    }

    /// Integral of mass times centre over the fraction x.
    pub(crate) fn first_moment(&self) -> [f64; 2] {
        let variations = [self.mass.variation(), self.centre.variation()];
        let degree: usize = variations.iter().flatten().map(|variation| variation.degree).sum();
        let gauss = Gauss::composite(degree / 2 + 1, &breaks(&self.variations()));
        let mut sum = [0.0; 2];
        for (&x, weight) in gauss.nodes.iter().zip(&gauss.weights) {
            let mass = weight * self.mass.at(x)[0];
            for (sum, offset) in sum.iter_mut().zip(self.centre.at(x)) {
                *sum += offset * mass;
            }
        }
        sum
    }
}

/// Square matrix from its entries, row by row.
fn matrix<const N: usize, const ENTRIES: usize>(entries: &[f64; ENTRIES]) -> [[f64; N]; N] {
    std::array::from_fn(|i| std::array::from_fn(|j| entries[N * i + j]))
}

/// Reports every problem of a section at one point, independent of its modes.
fn validate(section: &SectionProperties) -> Result<(), InvalidInput> {
    let mut check = Checker::new();
    let stiffness = &section.stiffness;
    let mut is_finite = true;
    for (i, row) in stiffness.iter().enumerate() {
        is_finite &= check.finite(row, &format!("stiffness[{i}]"));
    }
    if is_finite {
        let size = |i: usize, j: usize| stiffness[i][i].abs().sqrt() * stiffness[j][j].abs().sqrt();
        for i in 0..STRAINS {
            for j in 0..i {
                let [below, above] = [stiffness[i][j], stiffness[j][i]];
                let largest = size(i, j).max(below.abs()).max(above.abs());
                check.require(
                    (below - above).abs() <= SYMMETRY_TOLERANCE * largest,
                    &format!("stiffness[{i}][{j}]"),
                    format_args!("{below}, but {above} at [{j}][{i}]"),
                    "a symmetric matrix",
                );
            }
        }
    }
    check.positive(section.mass, "mass", "kg/m");
    body::check_inertia(&mut check, &section.inertia);
    check.finite(&section.centre[1..], "centre");
    check.finish()
}

/// Rejects a stiffness that is not positive definite on the strains with modes.
fn check_definite(
    stiffness: &[[f64; STRAINS]; STRAINS],
    modes: &[usize; STRAINS],
) -> Result<(), InvalidInput> {
    let mut check = Checker::new();
    let present: Vec<usize> = (0..STRAINS).filter(|&strain| modes[strain] > 0).collect();
    for &i in &present {
        let place = format!("stiffness[{i}][{i}]");
        let expected = format!("a positive stiffness, as {} has modes", STRAIN_NAMES[i]);
        check.require(stiffness[i][i] > 0.0, &place, stiffness[i][i], &expected);
    }
    if check.is_ok() {
        let scaled = Matrix6::from_fn(|i, j| match present.contains(&i) && present.contains(&j) {
            true => stiffness[i][j] / stiffness[i][i].sqrt() / stiffness[j][j].sqrt(),
            false => f64::from(u8::from(i == j)),
        });
        check.require(
            // If a quotient overflows, do not decompose.
            scaled.amax() <= LARGEST && scaled.symmetric_eigenvalues().min() >= LEAST_EIGENVALUE,
            "stiffness",
            "a matrix that is not positive definite",
            "a positive definite matrix of the strains that have modes",
        );
    }
    check.finish()
}
