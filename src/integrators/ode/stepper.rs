//! Integration step by step.

use super::dense::{DenseOutput, Form, StepPolynomial};
use super::explicit::Explicit;
use super::norm::all_finite;
use super::options::{Method, Options};
use super::radau::Radau;
use super::state::{Advance, Counters, State};
use super::status::Status;
use super::{FirstOrderSystem, initial_step};
use crate::error::{Interrupted, InvalidInput, Time};
use crate::integrators::Retries;
use crate::numerics::memory;
use crate::numerics::tape::Tape;

/// A method with its working memory.
#[derive(Clone, Debug)]
enum Scheme {
    Explicit(Explicit),
    Radau(Box<Radau>),
}

impl Scheme {
    fn form(&self) -> Form {
        match self {
            Self::Explicit(explicit) => explicit.form(),
            Self::Radau(_) => Radau::FORM,
        }
    }

    fn error_order(&self) -> f64 {
        match self {
            Self::Explicit(explicit) => explicit.error_order(),
            Self::Radau(_) => Radau::ERROR_ORDER,
        }
    }
}

/// An integration performed step by step. All memory is allocated at the start.
///
/// The stepper does not own the system; pass the same system to every call.
#[derive(Clone, Debug)]
pub struct Stepper {
    state: State,
    scheme: Scheme,
    max_steps: usize,
    // Number of steps whose results fit in memory.
    steps_in_memory: usize,
    first_step: Option<f64>,
    started: bool,
    // Whether the right-hand side at the start is finite.
    is_defined: bool,
    status: Option<Status>,
    // Polynomial of the last step, once computed.
    interpolant: Vec<f64>,
    has_interpolant: bool,
}

impl Stepper {
    /// Prepares the integration of `n` equations from `t_span.0` to `t_span.1`, which may be infinite or the
    /// earlier of the two. Evaluates nothing.
    pub fn new(n: usize, t_span: (f64, f64), y0: &[f64], options: &Options) -> Result<Self, InvalidInput> {
        let tolerances = options.check(n, t_span, y0)?;
        /// Number of vectors of the state, without those of the method.
        const VECTORS: usize = 12;
        let (t0, t_end) = t_span;
        let vectors = VECTORS + Explicit::vectors(options.method);
        memory::check(vectors.saturating_mul(n), "y0", format_args!("{n} values"), "fewer equations")?;
        let scheme = match options.method {
            Method::Rk45 => Scheme::Explicit(Explicit::dormand_prince_5(n, options.controller)),
            Method::Dop853 => Scheme::Explicit(Explicit::dormand_prince_8(n, options.controller)),
            Method::Radau => {
                Scheme::Radau(Box::new(Radau::new(n, &tolerances.rtol, options.sparsity.clone())?))
            }
        };
        let interpolant = vec![0.0; scheme.form().vectors() * n];
        Ok(Self {
            state: State {
                t: t0,
                t_end,
                horizon: t_end,
                direction: if t_end < t0 { -1.0 } else { 1.0 },
                y: y0.to_vec(),
                f: vec![0.0; n],
                t_old: t0,
                y_old: y0.to_vec(),
                y_new: vec![0.0; n],
                h_abs: 0.0,
                tolerances,
                max_step: options.max_step,
                min_step: options.min_step,
                counters: Counters::default(),
                retries: Retries::default(),
                stiff_at: None,
            },
            scheme,
            max_steps: options.max_steps,
            steps_in_memory: usize::MAX,
            first_step: options.first_step,
            started: false,
            is_defined: true,
            status: None,
            interpolant,
            has_interpolant: false,
        })
    }

    /// Limits the number of steps to what fits in memory.
    pub(super) fn limit_steps(&mut self, steps_in_memory: usize) {
        self.steps_in_memory = steps_in_memory;
    }

    /// Evaluates the right-hand side at the start and chooses the first step. [`Self::step`] calls this if
    /// necessary.
    pub fn start<S: FirstOrderSystem + ?Sized>(&mut self, system: &mut S) -> Result<(), Interrupted> {
        if self.started {
            return Ok(());
        }
        let state = &mut self.state;
        system.wrap(&mut state.y, &mut state.f);
        system.rhs(state.t, &state.y, &mut state.f)?;
        state.counters.nfev += 1;
        self.is_defined = all_finite(&state.f);
        state.h_abs = match self.first_step {
            Some(first_step) => first_step,
            None if state.y.is_empty() || state.t == state.t_end => 0.0,
            None => {
                let start = initial_step::Start {
                    t0: state.t,
                    t_end: state.t_end,
                    direction: state.direction,
                    y0: &state.y,
                    f0: &state.f,
                    max_step: state.max_step,
                };
                let h_abs =
                    initial_step::select(system, &start, &state.tolerances, self.scheme.error_order())?;
                state.counters.nfev += 1;
                h_abs
            }
        };
        if let Scheme::Radau(radau) = &mut self.scheme {
            radau.start(state, system)?;
        }
        self.started = true;
        Ok(())
    }

    /// Makes one accepted step. Returns `Some(status)` if the integration has ended: the end was reached, or
    /// no step could be made, which leaves the state unchanged. After an interruption the state is that of
    /// the last accepted step, and the step can be repeated.
    ///
    /// # Panics
    /// If the integration had already ended.
    pub fn step<S: FirstOrderSystem + ?Sized>(
        &mut self,
        system: &mut S,
    ) -> Result<Option<Status>, Interrupted> {
        assert!(self.status.is_none(), "the integration is over");
        self.start(system)?;
        let state = &mut self.state;
        self.status = if state.y.is_empty() || state.t == state.t_end {
            state.t_old = state.t;
            state.t = state.t_end;
            self.has_interpolant = false;
            Some(Status::Finished)
        } else if !self.is_defined {
            Some(Status::NonFinite)
        } else if state.counters.accepted >= self.max_steps.min(self.steps_in_memory) {
            Some(Status::TooManySteps)
        } else {
            if system.wrap(&mut state.y, &mut state.f)
                && let Scheme::Radau(radau) = &mut self.scheme
            {
                radau.restart(state, system)?;
            }
            state.update_horizon(system);
            let advance = match &mut self.scheme {
                Scheme::Explicit(explicit) => explicit.advance(state, system)?,
                Scheme::Radau(radau) => radau.advance(state, system)?,
            };
            match advance {
                Advance::Accepted => {
                    self.has_interpolant = false;
                    (state.direction * (state.t - state.t_end) >= 0.0).then_some(Status::Finished)
                }
                Advance::Failed(status) => Some(status),
            }
        };
        Ok(self.status)
    }

    /// Continues to a later end, whatever the status was.
    pub(crate) fn extend_to(&mut self, t_end: f64) {
        (self.status, self.state.t_end) = (None, t_end);
    }

    /// Switches to other coordinates if the current ones are close to a singularity.
    pub(crate) fn shorten_rotation_vectors<S: FirstOrderSystem + ?Sized>(&mut self, system: &mut S) {
        system.wrap(&mut self.state.y, &mut self.state.f);
    }

    /// Current state and right-hand side.
    pub(crate) fn state_mut(&mut self) -> [&mut [f64]; 2] {
        [&mut self.state.y, &mut self.state.f]
    }

    /// Right-hand side at the current state, to be overwritten after a jump.
    pub(crate) fn rate_mut(&mut self) -> &mut [f64] {
        &mut self.state.f
    }

    /// Undoes the last step of an explicit method.
    pub(crate) fn undo_step(&mut self) {
        let Scheme::Explicit(explicit) = &self.scheme else {
            unreachable!("implicit motions have a method of second order")
        };
        self.state.undo_step(explicit.rate_before());
        self.status = None;
        self.has_interpolant = false;
    }

    /// Continues from this state, at which the right-hand side jumps.
    pub(crate) fn restart(&mut self, parts: [&[f64]; 2]) {
        let (head, tail) = self.state.y.split_at_mut(parts[0].len());
        head.copy_from_slice(parts[0]);
        tail.copy_from_slice(parts[1]);
        self.started = false;
        self.has_interpolant = false;
    }

    /// Serialises the state between steps of an explicit method.
    pub(crate) fn serialise(&mut self, tape: &mut Tape<'_>) {
        self.state.serialise(tape);
        tape.flag(&mut self.started);
        tape.flag(&mut self.is_defined);
        match &mut self.scheme {
            Scheme::Explicit(explicit) => explicit.serialise(tape),
            Scheme::Radau(_) => unreachable!("implicit motions have a method of second order"),
        }
        self.has_interpolant = false;
    }

    /// The polynomial of the last step; `None` if it is not finite.
    pub(crate) fn last_step<S: FirstOrderSystem + ?Sized>(
        &mut self,
        system: &mut S,
    ) -> Result<Option<StepPolynomial<'_>>, Interrupted> {
        Ok(self.prepare_polynomial(system)?.then(|| self.polynomial()))
    }

    /// Computes the polynomial of the last step, if necessary. Returns whether its values are finite: they
    /// may overflow although the state does not.
    pub(super) fn prepare_polynomial<S: FirstOrderSystem + ?Sized>(
        &mut self,
        system: &mut S,
    ) -> Result<bool, Interrupted> {
        if !self.has_interpolant {
            if self.state.t == self.state.t_old || self.state.y.is_empty() {
                self.interpolant.fill(0.0);
                self.interpolant[..self.state.y.len()].copy_from_slice(&self.state.y);
            } else {
                match &mut self.scheme {
                    Scheme::Explicit(explicit) => {
                        explicit.interpolate(&mut self.state, system, &mut self.interpolant)?;
                    }
                    Scheme::Radau(radau) => self.interpolant.copy_from_slice(radau.polynomial()),
                }
            }
            self.has_interpolant = true;
        }
        // Values are bounded by the largest coefficient times the number of coefficients.
        let largest =
            self.interpolant.iter().fold(0.0_f64, |largest, coefficient| largest.max(coefficient.abs()));
        Ok(all_finite(&self.interpolant) && (self.form().vectors() as f64 * largest).is_finite())
    }

    /// Polynomial of the last step; must have been prepared.
    pub(super) fn polynomial(&self) -> StepPolynomial<'_> {
        debug_assert!(self.has_interpolant);
        StepPolynomial {
            form: self.form(),
            coefficients: &self.interpolant,
            t_old: self.state.t_old,
            t: self.state.t,
        }
    }

    /// Solution over the last step. DOP853 needs three additional evaluations of the right-hand side, once
    /// per step.
    pub fn dense_output<S: FirstOrderSystem + ?Sized>(
        &mut self,
        system: &mut S,
    ) -> Result<DenseOutput, Interrupted> {
        self.prepare_polynomial(system)?;
        let mut dense = DenseOutput::new(self.form(), self.state.y.len(), self.state.t_old);
        dense.push(self.state.t, self.polynomial());
        Ok(dense)
    }

    pub(super) fn form(&self) -> Form {
        self.scheme.form()
    }

    /// Estimated error of the last step for each component; zeros before the first step. For RK45, the
    /// embedded solution of order 4 minus the solution.
    pub fn error_estimate(&self) -> Vec<f64> {
        if self.state.t == self.state.t_old || self.state.y.is_empty() {
            return vec![0.0; self.state.y.len()];
        }
        match &self.scheme {
            Scheme::Explicit(explicit) => explicit.error_estimate(self.state.t - self.state.t_old),
            Scheme::Radau(radau) => radau.error_estimate().to_vec(),
        }
    }

    /// Current time.
    pub fn t(&self) -> f64 {
        self.state.t
    }

    /// Current state.
    pub fn y(&self) -> &[f64] {
        &self.state.y
    }

    /// The right-hand side at the current state.
    pub(crate) fn rate(&self) -> &[f64] {
        &self.state.f
    }

    /// Time before the last step; the start if no step was made.
    pub fn t_old(&self) -> f64 {
        self.state.t_old
    }

    /// End of the interval.
    pub fn t_end(&self) -> f64 {
        self.state.t_end
    }

    /// 1 forward, -1 backward in time.
    pub fn direction(&self) -> f64 {
        self.state.direction
    }

    /// Cost of the integration so far.
    pub fn counters(&self) -> Counters {
        self.state.counters
    }

    /// The attempts since the last call.
    pub(crate) fn take_retries(&mut self) -> Retries {
        self.state.retries.take()
    }

    /// `None` while the integration is running.
    pub fn status(&self) -> Option<Status> {
        self.status
    }

    /// Time at which the problem was found to be stiff for an explicit method, if it was.
    pub fn stiff_at(&self) -> Option<f64> {
        self.state.stiff_at
    }

    /// Whether a relative tolerance was raised to 100 rounding units.
    pub fn rtol_raised(&self) -> bool {
        self.state.tolerances.rtol_raised
    }

    /// Describes a status of this integration, with advice unless it is a success.
    pub fn explain(&self, status: Status) -> String {
        let smallest_is_min_step =
            self.state.min_step > 0.0 && self.state.smallest_step() == self.state.min_step;
        let [t, t_end, min_step] = [self.state.t, self.state.t_end, self.state.min_step].map(Time);
        let mut message = match status {
            Status::Finished => "The end of the integration interval was reached.".to_owned(),
            // SciPy's message, which programs compare with.
            Status::Event => "A termination event occurred.".to_owned(),
            Status::TooManySteps if self.steps_in_memory < self.max_steps => format!(
                "The result has no room for more than {} steps ({} GiB), which were reached at t = {t}, before the end of \
                 the interval, {t_end}: ask for fewer states with `t_eval`, or loosen `rtol` and `atol`.",
                self.steps_in_memory,
                memory::LARGEST_RESULT >> 30
            ),
            Status::TooManySteps => format!(
                "The limit of {} steps was reached at t = {t}, before the end of the interval, {t_end}: increase \
                 `max_steps`, or loosen `rtol` and `atol`.",
                self.max_steps
            ),
            Status::StepTooSmall if smallest_is_min_step => format!(
                "The required step size is less than `min_step` = {min_step} at t = {t}: decrease `min_step`, or \
                 loosen `rtol` and `atol`."
            ),
            Status::StepTooSmall => format!(
                "The required step size is less than the spacing between numbers at t = {t}: the solution may have a \
                 singularity there; otherwise loosen `rtol` and `atol` (with an `atol` of 0, a component that passes \
                 through 0 has no tolerance left)."
            ),
            Status::NonFinite => format!(
                "The right-hand side or the state is NaN or infinite at or right after t = {t}, however small the step: \
                 check the right-hand side at that point, or end the interval before."
            ),
            Status::NonFiniteJacobian => format!(
                "The Jacobian of the right-hand side is NaN or infinite at t = {t}: check `jac`, or without it the \
                 right-hand side next to the state at that point; or end the interval before."
            ),
            Status::Interrupted => format!("The integration was stopped at t = {t}, as asked for."),
        };
        if let Some(t) = self.state.stiff_at.map(Time) {
            message.push_str(&format!(
                " The problem seems to be stiff at t = {t}: stability, not accuracy, limits the steps of this \
                 explicit method; `method=\"radau\"` would need far fewer."
            ));
        }
        message
    }
}
