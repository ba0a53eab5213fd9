//! Eigenvalues of symmetric pencils `K x = l M x`, each with a bound of its error, by Jacobi's method.
//!
//! The usual eigensolvers have errors in proportion to the largest eigenvalue. In a stiff robot these would hide the slow motions:
//! shear waves across a wire are millions of times faster than its vibrations. Here the mass matrix is factorised, because
//! it stays well conditioned where the stiffness is nearly singular, and Jacobi's method then removes the remaining
//! coupling. In graded matrices it is accurate to rounding of each entry (Barlow and Demmel 1990, "Computing accurate
//! eigensystems of scaled diagonally dominant matrices"; Demmel and Veselic 1992, "Jacobi's method is more accurate than QR").
//!
//! An uncertainty E of the entries of the stiffness changes the eigenvalue of a shape x by at most `|x|^T E |x| / x^T M x` to first
//! order: a backward error for this direction (Rigal and Gaches 1967), independent of stiff directions elsewhere.

use crate::numerics::linalg::{Matrix, symmetric_eigen, symmetric_part};

/// Largest number of sweeps of Jacobi's method. It starts near the solution and usually converges in two to five sweeps, in 14 where
/// eigenvalues differ by factors of 1e26.
const SWEEPS: usize = 60;

/// Eigenvalues and shapes of K x = lambda M x.
#[derive(Clone, Debug)]
pub struct Eigenpairs {
    /// Eigenvalues in increasing order.
    pub values: Vec<f64>,
    /// Bounds of their errors.
    pub bounds: Vec<f64>,
    /// Columns X with `X^T M X = 1`.
    pub shapes: Matrix,
}

impl Eigenpairs {
    /// Solves a symmetric pencil; `error` bounds the error of each entry of the stiffness. `None` if the mass is not positive
    /// definite or a number is not finite. Cost: about 30 n^3 flops.
    pub fn new(stiffness: &Matrix, mass: &Matrix, error: &Matrix) -> Option<Self> {
        let stiffness = symmetric_part(stiffness);
        let mut shapes = by_mass(&stiffness, mass)?;
        let mut coupled = symmetric_part(&shapes.tr_mul(&(&stiffness * &shapes)));
        diagonalise(&mut coupled, &mut shapes);
        let mut order: Vec<(f64, f64, usize)> = Vec::with_capacity(shapes.ncols());
        let (with_stiffness, with_mass) = (&stiffness * &shapes, mass * &shapes);
        let sizes = shapes.abs();
        let with_error = error * &sizes;
        for k in 0..shapes.ncols() {
            let square = shapes.column(k).dot(&with_mass.column(k));
            let value = shapes.column(k).dot(&with_stiffness.column(k)) / square;
            let bound = sizes.column(k).dot(&with_error.column(k)) / square;
            shapes.column_mut(k).unscale_mut(square.sqrt());
            if !value.is_finite() || bound.is_nan() {
                return None;
            }
            order.push((value, bound, k));
        }
        // Shapes contain a part of the stiffest one of the size of rounding, which adds its square times the largest eigenvalue.
        let stiffest = order.iter().fold(0.0, |largest: f64, (value, ..)| largest.max(value.abs()));
        let mixed = stiffest * (stiffness.nrows() as f64 * f64::EPSILON).powi(2);
        order.iter_mut().for_each(|(_, bound, _)| *bound += mixed);
        order.sort_by(|a, b| a.0.total_cmp(&b.0));
        Some(Self {
            values: order.iter().map(|(value, ..)| *value).collect(),
            bounds: order.iter().map(|(_, bound, _)| *bound).collect(),
            shapes: shapes.select_columns(order.iter().map(|(.., k)| k)),
        })
    }

    /// Extends the bounds to cover a change of the stiffness. An entry that couples two shapes moves their eigenvalues by at most its
    /// size, and at most its square over their distance (Mathias 1998, "Quadratic residual bounds for the Hermitian eigenvalue problem").
    pub fn with_change(mut self, change: &Matrix) -> Self {
        if change.iter().all(|x| *x == 0.0) {
            return self;
        }
        let change = self.shapes.tr_mul(&(change * &self.shapes)).abs();
        for (k, bound) in self.bounds.iter_mut().enumerate() {
            let moved = |j: usize| {
                let (coupling, apart) = (change[(j, k)], (self.values[j] - self.values[k]).abs());
                if j == k || coupling >= apart { coupling } else { coupling * (coupling / apart) }
            };
            *bound += (0..self.values.len()).map(moved).sum::<f64>();
        }
        self
    }

    /// Whether an eigenvalue may be zero within its bound.
    pub fn is_neutral(&self, k: usize) -> bool {
        self.values[k].abs() <= self.bounds[k]
    }
}

/// Shapes by the eigenvalues of `L^-1 K L^-T`, with `M = L L^T` scaled to a unit diagonal.
fn by_mass(stiffness: &Matrix, mass: &Matrix) -> Option<Matrix> {
    let n = mass.nrows();
    let scales: Vec<f64> = (0..n).map(|i| 1.0 / mass[(i, i)].sqrt()).collect();
    if !scales.iter().all(|scale| scale.is_finite()) {
        return None;
    }
    let scaled = |a: &Matrix| Matrix::from_fn(n, n, |i, j| a[(i, j)] * scales[i] * scales[j]);
    let lower = scaled(mass).cholesky()?.l();
    let (_, mut shapes) = symmetric_eigen(&reduced(&scaled(stiffness), &lower)?)?;
    lower.tr_solve_lower_triangular_mut(&mut shapes).then_some(())?;
    for (mut row, scale) in shapes.row_iter_mut().zip(&scales) {
        row *= *scale;
    }
    // Fast shapes, which move little mass, are less accurate than slow ones: make them orthogonal to the slower ones.
    let lower = symmetric_part(&shapes.tr_mul(&(mass * &shapes))).cholesky()?.l();
    let mut rows = shapes.transpose();
    lower.solve_lower_triangular_mut(&mut rows).then_some(rows.transpose())
}

/// `L^-1 A L^-T`.
fn reduced(a: &Matrix, lower: &Matrix) -> Option<Matrix> {
    let mut half = a.clone();
    lower.solve_lower_triangular_mut(&mut half).then_some(())?;
    let mut whole = half.transpose();
    lower.solve_lower_triangular_mut(&mut whole).then_some(whole.transpose())
}

/// Jacobi's method: rotates pairs of shapes until all are uncoupled (Golub and Van Loan 2013, section 8.5).
fn diagonalise(a: &mut Matrix, shapes: &mut Matrix) {
    let n = a.nrows();
    for _ in 0..SWEEPS {
        let mut is_done = true;
        for j in 1..n {
            for i in 0..j {
                let coupling = a[(i, j)];
                let sizes = a[(i, i)].abs().sqrt() * a[(j, j)].abs().sqrt();
                if coupling.abs() <= f64::EPSILON * sizes || !coupling.is_finite() {
                    continue;
                }
                is_done = false;
                let half = 0.5 * (a[(j, j)] - a[(i, i)]);
                let tangent = coupling / (half + half.hypot(coupling).copysign(half));
                let cosine = 1.0 / tangent.hypot(1.0);
                let sine = tangent * cosine;
                let (first, second) = (a[(i, i)] - tangent * coupling, a[(j, j)] + tangent * coupling);
                turn(a, [i, j], [cosine, sine]);
                for k in 0..n {
                    (a[(i, k)], a[(j, k)]) = (a[(k, i)], a[(k, j)]);
                }
                (a[(i, i)], a[(j, j)], a[(i, j)], a[(j, i)]) = (first, second, 0.0, 0.0);
                turn(shapes, [i, j], [cosine, sine]);
            }
        }
        if is_done {
            return;
        }
    }
}

/// Rotates two columns, i < j.
fn turn(a: &mut Matrix, [i, j]: [usize; 2], [cosine, sine]: [f64; 2]) {
    let rows = a.nrows();
    let (before, after) = a.as_mut_slice().split_at_mut(j * rows);
    let (left, right) = (&mut before[i * rows..(i + 1) * rows], &mut after[..rows]);
    for (x, y) in left.iter_mut().zip(right) {
        (*x, *y) = (cosine * *x - sine * *y, sine * *x + cosine * *y);
    }
}

/// Whether a symmetric matrix is positive definite for all errors of its entries up to `error`: a sufficient condition. Cost:
/// n^3 / 3 flops.
pub fn is_positive(a: &Matrix, error: &Matrix) -> bool {
    let n = a.nrows();
    let scales: Vec<f64> = (0..n).map(|i| 1.0 / a[(i, i)].sqrt()).collect();
    if !scales.iter().all(|scale| scale.is_finite()) {
        return false;
    }
    // 2 |x_i x_j| e_ij <= (x_i^2 + x_j^2) e_ij, and rounding of the factors themselves (Higham 2002, theorem 10.3).
    let rounding = 2.0 * (n + 1) as f64 * f64::EPSILON;
    let mut least = Matrix::from_fn(n, n, |i, j| 0.5 * (a[(i, j)] + a[(j, i)]) * scales[i] * scales[j]);
    for i in 0..n {
        let errors: f64 = (0..n).map(|j| 0.5 * (error[(i, j)] + error[(j, i)]) * scales[i] * scales[j]).sum();
        least[(i, i)] -= errors + rounding;
    }
    least.cholesky().is_some()
}

/// Whether a symmetric matrix has a negative eigenvalue for all errors of its entries up to `error`, tested along the lowest
/// eigenvector: a sufficient condition. Cost: about 9 n^3 flops.
pub fn is_negative(a: &Matrix, error: &Matrix) -> bool {
    let n = a.nrows();
    let Some((values, shapes)) = symmetric_eigen(&symmetric_part(a)) else { return false };
    let (Some(lowest), Some(highest)) = (values.first(), values.last()) else { return false };
    let rounding = n as f64 * f64::EPSILON * lowest.abs().max(highest.abs());
    let sizes = shapes.column(0).abs();
    *lowest < -(sizes.dot(&(error * &sizes)) + rounding)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A chain of masses 1 with springs 1, in mixed coordinates scaled by factors from 1 to 1e-9.
    fn disguised(n: usize, sizes: impl Fn(usize) -> f64, stiffness: impl Fn(usize) -> f64) -> [Matrix; 3] {
        // X has columns of these sizes: K = X diag(k) X^T with exact eigenvalues needs M = X X^T.
        let mix = Matrix::from_fn(n, n, |i, j| {
            let x = if i == j { 1.0 } else { 0.3 / (1.0 + (i + 2 * j) as f64) };
            x * sizes(i)
        });
        let values = Matrix::from_diagonal(&(0..n).map(stiffness).collect::<Vec<_>>().into());
        let (k, m) = (&mix * &values * mix.transpose(), &mix * mix.transpose());
        let error = mix.abs() * values.abs() * mix.abs().transpose() * (4.0 * n as f64 * f64::EPSILON);
        [k, m, error]
    }

    #[test]
    fn eigenvalues_are_within_their_bounds() {
        for exponent in [0, 3, 6, 9] {
            let values: Vec<f64> =
                (0..6).map(|i| if i == 0 { 0.0 } else { 10f64.powi(exponent * i / 3) }).collect();
            let [k, m, error] = disguised(6, |i| 10f64.powi(-(2 * i as i32) % 7), |i| values[i]);
            let found = Eigenpairs::new(&k, &m, &error).unwrap();
            assert!(found.is_neutral(0), "{found:?}");
            for (i, value) in values.iter().enumerate().skip(1) {
                let wrong = (found.values[i] - value).abs();
                assert!(wrong <= found.bounds[i] + 1e-12 * value, "{exponent}, {i}: {found:?}");
            }
            let one = found.shapes.tr_mul(&(&m * &found.shapes));
            assert!((one - Matrix::identity(6, 6)).norm() < 1e-12);
        }
    }

    /// Two uncoupled parts: one is stiff, the other is soft or slightly unstable.
    #[test]
    fn stiff_parts_do_not_blur_soft_ones() {
        for stiff in [1.0, 1e8, 1e16, 1e24] {
            for soft in [1e-4, -1e-4] {
                let k = Matrix::from_row_slice(
                    3,
                    3,
                    &[2.0 * stiff, stiff, 0.0, stiff, stiff, 0.0, 0.0, 0.0, soft],
                );
                let error = k.abs() * (12.0 * f64::EPSILON);
                let found = Eigenpairs::new(&k, &Matrix::identity(3, 3), &error).unwrap();
                let k = found.values.iter().position(|value| (value - soft).abs() < 1e-15).unwrap();
                assert!(!found.is_neutral(k));
            }
        }
    }

    #[test]
    fn only_certain_matrices_are_positive() {
        let a = Matrix::from_row_slice(2, 2, &[1.0, 0.9, 0.9, 1.0]);
        assert!(is_positive(&a, &Matrix::from_element(2, 2, 0.04)));
        assert!(!is_positive(&a, &Matrix::from_element(2, 2, 0.06)));
        assert!(!is_positive(&(&a * f64::NAN), &Matrix::zeros(2, 2)));
        assert!(!is_positive(&-a, &Matrix::zeros(2, 2)));
        assert!(is_positive(&Matrix::zeros(0, 0), &Matrix::zeros(0, 0)));
        let free = Matrix::from_row_slice(2, 2, &[1.0, -1.0, -1.0, 1.0]);
        assert!(!is_positive(&free, &Matrix::zeros(2, 2)));
    }

    #[test]
    fn only_certain_matrices_are_negative_somewhere() {
        let a = Matrix::from_row_slice(2, 2, &[1.0, 1.1, 1.1, 1.0]);
        assert!(is_negative(&a, &Matrix::from_element(2, 2, 0.04)));
        assert!(!is_negative(&a, &Matrix::from_element(2, 2, 0.06)));
        assert!(!is_negative(&(&a * f64::NAN), &Matrix::zeros(2, 2)));
        assert!(!is_negative(&Matrix::zeros(0, 0), &Matrix::zeros(0, 0)));
        assert!(!is_negative(&Matrix::identity(3, 3), &Matrix::zeros(3, 3)));
    }

    #[test]
    fn there_are_no_pairs_without_mass() {
        let one = Matrix::identity(2, 2);
        let mass = Matrix::from_row_slice(2, 2, &[1.0, 0.0, 0.0, 0.0]);
        assert!(Eigenpairs::new(&one, &mass, &one).is_none());
        assert!(Eigenpairs::new(&(&one * f64::NAN), &one, &one).is_none());
        assert!(Eigenpairs::new(&Matrix::zeros(0, 0), &Matrix::zeros(0, 0), &Matrix::zeros(0, 0)).is_some());
    }
}
