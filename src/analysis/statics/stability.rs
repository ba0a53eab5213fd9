//! Tangent stiffness of an equilibrium, and its sign changes at limit points and bifurcations.

use std::cell::OnceCell;
use std::ops::Range;

use super::equations::Linear;
use crate::analysis::normalised::Normalised;
use crate::numerics::linalg::symmetric_part;
use crate::numerics::linalg::{Complex, Matrix, eigenvalues, symmetric_eigen, symmetric_eigenvalues};

/// A load is orthogonal to a direction if their product is below this accuracy.
pub(super) const ORTHOGONAL: f64 = 1e-5;

/// Eigenvalues below this value count as zero: rounding and the tolerance of equilibria give arbitrary signs
/// to directions that are free to turn.
pub(super) const NEUTRAL: f64 = 1e-8;

/// A stiffness counts as symmetric, so that its loads have a potential, if no entry differs from its
/// transpose by more than this fraction of the elastic stiffnesses it couples. This is above the quadrature
/// error of strongly bent rods and below the effect of any relevant follower load.
const LARGEST_ASYMMETRY: f64 = 1e-6;

fn is_symmetric(a: &Matrix) -> bool {
    (0..a.nrows()).all(|j| (0..j).all(|i| (a[(i, j)] - a[(j, i)]).abs() <= LARGEST_ASYMMETRY))
}

/// Tangent stiffness in normalised coordinates, relative to that of material and springs: all eigenvalues are
/// one without load, and one of them is zero at a critical point.
#[derive(Clone, Debug)]
pub(super) struct Stiffness {
    relative: Matrix,
    normalised: Normalised,
    /// Eigenvalues, once they are needed.
    eigenvalues: OnceCell<Vec<Complex>>,
    /// Smallest eigenvalue of the symmetric part; NaN if the tangent is not finite.
    pub(super) lowest: f64,
}

impl Stiffness {
    pub(super) fn new(linear: &Linear) -> Self {
        let relative = linear.tangent.clone();
        let symmetric = symmetric_eigenvalues(&symmetric_part(&relative));
        let lowest = symmetric.as_ref().map_or(f64::NAN, |values| values.first().copied().unwrap_or(1.0));
        let eigenvalues = OnceCell::new();
        if is_symmetric(&relative) {
            let real = symmetric.unwrap_or_default().into_iter().map(|value| Complex::new(value, 0.0));
            eigenvalues.get_or_init(|| real.collect());
        }
        Self { relative, normalised: linear.normalised.clone(), eigenvalues, lowest }
    }

    /// Eigenvalues in increasing order of their real parts; none if there is a number that is not finite. They change
    /// continuously along a path, including multiple ones.
    fn eigenvalues(&self) -> &[Complex] {
        self.eigenvalues.get_or_init(|| {
            let mut values = eigenvalues(&self.relative).unwrap_or_default();
            values.sort_by(|a, b| a.re.total_cmp(&b.re));
            values
        })
    }

    /// Number of eigenvalues with negative real parts. There is none if the symmetric part is positive: real parts are at least
    /// its smallest eigenvalue (Bendixson 1902).
    fn negative(&self) -> usize {
        if self.lowest > NEUTRAL {
            return 0;
        }
        self.eigenvalues().iter().filter(|x| x.re < -NEUTRAL).count()
    }

    /// Indices of the eigenvalues whose real parts change sign between this tangent and another one.
    pub(super) fn changes_until(&self, other: &Self) -> Range<usize> {
        let (before, after) = (self.negative(), other.negative());
        before.min(after)..before.max(after)
    }

    /// Smallest absolute eigenvalue.
    pub(super) fn smallest(&self) -> f64 {
        self.eigenvalues().iter().map(|value| value.norm()).fold(f64::INFINITY, f64::min)
    }

    /// Eigenvalue by index; NaN if there is none.
    pub(super) fn eigenvalue(&self, place: usize) -> Complex {
        self.eigenvalues().get(place).copied().unwrap_or(Complex::new(f64::NAN, f64::NAN))
    }

    /// Scaled directions of the m smallest stiffnesses, each with norm one, and whether the load `load`
    /// (normalised) acts in one of them, as at limit points but not at bifurcations.
    pub(super) fn softest(&self, m: usize, load: &[f64]) -> Option<(Vec<Vec<f64>>, bool)> {
        let n = load.len();
        let (_, right) = symmetric_eigen(&(self.relative.transpose() * &self.relative))?;
        let (_, left) = symmetric_eigen(&(&self.relative * self.relative.transpose()))?;
        let size = load.iter().map(|x| x * x).sum::<f64>().sqrt();
        let is_pushed = (0..m).any(|k| {
            let along: f64 = (0..n).map(|i| left[(i, k)] * load[i]).sum();
            along.abs() > ORTHOGONAL * size
        });
        let directions = (0..m).map(|k| {
            let normalised: Vec<f64> = right.column(k).iter().copied().collect();
            let mut direction = self.normalised.coordinates(&normalised);
            let norm = direction.iter().map(|x| x * x).sum::<f64>().sqrt();
            // The sign of an eigenvector is arbitrary: make the largest entry positive.
            let largest = direction.iter().fold(0.0_f64, |m, x| if x.abs() > m.abs() { *x } else { m });
            direction.iter_mut().for_each(|x| *x /= norm.copysign(largest));
            direction
        });
        Some((directions.collect(), is_pushed))
    }
}
