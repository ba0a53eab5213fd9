//! Runs of a model at a tolerance, with steps that resolve visible vibrations.

use super::choice::Choice;
use super::following::Following;
use super::inputs::{Given, Recording, set_state};
use super::paths;
use super::request::Request;
use crate::error::{Interrupted, InvalidInput};
use crate::model::{Facts, Model};

use crate::analysis::spectrum::Spectrum;
use crate::integrators::second_order;
use crate::simulation::simulate::{Inputs, Simulation, Status, simulate_as_chosen};

/// Tolerance of the first run over the requested one, chosen such that the second run usually meets the
/// request.
const FIRST_TOLERANCE: f64 = 1.5;

/// The same with contacts, stops and slack tendons, where the whole difference of two runs, with a factor of safety, is the estimate: it is
/// the error of the first run, which is 1 to 10 times its tolerance (random balls that land, `benches/python/accuracy/cost.py`).
const FIRST_TOLERANCE_AT_IMPACTS: f64 = 0.1;

/// Tolerance of the first run, relative to the requested one.
pub(super) fn first_tolerance(facts: &Facts) -> f64 {
    if facts.has_one_sided_forces { FIRST_TOLERANCE_AT_IMPACTS } else { FIRST_TOLERANCE }
}

/// Tightest tolerance of a run; below, rounding errors dominate.
pub(super) const SMALLEST_RUN_TOLERANCE: f64 = 1e-13;

/// Tolerance of the first run over that of the second one.
pub(super) const TIGHTENING: f64 = 5.0;

/// The same for motions with impacts: at similar tolerances the steps of free flights are the same, and so is the error of impacts.
pub(super) const TIGHTENING_AT_IMPACTS: f64 = 10.0;

/// Tolerance of the first run over that of the second one.
pub(super) fn tightening(facts: &Facts) -> f64 {
    if facts.has_one_sided_forces { TIGHTENING_AT_IMPACTS } else { TIGHTENING }
}

/// Tolerance of the second run, which is usually the last one.
pub(super) fn second_tolerance(facts: &Facts, wanted: f64) -> f64 {
    (first_tolerance(facts) * wanted / tightening(facts)).max(SMALLEST_RUN_TOLERANCE)
}

/// Tolerance of the second run over that of a run in closed loop, which is not repeated, and whose error is the whole difference to a finer
/// one, with a factor of safety.
const CLOSED_LOOP_MARGIN: f64 = 5.0;

/// Number of states of the first run that are examined for further vibrations.
const STATES: usize = 4;

/// Number of steps computed of a run that cannot finish within a larger limit.
const SHOWN: usize = 1000;

/// Status name of runs with too many steps, for methods of first and of second order.
pub(super) const TOO_MANY_STEPS: &str = "too_many_steps";

/// Status name of explicit runs that would need too many steps.
const STIFF: &str = "stiff";

/// Data shared by all runs of a model.
pub(super) struct Plan<'a, M> {
    pub(super) model: &'a M,
    pub(super) choice: Choice,
    pub(super) following: Following,
    pub(super) given: Given<'a>,
    pub(super) request: Request,
    /// Largest number of steps of a run that is only tried.
    pub(super) most_steps: usize,
}

/// A motion with its tolerance, and the paths of the tip.
pub(super) struct Run {
    pub(super) simulation: Simulation,
    pub(super) tolerance: f64,
    pub(super) tips: Vec<[f64; 3]>,
}

/// The motion that is returned, why its method was chosen, and by how much the number of nodes was raised.
pub(super) struct Motion {
    pub(super) simulation: Simulation,
    pub(super) reason: String,
    pub(super) factor: usize,
}

impl Run {
    pub(super) fn is_success(&self) -> bool {
        self.simulation.status.is_success()
    }

    pub(super) fn steps(&self) -> f64 {
        self.simulation.statistics.counters.steps as f64
    }

    /// Marks a run as interrupted during the estimation of its error.
    pub(super) fn interrupt(&mut self) {
        self.simulation.status = Status::SecondOrder(second_order::Status::Interrupted);
        self.simulation.message = "The run was stopped, as asked for, before its error was known.".to_owned();
    }
}

impl<'a, M: Model + Clone> Plan<'a, M> {
    /// Chooses the method and finds the vibrations to be resolved. `known` is what was found of a coarser model. `monitor` may stop the
    /// search.
    pub(super) fn new(
        model: &'a mut M,
        given: Given<'a>,
        request: Request,
        known: Option<&Following>,
        monitor: &mut dyn FnMut(f64) -> Result<(), Interrupted>,
    ) -> Result<Self, InvalidInput> {
        let Given { t_span, start: [q0, v0], held, .. } = given;
        model.check_shape(q0, "q0")?;
        if let Some(held) = held {
            held.set(model, t_span.0);
        }
        let loosest = first_tolerance(model.facts()) * request.rtol;
        let known = Spectrum::new(model, t_span.0, q0, v0).and_then(|spectrum| {
            let following =
                Following::new(model, given, &spectrum, [loosest, request.rtol], known, monitor).ok()?;
            let duration = t_span.1 - t_span.0;
            Some((Choice::new(&spectrum, &following, request.rtol, model.facts(), duration), following))
        });
        // Without accelerations, after a failure of a function of time or after a stop: the run will report
        // the same problem.
        let (choice, following) = known.unwrap_or_else(|| (Choice::implicit(), Following::nothing()));
        model.end_steps_at(&following.ends);
        Ok(Self { model, choice, following, given, request, most_steps: usize::MAX })
    }

    pub(super) fn duration(&self) -> f64 {
        self.given.t_span.1 - self.given.t_span.0
    }

    /// A run with steps no longer than `longest_step`, under the given inputs.
    pub(super) fn run(
        &self,
        tolerance: f64,
        longest_step: f64,
        monitor: &mut dyn FnMut(f64) -> Result<(), Interrupted>,
    ) -> Result<Run, InvalidInput> {
        let Some(held) = self.given.held else {
            return self.run_with(None, tolerance, longest_step, monitor);
        };
        let mut interval = 0;
        let mut inputs = |_: f64, _: &[f64], _: &[f64], inputs: &mut [f64]| {
            inputs.copy_from_slice(held.row(interval));
            interval += 1;
            Ok(())
        };
        let control = (held.step, &mut inputs as &mut Inputs<'_>);
        self.run_with(Some(control), tolerance, longest_step, monitor)
    }

    /// A run in closed loop, with the method that finishes it, and tolerances with which it is rarely less accurate than asked.
    pub(super) fn closed_loop(
        &mut self,
        recording: &mut Recording<'_>,
        monitor: &mut dyn FnMut(f64) -> Result<(), Interrupted>,
    ) -> Result<Run, InvalidInput> {
        self.most_steps = self.choice.worth;
        let tolerance = second_tolerance(self.model.facts(), self.request.rtol) / CLOSED_LOOP_MARGIN;
        let tolerance = tolerance.max(SMALLEST_RUN_TOLERANCE);
        loop {
            let step = recording.held.step;
            let mut inputs = recording.of_run();
            let control = (step, &mut inputs as &mut Inputs<'_>);
            let run = self.run_with(Some(control), tolerance, f64::INFINITY, monitor)?;
            if run.is_success() || !self.switches(&run) {
                return Ok(run);
            }
        }
    }

    /// A run with inputs that are set in these intervals.
    pub(super) fn run_with(
        &self,
        control: Option<(f64, &mut Inputs<'_>)>,
        tolerance: f64,
        longest_step: f64,
        monitor: &mut dyn FnMut(f64) -> Result<(), Interrupted>,
    ) -> Result<Run, InvalidInput> {
        let Choice { integrator, frequency, .. } = self.choice;
        let Given { t_span, start, t_eval, .. } = self.given;
        let mut model = self.model.clone();
        if control.is_some() {
            // A run begins with these, and sets others itself.
            let defaults = model.facts().default_inputs.clone();
            model.set_inputs(&defaults);
        }
        let sizes = model.facts().typical_coordinates.clone();
        let followed = self.following.longest_step(integrator, tolerance);
        let max_step = self.request.max_step.min(followed).min(longest_step);
        let fewest = self.duration() / max_step;
        let is_too_long = fewest > self.request.max_steps as f64;
        // Do not start hours of work that cannot finish within the limit: a few steps show the behaviour of
        // the model.
        let is_shown = is_too_long && self.request.max_steps > SHOWN;
        let max_steps = if is_shown { SHOWN } else { self.request.max_steps };
        let request = Request { max_step, max_steps: max_steps.min(self.most_steps), ..self.request };
        let method = integrator.method(&sizes, frequency, tolerance, request);
        let mut simulation =
            simulate_as_chosen(model.clone(), t_span, start, &method, t_eval, control, monitor)?;
        if is_shown && simulation.status.name() == TOO_MANY_STEPS {
            simulation.message = format!(
                "At least {fewest:.0e} steps are needed to resolve the motion, and `max_steps` is {}: only the first {SHOWN} of \
                 them were made. Check the loads, loosen `rtol`, shorten the time, or increase `max_steps`.",
                self.request.max_steps
            );
        }
        match paths::tips(&mut model, &simulation, monitor) {
            Ok(tips) => Ok(Run { simulation, tolerance, tips }),
            Err(Interrupted) => {
                let mut run = Run { simulation, tolerance, tips: Vec::new() };
                run.interrupt();
                Ok(run)
            }
        }
    }

    /// Whether a run took more explicit steps than it is worth; from now on, runs are implicit ones.
    pub(super) fn switches(&mut self, run: &Run) -> bool {
        let has_ended = [TOO_MANY_STEPS, STIFF].contains(&run.simulation.status.name());
        let switches = has_ended && self.choice.worth < self.request.max_steps;
        if switches {
            self.choice.switch();
            self.most_steps = usize::MAX;
        }
        switches
    }

    /// Whether the steps of a run were short enough for the vibrations that its own states contain.
    pub(super) fn follows(&mut self, run: &Run) -> bool {
        let mut model = self.model.clone();
        let simulation = &run.simulation;
        let Simulation { t, q, v, n, .. } = simulation;
        for (k, i) in (1..=STATES).map(|k| (k, k * t.len().saturating_sub(1) / STATES)) {
            let state = [q, v].map(|values| &values[i * n..][..*n]);
            // Until the next look.
            let time = if k < STATES { self.duration() / STATES as f64 } else { 0.0 };
            if set_state(&mut model, simulation, i).is_ok() {
                self.following.add_state(&mut model, t[i], [self.duration(), time], state);
            }
        }
        self.following.longest_step(self.choice.integrator, run.tolerance) * run.steps() >= self.duration()
    }
}
