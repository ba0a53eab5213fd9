//! Motions with a controller: one run in closed loop, and its error by a finer run under the inputs that the controller gave.
//!
//! A controller may have a memory, such as the sum of an integrator. It is called once for each of its intervals, and never again from
//! the start. The finer run follows the motion that the controller saw. Controllers often hold what would fall without them: under their
//! inputs alone, small differences grow then, which the controller would have corrected. Where a difference has become a small part of
//! what was asked, the finer run therefore begins again from the state that the controller saw, and the differences add up. This is the
//! error of a loop that does not multiply errors. Inputs that never change correct nothing: the finer run then goes on to the end.

use super::inputs::{Given, Held, Recording, State};
use super::paths::{distances, largest};
use super::request::Request;
use super::run::{Motion, Plan, Run};
use super::space::{add_error, with_nodes};
use super::time::{SAFETY, SMALLEST_ERROR, conclude, longest_of_gain};
use crate::error::{Interrupted, InvalidInput};
use crate::model::Model;
use crate::simulation::simulate::{Inputs, Status};

/// Part of what was asked at which a difference is added up, and the finer run begins again. Growing differences of smaller parts would be
/// cut off before velocities have moved anything, larger ones would count growth that the controller corrects.
pub(super) const RESTARTED_PART: f64 = 0.02;

/// Tolerance of the run in closed loop over that of the finer one.
const FINER: f64 = 5.0;

/// The motion of a model in closed loop, and the model with the nodes that it takes.
pub(super) fn motion<M: Model + Clone>(
    model: &mut M,
    given: Given<'_>,
    request: Request,
    mut recording: Recording<'_>,
    monitor: &mut dyn FnMut(f64) -> Result<(), Interrupted>,
) -> Result<Motion, InvalidInput> {
    let (original, mut factor) = (model.clone(), 1);
    let (mut run, has_switched) = loop {
        let mut plan = Plan::new(model, given, request, None, monitor)?;
        let run = plan.closed_loop(&mut recording, monitor)?;
        let has_switched = plan.choice.has_switched;
        if run.is_success() {
            break (run, has_switched);
        }
        match with_nodes(&plan, &run, (&original, 2 * factor), monitor)? {
            Some(more_nodes) => {
                factor *= 2;
                *model = more_nodes;
            }
            None => return Ok(Motion { simulation: run.simulation, reason: plan.choice.reason, factor }),
        }
    };
    let Recording { held, states, .. } = recording;
    let mut plan = Plan::new(model, Given { held: Some(&held), ..given }, request, None, monitor)?;
    if has_switched {
        plan.choice.switch();
    }
    plan.follows(&run);
    add_time_error(&plan, &mut run, &states, monitor)?;
    if run.is_success() && request.space_error {
        add_error(&plan, &mut run, monitor)?;
    }
    Ok(Motion { simulation: run.simulation, reason: plan.choice.reason, factor })
}

/// Adds the estimated error to a run in closed loop, of which these are the states in which the controller was called.
fn add_time_error<M: Model + Clone>(
    plan: &Plan<'_, M>,
    run: &mut Run,
    states: &[State],
    monitor: &mut dyn FnMut(f64) -> Result<(), Interrupted>,
) -> Result<(), InvalidInput> {
    let wanted = plan.request.rtol;
    let Some(held) = plan.given.held else { return Ok(()) };
    // Where intervals limit all steps, those of the finer run end within them, too.
    let longest_step = longest_of_gain(plan, run.steps()).min(0.5 * held.step);
    let largest = if held.varies() { RESTARTED_PART * wanted } else { f64::INFINITY };
    let (mut first, mut together, mut parts) = (0, 0.0, 0);
    loop {
        let mut follower = Follower { held, first, states, largest, stopped_at: None };
        let found = follower.part(plan, run, longest_step, monitor)?;
        let Some(apart) = found else {
            match monitor(plan.given.t_span.1) {
                Err(Interrupted) => run.interrupt(),
                Ok(()) => unknown(run),
            }
            return Ok(());
        };
        together += apart;
        parts += 1;
        match follower.stopped_at {
            Some(state) if SAFETY * together <= wanted => first = state,
            _ => break,
        }
    }
    let missed =
        plan.following.error_of_steps(plan.choice.integrator, plan.duration() / run.steps().max(1.0));
    conclude(run, wanted, 2, SAFETY * together + missed + SMALLEST_ERROR * run.tolerance);
    let simulation = &mut run.simulation;
    if !simulation.status.is_success() {
        let error = simulation.statistics.time_error.unwrap_or(f64::NAN);
        simulation.message = format!(
            "The accuracy of {wanted:.0e} was not reached: the time error is at least {error:.0e} of the length. The controller is not \
             called a second time from the start: ask for a smaller `rtol`."
        );
    } else if parts > 1 {
        simulation.message.push_str(
            " It is the sum over parts of the motion, between which the controller does not multiply errors; under its inputs alone they \
             would grow.",
        );
    }
    Ok(())
}

fn unknown(run: &mut Run) {
    run.simulation.status = Status::AccuracyNotReached;
    run.simulation.message =
        "The time error is unknown: a finer run under the inputs of the controller ended early.".to_owned();
}

/// A finer run that follows a motion in closed loop from one of the states in which the controller was called.
struct Follower<'a> {
    held: &'a Held,
    first: usize,
    states: &'a [State],
    /// Difference, relative to the length, at which it stops.
    largest: f64,
    stopped_at: Option<usize>,
}

impl Follower<'_> {
    /// Follows to the end, or until the difference has become large, and returns the difference, relative to the length; `None` if it does
    /// not come that far.
    fn part<M: Model + Clone>(
        &mut self,
        plan: &Plan<'_, M>,
        run: &Run,
        longest_step: f64,
        monitor: &mut dyn FnMut(f64) -> Result<(), Interrupted>,
    ) -> Result<Option<f64>, InvalidInput> {
        let State { t, q, v } = &self.states[self.first];
        let times = &run.simulation.t;
        let begun = times.partition_point(|time| time < t);
        let given = Given {
            t_span: (*t, plan.given.t_span.1),
            start: [q, v],
            held: None,
            t_eval: Some(&times[begun..]),
        };
        let (choice, following) = (plan.choice.clone(), plan.following.clone());
        let part = Plan { choice, following, given, ..*plan };
        let step = self.held.step;
        let (mut interval, mut apart) = (self.first, 0.0_f64);
        let mut model = plan.model.clone();
        let mut inputs = |_: f64, q: &[f64], _: &[f64], inputs: &mut [f64]| {
            apart = apart.max(self.distance(&mut model, interval, q));
            if apart > self.largest {
                self.stopped_at = Some(interval);
                return Err(Interrupted);
            }
            inputs.copy_from_slice(self.held.row(interval));
            interval += 1;
            Ok(())
        };
        let control = (step, &mut inputs as &mut Inputs<'_>);
        let finer = part.run_with(Some(control), run.tolerance / FINER, longest_step, monitor)?;
        if self.stopped_at.is_none() && !finer.is_success() {
            return Ok(None);
        }
        let places = run.tips.len() / times.len().max(1);
        let between = largest(&distances(&finer.tips, &run.tips[begun * places..]));
        Ok(Some(apart.max(between / plan.model.facts().length)))
    }

    /// Distance from the state in which the controller was called, relative to the length.
    fn distance<M: Model>(&self, model: &mut M, interval: usize, q: &[f64]) -> f64 {
        let Some(state) = self.states.get(interval) else { return 0.0 };
        if model.facts().varies_in_time && model.set_time(state.t).is_err() {
            return 0.0;
        }
        let [mut here, mut there] = [Vec::new(), Vec::new()];
        model.places(q, &mut here);
        model.places(&state.q, &mut there);
        largest(&distances(&here, &there)) / model.facts().length
    }
}
