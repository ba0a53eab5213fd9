//! Least squares with bounds: `min |A x - b|` with `lower <= x <= upper`.

use super::{Matrix, minimum_norm_solution, norm};

/// A gradient below this part of the product of the norms of its column and the right-hand side is rounding.
const ROUNDING: f64 = 1e-12;

/// State of a variable in the active-set method.
#[derive(Clone, Copy, PartialEq)]
enum Place {
    Free,
    Lower,
    Upper,
}

/// Solves by active sets (Lawson and Hanson 1974, chapter 23; Stark and Parker 1995, "Bounded-variable least squares"). Starts
/// from zero, or from the bound nearest to it; bounds may be infinite. With lower bounds of zero and no upper ones these are
/// nonnegative least squares. NaN in a matrix gives the start. Allocates.
pub fn bounded_least_squares(a: &Matrix, b: &[f64], lower: &[f64], upper: &[f64]) -> Vec<f64> {
    let (m, n) = a.shape();
    let mut x: Vec<f64> = lower.iter().zip(upper).map(|(&low, &high)| 0.0_f64.max(low).min(high)).collect();
    let mut places: Vec<Place> = (0..n)
        .map(|j| match x[j] {
            x if x <= lower[j] => Place::Lower,
            x if x >= upper[j] => Place::Upper,
            _ => Place::Free,
        })
        .collect();
    let remainder = |x: &[f64]| -> Vec<f64> {
        (0..m).map(|i| b[i] - (0..n).map(|j| a[(i, j)] * x[j]).sum::<f64>()).collect()
    };
    let lengths: Vec<f64> = a.column_iter().map(|column| column.norm()).collect();
    // A variable that leaves its bound and returns at once does so because of rounding.
    let mut returned = vec![false; n];
    for _ in 0..4 * n + 4 {
        // To the best point of the free variables, or to the first bound on the way.
        loop {
            let free: Vec<usize> = (0..n).filter(|&j| places[j] == Place::Free).collect();
            let mut fixed = x.clone();
            free.iter().for_each(|&j| fixed[j] = 0.0);
            let Some(best) = minimum_norm_solution(&a.select_columns(&free), &remainder(&fixed)) else {
                return x;
            };
            let (mut part, mut first) = (1.0, None);
            for (&j, &wanted) in free.iter().zip(&best.x) {
                let bound = if wanted < x[j] { lower[j] } else { upper[j] };
                let reached = (bound - x[j]) / (wanted - x[j]);
                if (wanted < lower[j] || wanted > upper[j]) && reached < part {
                    (part, first) = (reached, Some((j, wanted < x[j])));
                }
            }
            for (&j, &wanted) in free.iter().zip(&best.x) {
                x[j] += part * (wanted - x[j]);
            }
            let Some((j, is_lower)) = first else { break };
            (x[j], places[j]) = if is_lower { (lower[j], Place::Lower) } else { (upper[j], Place::Upper) };
            returned[j] |= part <= 0.0;
        }
        let left = remainder(&x);
        let size = norm(&left);
        let inwards = |j: usize| {
            let slope: f64 = (0..m).map(|i| a[(i, j)] * left[i]).sum();
            let pull = match places[j] {
                Place::Free => 0.0,
                Place::Lower => slope,
                Place::Upper => -slope,
            };
            if returned[j] || pull <= ROUNDING * lengths[j] * size { 0.0 } else { pull / lengths[j] }
        };
        let strongest = (0..n).map(|j| (inwards(j), j)).max_by(|a, b| a.0.total_cmp(&b.0));
        match strongest {
            Some((pull, j)) if pull > 0.0 => places[j] = Place::Free,
            _ => break,
        }
    }
    x
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bounds_hold_and_gradients_point_outwards() {
        let a = Matrix::from_fn(5, 4, |i, j| ((3 * i + 5 * j) as f64).sin());
        for (low, high) in [(0.0, f64::INFINITY), (-0.1, 0.2), (-1e3, 1e3)] {
            let b: Vec<f64> = (0..5).map(|i| (2.0 * i as f64).cos()).collect();
            let x = bounded_least_squares(&a, &b, &[low; 4], &[high; 4]);
            let left: Vec<f64> =
                (0..5).map(|i| b[i] - (0..4).map(|j| a[(i, j)] * x[j]).sum::<f64>()).collect();
            for j in 0..4 {
                let slope: f64 = (0..5).map(|i| a[(i, j)] * left[i]).sum();
                assert!((low..=high).contains(&x[j]));
                assert!(x[j] < high || slope > -1e-12);
                assert!(x[j] > low || slope < 1e-12);
                assert!(x[j] == low || x[j] == high || slope.abs() < 1e-12);
            }
        }
    }

    #[test]
    fn redundant_columns_share_what_is_needed() {
        let a = Matrix::from_row_slice(1, 2, &[1.0, 1.0]);
        let x = bounded_least_squares(&a, &[2.0], &[0.0; 2], &[f64::INFINITY; 2]);
        assert!((x[0] + x[1] - 2.0).abs() < 1e-14 && x.iter().all(|x| *x >= 0.0));
        assert_eq!(bounded_least_squares(&a, &[-2.0], &[0.0; 2], &[f64::INFINITY; 2]), [0.0; 2]);
    }
}
