//! Collection of requested states during a run.

use super::status::{Counters, Status};
use crate::error::{Checker, Interrupted, InvalidInput, Number};
use crate::numerics::memory;
use crate::numerics::memory::LARGEST_RESULT;

/// A motion with its status. States computed before a failure or an interruption are kept.
#[derive(Clone, Debug)]
pub struct Solution {
    /// Times: the requested ones that were reached, or the start and all accepted steps.
    pub t: Vec<f64>,
    /// Displacements at these times, n numbers each.
    pub q: Vec<f64>,
    /// Velocities at these times, n numbers each.
    pub v: Vec<f64>,
    /// Accelerations at these times, n numbers each.
    pub a: Vec<f64>,
    /// Number of coordinates n.
    pub n: usize,
    /// Counts of steps, iterations and evaluations.
    pub counters: Counters,
    /// Status.
    pub status: Status,
    /// Status in words, with advice unless the integration succeeded.
    pub message: String,
}

/// Maximum number of states of `n` coordinates in a result.
pub(crate) fn points_in_memory(n: usize) -> usize {
    memory::points_in_memory(n.saturating_mul(3).saturating_add(1))
}

/// Rejects results with more states than fit in memory.
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

/// An integration of second-order equations of motion that is carried out step by step.
pub(crate) trait Steps<S: ?Sized> {
    /// Solves for the accelerations at the start; `Some(status)` if that fails.
    fn start(&mut self, system: &mut S) -> Result<Option<Status>, Interrupted>;
    /// Makes one accepted step; `Some(status)` when the integration is over.
    fn step(&mut self, system: &mut S) -> Result<Option<Status>, Interrupted>;
    /// Current time.
    fn t(&self) -> f64;
    /// Current displacements, velocities and accelerations.
    fn state(&self) -> [&[f64]; 3];
    /// Interpolated state at a time within the last step.
    fn interpolate(&self, t: f64, q: &mut [f64], v: &mut [f64], a: &mut [f64]);
    /// Counts of steps, iterations and evaluations so far.
    fn counters(&self) -> Counters;
    /// A status in words.
    fn explain(&self, status: Status) -> String;
}

/// Implements the trait by inherent methods of the same names.
macro_rules! steps {
    ($stepper:ty) => {
        const _: () = {
            use $crate::error::Interrupted;
            use $crate::integrators::second_order::{Counters, SecondOrderSystem, Status, Steps};

            impl<S: SecondOrderSystem + ?Sized> Steps<S> for $stepper {
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
        };
    };
}
pub(crate) use steps;

/// Runs an integration of `n` coordinates to its end, with memory for `points` states.
pub(crate) fn collect<S: ?Sized, I: Steps<S>>(
    system: &mut S,
    stepper: &mut I,
    n: usize,
    points: usize,
    t_eval: Option<&[f64]>,
    monitor: &mut dyn FnMut(&mut S, &I) -> Result<(), Interrupted>,
) -> Solution {
    let mut recorder = Recorder::new(n, points, t_eval);
    let status = run(system, stepper, &mut recorder, monitor).unwrap_or(Status::Interrupted);
    Solution {
        t: recorder.t,
        q: recorder.q,
        v: recorder.v,
        a: recorder.a,
        n,
        counters: stepper.counters(),
        message: stepper.explain(status),
        status,
    }
}

fn run<S: ?Sized, I: Steps<S>>(
    system: &mut S,
    stepper: &mut I,
    recorder: &mut Recorder<'_>,
    monitor: &mut dyn FnMut(&mut S, &I) -> Result<(), Interrupted>,
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

pub(crate) fn check_times(times: &[f64], (t0, t_end): (f64, f64)) -> Result<(), InvalidInput> {
    let mut checker = Checker::new();
    let is_wrong = |i: usize| !(t0..=t_end).contains(&times[i]) || (i > 0 && times[i] <= times[i - 1]);
    if let Some(i) = (0..times.len()).find(|&i| is_wrong(i)) {
        let expected = format!("a time from {} to {}, after the one before", Number(t0), Number(t_end));
        checker.require(false, &format!("t_eval[{i}]"), Number(times[i]), &expected);
    }
    checker.finish()
}

/// Collects the requested states.
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

    fn start<S: ?Sized, I: Steps<S>>(&mut self, stepper: &I) {
        if self.t_eval.is_none_or(|times| times.first() == Some(&stepper.t())) {
            self.push(stepper);
        }
    }

    fn step<S: ?Sized, I: Steps<S>>(&mut self, stepper: &I) {
        let Some(times) = self.t_eval else {
            return self.push(stepper);
        };
        while let Some(&t) = times.get(self.t.len())
            && t <= stepper.t()
        {
            self.t.push(t);
            let end = self.q.len();
            let n = stepper.state()[0].len();
            for states in [&mut self.q, &mut self.v, &mut self.a] {
                states.resize(end + n, 0.0);
            }
            stepper.interpolate(t, &mut self.q[end..], &mut self.v[end..], &mut self.a[end..]);
        }
    }

    fn push<S: ?Sized, I: Steps<S>>(&mut self, stepper: &I) {
        self.t.push(stepper.t());
        for (states, values) in [&mut self.q, &mut self.v, &mut self.a].into_iter().zip(stepper.state()) {
            states.extend_from_slice(values);
        }
    }
}
