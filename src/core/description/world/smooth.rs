//! Signals with derivatives, for positions and angles; loads need values only.

use super::prescribed::Prescribed;
use crate::description::signal::{
    Cell, Harmonic, Interpolation, Jumps, Motion, Pieces, Signal, Spline, StepContext, Table,
};
use crate::error::{Checker, Interrupted};

/// Interval of time on which a signal has derivatives.
pub(crate) fn span<const N: usize>(signal: &Signal<N>) -> [f64; 2] {
    match signal {
        Signal::Table(table) if !is_linear(table) => {
            [table.times()[0], table.times()[table.times().len() - 1]]
        }
        _ => [f64::NEG_INFINITY, f64::INFINITY],
    }
}

/// Reports every problem of a signal, located at `place`, that prescribes a motion. Inputs are rejected
/// because they have no derivatives.
pub(crate) fn check_smooth<const N: usize>(signal: &Signal<N>, check: &mut Checker, place: &str) {
    if !matches!(signal, Signal::Table(_)) {
        signal.check(check, place);
    }
    if let Some(input) = signal.input() {
        let found = format_args!("the input \"{}\"", input.name);
        check.require(false, place, found, "a motion known in time; a Motor moves a joint by an input");
    }
}

fn is_linear<const N: usize>(table: &Table<N>) -> bool {
    table.interpolation() == Some(Interpolation::Linear)
}

/// Latest end of a step from `t` that cannot miss a feature of a prescribed motion ([`Signal::horizon`]).
pub(crate) fn horizon<const N: usize>(signal: &Signal<N>, t: f64) -> f64 {
    match signal {
        Signal::Table(table) if is_linear(table) => table.next_corner(t).unwrap_or(f64::INFINITY),
        _ => signal.horizon(t),
    }
}

/// The next time at which a step of fixed size must end ([`Signal::corner`]): all jumps of the velocity.
pub(crate) fn corner<const N: usize>(signal: &Signal<N>, cell: Cell) -> Option<f64> {
    match signal {
        Signal::Table(table) => match table.interpolation() {
            Some(Interpolation::Linear) => {
                table.next_corner(cell.t).filter(|&time| time <= cell.end + cell.margin())
            }
            // The acceleration jumps at each time.
            Some(Interpolation::Monotone) => table.corner_of_jumps(cell),
            Some(Interpolation::Cubic) | None => table.corner_of_unresolved(cell),
        },
        _ => None,
    }
}

/// The time at which the velocity or the acceleration jumps, if that is `t`, but for rounding.
pub(crate) fn jump_near<const N: usize>(signal: &Signal<N>, t: f64) -> Option<f64> {
    let Signal::Table(table) = signal else { return None };
    match table.interpolation()? {
        Interpolation::Linear => table.jump_near(t),
        Interpolation::Monotone => table.time_near(t),
        Interpolation::Cubic => None,
    }
}

/// The quantities that may jump at some time.
pub(crate) fn jumps<const N: usize>(signal: &Signal<N>) -> Jumps {
    let Signal::Table(table) = signal else { return Jumps::Nothing };
    match table.interpolation() {
        Some(Interpolation::Linear) => Jumps::Velocities,
        Some(Interpolation::Monotone) => Jumps::Accelerations,
        Some(Interpolation::Cubic) | None => Jumps::Nothing,
    }
}

/// A signal with two derivatives, but for jumps of the velocity.
#[derive(Clone, Debug)]
pub(crate) enum Smooth<const N: usize> {
    Constant([f64; N]),
    Harmonic(Harmonic<N>),
    Spline(Spline<N>),
    Pieces(Pieces<N>),
    Function(Prescribed<N>),
}

impl<const N: usize> Smooth<N> {
    pub(crate) fn new(signal: &Signal<N>) -> Self {
        match signal {
            Signal::Constant(value) => Self::Constant(*value),
            Signal::Harmonic(harmonic) => Self::Harmonic(*harmonic),
            Signal::Table(table) => Self::of_table(table),
            Signal::Function(function) => Self::Function(Prescribed::new(function.clone())),
            // `check_smooth` rejects inputs, which have no derivatives.
            Signal::Input(input) => Self::Constant(input.value),
        }
    }

    pub(crate) fn of_table(table: &Table<N>) -> Self {
        match table.interpolation() {
            Some(Interpolation::Linear) => Self::Pieces(Pieces::Linear(table.clone())),
            Some(Interpolation::Monotone) => Self::Pieces(Pieces::monotone(table.clone())),
            Some(Interpolation::Cubic) | None => Self::Spline(Spline::new(table)),
        }
    }

    /// Value and first two derivatives. Where the velocity jumps, that before the jump, unless `t` is the time
    /// that was passed: a jump, or the start of the run.
    pub(crate) fn motion(&self, t: f64, step_context: StepContext) -> Result<Motion<N>, Interrupted> {
        let [value, rate, acceleration] = self.at(t, step_context.passed)?;
        if step_context.mean_over == 0.0 {
            return Ok([value, rate, acceleration]);
        }
        let [before, ..] = self.at(t - step_context.mean_over, step_context.passed)?;
        if before.iter().any(|x| x.is_nan()) {
            // It is not defined so early.
            return Ok([value, rate, [0.0; N]]);
        }
        let mean = std::array::from_fn(|i| (value[i] - before[i]) / step_context.mean_over);
        Ok([value, mean, [0.0; N]])
    }

    fn at(&self, t: f64, passed: f64) -> Result<Motion<N>, Interrupted> {
        match self {
            Self::Constant(value) => Ok([*value, [0.0; N], [0.0; N]]),
            Self::Harmonic(harmonic) => Ok(harmonic.motion(t)),
            Self::Spline(spline) => Ok(spline.motion(t)),
            Self::Pieces(pieces) => Ok(pieces.motion(t, passed)),
            Self::Function(function) => function.motion(t, t == passed),
        }
    }
}
