//! One step of an explicit embedded Runge-Kutta pair.

use super::FirstOrderSystem;
use super::controller::StepControl;
use super::dense::Form;
use super::dormand_prince_5::DORMAND_PRINCE_5;
use super::dormand_prince_8::DORMAND_PRINCE_8;
use super::norm::{all_finite, scaled};
use super::options::{Controller, Method};
use super::pair::{ErrorEstimate, Extension, Pair, combine};
use super::pairs::pair;
use super::state::{Advance, State};
use super::status::Status;
use super::stiffness::StiffnessTest;
use crate::error::Interrupted;
use crate::integrators::Reason;
use crate::integrators::attempts::MAX_INVALID_ATTEMPTS;
use crate::numerics::tape::Tape;

/// Weight of the squared third-order difference in the error estimate of DOP853 (Hairer, Norsett and Wanner 1993,
/// eq. II.10.17).
const THIRD_ORDER_WEIGHT: f64 = 0.01;

/// Step-size factor after an invalid step.
const INVALID_STEP_FACTOR: f64 = 0.5;

/// An explicit pair with its working memory.
#[derive(Clone, Debug)]
pub(super) struct Explicit {
    pair: &'static Pair,
    // Stages of the current step, n numbers each.
    stages: Vec<f64>,
    // Stages of the last accepted step.
    accepted_stages: Vec<f64>,
    // Argument of the stage evaluated last.
    argument: Vec<f64>,
    // Error estimate relative to the tolerances.
    relative_error: Vec<f64>,
    control: StepControl,
    stiffness: StiffnessTest,
}

impl Explicit {
    pub(super) fn dormand_prince_5(n: usize, controller: Controller) -> Self {
        Self::new(&DORMAND_PRINCE_5, n, controller)
    }

    pub(super) fn dormand_prince_8(n: usize, controller: Controller) -> Self {
        Self::new(&DORMAND_PRINCE_8, n, controller)
    }

    /// Number of vectors that a method needs; zero for an implicit one.
    pub(super) fn vectors(method: Method) -> usize {
        pair(method).map_or(0, |pair| 2 * pair.kept_stages() + 2)
    }

    fn new(pair: &'static Pair, n: usize, controller: Controller) -> Self {
        Self {
            pair,
            stages: vec![0.0; pair.kept_stages() * n],
            accepted_stages: vec![0.0; pair.kept_stages() * n],
            argument: vec![0.0; n],
            relative_error: vec![0.0; n],
            control: StepControl::new(controller, pair.error_order),
            stiffness: StiffnessTest::default(),
        }
    }

    pub(super) fn error_order(&self) -> f64 {
        self.pair.error_order
    }

    pub(super) fn form(&self) -> Form {
        self.pair.extension.form()
    }

    /// Makes one accepted step, not longer than `state` proposes.
    pub(super) fn advance<S: FirstOrderSystem + ?Sized>(
        &mut self,
        state: &mut State,
        system: &mut S,
    ) -> Result<Advance, Interrupted> {
        let n = state.y.len();
        let smallest = state.smallest_step();
        let mut h_abs = if state.h_abs > state.max_step { state.max_step } else { state.h_abs.max(smallest) };
        let mut was_rejected = false;
        let mut invalid = 0;
        let mut finite = true;
        loop {
            if h_abs < smallest {
                return Ok(Advance::Failed(if finite { Status::StepTooSmall } else { Status::NonFinite }));
            }
            let wanted = h_abs;
            let (t_new, h) = state.step_to(h_abs);
            h_abs = h.abs();
            state.retries.attempt();
            self.attempt(state, system, t_new, h)?;
            let error = self.error_norm(state, h_abs);
            let f_new = self.pair.stages() * n..(self.pair.stages() + 1) * n;
            if error < 1.0 && all_finite(&state.y_new) && all_finite(&self.stages[f_new.clone()]) {
                let rates = [&state.f[..], &self.stages[f_new.clone()]];
                let states = [&state.y[..], &state.y_new];
                let is_judged = invalid < MAX_INVALID_ATTEMPTS;
                if let Some(reason) = system.refusal([state.t, t_new], states, rates, is_judged)? {
                    invalid += 1;
                    state.counters.rejected += 1;
                    state.retries.fail(reason);
                    was_rejected = true;
                    h_abs *= INVALID_STEP_FACTOR;
                    continue;
                }
                self.detect_stiffness(state, h_abs);
                state.accept(t_new, &self.stages[f_new]);
                std::mem::swap(&mut self.stages, &mut self.accepted_stages);
                // A step shortened by the horizon must not determine the size of the next step.
                let least = if t_new == state.horizon { wanted } else { 0.0 };
                state.h_abs = least.max(h_abs * self.control.after_acceptance(error, was_rejected));
                return Ok(Advance::Accepted);
            }
            state.counters.rejected += 1;
            was_rejected = true;
            // The state may overflow with a zero error although the right-hand side is finite.
            finite = all_finite(&self.stages[..(self.pair.stages() + 1) * n]) && all_finite(&state.y_new);
            state.retries.fail(if finite { Reason::Error } else { Reason::NonFinite });
            h_abs *= self.control.after_rejection(if finite { error } else { f64::NAN });
        }
    }

    /// The right-hand side at the start of the last accepted step.
    pub(super) fn rate_before(&self) -> &[f64] {
        &self.accepted_stages[..self.argument.len()]
    }

    /// The state between steps.
    pub(super) fn serialise(&mut self, tape: &mut Tape<'_>) {
        tape.numbers(&mut self.accepted_stages);
        self.control.serialise(tape);
        self.stiffness.serialise(tape);
    }

    /// Evaluates all stages of a step: `y_new` and, as the last stage, `f(t_new, y_new)`.
    fn attempt<S: FirstOrderSystem + ?Sized>(
        &mut self,
        state: &mut State,
        system: &mut S,
        t_new: f64,
        h: f64,
    ) -> Result<(), Interrupted> {
        let n = state.y.len();
        self.stages[..n].copy_from_slice(&state.f);
        for (stage, (row, &c)) in self.pair.a.iter().zip(self.pair.c).enumerate().skip(1) {
            let (known, rest) = self.stages.split_at_mut(stage * n);
            shift(&state.y, h, known, row, &mut self.argument);
            // Rounding must not carry the end of the step beyond the end of the interval.
            let t = if c == 1.0 { t_new } else { state.t + c * h };
            state.counters.nfev += 1;
            system.rhs(t, &self.argument, &mut rest[..n])?;
        }
        let (known, rest) = self.stages.split_at_mut(self.pair.stages() * n);
        shift(&state.y, h, known, self.pair.b, &mut state.y_new);
        state.counters.nfev += 1;
        system.rhs(t_new, &state.y_new, &mut rest[..n])
    }

    /// Root mean square of the error estimate relative to the tolerances.
    fn error_norm(&mut self, state: &State, h_abs: f64) -> f64 {
        let n = state.y.len();
        let (y, y_new) = (&state.y[..n], &state.y_new[..n]);
        let (atol, rtol) = (&state.tolerances.atol[..n], &state.tolerances.rtol[..n]);
        let stages = &self.stages;
        let relative = &mut self.relative_error;
        let mut squared = |row: &[(usize, f64)]| {
            combine(stages, row, relative, |i, sum| {
                scaled(sum * h_abs, atol[i] + y[i].abs().max(y_new[i].abs()) * rtol[i])
            });
            relative.iter().map(|error| error * error).sum::<f64>()
        };
        match self.pair.error {
            ErrorEstimate::Difference(row) => (squared(row) / n as f64).sqrt(),
            ErrorEstimate::Combined { fifth, third } => {
                let (fifth, third) = (squared(fifth), squared(third));
                if fifth == 0.0 && third == 0.0 {
                    0.0
                } else {
                    fifth / ((fifth + THIRD_ORDER_WEIGHT * third) * n as f64).sqrt()
                }
            }
        }
    }

    /// Error estimate of the last accepted step of size `h`, for each component.
    pub(super) fn error_estimate(&self, h: f64) -> Vec<f64> {
        let mut estimate = vec![0.0; self.argument.len()];
        match self.pair.error {
            ErrorEstimate::Difference(row) => {
                combine(&self.accepted_stages, row, &mut estimate, |_, sum| sum * h);
            }
            ErrorEstimate::Combined { fifth, third } => {
                let mut rough = estimate.clone();
                combine(&self.accepted_stages, fifth, &mut estimate, |_, sum| sum * h);
                combine(&self.accepted_stages, third, &mut rough, |_, sum| sum * h);
                for (value, rough) in estimate.iter_mut().zip(rough) {
                    let size = value.hypot(THIRD_ORDER_WEIGHT.sqrt() * rough);
                    *value *= if size > 0.0 { value.abs() / size } else { 1.0 };
                }
            }
        }
        estimate
    }

    /// The last row of `a` and the solution belong to the same time, as the stiffness test requires.
    fn detect_stiffness(&mut self, state: &mut State, h_abs: f64) {
        let n = state.y.len();
        if state.stiff_at.is_some() || !self.stiffness.is_due(state.counters.accepted + 1) {
            return;
        }
        let last = self.pair.stages();
        let values = (&self.stages[(last - 1) * n..last * n], &self.stages[last * n..(last + 1) * n]);
        let arguments = (&self.argument[..], &state.y_new[..]);
        if self.stiffness.observe(h_abs, arguments, values, self.pair.stability_limit) {
            state.stiff_at = Some(state.t);
        }
    }

    /// Polynomial of the last accepted step.
    pub(super) fn interpolate<S: FirstOrderSystem + ?Sized>(
        &mut self,
        state: &mut State,
        system: &mut S,
        coefficients: &mut [f64],
    ) -> Result<(), Interrupted> {
        let n = state.y.len();
        let h = state.t - state.t_old;
        coefficients[..n].copy_from_slice(&state.y_old);
        match self.pair.extension {
            Extension::Monomial(rows) => {
                for (row, out) in rows.iter().zip(coefficients[n..].chunks_exact_mut(n)) {
                    combine(&self.accepted_stages, row, out, |_, sum| sum * h);
                }
            }
            Extension::Nested { c, a, d } => {
                for (extra, (row, c)) in a.iter().zip(c).enumerate() {
                    let stage = self.pair.stages() + 1 + extra;
                    let (known, rest) = self.accepted_stages.split_at_mut(stage * n);
                    shift(&state.y_old, h, known, row, &mut self.argument);
                    state.counters.nfev += 1;
                    system.rhs(state.t_old + c * h, &self.argument, &mut rest[..n])?;
                }
                for i in 0..n {
                    let difference = state.y[i] - state.y_old[i];
                    let (f_old, f) = (self.accepted_stages[i], state.f[i]);
                    coefficients[n + i] = difference;
                    coefficients[2 * n + i] = h * f_old - difference;
                    coefficients[3 * n + i] = 2.0 * difference - h * (f + f_old);
                }
                for (row, out) in d.iter().zip(coefficients[4 * n..].chunks_exact_mut(n)) {
                    combine(&self.accepted_stages, row, out, |_, sum| sum * h);
                }
            }
        }
        Ok(())
    }
}

/// `out <- y + h sum_j weight_j stages[j]`.
fn shift(y: &[f64], h: f64, stages: &[f64], row: &[(usize, f64)], out: &mut [f64]) {
    let y = &y[..out.len()];
    combine(stages, row, out, |i, sum| y[i] + sum * h);
}
