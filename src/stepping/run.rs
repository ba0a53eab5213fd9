//! A simulation that the caller advances step by step.

use super::integrator::Integrator;
use super::method::{Method, check_span, check_step};
use super::start::Start;
use super::status::{Status, Stop};
use crate::balance::State;
use crate::error::{Interrupted, InvalidInput, Number};
use crate::model::{Energy, ForwardScratch, Model, SingularMass};
use crate::ode;
use crate::second_order::{self, Counters, Failure, Grid, is_whole, number_of_steps};
use crate::signal::covers;
use crate::tape::Tape;

/// A motion of a model that the caller advances, with inputs that are constant in between. It owns its model.
/// All memory is allocated once [`Self::begin`] has been called.
///
/// The part of a run from one call of [`Self::set_out`] to its end time is a leg. Methods with adaptive steps
/// end a step there; fixed steps divide the leg into equal steps of size `dt`, or shorter if `dt` does not
/// divide the leg. Runs over the same legs agree bit for bit.
#[derive(Clone, Debug)]
pub struct Run<M> {
    integrator: Integrator<M>,
    dt: f64,
    /// Interval of time in seconds on which the model is defined.
    known: [f64; 2],
    /// End times of single steps.
    grid: Grid,
    inputs: Vec<f64>,
    inputs_have_jumped: bool,
    /// Accelerations after a jump of the inputs.
    jumped: Vec<f64>,
    scratch: ForwardScratch,
    /// Distance in metres by which the start was moved to close loops.
    moved: f64,
    stop: Option<Stop>,
}

impl<M: Model> Run<M> {
    /// Creates a run of `model` from `q0`, `v0`, whose first leg is `t_span`. Evaluates no motion.
    ///
    /// Fails if an argument is invalid, or if the model does not resolve `q0`.
    pub fn new(
        mut model: M,
        t_span: (f64, f64),
        q0: &[f64],
        v0: &[f64],
        method: &Method,
    ) -> Result<Self, InvalidInput> {
        let (n, dt) = (model.n(), method.dt());
        second_order::check_start(n, t_span, q0, v0, dt)?;
        let known = model.time_span();
        check_span(known, t_span)?;
        let start = Start::fitted(&mut model, t_span.0, q0, v0)?;
        let (q0, v0) = (&start.q[..], &start.v[..]);
        model.check_shape(q0, "q0")?;
        if let Some(flaw) = model.sunk(q0) {
            let expected = "a start in which surfaces overlap by less than a radius";
            return Err(InvalidInput::new("q0", format_args!("one in which the model {flaw}"), expected));
        }
        if let Some(dt) = method.fixed_step() {
            check_step(dt, model.shortest_period())?;
        }
        let inputs = model.default_inputs();
        let scratch = ForwardScratch::of(&model);
        Ok(Self {
            integrator: Integrator::new(model, t_span, q0, v0, method)?,
            dt,
            known,
            grid: Grid::new(t_span.0, dt),
            inputs,
            inputs_have_jumped: false,
            jumped: vec![0.0; n],
            scratch,
            moved: start.moved,
            stop: None,
        })
    }

    /// End of a leg of this duration from now; default: `dt`. Whole multiples of `dt` end at the same time as
    /// that number of single legs.
    ///
    /// Fails if this is not a later time, or if the model is not defined there.
    pub fn end_of(&self, duration: Option<f64>) -> Result<f64, InvalidInput> {
        let (t, way) = (self.t(), duration.unwrap_or(self.dt));
        let place = if duration.is_some() { "duration" } else { "dt" };
        if !(way.is_finite() && way > 0.0) {
            return Err(InvalidInput::new(place, Number(way), "a finite number > 0 (seconds)"));
        }
        let steps = number_of_steps(way, self.dt);
        let end = if is_whole(way, steps, self.dt) { self.grid_now().after(steps) } else { t + way };
        if !(end > t && end.is_finite()) {
            let expected = "one that rounding of the time does not swallow";
            return Err(InvalidInput::new(place, Number(way), expected));
        }
        if !covers(self.known, end) {
            let [from, to] = self.known;
            let found = format_args!("a step from {} to {}", Number(t), Number(end)).to_string();
            let expected = format!(
                "one that ends within [{from}, {to}] (seconds), where all prescribed motion is known"
            );
            return Err(InvalidInput::new(place, found, expected));
        }
        Ok(end)
    }

    /// Begins a leg that ends at this time, which must be later than the current one.
    pub fn set_out(&mut self, t_end: f64) {
        self.grid = self.grid_now();
        self.stop = None;
        self.integrator.go_on(t_end);
    }

    /// End times of single steps from now on.
    fn grid_now(&self) -> Grid {
        let t = self.t();
        self.grid.at(t).unwrap_or_else(|| Grid::new(t, self.dt))
    }

    /// Sets the inputs from now on.
    ///
    /// # Panics
    /// If their number differs from the number of the model's inputs.
    pub fn set_inputs(&mut self, inputs: &[f64]) {
        if self.inputs != inputs {
            self.inputs.copy_from_slice(inputs);
            self.integrator.model().set_inputs(inputs);
            self.inputs_have_jumped = true;
        }
    }

    /// Computes the accelerations at the start, or after a jump of the inputs. [`Self::step`] calls this if
    /// necessary. Returns `Some(status)` if there are none.
    ///
    /// A run that begins before its first inputs are set agrees bit for bit with [`simulate_controlled`].
    /// Inputs set before belong to the start, for which an adaptive method may choose another first step.
    ///
    /// [`simulate_controlled`]: crate::simulate::simulate_controlled
    pub fn begin(&mut self) -> Result<Option<Status>, Interrupted> {
        if let Some(status) = self.integrator.start()? {
            return Ok(Some(status));
        }
        if !self.inputs_have_jumped {
            return Ok(None);
        }
        let Self { integrator, jumped, scratch, .. } = self;
        let found = integrator.observe(|model, state| {
            model.set_time(state.t)?;
            Ok(model.forward_dynamics(state.q, state.v, jumped, scratch))
        })?;
        let failure = match found {
            Err(SingularMass) => Failure::SingularJacobian,
            Ok(()) if !self.jumped.iter().all(|a| a.is_finite()) => Failure::NonFinite,
            Ok(()) => {
                self.integrator.jump(&self.jumped);
                self.inputs_have_jumped = false;
                return Ok(None);
            }
        };
        Ok(Some(self.integrator.no_acceleration(failure)))
    }

    /// Makes one accepted step of this leg. Returns `Some(status)` if the leg has ended: its end was reached,
    /// or no step could be made, which leaves the state unchanged. After an interruption the state is that of
    /// the last accepted step, and the step can be repeated.
    ///
    /// A step to an invalid shape is accepted, and ends the leg.
    ///
    /// # Panics
    /// If the leg had already ended.
    pub fn step(&mut self) -> Result<Option<Status>, Interrupted> {
        if let Some(status) = self.begin()? {
            return Ok(Some(status));
        }
        let steps = self.integrator.steps();
        let status = self.integrator.step()?;
        if self.integrator.steps() > steps {
            self.stop = match self.integrator.hold() {
                true => self.integrator.observe(|model, state| Stop::where_flawed(model, state.t, state.q)),
                false => Some(Stop::at_singular_position(self.t())),
            };
        } else if matches!(
            status,
            Some(
                Status::FirstOrder(ode::Status::StepTooSmall)
                    | Status::SecondOrder(second_order::Status::StepTooSmall)
            )
        ) && self.integrator.is_nearly_singular()
        {
            self.stop = Some(Stop::at_singular_position(self.t()));
        }
        Ok(self.stop.as_ref().map(|stop| stop.status).or(status))
    }

    /// Rewrites the state with rotation vectors no longer than pi, if the last step exceeded pi. The next
    /// step would do the same.
    pub fn settle(&mut self) {
        self.integrator.settle();
    }

    /// Makes steps to the end of this leg, [settles](Self::settle), and returns the status. `monitor` is
    /// called with the time after every step and may interrupt the leg.
    pub fn finish(
        &mut self,
        monitor: &mut dyn FnMut(f64) -> Result<(), Interrupted>,
    ) -> Result<Status, Interrupted> {
        loop {
            if let Some(status) = self.step()? {
                self.settle();
                return Ok(status);
            }
            monitor(self.t())?;
        }
    }

    /// Current time.
    pub fn t(&self) -> f64 {
        self.integrator.t()
    }

    /// Current coordinates.
    pub fn q(&self) -> &[f64] {
        self.integrator.state()[0]
    }

    /// Current velocities.
    pub fn v(&self) -> &[f64] {
        self.integrator.state()[1]
    }

    /// Current accelerations; at the end of a leg, with the inputs of this leg until the next one begins.
    pub fn a(&self) -> &[f64] {
        self.integrator.state()[2]
    }

    /// Current inputs.
    pub fn inputs(&self) -> &[f64] {
        &self.inputs
    }

    /// Energies of the current state.
    pub fn energy(&mut self) -> Result<Energy, Interrupted> {
        self.observe(|model, state| {
            model.set_time(state.t)?;
            Ok(model.energy(state.q, state.v))
        })
    }

    /// Cost of the run so far.
    pub fn counters(&self) -> Counters {
        self.integrator.counters()
    }

    /// Describes a status of this run, with advice unless it is a success.
    pub fn explain(&mut self, status: Status) -> String {
        if let Some(stop) = &self.stop {
            return stop.message.clone();
        }
        let mut message = self.integrator.explain(status);
        if self.moved > 0.0 {
            message.push_str(&Start::sentence(self.moved));
        }
        if !status.is_success()
            && let Some(what) = self.integrator.model().not_finite()
        {
            message.push_str(&format!(" The cause: {what}."));
        }
        message
    }

    /// Status of an interrupted run.
    pub(crate) fn interrupted(&self) -> Status {
        self.integrator.interrupted()
    }

    /// Calls `observe` with the model and its current state.
    pub(crate) fn observe<T>(&mut self, observe: impl FnOnce(&mut M, State<'_>) -> T) -> T {
        self.integrator.observe(observe)
    }

    /// Writes the state at a time within the last step; false if it is not finite.
    pub(crate) fn interpolate(&mut self, t: f64, state: [&mut [f64]; 3]) -> Result<bool, Interrupted> {
        self.integrator.interpolate(t, state)
    }

    /// All data that persist from leg to leg, as numbers.
    pub fn memory(&mut self) -> Vec<f64> {
        let mut numbers = Vec::new();
        self.carry(&mut Tape::writing(&mut numbers));
        numbers
    }

    /// Restores the [memory](Self::memory) of a run of the same model with the same method; the run then
    /// continues as that one does, bit for bit.
    ///
    /// Fails for an invalid memory; this run is then invalid.
    pub fn recall(&mut self, memory: &[f64]) -> Result<(), InvalidInput> {
        let mut tape = Tape::reading(memory);
        self.carry(&mut tape);
        let is_right = tape.is_right() && self.t().is_finite();
        self.integrator.model().set_inputs(&self.inputs);
        if is_right {
            return Ok(());
        }
        let found = format_args!("{} numbers", memory.len()).to_string();
        Err(InvalidInput::new("memory", found, "those of a run of the same model by the same method"))
    }

    fn carry(&mut self, tape: &mut Tape<'_>) {
        tape.numbers(&mut self.inputs);
        tape.flag(&mut self.inputs_have_jumped);
        self.grid.carry(tape);
        self.integrator.carry(tape);
    }
}
