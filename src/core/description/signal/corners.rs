//! Corners of tables within steps of fixed size. A step sees a table at its ends only; a step that ends at
//! corners sees straight lines, which the trapezoidal rule integrates exactly.

use super::table::Table;
use super::times::rounding_of_times;

/// Maximum number of parts into which a table with many times divides a step.
const MOST_PARTS: usize = 8;

/// A step passes over several corners if its ends predict the mean of the table over the step with an error
/// below this part of the range of the table. Errors of steps that resolve a smooth table are smaller.
const NEGLIGIBLE_ERROR: f64 = 1e-4;

/// The range of a sine over the mean of its magnitude, about.
const RANGE_OF_MEAN: f64 = 3.0;

/// The same for an error below this part of the mean magnitude over the step: larger errors belong to low pulses, which are hardly visible
/// at the ends. A smooth table that leaves zero has such errors for a few steps.
const MISSED_PULSE: f64 = 1e-2;

/// Pulses lower than this part of the others of their table are ignored.
const NEGLIGIBLE_PULSE: f64 = 1e-7;

/// Relative change of the slope that is rounding.
const ROUNDING_OF_SLOPES: f64 = 1e-9;

/// The rest of a step of fixed size.
#[derive(Clone, Copy, Debug)]
pub struct Cell {
    /// Start of the whole step.
    pub start: f64,
    /// Current time.
    pub t: f64,
    /// End of the step.
    pub end: f64,
}

impl Cell {
    /// Whether a corner is the end of the step, but for rounding.
    pub fn ends_at(&self, corner: f64) -> bool {
        (corner - self.end).abs() <= self.margin()
    }

    /// The end, or the corner that equals it up to rounding, so that jumps there have their values before. `corner` is the next one in
    /// a cell.
    pub fn end_at_corner(mut self, corner: impl Fn(Self) -> Option<f64>) -> f64 {
        while let Some(next) = corner(self).filter(|&next| next > self.t) {
            if self.ends_at(next) {
                return next;
            }
            self.t = next;
        }
        self.end
    }

    /// Rounding of the times of the step, in seconds.
    pub fn margin(&self) -> f64 {
        rounding_of_times(self.end - self.start, self.end)
    }
}

impl<const N: usize> Table<N> {
    /// The corner at which the step must end; `None` if it may end where it is planned. A single corner always
    /// ends a step, which at most doubles the number of steps. Of several corners, those of a table that the
    /// step resolves anyway do not.
    pub(crate) fn corner(&self, cell: Cell) -> Option<f64> {
        let mut corners = self.corners_within(cell.t, cell);
        let first = corners.next()?;
        if corners.next().is_none() {
            return Some(first);
        }
        // A short pulse is high and a small part of a mean; among others it may be low, and yet all that there is.
        let mean = self.impulse / self.support.max(cell.end - cell.start);
        let size = self.range.min(RANGE_OF_MEAN * mean);
        let [error, magnitude] = self.means(cell);
        let tolerated = (MISSED_PULSE * magnitude)
            .clamp(NEGLIGIBLE_PULSE * NEGLIGIBLE_ERROR * size, NEGLIGIBLE_ERROR * size);
        if error <= tolerated { None } else { self.end_of_part(first, cell) }
    }

    /// The same for tables in which something jumps at corners: steps that do not resolve the table end at each of them.
    pub(crate) fn corner_of_jumps(&self, cell: Cell) -> Option<f64> {
        let mut corners = self.corners_within(cell.t, cell);
        let first = corners.next()?;
        let is_resolved = corners.next().is_some() && self.means(cell)[0] <= NEGLIGIBLE_ERROR * self.range;
        (!is_resolved).then_some(first)
    }

    /// The same for tables whose single corners do not matter.
    pub(crate) fn corner_of_unresolved(&self, cell: Cell) -> Option<f64> {
        let first = self.corners_within(cell.t, cell).next()?;
        if self.means(cell)[0] <= NEGLIGIBLE_ERROR * self.range {
            None
        } else {
            self.end_of_part(first, cell)
        }
    }

    /// The next corner, or of very many the one at which a part of the step is long enough.
    fn end_of_part(&self, first: f64, cell: Cell) -> Option<f64> {
        let of_step = self.corners_within(cell.start, cell);
        if of_step.count() < MOST_PARTS {
            return Some(first);
        }
        let soonest = cell.t + (cell.end - cell.start) / MOST_PARTS as f64;
        self.corners_within(cell.t, cell).find(|&time| time >= soonest)
    }

    /// Times between `t` and the end of the step, but for rounding, at which the slope changes.
    fn corners_within(&self, t: f64, Cell { start, end, .. }: Cell) -> impl Iterator<Item = f64> {
        let margin = rounding_of_times(end - start, end);
        let from = self.times.partition_point(|&time| time <= t + margin);
        let to = self.times.partition_point(|&time| time < end - margin).max(from);
        (from..to).filter(|&i| self.bends_at(i)).map(|i| self.times[i])
    }

    /// Whether the slope changes at the time with this index.
    pub(super) fn bends_at(&self, i: usize) -> bool {
        let [before, after] = [self.slope_after(i.checked_sub(1)), self.slope_after(Some(i))];
        (0..N)
            .any(|k| (after[k] - before[k]).abs() > ROUNDING_OF_SLOPES * before[k].abs().max(after[k].abs()))
    }

    /// Slope after the time with this index: zero before the first time and after the last one.
    pub(super) fn slope_after(&self, i: Option<usize>) -> [f64; N] {
        let Some(i) = i.filter(|&i| i + 1 < self.times.len()) else { return [0.0; N] };
        let h = self.times[i + 1] - self.times[i];
        std::array::from_fn(|k| (self.values[i + 1][k] - self.values[i][k]) / h)
    }

    /// Over the rest of the step, the largest difference between the mean and the mean of its ends, and the largest mean of the
    /// magnitude of a component.
    fn means(&self, Cell { t, end, .. }: Cell) -> [f64; 2] {
        let (from, to) = (self.at(t), self.at(end));
        let first = self.times.partition_point(|&time| time <= t);
        let last = self.times.partition_point(|&time| time < end);
        let [mut integral, mut magnitude] = [[0.0; N]; 2];
        let mut before = (t, from);
        for here in (first..last).map(|i| (self.times[i], self.values[i])).chain([(end, to)]) {
            for k in 0..N {
                let half = 0.5 * (here.0 - before.0);
                integral[k] += half * (before.1[k] + here.1[k]);
                magnitude[k] += half * (before.1[k].abs() + here.1[k].abs());
            }
            before = here;
        }
        let errors = (0..N).map(|k| (integral[k] / (end - t) - 0.5 * (from[k] + to[k])).abs());
        [errors.fold(0.0, f64::max), magnitude.into_iter().fold(0.0, f64::max) / (end - t)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn corners(table: &Table<1>, dt: f64, steps: usize) -> Vec<f64> {
        let mut found = Vec::new();
        for k in 0..steps {
            let (start, end) = (k as f64 * dt, (k + 1) as f64 * dt);
            let mut t = start;
            while let Some(corner) = table.corner(Cell { start, t, end }) {
                assert!(corner > t && corner < end);
                found.push(corner);
                t = corner;
            }
        }
        found
    }

    #[test]
    fn steps_end_at_corners_but_not_at_those_on_their_ends_and_not_on_straight_lines() {
        let values = [0.0, 0.0, 1.0, 2.0, 2.0, 0.0].map(|x| [x]).to_vec();
        let table = Table::new(vec![0.0, 0.25, 0.45, 0.65, 0.7, 0.701], values).unwrap();
        assert_eq!(corners(&table, 0.1, 10), [0.25, 0.65, 0.701]);
        assert_eq!(corners(&table, 1.0, 1), [0.25, 0.65, 0.7, 0.701]);
    }

    #[test]
    fn no_pulse_is_too_short_or_too_low() {
        // A pulse of a millionth of a step.
        let times = [0.0, 0.0533, 0.0533 + 5e-9, 0.0533 + 1e-8].to_vec();
        let table = Table::new(times, [0.0, 0.0, 2e8, 0.0].map(|x| [x]).to_vec()).unwrap();
        assert_eq!(corners(&table, 0.01, 20), [0.0533, 0.0533 + 5e-9, 0.0533 + 1e-8]);
        // A low one before a high one.
        let times = [0.0, 0.0521, 0.0535, 0.0549, 0.15, 0.155, 0.16].to_vec();
        let table =
            Table::new(times.clone(), [0.0, 0.0, 1.0, 0.0, 0.0, 2e3, 0.0].map(|x| [x]).to_vec()).unwrap();
        assert_eq!(corners(&table, 0.01, 14), times[1..4]);
        // A millionth of another one that steps resolve.
        let late =
            (1..=200).map(|i| (0.1 + 1e-3 * i as f64, 1e6 * (0.005 * std::f64::consts::PI * i as f64).sin()));
        let early = [(0.0, 0.0), (0.0521, 0.0), (0.0535, 1.0), (0.0549, 0.0), (0.1, 0.0)];
        let (times, values): (Vec<f64>, Vec<f64>) = early.into_iter().chain(late).unzip();
        let table = Table::new(times, values.into_iter().map(|x| [x]).collect()).unwrap();
        assert_eq!(corners(&table, 0.01, 9), [0.0521, 0.0535, 0.0549]);
        // Short ones in every step.
        let comb = |i: usize| (0.5 + i as f64) * 1e-3;
        let times: Vec<f64> = (0..1000).flat_map(|i| [0.0, 5e-9, 1e-8].map(|x| comb(i) + x)).collect();
        let values = (0..3000).map(|i| [f64::from(u8::from(i % 3 == 1))]).collect();
        assert_eq!(corners(&Table::new(times, values).unwrap(), 1e-3, 1000).len(), 3000);
    }

    #[test]
    fn many_corners_do_not_make_many_steps() {
        let dense = |value: &dyn Fn(f64) -> f64| {
            let times: Vec<f64> = (0..=100_000).map(|i| 1e-5 * i as f64).collect();
            Table::new(times.clone(), times.iter().map(|&t| [value(t)]).collect()).unwrap()
        };
        assert!(corners(&dense(&|t| (6.0 * t).sin()), 1e-3, 1000).is_empty());
        // One that leaves zero smoothly is divided there alone.
        assert!(corners(&dense(&|t| 1.0 - (3.0 * t).cos()), 1e-3, 1000).len() <= 5 * MOST_PARTS);
        let noise = corners(&dense(&|t| (1e7 * t).sin()), 1e-3, 1000);
        assert!(noise.len() < 1000 * MOST_PARTS, "{}", noise.len());
        // A pulse of half a millisecond: steps are divided where it is.
        let pulse = corners(&dense(&|t| (-((t - 0.5003) / 2e-4).powi(2)).exp()), 1e-3, 1000);
        assert!((1..=20).contains(&pulse.len()), "{pulse:?}");
    }
}
