//! The minimum of a quadratic model in a ball, by eigenvectors (Moré and Sorensen 1983).

use crate::numerics::linalg::{Matrix, dot, norm, symmetric_eigen};

/// Relative tolerance of the step length in the search for the multiplier.
const LENGTH: f64 = 1e-3;

/// Newton's method for the multiplier converges monotonically, typically in three steps.
const MAX_ITERATIONS: usize = 50;

/// Multipliers this close to the smallest admissible one, relative to the largest eigenvalue, count as equal
/// to it.
const NEAR: f64 = 1e-10;

/// Eigenvalues and orthonormal eigenvectors (columns). If there are fewer of them than unknowns, the
/// complement has the eigenvalue zero and no gradient.
pub(super) struct Spectrum {
    values: Vec<f64>,
    vectors: Matrix,
    /// Eigenvalues of smaller magnitude are rounding errors.
    floor: f64,
}

impl Spectrum {
    /// Spectrum of `J^T J`, from the smaller one of `J^T J` and `J J^T`.
    pub(super) fn of_squares(jacobian: &Matrix) -> Option<Self> {
        /// Rounding error relative to the largest eigenvalue.
        const ROUNDING: f64 = 1e-15;
        let (m, n) = jacobian.shape();
        if n <= m {
            return Self::new(&jacobian.tr_mul(jacobian), 0.0);
        }
        let (values, left) = symmetric_eigen(&(jacobian * jacobian.transpose()))?;
        let largest = values.last().copied().unwrap_or(0.0);
        let kept: Vec<usize> = (0..m).filter(|&k| values[k] > ROUNDING * largest).collect();
        let mut vectors = jacobian.tr_mul(&left.select_columns(&kept));
        for (mut vector, &k) in vectors.column_iter_mut().zip(&kept) {
            vector /= values[k].sqrt();
        }
        let values = kept.into_iter().map(|k| values[k]).collect();
        Some(Self { values, vectors, floor: Self::floor(largest, 0.0) })
    }

    /// Spectrum of a symmetric matrix with an error of this size.
    pub(super) fn new(matrix: &Matrix, error: f64) -> Option<Self> {
        let (values, vectors) = symmetric_eigen(matrix)?;
        let largest = values.iter().fold(0.0, |largest: f64, value| largest.max(value.abs()));
        Some(Self { values, vectors, floor: Self::floor(largest, error) })
    }

    fn floor(largest: f64, error: f64) -> f64 {
        /// Rounding error relative to the largest eigenvalue, for the square of a matrix.
        const ROUNDING: f64 = 1e-14;
        (ROUNDING * largest).max(error)
    }

    /// The steps of at most this length that minimise the model with this gradient: one step, or two opposite
    /// ones if only negative curvature determines the direction. Empty at a minimum.
    pub(super) fn steps(&self, gradient: &[f64], radius: f64) -> Vec<Vec<f64>> {
        let along: Vec<f64> =
            (0..self.values.len()).map(|k| dot(self.vectors.column(k).as_slice(), gradient)).collect();
        let largest = self.values.iter().fold(0.0, |largest: f64, value| largest.max(value.abs()));
        if largest == 0.0 {
            return Vec::new();
        }
        let least = self.values.first().copied().unwrap_or(0.0);
        let is_indefinite = least < -self.floor;
        let step = |multiplier: f64| -> Vec<f64> {
            let stiffness = self.values.iter().map(|value| (value + multiplier).max(self.floor));
            along.iter().zip(stiffness).map(|(g, stiffness)| -g / stiffness).collect()
        };
        let first = if is_indefinite { -least + NEAR * largest } else { 0.0 };
        let mut found = step(first);
        let length = norm(&found);
        if length <= radius {
            if !is_indefinite {
                return vec![self.in_space(&found)];
            }
            // Continue to the boundary along the most negative curvature, in both directions.
            let rest = (radius * radius - length * length).sqrt() + found[0].abs();
            let sign = if found[0] < 0.0 { -1.0 } else { 1.0 };
            let is_open = found[0].abs() <= NEAR.sqrt() * radius;
            let ways = if is_open { vec![sign, -sign] } else { vec![sign] };
            let to_boundary = |way: f64| {
                let mut step = found.clone();
                step[0] = way * rest;
                self.in_space(&step)
            };
            return ways.into_iter().map(to_boundary).collect();
        }
        let mut multiplier = first;
        for _ in 0..MAX_ITERATIONS {
            let length = norm(&found);
            if (length - radius).abs() <= LENGTH * radius {
                break;
            }
            // Newton's method on 1 / |d| - 1 / radius.
            let slope: f64 = found
                .iter()
                .zip(&self.values)
                .map(|(d, value)| d * d / (value + multiplier).max(self.floor))
                .sum();
            multiplier += (length - radius) / radius * length * length / slope;
            found = step(multiplier);
        }
        vec![self.in_space(&found)]
    }

    fn in_space(&self, along: &[f64]) -> Vec<f64> {
        let mut step = vec![0.0; self.vectors.nrows()];
        for (vector, along) in self.vectors.column_iter().zip(along) {
            for (step, entry) in step.iter_mut().zip(vector.iter()) {
                *step += entry * along;
            }
        }
        step
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Smallest value of the model among many points of the ball.
    fn least_in_disc(matrix: &Matrix, gradient: &[f64], radius: f64) -> f64 {
        let mut least = 0.0_f64;
        for i in 0..=200 {
            for j in 0..720 {
                let (r, angle) = (radius * f64::from(i) / 200.0, f64::from(j).to_radians() / 2.0);
                least = least.min(value(matrix, gradient, &[r * angle.cos(), r * angle.sin()]));
            }
        }
        least
    }

    fn value(matrix: &Matrix, gradient: &[f64], step: &[f64]) -> f64 {
        let quadratic: f64 =
            (0..2).map(|i| (0..2).map(|j| step[i] * matrix[(i, j)] * step[j]).sum::<f64>()).sum();
        dot(gradient, step) + 0.5 * quadratic
    }

    #[test]
    fn steps_are_minima_of_the_model_in_the_ball() {
        let matrices =
            [[2.0, 0.5, 1.0], [1.0, 0.0, -2.0], [-1.0, 0.3, -2.0], [1.0, 1.0, 1.0], [3.0, 0.0, 0.0]];
        for [a, b, c] in matrices {
            let matrix = Matrix::from_row_slice(2, 2, &[a, b, b, c]);
            for gradient in [[1.0, -0.5], [0.01, 0.0], [0.0, 0.3], [0.0, 0.0]] {
                for radius in [0.1, 1.0, 3.0] {
                    let steps = Spectrum::new(&matrix, 0.0).unwrap().steps(&gradient, radius);
                    let least = least_in_disc(&matrix, &gradient, radius);
                    for step in &steps {
                        assert!(norm(step) <= radius * (1.0 + 2.0 * LENGTH));
                        let found = value(&matrix, &gradient, step);
                        assert!(
                            found <= least + 5e-3 * (radius + radius * radius),
                            "{matrix} {gradient:?} {radius}: {found} at {step:?}, not {least}"
                        );
                    }
                    assert!(!steps.is_empty());
                }
            }
        }
    }

    #[test]
    fn the_smaller_product_has_the_same_steps() {
        let wide = Matrix::from_row_slice(2, 4, &[1.0, 2.0, 0.0, -1.0, 0.5, 0.0, 3.0, 1.0]);
        let gradient: Vec<f64> =
            wide.tr_mul(&Matrix::from_column_slice(2, 1, &[0.7, -0.4])).as_slice().to_vec();
        for radius in [0.01, 0.1, 10.0] {
            let by_rows = &Spectrum::of_squares(&wide).unwrap().steps(&gradient, radius)[0];
            let by_columns = &Spectrum::new(&wide.tr_mul(&wide), 0.0).unwrap().steps(&gradient, radius)[0];
            assert!(by_rows.iter().zip(by_columns).all(|(a, b)| (a - b).abs() < 1e-3 * radius + 1e-12));
        }
    }
}
