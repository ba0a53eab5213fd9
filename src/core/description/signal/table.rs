//! Tables of values over time.

use super::times::rounding_of_times;
use crate::description::schema::Described;
use crate::error::{Checker, InvalidInput, Number};

/// Values at given times. As a signal: linear interpolation, constant before the first and after the last
/// time. As a prescribed motion: interpolated as the table says.
#[derive(Clone, Debug, PartialEq)]
pub struct Table<const N: usize> {
    pub(super) times: Vec<f64>,
    pub(super) values: Vec<[f64; N]>,
    interpolation: Option<Interpolation>,
    /// Largest range of a component.
    pub(super) range: f64,
    /// Shortest time from one entry to the next.
    pub(super) narrowest: f64,
    /// Largest integral of the magnitude of a component between the times, and from where to where values are not zero.
    pub(super) impulse: f64,
    pub(super) support: f64,
}

/// Interpolation of a table.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Described)]
pub enum Interpolation {
    /// Straight lines, constant before the first and after the last time. The velocity of a prescribed motion
    /// jumps at corners.
    Linear,
    /// Cubic pieces that are monotone wherever the values are, with a continuous first derivative (Fritsch
    /// and Butland 1984).
    Monotone,
    /// Cubic spline with continuous first and second derivatives and not-a-knot ends (de Boor 1978).
    Cubic,
}

impl Interpolation {
    /// The names, in this order.
    pub const NAMES: [&str; 3] = ["linear", "monotone", "cubic"];

    /// The interpolation of this name.
    pub fn by_name(name: &str) -> Option<Self> {
        let all = [Self::Linear, Self::Monotone, Self::Cubic];
        all.into_iter().zip(Self::NAMES).find(|(_, own)| *own == name).map(|(interpolation, _)| interpolation)
    }

    /// The name.
    pub fn name(self) -> &'static str {
        Self::NAMES[self as usize]
    }
}

impl<const N: usize> Table<N> {
    /// The first time of the table after `t`; infinite after the last time. Times within rounding of `t`
    /// count as `t`, because a step to them would consist of rounding errors.
    pub(super) fn next_time(&self, t: f64) -> f64 {
        let apart = (self.times[self.times.len() - 1] - self.times[0]) / self.times.len() as f64;
        let margin = rounding_of_times(apart, t);
        let next = self.times.partition_point(|&time| time <= t + margin);
        self.times.get(next).copied().unwrap_or(f64::INFINITY)
    }

    /// A table of values at strictly increasing times in seconds; at least two.
    pub fn new(times: Vec<f64>, values: Vec<[f64; N]>) -> Result<Self, InvalidInput> {
        let mut check = Checker::new();
        let enough = check.require(
            times.len() >= 2,
            "times",
            format_args!("{} times", times.len()),
            "at least two (a value that never changes needs no table)",
        );
        let finite = check.finite(&times, "times");
        if enough && finite {
            let unordered = (1..times.len()).find(|&i| times[i] <= times[i - 1]);
            if let Some(i) = unordered {
                let expected = format!("a time > times[{}] = {} (seconds)", i - 1, times[i - 1]);
                check.require(false, &format!("times[{i}]"), Number(times[i]), &expected);
            }
        }
        check.require(
            values.len() == times.len(),
            "values",
            format_args!("{} values", values.len()),
            &format!("one for each of the {} times", times.len()),
        );
        for (i, value) in values.iter().enumerate() {
            check.finite(value, &format!("values[{i}]"));
        }
        check.finish()?;
        let range_of = |i: usize| {
            let column = || values.iter().map(|value| value[i]);
            column().fold(f64::NEG_INFINITY, f64::max) - column().fold(f64::INFINITY, f64::min)
        };
        let range = (0..N).map(range_of).fold(0.0, f64::max);
        let narrowest = times.windows(2).map(|pair| pair[1] - pair[0]).fold(f64::INFINITY, f64::min);
        let pairs = || times.windows(2).zip(values.windows(2)).map(|(t, v)| (t[1] - t[0], [&v[0], &v[1]]));
        let impulse_of =
            |i: usize| -> f64 { pairs().map(|(h, [a, b])| 0.5 * h * (a[i].abs() + b[i].abs())).sum() };
        let impulse = (0..N).map(impulse_of).fold(0.0, f64::max);
        let acts = |(_, [a, b]): &(f64, [&[f64; N]; 2])| a.iter().chain(*b).any(|x| *x != 0.0);
        let ends = [pairs().position(|pair| acts(&pair)), pairs().rposition(|pair| acts(&pair))];
        let support = if let [Some(first), Some(last)] = ends { times[last + 1] - times[first] } else { 0.0 };
        Ok(Self { times, values, interpolation: None, range, narrowest, impulse, support })
    }

    /// The same table with an interpolation; without one, signals are linear and prescribed motions cubic.
    #[must_use]
    pub fn interpolated(self, interpolation: Option<Interpolation>) -> Self {
        Self { interpolation, ..self }
    }

    /// The interpolation, if one was given.
    pub fn interpolation(&self) -> Option<Interpolation> {
        self.interpolation
    }

    /// The times, in seconds.
    pub fn times(&self) -> &[f64] {
        &self.times
    }

    /// The values at the times.
    pub fn values(&self) -> &[[f64; N]] {
        &self.values
    }

    /// Slope to the right of a time.
    pub(super) fn slope(&self, t: f64) -> [f64; N] {
        let after = self.times.partition_point(|&time| time <= t);
        if after == 0 || after == self.times.len() {
            return [0.0; N];
        }
        let (a, b) = (&self.values[after - 1], &self.values[after]);
        std::array::from_fn(|i| (b[i] - a[i]) / (self.times[after] - self.times[after - 1]))
    }

    pub(super) fn at(&self, t: f64) -> [f64; N] {
        let after = self.times.partition_point(|&time| time <= t);
        let Some(before) = after.checked_sub(1) else { return self.values[0] };
        let Some(&end) = self.times.get(after) else { return self.values[before] };
        let start = self.times[before];
        let x = (t - start) / (end - start);
        let (a, b) = (&self.values[before], &self.values[after]);
        std::array::from_fn(|i| (1.0 - x) * a[i] + x * b[i])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tables_that_make_no_sense_are_refused() {
        let places = |times: &[f64], values: &[[f64; 1]]| {
            let error = Table::new(times.to_vec(), values.to_vec()).unwrap_err();
            error.problems.iter().map(|problem| problem.place.clone()).collect::<Vec<_>>()
        };
        assert_eq!(places(&[0.0], &[[1.0]]), ["times"]);
        assert_eq!(places(&[0.0, 0.0], &[[1.0], [2.0]]), ["times[1]"]);
        assert_eq!(places(&[0.0, f64::NAN], &[[1.0], [2.0]]), ["times[1]"]);
        assert_eq!(places(&[0.0, 1.0], &[[1.0]]), ["values"]);
        assert_eq!(places(&[0.0, 1.0], &[[1.0], [f64::INFINITY]]), ["values[1][0]"]);
    }
}
