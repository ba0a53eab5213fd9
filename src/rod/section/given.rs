//! Sections of which stiffness and inertia are given.

use nalgebra::Matrix6;

use super::super::body;
use super::super::description::{STRAIN_NAMES, STRAINS};
use crate::error::{Checker, InvalidInput};

/// A stiffness may violate symmetry by this much of its entries' size: rounding of whoever computed it.
const SYMMETRY_TOLERANCE: f64 = 1e-9;

/// The least eigenvalue of a stiffness with its diagonal scaled to one: below, it is singular to rounding.
const LEAST_EIGENVALUE: f64 = 1e-12;

/// A section by its stiffness and inertia per length: of composites, of profiles computed elsewhere, of test cases.
#[derive(Clone, Debug, PartialEq)]
pub struct GivenSection {
    /// Stiffness per length H of the strains in the order of [`STRAIN_NAMES`]: a symmetric matrix, positive definite on the
    /// strains that have modes. N m^2 between angular strains, N between linear ones, N m between one and another.
    pub stiffness: [[f64; STRAINS]; STRAINS],
    /// Mass per length in kg/m.
    pub mass: f64,
    /// Inertia tensor per length about the centre of mass, in the section's axes, in kg m: rows of a symmetric matrix.
    pub inertia: [[f64; 3]; 3],
    /// Centre of mass along y and z, seen from the rod's axis, in metres.
    pub centre: [f64; 2],
}

impl GivenSection {
    /// Everything that is wrong with this section, whatever modes it is given.
    pub fn validate(&self) -> Result<(), InvalidInput> {
        let mut check = Checker::new();
        let mut is_finite = true;
        for (i, row) in self.stiffness.iter().enumerate() {
            is_finite &= check.finite(row, &format!("stiffness[{i}]"));
        }
        if is_finite {
            let size = |i: usize, j: usize| (self.stiffness[i][i] * self.stiffness[j][j]).abs().sqrt();
            for i in 0..STRAINS {
                for j in 0..i {
                    let [below, above] = [self.stiffness[i][j], self.stiffness[j][i]];
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
        check.positive(self.mass, "mass", "kg/m");
        body::check_inertia(&mut check, &self.inertia);
        check.finite(&self.centre, "centre");
        check.finish()
    }

    /// Pairs of strains with modes that the stiffness couples, in their order.
    pub(in super::super) fn coupled(&self, modes: &[usize; STRAINS]) -> impl Iterator<Item = [usize; 2]> {
        let pairs = (0..STRAINS).flat_map(|i| (i + 1..STRAINS).map(move |j| [i, j]));
        pairs.filter(move |&[i, j]| modes[i] > 0 && modes[j] > 0 && self.stiffness[i][j] != 0.0)
    }

    /// Refuses a stiffness under which a motion in these strains would store no energy.
    pub(super) fn check_stiffness(&self, check: &mut Checker, modes: &[usize; STRAINS]) {
        let present: Vec<usize> = (0..STRAINS).filter(|&strain| modes[strain] > 0).collect();
        let mut is_positive = true;
        for &i in &present {
            let place = format!("section.stiffness[{i}][{i}]");
            let expected = format!("a positive stiffness, as {} has modes", STRAIN_NAMES[i]);
            let stiffness = self.stiffness[i][i];
            is_positive &= check.require(stiffness > 0.0, &place, stiffness, &expected);
        }
        if !is_positive {
            return;
        }
        let scaled = Matrix6::from_fn(|i, j| match present.contains(&i) && present.contains(&j) {
            true => self.stiffness[i][j] / (self.stiffness[i][i] * self.stiffness[j][j]).sqrt(),
            false => f64::from(u8::from(i == j)),
        });
        check.require(
            scaled.symmetric_eigenvalues().min() >= LEAST_EIGENVALUE,
            "section.stiffness",
            "a matrix that is not positive definite",
            "a positive definite matrix of the strains that have modes",
        );
    }
}
