//! The state of an integration, and the interface of methods.

use super::FirstOrderSystem;
use super::options::Tolerances;
use super::status::Status;
use crate::description::signal::end_of_step;
use crate::integrators::{Reason, Retries};
use crate::numerics::tape::Tape;

/// The cost of an integration.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counters {
    /// Accepted steps.
    pub accepted: usize,
    /// Rejected steps, because of their error estimate or because they were not finite.
    pub rejected: usize,
    /// Evaluations of the right-hand side, without those for Jacobians by differences.
    pub nfev: usize,
    /// Evaluations of the right-hand side for Jacobians by differences.
    pub nfev_jacobian: usize,
    /// Jacobians, provided by the system or by differences.
    pub njev: usize,
    /// LU factorisations, real and complex.
    pub nlu: usize,
}

/// State of an integration, common to all methods.
#[derive(Clone, Debug)]
pub(super) struct State {
    pub(super) t: f64,
    pub(super) t_end: f64,
    /// Latest end of the next step: the end of the integration, or the system's horizon.
    pub(super) horizon: f64,
    /// 1 forward, -1 backward in time.
    pub(super) direction: f64,
    pub(super) y: Vec<f64>,
    /// f(t, y).
    pub(super) f: Vec<f64>,
    pub(super) t_old: f64,
    pub(super) y_old: Vec<f64>,
    /// Memory for the new state, which replaces y when the step is accepted.
    pub(super) y_new: Vec<f64>,
    /// Size of the next step.
    pub(super) h_abs: f64,
    pub(super) tolerances: Tolerances,
    pub(super) max_step: f64,
    pub(super) min_step: f64,
    pub(super) counters: Counters,
    pub(super) retries: Retries,
    /// Time at which the problem was found to be stiff.
    pub(super) stiff_at: Option<f64>,
}

/// Minimum step size in spacings of floating-point numbers (SciPy).
const SMALLEST_STEP_IN_SPACINGS: f64 = 10.0;

impl State {
    /// Smallest allowed step at the current time.
    pub(super) fn smallest_step(&self) -> f64 {
        let next = if self.direction > 0.0 { self.t.next_up() } else { self.t.next_down() };
        self.min_step.max(SMALLEST_STEP_IN_SPACINGS * (next - self.t).abs())
    }

    /// Serialises the state between steps.
    pub(super) fn serialise(&mut self, tape: &mut Tape<'_>) {
        for number in [&mut self.t, &mut self.t_end, &mut self.t_old, &mut self.h_abs] {
            tape.number(number);
        }
        for values in [&mut self.y, &mut self.f, &mut self.y_old] {
            tape.numbers(values);
        }
        let Counters { accepted, rejected, nfev, nfev_jacobian, njev, nlu } = &mut self.counters;
        for count in [accepted, rejected, nfev, nfev_jacobian, njev, nlu] {
            tape.count(count);
        }
        tape.optional(&mut self.stiff_at, 0.0, Tape::number);
    }

    /// Updates the horizon of the next step.
    pub(super) fn update_horizon<S: FirstOrderSystem + ?Sized>(&mut self, system: &S) {
        self.horizon = self.t_end;
        if self.direction > 0.0 {
            self.horizon = end_of_step(self.t, self.t_end, system.horizon(self.t));
        }
    }

    /// End and size of a step of the given size, limited by the horizon.
    pub(super) fn step_to(&self, h_abs: f64) -> (f64, f64) {
        let mut t_new = self.t + h_abs * self.direction;
        if self.direction * (t_new - self.horizon) > 0.0 {
            t_new = self.horizon;
        }
        (t_new, t_new - self.t)
    }

    /// Accepts `y_new` and `f_new` as the state at `t_new`.
    pub(super) fn accept(&mut self, t_new: f64, f_new: &[f64]) {
        self.t_old = self.t;
        self.t = t_new;
        std::mem::swap(&mut self.y_old, &mut self.y);
        std::mem::swap(&mut self.y, &mut self.y_new);
        self.f.copy_from_slice(f_new);
        self.counters.accepted += 1;
    }

    /// Restores the state before the last step, with the right-hand side there.
    pub(super) fn undo_step(&mut self, f_old: &[f64]) {
        self.t = self.t_old;
        self.y.copy_from_slice(&self.y_old);
        self.f.copy_from_slice(f_old);
        self.counters.accepted -= 1;
        self.counters.rejected += 1;
        self.retries.fail(Reason::Event);
    }
}

/// Result of a method's attempt to make a step.
pub(super) enum Advance {
    Accepted,
    Failed(Status),
}
