//! Adaptive steps by the error estimate.

use super::super::error_estimate::{self, LARGEST_FACTOR};
use super::super::numbers::Numbers;
use super::super::options::StepSize;
use super::super::scheme::stretch;
use super::StepperOf;
use crate::error::Interrupted;
use crate::integrators::attempts::{Adaptive, Sizes, Tried, adaptive_step};
use crate::integrators::second_order::{Counters, SecondOrderSystem, Status};

impl<V: Numbers> Adaptive for StepperOf<V> {
    /// CVODE's choice.
    const FAILED_STEP_FACTOR: f64 = 0.25;
    const BENDS: bool = false;

    fn try_step<S: SecondOrderSystem + ?Sized>(
        &mut self,
        system: &mut S,
        t_new: f64,
        h: f64,
        again: bool,
    ) -> Result<Tried, Interrupted> {
        self.rescale_memory(h);
        if let Err(failure) = self.attempt(system, t_new, h)? {
            return Ok(Tried::Unsolved(failure));
        }
        let Some(estimate) = self.error_estimate else {
            unreachable!("adaptive steps have an error estimate")
        };
        let ends = error_estimate::Ends {
            q: [&self.q, &self.trial.q],
            v: [&self.v, &self.trial.v],
            a: [&self.a, &self.trial.a],
            s: if self.adapts_memory { &self.s_of_trial } else { &[] },
        };
        let error = estimate.error(h, &ends, &self.rtol, self.atol.as_deref());
        let factor = if error == 0.0 && !again {
            // No estimate: steps that were shortened return to the initial size.
            (self.options.dt / h).clamp(1.0, LARGEST_FACTOR)
        } else {
            estimate.factor(error, again)
        };
        Ok(if error <= 1.0 { Tried::Good(factor) } else { Tried::Inaccurate(factor) })
    }

    fn next_size(&mut self, _: f64, wanted: f64, factor: f64) -> f64 {
        factor * wanted
    }

    fn counters(&mut self) -> &mut Counters {
        &mut self.counters
    }
}

impl<V: Numbers> StepperOf<V> {
    pub(super) fn adaptive_step<S: SecondOrderSystem + ?Sized>(
        &mut self,
        system: &mut S,
    ) -> Result<Option<Status>, Interrupted> {
        let StepSize::Adaptive { max_step: largest, min_step: smallest } = self.options.step_size else {
            unreachable!("only adaptive steps have an error estimate");
        };
        let sizes = Sizes { t_end: self.t_end, wanted: self.h, smallest, largest };
        let Ok(next) = adaptive_step(self, system, sizes)? else { return Ok(Some(Status::StepTooSmall)) };
        self.h = next;
        Ok(None)
    }

    /// Computes the algorithmic accelerations at the start of an adaptive step of size `h`. Their lead over the true ones is a fraction of
    /// the step and is scaled with it (Bruels and Arnold 2008). The rest of the difference stems from events that are not smooth, such as
    /// impacts; it alternates in sign and must not be enlarged with the step, or it would grow from step to step.
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
