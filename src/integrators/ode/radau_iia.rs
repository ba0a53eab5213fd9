//! The Radau IIA method of order 5 with three stages, independent of the problem type: coefficients and
//! step-size control (Hairer and Wanner 1996, "Solving Ordinary
//! Differential Equations II", section IV.8, and their code RADAU5).

use super::norm::scaled_norm;
use crate::integrators::chord::NEWTON_ITERATIONS;

/// Number of stages.
pub(crate) const STAGES: usize = 3;
pub(crate) const SQRT_6: f64 = 2.449489742783178;
/// Times of the stages (Hairer and Wanner 1996, table IV.5.6).
pub(crate) const C: [f64; STAGES] = [(4.0 - SQRT_6) / 10.0, (4.0 + SQRT_6) / 10.0, 1.0];
/// Weights of the stages in the error estimate, times the real eigenvalue (ibid., eq. IV.8.18).
pub(crate) const E: [f64; STAGES] = [(-13.0 - 7.0 * SQRT_6) / 3.0, (-13.0 + 7.0 * SQRT_6) / 3.0, -1.0 / 3.0];
/// Weights A of the stages (Hairer and Wanner 1996, table IV.5.6); the last row contains the weights of the
/// step.
pub(crate) const A: [[f64; STAGES]; STAGES] = [
    [(88.0 - 7.0 * SQRT_6) / 360.0, (296.0 - 169.0 * SQRT_6) / 1800.0, (-2.0 + 3.0 * SQRT_6) / 225.0],
    [(296.0 + 169.0 * SQRT_6) / 1800.0, (88.0 + 7.0 * SQRT_6) / 360.0, (-2.0 - 3.0 * SQRT_6) / 225.0],
    [(16.0 - SQRT_6) / 36.0, (16.0 + SQRT_6) / 36.0, 1.0 / 9.0],
];
/// `A^2`, for second-order equations.
pub(crate) const A_SQUARED: [[f64; STAGES]; STAGES] =
    [product(&A[0], &A), product(&A[1], &A), product(&A[2], &A)];
/// Inverse of `A^2`, which maps displacements of the stages to accelerations.
pub(crate) const A_SQUARED_INVERSE: [[f64; STAGES]; STAGES] = inverse(&A_SQUARED);
/// Weights of accelerations in the error estimate: through velocities, `E A`,
pub(crate) const E_A: [f64; STAGES] = product(&E, &A);
/// and through displacements, `E A^2`.
pub(crate) const E_A_SQUARED: [f64; STAGES] = product(&E, &A_SQUARED);
/// Real eigenvalue of the inverse of A, `3 + 3^(2/3) - 3^(1/3)` (ibid., eq. IV.8.15).
pub(crate) const MU_REAL: f64 = 3.637834252744496;
/// One eigenvalue of the complex pair, `3 + (3^(1/3) - 3^(2/3)) / 2 - i (3^(5/6) + 3^(7/6)) / 2`.
pub(crate) const MU_COMPLEX: (f64, f64) = (2.6810828736277523, -3.0504301992474105);
/// The transformation T (RADAU5).
pub(crate) const T: [[f64; STAGES]; STAGES] = [
    [0.09443876248897524, -0.1412552950209542, 0.03002919410514742],
    [0.2502131229653333, 0.20412935229379994, -0.3829421127572619],
    [1.0, 1.0, 0.0],
];
/// Inverse of T (RADAU5).
pub(crate) const T_INVERSE: [[f64; STAGES]; STAGES] = [
    [4.178718591551904, 0.32768282076106237, 0.5233764454994495],
    [-4.178718591551904, -0.32768282076106237, 0.47662355450055044],
    [0.5028726349457868, -2.571926949855605, 0.5960392048282249],
];
/// Step factor when the Newton iteration does not converge (RADAU5).
pub(crate) const DIVERGENCE_FACTOR: f64 = 0.5;
/// Bounds of the step factor (SciPy; RADAU5: 1/8 and 5).
pub(crate) const SMALLEST_FACTOR: f64 = 0.2;
pub(crate) const LARGEST_FACTOR: f64 = 10.0;
/// Factors between 1 and this one leave the step size, and hence the factorisations, unchanged (RADAU5:
/// QUOT2).
const SMALLEST_GROWTH: f64 = 1.2;
/// Safety factor of a step with the fewest iterations (RADAU5: SAFE).
const SAFETY: f64 = 0.9;
/// Step sizes count as equal up to the rounding of their end times.
pub(crate) const SAME_SIZE: f64 = 1e-8;

/// Size of a step and its error estimate relative to the tolerances.
#[derive(Clone, Copy, Debug)]
pub(crate) struct StepError {
    pub(crate) h_abs: f64,
    pub(crate) error: f64,
}

/// Order of the embedded formula.
pub(crate) const ERROR_ORDER: f64 = 3.0;

/// Factor of the step size from the errors and sizes of two steps (Gustafsson 1994; Hairer and Wanner 1996,
/// eq. IV.8.25). The factor is larger after fewer iterations (ibid., eq. IV.8.21).
pub(crate) fn step_factor(step: StepError, last: Option<StepError>, iterations: usize) -> f64 {
    let exponent = 1.0 / (ERROR_ORDER + 1.0);
    let trend = match last {
        Some(last) if step.error > 0.0 => step.h_abs / last.h_abs * (last.error / step.error).powf(exponent),
        _ => 1.0,
    };
    let (allowed, used) = (2 * NEWTON_ITERATIONS + 1, 2 * NEWTON_ITERATIONS + iterations);
    SAFETY * allowed as f64 / used as f64 * (trend.min(1.0) * step.error.powf(-exponent))
}

/// Size of the step after an accepted one, from the step factor.
pub(crate) fn next_size(h_abs: f64, factor: f64, wants_jacobian: bool) -> f64 {
    let keep = !wants_jacobian && factor < SMALLEST_GROWTH;
    h_abs * if keep { 1.0 } else { factor.min(LARGEST_FACTOR) }
}

/// Whether factorisations for one step size are valid for another one.
pub(crate) fn is_same_size(h: f64, factorised_for: f64) -> bool {
    (h / factorised_for - 1.0).abs() <= SAME_SIZE
}

/// Row times matrix.
const fn product(row: &[f64; STAGES], matrix: &[[f64; STAGES]; STAGES]) -> [f64; STAGES] {
    let mut out = [0.0; STAGES];
    let mut i = 0;
    while i < STAGES {
        let mut j = 0;
        while j < STAGES {
            out[i] += row[j] * matrix[j][i];
            j += 1;
        }
        i += 1;
    }
    out
}

/// By cofactors.
const fn inverse(m: &[[f64; STAGES]; STAGES]) -> [[f64; STAGES]; STAGES] {
    let mut out = [[0.0; STAGES]; STAGES];
    let mut determinant = 0.0;
    let mut i = 0;
    while i < STAGES {
        let (i1, i2) = ((i + 1) % STAGES, (i + 2) % STAGES);
        let mut j = 0;
        while j < STAGES {
            let (j1, j2) = ((j + 1) % STAGES, (j + 2) % STAGES);
            out[j][i] = m[i1][j1] * m[i2][j2] - m[i1][j2] * m[i2][j1];
            j += 1;
        }
        determinant += m[0][i] * (m[1][i1] * m[2][i2] - m[1][i2] * m[2][i1]);
        i += 1;
    }
    let mut i = 0;
    while i < STAGES * STAGES {
        out[i / STAGES][i % STAGES] /= determinant;
        i += 1;
    }
    out
}

/// `out_i <- sum_j matrix[i][j] vectors_j`.
pub(crate) fn transform(matrix: &[[f64; STAGES]; STAGES], vectors: &[f64], out: &mut [f64]) {
    let n = vectors.len() / STAGES;
    for (row, out) in matrix.iter().zip(out.chunks_exact_mut(n)) {
        for (i, value) in out.iter_mut().enumerate() {
            *value = (0..STAGES).map(|stage| row[stage] * vectors[stage * n + i]).sum();
        }
    }
}

/// Root of the mean over the stages of the squared scaled corrections.
pub(crate) fn norm_of_stages(stages: &[f64], scale: &[f64]) -> f64 {
    let norm = stages.chunks_exact(scale.len()).map(|stage| scaled_norm(stage, scale).powi(2)).sum::<f64>();
    (norm / STAGES as f64).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_eigenvalues_are_those_of_the_inverse_of_a() {
        // A T = T inv(Mu), Mu with the real eigenvalue and the block of the pair.
        let (re, im) = MU_COMPLEX;
        let size = re * re + im * im;
        let inverse = [[1.0 / MU_REAL, 0.0, 0.0], [0.0, re / size, im / size], [0.0, -im / size, re / size]];
        for (row, t) in A.iter().zip(&T) {
            let (left, right) = (product(row, &T), product(t, &inverse));
            for (left, right) in left.iter().zip(right) {
                assert!((left - right).abs() < 1e-15, "{left} {right}");
            }
        }
    }

    #[test]
    fn the_square_of_a_has_its_inverse() {
        for (i, row) in A_SQUARED_INVERSE.iter().enumerate() {
            for (j, entry) in product(row, &A_SQUARED).iter().enumerate() {
                assert!((entry - f64::from(u8::from(i == j))).abs() < 1e-14, "{i} {j}: {entry}");
            }
        }
    }

    #[test]
    fn constant_velocities_and_accelerations_have_no_error() {
        // E z / h = -v0 for z = c h v0. Its second-order counterpart has q = c^2 h^2 a0 / 2 and v = c h a0.
        let dot = |x: [f64; STAGES]| x.iter().zip(E).map(|(x, e)| x * e).sum::<f64>();
        assert!((dot(C) + 1.0).abs() < 1e-14);
        assert!(E_A_SQUARED.iter().sum::<f64>().abs() < 1e-14);
        assert!((E_A.iter().sum::<f64>() + 1.0).abs() < 1e-14);
    }
}
