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

/// If every coordinate moves by its size and a gap changes by less than this part of its own size, that change is rounding.
const UNMOVED: f64 = 1e-12;

/// Sets rows of gaps to zero whose entries are rounding, such as rows out of the plane of an inclined planar mechanism. Normalised,
/// they would count as constraints.
pub fn forget_unmoved(rows: &mut Matrix, sizes: &[f64], gap_sizes: &[f64]) {
    for (mut row, gap_size) in rows.row_iter_mut().zip(gap_sizes) {
        let square: f64 = row.iter().zip(sizes).map(|(x, size)| (x * size).powi(2)).sum();
        if square.sqrt() <= UNMOVED * gap_size {
            row.fill(0.0);
        }
    }
}
