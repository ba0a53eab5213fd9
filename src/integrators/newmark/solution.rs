//! Integration over an interval, with states at requested times.

use super::alternation::Alternation;
use super::linear_system::LinearSystem;
use super::options::{Options, StepSize};
use super::stepper::Stepper;
use crate::error::{Interrupted, InvalidInput};
use crate::integrators::second_order::runaway;
use crate::integrators::second_order::{
    Failure, SecondOrderSystem, Solution, Status, check_points, check_times, collect, points_in_memory, steps,
};

/// Integrates the equations of motion over `t_span` from displacements `q0` and velocities `v0`. `t_eval` are
/// the increasing times of the result; `None` records all steps. `monitor` is called with the system and the
/// stepper after every accepted step. It may stop the integration, as may the system; the status is then
/// [`Status::Interrupted`](crate::integrators::second_order::Status::Interrupted).
///
/// Fails before any evaluation if an argument is invalid. Cost: see [`crate::integrators::second_order::Counters`]. Memory:
/// `1 + 3 n` numbers for every point of the output.
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
    if t_eval.is_none() && options.step_size != StepSize::Fixed {
        options.max_steps = options.max_steps.min(points_in_memory(n));
    }
    let mut stepper = Stepper::new(n, t_span, q0, v0, &options)?;
    LinearSystem::check_memory(system, options.derivative)?;
    let points = match t_eval {
        Some(times) => {
            check_times(times, t_span)?;
            times.len()
        }
        None if options.step_size == StepSize::Fixed => stepper.fixed_steps().saturating_add(1),
        None => 1,
    };
    check_points(points, n)?;
    let has_limit = options.step_size == StepSize::Fixed && options.scheme.stability_limit().is_finite();
    let mut alternation = has_limit.then(|| Alternation::new(n));
    let mut watching = |system: &mut S, stepper: &Stepper| {
        if let Some(alternation) = &mut alternation {
            alternation.step(stepper.t(), stepper.a());
        }
        monitor(system, stepper)
    };
    let mut solution = collect(system, &mut stepper, n, points, t_eval, &mut watching);
    let is_over = matches!(
        solution.status,
        Status::Finished | Status::StepFailed(Failure::NotConverged | Failure::NonFinite)
    );
    if is_over && let Some(sentence) = alternation.and_then(|alternation| alternation.sentence()) {
        solution.status = Status::Unstable;
        solution.message = format!("{sentence} {}", stepper.explain(Status::Unstable));
    } else if let Some(sentence) = runaway::sentence(&solution) {
        solution.message = format!("{sentence} {}", solution.message);
    }
    Ok(solution)
}

steps!(Stepper);
