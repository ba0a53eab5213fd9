//! Cholesky factorisation of symmetric positive definite matrices.

use dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::llt::{factor, solve};
use faer::{Conj, MatMut, Par};

use super::failure::NotPositiveDefinite;
use super::{Matrix, small_cholesky, view, view_mut};

/// Up to this size [`small_cholesky`] is faster than faer, or equally fast: factorising and solving takes
/// half of faer's time at n = 2, 0.9 at 8 and 12, and 1.3 times as long at 16 to 24; nalgebra's is never the
/// fastest by more than the measurement's error (`benches/dense.rs`, two-core x86-64, 2026).
const SMALL: usize = 12;

/// `A = L L^T`, with memory for repeated use at a fixed size.
pub struct Cholesky {
    factors: Matrix,
    is_factorised: bool,
    memory: MemBuffer,
}

impl std::fmt::Debug for Cholesky {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Cholesky").field("factors", &self.factors).finish_non_exhaustive()
    }
}

impl Clone for Cholesky {
    fn clone(&self) -> Self {
        let memory = Self::memory(self.factors.nrows());
        Self { factors: self.factors.clone(), is_factorised: self.is_factorised, memory }
    }
}

impl Cholesky {
    /// Memory for matrices of size `n`.
    pub fn new(n: usize) -> Self {
        Self { factors: Matrix::zeros(n, n), is_factorised: false, memory: Self::memory(n) }
    }

    fn memory(n: usize) -> MemBuffer {
        MemBuffer::new(factor::cholesky_in_place_scratch::<f64>(n, Par::Seq, Default::default()))
    }

    /// Factorises `a` (n x n; only its lower triangle is used). Cost: n^3 / 3 flops.
    pub fn factorise(&mut self, a: &Matrix) -> Result<(), NotPositiveDefinite> {
        self.is_factorised = false;
        self.factors.copy_from(a);
        let n = a.nrows();
        if n <= SMALL {
            small_cholesky::factorise(self.factors.as_mut_slice(), n)?;
        } else if a.iter().all(|entry| entry.is_finite()) {
            factor::cholesky_in_place(
                view_mut(&mut self.factors),
                Default::default(),
                Par::Seq,
                MemStack::new(&mut self.memory),
                Default::default(),
            )
            .map_err(|_| NotPositiveDefinite)?;
        } else {
            return Err(NotPositiveDefinite);
        }
        self.is_factorised = true;
        Ok(())
    }

    /// The smallest pivot, the square of a diagonal entry of the factor.
    ///
    /// # Panics
    ///
    /// If the last factorisation failed, or there was none.
    pub fn smallest_pivot(&self) -> f64 {
        assert!(self.is_factorised, "pivots come from a successful factorise");
        let n = self.factors.nrows();
        let pivot = |i: usize| {
            let root = self.factors[(i, i)];
            // Factors of small matrices keep the reciprocals.
            if n <= SMALL { (root * root).recip() } else { root * root }
        };
        (0..n).map(pivot).fold(f64::INFINITY, f64::min)
    }

    /// Solves `A x = b` in place.
    ///
    /// # Panics
    /// If the last factorisation failed, or there was none.
    pub fn solve(&self, b: &mut [f64]) {
        assert!(self.is_factorised, "solve comes after a successful factorise");
        let n = self.factors.nrows();
        if n <= SMALL {
            return small_cholesky::solve(self.factors.as_slice(), b);
        }
        let b = MatMut::from_column_major_slice_mut(b, n, 1);
        // faer solves this without memory of its own.
        solve::solve_in_place_with_conj(view(&self.factors), Conj::No, b, Par::Seq, MemStack::new(&mut []));
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

    /// Both ways of factorising, positive definite or not.
    #[test]
    fn all_sizes_solve_or_refuse() {
        for n in 0..3 * SMALL {
            let a = Matrix::from_fn(n, n, |i, j| {
                1.0 / (1.0 + i.abs_diff(j) as f64) + if i == j { i as f64 } else { 0.0 }
            });
            let x: Vec<f64> = (0..n).map(|i| 1.0 + i as f64).collect();
            let mut b: Vec<f64> = (0..n).map(|i| (0..n).map(|j| a[(i, j)] * x[j]).sum()).collect();
            let mut cholesky = Cholesky::new(n);
            cholesky.factorise(&a).unwrap();
            cholesky.solve(&mut b);
            for (found, wanted) in b.iter().zip(&x) {
                assert!((found - wanted).abs() < 1e-12 * n as f64, "n = {n}: {found} is not {wanted}");
            }
            if n > 0 {
                for entry in [-1.0, 0.0, f64::NAN, f64::INFINITY] {
                    let mut wrong = a.clone();
                    wrong[(n - 1, n - 1)] = entry;
                    assert_eq!(cholesky.factorise(&wrong), Err(NotPositiveDefinite), "n = {n}, {entry}");
                }
            }
        }
    }
}
