//! Linear algebra, dense and of chains: the only place that names the solvers of nalgebra and faer.
//!
//! Factorisations own their memory, sized once, so that factorising and solving allocate nothing.

mod chain;
mod cholesky;
mod complex_lu;
mod eigen;
mod lu;
pub mod small_cholesky;
pub mod small_lu;
mod svd;

pub use chain::{ChainLu, ChainMatrix, Generators};
pub use cholesky::{Cholesky, NotPositiveDefinite};
pub use complex_lu::ComplexLu;
pub use eigen::{Complex, eigen, eigenvalues, symmetric_eigen, symmetric_eigenvalues};
pub use lu::{Lu, Singular};
pub use svd::{MinimumNorm, condition_number, full_svd, minimum_norm_solution, singular_values};

/// A dense matrix of doubles, stored by columns.
pub type Matrix = nalgebra::DMatrix<f64>;

/// Euclidean norm, without overflow or underflow of the squares for finite entries.
pub fn norm(v: &[f64]) -> f64 {
    let largest = norm_inf(v);
    // The plain sum of squares is exact to rounding in this range; scaling costs a division an entry.
    if (1e-140..1e140).contains(&largest) {
        v.iter().map(|x| x * x).sum::<f64>().sqrt()
    } else if largest == 0.0 || !largest.is_finite() {
        largest
    } else {
        largest * v.iter().map(|x| (x / largest) * (x / largest)).sum::<f64>().sqrt()
    }
}

/// Largest absolute entry; NaN when any entry is NaN.
pub fn norm_inf(v: &[f64]) -> f64 {
    v.iter().fold(0.0, |m: f64, x| if x.is_nan() || m.is_nan() { f64::NAN } else { m.max(x.abs()) })
}

/// Scalar product.
pub fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(x, y)| x * y).sum()
}

fn view(a: &Matrix) -> faer::MatRef<'_, f64> {
    faer::MatRef::from_column_major_slice(a.as_slice(), a.nrows(), a.ncols())
}

fn view_mut(a: &mut Matrix) -> faer::MatMut<'_, f64> {
    let (rows, columns) = a.shape();
    faer::MatMut::from_column_major_slice_mut(a.as_mut_slice(), rows, columns)
}
