//! Linear algebra for dense matrices and for those of trees. Solvers of nalgebra and faer are used only here.
//!
//! Factorisations own their memory, sized once; factorising and solving do not allocate.
//!
//! ```
//! use lissom::linalg::{Lu, Matrix};
//!
//! let mut lu = Lu::new(2);
//! lu.factorise(&Matrix::from_row_slice(2, 2, &[2.0, 1.0, 1.0, 3.0]))?;
//! let mut x = [3.0, 4.0];
//! lu.solve(&mut x);
//! assert!((x[0] - 1.0).abs() < 1e-15 && (x[1] - 1.0).abs() < 1e-15);
//! # Ok::<(), lissom::linalg::Singular>(())
//! ```

use std::borrow::Cow;
use std::ops::Range;

/// Calls a function whose first argument is a size, with the smallest sizes as constants so that its loops are unrolled.
#[doc(hidden)]
#[macro_export]
macro_rules! with_size {
    ($function:ident($n:expr $(, $argument:expr)*)) => {
        match $n {
            1 => $function(1 $(, $argument)*),
            2 => $function(2 $(, $argument)*),
            3 => $function(3 $(, $argument)*),
            4 => $function(4 $(, $argument)*),
            n => $function(n $(, $argument)*),
        }
    };
}
#[doc(hidden)]
pub use with_size;

mod block_lu;
mod bounded_least_squares;
mod cholesky;
mod complex_lu;
mod eigen;
mod elimination;
mod failure;
mod lu;
pub mod small_cholesky;
pub mod small_lu;
mod svd;
mod tree;

pub use block_lu::BlockLu;
#[doc(hidden)]
pub use bounded_least_squares::bounded_least_squares;
pub use cholesky::Cholesky;
pub use complex_lu::ComplexLu;
pub use eigen::{Complex, eigen, eigenvalues, symmetric_eigen, symmetric_eigenvalues};
#[doc(hidden)]
pub use eigen::{eigen_both, symmetric_part};
pub use failure::{NotPositiveDefinite, Singular};
pub use lu::Lu;
pub use svd::{MinimumNorm, condition_number, full_svd, minimum_norm_solution, singular_values, thin_svd};
pub use tree::{Generators, TreeLu, TreeMatrix, TreePlace};

/// A dense matrix of doubles, stored by columns.
pub type Matrix = nalgebra::DMatrix<f64>;

/// Largest entries of vectors whose squares neither overflow nor underflow, with a margin for sums of many.
const UNSCALED: Range<f64> = 1e-140..1e140;

/// Euclidean norm, without overflow or underflow of squares for finite entries.
pub fn norm(v: &[f64]) -> f64 {
    let largest = norm_inf(v);
    // The plain sum of squares is exact to rounding in this range; scaling costs a division per entry.
    if UNSCALED.contains(&largest) {
        v.iter().map(|x| x * x).sum::<f64>().sqrt()
    } else if largest == 0.0 || !largest.is_finite() {
        largest
    } else {
        largest * v.iter().map(|x| (x / largest) * (x / largest)).sum::<f64>().sqrt()
    }
}

/// Largest absolute entry; NaN if an entry is NaN.
pub fn norm_inf(v: &[f64]) -> f64 {
    v.iter().fold(0.0, |m: f64, x| if x.is_nan() || m.is_nan() { f64::NAN } else { m.max(x.abs()) })
}

/// Scalar product.
pub fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(x, y)| x * y).sum()
}

/// A finite matrix whose squares neither overflow nor vanish as a whole, and the power of two that it has been
/// divided by: mostly it is `a` itself. `None` where `a` is not finite.
fn moderate(a: &Matrix) -> Option<(Cow<'_, Matrix>, f64)> {
    /// Products of four entries in this range, summed, stay doubles.
    const RANGE: Range<f64> = 1e-70..1e70;
    let largest = norm_inf(a.as_slice());
    if !largest.is_finite() {
        return None;
    }
    if largest == 0.0 || RANGE.contains(&largest) {
        return Some((Cow::Borrowed(a), 1.0));
    }
    // Below the largest powers of two, so that the reciprocal is no subnormal number.
    let scale = largest.log2().floor().clamp(-1000.0, 1000.0).exp2();
    Some((Cow::Owned(a / scale), scale))
}

/// Adds `A B^T` to the block of a matrix with these rows and columns. A and B are these rows of matrices that are stored by columns of
/// the given length; they have the same number of columns.
#[doc(hidden)]
pub fn add_product(
    matrix: &mut Matrix,
    [rows, columns]: [Range<usize>; 2],
    length: usize,
    factors: [(&[f64], Range<usize>); 2],
) {
    let [left, right] = factors.map(|(factor, own)| {
        let all = faer::MatRef::from_column_major_slice(factor, length, factor.len() / length.max(1));
        all.subrows(own.start, own.len())
    });
    let block = view_mut(matrix).submatrix_mut(rows.start, columns.start, rows.len(), columns.len());
    faer::linalg::matmul::matmul(block, faer::Accum::Add, left, right.transpose(), 1.0, faer::Par::Seq);
}

fn view(a: &Matrix) -> faer::MatRef<'_, f64> {
    faer::MatRef::from_column_major_slice(a.as_slice(), a.nrows(), a.ncols())
}

fn view_mut(a: &mut Matrix) -> faer::MatMut<'_, f64> {
    let (rows, columns) = a.shape();
    faer::MatMut::from_column_major_slice_mut(a.as_mut_slice(), rows, columns)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Decompositions of matrices at the edges of doubles end, with the results of moderate ones.
    #[test]
    fn decompositions_at_the_edges_of_doubles() {
        let a = Matrix::from_row_slice(3, 3, &[2.0, -1.0, 0.5, -1.0, 3.0, 0.25, 0.5, 0.25, 1.0]);
        let wanted = [symmetric_eigenvalues(&a).unwrap(), singular_values(&a).unwrap()];
        for exponent in [-1000, -500, 500, 1020] {
            let scale = f64::from(exponent).exp2();
            let scaled = &a * scale;
            let found = [symmetric_eigenvalues(&scaled).unwrap(), singular_values(&scaled).unwrap()];
            for (found, wanted) in found.iter().flatten().zip(wanted.iter().flatten()) {
                assert!((found / scale - wanted).abs() < 1e-13, "{exponent}: {found} {wanted}");
            }
            assert!((condition_number(&scaled) / condition_number(&a) - 1.0).abs() < 1e-12);
            let complex = eigen(&scaled).unwrap();
            assert!(complex.iter().all(|(value, _)| (value.re / scale).is_finite() && value.im == 0.0));
            assert_eq!(eigenvalues(&scaled).unwrap().len(), 3);
            assert_eq!(symmetric_eigen(&scaled).unwrap().0.len(), 3);
            let b = [scale, 0.0, 0.0];
            let x = minimum_norm_solution(&scaled, &b).unwrap();
            assert_eq!(x.rank, 3);
            let plain = minimum_norm_solution(&a, &[1.0, 0.0, 0.0]).unwrap();
            assert!(x.x.iter().zip(&plain.x).all(|(x, plain)| (x - plain).abs() < 1e-13));
        }
        for value in [f64::MAX, f64::MIN_POSITIVE, 5e-324] {
            let extreme = Matrix::from_element(3, 3, value);
            assert!(singular_values(&extreme).is_some_and(|s| s.len() == 3));
            assert!(condition_number(&extreme) > 1e10);
            assert!(eigen(&extreme).is_some() && symmetric_eigen(&extreme).is_some());
        }
    }
}
