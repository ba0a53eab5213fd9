//! LU factorisation of complex matrices composed of real ones.

use dyn_stack::{MemBuffer, MemStack, StackReq};
use faer::linalg::lu::partial_pivoting::{factor, solve};
use faer::perm::PermRef;
use faer::{Conj, MatMut, MatRef, Par, c64};

use super::{Matrix, Singular};

/// `P (s I - A) = L U` for a complex number s and a real matrix A, or `P (A + i B) = L U`, with memory for
/// repeated use at a fixed size: the systems of an implicit Runge-Kutta method for a conjugate pair of
/// eigenvalues of its coefficient matrix.
pub struct ComplexLu {
    n: usize,
    factors: Vec<c64>,
    right_side: Vec<c64>,
    row_permutation: Vec<usize>,
    row_permutation_inverse: Vec<usize>,
    memory: MemBuffer,
}

impl std::fmt::Debug for ComplexLu {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("ComplexLu").field("n", &self.n).finish_non_exhaustive()
    }
}

impl Clone for ComplexLu {
    fn clone(&self) -> Self {
        Self {
            n: self.n,
            factors: self.factors.clone(),
            right_side: self.right_side.clone(),
            row_permutation: self.row_permutation.clone(),
            row_permutation_inverse: self.row_permutation_inverse.clone(),
            memory: Self::memory(self.n),
        }
    }
}

impl ComplexLu {
    /// Memory for matrices of size `n`.
    pub fn new(n: usize) -> Self {
        Self {
            n,
            factors: vec![c64::default(); n * n],
            right_side: vec![c64::default(); n],
            row_permutation: (0..n).collect(),
            row_permutation_inverse: (0..n).collect(),
            memory: Self::memory(n),
        }
    }

    fn memory(n: usize) -> MemBuffer {
        MemBuffer::new(StackReq::any_of(&[
            factor::lu_in_place_scratch::<usize, c64>(n, n, Par::Seq, Default::default()),
            solve::solve_in_place_scratch::<usize, c64>(n, 1, Par::Seq),
        ]))
    }

    /// Factorises `s I - a` with `s = shift.0 + i shift.1`. Cost: 8/3 n^3 real flops.
    pub fn factorise(&mut self, shift: (f64, f64), a: &Matrix) -> Result<(), Singular> {
        let n = self.n;
        for (factor, &entry) in self.factors.iter_mut().zip(a.as_slice()) {
            *factor = c64::new(-entry, 0.0);
        }
        for i in 0..n {
            self.factors[i * n + i] += c64::new(shift.0, shift.1);
        }
        self.factorise_in_place()
    }

    /// Factorises `real + i imaginary`, at the same cost.
    pub fn factorise_sum(&mut self, real: &Matrix, imaginary: &Matrix) -> Result<(), Singular> {
        for ((factor, &re), &im) in self.factors.iter_mut().zip(real.as_slice()).zip(imaginary.as_slice()) {
            *factor = c64::new(re, im);
        }
        self.factorise_in_place()
    }

    fn factorise_in_place(&mut self) -> Result<(), Singular> {
        let n = self.n;
        factor::lu_in_place(
            MatMut::from_column_major_slice_mut(&mut self.factors, n, n),
            &mut self.row_permutation,
            &mut self.row_permutation_inverse,
            Par::Seq,
            MemStack::new(&mut self.memory),
            Default::default(),
        );
        let regular = (0..n).all(|i| {
            let pivot = self.factors[i * n + i];
            pivot != c64::default() && pivot.re.is_finite() && pivot.im.is_finite()
        });
        if regular { Ok(()) } else { Err(Singular) }
    }

    /// Solves for the right-hand side `real + i imaginary`, in place.
    pub fn solve(&mut self, real: &mut [f64], imaginary: &mut [f64]) {
        let n = self.n;
        for ((value, &re), &im) in self.right_side.iter_mut().zip(&*real).zip(&*imaginary) {
            *value = c64::new(re, im);
        }
        let factors = MatRef::from_column_major_slice(&self.factors, n, n);
        solve::solve_in_place_with_conj(
            factors,
            factors,
            PermRef::new_checked(&self.row_permutation, &self.row_permutation_inverse, n),
            Conj::No,
            MatMut::from_column_major_slice_mut(&mut self.right_side, n, 1),
            Par::Seq,
            MemStack::new(&mut self.memory),
        );
        for ((value, re), im) in self.right_side.iter().zip(real).zip(imaginary) {
            *re = value.re;
            *im = value.im;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn solves_shifted_systems() {
        let a = Matrix::from_row_slice(3, 3, &[0.0, 2.0, 1.0, 4.0, -1.0, 0.5, 1.0, 1.0, 8.0]);
        let (shift, x) = ((0.3, -2.0), [c64::new(1.0, -2.0), c64::new(3.0, 0.5), c64::new(-1.0, 1.0)]);
        let b: Vec<c64> = (0..3)
            .map(|i| c64::new(shift.0, shift.1) * x[i] - (0..3).map(|j| x[j] * a[(i, j)]).sum::<c64>())
            .collect();
        let (mut re, mut im): (Vec<f64>, Vec<f64>) = b.iter().map(|b| (b.re, b.im)).unzip();
        let mut lu = ComplexLu::new(3);
        lu.factorise(shift, &a).unwrap();
        lu.clone().solve(&mut re, &mut im);
        for i in 0..3 {
            assert!((re[i] - x[i].re).abs() < 1e-14 && (im[i] - x[i].im).abs() < 1e-14);
        }
    }

    #[test]
    fn solves_sums() {
        let re = Matrix::from_row_slice(2, 2, &[1.0, 2.0, -1.0, 0.5]);
        let im = Matrix::from_row_slice(2, 2, &[0.0, -3.0, 1.0, 1.0]);
        // (re + i im) (1 + i, 2)
        let (mut real, mut imaginary) = ([5.0, -1.0], [-5.0, 2.0]);
        let mut lu = ComplexLu::new(2);
        lu.factorise_sum(&re, &im).unwrap();
        lu.solve(&mut real, &mut imaginary);
        for (found, expected) in real.iter().chain(&imaginary).zip([1.0, 2.0, 1.0, 0.0]) {
            assert!((found - expected).abs() < 1e-14, "{real:?} {imaginary:?}");
        }
    }

    #[test]
    fn a_singular_or_non_finite_matrix_is_refused() {
        let mut lu = ComplexLu::new(2);
        assert_eq!(lu.factorise((0.0, 0.0), &Matrix::zeros(2, 2)), Err(Singular));
        assert_eq!(lu.factorise((1.0, 1.0), &Matrix::from_element(2, 2, f64::NAN)), Err(Singular));
        assert_eq!(lu.factorise((1.0, 1.0), &Matrix::zeros(2, 2)), Ok(()));
        ComplexLu::new(0).factorise((1.0, 1.0), &Matrix::zeros(0, 0)).unwrap();
    }
}
