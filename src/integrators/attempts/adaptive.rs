//! Steps whose size follows from an estimate of their errors.

use super::diagnosis::Kind;
use super::{Diagnosis, Stepper};
use crate::description::signal::end_of_step;
use crate::error::Interrupted;
use crate::integrators::Reason;
use crate::integrators::second_order::{Counters, Failure, ROUNDING_OF_STEPS, SecondOrderSystem};
use crate::model::Excitation;

/// Number of times that a step is shortened because its end is invalid, such as a rotation too large for one step. Steps can grow
/// tenfold at once, so that several attempts may be needed.
pub(crate) const MAX_INVALID_ATTEMPTS: usize = 5;

/// Largest growth after a step whose equations could first not be solved, with dry friction but no contact: the convergence of the
/// iterations limits steps, not errors, so that a step grown tenfold would fail again three times. Of factors from 1 to 10 the cheapest for
/// chains with dry friction (`benches/python/accuracy/cost.py`); landing balls take as long with all of them.
const LARGEST_GROWTH_AFTER_FAILURE: f64 = 3.0;

/// Smallest step, in spacings of floating-point numbers (as in SciPy).
const SMALLEST_STEP_IN_SPACINGS: f64 = 10.0;

/// Result of an attempted step. The factors give the size of the next step, or of the next attempt.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Tried {
    /// Its error is within the tolerance.
    Good(f64),
    /// Its error is too large.
    Inaccurate(f64),
    /// Its equations could not be solved.
    Unsolved(Failure),
}

/// End of the integration, and limits of the step size.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sizes {
    pub(crate) t_end: f64,
    pub(crate) wanted: f64,
    pub(crate) smallest: f64,
    pub(crate) largest: f64,
}

/// A stepper that estimates the errors of its steps.
pub(crate) trait Adaptive: Stepper {
    /// Factor by which a step is shortened that failed without an error estimate.
    const FAILED_STEP_FACTOR: f64;
    /// Whether the motion within a step is curved (its middle is examined too), and its end is checked.
    const BENDS: bool;

    /// Attempts a step of size `h` to `t_new`; `again` after a failed attempt.
    fn try_step<S: SecondOrderSystem + ?Sized>(
        &mut self,
        system: &mut S,
        t_new: f64,
        h: f64,
        again: bool,
    ) -> Result<Tried, Interrupted>;

    /// The size of the step after an accepted one of size `h`, which equals `wanted` but for rounding of times.
    fn next_size(&mut self, h: f64, wanted: f64, factor: f64) -> f64;

    fn counters(&mut self) -> &mut Counters;
}

/// Makes a step of the wanted size, or a shorter one if its equations cannot be solved, its error is too large, or its diagnosis is
/// not [`Diagnosis::Valid`]. Returns the size of the next step; if steps became too small, the reason of the last failure.
pub(crate) fn adaptive_step<A: Adaptive, S: SecondOrderSystem + ?Sized>(
    stepper: &mut A,
    system: &mut S,
    Sizes { t_end, wanted, smallest, largest }: Sizes,
) -> Result<Result<f64, Failure>, Interrupted> {
    let [t, _] = stepper.tried().0.t;
    let smallest = smallest.max(SMALLEST_STEP_IN_SPACINGS * (t.next_up() - t));
    let horizon = system.model().map_or(f64::INFINITY, |model| model.horizon(t));
    let end = end_of_step(t, t_end, horizon);
    let mut wanted = wanted.clamp(smallest.min(largest), largest);
    let (mut again, mut invalid, mut failure) = (false, 0, Failure::NotConverged);
    let mut largest_growth = f64::INFINITY;
    loop {
        let is_last = t + wanted * (1.0 + ROUNDING_OF_STEPS) >= end;
        if wanted.is_nan() || wanted < smallest && (again || !is_last) {
            return Ok(Err(failure));
        }
        let t_new = if is_last { end } else { t + wanted };
        let h = t_new - t;
        stepper.retries().attempt();
        let tried = stepper.try_step(system, t_new, h, again)?;
        (failure, again) = (Failure::NotConverged, true);
        wanted = match tried {
            Tried::Good(factor) => {
                let factor = factor.min(largest_growth);
                let (ends, unilateral) = stepper.tried();
                let kind =
                    Kind::Adaptive { bends: A::BENDS, is_judged: A::BENDS && invalid < MAX_INVALID_ATTEMPTS };
                let found = match system.model() {
                    Some(model) => unilateral.diagnose(model, &ends, kind)?,
                    None => Diagnosis::Valid,
                };
                if found == Diagnosis::Valid {
                    // The last step is short because the interval ends, so that it must not shorten the next one.
                    let next = if is_last {
                        wanted.max(stepper.next_size(h, h, factor))
                    } else {
                        stepper.next_size(h, wanted, factor)
                    };
                    stepper.accept(system)?;
                    return Ok(Ok(next));
                }
                invalid += 1;
                found.reason().into_iter().for_each(|reason| stepper.retries().fail(reason));
                stepper.counters().rejected += 1;
                A::FAILED_STEP_FACTOR * h
            }
            Tried::Inaccurate(factor) => {
                stepper.retries().fail(Reason::Error);
                stepper.counters().rejected += 1;
                factor * h
            }
            Tried::Unsolved(found) => {
                stepper.retries().fail(found);
                stepper.counters().unsolved += 1;
                if system.facts().has_dry_friction && !system.facts().has_contact {
                    largest_growth = LARGEST_GROWTH_AFTER_FAILURE;
                }
                failure = found;
                A::FAILED_STEP_FACTOR * h
            }
        };
    }
}
