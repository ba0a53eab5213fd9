//! Integration step by step.

use super::Options;
use super::stages::{Stages, Start};
use crate::error::{Interrupted, InvalidInput, Time};
use crate::integrators::attempts::{self, Adaptive, Ends, Sizes, Tried, Unilateral, adaptive_step};
use crate::integrators::newmark;
use crate::integrators::newmark::LinearSystem;
use crate::integrators::ode;
use crate::integrators::ode::norm::all_finite;
use crate::integrators::ode::radau_iia::{
    DIVERGENCE_FACTOR, ERROR_ORDER, SMALLEST_FACTOR, StepError, next_size, step_factor,
};
use crate::integrators::ode::{Tolerances, initial_step};
use crate::integrators::second_order::{Counters, Failure, SecondOrderSystem, Status, steps};
use crate::integrators::{Reason, Retries};
use crate::model::rotation_vectors;
use crate::numerics::hermite::Quintic;
use crate::numerics::tape::Tape;

/// An integration performed step by step. All memory is allocated by the time the initial accelerations are
/// known.
///
/// The stepper does not own the equations of motion; pass the same ones to every call. They must provide
/// their [tangent](SecondOrderSystem::tangent).
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
    /// Where the step ends that is tried, its error, and whether the next one needs tangents of its own.
    t_new: f64,
    tried: (StepError, bool),
    unilateral: Unilateral,
    /// Size of the next step.
    h: f64,
    last: Option<StepError>,
    tangents_are_wanted: bool,
    counters: Counters,
    retries: Retries,
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
            t_new: t0,
            tried: (StepError { h_abs: 0.0, error: 0.0 }, false),
            unilateral: Unilateral::default(),
            h: 0.0,
            last: None,
            tangents_are_wanted: false,
            counters: Counters::default(),
            retries: Retries::default(),
            started: false,
            status: None,
        })
    }

    /// Tolerances are absolute ones, and iterations go as far as this relative one asks for. Before the first step.
    pub(crate) fn set_accuracy(&mut self, rtol: f64) {
        self.tolerances.rtol.fill(0.0);
        self.smallest_rtol = rtol;
        self.stages = Stages::new(self.q.len(), 0, rtol);
    }

    /// Solves for the accelerations at the start and chooses the first step. [`Self::step`] calls this if
    /// necessary. Returns `Some(status)` if there are no accelerations.
    pub fn start<S: SecondOrderSystem + ?Sized>(
        &mut self,
        system: &mut S,
    ) -> Result<Option<Status>, Interrupted> {
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

    /// Memory for the multipliers of constraints, where there are any, and how accurate iterations must be.
    fn prepare<S: SecondOrderSystem + ?Sized>(&mut self, system: &S) {
        let (n, constraints) = (self.q.len(), system.facts().constraints());
        if self.stages.unknowns() != n + constraints {
            self.stages = Stages::of_system(system, self.smallest_rtol);
            self.a.resize(n + constraints, 0.0);
            self.a_old.resize(n + constraints, 0.0);
        }
        self.stages.follow(system.facts());
    }

    fn select_first_step<S: SecondOrderSystem + ?Sized>(
        &mut self,
        system: &mut S,
    ) -> Result<f64, Interrupted> {
        let n = self.q.len();
        let (true, Ok(mass)) = (n > 0, self.stages.mass()) else { return Ok(self.t_end - self.t) };
        let mut motion =
            FirstOrderAtStart { system, a0: &self.a, n, mass, residual: vec![0.0; self.a.len()] };
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
    pub fn step<S: SecondOrderSystem + ?Sized>(
        &mut self,
        system: &mut S,
    ) -> Result<Option<Status>, Interrupted> {
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
            self.shorten_rotation_vectors(system);
            if std::mem::take(&mut self.tangents_are_wanted) {
                let start = Start { t: self.t, q: &self.q, v: &self.v, a: &self.a };
                self.stages.evaluate_tangents(system, &start, &mut self.counters)?;
            }
            let Options { min_step: smallest, max_step: largest, .. } = self.options;
            let sizes = Sizes { t_end: self.t_end, wanted: self.h, smallest, largest };
            match adaptive_step(self, system, sizes)? {
                Ok(next) => {
                    self.h = next;
                    None
                }
                Err(Failure::NotConverged) => Some(Status::StepTooSmall),
                Err(failure) => Some(Status::StepFailed(failure)),
            }
        };
        if self.status.is_none() && self.t == self.t_end {
            self.status = Some(Status::Finished);
        }
        Ok(self.status)
    }

    /// Goes on in other coordinates where those at hand come near a singularity.
    pub(crate) fn shorten_rotation_vectors<S: SecondOrderSystem + ?Sized>(&mut self, system: &mut S) {
        let vectors = &system.facts().rotation_vectors;
        if rotation_vectors::wrap(vectors, &mut self.q, &mut self.v, &mut [&mut self.a]) {
            self.stages.forget_last();
            self.tangents_are_wanted = true;
        }
    }

    /// Size of the next step, before it is tried; from the start on.
    pub(crate) fn next_step(&mut self) -> &mut f64 {
        &mut self.h
    }

    /// Goes on to a later end, whatever the status was.
    pub(crate) fn extend_to(&mut self, t_end: f64) {
        (self.status, self.t_end) = (None, t_end);
    }

    /// Takes these accelerations for the current ones: what acts has jumped.
    pub(crate) fn jump(&mut self, a: &[f64]) {
        self.a[..a.len()].copy_from_slice(a);
        self.stages.forget_last();
    }

    /// Takes back the last step.
    pub(crate) fn undo_step(&mut self) {
        self.t = self.t_old;
        self.q.copy_from_slice(&self.q_old);
        self.v.copy_from_slice(&self.v_old);
        self.a.copy_from_slice(&self.a_old);
        self.stages.undo_step();
        self.status = None;
        self.counters.steps -= 1;
        self.counters.rejected += 1;
        self.retries.fail(Reason::Event);
    }

    /// Goes on from this state, with other constraints; `a` are accelerations, and multipliers behind them.
    pub(crate) fn restart<S: SecondOrderSystem + ?Sized>(
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

    /// Serialises all data that persist from step to step.
    pub(crate) fn serialise<S: SecondOrderSystem + ?Sized>(&mut self, system: &mut S, tape: &mut Tape<'_>) {
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
        self.counters.serialise(tape);
        tape.flag(&mut self.started);
        self.stages.serialise(tape);
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

    /// Current accelerations, and multipliers of constraints behind them.
    pub(crate) fn unknowns(&self) -> &[f64] {
        &self.a
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

    /// The attempts since the last call.
    pub(crate) fn take_retries(&mut self) -> Retries {
        self.retries.take()
    }

    /// `None` while the integration is running.
    pub fn status(&self) -> Option<Status> {
        self.status
    }

    /// State at a time within the last step: the quintic polynomial through displacements, velocities and
    /// accelerations at both ends, and its derivatives, of orders 5, 4 and 3. At the ends of the step, the
    /// result is bit for bit the state there.
    pub fn interpolate(&self, t: f64, q: &mut [f64], v: &mut [f64], a: &mut [f64]) {
        interpolate(self.ends(), t, [q, v, a]);
    }

    /// Times and motions at both ends of the last step; multipliers stand behind accelerations.
    pub(crate) fn ends(&self) -> [(f64, [&[f64]; 3]); 2] {
        [(self.t_old, [&self.q_old, &self.v_old, &self.a_old]), (self.t, [&self.q, &self.v, &self.a])]
    }

    /// Describes a status of this integration, with advice unless it is a success.
    pub fn explain(&self, status: Status) -> String {
        let [t, h] = [self.t, self.h].map(Time);
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
                Time(self.t_end)
            ),
            Status::Interrupted => format!("The integration was stopped at t = {t}, as asked for."),
            Status::Finished | Status::NoInitialAcceleration(_) | Status::Unstable => {
                self.initial.explain(status)
            }
        }
    }
}

impl attempts::Stepper for Stepper {
    fn tried(&mut self) -> (Ends<'_>, &mut Unilateral) {
        let Self { t, q, v, a, stages, t_new, unilateral, .. } = self;
        let (t, h) = ([*t, *t_new], *t_new - *t);
        (Ends { t, h, q: [q, &stages.q], v: [v, &stages.v], a: [a, &stages.end] }, unilateral)
    }

    fn retries(&mut self) -> &mut Retries {
        &mut self.retries
    }

    fn accept<S: SecondOrderSystem + ?Sized>(&mut self, _: &mut S) -> Result<(), Interrupted> {
        let h = self.t_new - self.t;
        self.t_old = self.t;
        self.t = self.t_new;
        std::mem::swap(&mut self.q_old, &mut self.q);
        std::mem::swap(&mut self.v_old, &mut self.v);
        std::mem::swap(&mut self.a_old, &mut self.a);
        self.q.copy_from_slice(&self.stages.q);
        self.v.copy_from_slice(&self.stages.v);
        self.a.copy_from_slice(&self.stages.end);
        self.stages.accept(h);
        self.stages.forget_start();
        self.counters.steps += 1;
        Ok(())
    }
}

impl Adaptive for Stepper {
    const FAILED_STEP_FACTOR: f64 = DIVERGENCE_FACTOR;
    const BENDS: bool = true;

    fn try_step<S: SecondOrderSystem + ?Sized>(
        &mut self,
        system: &mut S,
        t_new: f64,
        h: f64,
        again: bool,
    ) -> Result<Tried, Interrupted> {
        let Self { stages, scale, tolerances, counters, .. } = self;
        let start = Start { t: self.t, q: &self.q, v: &self.v, a: &self.a };
        set_scale(scale, tolerances, [start.q, start.v], [start.q, start.v]);
        let newton = match stages.solve(system, &start, (h, t_new), scale, counters)? {
            Ok(newton) => newton,
            Err(failure) => return Ok(Tried::Unsolved(failure)),
        };
        set_scale(scale, tolerances, [start.q, start.v], [&stages.q, &stages.v]);
        let error = stages.error(system, &start, h, scale, again, counters)?;
        let sized = StepError { h_abs: h, error };
        let factor = step_factor(sized, self.last, newton.iterations);
        let finite = all_finite(&stages.q) && all_finite(&stages.v);
        if !(error <= 1.0 && finite) {
            let factor = if finite { factor.max(SMALLEST_FACTOR) } else { DIVERGENCE_FACTOR };
            return Ok(Tried::Inaccurate(factor));
        }
        if !stages.fit(system, (h, t_new), counters)? {
            return Ok(Tried::Unsolved(Failure::NotConverged));
        }
        self.t_new = t_new;
        self.tried = (sized, newton.wants_jacobian() && !stages.have_own_tangents());
        Ok(Tried::Good(factor))
    }

    fn next_size(&mut self, h: f64, _: f64, factor: f64) -> f64 {
        let (sized, wants_tangents) = self.tried;
        (self.last, self.tangents_are_wanted) = (Some(sized), wants_tangents);
        next_size(h, factor, wants_tangents)
    }

    fn counters(&mut self) -> &mut Counters {
        &mut self.counters
    }
}

steps!(Stepper);

/// State at a time within a step between these [ends](Stepper::ends).
pub(crate) fn interpolate(ends: [(f64, [&[f64]; 3]); 2], t: f64, [q, v, a]: [&mut [f64]; 3]) {
    if let Some((_, state)) = ends.iter().find(|(end, _)| *end == t) {
        for (out, values) in [q, v, a].into_iter().zip(state) {
            out.copy_from_slice(&values[..out.len()]);
        }
        return;
    }
    let [(t_old, [q_old, v_old, a_old]), (t_new, [q_new, v_new, a_new])] = ends;
    let h = t_new - t_old;
    let quintic = Quintic::at((t - t_old) / h, h);
    for i in 0..q.len() {
        [q[i], v[i], a[i]] = quintic.motion([q_old[i], v_old[i], a_old[i]], [q_new[i], v_new[i], a_new[i]]);
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
struct FirstOrderAtStart<'a, S: ?Sized> {
    system: &'a mut S,
    /// Accelerations and multipliers, and the number of the former.
    a0: &'a [f64],
    n: usize,
    mass: LinearSystem,
    residual: Vec<f64>,
}

impl<S: SecondOrderSystem + ?Sized> ode::FirstOrderSystem for FirstOrderAtStart<'_, S> {
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
