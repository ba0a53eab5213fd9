//! The tangent stiffness of an equilibrium, and what changes its sign where paths turn and cross.

use super::equations::Linear;
use crate::linalg::{Matrix, eigenvalues, symmetric_eigen, symmetric_eigenvalues};
use crate::springs::Natural;
use crate::stability::{is_symmetric, symmetric_part};

/// What changes its sign at a critical point.
#[derive(Clone, Copy, Debug)]
pub(super) enum Test {
    /// An eigenvalue of the symmetric tangent, by its place in order.
    Eigenvalue(usize),
    /// The determinant of a tangent that is not symmetric: its sign, with the size of the smallest eigenvalue.
    Determinant,
}

/// The tangent stiffness in natural coordinates, relative to that of material and springs: all its eigenvalues are one without load;
/// where one is zero there is a critical point.
#[derive(Clone, Debug)]
pub(super) struct Stiffness {
    relative: Matrix,
    natural: Natural,
    pub(super) is_symmetric: bool,
    /// Its eigenvalues, smallest first, if it is symmetric: what changes sign at critical points.
    eigenvalues: Vec<f64>,
    /// Smallest eigenvalue of the symmetric part; NaN when the tangent is not finite.
    pub(super) lowest: f64,
}

impl Stiffness {
    pub(super) fn new(linear: &Linear) -> Self {
        let relative = linear.tangent.clone();
        let is_symmetric = is_symmetric(&relative);
        let symmetric = symmetric_eigenvalues(&symmetric_part(&relative));
        let lowest = symmetric.as_ref().map_or(f64::NAN, |values| values.first().copied().unwrap_or(1.0));
        let eigenvalues = symmetric.filter(|_| is_symmetric).unwrap_or_default();
        Self { relative, natural: linear.natural.clone(), is_symmetric, eigenvalues, lowest }
    }

    /// What changes sign at the critical points between this tangent and another one.
    pub(super) fn tests_until(&self, other: &Self) -> Vec<Test> {
        if self.is_symmetric && other.is_symmetric {
            let negative = |stiffness: &Self| stiffness.eigenvalues.iter().filter(|x| **x < 0.0).count();
            let (before, after) = (negative(self), negative(other));
            return (before.min(after)..before.max(after)).map(Test::Eigenvalue).collect();
        }
        let changes = (self.value(Test::Determinant) < 0.0) != (other.value(Test::Determinant) < 0.0);
        if changes { vec![Test::Determinant] } else { Vec::new() }
    }

    /// The smallest absolute eigenvalue.
    pub(super) fn smallest(&self) -> f64 {
        if self.is_symmetric {
            self.eigenvalues.iter().fold(f64::INFINITY, |smallest, x| smallest.min(x.abs()))
        } else {
            self.value(Test::Determinant).abs()
        }
    }

    /// The value of a test; NaN where it does not apply.
    pub(super) fn value(&self, test: Test) -> f64 {
        match test {
            Test::Eigenvalue(i) => self.eigenvalues.get(i).copied().unwrap_or(f64::NAN),
            Test::Determinant => signed_smallest(&self.relative),
        }
    }

    /// The scaled directions of the m smallest stiffnesses, each of norm one; and whether a load along `load` (natural) pushes
    /// in one of them, as it does at limit points and does not at bifurcations.
    pub(super) fn softest(&self, m: usize, load: &[f64]) -> Option<(Vec<Vec<f64>>, bool)> {
        /// A load that is orthogonal to a direction to this accuracy does not push in it.
        const ORTHOGONAL: f64 = 1e-5;
        let n = load.len();
        let (_, right) = symmetric_eigen(&(self.relative.transpose() * &self.relative))?;
        let (_, left) = symmetric_eigen(&(&self.relative * self.relative.transpose()))?;
        let size = load.iter().map(|x| x * x).sum::<f64>().sqrt();
        let is_pushed = (0..m).any(|k| {
            let along: f64 = (0..n).map(|i| left[(i, k)] * load[i]).sum();
            along.abs() > ORTHOGONAL * size
        });
        let directions = (0..m).map(|k| {
            let natural: Vec<f64> = right.column(k).iter().copied().collect();
            let mut direction = self.natural.coordinates(&natural);
            let norm = direction.iter().map(|x| x * x).sum::<f64>().sqrt();
            // The sign of an eigenvector is arbitrary; ours makes the largest entry positive.
            let largest = direction.iter().fold(0.0_f64, |m, x| if x.abs() > m.abs() { *x } else { m });
            direction.iter_mut().for_each(|x| *x /= norm.copysign(largest));
            direction
        });
        Some((directions.collect(), is_pushed))
    }
}

/// The smallest absolute eigenvalue with the sign of the determinant: that of the number of negative real ones.
fn signed_smallest(a: &Matrix) -> f64 {
    let Some(values) = eigenvalues(a) else { return f64::NAN };
    let smallest = values.iter().map(|value| value.norm()).fold(f64::INFINITY, f64::min);
    let negative = values.iter().filter(|value| value.im == 0.0 && value.re < 0.0).count();
    if negative % 2 == 0 { smallest } else { -smallest }
}
