//! Runs of a model at a tolerance, with steps that resolve visible vibrations.

use super::choice::Choice;
use super::following::Following;
use super::paths;
use super::request::Request;
use crate::error::{Interrupted, InvalidInput};
use crate::model::{Facts, Model};

use crate::analysis::spectrum::Spectrum;
use crate::integrators::second_order;
use crate::simulation::simulate::{Simulation, Status, simulate_as_chosen};

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

/// Number of states of the first run that are examined for further vibrations.
const STATES: usize = 4;

/// Number of steps computed of a run that cannot finish within a larger limit.
const SHOWN: usize = 1000;

/// Status name of runs with too many steps, for methods of first and of second order.
const TOO_MANY_STEPS: &str = "too_many_steps";

/// Status name of explicit runs that would need too many steps.
const STIFF: &str = "stiff";

/// Data shared by all runs of a model.
pub(super) struct Plan<'a, M> {
    pub(super) model: &'a M,
    pub(super) choice: Choice,
    pub(super) following: Following,
    pub(super) t_span: (f64, f64),
    pub(super) start: [&'a [f64]; 2],
    pub(super) request: Request,
    pub(super) t_eval: Option<&'a [f64]>,
    /// Largest number of steps of a run that is only tried.
    pub(super) most_steps: usize,
}

/// A motion with its tolerance, and the paths of the tip.
pub(super) struct Run {
    pub(super) simulation: Simulation,
    pub(super) tolerance: f64,
    pub(super) tips: Vec<[f64; 3]>,
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
        t_span: (f64, f64),
        start: [&'a [f64]; 2],
        request: Request,
        t_eval: Option<&'a [f64]>,
        known: Option<&Following>,
        monitor: &mut dyn FnMut(f64) -> Result<(), Interrupted>,
    ) -> Result<Self, InvalidInput> {
        let [q0, v0] = start;
        model.check_shape(q0, "q0")?;
        let loosest = first_tolerance(model.facts()) * request.rtol;
        let known = Spectrum::new(model, t_span.0, q0, v0).and_then(|spectrum| {
            let following =
                Following::new(model, t_span, start, &spectrum, [loosest, request.rtol], known, monitor)
                    .ok()?;
            let duration = t_span.1 - t_span.0;
            Some((Choice::new(&spectrum, &following, request.rtol, model.facts(), duration), following))
        });
        // Without accelerations, after a failure of a function of time or after a stop: the run will report
        // the same problem.
        let (choice, following) = known.unwrap_or_else(|| (Choice::implicit(), Following::nothing()));
        model.end_steps_at(&following.ends);
        Ok(Self { model, choice, following, t_span, start, request, t_eval, most_steps: usize::MAX })
    }

    pub(super) fn duration(&self) -> f64 {
        self.t_span.1 - self.t_span.0
    }

    /// A run with steps no longer than `longest_step`.
    pub(super) fn run(
        &self,
        tolerance: f64,
        longest_step: f64,
        monitor: &mut dyn FnMut(f64) -> Result<(), Interrupted>,
    ) -> Result<Run, InvalidInput> {
        let Choice { integrator, frequency, .. } = self.choice;
        let mut model = self.model.clone();
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
            simulate_as_chosen(model.clone(), self.t_span, self.start, &method, self.t_eval, monitor)?;
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
        let Simulation { t, q, v, n, .. } = &run.simulation;
        for (k, i) in (1..=STATES).map(|k| (k, k * t.len().saturating_sub(1) / STATES)) {
            let state = [q, v].map(|values| &values[i * n..][..*n]);
            // Until the next look.
            let time = if k < STATES { self.duration() / STATES as f64 } else { 0.0 };
            self.following.add_state(&mut model, t[i], [self.duration(), time], state);
        }
        self.following.longest_step(self.choice.integrator, run.tolerance) * run.steps() >= self.duration()
    }
}
