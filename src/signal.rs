//! Vectors that depend on time: what loads that vary follow.

use std::fmt::Debug;
use std::sync::Arc;

use crate::error::{Checker, Interrupted, InvalidInput, Number};

/// N numbers as a function of time.
#[derive(Clone, Debug, PartialEq)]
pub enum Signal<const N: usize> {
    /// Always the same.
    Constant([f64; N]),
    /// A steady part and an oscillation.
    Harmonic(Harmonic<N>),
    /// Given at some times.
    Table(Arc<Table<N>>),
    /// Anything else.
    Function(Function<N>),
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
    /// The value at a time. Only a function can fail.
    pub fn at(&self, t: f64) -> Result<[f64; N], Interrupted> {
        match self {
            Self::Constant(value) => Ok(*value),
            Self::Harmonic(harmonic) => Ok(harmonic.at(t)),
            Self::Table(table) => Ok(table.at(t)),
            Self::Function(Function(function)) => function.value(t),
        }
    }

    /// The value, if it is always the same.
    pub fn constant(&self) -> Option<[f64; N]> {
        if let Self::Constant(value) = self { Some(*value) } else { None }
    }

    /// Whether it is zero at all times, and known to be.
    pub fn is_zero(&self) -> bool {
        self.constant() == Some([0.0; N])
    }

    /// Everything that is wrong with this signal, which stands at `place`.
    pub fn check(&self, check: &mut Checker, place: &str) {
        match self {
            Self::Constant(value) => _ = check.finite(value, place),
            Self::Harmonic(harmonic) => _ = check.nested(place, harmonic.validate()),
            // A table was checked when it was made; what a function returns is seen when it is called.
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
    /// Nothing yet: a start for `..` syntax.
    pub fn zero() -> Self {
        Self { mean: [0.0; N], rate: [0.0; N], amplitude: [0.0; N], frequency: 0.0, phase: 0.0 }
    }

    fn at(&self, t: f64) -> [f64; N] {
        let sine = (std::f64::consts::TAU * self.frequency * t + self.phase).sin();
        std::array::from_fn(|i| self.mean[i] + self.rate[i] * t + self.amplitude[i] * sine)
    }

    /// Everything that is wrong with it.
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

/// Values at some times: straight lines from one to the next, held before the first and after the last.
#[derive(Clone, Debug, PartialEq)]
pub struct Table<const N: usize> {
    times: Vec<f64>,
    values: Vec<[f64; N]>,
}

impl<const N: usize> Table<N> {
    /// Values at times in seconds, which must increase; at least two.
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

    /// The values at these times.
    pub fn values(&self) -> &[[f64; N]] {
        &self.values
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

/// A function of time that somebody else provides.
pub trait Evaluate<const N: usize>: std::any::Any + Debug + Send + Sync {
    /// The value at a time; one that is not finite ends the run with a status that says so.
    fn value(&self, t: f64) -> Result<[f64; N], Interrupted>;

    /// Functions of the same identity are the same; by default one is only the same as itself.
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
