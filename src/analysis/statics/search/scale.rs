//! Scales of a shape: sizes of coordinates, normalised coordinates, and magnitudes of loads.

use super::problem::{Problem, scaled};
use crate::model::chart;
use crate::numerics::linalg::Matrix;

/// Stiffness below this part of the largest one counts as zero.
const SOFTEST: f64 = 1e-14;

/// Magnitude of generalised forces, relative to the largest one of the same part or to the constraint wrench of their joint, below which
/// they are rounding: no force does work along such a coordinate.
pub(super) const NEGLIGIBLE_FORCE: f64 = 1e-5;

/// Typical sizes of coordinates in a shape, and normalised coordinates x, `dq = w x`, in which all stiffnesses are comparable.
pub(super) struct Scale {
    pub(super) sizes: Vec<f64>,
    pub(super) w: Vec<f64>,
    /// Whether a coordinate rotates a part, rather than only translating it.
    pub(super) turns: Vec<bool>,
    /// Magnitudes of the generalised forces of weight and loads, for any direction of these, at least [`NEGLIGIBLE_FORCE`] of the constraint
    /// wrenches of joints.
    pub(super) loads: Vec<f64>,
}

impl Scale {
    pub(super) fn new(problem: &mut Problem<'_>, q: &[f64]) -> Self {
        let n = problem.n();
        let mut sizes = vec![0.0; n];
        problem.model.sizes(q, &mut sizes);
        let stiffness: Vec<f64> =
            (0..n).map(|k| problem.material[(k, k)].abs() * sizes[k] * sizes[k]).collect();
        let largest = stiffness.iter().copied().fold(0.0, f64::max);
        let softest =
            stiffness.iter().copied().filter(|k| *k > SOFTEST * largest).fold(f64::INFINITY, f64::min);
        let w = sizes.iter().zip(&stiffness).map(|(size, k)| size / (1.0 + k / softest).sqrt()).collect();
        let turns = problem.model.facts().turns.clone();
        let mut loads = Matrix::zeros(n, 3);
        let mut constraint_loads = vec![0.0; n];
        problem.model.turned_loads(q, &mut loads, &mut constraint_loads);
        for mut column in loads.column_iter_mut() {
            chart::forces(&problem.turns, q, column.as_mut_slice());
        }
        let loads = loads
            .row_iter()
            .zip(constraint_loads)
            .map(|(row, load)| row.norm().max(NEGLIGIBLE_FORCE * load))
            .collect();
        Self { sizes, w, turns, loads }
    }

    /// Diagonal metric that measures steps in sizes of coordinates. Rotations are limited to a radian, however large the
    /// radius is.
    pub(super) fn metric(&self, radius: f64) -> Vec<f64> {
        let more = radius.max(1.0).powi(2);
        (0..self.w.len())
            .map(|k| (self.w[k] / self.sizes[k]).powi(2) * if self.turns[k] { more } else { 1.0 })
            .collect()
    }

    /// Converts derivatives to normalised coordinates.
    pub(super) fn rows(&self, rows: &Matrix) -> Matrix {
        scaled(rows, &self.w)
    }

    /// Converts a normalised step to coordinates.
    pub(super) fn coordinates(&self, x: &[f64]) -> Vec<f64> {
        x.iter().zip(&self.w).map(|(x, w)| x * w).collect()
    }

    /// Length of a step in translating coordinates only, in sizes.
    pub(super) fn shift(&self, x: &[f64]) -> f64 {
        let of = |k: usize| if self.turns[k] { 0.0 } else { (x[k] * self.w[k] / self.sizes[k]).powi(2) };
        (0..x.len()).map(of).sum::<f64>().sqrt()
    }

    /// Diagonal regularisation of the second derivative that corresponds to a relative error of the balance of forces.
    pub(super) fn regularisation(&self, error: f64, work: &[f64]) -> Vec<f64> {
        (0..self.w.len()).map(|k| error * work[k] * self.w[k] * self.w[k] / self.sizes[k]).collect()
    }
}
