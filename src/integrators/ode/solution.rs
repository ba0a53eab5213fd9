//! Integration over an interval, with output times, events and dense output.

use super::FirstOrderSystem;
use super::dense::{DenseOutput, StepPolynomial};
use super::events::{Event, EventSearch};
use super::options::{Options, Output};
use super::state::Counters;
use super::status::Status;
use super::stepper::Stepper;
use crate::error::{Interrupted, InvalidInput};
use crate::numerics::memory;

/// A trajectory with its status. States computed before a failure or an interruption are kept.
#[derive(Clone, Debug)]
pub struct Solution {
    /// Times: the requested ones that were reached, or the start and all accepted steps.
    pub t: Vec<f64>,
    /// States at these times, n numbers each.
    pub y: Vec<f64>,
    /// Number of equations n.
    pub n: usize,
    /// Solution as a function of time, if requested and if a step was made.
    pub dense: Option<DenseOutput>,
    /// For every event function, the times and states of its events.
    pub events: Vec<Occurrences>,
    /// Counts of steps, iterations and evaluations.
    pub counters: Counters,
    /// Status.
    pub status: Status,
    /// Status in words, with advice unless the integration succeeded.
    pub message: String,
    /// Time at which the problem was found to be stiff for an explicit method, if it was.
    pub stiff_at: Option<f64>,
    /// Whether a relative tolerance was raised to 100 rounding units.
    pub rtol_raised: bool,
}

/// Occurrences of an event.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Occurrences {
    /// Times, in the order of the integration.
    pub t: Vec<f64>,
    /// States, n numbers each.
    pub y: Vec<f64>,
}

impl Solution {
    /// State at the point with this index.
    pub fn state(&self, index: usize) -> &[f64] {
        &self.y[index * self.n..(index + 1) * self.n]
    }
}

/// Integrates `system` over `t_span` from `y0`. `monitor` is called with the stepper after every accepted
/// step and may stop the integration, as may the system and the events; the status is then
/// [`Status::Interrupted`].
///
/// Fails before any evaluation if an argument is invalid. Cost: see [`Counters`]. Memory: n numbers for every
/// point of the output, and 4 (Radau), 5 (RK45) or 8 (DOP853) times that for every step with `output.dense`.
pub fn solve<S: FirstOrderSystem + ?Sized>(
    system: &mut S,
    t_span: (f64, f64),
    y0: &[f64],
    options: &Options,
    output: &Output,
    events: &mut [Event<'_>],
    monitor: &mut dyn FnMut(&Stepper) -> Result<(), Interrupted>,
) -> Result<Solution, InvalidInput> {
    let mut stepper = Stepper::new(system.n(), t_span, y0, options)?;
    output.check(t_span)?;
    let n = y0.len();
    if let Some(times) = &output.t_eval {
        let found = format_args!("{} times of {n} values", times.len());
        memory::check(times.len().saturating_mul(n), "t_eval", found, "ask for fewer times")?;
    }
    // Numbers added to the result per step.
    let of_state = if output.t_eval.is_none() { 1 + n } else { 0 };
    let of_polynomial = if output.dense { 1 + stepper.form().vectors() * n } else { 0 };
    if of_state + of_polynomial > 0 {
        stepper.limit_steps(memory::points_in_memory(of_state + of_polynomial));
    }
    let mut recorder = Recorder::new(&stepper, output, events.len());
    let status = run(system, &mut stepper, &mut recorder, events, monitor).unwrap_or(Status::Interrupted);
    Ok(Solution {
        t: recorder.t,
        y: recorder.y,
        n,
        dense: recorder.dense.filter(|dense| dense.times().len() > 1),
        events: recorder.events,
        counters: stepper.counters(),
        status,
        message: stepper.explain(status),
        stiff_at: stepper.stiff_at(),
        rtol_raised: stepper.rtol_raised(),
    })
}

fn run<S: FirstOrderSystem + ?Sized>(
    system: &mut S,
    stepper: &mut Stepper,
    recorder: &mut Recorder<'_>,
    events: &mut [Event<'_>],
    monitor: &mut dyn FnMut(&Stepper) -> Result<(), Interrupted>,
) -> Result<Status, Interrupted> {
    stepper.start(system)?;
    let mut search = EventSearch::new(events, recorder.output.event_samples, stepper.t(), stepper.y())?;
    loop {
        let finished = match stepper.step(system)? {
            None => false,
            Some(Status::Finished) => true,
            Some(failure) => return Ok(failure),
        };
        let mut end = stepper.t();
        let mut terminated = false;
        if !events.is_empty() && stepper.t() != stepper.t_old() {
            if !stepper.prepare_polynomial(system)? {
                return Ok(Status::NonFinite);
            }
            let polynomial = stepper.polynomial();
            let found = search.search(events, polynomial, stepper.y())?;
            for occurrence in found.occurrences {
                recorder.occurrence(occurrence.event, occurrence.t, polynomial);
            }
            if let (true, Some(last)) = (found.terminal, found.occurrences.last()) {
                end = last.t;
                terminated = true;
            }
        }
        if !recorder.step(system, stepper, end)? {
            return Ok(Status::NonFinite);
        }
        monitor(stepper)?;
        if terminated {
            return Ok(Status::Event);
        }
        if finished {
            return Ok(Status::Finished);
        }
    }
}

/// Collects the requested output.
struct Recorder<'a> {
    output: &'a Output,
    // Index of the next time of `output.t_eval`.
    next: usize,
    t: Vec<f64>,
    y: Vec<f64>,
    dense: Option<DenseOutput>,
    events: Vec<Occurrences>,
    scratch: Vec<f64>,
}

impl<'a> Recorder<'a> {
    fn new(stepper: &Stepper, output: &'a Output, events: usize) -> Self {
        let n = stepper.y().len();
        let mut recorder = Self {
            output,
            next: 0,
            t: Vec::new(),
            y: Vec::new(),
            dense: output.dense.then(|| DenseOutput::new(stepper.form(), n, stepper.t())),
            events: vec![Occurrences::default(); events],
            scratch: vec![0.0; n],
        };
        match &output.t_eval {
            None => recorder.push(stepper.t(), stepper.y()),
            Some(times) => {
                recorder.t.reserve_exact(times.len());
                recorder.y.reserve_exact(times.len() * n);
            }
        }
        recorder
    }

    fn push(&mut self, t: f64, y: &[f64]) {
        self.t.push(t);
        self.y.extend_from_slice(y);
    }

    fn push_between(&mut self, t: f64, polynomial: StepPolynomial<'_>) {
        polynomial.evaluate(t, &mut self.scratch);
        self.t.push(t);
        self.y.extend_from_slice(&self.scratch);
    }

    fn occurrence(&mut self, event: usize, t: f64, polynomial: StepPolynomial<'_>) {
        polynomial.evaluate(t, &mut self.scratch);
        let occurrences = &mut self.events[event];
        occurrences.t.push(t);
        occurrences.y.extend_from_slice(&self.scratch);
    }

    /// Records the last step up to `end`, which differs from the end of the step if an event ends the
    /// integration. Returns false if interpolated values are not finite.
    fn step<S: FirstOrderSystem + ?Sized>(
        &mut self,
        system: &mut S,
        stepper: &mut Stepper,
        end: f64,
    ) -> Result<bool, Interrupted> {
        let is_empty = end == stepper.t_old() && end != stepper.t();
        if !is_empty && let Some(dense) = &mut self.dense {
            if !stepper.prepare_polynomial(system)? {
                return Ok(false);
            }
            dense.push(end, stepper.polynomial());
        }
        let Some(times) = &self.output.t_eval else {
            if end == stepper.t() {
                self.push(end, stepper.y());
            } else if !is_empty {
                self.push_between(end, stepper.polynomial());
            }
            return Ok(true);
        };
        while let Some(&t) = times.get(self.next)
            && stepper.direction() * (t - end) <= 0.0
        {
            self.next += 1;
            if t == stepper.t() {
                self.push(t, stepper.y());
            } else {
                if !stepper.prepare_polynomial(system)? {
                    return Ok(false);
                }
                self.push_between(t, stepper.polynomial());
            }
        }
        Ok(true)
    }
}
