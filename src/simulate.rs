//! Free motions of models over an interval, by the implicit Newmark family or an explicit Runge-Kutta method.

use std::time::Instant;

use crate::balance::{Balance, Flow, FlowMeter, Rule, State};
use crate::error::{Checker, Interrupted, InvalidInput, Number};
use crate::model::{Flaw, ForwardScratch, Model, at_least, rotation_vectors};
use crate::newmark::{self, StepSize, number_of_steps};
use crate::ode::{self, FirstOrder, Output};
use crate::radau;
use crate::second_order;
use crate::second_order::{FreeMotion, check_points};
use crate::signal::covers;
use crate::spectrum::Spectrum;
use crate::unseen::Unseen;

/// Steps that stability may force on an explicit method, unless the caller says how many there may be: some seconds
/// of work.
const STIFF_STEPS: usize = 100_000;

/// Accepted steps after which that is looked at for the first time.
const FIRST_LOOK: usize = 256;

/// Steps longer than this part of the stable ones are limited by the largest rate: by stability, or because it is
/// followed.
const LIMITED: f64 = 0.1;

/// Nobody wants to follow it where it is so many times the highest frequency that moves the tip by this part of the
/// length.
const MANY_TIMES: f64 = 10.0;
const VISIBLE: f64 = 1e-5;

/// How a motion is computed.
#[derive(Clone, Debug, PartialEq)]
pub enum Method {
    /// By the Newmark family, through the inverse dynamics and their tangent.
    Newmark(newmark::Options),
    /// By Radau IIA of order 5, through the inverse dynamics and their tangent.
    Radau {
        /// How to integrate; the tolerances are those of displacements and velocities.
        options: radau::Options,
        /// Distance of the output times where none are asked for.
        dt: f64,
    },
    /// As a system of first order, through the forward dynamics.
    FirstOrder {
        /// How to integrate; the tolerances are those of displacements and velocities.
        options: ode::Options,
        /// Distance of the output times where none are asked for.
        dt: f64,
    },
}

/// What a run has cost. Counters that have no meaning for the method are zero.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Statistics {
    /// Seconds from the start to the end of the run, on the wall clock.
    pub wall_time: f64,
    /// Estimated error of the tip by the steps in time, relative to the model's length; only of runs to an accuracy.
    pub time_error: Option<f64>,
    /// Estimated error of the tip by the number of modes and nodes, likewise; only where there are any.
    pub space_error: Option<f64>,
    /// What was counted. For first-order methods `nfev` are forward dynamics.
    pub counters: second_order::Counters,
}

/// Why a run ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Status {
    /// Of the Newmark family or of Radau IIA.
    SecondOrder(second_order::Status),
    /// Of a first-order method.
    FirstOrder(ode::Status),
    /// The end was reached, but not the accuracy that was asked for.
    AccuracyNotReached,
    /// The motion left the shapes that the model resolves.
    Unresolved,
    /// The motion turned the rod inside out.
    Inverted,
    /// Stability would force more steps on an explicit method than are sensible.
    Stiff,
}

impl Status {
    /// True when the end of the interval was reached.
    pub fn is_success(self) -> bool {
        match self {
            Self::SecondOrder(status) => status.is_success(),
            Self::FirstOrder(status) => status.is_success(),
            Self::AccuracyNotReached | Self::Unresolved | Self::Inverted | Self::Stiff => false,
        }
    }

    /// The status as one word, such as `finished` or `interrupted`.
    pub fn name(self) -> &'static str {
        match self {
            Self::SecondOrder(status) => status.name(),
            Self::FirstOrder(status) => status.name(),
            Self::AccuracyNotReached => "accuracy_not_reached",
            Self::Unresolved => "unresolved",
            Self::Inverted => "inverted",
            Self::Stiff => "stiff",
        }
    }
}

/// A motion and how it came about. What was computed before a failure or an interruption is kept.
#[derive(Clone, Debug)]
pub struct Simulation {
    /// Times: those asked for as far as they were reached; else all steps (Newmark) or a grid (first order).
    pub t: Vec<f64>,
    /// Coordinates at these times one after the other, n numbers each.
    pub q: Vec<f64>,
    /// Velocities, likewise.
    pub v: Vec<f64>,
    /// Accelerations, likewise; `None` where the method does not solve for them: [`Self::accelerations`] does.
    pub a: Option<Vec<f64>>,
    /// Number of coordinates n.
    pub n: usize,
    /// Energy that has flowed out of and into the motion up to these times, integrated along the run.
    pub flow: Flow,
    /// What it has cost.
    pub statistics: Statistics,
    /// How it ended.
    pub status: Status,
    /// The status in words, with what to change when it is not the wanted one.
    pub message: String,
    /// Why the motion may be far from the right one although the method has nothing against it; the message ends with it.
    pub doubt: Option<String>,
}

impl Simulation {
    /// The accelerations of this motion of `model`: those of the run, or by one forward dynamics for each of the times.
    pub fn accelerations<M: Model + ?Sized>(&self, model: &mut M) -> Result<Vec<f64>, Interrupted> {
        match &self.a {
            Some(a) => Ok(a.clone()),
            None => accelerations(model, &self.t, &self.q, &self.v),
        }
    }

    /// Forgets all times but these, which increase; a run that ended early has the first of them.
    pub(crate) fn keep(&mut self, times: &[f64]) {
        let is_kept: Vec<bool> =
            self.t.iter().map(|t| times.binary_search_by(|time| time.total_cmp(t)).is_ok()).collect();
        let n = self.n;
        let keep = |values: &mut Vec<f64>, n: usize| {
            let mut of_all = is_kept.iter().flat_map(|&is_kept| std::iter::repeat_n(is_kept, n));
            values.retain(|_| of_all.next() == Some(true));
        };
        for values in [&mut self.q, &mut self.v].into_iter().chain(&mut self.a) {
            keep(values, n);
        }
        for values in [&mut self.t, &mut self.flow.dissipated, &mut self.flow.work] {
            keep(values, 1);
        }
    }

    /// The energy balance of this motion of `model`: one evaluation of its energy for each of the times.
    pub fn balance<M: Model + ?Sized>(&self, model: &mut M) -> Result<Balance, Interrupted> {
        Balance::new(model, &self.t, &self.q, &self.v, &self.flow)
    }
}

/// Steps of a period of what is driven where nothing else moves: the mean of two powers then is good to 1e-3.
const STEPS_OF_A_PERIOD: f64 = 100.0;

/// The free motion of `model` from `q0`, `v0` over `t_span`, from its start to its end. `t_eval` are increasing times
/// at which it is wanted. `monitor` sees the time after every accepted step and may stop the run; the status then
/// says so.
///
/// Fails before any evaluation when an argument is wrong, when the model does not resolve `q0`, or when the result
/// would not fit in memory.
pub fn simulate<M: Model + Clone>(
    mut model: M,
    t_span: (f64, f64),
    q0: &[f64],
    v0: &[f64],
    method: &Method,
    t_eval: Option<&[f64]>,
    monitor: &mut dyn FnMut(f64) -> Result<(), Interrupted>,
) -> Result<Simulation, InvalidInput> {
    let start = Instant::now();
    second_order::check_start(model.n(), t_span, q0, v0, method.dt())?;
    let (by_steps, grid_of_steps);
    let (method, t_eval) = if model.n() == 0 && !matches!(method, Method::Newmark(_)) {
        // Nothing is unknown, and no error chooses steps: these see what is driven and its work.
        let dt = method.dt().min(model.shortest_period() / STEPS_OF_A_PERIOD);
        by_steps = Method::Newmark(newmark::Options::new(dt));
        grid_of_steps = match t_eval {
            Some(times) => times.to_vec(),
            None => grid(0, t_span, method.dt())?,
        };
        (&by_steps, Some(&grid_of_steps[..]))
    } else {
        (method, t_eval)
    };
    model.check_shape(q0, "q0")?;
    check_span(model.time_span(), t_span)?;
    if let Method::Newmark(newmark::Options { dt, step_size: StepSize::Fixed, .. }) = *method {
        check_step(dt, model.shortest_period())?;
    }
    let mut stop = None;
    let mut simulation = match method {
        Method::Newmark(options) => {
            let mut unseen = match options.step_size {
                StepSize::Fixed => Unseen::new(&mut model, t_span, [q0, v0], options.dt),
                StepSize::Adaptive { .. } => None,
            };
            let mut meter = FlowMeter::new(&mut model, Rule::Mean, t_span.0, [q0, v0], t_eval);
            let mut monitor = |system: &mut FreeMotion<'_, M>, stepper: &newmark::Stepper| {
                let state = State { t: stepper.t(), q: stepper.q(), v: stepper.v(), a: stepper.a() };
                measure(&mut meter, system, state)?;
                if let Some(unseen) = &mut unseen {
                    unseen.step(state.t, state.a);
                }
                stop = Stop::where_flawed(system.0, stepper.t(), stepper.q());
                if stop.is_some() { Err(Interrupted) } else { monitor(stepper.t()) }
            };
            let mut system = FreeMotion(&mut model);
            let solution = newmark::solve(&mut system, t_span, q0, v0, options, t_eval, &mut monitor)?;
            let mut simulation = Simulation::new(solution, meter).wrapped(&model);
            if simulation.status.is_success() {
                simulation.doubt = unseen.and_then(|unseen| unseen.verdict(&mut model, q0));
            }
            simulation.because(model.not_finite())
        }
        Method::Radau { options, dt } => {
            let times = match t_eval {
                Some(times) => times.to_vec(),
                None => grid(model.n(), t_span, *dt)?,
            };
            let mut meter = FlowMeter::new(&mut model, Rule::Quintic, t_span.0, [q0, v0], Some(&times));
            let mut monitor = |system: &mut FreeMotion<'_, M>, stepper: &radau::Stepper| {
                let state = State { t: stepper.t(), q: stepper.q(), v: stepper.v(), a: stepper.a() };
                measure(&mut meter, system, state)?;
                stop = Stop::where_flawed(system.0, stepper.t(), stepper.q());
                if stop.is_some() { Err(Interrupted) } else { monitor(stepper.t()) }
            };
            let mut system = FreeMotion(&mut model);
            let solution = radau::solve(&mut system, t_span, q0, v0, options, Some(&times), &mut monitor)?;
            Simulation::new(solution, meter).wrapped(&model).because(model.not_finite())
        }
        Method::FirstOrder { options, dt } => {
            first_order(model, t_span, [q0, v0], (options, *dt), t_eval, &mut stop, monitor)?
        }
    };
    if let Some(stop) = stop {
        simulation.status = stop.status;
        simulation.message = stop.message;
    }
    if let Some(doubt) = &simulation.doubt {
        simulation.message = format!("{} {doubt}", simulation.message);
    }
    simulation.statistics.wall_time = start.elapsed().as_secs_f64();
    Ok(simulation)
}

/// Fixed steps must see what oscillates: from half a period on it looks like something slower (Nyquist), or like nothing.
pub(crate) fn check_step(dt: f64, shortest_period: f64) -> Result<(), InvalidInput> {
    let mut check = Checker::new();
    check.require(
        dt < 0.5 * shortest_period,
        "dt",
        format_args!(
            "{} s for a load or a base motion with a period of {} s",
            Number(dt),
            Number(shortest_period)
        ),
        "less than half a period (a twentieth follows it)",
    );
    check.finish()
}

/// A motion must end before the model is no longer known.
fn check_span(known: [f64; 2], (t0, t_end): (f64, f64)) -> Result<(), InvalidInput> {
    let starts = covers(known, t0);
    if !starts || !covers(known, t_end) {
        let [from, to] = known;
        let expected = format!("a run within [{from}, {to}] (seconds), where all prescribed motion is known");
        let place = if starts { "t_span[1]" } else { "t_span[0]" };
        return Err(InvalidInput::new(place, format_args!("a run from {t0} to {t_end}"), expected));
    }
    Ok(())
}

impl Method {
    /// Size of fixed steps, or distance of output times.
    fn dt(&self) -> f64 {
        match self {
            Self::Newmark(options) => options.dt,
            Self::Radau { dt, .. } | Self::FirstOrder { dt, .. } => *dt,
        }
    }
}

/// Why a run is ended although its method could go on.
struct Stop {
    status: Status,
    message: String,
}

impl Stop {
    fn where_flawed<M: Model + ?Sized>(model: &mut M, t: f64, q: &[f64]) -> Option<Self> {
        let flaw = model.flaw(q)?;
        let (status, cure) = match flaw {
            Flaw::Unresolved { shortage } => (
                Status::Unresolved,
                format!("; if that ends here too, give the segment more `nodes`{}", at_least(shortage)),
            ),
            Flaw::Inverted { .. } => (
                Status::Inverted,
                "; if that ends here too, linear elasticity in the stretch does not hold".to_owned(),
            ),
        };
        let message = format!(
            "At t = {} the rod {flaw}: the last state says nothing about the motion. Take shorter steps{cure}.",
            Number(t),
        );
        Some(Self { status, message })
    }
}

/// Looks at an explicit run now and then: whether stability limits its steps, and how many it would still take.
struct StiffnessWatch {
    limit: f64,
    allowed: usize,
    /// Accepted steps and time of the last look, and accepted steps of the next one.
    last: (usize, f64),
    next: usize,
}

impl StiffnessWatch {
    fn new(options: &ode::Options, t0: f64) -> Option<Self> {
        let limit = ode::stability_limit(options.method)?;
        let allowed = if options.max_steps == usize::MAX { STIFF_STEPS } else { options.max_steps };
        Some(Self { limit, allowed, last: (0, t0), next: FIRST_LOOK })
    }

    fn look<M: Model>(&mut self, model: &mut M, stepper: &ode::Stepper) -> Option<Stop> {
        let (t, accepted) = (stepper.t(), stepper.counters().accepted);
        if accepted < self.next {
            return None;
        }
        let step = (t - self.last.1) / (accepted - self.last.0) as f64;
        self.last = (accepted, t);
        self.next = 2 * accepted;
        let left = ((stepper.t_end() - t) / step).ceil();
        if accepted as f64 + left <= self.allowed as f64 {
            return None;
        }
        let (q, v) = stepper.y().split_at(model.n());
        let spectrum = Spectrum::new(model, t, q, v)?;
        let rate = spectrum.rate();
        let visible = spectrum.highest_visible(model, q, VISIBLE * model.length());
        if step * rate < LIMITED * self.limit || rate < MANY_TIMES * visible {
            return None;
        }
        let message = format!(
            "The model is stiff: its largest rate at t = {t:.1e} s, {rate:.1e} per second, limits explicit steps to {:.1e} s, whatever the \
             accuracy, and the rest of the time would take about {left:.0} of them. Use method \"radau\", which no rate limits, or \
             \"auto\"; or allow that many `max_steps`.",
            self.limit / rate
        );
        Some(Stop { status: Status::Stiff, message })
    }
}

fn measure<M: Model>(
    meter: &mut Option<FlowMeter<'_>>,
    system: &mut FreeMotion<'_, M>,
    state: State<'_>,
) -> Result<(), Interrupted> {
    match meter {
        Some(meter) => meter.step(system.0, state),
        None => Ok(()),
    }
}

impl Simulation {
    fn new(solution: second_order::Solution, meter: Option<FlowMeter<'_>>) -> Self {
        let second_order::Solution { t, q, v, a, n, counters, status, message } = solution;
        let flow = meter.map_or_else(Flow::default, |meter| meter.into_flow(t.len()));
        let statistics = Statistics { counters, ..Statistics::default() };
        Self {
            t,
            q,
            v,
            a: Some(a),
            n,
            flow,
            statistics,
            status: Status::SecondOrder(status),
            message,
            doubt: None,
        }
    }
}

impl Simulation {
    /// The same with no rotation vector longer than pi.
    fn wrapped<M: Model + ?Sized>(mut self, model: &M) -> Self {
        let first = model.rotation_vectors();
        if first.is_empty() || self.n == 0 {
            return self;
        }
        let states = self.q.chunks_exact_mut(self.n).zip(self.v.chunks_exact_mut(self.n));
        let mut accelerations = self.a.as_mut().map(|a| a.chunks_exact_mut(self.n));
        for (q, v) in states {
            match accelerations.as_mut().and_then(Iterator::next) {
                Some(a) => _ = rotation_vectors::wrap(first, q, v, &mut [a]),
                None => _ = rotation_vectors::wrap(first, q, v, &mut []),
            }
        }
        self
    }

    /// Names what of the model was not finite where this run ended early.
    fn because(mut self, not_finite: Option<String>) -> Self {
        if let Some(what) = not_finite.filter(|_| !self.status.is_success()) {
            self.message.push_str(&format!(" The cause: {what}."));
        }
        self
    }
}

impl From<second_order::Solution> for Simulation {
    /// A motion whose model, and so whose flow of energy, is not known.
    fn from(solution: second_order::Solution) -> Self {
        Self::new(solution, None)
    }
}

fn first_order<M: Model + Clone>(
    model: M,
    t_span: (f64, f64),
    [q0, v0]: [&[f64]; 2],
    (options, dt): (&ode::Options, f64),
    t_eval: Option<&[f64]>,
    stop: &mut Option<Stop>,
    monitor: &mut dyn FnMut(f64) -> Result<(), Interrupted>,
) -> Result<Simulation, InvalidInput> {
    let n = model.n();
    let output = Output::at(match t_eval {
        Some(times) => times.to_vec(),
        None => grid(n, t_span, dt)?,
    });
    let mut observed = model.clone();
    let output_times = output.t_eval.clone();
    let mut meter = FlowMeter::new(&mut observed, Rule::Quintic, t_span.0, [q0, v0], output_times.as_deref());
    let mut watch = StiffnessWatch::new(options, t_span.0);
    let mut system = FirstOrder::new(model);
    let y0 = [q0, v0].concat();
    let mut monitor = |stepper: &ode::Stepper| {
        let ((q, v), a) = (stepper.y().split_at(n), &stepper.rate()[n..]);
        if let Some(meter) = &mut meter {
            meter.step(&mut observed, State { t: stepper.t(), q, v, a })?;
        }
        *stop = Stop::where_flawed(&mut observed, stepper.t(), q);
        if stop.is_none() {
            *stop = watch.as_mut().and_then(|watch| watch.look(&mut observed, stepper));
        }
        if stop.is_some() { Err(Interrupted) } else { monitor(stepper.t()) }
    };
    let solution = ode::solve(&mut system, t_span, &y0, options, &output, &mut [], &mut monitor)?;
    let points = solution.t.len();
    let mut states = [(); 2].map(|()| Vec::with_capacity(points * n));
    for y in (0..points).map(|i| solution.state(i)) {
        let (q, v) = y.split_at(n);
        states[0].extend_from_slice(q);
        states[1].extend_from_slice(v);
    }
    let [q, v] = states;
    let ode::Counters { accepted, rejected, nfev, nfev_jacobian, njev, nlu, .. } = solution.counters;
    let counters = second_order::Counters {
        steps: accepted,
        rejected,
        nfev,
        nfev_jacobian,
        njev,
        nlu,
        ..second_order::Counters::default()
    };
    let statistics = Statistics { counters, ..Statistics::default() };
    let status = Status::FirstOrder(solution.status);
    let flow = meter.map_or_else(Flow::default, |meter| meter.into_flow(points));
    let message = solution.message;
    let simulation =
        Simulation { t: solution.t, q, v, a: None, n, flow, statistics, status, message, doubt: None };
    let model = system.model();
    Ok(simulation.wrapped(model).because(model.not_finite()))
}

/// Accelerations of the free motion at these times and states, n numbers each; NaN where the mass matrix is singular.
pub(crate) fn accelerations<M: Model + ?Sized>(
    model: &mut M,
    t: &[f64],
    q: &[f64],
    v: &[f64],
) -> Result<Vec<f64>, Interrupted> {
    let n = model.n();
    let mut scratch = ForwardScratch::new(n);
    let mut a = vec![0.0; t.len() * n];
    for (i, &t) in t.iter().enumerate() {
        let here = i * n..(i + 1) * n;
        model.set_time(t)?;
        if model
            .forward_dynamics(&q[here.clone()], &v[here.clone()], &mut a[here.clone()], &mut scratch)
            .is_err()
        {
            a[here].fill(f64::NAN);
        }
    }
    Ok(a)
}

/// The times `t0`, `t0 + dt`, `t0 + 2 dt`, ... and `t_end`.
pub(crate) fn grid(n: usize, (t0, t_end): (f64, f64), dt: f64) -> Result<Vec<f64>, InvalidInput> {
    let steps = number_of_steps(t_end - t0, dt);
    check_points(steps.saturating_add(1), n)?;
    let mut times: Vec<f64> = (0..steps).map(|i| t0 + i as f64 * dt).collect();
    times.push(t_end);
    Ok(times)
}
