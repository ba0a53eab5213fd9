//! LU factorisation of small matrices, where the set-up of a blocked factorisation costs more than the work itself.
//!
//! The storage is that of LINPACK's `dgefa` (Dongarra et al. 1979): multipliers below the diagonal, in the row order of
//! their own elimination step, so that solving repeats the interchanges. The diagonal keeps the reciprocals of the
//! pivots, which makes solving free of divisions.

use super::failure::Singular;

/// Factorises the n x n matrix `a` (by columns) in place. Row k was exchanged with row `pivots[k]`.
pub fn factorise(a: &mut [f64], pivots: &mut [usize]) -> Result<(), Singular> {
    with_size!(factorise_sized(pivots.len(), a, pivots))
}

#[inline(always)]
fn factorise_sized(n: usize, a: &mut [f64], pivots: &mut [usize]) -> Result<(), Singular> {
    assert!(pivots.len() == n && a.len() == n * n, "sizes of a matrix");
    for k in 0..n {
        let (left, right) = a.split_at_mut((k + 1) * n);
        let column = &mut left[k * n..];
        let mut p = k;
        for i in k + 1..n {
            if column[i].abs() > column[p].abs() {
                p = i;
            }
        }
        pivots[k] = p;
        let reciprocal = 1.0 / column[p];
        if reciprocal == 0.0 || !reciprocal.is_finite() {
            return Err(Singular);
        }
        column[p] = column[k];
        column[k] = reciprocal;
        let multipliers = &mut column[k + 1..];
        for l in multipliers.iter_mut() {
            *l *= reciprocal;
        }
        for column in right.chunks_exact_mut(n) {
            column.swap(k, p);
            let u = column[k];
            for (x, l) in column[k + 1..].iter_mut().zip(&*multipliers) {
                *x -= u * l;
            }
        }
    }
    Ok(())
}

/// Solves `A x = b` in place.
pub fn solve(factors: &[f64], pivots: &[usize], b: &mut [f64]) {
    with_size!(solve_sized(pivots.len(), factors, pivots, b));
}

#[inline(always)]
fn solve_sized(n: usize, factors: &[f64], pivots: &[usize], b: &mut [f64]) {
    assert!(b.len() == n && pivots.len() == n && factors.len() == n * n, "sizes of a linear system");
    for k in 0..n {
        let l = &factors[k * n..(k + 1) * n];
        if pivots[k] != k {
            b.swap(k, pivots[k]);
        }
        let x = b[k];
        for i in k + 1..n {
            b[i] -= x * l[i];
        }
    }
    for k in (0..n).rev() {
        let u = &factors[k * n..(k + 1) * n];
        let x = b[k] * u[k];
        b[k] = x;
        for i in 0..k {
            b[i] -= x * u[i];
        }
    }
}

/// Solves `A X = B` in place, with `columns` right-hand sides that are stored by rows.
#[inline(always)]
pub(super) fn solve_rows(factors: &[f64], pivots: &[usize], columns: usize, b: &mut [f64]) {
    let n = pivots.len();
    assert!(b.len() == n * columns && factors.len() == n * n, "sizes of linear systems");
    let row = |k: usize| k * columns..(k + 1) * columns;
    for k in 0..n {
        for i in 0..columns {
            b.swap(k * columns + i, pivots[k] * columns + i);
        }
        let (above, below) = b.split_at_mut((k + 1) * columns);
        let x = &above[row(k)];
        for i in k + 1..n {
            subtract(&mut below[row(i - k - 1)], x, factors[k * n + i]);
        }
    }
    for k in (0..n).rev() {
        let (above, below) = b.split_at_mut(k * columns);
        let x = &mut below[..columns];
        for x in x.iter_mut() {
            *x *= factors[k * n + k];
        }
        for i in 0..k {
            subtract(&mut above[row(i)], x, factors[k * n + i]);
        }
    }
}

/// `y <- y - factor x`.
#[inline(always)]
fn subtract(y: &mut [f64], x: &[f64], factor: f64) {
    for (y, x) in y.iter_mut().zip(x) {
        *y -= factor * x;
    }
}

/// Solves `A^T x = b` in place.
pub fn solve_transposed(factors: &[f64], pivots: &[usize], b: &mut [f64]) {
    let n = pivots.len();
    for k in 0..n {
        let u = &factors[k * n..(k + 1) * n];
        let sum: f64 = (0..k).map(|i| u[i] * b[i]).sum();
        b[k] = (b[k] - sum) * u[k];
    }
    for k in (0..n).rev() {
        let l = &factors[k * n..(k + 1) * n];
        b[k] -= (k + 1..n).map(|i| l[i] * b[i]).sum::<f64>();
        b.swap(k, pivots[k]);
    }
}
