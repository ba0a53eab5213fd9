//! Eigenvalues of dense matrices, by faer. All of these functions allocate.

use super::{Matrix, moderate, view};

/// A complex number.
pub type Complex = nalgebra::Complex<f64>;

/// Half of a square matrix and its transpose.
pub fn symmetric_part(a: &Matrix) -> Matrix {
    (a + a.transpose()) * 0.5
}

/// Eigenvalues of a symmetric matrix (only its lower triangle is read) in increasing order; `None` if the
/// matrix is not finite. Cost: 4/3 n^3 flops.
pub fn symmetric_eigenvalues(a: &Matrix) -> Option<Vec<f64>> {
    let (a, scale) = moderate(a)?;
    let values = view(&a).self_adjoint_eigenvalues(faer::Side::Lower).ok()?;
    Some(values.into_iter().map(|value| value * scale).collect())
}

/// Eigenvalues of a symmetric matrix (only its lower triangle is read) in increasing order, with orthonormal
/// eigenvectors as columns; `None` if the matrix is not finite. Cost: about 9 n^3 flops.
pub fn symmetric_eigen(a: &Matrix) -> Option<(Vec<f64>, Matrix)> {
    if a.is_empty() {
        // faer counts its memory from the size less one.
        return Some((Vec::new(), a.clone()));
    }
    let (a, scale) = moderate(a)?;
    let evd = view(&a).self_adjoint_eigen(faer::Side::Lower).ok()?;
    let (values, vectors) = (evd.S().column_vector(), evd.U());
    let n = a.nrows();
    Some(((0..n).map(|i| values[i] * scale).collect(), Matrix::from_fn(n, n, |i, j| vectors[(i, j)])))
}

/// Eigenvalues of a square matrix, in no particular order; `None` if it is not finite. Cost: about 10 n^3
/// flops.
pub fn eigenvalues(a: &Matrix) -> Option<Vec<Complex>> {
    let (a, scale) = moderate(a)?;
    let values = view(&a).eigenvalues().ok()?;
    Some(values.into_iter().map(|value| value * scale).collect())
}

/// Eigenvalues of a square matrix, in no particular order, each with its right eigenvector of norm one;
/// `None` if the matrix is not finite. Cost: about 25 n^3 flops.
pub fn eigen(a: &Matrix) -> Option<Vec<(Complex, Vec<Complex>)>> {
    let (a, scale) = moderate(a)?;
    let evd = view(&a).eigen().ok()?;
    let (values, vectors) = (evd.S().column_vector(), evd.U());
    let n = a.nrows();
    let pairs = (0..n).map(|k| {
        let vector: Vec<Complex> = (0..n).map(|i| vectors[(i, k)]).collect();
        let norm = vector.iter().map(Complex::norm_sqr).sum::<f64>().sqrt();
        (values[k] * scale, vector.into_iter().map(|x| x / norm).collect())
    });
    Some(pairs.collect())
}

/// An eigenvalue with its right and its left eigenvector.
pub(crate) type Eigentriple = (Complex, Vec<Complex>, Vec<Complex>);

/// Eigenvalues of a square matrix, in no particular order, each with a right eigenvector x of norm one and the left one y with
/// `y^T x = 1`: a change E of the matrix changes the eigenvalue by `y^T E x`. If eigenvectors coincide, so that any change of the
/// matrix matters, the left ones are huge. `None` if the matrix is not finite. Cost: about 35 n^3 flops.
pub fn eigen_both(a: &Matrix) -> Option<Vec<Eigentriple>> {
    let pairs = eigen(a)?;
    let n = pairs.len();
    let right = nalgebra::DMatrix::from_fn(n, n, |i, k| pairs[k].1[i]);
    // The largest number whose square is finite.
    let huge = || nalgebra::DMatrix::from_element(n, n, Complex::from(f64::MAX.sqrt()));
    let left = right.try_inverse().unwrap_or_else(huge);
    let triples = pairs.into_iter().enumerate().map(|(k, (value, right))| {
        let left = left.row(k).iter().copied().collect();
        (value, right, left)
    });
    Some(triples.collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn symmetric_matrices() {
        let a = Matrix::from_row_slice(3, 3, &[2.0, -1.0, 0.0, -1.0, 2.0, -1.0, 0.0, -1.0, 2.0]);
        let exact = [2.0 - 2f64.sqrt(), 2.0, 2.0 + 2f64.sqrt()];
        let (values, vectors) = symmetric_eigen(&a).unwrap();
        for (i, exact) in exact.into_iter().enumerate() {
            assert!((values[i] - exact).abs() < 1e-14);
            let vector = vectors.column(i);
            assert!((&a * vector - vector * exact).norm() < 1e-14);
        }
        assert_eq!(symmetric_eigenvalues(&a).unwrap().len(), 3);
        assert!(symmetric_eigenvalues(&(a * f64::NAN)).is_none());
        assert!(symmetric_eigenvalues(&Matrix::zeros(0, 0)).unwrap().is_empty());
        assert!(symmetric_eigen(&Matrix::zeros(0, 0)).unwrap().0.is_empty());
    }

    #[test]
    fn a_rotation_has_complex_eigenvalues() {
        let a = Matrix::from_row_slice(2, 2, &[0.0, -3.0, 3.0, 0.0]);
        for (value, vector) in eigen(&a).unwrap() {
            assert!(value.re.abs() < 1e-14 && (value.im.abs() - 3.0).abs() < 1e-14);
            let residual = Complex::from(-3.0) * vector[1] - value * vector[0];
            assert!(residual.norm() < 1e-14);
        }
        assert_eq!(eigenvalues(&a).unwrap().len(), 2);
        assert!(eigen(&Matrix::from_element(2, 2, f64::INFINITY)).is_none());
        assert!(eigenvalues(&Matrix::from_element(2, 2, f64::NAN)).is_none());
    }
}
