//! A simulation step by step beside one of a looser tolerance, whose difference estimates the error.
//!
//! Whoever advances it may be a controller, which holds what would fall without it. Under the same inputs small differences grow then, though
//! not in the loop. As in motions in closed loop, where a difference has become a small part of what was asked, both go on
//! from one state, and the differences add up. Inputs that have never changed correct nothing: differences then grow as errors do.

use super::choice::Choice;
use super::closed_loop::RESTARTED_PART;
use super::following::Following;
use super::integrator::Integrator;
use super::paths::{distances, largest};
use super::request::Request;
use super::run::{first_tolerance, second_tolerance};
use super::time::{LEAST_GAIN, SAFETY, SMALLEST_ERROR};
use crate::analysis::spectrum::Spectrum;
use crate::error::{Interrupted, InvalidInput, Time};
use crate::model::{Energy, Model};
use crate::numerics::tape::Tape;
use crate::simulation::balance::State;
use crate::simulation::stepping::{Method, Run, Start, Status};

/// Number of periods of the slowest vibration, and of steps, for which the vibrations of the start are resolved: a simulation that is
/// advanced step by step has no end that is known.
const PERIODS: f64 = 30.0;
const STEPS: f64 = 1000.0;

/// Number of intervals, each of which was interrupted, that a memory can have.
const MOST_INTERVALS: usize = 1 << 16;

/// A simulation advanced interval by interval to a requested accuracy, with inputs held constant in each. The method is chosen at the start.
///
/// A second one, of a looser tolerance, follows under the same inputs at the end of each interval. The steps of the first one also end in
/// the middle of each interval, so that both differ where intervals limit all steps.
#[derive(Clone, Debug)]
pub struct AccurateRun<M> {
    run: Run<M>,
    /// `None` after it has failed.
    looser: Option<Run<M>>,
    /// The model and the method of the looser one.
    pattern: (M, Method),
    /// Steps of the first one before the looser one began.
    steps_before: usize,
    /// Sum of the differences at which both went on from one state, relative to the length, with the factor by which they are errors.
    added: f64,
    /// Inputs of the last interval, and whether they have ever changed.
    inputs: Option<Vec<f64>>,
    has_changed: bool,
    /// Ends of intervals that the looser one has still to make, with their inputs.
    behind: Vec<(f64, Vec<f64>)>,
    /// End of the interval, while the first half is made.
    end: Option<f64>,
    integrator: &'static Integrator,
    tolerances: [f64; 2],
    wanted: f64,
    /// Largest difference so far, relative to the length, with the factor by which it is an error.
    error: f64,
    /// Time at which the error first exceeded what was asked.
    exceeded_at: Option<f64>,
    reason: String,
}

impl<M: Model + Clone> AccurateRun<M> {
    /// Creates a simulation of `model` from `q0`, `v0`, whose first interval is `t_span`. Evaluates no motion.
    ///
    /// Fails if an argument is invalid, or if the model does not resolve `q0`.
    pub fn new(
        mut model: M,
        t_span: (f64, f64),
        q0: &[f64],
        v0: &[f64],
        request: Request,
    ) -> Result<Self, InvalidInput> {
        request.validate()?;
        // Rejects invalid arguments before the vibrations of the start are looked for.
        let checked = Choice::implicit().integrator;
        let sizes = model.facts().typical_coordinates.clone();
        Run::new(model.clone(), t_span, q0, v0, &checked.method(&sizes, 1.0, request.rtol, request))?;
        let start = Start::fitted(&mut model, t_span.0, q0, v0)?;
        let loosest = first_tolerance(model.facts()) * request.rtol;
        let known = Spectrum::new(&mut model, t_span.0, &start.q, &start.v).map(|spectrum| {
            let slowest = spectrum.modes.iter().map(|mode| mode.frequency).filter(|&w| w > 0.0);
            let period = std::f64::consts::TAU / slowest.fold(f64::INFINITY, f64::min);
            let duration = (PERIODS * period).max(STEPS * request.dt);
            let following =
                Following::of_start(&mut model, duration, &start.q, &spectrum, [loosest, request.rtol]);
            (Choice::new(&spectrum, &following, request.rtol, model.facts(), duration), following)
        });
        let (choice, following) = known.unwrap_or_else(|| (Choice::implicit(), Following::nothing()));
        let finer = second_tolerance(model.facts(), request.rtol);
        let method = |tolerance: f64| {
            let max_step = request.max_step.min(following.longest_step(choice.integrator, tolerance));
            let request = Request { max_step, ..request };
            choice.integrator.method(&sizes, choice.frequency, tolerance, request)
        };
        let looser = method(loosest);
        Ok(Self {
            run: Run::new(model.clone(), t_span, q0, v0, &method(finer))?,
            looser: Some(Run::new(model.clone(), t_span, q0, v0, &looser)?),
            pattern: (model, looser),
            steps_before: 0,
            added: 0.0,
            inputs: None,
            has_changed: false,
            behind: Vec::new(),
            end: None,
            integrator: choice.integrator,
            tolerances: [loosest, finer],
            wanted: request.rtol,
            error: SMALLEST_ERROR * finer,
            exceeded_at: None,
            reason: choice.reason,
        })
    }

    /// The simulation whose states are returned.
    pub fn run(&self) -> &Run<M> {
        &self.run
    }

    /// Estimated error of the measured places so far, due to the steps, relative to the model's length; infinite where it is unknown.
    pub fn time_error(&self) -> f64 {
        if self.looser.is_some() { self.error } else { f64::INFINITY }
    }

    /// As of [`Run::begin`].
    pub fn begin(&mut self) -> Result<Option<Status>, Interrupted> {
        if let Some(looser) = &mut self.looser {
            looser.begin()?;
        }
        self.run.begin()
    }

    /// As of [`Run::begin_interval`].
    pub fn begin_interval(&mut self, t_end: f64) {
        let t = self.run.t();
        // An interval that was interrupted ended here.
        if let Some((end, _)) = self.behind.last_mut() {
            *end = t;
        }
        let mut last = self.looser.as_ref().map_or(t, Run::t);
        self.behind.retain(|&(end, _)| {
            let is_ahead = end > last;
            last = last.max(end);
            is_ahead
        });
        let inputs = self.run.inputs().to_vec();
        self.has_changed |= self.inputs.as_ref().is_some_and(|last| *last != inputs);
        self.inputs = Some(inputs.clone());
        self.behind.push((t_end, inputs));
        let middle = 0.5 * (t + t_end);
        self.end = (t < middle && middle < t_end).then_some(t_end);
        self.run.begin_interval(t_end);
        if self.end.is_some() {
            self.run.end_part_at(middle);
        }
    }

    /// As of [`Run::set_inputs`].
    pub fn set_inputs(&mut self, inputs: &[f64]) {
        self.run.set_inputs(inputs);
    }

    /// As of [`Run::watched_step`]. At the end of the interval the looser simulation follows.
    pub fn watched_step(
        &mut self,
        monitor: &mut dyn FnMut(f64) -> Result<(), Interrupted>,
    ) -> Result<Option<Status>, Interrupted> {
        let status = self.run.watched_step(monitor)?;
        if !status.is_some_and(Status::is_success) {
            return Ok(status);
        }
        if let Some(end) = self.end.take() {
            self.run.end_part_at(end);
            return Ok(None);
        }
        self.follow(monitor)?;
        Ok(status)
    }

    /// As of [`Run::finish`].
    pub fn finish(
        &mut self,
        monitor: &mut dyn FnMut(f64) -> Result<(), Interrupted>,
    ) -> Result<Status, Interrupted> {
        loop {
            if let Some(status) = self.watched_step(monitor)? {
                self.run.shorten_rotation_vectors();
                return Ok(status);
            }
            monitor(self.run.t())?;
        }
    }

    /// Lets the looser simulation make the intervals in which it is behind, and compares both.
    fn follow(&mut self, monitor: &mut dyn FnMut(f64) -> Result<(), Interrupted>) -> Result<(), Interrupted> {
        while let (Some(looser), Some((end, inputs))) = (&mut self.looser, self.behind.first()) {
            looser.set_inputs(inputs);
            looser.begin_interval(*end);
            let status = looser.finish(monitor)?;
            if !status.is_success() {
                self.looser = None;
            }
            self.behind.remove(0);
        }
        self.behind.clear();
        let Self { run, looser: Some(looser), integrator, tolerances, steps_before, .. } = self else {
            self.exceeded_at.get_or_insert(self.run.t());
            return Ok(());
        };
        let [here, there] = [&mut *run, looser].map(|run| {
            run.observe(|model, state: State<'_>| {
                model.set_time(state.t)?;
                let mut places = Vec::new();
                model.places(state.q, &mut places);
                Ok((places, model.facts().length, model.facts().has_one_sided_forces))
            })
        });
        let ((here, length, has_impacts), (there, ..)) = (here?, there?);
        let steps = [looser.steps(), run.steps() - *steps_before].map(|steps| steps as f64);
        let gain = integrator.gain([(tolerances[0], steps[0]), (tolerances[1], steps[1])]);
        let share = if gain >= LEAST_GAIN && !has_impacts { SAFETY / gain.sqrt() } else { SAFETY };
        let apart = share * largest(&distances(&here, &there)) / length;
        self.error = self.error.max(self.added + apart + SMALLEST_ERROR * tolerances[1]);
        // A difference that is not a number is an error, too.
        if !(self.error <= self.wanted && apart.is_finite()) {
            self.exceeded_at.get_or_insert(self.run.t());
        }
        if self.has_changed && apart > RESTARTED_PART * self.wanted {
            self.added += apart;
            self.restart()?;
        }
        Ok(())
    }

    /// Lets the looser simulation go on from the state of the first one.
    fn restart(&mut self) -> Result<(), Interrupted> {
        let (model, method) = &self.pattern;
        let (t, inputs) = (self.run.t(), self.run.inputs().to_vec());
        self.steps_before = self.run.steps();
        self.looser = Run::new(model.clone(), (t, t), self.run.q(), self.run.v(), method).ok();
        if let Some(looser) = &mut self.looser {
            looser.begin()?;
            looser.set_inputs(&inputs);
        }
        Ok(())
    }

    /// Why the motion so far may be less accurate than was asked, or wrong.
    pub fn doubt(&mut self) -> Option<String> {
        let (error, wanted) = (self.time_error(), self.wanted);
        let of_accuracy = self.exceeded_at.map(|t| {
            let what = match error.is_finite() {
                true => format!("is {error:.0e} of the length"),
                false => "is unknown, because the steps of a looser tolerance failed".to_owned(),
            };
            format!(
                "The time error {what}, {wanted:.0e} was asked for and exceeded at t = {} s: start again with a smaller `rtol`.",
                Time(t)
            )
        });
        let doubts: Vec<String> = self.run.doubt().into_iter().chain(of_accuracy).collect();
        (!doubts.is_empty()).then(|| doubts.join(" "))
    }

    /// Describes a status, with the error so far.
    pub fn explain(&mut self, status: Status) -> String {
        let explained = self.run.explain(status);
        let (error, wanted) = (self.time_error(), self.wanted);
        if !status.is_success() || !error.is_finite() {
            return explained;
        }
        format!(
            "{explained} The time error is {error:.0e} of the length, {wanted:.0e} was asked for. The space error is not estimated. {}",
            self.reason
        )
    }

    /// Energies of the current state.
    pub fn energy(&mut self) -> Result<Energy, Interrupted> {
        self.run.energy()
    }

    /// The simulation whose states are returned.
    pub fn run_mut(&mut self) -> &mut Run<M> {
        &mut self.run
    }

    /// All data that persist from interval to interval, as numbers.
    pub fn memory(&mut self) -> Vec<f64> {
        let runs = [Some(self.run.memory()), self.looser.as_mut().map(Run::memory)];
        let mut numbers = Vec::new();
        for run in runs.into_iter().map(Option::unwrap_or_default) {
            numbers.push(run.len() as f64);
            numbers.extend(run);
        }
        self.serialise(&mut Tape::writing(&mut numbers));
        numbers
    }

    /// Restores the [memory](Self::memory) of a simulation of the same model to the same accuracy.
    ///
    /// Fails for an invalid memory; this simulation is then invalid.
    pub fn recall(&mut self, memory: &[f64]) -> Result<(), InvalidInput> {
        let wrong = || {
            let expected = "those of a simulation of the same model to the same accuracy";
            InvalidInput::new("memory", format_args!("{} numbers", memory.len()), expected)
        };
        let part = |numbers: &[f64]| -> Option<(Vec<f64>, Vec<f64>)> {
            let (length, rest) = numbers.split_first()?;
            let length = *length as usize;
            (length <= rest.len()).then(|| (rest[..length].to_vec(), rest[length..].to_vec()))
        };
        let (of_run, rest) = part(memory).ok_or_else(wrong)?;
        let (of_looser, rest) = part(&rest).ok_or_else(wrong)?;
        self.run.recall(&of_run)?;
        match &mut self.looser {
            _ if of_looser.is_empty() => self.looser = None,
            Some(looser) => looser.recall(&of_looser)?,
            None => return Err(wrong()),
        }
        let mut tape = Tape::reading(&rest);
        self.serialise(&mut tape);
        if tape.is_right() { Ok(()) } else { Err(wrong()) }
    }

    fn serialise(&mut self, tape: &mut Tape<'_>) {
        tape.number(&mut self.error);
        tape.number(&mut self.added);
        tape.count(&mut self.steps_before);
        tape.optional(&mut self.exceeded_at, 0.0, Tape::number);
        let inputs = self.run.inputs().len();
        tape.flag(&mut self.has_changed);
        tape.optional(&mut self.inputs, vec![0.0; inputs], |tape, inputs| tape.numbers(inputs));
        let mut count = self.behind.len();
        tape.below(MOST_INTERVALS, &mut count);
        if tape.reads() {
            self.behind = vec![(0.0, vec![0.0; inputs]); count];
        }
        for (end, inputs) in &mut self.behind {
            tape.number(end);
            tape.numbers(inputs);
        }
    }
}
