//! Signals with derivatives, for positions and angles; loads need values only.

use super::prescribed::Prescribed;
use crate::error::{Checker, Interrupted};
use crate::signal::{Harmonic, Motion, Signal, Spline};

/// Interval of time on which a signal has derivatives.
pub(crate) fn span<const N: usize>(signal: &Signal<N>) -> [f64; 2] {
    match signal {
        Signal::Table(table) => [table.times()[0], table.times()[table.times().len() - 1]],
        _ => [f64::NEG_INFINITY, f64::INFINITY],
    }
}

/// Reports every problem of a signal, located at `place`, that prescribes a motion. Inputs are rejected
/// because they have no derivatives.
pub(crate) fn check_smooth<const N: usize>(signal: &Signal<N>, check: &mut Checker, place: &str) {
    signal.check(check, place);
    if let Some(input) = signal.input() {
        let found = format_args!("the input \"{}\"", input.name);
        check.require(false, place, found, "a motion known in time; a Motor moves a joint by an input");
    }
}

/// A signal with two derivatives.
#[derive(Clone, Debug)]
pub(crate) enum Smooth<const N: usize> {
    Constant([f64; N]),
    Harmonic(Harmonic<N>),
    Spline(Spline<N>),
    Function(Prescribed<N>),
}

impl<const N: usize> Smooth<N> {
    pub(crate) fn new(signal: &Signal<N>) -> Self {
        match signal {
            Signal::Constant(value) => Self::Constant(*value),
            Signal::Harmonic(harmonic) => Self::Harmonic(*harmonic),
            Signal::Table(table) => Self::Spline(Spline::new(table)),
            Signal::Function(function) => Self::Function(Prescribed::new(function.clone())),
            // `check_smooth` rejects inputs, which have no derivatives.
            Signal::Input(input) => Self::Constant(input.value),
        }
    }

    /// Value and first two derivatives.
    pub(crate) fn motion(&self, t: f64) -> Result<Motion<N>, Interrupted> {
        match self {
            Self::Constant(value) => Ok([*value, [0.0; N], [0.0; N]]),
            Self::Harmonic(harmonic) => Ok(harmonic.motion(t)),
            Self::Spline(spline) => Ok(spline.motion(t)),
            Self::Function(function) => function.motion(t),
        }
    }
}
