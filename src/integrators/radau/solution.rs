//! Integration over an interval, with states at requested times.

use super::{Options, Stepper};
use crate::error::{Interrupted, InvalidInput};
use crate::integrators::second_order::{
    SecondOrderSystem, Solution, check_points, check_times, collect, points_in_memory,
};
use crate::model::Dynamics;
use crate::numerics::memory;

/// Integrates the equations of motion over `t_span` from displacements `q0` and velocities `v0`. `t_eval` are
/// the increasing times of the result; `None` records all steps. `monitor` is called with the system and the
/// stepper after every accepted step. It may stop the integration, as may the system; the status is then
/// [`Status::Interrupted`](crate::integrators::second_order::Status::Interrupted).
///
/// Fails before any evaluation if an argument is invalid. Memory: `1 + 3 n` numbers for every point of the
/// output.
pub fn solve<S: SecondOrderSystem + ?Sized>(
    system: &mut S,
    t_span: (f64, f64),
    q0: &[f64],
    v0: &[f64],
    options: &Options,
    t_eval: Option<&[f64]>,
    monitor: &mut dyn FnMut(&mut S, &Stepper) -> Result<(), Interrupted>,
) -> Result<Solution, InvalidInput> {
    let n = system.facts().n;
    let mut options = options.clone();
    if t_eval.is_none() {
        options.max_steps = options.max_steps.min(points_in_memory(n));
    }
    check_memory(system)?;
    let mut stepper = Stepper::new(n, t_span, q0, v0, &options)?;
    if let Some(times) = t_eval {
        check_times(times, t_span)?;
    }
    let points = t_eval.map_or(1, <[f64]>::len);
    check_points(points, n)?;
    Ok(collect(system, &mut stepper, n, points, t_eval, monitor))
}

/// Rejects systems whose matrices do not fit in memory.
pub(crate) fn check_memory<S: SecondOrderSystem + ?Sized>(system: &mut S) -> Result<(), InvalidInput> {
    /// The derivatives of the residual, the shifted real and the complex matrix, and the factors of both.
    const SQUARE_MATRICES: usize = 8;
    if system.model().is_some_and(|model| model.tree().is_some()) {
        return Ok(());
    }
    let unknowns = system.facts().n + system.facts().constraints();
    memory::check_square(SQUARE_MATRICES, unknowns, "q0", "an explicit method needs no matrices")
}
