//! Singular values, condition numbers and minimum-norm least-squares solutions.

use super::{Matrix, moderate, norm, view};

/// A minimum-norm least-squares solution.
#[derive(Clone, Debug, PartialEq)]
pub struct MinimumNorm {
    /// The solution, `pinv(A) b`.
    pub x: Vec<f64>,
    /// The numerical rank of A.
    pub rank: usize,
}

/// Solves `min |A x - b|` with the smallest `|x|`, by the pseudo-inverse. Singular values below
/// `max(m, n) eps sigma_max` count as zero (Golub and Van Loan 2013, section 5.5.8). `None` if A is not
/// finite or the singular value decomposition did not converge. Allocates.
pub fn minimum_norm_solution(a: &Matrix, b: &[f64]) -> Option<MinimumNorm> {
    let (m, n) = a.shape();
    let (a, scale) = moderate(a)?;
    let svd = view(&a).thin_svd().ok()?;
    let (u, s, v) = (svd.U(), svd.S().column_vector(), svd.V());
    let size = m.min(n);
    let largest = if size > 0 { s[0] } else { 0.0 };
    let threshold = m.max(n) as f64 * f64::EPSILON * largest;
    let mut x = vec![0.0; n];
    let mut rank = 0;
    for k in 0..size {
        if s[k] <= threshold {
            break;
        }
        rank += 1;
        let coefficient = (0..m).map(|i| u[(i, k)] * (b[i] / scale)).sum::<f64>() / s[k];
        for (j, x) in x.iter_mut().enumerate() {
            *x += coefficient * v[(j, k)];
        }
    }
    norm(&x).is_finite().then_some(MinimumNorm { x, rank })
}

/// `A = U diag(s) V^T` with square U and V, and the singular values s in decreasing order; `None` if `a` is
/// not finite. Allocates.
pub fn full_svd(a: &Matrix) -> Option<(Matrix, Vec<f64>, Matrix)> {
    if !a.iter().all(|v| v.is_finite()) {
        return None;
    }
    let svd = view(a).svd().ok()?;
    let (u, s, v) = (svd.U(), svd.S().column_vector(), svd.V());
    let (m, n) = a.shape();
    Some((
        Matrix::from_fn(m, m, |i, j| u[(i, j)]),
        (0..m.min(n)).map(|i| s[i]).collect(),
        Matrix::from_fn(n, n, |i, j| v[(i, j)]),
    ))
}

/// `A = U diag(s) V^T` with one column of U and V per singular value s, in decreasing order; `None` if `a` is
/// not finite. Allocates.
pub fn thin_svd(a: &Matrix) -> Option<(Matrix, Vec<f64>, Matrix)> {
    if !a.iter().all(|v| v.is_finite()) {
        return None;
    }
    let svd = view(a).thin_svd().ok()?;
    let (u, s, v) = (svd.U(), svd.S().column_vector(), svd.V());
    let ((m, n), size) = (a.shape(), a.nrows().min(a.ncols()));
    Some((
        Matrix::from_fn(m, size, |i, j| u[(i, j)]),
        (0..size).map(|i| s[i]).collect(),
        Matrix::from_fn(n, size, |i, j| v[(i, j)]),
    ))
}

/// Singular values of `a` in decreasing order; `None` if `a` is not finite. Allocates.
pub fn singular_values(a: &Matrix) -> Option<Vec<f64>> {
    let (a, scale) = moderate(a)?;
    let values = view(&a).singular_values().ok()?;
    Some(values.into_iter().map(|value| value * scale).collect())
}

/// Condition number in the 2-norm; infinite for singular matrices, NaN for non-finite ones. Allocates.
pub fn condition_number(a: &Matrix) -> f64 {
    match moderate(a).and_then(|(a, _)| view(&a).singular_values().ok()) {
        Some(s) if s.is_empty() => 1.0,
        Some(s) if s[s.len() - 1] > 0.0 => s[0] / s[s.len() - 1],
        Some(_) => f64::INFINITY,
        None => f64::NAN,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn minimum_norm_of_wide_tall_and_singular_systems() {
        let wide = Matrix::from_row_slice(1, 2, &[3.0, 4.0]);
        let solution = minimum_norm_solution(&wide, &[25.0]).unwrap();
        assert!((solution.x[0] - 3.0).abs() < 1e-14 && (solution.x[1] - 4.0).abs() < 1e-14);
        let tall = Matrix::from_row_slice(2, 1, &[1.0, 1.0]);
        assert!((minimum_norm_solution(&tall, &[1.0, 3.0]).unwrap().x[0] - 2.0).abs() < 1e-14);
        let singular = Matrix::from_row_slice(2, 2, &[1.0, 1.0, 1.0, 1.0]);
        let solution = minimum_norm_solution(&singular, &[2.0, 2.0]).unwrap();
        assert_eq!(solution.rank, 1);
        assert!((solution.x[0] - 1.0).abs() < 1e-14 && (solution.x[1] - 1.0).abs() < 1e-14);
        assert_eq!(minimum_norm_solution(&Matrix::zeros(1, 1), &[1.0]).unwrap().x, [0.0]);
        assert_eq!(minimum_norm_solution(&Matrix::from_element(1, 1, f64::NAN), &[1.0]), None);
    }

    #[test]
    fn conditions() {
        let diagonal = Matrix::from_row_slice(2, 2, &[1e3, 0.0, 0.0, 1e-3]);
        assert!((condition_number(&diagonal) / 1e6 - 1.0).abs() < 1e-12);
        assert_eq!(condition_number(&Matrix::zeros(2, 2)), f64::INFINITY);
        assert!(condition_number(&Matrix::from_element(2, 2, f64::NAN)).is_nan());
    }
}
