//! Tables of prescribed motions with corners: straight lines, whose velocity jumps, and cubic pieces that keep the shape of the
//! values, whose acceleration does.

use super::spline::Motion;
use super::table::Table;
use super::times::{covers, rounding_of_times};
use crate::numerics::hermite::cubic_motion;

/// A table as straight lines, or as monotone cubic pieces.
#[derive(Clone, Debug)]
pub(crate) enum Pieces<const N: usize> {
    /// Straight lines, constant before the first and after the last time.
    Linear(Table<N>),
    /// Cubic pieces with these slopes at the times. NaN outside the table.
    Monotone(Table<N>, Vec<[f64; N]>),
}

impl<const N: usize> Pieces<N> {
    /// Cubic pieces with the slopes of Fritsch and Butland (1984), which are monotone wherever the values are.
    pub(crate) fn monotone(table: Table<N>) -> Self {
        let mut slopes = vec![[0.0; N]; table.times.len()];
        for k in 0..N {
            let column: Vec<f64> = table.values.iter().map(|value| value[k]).collect();
            for (slope, x) in slopes.iter_mut().zip(monotone_slopes(&table.times, &column)) {
                slope[k] = x;
            }
        }
        Self::Monotone(table, slopes)
    }

    /// Value and first two derivatives. At a jump those before it, unless that corner was `passed`.
    pub(crate) fn motion(&self, t: f64, passed: f64) -> Motion<N> {
        match self {
            Self::Linear(table) => {
                let slope = match table.near(t) {
                    Some(i) if table.near(passed) == Some(i) => table.slope_after(Some(i)),
                    _ => table.slope_before(t),
                };
                [table.at(t), slope, [0.0; N]]
            }
            Self::Monotone(table, slopes) => {
                let Table { times, values, .. } = table;
                if !covers([times[0], times[times.len() - 1]], t) {
                    return [[f64::NAN; N]; 3];
                }
                let i = match table.near(t) {
                    Some(i) if table.near(passed) == Some(i) => i,
                    Some(i) => i.saturating_sub(1),
                    None => times.partition_point(|&time| time <= t).saturating_sub(1),
                };
                let i = i.min(times.len() - 2);
                let h = times[i + 1] - times[i];
                let mut motion = [[0.0; N]; 3];
                for k in 0..N {
                    let [value, slope] = [[values[i][k], values[i + 1][k]], [slopes[i][k], slopes[i + 1][k]]];
                    for (part, x) in motion.iter_mut().zip(cubic_motion((t - times[i]) / h, h, value, slope))
                    {
                        part[k] = x;
                    }
                }
                motion
            }
        }
    }
}

/// The quantities that jump at some times in a prescribed motion.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Jumps {
    /// Nothing.
    Nothing,
    /// Accelerations.
    Accelerations,
    /// Velocities.
    Velocities,
}

impl<const N: usize> Table<N> {
    /// A time within the table, at which the acceleration of cubic pieces jumps, if that is `t`, but for rounding.
    pub(crate) fn time_near(&self, t: f64) -> Option<f64> {
        self.near(t).filter(|&i| i > 0 && i + 1 < self.times.len()).map(|i| self.times[i])
    }

    /// The time at which straight lines change their velocity, if that is `t`, but for rounding.
    pub(crate) fn jump_near(&self, t: f64) -> Option<f64> {
        self.near(t).filter(|&i| self.bends_at(i)).map(|i| self.times[i])
    }

    /// The next time after `t`, but for rounding, at which straight lines change their velocity.
    pub(crate) fn next_corner(&self, t: f64) -> Option<f64> {
        let from = self.near(t).map_or_else(|| self.times.partition_point(|&time| time <= t), |i| i + 1);
        (from..self.times.len()).find(|&i| self.bends_at(i)).map(|i| self.times[i])
    }

    /// Slope to the left of a time.
    fn slope_before(&self, t: f64) -> [f64; N] {
        self.slope_after(self.times.partition_point(|&time| time < t).checked_sub(1))
    }

    /// Index of the time that is `t`, but for rounding.
    fn near(&self, t: f64) -> Option<usize> {
        let after = self.times.partition_point(|&time| time < t);
        [after.checked_sub(1), Some(after)].into_iter().flatten().find(|&i| {
            let Some(&time) = self.times.get(i) else { return false };
            let before = i.checked_sub(1).map_or(f64::INFINITY, |i| time - self.times[i]);
            let apart = self.times.get(i + 1).map_or(f64::INFINITY, |next| next - time).min(before);
            (time - t).abs() <= rounding_of_times(apart, t)
        })
    }
}

/// Slopes at the times: weighted harmonic means of the slopes on both sides, zero where these have different
/// signs (Fritsch and Butland 1984, as in PCHIP); at the ends those of a parabola, limited to keep the shape.
fn monotone_slopes(times: &[f64], values: &[f64]) -> Vec<f64> {
    let n = times.len();
    let h: Vec<f64> = times.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let secant: Vec<f64> = values.windows(2).zip(&h).map(|(pair, h)| (pair[1] - pair[0]) / h).collect();
    if n == 2 {
        return vec![secant[0]; 2];
    }
    let inside = |i: usize| {
        let (before, after) = (secant[i - 1], secant[i]);
        if before * after <= 0.0 {
            return 0.0;
        }
        let (a, b) = (2.0 * h[i] + h[i - 1], h[i] + 2.0 * h[i - 1]);
        (a + b) / (a / before + b / after)
    };
    let mut slopes = vec![end_slope([h[0], h[1]], [secant[0], secant[1]])];
    slopes.extend((1..n - 1).map(inside));
    slopes.push(end_slope([h[n - 2], h[n - 3]], [secant[n - 2], secant[n - 3]]));
    slopes
}

/// Slope at an end from the two pieces next to it, the nearer one first.
fn end_slope(h: [f64; 2], secant: [f64; 2]) -> f64 {
    let slope = ((2.0 * h[0] + h[1]) * secant[0] - h[0] * secant[1]) / (h[0] + h[1]);
    if slope * secant[0] <= 0.0 {
        0.0
    } else if secant[0] * secant[1] <= 0.0 && slope.abs() > 3.0 * secant[0].abs() {
        3.0 * secant[0]
    } else {
        slope
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_have_the_velocity_before_a_corner_until_it_is_passed() {
        let table = Table::new(vec![0.0, 0.3, 1.0], vec![[0.0], [0.6], [0.6]]).unwrap();
        assert_eq!(
            [0.0, 0.1 + 0.2, 0.5, 1.0].map(|t| table.jump_near(t)),
            [Some(0.0), Some(0.3), None, None]
        );
        let lines = Pieces::Linear(table);
        let rate = |t: f64, passed: f64| lines.motion(t, passed)[1][0];
        assert_eq!([rate(0.0, f64::NAN), rate(0.0, 0.0), rate(0.1, 0.0)], [0.0, 2.0, 2.0]);
        assert_eq!([rate(0.3, 0.0), rate(0.3, 0.3), rate(2.0, 0.3)], [2.0, 0.0, 0.0]);
        // A time just before the corner by rounding, once that is passed.
        let just_before = 0.3_f64.next_down();
        assert_eq!([rate(just_before, 0.0), rate(just_before, 0.3)], [2.0, 0.0]);
    }

    #[test]
    fn monotone_pieces_have_the_acceleration_before_a_time_until_it_is_passed() {
        let table = Table::new(vec![0.0, 0.3, 0.6, 1.0], vec![[0.0], [0.0], [0.6], [0.6]]).unwrap();
        let inside = [0.0, 0.1 + 0.2, 0.45, 0.6, 1.0].map(|t| table.time_near(t));
        assert_eq!(inside, [None, Some(0.3), None, Some(0.6), None]);
        let pieces = Pieces::monotone(table);
        let [before, after] = [f64::NAN, 0.3].map(|passed| pieces.motion(0.3, passed));
        assert_eq!((before[0], before[1], before[2]), ([0.0], [0.0], [0.0]));
        assert_eq!((after[0], after[1]), ([0.0], [0.0]));
        // 6 times the rise over the square of its duration.
        assert!((after[2][0] - 6.0 * 0.6 / 0.09).abs() < 1e-9);
        assert!((pieces.motion(0.6, 0.3)[2][0] + 6.0 * 0.6 / 0.09).abs() < 1e-9);
        assert_eq!(pieces.motion(0.0, f64::NAN)[2], [0.0]);
        assert_eq!(pieces.motion(1.0, 1.0)[2], [0.0]);
    }

    #[test]
    fn monotone_pieces_keep_the_shape() {
        let table = Table::new(vec![0.0, 1.0, 2.0, 4.0], vec![[0.0], [0.1], [0.1], [1.0]]).unwrap();
        let pieces = Pieces::monotone(table);
        for i in 0..=400 {
            let [[value], [rate], _] = pieces.motion(0.01 * f64::from(i), f64::NAN);
            assert!((-1e-15..=1.0 + 1e-15).contains(&value) && rate >= -1e-15, "{i}");
            assert!(!(100..=200).contains(&i) || (value - 0.1).abs() < 1e-15, "{i}");
        }
        assert!(pieces.motion(4.5, f64::NAN)[0][0].is_nan());
    }
}
