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

mod corners;
mod described;
mod edges;
mod pieces;
mod spline;
mod table;
mod times;

use std::fmt::Debug;
use std::sync::Arc;

use crate::error::{Checker, Interrupted, InvalidInput, Number};

pub use self::corners::Cell;
pub use self::described::Drive;
pub(crate) use self::edges::StepContext;
pub use self::pieces::Jumps;
pub(crate) use self::pieces::Pieces;
pub use self::spline::Motion;
pub(crate) use self::spline::Spline;
pub use self::table::{Interpolation, Table};
#[doc(hidden)]
pub use self::times::{covers, end_of_step, rounding_of_times};

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

/// Distance in seconds of finite differences. Rounding and truncation errors are both below 1e-3 for signals that vary within seconds.
const DIFFERENCE_STEP: f64 = 1e-4;

/// A function jumps if its change in an interval exceeds this many times those in the neighbouring intervals. A function that starts as
/// t^5 changes 31 times more in the second interval than in the first.
const JUMP_FACTOR: f64 = 40.0;

/// Differences of a function on one side of a time.
struct Differences<const N: usize> {
    /// First and second derivative.
    rates: [[f64; N]; 2],
    /// The smaller and the larger change within one of two intervals.
    smallest: f64,
    largest: f64,
}

impl<const N: usize> Differences<N> {
    /// Whether the function may jump in one of the intervals.
    fn may_jump(&self) -> bool {
        self.largest > JUMP_FACTOR * self.smallest
    }
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
        self.value_in_step(t, StepContext::EXACT)
    }

    /// The same in steps, for which tables may jump.
    pub(crate) fn value_in_step(&self, t: f64, step_context: StepContext) -> Result<[f64; N], Interrupted> {
        match self {
            Self::Constant(value) => Ok(*value),
            Self::Harmonic(harmonic) => Ok(harmonic.at(t)),
            Self::Table(table) => Ok(table.value_in_step(t, step_context)),
            Self::Function(Function(function)) => function.value(t),
            Self::Input(input) => Ok(input.value),
        }
    }

    /// First two derivatives with respect to time, after a corner if there is one at `t`; for functions by forward differences. In steps of
    /// fixed size, which pass over jumps, backward differences are used directly before a jump; other methods end steps there. Only a
    /// function can fail.
    pub(crate) fn rates(&self, t: f64, step_context: StepContext) -> Result<[[f64; N]; 2], Interrupted> {
        match self {
            Self::Constant(_) | Self::Input(_) => Ok([[0.0; N]; 2]),
            Self::Harmonic(harmonic) => {
                let [_, rate, bend] = harmonic.motion(t);
                Ok([rate, bend])
            }
            Self::Table(table) => Ok([table.slope(t), [0.0; N]]),
            Self::Function(_) => {
                let forward = self.differences(t, DIFFERENCE_STEP)?;
                let goes_over_jumps = step_context.dt > 0.0;
                if !(goes_over_jumps && forward.may_jump()) {
                    return Ok(forward.rates);
                }
                let backward = self.differences(t, -DIFFERENCE_STEP)?;
                let is_jump = forward.largest > JUMP_FACTOR * backward.largest.max(forward.smallest);
                Ok(if is_jump { backward.rates } else { forward.rates })
            }
        }
    }

    /// Differences of values on one side of a time.
    fn differences(&self, t: f64, apart: f64) -> Result<Differences<N>, Interrupted> {
        let [here, next, last] = [self.at(t)?, self.at(t + apart)?, self.at(t + 2.0 * apart)?];
        let [first, second]: [[f64; N]; 2] =
            [std::array::from_fn(|i| next[i] - here[i]), std::array::from_fn(|i| last[i] - next[i])];
        let bend = std::array::from_fn(|i| (second[i] - first[i]) / (apart * apart));
        let rate = std::array::from_fn(|i| first[i] / apart - 0.5 * apart * bend[i]);
        let sizes = [first, second].map(|values| values.into_iter().map(f64::abs).fold(0.0, f64::max));
        let [smallest, largest] = [sizes[0].min(sizes[1]), sizes[0].max(sizes[1])];
        Ok(Differences { rates: [rate, bend], smallest, largest })
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
                let values = table.values().iter().map(|value| value[entry]).enumerate();
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
        const SAMPLES_PER_PERIOD: f64 = 4.0;
        match self {
            Self::Constant(_) | Self::Function(_) | Self::Input(_) => f64::INFINITY,
            Self::Harmonic(_) => (t + self.period() / SAMPLES_PER_PERIOD).max(t.next_up()),
            Self::Table(table) => table.next_time(t),
        }
    }

    /// The next time at which a step of fixed size must end, so that it loses nothing of a table.
    pub(crate) fn corner(&self, cell: Cell) -> Option<f64> {
        if let Self::Table(table) = self { table.corner(cell) } else { None }
    }

    /// Whether values may jump at some time for steps of the size `dt`.
    pub(crate) fn has_edges(&self, dt: f64) -> bool {
        matches!(self, Self::Table(table) if table.has_edges(dt))
    }

    /// The time at which the value jumps for steps of the size `dt`, if that is `t`, but for rounding.
    pub(crate) fn edge_near(&self, t: f64, dt: f64) -> Option<f64> {
        if let Self::Table(table) = self { table.edge_near(t, dt) } else { None }
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
                // A single number has no index.
                let place = format!("{place}.default");
                match input.value.as_slice() {
                    [value] => check.require(value.is_finite(), &place, Number(*value), "a finite number"),
                    values => check.finite(values, &place),
                };
            }
            // The rest of a table is checked on creation; values of functions are checked when they are called.
            Self::Table(table) => {
                let found = table.interpolation().filter(|&given| given != Interpolation::Linear);
                if let Some(found) = found {
                    let expected = "\"linear\", or none: only prescribed motions have others";
                    check.require(false, &format!("{place}.interpolation"), found.name(), expected);
                }
            }
            Self::Function(_) => {}
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

/// A shared function of time.
#[derive(Clone, Debug)]
pub struct Function<const N: usize>(pub Arc<dyn Evaluate<N>>);

impl<const N: usize> PartialEq for Function<N> {
    fn eq(&self, other: &Self) -> bool {
        self.0.identity() == other.0.identity()
    }
}

/// Time dependence of a signal with any number of entries; see the functions of [`Signal`].
pub(crate) trait Timed {
    /// [`Signal::varies_in_time`].
    fn varies_in_time(&self) -> bool;
    /// [`Signal::horizon`].
    fn horizon(&self, t: f64) -> f64;
    /// [`Signal::corner`].
    fn corner(&self, cell: Cell) -> Option<f64>;
    /// [`Signal::has_edges`].
    fn has_edges(&self, dt: f64) -> bool;
    /// [`Signal::edge_near`].
    fn edge_near(&self, t: f64, dt: f64) -> Option<f64>;
    /// [`Signal::period`].
    fn period(&self) -> f64;
    /// An entry that is not finite at a time, if it can be computed at all.
    fn not_finite(&self, t: f64) -> Option<f64>;
}

impl<const N: usize> Timed for Signal<N> {
    fn varies_in_time(&self) -> bool {
        self.varies_in_time()
    }

    fn horizon(&self, t: f64) -> f64 {
        self.horizon(t)
    }

    fn corner(&self, cell: Cell) -> Option<f64> {
        self.corner(cell)
    }

    fn has_edges(&self, dt: f64) -> bool {
        self.has_edges(dt)
    }

    fn edge_near(&self, t: f64, dt: f64) -> Option<f64> {
        self.edge_near(t, dt)
    }

    fn period(&self) -> f64 {
        self.period()
    }

    fn not_finite(&self, t: f64) -> Option<f64> {
        self.at(t).ok()?.into_iter().find(|x| !x.is_finite())
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
    fn a_harmonic_signal_is_its_formula() {
        let harmonic = Harmonic { mean: [1.0], rate: [2.0], amplitude: [3.0], frequency: 0.25, phase: 0.5 };
        let value = Signal::Harmonic(harmonic).at(2.0).unwrap()[0];
        assert!((value - (1.0 + 4.0 + 3.0 * (std::f64::consts::PI + 0.5).sin())).abs() < 1e-14);
    }
}
