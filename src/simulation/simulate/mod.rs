//! Motions of models over an interval, by the implicit Newmark family, Radau IIA or an explicit Runge-Kutta method.
//!
//! ```
//! use lissom::newmark;
//! use lissom::robot::{Rod, RobotModel};
//! use lissom::rod::Segment;
//! use lissom::simulate::{Method, simulate};
//!
//! let segment = Segment { modes: [0, 3, 0, 0, 0, 0], ..Segment::straight(1.0, 1e-3, 210e9, 80e9, 7800.0) };
//! let wire = RobotModel::of_rod(&Rod::new(vec![segment]))?;
//! let method = Method::Newmark(newmark::Options::new(1e-2));
//! let motion = simulate(wire, (0.0, 0.1), &[0.0; 3], &[0.0; 3], &method, None, &mut |_| Ok(()))?;
//! assert_eq!(motion.t.len(), 11);
//! # Ok::<(), lissom::error::InvalidInput>(())
//! ```

mod control;
mod creep;
mod growth_errors;
mod hard_steps;
mod overloads;
mod recorder;
mod runner;
mod slackness;
mod watch;

use std::time::Instant;

use self::recorder::Recorder;
use self::runner::Runner;

use crate::description::signal::Cell;
use crate::error::{Checker, Interrupted, InvalidInput, Number};
use crate::integrators::newmark;
use crate::integrators::newmark::StepSize;
use crate::integrators::second_order;
use crate::integrators::second_order::{
    Grid, check_points, check_times, is_whole, number_of_steps, points_in_memory,
};
use crate::model::{ForwardScratch, Model, Overlap, rotation_vectors};
use crate::simulation::balance::{Balance, Flow};
use crate::simulation::stepping::Run;

pub use self::control::{Control, Inputs};
pub use self::creep::{creep, has_friction};
pub(crate) use self::growth_errors::unstable_equilibrium;
pub use self::hard_steps::HardStep;
pub use self::overloads::add_overloads;
pub use self::slackness::{Slack, slackness};
pub use crate::integrators::Reason;
pub use crate::simulation::stepping::{Method, Status};

use crate::simulation::stepping::check_span;

/// The cost of a run. Counters that do not apply to the method are zero.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Statistics {
    /// Wall-clock time of the run, in seconds.
    pub wall_time: f64,
    /// Estimated error of the tip due to time steps, relative to the model's length; only for runs to an
    /// accuracy.
    pub time_error: Option<f64>,
    /// Estimated error of the tip due to the number of modes and nodes, relative to the model's length; only
    /// for runs to an accuracy of models with modes.
    pub space_error: Option<f64>,
    /// Counters. For first-order methods, `nfev` counts forward dynamics.
    pub counters: second_order::Counters,
}

/// A computed motion with its status. States computed before a failure or an interruption are kept.
#[derive(Clone, Debug)]
pub struct Simulation {
    /// Times: the requested ones that were reached; otherwise those of all steps, or a grid ([`Method`]).
    pub t: Vec<f64>,
    /// Coordinates at these times, n numbers each.
    pub q: Vec<f64>,
    /// Velocities at these times, n numbers each.
    pub v: Vec<f64>,
    /// Accelerations at these times; `None` if the method does not solve for them: use
    /// [`Self::accelerations`].
    pub a: Option<Vec<f64>>,
    /// Inputs from each of these times on, one number for each input of the model.
    pub u: Vec<f64>,
    /// Number of coordinates n.
    pub n: usize,
    /// Evaluations of the residual up to each of these times, of explicit methods those of the forward dynamics; empty without a model.
    pub evaluations: Vec<usize>,
    /// The steps that were attempted more than once or converged slowly; empty without a model.
    pub hard_steps: Vec<HardStep>,
    /// Energy flow out of and into the motion up to each time, integrated along the run.
    pub flow: Flow,
    /// Counts of steps, iterations and evaluations.
    pub statistics: Statistics,
    /// Status.
    pub status: Status,
    /// Status in words, with advice unless the run succeeded.
    pub message: String,
    /// Reason why the motion may be inaccurate although the method succeeded; the message ends with it.
    pub doubt: Option<String>,
    /// The overlap with the largest share at the ends of steps, with its time; `None` if nothing touched.
    pub deepest: Option<(f64, Overlap)>,
    /// What touches and holds where a run ended that has not failed, in sentences, for a limit of time.
    pub(crate) held: String,
}

impl Simulation {
    /// Accelerations of this motion of `model`: those of the run, or from one forward dynamics per time.
    pub fn accelerations<M: Model + ?Sized>(&self, model: &mut M) -> Result<Vec<f64>, Interrupted> {
        match &self.a {
            Some(a) => Ok(a.clone()),
            None => accelerations(model, &self.t, &self.q, &self.v, &self.u),
        }
    }

    /// Every `number`-th state of this motion, and the last one.
    pub(crate) fn every(&self, number: usize) -> Self {
        let last = self.t.len().saturating_sub(1);
        let is_kept = |i: &usize| i.is_multiple_of(number) || *i == last;
        let times: Vec<f64> = (0..self.t.len()).filter(is_kept).map(|i| self.t[i]).collect();
        let mut few = self.clone();
        few.keep(&times);
        few
    }

    /// Keeps only these increasing times; a run that ended early has the first of them.
    pub(crate) fn keep(&mut self, times: &[f64]) {
        let is_kept: Vec<bool> =
            self.t.iter().map(|t| times.binary_search_by(|time| time.total_cmp(t)).is_ok()).collect();
        let n = self.n;
        let inputs = self.u.len() / self.t.len().max(1);
        let keep = |values: &mut Vec<f64>, n: usize| {
            let mut of_all = is_kept.iter().flat_map(|&is_kept| std::iter::repeat_n(is_kept, n));
            values.retain(|_| of_all.next() == Some(true));
        };
        for values in [&mut self.q, &mut self.v].into_iter().chain(&mut self.a) {
            keep(values, n);
        }
        keep(&mut self.u, inputs);
        let mut are_kept = is_kept.iter();
        self.evaluations.retain(|_| are_kept.next() == Some(&true));
        for values in [&mut self.t, &mut self.flow.dissipated, &mut self.flow.work] {
            keep(values, 1);
        }
    }

    /// Energy balance of this motion of `model`. Evaluates the energy once per time.
    pub fn balance<M: Model + ?Sized>(&self, model: &mut M) -> Result<Balance, Interrupted> {
        Balance::new(model, &self.t, &self.q, &self.v, &self.u, &self.flow)
    }
}

/// Steps per period of the excitation for models without free coordinates: the trapezoidal rule is then
/// accurate to 1e-3.
const STEPS_OF_A_PERIOD: f64 = 100.0;

/// Computes the free motion of `model` from `q0`, `v0` over `t_span`. `t_eval` are the increasing times of
/// the result. `monitor` is called with the time after every accepted step, and with that of its start within a step of many
/// evaluations. It may stop the run; the status then says so. Inputs keep their defaults.
///
/// Fails before any evaluation if an argument is invalid, if the model does not resolve `q0`, or if the
/// result would not fit in memory.
pub fn simulate<M: Model>(
    model: M,
    t_span: (f64, f64),
    q0: &[f64],
    v0: &[f64],
    method: &Method,
    t_eval: Option<&[f64]>,
    monitor: &mut dyn FnMut(f64) -> Result<(), Interrupted>,
) -> Result<Simulation, InvalidInput> {
    let arguments = Arguments { t_span, q0, v0, method, t_eval, judges_growth: true };
    arguments.run(model, None, monitor)
}

/// Like [`simulate`], of steps that are known to follow what grows, with inputs that are set every so many seconds if given.
pub(crate) fn simulate_as_chosen<M: Model>(
    model: M,
    t_span: (f64, f64),
    [q0, v0]: [&[f64]; 2],
    method: &Method,
    t_eval: Option<&[f64]>,
    control: Option<(f64, &mut Inputs<'_>)>,
    monitor: &mut dyn FnMut(f64) -> Result<(), Interrupted>,
) -> Result<Simulation, InvalidInput> {
    let arguments = Arguments { t_span, q0, v0, method, t_eval, judges_growth: false };
    arguments.run(model, control.map(|(step, inputs)| Control { step, inputs }), monitor)
}

/// Like [`simulate`], with inputs set by `control`. Steps end at the times of the controller: a method with
/// fixed steps divides the interval into equal steps of at most `dt`. Work is computed with constant inputs
/// in between; jumps of the energy with the inputs count as work too.
#[allow(clippy::too_many_arguments, reason = "those of `simulate`, and one")]
pub fn simulate_controlled<M: Model>(
    model: M,
    t_span: (f64, f64),
    q0: &[f64],
    v0: &[f64],
    method: &Method,
    t_eval: Option<&[f64]>,
    control: Control<'_>,
    monitor: &mut dyn FnMut(f64) -> Result<(), Interrupted>,
) -> Result<Simulation, InvalidInput> {
    // Controllers hold what grows by itself.
    let arguments = Arguments { t_span, q0, v0, method, t_eval, judges_growth: false };
    arguments.run(model, Some(control), monitor)
}

/// Arguments of a run.
struct Arguments<'a> {
    t_span: (f64, f64),
    q0: &'a [f64],
    v0: &'a [f64],
    method: &'a Method,
    t_eval: Option<&'a [f64]>,
    /// Whether a doubt says where steps do not follow what grows from the start.
    judges_growth: bool,
}

/// A validated run before its start.
struct Prepared<M> {
    run: Run<M>,
    method: Method,
    times: Option<Vec<f64>>,
    points: usize,
}

impl Arguments<'_> {
    /// Rejects invalid arguments before any evaluation of a motion.
    fn prepare<M: Model>(&self, model: M, control_step: Option<f64>) -> Result<Prepared<M>, InvalidInput> {
        let &Self { t_span, q0, v0, method, t_eval, .. } = self;
        let n = model.facts().n;
        second_order::check_start(n, t_span, q0, v0, method.dt())?;
        if let Some(step) = control_step {
            check_control(step, t_span)?;
        }
        let times = match (t_eval, method) {
            (Some(times), _) => Some(times.to_vec()),
            // Steps of fixed size also end where tendons become slack or taut.
            (None, method) if method.fixed_step().is_some() && model.facts().is_one_sided => {
                times_of_run(n, t_span, method, None, control_step, &|cell| model.corner(cell))?
            }
            (None, method) if method.returns_steps() => None,
            (None, _) => Some(grid(n, t_span, method.dt())?),
        };
        if let Some(times) = &times {
            check_times(times, t_span)?;
        }
        let points = match (&times, method.fixed_step()) {
            (Some(times), _) => times.len(),
            (None, Some(dt)) => all_steps(t_span, dt, control_step).saturating_add(1),
            (None, None) => 1,
        };
        check_points(points, n)?;
        let mut method = if n == 0 { by_steps(&model, method) } else { method.clone() };
        if times.is_none() {
            limit_steps(&mut method, n);
        }
        check_span(model.facts().time_span, t_span)?;
        let first_interval = match control_step {
            // The first step of an adaptive method depends on the length of the first interval; choose it as in a
            // run stepped from outside.
            Some(_) => (t_span.0, t_span.1.min(t_span.0 + method.dt())),
            None => t_span,
        };
        let run = Run::new(model, first_interval, q0, v0, &method)?;
        Ok(Prepared { run, method, times, points })
    }

    fn run<M: Model>(
        self,
        model: M,
        control: Option<Control<'_>>,
        monitor: &mut dyn FnMut(f64) -> Result<(), Interrupted>,
    ) -> Result<Simulation, InvalidInput> {
        let start = Instant::now();
        let control_step = control.as_ref().map(|control| control.step);
        let Prepared { run, method, times, points } = self.prepare(model, control_step)?;
        let Self { t_span, q0, judges_growth, .. } = self;
        let recorder = Recorder::new(&run, points, times.as_deref());
        let mut runner = Runner::new(run, recorder, t_span, control, judges_growth);
        let status = runner.finish(&method, times.as_deref(), monitor);
        let mut simulation = Simulation::of(runner, status, q0);
        simulation.statistics.wall_time = start.elapsed().as_secs_f64();
        Ok(simulation)
    }
}

/// Rejects all arguments that [`simulate`] or, with a control step, [`simulate_controlled`] would reject.
pub fn check<M: Model>(
    model: M,
    t_span: (f64, f64),
    q0: &[f64],
    v0: &[f64],
    method: &Method,
    t_eval: Option<&[f64]>,
    control_step: Option<f64>,
) -> Result<(), InvalidInput> {
    let arguments = Arguments { t_span, q0, v0, method, t_eval, judges_growth: false };
    arguments.prepare(model, control_step).map(|_| ())
}

/// Times of the result of a complete run of a model with `n` coordinates, with inputs set every
/// `control_step` if given: the requested times, the grid of a method, or the ends of fixed steps. `None` if
/// the method chooses its steps and returns all of them. `corner` gives the times at which steps of fixed size must end
/// ([`Excitation::corner`](crate::model::Excitation::corner)).
///
/// The arguments must be valid; see [`check`].
pub fn times_of_run(
    n: usize,
    t_span: (f64, f64),
    method: &Method,
    t_eval: Option<&[f64]>,
    control_step: Option<f64>,
    corner: &dyn Fn(Cell) -> Option<f64>,
) -> Result<Option<Vec<f64>>, InvalidInput> {
    if let Some(times) = t_eval {
        return Ok(Some(times.to_vec()));
    }
    if !method.returns_steps() {
        return grid(n, t_span, method.dt()).map(Some);
    }
    let (Some(dt), (mut t, t_end)) = (method.fixed_step(), t_span) else { return Ok(None) };
    let intervals = control_step.map_or(1, |step| number_of_steps(t_end - t, step).max(1));
    let mut times = vec![t];
    // Grids of the integrator and of the ends of intervals, as in `Run::end_of`.
    let (mut steps, mut ends) = (Grid::new(t, dt), Grid::new(t, dt));
    for interval in 1..=intervals {
        let (end, last) = match control_step {
            Some(step) => {
                ends = ends.at(t).unwrap_or_else(|| Grid::new(t, dt));
                let whole = number_of_steps(step, dt);
                let end = if is_whole(step, whole, dt) { ends.after(whole) } else { t + step };
                let end = Cell { start: end - dt, t: end - dt, end }.end_at_corner(corner);
                let end = if interval == intervals { t_end } else { end };
                (end, steps.begin_interval(t, end, dt))
            }
            None => (t_end, number_of_steps(t_end - t, dt)),
        };
        while t < end {
            let (step_end, _, is_on_grid) = steps.step_to_corner(last, (t, end), corner);
            t = step_end;
            if is_on_grid {
                steps.count();
            }
            times.push(t);
        }
    }
    Ok(Some(times))
}

/// Number of steps of a run with steps of at most this size.
fn all_steps((t0, t_end): (f64, f64), dt: f64, control_step: Option<f64>) -> usize {
    match control_step {
        Some(step) => number_of_steps(t_end - t0, step).saturating_mul(number_of_steps(step, dt)),
        None => number_of_steps(t_end - t0, dt),
    }
}

/// Without free coordinates there is no error estimate to choose steps; fixed steps resolve the excitation
/// and its work.
fn by_steps<M: Model>(model: &M, method: &Method) -> Method {
    match method {
        Method::Newmark(_) => method.clone(),
        _ => Method::Newmark(newmark::Options::new(
            method.dt().min(model.facts().shortest_period / STEPS_OF_A_PERIOD),
        )),
    }
}

/// Limits the number of steps to what fits into a result with all steps.
fn limit_steps(method: &mut Method, n: usize) {
    let max_steps = match method {
        Method::Newmark(options) if options.step_size == StepSize::Fixed => return,
        Method::Newmark(options) => &mut options.max_steps,
        Method::Radau { options, .. } => &mut options.max_steps,
        Method::FirstOrder { options, .. } => &mut options.max_steps,
    };
    *max_steps = points_in_memory(n).min(*max_steps);
}

pub(crate) fn check_control(step: f64, (t0, t_end): (f64, f64)) -> Result<(), InvalidInput> {
    let mut check = Checker::new();
    if check.positive(step, "control_step", "seconds") {
        let is_visible = t_end == t0 || t0 + step > t0 && t_end - step < t_end;
        let expected = "a step that rounding of the time does not swallow";
        check.require(is_visible, "control_step", Number(step), expected);
    }
    check.finish()
}

impl Simulation {
    /// Adds a doubt about a run that has succeeded, also to its message.
    pub fn add_doubt(&mut self, doubt: &str) {
        if !self.status.is_success() {
            return;
        }
        self.message = format!("{} {doubt}", self.message);
        self.doubt =
            Some(self.doubt.take().map_or_else(|| doubt.to_owned(), |known| format!("{known} {doubt}")));
    }

    /// Final state and records of a run.
    fn of<M: Model>(runner: Runner<'_, '_, M>, status: Status, q0: &[f64]) -> Self {
        let Runner { mut run, recorder, meter, watch, growth_errors, stop, deepest, hard_steps, .. } = runner;
        let Recorder { t, q, v, a, u, evaluations, .. } = recorder;
        let flow = meter.map_or_else(Flow::default, |meter| meter.into_flow(t.len()));
        let mut message = stop.map_or_else(|| run.explain(status), |stop| stop.message);
        let is_success = status.is_success();
        let overlap = deepest.map(|(_, overlap)| overlap);
        message += &run.advice_at_end(status, overlap);
        // A trial that has finished may be the last one that a limit of time leaves.
        let held = if is_success || status.is_interrupted() {
            run.advice_where_it_ends(overlap)
        } else {
            String::new()
        };
        let doubt = if is_success {
            // Both checks may have found a problem.
            let of_vibrations = run.observe(|model, _| watch.doubt(model, q0));
            let of_steps = run.doubt();
            // Of what is doubted already nothing more is known from the start.
            let of_growth =
                growth_errors.filter(|_| of_steps.is_none()).and_then(|growth_errors| growth_errors.doubt());
            let doubts: Vec<_> = of_steps.into_iter().chain(of_vibrations).chain(of_growth).collect();
            (!doubts.is_empty()).then(|| doubts.join(" "))
        } else {
            None
        };
        if let Some(doubt) = &doubt {
            message = format!("{message} {doubt}");
        }
        let simulation = Self {
            t,
            q,
            v,
            a: run.knows_accelerations().then_some(a),
            u,
            n: q0.len(),
            evaluations,
            hard_steps: hard_steps.found,
            flow,
            statistics: Statistics { counters: run.counters(), ..Statistics::default() },
            status,
            message,
            doubt,
            deepest,
            held,
        };
        run.observe(|model, _| simulation.wrapped(model))
    }
}

impl Simulation {
    /// The same motion with all rotation vectors no longer than pi.
    fn wrapped<M: Model + ?Sized>(mut self, model: &M) -> Self {
        let first = &model.facts().rotation_vectors;
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
}

impl From<second_order::Solution> for Simulation {
    /// A motion without a model, and hence without energy flow.
    fn from(solution: second_order::Solution) -> Self {
        let second_order::Solution { t, q, v, a, n, counters, status, message } = solution;
        Self {
            t,
            q,
            v,
            a: Some(a),
            u: Vec::new(),
            n,
            evaluations: Vec::new(),
            hard_steps: Vec::new(),
            flow: Flow::default(),
            statistics: Statistics { counters, ..Statistics::default() },
            status: Status::SecondOrder(status),
            message,
            doubt: None,
            deepest: None,
            held: String::new(),
        }
    }
}

/// Accelerations of the free motion at these times and states, n numbers each; NaN if the mass matrix is
/// singular.
pub(crate) fn accelerations<M: Model + ?Sized>(
    model: &mut M,
    t: &[f64],
    q: &[f64],
    v: &[f64],
    u: &[f64],
) -> Result<Vec<f64>, Interrupted> {
    let n = model.facts().n;
    let inputs = u.len() / t.len().max(1);
    let mut scratch = ForwardScratch::new(n);
    let mut a = vec![0.0; t.len() * n];
    for (i, &t) in t.iter().enumerate() {
        let here = i * n..(i + 1) * n;
        if inputs > 0 {
            model.set_inputs(&u[i * inputs..][..inputs]);
        }
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

/// Times `t0`, `t0 + dt`, `t0 + 2 dt`, ... and `t_end`.
pub(crate) fn grid(n: usize, (t0, t_end): (f64, f64), dt: f64) -> Result<Vec<f64>, InvalidInput> {
    let steps = number_of_steps(t_end - t0, dt);
    check_points(steps.saturating_add(1), n)?;
    let mut times: Vec<f64> = (0..steps).map(|i| t0 + i as f64 * dt).collect();
    times.push(t_end);
    Ok(times)
}
