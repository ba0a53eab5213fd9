//! Steps whose size follows from an estimate of their errors.

use super::diagnosis::Kind;
use super::{Diagnosis, Stepper};
use crate::description::signal::end_of_step;
use crate::error::Interrupted;
use crate::integrators::second_order::{Counters, Failure, ROUNDING_OF_STEPS, System};
use crate::model::Excitation;

/// Steps that end where no motion can be are tried again as often; longer ones may turn what turns too far at once,
/// and steps can grow tenfold.
pub(crate) const MOST_UNSOUND: usize = 5;

/// A step must be that many spacings of floating-point numbers long at least (SciPy).
const SMALLEST_STEP_IN_SPACINGS: f64 = 10.0;

/// What came of a step that was tried. Factors are those of the size of the next one, or of the same.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Tried {
    /// Its error is as small as was asked for.
    Good(f64),
    /// Its error is too large.
    Inaccurate(f64),
    /// Its equations could not be solved.
    Unsolved(Failure),
}

/// Where the way ends, and which sizes steps may have.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sizes {
    pub(crate) t_end: f64,
    pub(crate) wanted: f64,
    pub(crate) smallest: f64,
    pub(crate) largest: f64,
}

/// A stepper that estimates the errors of its steps.
pub(crate) trait Adaptive: Stepper {
    /// Steps of which nothing else is known are shortened to that part.
    const CUT: f64;
    /// Whether its motion bends within a step, and is judged at the end.
    const BENDS: bool;

    /// Tries a step to a time, of a size, after another one or not.
    fn try_step<S: System + ?Sized>(
        &mut self,
        system: &mut S,
        t_new: f64,
        h: f64,
        again: bool,
    ) -> Result<Tried, Interrupted>;

    /// The size of the step after one that is made, of the size `h` and `wanted` but for rounding of times.
    fn next_size(&mut self, h: f64, wanted: f64, factor: f64) -> f64;

    fn counters(&mut self) -> &mut Counters;
}

/// Makes a step of the size that is wanted, or a shorter one where its equations cannot be solved, its error is too large, or something
/// is wrong with it. Returns the size of the next one, or why the last one failed that was not too small.
pub(crate) fn adaptive_step<A: Adaptive, S: System + ?Sized>(
    stepper: &mut A,
    system: &mut S,
    Sizes { t_end, wanted, smallest, largest }: Sizes,
) -> Result<Result<f64, Failure>, Interrupted> {
    let [t, _] = stepper.tried().0.t;
    let smallest = smallest.max(SMALLEST_STEP_IN_SPACINGS * (t.next_up() - t));
    let horizon = system.model().map_or(f64::INFINITY, |model| model.horizon(t));
    let end = end_of_step(t, t_end, horizon);
    let mut wanted = wanted.clamp(smallest.min(largest), largest);
    let (mut again, mut unsound, mut failure) = (false, 0, Failure::NotConverged);
    loop {
        let is_last = t + wanted * (1.0 + ROUNDING_OF_STEPS) >= end;
        if wanted.is_nan() || wanted < smallest && (again || !is_last) {
            return Ok(Err(failure));
        }
        let t_new = if is_last { end } else { t + wanted };
        let h = t_new - t;
        let tried = stepper.try_step(system, t_new, h, again)?;
        (failure, again) = (Failure::NotConverged, true);
        wanted = match tried {
            Tried::Good(factor) => {
                let (ends, unilateral) = stepper.tried();
                let kind = Kind::Adaptive { bends: A::BENDS, is_judged: A::BENDS && unsound < MOST_UNSOUND };
                let found = match system.model() {
                    Some(model) => unilateral.diagnose(model, &ends, kind)?,
                    None => Diagnosis::Sound,
                };
                if found == Diagnosis::Sound {
                    // The rest of the way says nothing about the size of the step after it.
                    let next = if is_last {
                        wanted.max(stepper.next_size(h, h, factor))
                    } else {
                        stepper.next_size(h, wanted, factor)
                    };
                    stepper.accept(system)?;
                    return Ok(Ok(next));
                }
                unsound += 1;
                stepper.counters().rejected += 1;
                A::CUT * h
            }
            Tried::Inaccurate(factor) => {
                stepper.counters().rejected += 1;
                factor * h
            }
            Tried::Unsolved(found) => {
                stepper.counters().unsolved += 1;
                failure = found;
                A::CUT * h
            }
        };
    }
}
