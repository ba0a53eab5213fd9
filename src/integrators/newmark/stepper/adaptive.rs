//! Steps whose size follows from an estimate of their errors.

use super::super::error_estimate::{Ends, LARGEST_FACTOR};
use super::super::options::StepSize;
use super::super::scheme::stretch;
use super::StepperOf;
use crate::description::signal::end_of_step;
use crate::error::Interrupted;
use crate::integrators::newmark::numbers::Numbers;
use crate::integrators::second_order::{ROUNDING_OF_STEPS, Status, System};
use crate::model::{Excitation, have_missed};

/// A step must be that many spacings of floating-point numbers long at least.
const SMALLEST_STEP_IN_SPACINGS: f64 = 10.0;

/// A step whose equations could not be solved is tried again with this fraction of its size (CVODE's choice).
const CUT: f64 = 0.25;

impl<V: Numbers> StepperOf<V> {
    pub(super) fn adaptive_step<S: System + ?Sized>(
        &mut self,
        system: &mut S,
    ) -> Result<Option<Status>, Interrupted> {
        let (StepSize::Adaptive { max_step, min_step }, Some(estimate)) =
            (self.options.step_size, self.error_estimate)
        else {
            unreachable!("only adaptive steps have an error estimate");
        };
        let smallest = min_step.max(SMALLEST_STEP_IN_SPACINGS * (self.t.next_up() - self.t));
        let mut h = self.h;
        let mut rejected = false;
        let horizon = system.model().map_or(f64::INFINITY, |model| model.horizon(self.t));
        let end = end_of_step(self.t, self.t_end, horizon);
        loop {
            if h < smallest {
                return Ok(Some(Status::StepTooSmall));
            }
            let is_last = self.t + h * (1.0 + ROUNDING_OF_STEPS) >= end;
            let t_new = if is_last { end } else { self.t + h };
            let step = t_new - self.t;
            self.rescale_memory(step);
            if self.attempt(system, t_new, step)?.is_err() {
                self.counters.unsolved += 1;
                h = CUT * step;
                rejected = true;
                continue;
            }
            let ends = Ends {
                q: [&self.q, &self.trial.q],
                v: [&self.v, &self.trial.v],
                a: [&self.a, &self.trial.a],
                s: if self.adapts_memory { &self.s_of_trial } else { &[] },
            };
            let error = estimate.error(step, &ends, &self.rtol, &self.atol);
            let factor = if error == 0.0 && !rejected {
                // That says nothing of what follows. Steps which something has shortened return to the first size.
                (self.options.dt / step).clamp(1.0, LARGEST_FACTOR)
            } else {
                estimate.factor(error, rejected)
            };
            let way = [(self.t, &self.q[..]), (t_new, &self.trial.q[..])];
            if error <= 1.0
                && let Some(model) = system.model()
                && have_missed(model, &way, ends.v, &mut self.straight_on)?
            {
                self.counters.rejected += 1;
                h = CUT * step;
                rejected = true;
                continue;
            }
            if error <= 1.0 {
                // The rest of the way says nothing about the size of the step after it.
                self.h = (if is_last { h.max(factor * step) } else { factor * h }).min(max_step);
                self.accept(t_new, step);
                return Ok(None);
            }
            self.counters.rejected += 1;
            h = factor * step;
            rejected = true;
        }
    }

    /// Algorithmic accelerations at the start of an adaptive step of size `h`. They are ahead of the true ones by a fraction of
    /// the step, which grows with it (Bruels and Arnold 2008). What else they differ by is left over from something that was not
    /// smooth, an impact: it is velocity still to come and alternates, so that it becomes smaller with a step of another
    /// size. Grown with the step it would be larger from step to step.
    fn rescale_memory(&mut self, h: f64) {
        if !self.adapts_memory {
            return;
        }
        let Some(stretch) = stretch(h, self.h_of_s) else {
            self.s_of_trial.iter_mut().zip(self.a.iter()).for_each(|(s, a)| *s = *a);
            return;
        };
        let Self { scheme, a, a_old, s, s_of_trial, .. } = self;
        for (i, start) in s_of_trial.iter_mut().enumerate() {
            let smooth = scheme.shift() * (a[i] - a_old[i]);
            let rest = s[i] - a[i] - smooth;
            *start = a[i] + stretch * smooth + stretch.min(stretch.recip()) * rest;
        }
    }
}
