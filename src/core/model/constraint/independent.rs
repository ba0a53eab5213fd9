//! Selection of linearly independent rows of a matrix.

use crate::numerics::linalg::{Matrix, dot};

/// A row depends on others if orthogonalisation leaves less than this part of it: near a singular position rows are kept until their
/// multipliers lose half of all digits.
const DEPENDENT: f64 = 1e-8;

/// One over the length of a row, zero where the length is rounding of the largest one: nothing moves such a constraint, for example
/// out of the plane of a planar mechanism.
pub fn inverse_length(length: f64, largest: f64) -> f64 {
    if length > DEPENDENT * largest && length.is_finite() { length.recip() } else { 0.0 }
}

/// A maximal set of independent rows of a matrix, with memory for repeated use: Gram and Schmidt's orthogonalisation with pivoting
/// by the longest remaining row (Golub and Van Loan 2013, section 5.4.2, on columns).
#[derive(Clone, Debug)]
pub struct Independent {
    rows: usize,
    columns: usize,
    /// The remaining part of each row, of length one at first.
    left: Vec<f64>,
    is_independent: Vec<bool>,
    squares: Vec<f64>,
}

impl Independent {
    pub(crate) fn new(rows: usize, columns: usize) -> Self {
        Self {
            rows,
            columns,
            left: vec![0.0; rows * columns],
            is_independent: vec![false; rows],
            squares: vec![0.0; rows],
        }
    }

    /// Finds them, of rows whose entries are multiplied by `scale` of their column: the same units in all of them. Rows of different
    /// `parts` have no columns in common. Cost: rows^2 columns for each part.
    pub(crate) fn find(&mut self, matrix: &Matrix, scale: impl Fn(usize) -> f64, parts: &[usize]) {
        let Self { rows, columns, left, is_independent, squares } = self;
        let columns = *columns;
        is_independent.fill(false);
        let mut largest = 0.0_f64;
        for (i, row) in left.chunks_exact_mut(columns.max(1)).enumerate() {
            for (k, entry) in row.iter_mut().enumerate() {
                *entry = matrix[(i, k)] * scale(k);
            }
            largest = largest.max(dot(row, row).sqrt());
        }
        for row in left.chunks_exact_mut(columns.max(1)) {
            let factor = inverse_length(dot(row, row).sqrt(), largest);
            row.iter_mut().for_each(|entry| *entry *= factor);
        }
        for (square, row) in squares.iter_mut().zip(left.chunks_exact(columns.max(1))) {
            *square = dot(row, row);
        }
        for _ in 0..(*rows).min(columns) {
            // The first of equal ones.
            let mut most = 0;
            for i in 1..*rows {
                if squares[i] > squares[most] {
                    most = i;
                }
            }
            if squares[most] <= DEPENDENT * DEPENDENT {
                break;
            }
            is_independent[most] = true;
            let factor = squares[most].sqrt().recip();
            left[most * columns..][..columns].iter_mut().for_each(|entry| *entry *= factor);
            for i in (0..*rows).filter(|&i| i != most && parts[i] == parts[most]) {
                let (first, second) = left.split_at_mut(i.max(most) * columns);
                let (row, unit) = if i < most {
                    (&mut first[i * columns..][..columns], &second[..columns])
                } else {
                    (&mut second[..columns], &first[most * columns..][..columns])
                };
                let part = dot(row, unit);
                for (entry, unit) in row.iter_mut().zip(unit) {
                    *entry -= part * unit;
                }
                squares[i] = dot(row, row);
            }
            left[most * columns..][..columns].fill(0.0);
            squares[most] = 0.0;
        }
    }

    pub(crate) fn is_independent(&self, row: usize) -> bool {
        self.is_independent[row]
    }

    /// Number of independent rows.
    pub(crate) fn rank(&self) -> usize {
        self.is_independent.iter().filter(|&&is_independent| is_independent).count()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_that_others_determine_are_found_whatever_their_units() {
        let rows = [[1.0, 0.0, 0.0], [1e3, 1e3, 0.0], [0.0, 3.0, 0.0], [0.0, 1e-14, 0.0], [0.0, 1e-3, 1e-3]];
        let matrix = Matrix::from_fn(5, 3, |i, j| rows[i][j]);
        let mut found = Independent::new(5, 3);
        found.find(&matrix, |_| 1.0, &[0; 5]);
        assert_eq!(found.rank(), 3);
        assert!(!found.is_independent(3) && found.is_independent(4));
        let mut none = Independent::new(2, 0);
        none.find(&Matrix::zeros(2, 0), |_| 1.0, &[0; 2]);
        assert!(!none.is_independent(0) && !none.is_independent(1));
    }
}
