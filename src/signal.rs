//! Functions of time for loads, inputs and moving bases.
//!
//! ```
//! use lissom::signal::{Signal, Table};
//! use std::sync::Arc;
//!
//! let ramp = Signal::Table(Arc::new(Table::new(vec![0.0, 1.0], vec![[0.0], [2.0]])?));
//! assert_eq!(ramp.at(0.5), Ok([1.0]));
//! # Ok::<(), lissom::error::InvalidInput>(())
//! ```

use std::fmt::Debug;
use std::sync::Arc;

use crate::error::{Checker, Interrupted, InvalidInput, Number};

/// N numbers as a function of time.
#[derive(Clone, Debug, PartialEq)]
pub enum Signal<const N: usize> {
    /// A constant.
    Constant([f64; N]),
    /// A steady part plus an oscillation.
    Harmonic(Harmonic<N>),
    /// A table of values over time.
    Table(Arc<Table<N>>),
    /// Anything else.
    Function(Function<N>),
    /// An input, set from outside while a model moves.
    Input(Input<N>),
}

/// N numbers set by a controller. Inputs of the same name are the same input.
#[derive(Clone, Debug, PartialEq)]
pub struct Input<const N: usize> {
    /// The name.
    pub name: Arc<str>,
    /// Default value.
    pub value: [f64; N],
}

impl<const N: usize> From<[f64; N]> for Signal<N> {
    fn from(value: [f64; N]) -> Self {
        Self::Constant(value)
    }
}

impl<const N: usize> Default for Signal<N> {
    fn default() -> Self {
        Self::Constant([0.0; N])
    }
}

impl<const N: usize> Signal<N> {
    /// Value at a time; the default value of an input. Only a function can fail.
    pub fn at(&self, t: f64) -> Result<[f64; N], Interrupted> {
        match self {
            Self::Constant(value) => Ok(*value),
            Self::Harmonic(harmonic) => Ok(harmonic.at(t)),
            Self::Table(table) => Ok(table.at(t)),
            Self::Function(Function(function)) => function.value(t),
            Self::Input(input) => Ok(input.value),
        }
    }

    /// First two derivatives with respect to time, to the right of a corner; of a function by forward
    /// differences. Only a function can fail.
    pub(crate) fn rates(&self, t: f64) -> Result<[[f64; N]; 2], Interrupted> {
        /// Seconds. Rounding and truncation errors are both below 1e-3 of signals that vary within seconds.
        const APART: f64 = 1e-4;
        match self {
            Self::Constant(_) | Self::Input(_) => Ok([[0.0; N]; 2]),
            Self::Harmonic(harmonic) => {
                let [_, rate, bend] = harmonic.motion(t);
                Ok([rate, bend])
            }
            Self::Table(table) => Ok([table.slope(t), [0.0; N]]),
            Self::Function(_) => {
                let [here, next, last] = [self.at(t)?, self.at(t + APART)?, self.at(t + 2.0 * APART)?];
                let bend = |i: usize| (here[i] - 2.0 * next[i] + last[i]) / (APART * APART);
                let rate = |i: usize| (next[i] - here[i]) / APART - 0.5 * APART * bend(i);
                Ok([std::array::from_fn(rate), std::array::from_fn(bend)])
            }
        }
    }

    /// The input, if the signal is one.
    pub fn input(&self) -> Option<&Input<N>> {
        if let Self::Input(input) = self { Some(input) } else { None }
    }

    /// Whether the signal depends on time explicitly.
    pub fn varies_in_time(&self) -> bool {
        !matches!(self, Self::Constant(_) | Self::Input(_))
    }

    /// Value of a constant signal.
    pub fn constant(&self) -> Option<[f64; N]> {
        if let Self::Constant(value) = self { Some(*value) } else { None }
    }

    /// Whether the signal is a zero constant.
    pub fn is_zero(&self) -> bool {
        self.constant() == Some([0.0; N])
    }

    /// A lower bound of an entry while inputs keep their default values, and the path of the value that
    /// determines it; `None` for functions and for growing signals.
    pub fn known_lowest(&self, entry: usize) -> Option<(f64, String)> {
        match self {
            Self::Constant(value) => Some((value[entry], String::new())),
            Self::Input(input) => Some((input.value[entry], ".default".to_owned())),
            Self::Table(table) => {
                let values = table.values.iter().map(|value| value[entry]).enumerate();
                let (i, lowest) = values.min_by(|a, b| a.1.total_cmp(&b.1))?;
                Some((lowest, format!(".values[{i}]")))
            }
            Self::Harmonic(harmonic) if harmonic.rate[entry] == 0.0 && harmonic.frequency > 0.0 => {
                Some((harmonic.mean[entry] - harmonic.amplitude[entry].abs(), String::new()))
            }
            Self::Harmonic(_) | Self::Function(_) => None,
        }
    }

    /// Latest end of a step from `t` that cannot miss a feature of this signal: the next time of a table, or
    /// a quarter of a period. Always later than `t`; infinite for functions, about which nothing is known.
    pub fn horizon(&self, t: f64) -> f64 {
        /// Evaluations per period that detect every oscillation.
        const LOOKS: f64 = 4.0;
        match self {
            Self::Constant(_) | Self::Function(_) | Self::Input(_) => f64::INFINITY,
            Self::Harmonic(_) => (t + self.period() / LOOKS).max(t.next_up()),
            Self::Table(table) => table.next_time(t),
        }
    }

    /// Period of the oscillation in seconds; infinite without an oscillation.
    pub fn period(&self) -> f64 {
        match self {
            Self::Harmonic(harmonic) if harmonic.amplitude.iter().any(|&amplitude| amplitude != 0.0) => {
                harmonic.frequency.recip()
            }
            _ => f64::INFINITY,
        }
    }

    /// Reports every problem of this signal, located at `place`.
    pub fn check(&self, check: &mut Checker, place: &str) {
        match self {
            Self::Constant(value) if N == 1 => {
                check.require(value[0].is_finite(), place, Number(value[0]), "a finite number");
            }
            Self::Constant(value) => _ = check.finite(value, place),
            Self::Harmonic(harmonic) => _ = check.nested(place, harmonic.validate()),
            Self::Input(input) => {
                check.require(
                    !input.name.is_empty(),
                    &format!("{place}.name"),
                    "\"\"",
                    "a name for the input",
                );
                check.finite(&input.value, &format!("{place}.default"));
            }
            // Tables are checked on creation; values of functions are checked when they are called.
            Self::Table(_) | Self::Function(_) => {}
        }
    }
}

/// `mean + rate t + amplitude sin(2 pi frequency t + phase)`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Harmonic<const N: usize> {
    /// Steady part.
    pub mean: [f64; N],
    /// Growth of the steady part per second.
    pub rate: [f64; N],
    /// Largest deviation from the steady part.
    pub amplitude: [f64; N],
    /// Oscillations per second, hertz.
    pub frequency: f64,
    /// Phase at time zero, radians.
    pub phase: f64,
}

impl<const N: usize> Harmonic<N> {
    /// Zero: a start for `..` syntax.
    pub fn zero() -> Self {
        Self { mean: [0.0; N], rate: [0.0; N], amplitude: [0.0; N], frequency: 0.0, phase: 0.0 }
    }

    fn at(&self, t: f64) -> [f64; N] {
        let sine = (std::f64::consts::TAU * self.frequency * t + self.phase).sin();
        std::array::from_fn(|i| self.mean[i] + self.rate[i] * t + self.amplitude[i] * sine)
    }

    /// Value and first two derivatives.
    pub(crate) fn motion(&self, t: f64) -> Motion<N> {
        let omega = std::f64::consts::TAU * self.frequency;
        let (sine, cosine) = (omega * t + self.phase).sin_cos();
        [
            self.at(t),
            std::array::from_fn(|i| self.rate[i] + self.amplitude[i] * omega * cosine),
            std::array::from_fn(|i| -self.amplitude[i] * omega * omega * sine),
        ]
    }

    /// Reports every problem of the oscillation.
    pub fn validate(&self) -> Result<(), InvalidInput> {
        let mut check = Checker::new();
        check.finite(&self.mean, "mean");
        check.finite(&self.rate, "rate");
        check.finite(&self.amplitude, "amplitude");
        check.non_negative(self.frequency, "frequency", "hertz");
        check.require(self.phase.is_finite(), "phase", Number(self.phase), "a finite number (radians)");
        check.finish()
    }
}

/// Values at given times: linear interpolation, constant before the first and after the last time.
#[derive(Clone, Debug, PartialEq)]
pub struct Table<const N: usize> {
    times: Vec<f64>,
    values: Vec<[f64; N]>,
}

impl<const N: usize> Table<N> {
    /// The first time of the table after `t`; infinite after the last time. Times within rounding of `t`
    /// count as `t`, because a step to them would consist of rounding errors.
    fn next_time(&self, t: f64) -> f64 {
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
        Ok(Self { times, values })
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
    fn slope(&self, t: f64) -> [f64; N] {
        let after = self.times.partition_point(|&time| time <= t);
        if after == 0 || after == self.times.len() {
            return [0.0; N];
        }
        let (a, b) = (&self.values[after - 1], &self.values[after]);
        std::array::from_fn(|i| (b[i] - a[i]) / (self.times[after] - self.times[after - 1]))
    }

    fn at(&self, t: f64) -> [f64; N] {
        let after = self.times.partition_point(|&time| time <= t);
        let Some(before) = after.checked_sub(1) else { return self.values[0] };
        let Some(&end) = self.times.get(after) else { return self.values[before] };
        let start = self.times[before];
        let x = (t - start) / (end - start);
        let (a, b) = (&self.values[before], &self.values[after]);
        std::array::from_fn(|i| (1.0 - x) * a[i] + x * b[i])
    }
}

/// A user-defined function of time.
pub trait Evaluate<const N: usize>: std::any::Any + Debug + Send + Sync {
    /// Value at a time. A non-finite value ends the run with a status that names the function.
    fn value(&self, t: f64) -> Result<[f64; N], Interrupted>;

    /// Value and first two derivatives, if the function provides them; otherwise they are computed by finite
    /// differences.
    fn motion(&self, _t: f64) -> Result<Option<Motion<N>>, Interrupted> {
        Ok(None)
    }

    /// Reports a useless value of this function. The implementation may keep the message and raise it after
    /// the computation.
    fn refuse(&self, _found: String, _expected: &str) -> Interrupted {
        Interrupted
    }

    /// Functions with the same identity are the same function. By default each function has its own identity.
    fn identity(&self) -> usize {
        std::ptr::from_ref(self).cast::<()>() as usize
    }
}

/// A value with its first and second derivatives.
pub type Motion<const N: usize> = [[f64; N]; 3];

/// End of the longest step from `t`: the horizon, or the end of the run if both differ only by rounding,
/// because the remaining step would be too short.
pub(crate) fn end_of_step(t: f64, t_end: f64, horizon: f64) -> f64 {
    if t_end - horizon <= rounding_of_times(t_end - t, t_end) { t_end } else { horizon }
}

/// Tolerance, near `t`, for times that are meant to be equal, if distinct times are `apart`.
fn rounding_of_times(apart: f64, t: f64) -> f64 {
    const PART: f64 = 1e-9;
    const UNITS: f64 = 8.0;
    (PART * apart).max(UNITS * f64::EPSILON * t.abs())
}

/// Whether a time lies between two others, or beyond them by rounding only, as at the last step of a run.
pub(crate) fn covers([from, to]: [f64; 2], t: f64) -> bool {
    /// Rounding of a time, relative to the length of the interval.
    const ROUNDING: f64 = 1e-12;
    let margin = if (to - from).is_finite() { ROUNDING * (to - from) } else { 0.0 };
    (from - margin..=to + margin).contains(&t)
}

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

/// A shared function of time.
#[derive(Clone, Debug)]
pub struct Function<const N: usize>(pub Arc<dyn Evaluate<N>>);

impl<const N: usize> PartialEq for Function<N> {
    fn eq(&self, other: &Self) -> bool {
        self.0.identity() == other.0.identity()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_table_is_a_chain_of_straight_lines_held_at_its_ends() {
        let table = Table::new(vec![0.0, 1.0, 3.0], vec![[0.0], [2.0], [-2.0]]).unwrap();
        let signal = Signal::Table(Arc::new(table));
        let wanted = [(-1.0, 0.0), (0.0, 0.0), (0.5, 1.0), (1.0, 2.0), (2.0, 0.0), (3.0, -2.0), (9.0, -2.0)];
        for (t, value) in wanted {
            assert_eq!(signal.at(t), Ok([value]), "at {t}");
        }
        assert!(signal.constant().is_none() && !signal.is_zero());
    }

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

    #[test]
    fn a_harmonic_signal_is_its_formula() {
        let harmonic = Harmonic { mean: [1.0], rate: [2.0], amplitude: [3.0], frequency: 0.25, phase: 0.5 };
        let value = Signal::Harmonic(harmonic).at(2.0).unwrap()[0];
        assert!((value - (1.0 + 4.0 + 3.0 * (std::f64::consts::PI + 0.5).sin())).abs() < 1e-14);
    }

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
