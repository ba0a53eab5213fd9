//! Integration over an interval, with the states that are asked for on the way.

use super::options::{Options, StepSize};
use super::stepper::Stepper;
use super::{Counters, Status, System};
use crate::error::{Checker, Interrupted, InvalidInput, Number};

/// A motion and how it came about. What was computed before a failure or an interruption is kept.
#[derive(Clone, Debug)]
pub struct Solution {
    /// Times: those asked for as far as they were reached, or the start and all accepted steps.
    pub t: Vec<f64>,
    /// Displacements at these times one after the other, n numbers each.
    pub q: Vec<f64>,
    /// Velocities, likewise.
    pub v: Vec<f64>,
    /// Accelerations, likewise.
    pub a: Vec<f64>,
    /// Number of coordinates n.
    pub n: usize,
    /// What it has cost.
    pub counters: Counters,
    /// How it ended.
    pub status: Status,
    /// The status in words, with what to change when it is not the wanted one.
    pub message: String,
}

/// Largest memory for the states of a result, in bytes (4 GiB): beyond it a slip in the step size is likelier than a wish.
const LARGEST_RESULT: usize = 1 << 32;

fn points_in_memory(n: usize) -> usize {
    LARGEST_RESULT / (size_of::<f64>() * (1 + 3 * n))
}

/// Refuses results of more states than fit in memory.
pub(crate) fn check_points(points: usize, n: usize) -> Result<(), InvalidInput> {
    let most = points_in_memory(n);
    if points <= most {
        return Ok(());
    }
    let expected = format!(
        "at most {most} ({} GiB for {n} coordinates): increase `dt`, or ask for fewer times with `t_eval`",
        LARGEST_RESULT >> 30
    );
    Err(InvalidInput::new("number of output times", points, expected))
}

/// Integrates the equations of motion over `t_span` from displacements `q0` and velocities `v0`. `t_eval` are increasing
/// times at which the motion is wanted, all steps if `None`. `monitor` sees the system and the stepper after every accepted
/// step and may stop the integration, as may the system; the status is then [`Status::Interrupted`].
///
/// Fails before any evaluation when an argument is wrong. Cost: see [`Counters`]; memory: `1 + 3 n` numbers for every
/// point of the output.
pub fn solve<S: System + ?Sized>(
    system: &mut S,
    t_span: (f64, f64),
    q0: &[f64],
    v0: &[f64],
    options: &Options,
    t_eval: Option<&[f64]>,
    monitor: &mut dyn FnMut(&mut S, &Stepper) -> Result<(), Interrupted>,
) -> Result<Solution, InvalidInput> {
    let n = system.n();
    let mut options = options.clone();
    if t_eval.is_none() && options.step_size != StepSize::Fixed {
        options.max_steps = options.max_steps.min(points_in_memory(n));
    }
    let mut stepper = Stepper::new(n, t_span, q0, v0, &options)?;
    let points = match t_eval {
        Some(times) => {
            check_times(times, t_span)?;
            times.len()
        }
        None if options.step_size == StepSize::Fixed => stepper.fixed_steps().saturating_add(1),
        None => 1,
    };
    check_points(points, n)?;
    let mut recorder = Recorder::new(n, points, t_eval);
    let status = run(system, &mut stepper, &mut recorder, monitor).unwrap_or(Status::Interrupted);
    Ok(Solution {
        t: recorder.t,
        q: recorder.q,
        v: recorder.v,
        a: recorder.a,
        n,
        counters: stepper.counters(),
        message: stepper.explain(status),
        status,
    })
}

fn run<S: System + ?Sized>(
    system: &mut S,
    stepper: &mut Stepper,
    recorder: &mut Recorder<'_>,
    monitor: &mut dyn FnMut(&mut S, &Stepper) -> Result<(), Interrupted>,
) -> Result<Status, Interrupted> {
    if let Some(status) = stepper.start(system)? {
        return Ok(status);
    }
    recorder.start(stepper);
    loop {
        let steps = stepper.counters().steps;
        let status = stepper.step(system)?;
        if stepper.counters().steps > steps {
            recorder.step(stepper);
            monitor(system, stepper)?;
        }
        if let Some(status) = status {
            return Ok(status);
        }
    }
}

fn check_times(times: &[f64], (t0, t_end): (f64, f64)) -> Result<(), InvalidInput> {
    let mut checker = Checker::new();
    let is_wrong = |i: usize| !(t0..=t_end).contains(&times[i]) || (i > 0 && times[i] <= times[i - 1]);
    if let Some(i) = (0..times.len()).find(|&i| is_wrong(i)) {
        let expected = format!("a time in t_span = [{}, {}] after the one before", Number(t0), Number(t_end));
        checker.require(false, &format!("t_eval[{i}]"), Number(times[i]), &expected);
    }
    checker.finish()
}

/// Collects the states that the caller asked for.
struct Recorder<'a> {
    t_eval: Option<&'a [f64]>,
    t: Vec<f64>,
    q: Vec<f64>,
    v: Vec<f64>,
    a: Vec<f64>,
}

impl<'a> Recorder<'a> {
    fn new(n: usize, points: usize, t_eval: Option<&'a [f64]>) -> Self {
        let states = || Vec::with_capacity(points * n);
        Self { t_eval, t: Vec::with_capacity(points), q: states(), v: states(), a: states() }
    }

    fn start(&mut self, stepper: &Stepper) {
        if self.t_eval.is_none_or(|times| times.first() == Some(&stepper.t())) {
            self.push(stepper);
        }
    }

    fn step(&mut self, stepper: &Stepper) {
        let Some(times) = self.t_eval else {
            return self.push(stepper);
        };
        while let Some(&t) = times.get(self.t.len())
            && t <= stepper.t()
        {
            self.t.push(t);
            let end = self.q.len();
            let n = stepper.q().len();
            for states in [&mut self.q, &mut self.v, &mut self.a] {
                states.resize(end + n, 0.0);
            }
            stepper.interpolate(t, &mut self.q[end..], &mut self.v[end..], &mut self.a[end..]);
        }
    }

    fn push(&mut self, stepper: &Stepper) {
        self.t.push(stepper.t());
        self.q.extend_from_slice(stepper.q());
        self.v.extend_from_slice(stepper.v());
        self.a.extend_from_slice(stepper.a());
    }
}
