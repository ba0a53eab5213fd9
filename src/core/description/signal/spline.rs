//! Cubic splines through the values of tables.

use super::table::Table;
use super::times::covers;

/// A value with its first and second derivatives.
pub type Motion<const N: usize> = [[f64; N]; 3];

/// Cubic spline through the values of a table, twice continuously differentiable, with not-a-knot ends: the
/// first two pieces are one cubic, and so are the last two (de Boor 1978, chapter IV). NaN outside the table.
#[derive(Clone, Debug)]
pub(crate) struct Spline<const N: usize> {
    times: Vec<f64>,
    values: Vec<[f64; N]>,
    /// Second derivatives at the times.
    bends: Vec<[f64; N]>,
}

impl<const N: usize> Spline<N> {
    pub(crate) fn new(table: &Table<N>) -> Self {
        let (times, values) = (table.times.clone(), table.values.clone());
        let mut bends = vec![[0.0; N]; times.len()];
        for i in 0..N {
            let column: Vec<f64> = values.iter().map(|value| value[i]).collect();
            for (bend, x) in bends.iter_mut().zip(bends_of(&times, &column)) {
                bend[i] = x;
            }
        }
        Self { times, values, bends }
    }

    /// Value and first two derivatives.
    pub(crate) fn motion(&self, t: f64) -> Motion<N> {
        if !covers([self.times[0], self.times[self.times.len() - 1]], t) {
            return [[f64::NAN; N]; 3];
        }
        let i = self.times.partition_point(|&time| time <= t).clamp(1, self.times.len() - 1) - 1;
        let h = self.times[i + 1] - self.times[i];
        let (b, a) = ((t - self.times[i]) / h, (self.times[i + 1] - t) / h);
        let mut motion = [[0.0; N]; 3];
        for k in 0..N {
            let (start, end) = (self.values[i][k], self.values[i + 1][k]);
            let (from, to) = (self.bends[i][k], self.bends[i + 1][k]);
            motion[0][k] =
                a * start + b * end + h * h / 6.0 * ((a * a * a - a) * from + (b * b * b - b) * to);
            motion[1][k] =
                (end - start) / h + h / 6.0 * ((3.0 * b * b - 1.0) * to - (3.0 * a * a - 1.0) * from);
            motion[2][k] = a * from + b * to;
        }
        motion
    }
}

/// Second derivatives of the spline at the times.
fn bends_of(times: &[f64], values: &[f64]) -> Vec<f64> {
    let n = times.len();
    let h: Vec<f64> = times.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let slope: Vec<f64> = values.windows(2).zip(&h).map(|(pair, h)| (pair[1] - pair[0]) / h).collect();
    match n {
        0..=2 => return vec![0.0; n],
        // A single parabola.
        3 => return vec![2.0 * (slope[1] - slope[0]) / (h[0] + h[1]); 3],
        _ => {}
    }
    // h[i-1] m[i-1] + 2 (h[i-1] + h[i]) m[i] + h[i] m[i+1] = 6 (slope[i] - slope[i-1]) in the interior, with
    // both end values eliminated by the not-a-knot conditions: Gaussian elimination of a tridiagonal,
    // diagonally dominant matrix.
    let inside = n - 2;
    let mut diagonal: Vec<f64> = (0..inside).map(|i| 2.0 * (h[i] + h[i + 1])).collect();
    let mut above: Vec<f64> = (0..inside).map(|i| h[i + 1]).collect();
    let mut below: Vec<f64> = (0..inside).map(|i| h[i]).collect();
    let mut right: Vec<f64> = (0..inside).map(|i| 6.0 * (slope[i + 1] - slope[i])).collect();
    let (first, last) = (h[0] / h[1], h[n - 2] / h[n - 3]);
    diagonal[0] += h[0] * (1.0 + first);
    above[0] -= h[0] * first;
    diagonal[inside - 1] += h[n - 2] * (1.0 + last);
    below[inside - 1] -= h[n - 2] * last;
    for i in 1..inside {
        let factor = below[i] / diagonal[i - 1];
        diagonal[i] -= factor * above[i - 1];
        right[i] -= factor * right[i - 1];
    }
    let mut bends = vec![0.0; n];
    for i in (0..inside).rev() {
        let next = if i + 1 < inside { above[i] * bends[i + 2] } else { 0.0 };
        bends[i + 1] = (right[i] - next) / diagonal[i];
    }
    bends[0] = bends[1] + first * (bends[1] - bends[2]);
    bends[n - 1] = bends[n - 2] + last * (bends[n - 2] - bends[n - 3]);
    bends
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_spline_is_exact_for_cubics_and_knows_nothing_beyond_its_ends() {
        let cubic = |t: f64| [1.0 + t - 2.0 * t * t + 0.5 * t * t * t];
        for times in [vec![0.0, 0.3, 0.4, 1.0], vec![-1.0, 0.0, 0.5, 0.6, 2.0, 2.5]] {
            let table = Table::new(times.clone(), times.iter().map(|&t| cubic(t)).collect()).unwrap();
            let spline = Spline::new(&table);
            for t in [0.0, 0.1, 0.35, 0.9, 1.0] {
                let [[value], [rate], [bend]] = spline.motion(t);
                assert!((value - cubic(t)[0]).abs() < 1e-13, "{t}");
                assert!((rate - (1.0 - 4.0 * t + 1.5 * t * t)).abs() < 1e-12, "{t}");
                assert!((bend - (-4.0 + 3.0 * t)).abs() < 1e-11, "{t}");
            }
            assert!(spline.motion(9.0)[0][0].is_nan() && spline.motion(-9.0)[0][0].is_nan());
        }
        let parabola = Table::new(vec![0.0, 1.0, 3.0], vec![[0.0], [1.0], [9.0]]).unwrap();
        let [[value], [rate], [bend]] = Spline::new(&parabola).motion(2.0);
        assert!((value - 4.0).abs() < 1e-14 && (rate - 4.0).abs() < 1e-14 && (bend - 2.0).abs() < 1e-14);
        let line = Table::new(vec![0.0, 2.0], vec![[0.0], [1.0]]).unwrap();
        assert_eq!(Spline::new(&line).motion(1.0), [[0.5], [0.5], [0.0]]);
    }
}
