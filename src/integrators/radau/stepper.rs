//! Integration step by step.

use super::Options;
use super::stages::{Stages, Start};
use crate::description::signal::end_of_step;
use crate::error::{Interrupted, InvalidInput, Number};
use crate::integrators::newmark;
use crate::integrators::newmark::LinearSystem;
use crate::integrators::ode;
use crate::integrators::ode::norm::all_finite;
use crate::integrators::ode::radau_iia::{
    DIVERGENCE_FACTOR, ERROR_ORDER, SMALLEST_FACTOR, StepError, next_size, step_factor,
};
use crate::integrators::ode::{Tolerances, initial_step};
use crate::integrators::second_order::{Counters, Failure, Status, Steps, System};
use crate::model::{Excitation, have_missed, is_unsound, may_miss, rotation_vectors};
use crate::numerics::hermite;
use crate::numerics::hermite::Quintic;
use crate::numerics::tape::Tape;

/// A step must be that many spacings of floating-point numbers long at least (SciPy).
const SMALLEST_STEP_IN_SPACINGS: f64 = 10.0;

/// Steps that end in a shape that means nothing are tried again as often, with half the size: longer ones may turn what turns too
/// far at once.
const MOST_FLAWED: usize = 5;

/// A remainder of the way of less than that fraction of a step is added to it.
const REMAINDER: f64 = 1e-9;

/// An integration performed step by step. All memory is allocated by the time the initial accelerations are
/// known.
///
/// The stepper does not own the equations of motion; pass the same ones to every call. They must provide
/// their [tangent](System::tangent).
#[derive(Clone, Debug)]
pub struct Stepper {
    /// Solves for the accelerations at the start.
    initial: Box<newmark::Stepper>,
    tolerances: Tolerances,
    options: Options,
    t: f64,
    t_end: f64,
    q: Vec<f64>,
    v: Vec<f64>,
    /// Accelerations, and multipliers of constraints behind them.
    a: Vec<f64>,
    t_old: f64,
    q_old: Vec<f64>,
    v_old: Vec<f64>,
    a_old: Vec<f64>,
    stages: Stages,
    smallest_rtol: f64,
    /// Scale of the errors of displacements and velocities.
    scale: Vec<f64>,
    /// Displacements on the way of a step, where surfaces may pass through each other.
    middle: Vec<f64>,
    /// Memory of `have_missed`.
    memory: Vec<f64>,
    /// Size of the next step.
    h: f64,
    last: Option<StepError>,
    tangents_are_wanted: bool,
    counters: Counters,
    started: bool,
    status: Option<Status>,
}

impl Stepper {
    /// Prepares the integration of `n` coordinates from `q0`, `v0` over `t_span`. Evaluates nothing.
    pub fn new(
        n: usize,
        t_span: (f64, f64),
        q0: &[f64],
        v0: &[f64],
        options: &Options,
    ) -> Result<Self, InvalidInput> {
        let tolerances = options.check(n, t_span, q0, v0)?;
        let (t0, t_end) = t_span;
        let any_step = if t_end > t0 { t_end - t0 } else { 1.0 };
        let initial = newmark::Stepper::new(n, t_span, q0, v0, &newmark::Options::new(any_step))?;
        let smallest_rtol = tolerances.rtol.iter().copied().fold(1.0, f64::min);
        let zeros = vec![0.0; n];
        Ok(Self {
            initial: Box::new(initial),
            tolerances,
            options: options.clone(),
            t: t0,
            t_end,
            q: q0.to_vec(),
            v: v0.to_vec(),
            a: zeros.clone(),
            t_old: t0,
            q_old: q0.to_vec(),
            v_old: v0.to_vec(),
            a_old: zeros,
            stages: Stages::new(n, 0, smallest_rtol),
            smallest_rtol,
            scale: vec![0.0; 2 * n],
            middle: Vec::new(),
            memory: Vec::new(),
            h: 0.0,
            last: None,
            tangents_are_wanted: false,
            counters: Counters::default(),
            started: false,
            status: None,
        })
    }

    /// Solves for the accelerations at the start and chooses the first step. [`Self::step`] calls this if
    /// necessary. Returns `Some(status)` if there are no accelerations.
    pub fn start<S: System + ?Sized>(&mut self, system: &mut S) -> Result<Option<Status>, Interrupted> {
        if self.started {
            return Ok(self.status);
        }
        self.prepare(system);
        self.status = self.initial.start(system)?;
        self.counters = self.initial.counters();
        self.q.copy_from_slice(self.initial.q());
        self.v.copy_from_slice(self.initial.v());
        self.a.copy_from_slice(self.initial.unknowns());
        self.a_old.copy_from_slice(&self.a);
        if self.status.is_none() && self.t < self.t_end {
            let start = Start { t: self.t, q: &self.q, v: &self.v, a: &self.a };
            self.stages.evaluate_tangents(system, &start, &mut self.counters)?;
            self.h = match self.options.first_step {
                Some(first_step) => first_step,
                None => self.select_first_step(system)?,
            };
        }
        self.started = self.status.is_none();
        Ok(self.status)
    }

    /// Memory for the multipliers of constraints, where there are any.
    fn prepare<S: System + ?Sized>(&mut self, system: &S) {
        let (n, constraints) = (self.q.len(), system.facts().constraints());
        if self.stages.unknowns() != n + constraints {
            self.stages = Stages::of_system(system, self.smallest_rtol);
            self.a.resize(n + constraints, 0.0);
            self.a_old.resize(n + constraints, 0.0);
        }
    }

    fn select_first_step<S: System + ?Sized>(&mut self, system: &mut S) -> Result<f64, Interrupted> {
        let n = self.q.len();
        let (true, Ok(mass)) = (n > 0, self.stages.mass()) else { return Ok(self.t_end - self.t) };
        let mut motion = NearStart { system, a0: &self.a, n, mass, residual: vec![0.0; self.a.len()] };
        let (y0, f0) = ([&self.q[..], &self.v].concat(), [&self.v[..], &self.a[..n]].concat());
        let start = initial_step::Start {
            t0: self.t,
            t_end: self.t_end,
            direction: 1.0,
            y0: &y0,
            f0: &f0,
            max_step: self.options.max_step,
        };
        self.counters.nfev += 1;
        initial_step::select(&mut motion, &start, &self.tolerances, ERROR_ORDER)
    }

    /// Makes one accepted step. Returns `Some(status)` if the integration has ended: the end was reached, or
    /// no step could be made, which leaves the state unchanged. After an interruption the state is that of
    /// the last accepted step, and the step can be repeated.
    ///
    /// # Panics
    /// If the integration had already ended.
    pub fn step<S: System + ?Sized>(&mut self, system: &mut S) -> Result<Option<Status>, Interrupted> {
        assert!(self.status.is_none(), "the integration is over");
        if self.start(system)?.is_some() {
            return Ok(self.status);
        }
        self.status = if self.t == self.t_end || self.q.is_empty() {
            // Nothing moves.
            self.t_old = self.t;
            self.t = self.t_end;
            Some(Status::Finished)
        } else if self.counters.steps >= self.options.max_steps {
            Some(Status::TooManySteps)
        } else {
            self.settle(system);
            self.advance(system)?
        };
        if self.status.is_none() && self.t == self.t_end {
            self.status = Some(Status::Finished);
        }
        Ok(self.status)
    }

    /// Goes on in other coordinates where those at hand come near a singularity.
    pub(crate) fn settle<S: System + ?Sized>(&mut self, system: &mut S) {
        let vectors = &system.facts().rotation_vectors;
        if rotation_vectors::wrap(vectors, &mut self.q, &mut self.v, &mut [&mut self.a]) {
            self.stages.forget_last();
            self.tangents_are_wanted = true;
        }
    }

    /// Makes one accepted step of at most the size that is proposed.
    fn advance<S: System + ?Sized>(&mut self, system: &mut S) -> Result<Option<Status>, Interrupted> {
        let smallest = self.options.min_step.max(SMALLEST_STEP_IN_SPACINGS * (self.t.next_up() - self.t));
        let mut h = self.h.clamp(smallest.min(self.options.max_step), self.options.max_step);
        if std::mem::take(&mut self.tangents_are_wanted) {
            let start = Start { t: self.t, q: &self.q, v: &self.v, a: &self.a };
            self.stages.evaluate_tangents(system, &start, &mut self.counters)?;
        }
        let mut was_rejected = false;
        let mut flawed = 0;
        let mut failure = Failure::NotConverged;
        let horizon = system.model().map_or(f64::INFINITY, |model| model.horizon(self.t));
        let end = end_of_step(self.t, self.t_end, horizon);
        loop {
            let start = Start { t: self.t, q: &self.q, v: &self.v, a: &self.a };
            let wanted = h;
            let is_last = self.t + h * (1.0 + REMAINDER) >= end;
            if h.is_nan() || h < smallest && (was_rejected || !is_last) {
                return Ok(Some(match failure {
                    Failure::NotConverged => Status::StepTooSmall,
                    failure => Status::StepFailed(failure),
                }));
            }
            let t_new = if is_last { end } else { self.t + h };
            h = t_new - self.t;
            set_scale(&mut self.scale, &self.tolerances, [start.q, start.v], [start.q, start.v]);
            let newton =
                match self.stages.solve(system, &start, (h, t_new), &self.scale, &mut self.counters)? {
                    Ok(newton) => newton,
                    Err(found) => {
                        failure = found;
                        self.counters.unsolved += 1;
                        was_rejected = true;
                        h *= DIVERGENCE_FACTOR;
                        continue;
                    }
                };
            failure = Failure::NotConverged;
            let end = [&self.stages.q[..], &self.stages.v];
            set_scale(&mut self.scale, &self.tolerances, [start.q, start.v], end);
            let scale = &self.scale;
            let error = self.stages.error(system, &start, h, scale, was_rejected, &mut self.counters)?;
            let sized = StepError { h_abs: h, error };
            let factor = step_factor(sized, self.last, newton.iterations);
            let finite = all_finite(&self.stages.q) && all_finite(&self.stages.v);
            if error <= 1.0 && finite {
                if !self.stages.fit(system, (h, t_new), &mut self.counters)? {
                    self.counters.unsolved += 1;
                    was_rejected = true;
                    h *= DIVERGENCE_FACTOR;
                    continue;
                }
                if self.is_wrong(system, t_new, flawed < MOST_FLAWED)? {
                    flawed += 1;
                    self.counters.rejected += 1;
                    was_rejected = true;
                    h *= DIVERGENCE_FACTOR;
                    continue;
                }
                self.tangents_are_wanted = newton.wants_jacobian() && !self.stages.have_own_tangents();
                // The rest of the way says nothing about the size of the step after it.
                let least = if is_last { wanted } else { 0.0 };
                self.h = least.max(next_size(h, factor, self.tangents_are_wanted));
                self.last = Some(sized);
                self.accept(t_new, h);
                return Ok(None);
            }
            self.counters.rejected += 1;
            was_rejected = true;
            h *= if finite { factor.max(SMALLEST_FACTOR) } else { DIVERGENCE_FACTOR };
        }
    }

    /// Whether contacts or stops act within the step to the last stage, unseen at its ends, or, if that `is_judged`, the motion there
    /// cannot be.
    fn is_wrong<S: System + ?Sized>(
        &mut self,
        system: &mut S,
        t_new: f64,
        is_judged: bool,
    ) -> Result<bool, Interrupted> {
        let Some(model) = system.model() else { return Ok(false) };
        let Self { t, q, v, stages, middle, memory, .. } = self;
        let h = t_new - *t;
        if may_miss(model) {
            let rates = [&v[..], &stages.v];
            hermite::middle(h, [q, &stages.q], rates, middle);
            let way = [(*t, &q[..]), (0.5 * (*t + t_new), middle), (t_new, &stages.q)];
            if have_missed(model, &way, rates, memory)? {
                return Ok(true);
            }
        }
        let motion = [&stages.q[..], &stages.v, &stages.end[..q.len()]];
        Ok(is_judged && is_unsound(model, t_new, [q, v], motion, h)?)
    }

    /// Takes the last stage as the new state.
    fn accept(&mut self, t_new: f64, h: f64) {
        self.t_old = self.t;
        self.t = t_new;
        std::mem::swap(&mut self.q_old, &mut self.q);
        std::mem::swap(&mut self.v_old, &mut self.v);
        std::mem::swap(&mut self.a_old, &mut self.a);
        self.q.copy_from_slice(&self.stages.q);
        self.v.copy_from_slice(&self.stages.v);
        self.a.copy_from_slice(&self.stages.end);
        self.stages.accept(h);
        self.stages.forget_start();
        self.counters.steps += 1;
    }

    /// Goes on to a later end, whatever the status was.
    pub(crate) fn go_on(&mut self, t_end: f64) {
        (self.status, self.t_end) = (None, t_end);
    }

    /// Takes these accelerations for the current ones: what acts has jumped.
    pub(crate) fn jump(&mut self, a: &[f64]) {
        self.a[..a.len()].copy_from_slice(a);
        self.stages.forget_last();
    }

    /// Takes back the last step.
    pub(crate) fn take_back(&mut self) {
        self.t = self.t_old;
        self.q.copy_from_slice(&self.q_old);
        self.v.copy_from_slice(&self.v_old);
        self.a.copy_from_slice(&self.a_old);
        self.stages.take_back();
        self.status = None;
        self.counters.steps -= 1;
        self.counters.rejected += 1;
    }

    /// Goes on from this state, with other constraints; `a` are accelerations, and multipliers behind them.
    pub(crate) fn restart<S: System + ?Sized>(
        &mut self,
        system: &mut S,
        [q, v, a]: [&[f64]; 3],
    ) -> Result<(), Interrupted> {
        self.q.copy_from_slice(q);
        self.v.copy_from_slice(v);
        self.a.copy_from_slice(a);
        self.stages.forget_last();
        self.last = None;
        let start = Start { t: self.t, q: &self.q, v: &self.v, a: &self.a };
        self.stages.evaluate_tangents(system, &start, &mut self.counters)?;
        self.h = self.h.min(self.select_first_step(system)?);
        Ok(())
    }

    /// What goes on from step to step.
    pub(crate) fn carry<S: System + ?Sized>(&mut self, system: &mut S, tape: &mut Tape<'_>) {
        if tape.reads() {
            self.prepare(system);
        }
        for number in [&mut self.t, &mut self.t_end, &mut self.t_old, &mut self.h] {
            tape.number(number);
        }
        let Self { q, v, a, q_old, v_old, a_old, .. } = self;
        for values in [q, v, a, q_old, v_old, a_old] {
            tape.numbers(values);
        }
        tape.optional(&mut self.last, StepError { h_abs: 0.0, error: 0.0 }, |tape, last| {
            tape.number(&mut last.h_abs);
            tape.number(&mut last.error);
        });
        tape.flag(&mut self.tangents_are_wanted);
        self.counters.carry(tape);
        tape.flag(&mut self.started);
        self.stages.carry(tape);
    }

    /// Current time.
    pub fn t(&self) -> f64 {
        self.t
    }

    /// Current displacements.
    pub fn q(&self) -> &[f64] {
        &self.q
    }

    /// Current velocities.
    pub fn v(&self) -> &[f64] {
        &self.v
    }

    /// Current accelerations, which satisfy the equations of motion to the tolerance of the step.
    pub fn a(&self) -> &[f64] {
        &self.a[..self.q.len()]
    }

    /// Time before the last step; the start if no step was made.
    pub fn t_old(&self) -> f64 {
        self.t_old
    }

    /// Cost of the integration so far.
    pub fn counters(&self) -> Counters {
        self.counters
    }

    /// `None` while the integration is running.
    pub fn status(&self) -> Option<Status> {
        self.status
    }

    /// State at a time within the last step: the quintic polynomial through displacements, velocities and
    /// accelerations at both ends, and its derivatives, of orders 5, 4 and 3. At the ends of the step, the
    /// result is bit for bit the state there.
    pub fn interpolate(&self, t: f64, q: &mut [f64], v: &mut [f64], a: &mut [f64]) {
        let ends =
            [(self.t_old, [&self.q_old, &self.v_old, &self.a_old]), (self.t, [&self.q, &self.v, &self.a])];
        if let Some((_, state)) = ends.iter().find(|(end, _)| *end == t) {
            for (out, values) in [q, v, a].into_iter().zip(state) {
                out.copy_from_slice(&values[..out.len()]);
            }
            return;
        }
        let h = self.t - self.t_old;
        let quintic = Quintic::at((t - self.t_old) / h, h);
        for i in 0..q.len() {
            let start = [self.q_old[i], self.v_old[i], self.a_old[i]];
            [q[i], v[i], a[i]] = quintic.motion(start, [self.q[i], self.v[i], self.a[i]]);
        }
    }

    /// Describes a status of this integration, with advice unless it is a success.
    pub fn explain(&self, status: Status) -> String {
        let [t, h] = [self.t, self.h].map(Number);
        match status {
            Status::StepFailed(Failure::NonFinite) => format!(
                "The residual or its Jacobian became NaN or infinite right after t = {t}, however small the step; the result \
                 ends there. Check the equations of motion near the last state."
            ),
            Status::StepFailed(_) => format!(
                "The Jacobian of the step from t = {t} (step size {h}) is singular, however small the step; the result ends \
                 there: the equations of motion do not determine the accelerations."
            ),
            Status::StepTooSmall => format!(
                "The step size fell below its limit at t = {t} after {} rejected and {} unsolved steps: loosen `rtol` and \
                 `atol` (with an `atol` of 0, a coordinate that passes through 0 has no tolerance left), reduce `min_step`, or \
                 check the equations of motion there for a singularity.",
                self.counters.rejected, self.counters.unsolved
            ),
            Status::TooManySteps => format!(
                "The limit of {} steps was reached at t = {t}, before the end of the interval, {}: increase `max_steps`, or \
                 loosen `rtol` and `atol`.",
                self.options.max_steps,
                Number(self.t_end)
            ),
            Status::Interrupted => format!("The integration was stopped at t = {t}, as asked for."),
            Status::Finished | Status::NoInitialAcceleration(_) => self.initial.explain(status),
        }
    }
}

impl<S: System + ?Sized> Steps<S> for Stepper {
    fn start(&mut self, system: &mut S) -> Result<Option<Status>, Interrupted> {
        self.start(system)
    }
    fn step(&mut self, system: &mut S) -> Result<Option<Status>, Interrupted> {
        self.step(system)
    }
    fn t(&self) -> f64 {
        self.t()
    }
    fn state(&self) -> [&[f64]; 3] {
        [self.q(), self.v(), self.a()]
    }
    fn interpolate(&self, t: f64, q: &mut [f64], v: &mut [f64], a: &mut [f64]) {
        self.interpolate(t, q, v, a);
    }
    fn counters(&self) -> Counters {
        self.counters()
    }
    fn explain(&self, status: Status) -> String {
        self.explain(status)
    }
}

/// `scale <- atol + rtol max(|start|, |end|)` of displacements and velocities.
fn set_scale(scale: &mut [f64], tolerances: &Tolerances, start: [&[f64]; 2], end: [&[f64]; 2]) {
    let sizes = start
        .iter()
        .zip(end)
        .flat_map(|(start, end)| start.iter().zip(end).map(|(start, end)| start.abs().max(end.abs())));
    for ((scale, size), (rtol, atol)) in
        scale.iter_mut().zip(sizes).zip(tolerances.rtol.iter().zip(&tolerances.atol))
    {
        *scale = atol + rtol * size;
    }
}

/// The motion as a system of first order, with the mass matrix of the start: good enough to choose the first step.
struct NearStart<'a, S: ?Sized> {
    system: &'a mut S,
    /// Accelerations and multipliers, and the number of the former.
    a0: &'a [f64],
    n: usize,
    mass: LinearSystem,
    residual: Vec<f64>,
}

impl<S: System + ?Sized> ode::System for NearStart<'_, S> {
    fn n(&self) -> usize {
        2 * self.n
    }

    fn rhs(&mut self, t: f64, y: &[f64], dydt: &mut [f64]) -> Result<(), Interrupted> {
        let n = self.n;
        let (q, v) = y.split_at(n);
        self.system.residual(t, q, v, self.a0, &mut self.residual)?;
        // Gaps say nothing about accelerations.
        self.residual[n..].fill(0.0);
        self.mass.solve(&mut self.residual);
        dydt[..n].copy_from_slice(v);
        for i in 0..n {
            dydt[n + i] = self.a0[i] - self.residual[i];
        }
        Ok(())
    }
}
