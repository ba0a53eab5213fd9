//! Equations of motion with constraints `g(q, t) = 0`, held by multipliers: `tau + G^T lambda = 0`, `G = dg/dq`.
//!
//! Constraints may be redundant, as those of a planar mechanism whose loops are closed by hinges with six
//! rows, or of a mechanism at a singular position. [`Independent`] selects independent rows; the other rows
//! get no multipliers, and are satisfied automatically unless they conflict.

pub mod closing;
mod independent;
pub mod one_sided;
mod parts;
pub mod projection;
pub mod saddle;

use crate::numerics::linalg::Matrix;

pub use independent::{Independent, inverse_length};
pub use saddle::Saddle;

/// A gap that changes by less than this part of its size, where every coordinate moves by its size, does so by rounding.
const UNMOVED: f64 = 1e-12;

/// Sets rows of gaps to zero that coordinates move by rounding alone, such as those out of the plane of a mechanism that is turned.
/// Divided by their lengths they would count as constraints.
pub fn forget_unmoved(rows: &mut Matrix, sizes: &[f64], gap_sizes: &[f64]) {
    for (mut row, gap_size) in rows.row_iter_mut().zip(gap_sizes) {
        let square: f64 = row.iter().zip(sizes).map(|(x, size)| (x * size).powi(2)).sum();
        if square.sqrt() <= UNMOVED * gap_size {
            row.fill(0.0);
        }
    }
}
