//! Cholesky factorisation of small matrices, where the set-up of a blocked factorisation costs more than the work itself.
//!
//! Right-looking, by columns (Golub and Van Loan 2013, algorithm 4.2.2 without blocks). The diagonal keeps the
//! reciprocals of the pivots, which makes solving free of divisions.

use super::failure::NotPositiveDefinite;

/// Factorises the n x n matrix `a` (by columns) in place: only its lower triangle is read and written.
pub fn factorise(a: &mut [f64], n: usize) -> Result<(), NotPositiveDefinite> {
    with_size!(factorise_sized(n, a))
}

#[inline(always)]
fn factorise_sized(n: usize, a: &mut [f64]) -> Result<(), NotPositiveDefinite> {
    assert!(a.len() == n * n, "sizes of a matrix");
    for k in 0..n {
        let (left, right) = a.split_at_mut((k + 1) * n);
        let column = &mut left[k * n + k..];
        let reciprocal = 1.0 / column[0].sqrt();
        // Negative and NaN have no root, zero and infinity no reciprocal.
        if reciprocal.is_nan() || reciprocal == 0.0 || reciprocal.is_infinite() {
            return Err(NotPositiveDefinite);
        }
        column[0] = reciprocal;
        for l in &mut column[1..] {
            *l *= reciprocal;
        }
        for (j, other) in right.chunks_exact_mut(n).enumerate() {
            let l = &column[j + 1..];
            let factor = l[0];
            for (x, l) in other[k + 1 + j..].iter_mut().zip(l) {
                *x -= factor * l;
            }
        }
    }
    Ok(())
}

/// Solves `A x = b` in place.
pub fn solve(factors: &[f64], b: &mut [f64]) {
    with_size!(solve_sized(b.len(), factors, b));
}

#[inline(always)]
fn solve_sized(n: usize, factors: &[f64], b: &mut [f64]) {
    assert!(b.len() == n && factors.len() == n * n, "sizes of a linear system");
    for k in 0..n {
        let l = &factors[k * n..(k + 1) * n];
        let x = b[k] * l[k];
        b[k] = x;
        for i in k + 1..n {
            b[i] -= x * l[i];
        }
    }
    for k in (0..n).rev() {
        let l = &factors[k * n..(k + 1) * n];
        let sum: f64 = (k + 1..n).map(|i| l[i] * b[i]).sum();
        b[k] = (b[k] - sum) * l[k];
    }
}
