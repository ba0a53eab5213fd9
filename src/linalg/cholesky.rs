//! Cholesky factorisation of symmetric positive definite matrices.

use super::Matrix;

/// The matrix was not positive definite (or not finite).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NotPositiveDefinite;

/// `A = L L^T`, with memory for repeated use at one size.
#[derive(Clone, Debug)]
pub struct Cholesky {
    // Some: the factorised matrix. The buffer moves between the two without being reallocated.
    factors: Option<nalgebra::Cholesky<f64, nalgebra::Dyn>>,
    buffer: Matrix,
}

impl Cholesky {
    /// Memory for matrices of size `n`.
    pub fn new(n: usize) -> Self {
        Self { factors: None, buffer: Matrix::zeros(n, n) }
    }

    /// Factorises `a` (n x n; only its lower triangle is read). Cost: n^3 / 3 flops.
    pub fn factorise(&mut self, a: &Matrix) -> Result<(), NotPositiveDefinite> {
        let mut buffer = match self.factors.take() {
            Some(factors) => factors.unpack_dirty(),
            None => std::mem::replace(&mut self.buffer, Matrix::zeros(0, 0)),
        };
        if buffer.shape() != a.shape() {
            // Only after a failure, which consumed the buffer.
            buffer = Matrix::zeros(a.nrows(), a.ncols());
        }
        buffer.copy_from(a);
        if !buffer.iter().all(|v| v.is_finite()) {
            self.buffer = buffer;
            return Err(NotPositiveDefinite);
        }
        self.factors = nalgebra::Cholesky::new(buffer);
        if self.factors.is_some() { Ok(()) } else { Err(NotPositiveDefinite) }
    }

    /// Solves `A x = b` in place.
    ///
    /// # Panics
    /// When the last factorisation failed or none was made.
    pub fn solve(&self, b: &mut [f64]) {
        let factors = self.factors.as_ref().expect("solve comes after a successful factorise");
        let mut b = nalgebra::DVectorViewMut::from_slice(b, b.len());
        factors.solve_mut(&mut b);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn solves_again_after_a_failure() {
        let good = Matrix::from_row_slice(2, 2, &[4.0, 2.0, 2.0, 3.0]);
        let mut cholesky = Cholesky::new(2);
        assert_eq!(cholesky.factorise(&-&good), Err(NotPositiveDefinite));
        assert_eq!(cholesky.factorise(&(&good * f64::NAN)), Err(NotPositiveDefinite));
        cholesky.factorise(&good).unwrap();
        let mut b = [2.0, -1.0];
        cholesky.solve(&mut b);
        assert!((4.0 * b[0] + 2.0 * b[1] - 2.0).abs() < 1e-14);
        assert!((2.0 * b[0] + 3.0 * b[1] + 1.0).abs() < 1e-14);
    }
}
