//! LU factorisation with partial pivoting.

use dyn_stack::{MemBuffer, MemStack};
use faer::linalg::lu::partial_pivoting::{factor, solve};
use faer::linalg::temp_mat_scratch;
use faer::perm::PermRef;
use faer::{Conj, MatMut, Par};

use super::failure::Singular;
use super::{Matrix, small_lu, view, view_mut};

/// Up to this size [`small_lu`] is faster than faer, and always faster than nalgebra: factorising and solving takes
/// 0.35 of faer's time at n = 2, 0.7 at 12, 0.9 at 24, and more than that from 40 to 48 on (`benches/dense.rs`,
/// two-core x86-64, 2026).
const SMALL: usize = 24;

/// `P A = L U` of a square matrix, with memory for repeated use at a fixed size.
pub struct Lu {
    factors: Matrix,
    norm_1: f64,
    // Up to SMALL: the row exchanges one by one.
    row_permutation: Vec<usize>,
    row_permutation_inverse: Vec<usize>,
    memory: MemBuffer,
}

impl std::fmt::Debug for Lu {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Lu").field("factors", &self.factors).finish_non_exhaustive()
    }
}

impl Clone for Lu {
    fn clone(&self) -> Self {
        let n = self.factors.nrows();
        Self {
            factors: self.factors.clone(),
            norm_1: self.norm_1,
            row_permutation: self.row_permutation.clone(),
            row_permutation_inverse: self.row_permutation_inverse.clone(),
            memory: Self::memory(n),
        }
    }
}

impl Lu {
    /// Memory for matrices of size `n`.
    pub fn new(n: usize) -> Self {
        Self {
            factors: Matrix::zeros(n, n),
            norm_1: 0.0,
            row_permutation: (0..n).collect(),
            row_permutation_inverse: (0..n).collect(),
            memory: Self::memory(n),
        }
    }

    fn memory(n: usize) -> MemBuffer {
        if n <= SMALL {
            return MemBuffer::new(dyn_stack::StackReq::EMPTY);
        }
        MemBuffer::new(dyn_stack::StackReq::any_of(&[
            factor::lu_in_place_scratch::<usize, f64>(n, n, Par::Seq, Default::default()),
            solve::solve_in_place_scratch::<usize, f64>(n, 1, Par::Seq),
            solve::solve_transpose_in_place_scratch::<usize, f64>(n, 1, Par::Seq),
            temp_mat_scratch::<f64>(n, 1),
        ]))
    }

    /// Factorises `a` (n x n). Cost: 2/3 n^3 flops.
    pub fn factorise(&mut self, a: &Matrix) -> Result<(), Singular> {
        let n = self.factors.nrows();
        self.factors.as_mut_slice().copy_from_slice(a.as_slice());
        self.norm_1 = norm_1(a);
        if n <= SMALL {
            small_lu::factorise(self.factors.as_mut_slice(), &mut self.row_permutation)?;
            return if self.norm_1.is_finite() { Ok(()) } else { Err(Singular) };
        }
        factor::lu_in_place(
            view_mut(&mut self.factors),
            &mut self.row_permutation,
            &mut self.row_permutation_inverse,
            Par::Seq,
            MemStack::new(&mut self.memory),
            Default::default(),
        );
        let regular = (0..n).all(|i| self.factors[(i, i)] != 0.0 && self.factors[(i, i)].is_finite());
        if regular && self.norm_1.is_finite() { Ok(()) } else { Err(Singular) }
    }

    /// Solves `A x = b` in place.
    pub fn solve(&mut self, b: &mut [f64]) {
        let n = self.factors.nrows();
        if n <= SMALL {
            return small_lu::solve(self.factors.as_slice(), &self.row_permutation, b);
        }
        let factors = view(&self.factors);
        solve::solve_in_place_with_conj(
            factors,
            factors,
            PermRef::new_checked(&self.row_permutation, &self.row_permutation_inverse, n),
            Conj::No,
            MatMut::from_column_major_slice_mut(b, n, 1),
            Par::Seq,
            MemStack::new(&mut self.memory),
        );
    }

    /// `min |u_ii| / max |u_ii|` of the factorised matrix: a cheap indication that it may be close to
    /// singular; not a bound.
    pub fn pivot_ratio(&self) -> f64 {
        // The reciprocals that small matrices keep have the same ratio.
        let (mut smallest, mut largest) = (f64::INFINITY, 0.0_f64);
        for i in 0..self.factors.nrows() {
            let pivot = self.factors[(i, i)].abs();
            smallest = smallest.min(pivot);
            largest = largest.max(pivot);
        }
        if largest > 0.0 { smallest / largest } else { 1.0 }
    }

    fn solve_transposed(&mut self, b: &mut [f64]) {
        let n = self.factors.nrows();
        if n <= SMALL {
            return small_lu::solve_transposed(self.factors.as_slice(), &self.row_permutation, b);
        }
        let factors = view(&self.factors);
        solve::solve_transpose_in_place_with_conj(
            factors,
            factors,
            PermRef::new_checked(&self.row_permutation, &self.row_permutation_inverse, n),
            Conj::No,
            MatMut::from_column_major_slice_mut(b, n, 1),
            Par::Seq,
            MemStack::new(&mut self.memory),
        );
    }

    /// Estimate of `1 / (|A|_1 |A^-1|_1)` of the factorised matrix, by Hager's method (Hager 1984; Higham
    /// 1988, algorithm 2.4): O(n^2), usually exact, and never below the exact value by more than a few ulp.
    /// Allocates; not for step loops.
    pub fn reciprocal_condition(&mut self) -> f64 {
        /// Higham (1988): the estimate hardly improves after that many sweeps.
        const SWEEPS: usize = 5;
        let n = self.factors.nrows();
        if n == 0 {
            return 1.0;
        }
        let mut x = vec![1.0 / n as f64; n];
        let mut estimate = 0.0;
        let mut last_index = usize::MAX;
        for _ in 0..SWEEPS {
            self.solve(&mut x);
            let norm: f64 = x.iter().map(|v| v.abs()).sum();
            if !norm.is_finite() {
                return 0.0;
            }
            if norm <= estimate {
                break;
            }
            estimate = norm;
            for v in &mut x {
                *v = if *v >= 0.0 { 1.0 } else { -1.0 };
            }
            self.solve_transposed(&mut x);
            let index = (0..n).fold(0, |best, i| if x[i].abs() > x[best].abs() { i } else { best });
            if index == last_index {
                break;
            }
            last_index = index;
            x.fill(0.0);
            x[index] = 1.0;
        }
        let product = self.norm_1 * estimate;
        if product > 0.0 { 1.0 / product } else { 0.0 }
    }
}

/// Largest column sum; NaN when any entry is not finite.
fn norm_1(a: &Matrix) -> f64 {
    with_size!(norm_1_sized(a.nrows(), a.as_slice()))
}

#[inline(always)]
fn norm_1_sized(n: usize, a: &[f64]) -> f64 {
    let (mut largest, mut total) = (0.0_f64, 0.0);
    for k in 0..n {
        let sum: f64 = a[k * n..][..n].iter().map(|v| v.abs()).sum();
        largest = largest.max(sum);
        total += sum;
    }
    if total.is_finite() { largest } else { f64::NAN }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn solves_and_estimates_the_condition() {
        let a = Matrix::from_row_slice(3, 3, &[0.0, 2.0, 1.0, 4.0, -1.0, 0.5, 1.0, 1.0, 8.0]);
        let x = [1.0, -2.0, 3.0];
        let mut b: Vec<f64> = (0..3).map(|i| (0..3).map(|j| a[(i, j)] * x[j]).sum()).collect();
        let mut lu = Lu::new(3);
        lu.factorise(&a).unwrap();
        lu.solve(&mut b);
        for (found, wanted) in b.iter().zip(x) {
            assert!((found - wanted).abs() < 1e-14, "{found} is not {wanted}");
        }
        let inverse = a.clone().try_inverse().unwrap();
        let exact = 1.0 / (norm_1(&a) * norm_1(&inverse));
        assert!((lu.reciprocal_condition() / exact - 1.0).abs() < 1e-12);
    }

    /// Both ways of factorising, with many row exchanges, against each other's sizes.
    #[test]
    fn all_sizes_solve_both_systems() {
        for n in 0..2 * SMALL {
            let a = Matrix::from_fn(n, n, |i, j| {
                ((3 * i + 7 * j + i * j) as f64).sin() + ((i + 1) % n == j) as u8 as f64 * 9.0
            });
            let x: Vec<f64> = (0..n).map(|i| 1.0 + i as f64).collect();
            let mut lu = Lu::new(n);
            lu.factorise(&a).unwrap();
            let mut b: Vec<f64> = (0..n).map(|i| (0..n).map(|j| a[(i, j)] * x[j]).sum()).collect();
            lu.solve(&mut b);
            let mut c: Vec<f64> = (0..n).map(|i| (0..n).map(|j| a[(j, i)] * x[j]).sum()).collect();
            lu.solve_transposed(&mut c);
            for i in 0..n {
                assert!((b[i] - x[i]).abs() < 1e-11 && (c[i] - x[i]).abs() < 1e-11, "n = {n}, row {i}");
            }
            assert!(lu.pivot_ratio() > 0.0 && lu.pivot_ratio() <= 1.0);
        }
    }

    #[test]
    fn a_singular_or_non_finite_matrix_is_refused() {
        let mut lu = Lu::new(2);
        assert_eq!(lu.factorise(&Matrix::zeros(2, 2)), Err(Singular));
        assert_eq!(lu.factorise(&Matrix::from_element(2, 2, f64::NAN)), Err(Singular));
        assert_eq!(lu.factorise(&Matrix::identity(2, 2)), Ok(()));
    }
}
