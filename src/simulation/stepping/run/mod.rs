//! A simulation that the caller advances step by step.

mod tendons;

use super::changes::Changes;
use super::energy_watch::EnergyWatch;
use super::impact_resolver::ImpactResolver;
use super::integrator::{Integrator, without_inertia};
use super::method::{Method, check_span, check_step};
use super::prescribed_watch::PrescribedWatch;
use super::start::Start;
use super::status::{Status, Stop};
use super::unstable_vibrations::UnstableVibrations;
use crate::description::signal::{Jumps, covers};
use crate::error::{Interrupted, InvalidInput, Number, Time};
use crate::integrators::Retries;
use crate::integrators::attempts::Remedy;
use crate::integrators::newmark::Lengths;
use crate::integrators::ode;
use crate::integrators::second_order;
use crate::integrators::second_order::{Counters, Failure, Grid, is_whole, number_of_steps};
use crate::model::constraint::projection;
use crate::model::{ContactText, Energy, ForwardScratch, InvalidShape, Model, Overlap, SingularMass};
use crate::numerics::tape::Tape;
use crate::simulation::balance::{FlowMeter, State};

/// Longest step of fixed size relative to the sticking time of static friction: a step from rest then gains at most about this part of the
/// Stribeck velocity, at which friction has fallen by a percent of the difference between static and kinetic friction.
const STEP_OVER_STICKING_TIME: f64 = 0.2;

/// A simulation advanced interval by interval, with inputs held constant in each: state in, inputs in, steps, state out. It owns its
/// model, and allocates its memory before the end of [`Self::begin`].
///
/// The part of a run from one call of [`Self::begin_interval`] to its end time is an interval. Methods with adaptive steps
/// end a step there; fixed steps divide the interval into equal steps of size `dt`, or shorter if `dt` does not
/// divide the interval. Runs over the same intervals agree bit for bit.
#[derive(Clone, Debug)]
pub struct Run<M> {
    integrator: Integrator<M>,
    dt: f64,
    /// Range of times in seconds on which the model is defined.
    known: [f64; 2],
    /// End times of single steps.
    grid: Grid,
    inputs: Vec<f64>,
    /// Inputs before the last jump.
    inputs_before: Vec<f64>,
    inputs_have_jumped: bool,
    /// Accelerations after a jump of the inputs.
    jumped: Vec<f64>,
    scratch: ForwardScratch,
    /// Whether prescribed velocities or accelerations, loads or commands may jump, the time of their last jump, and the work done
    /// in jumps since it was last asked for.
    jumps: bool,
    jumped_at: Option<f64>,
    work: Option<f64>,
    /// Whether the mass at the start is known to be regular.
    has_mass: bool,
    /// Distance in metres by which the start was moved to close loops.
    moved: f64,
    /// Present if the active set of one-sided constraints changes only between steps.
    changes: Option<Box<Changes>>,
    /// The energy of steps of one size, from the start until inputs change, with what loads supply.
    energy: Option<Box<EnergyWatch>>,
    supply: Option<Box<FlowMeter<'static>>>,
    is_watched: bool,
    /// What is prescribed, in steps of one size.
    prescribed_watch: Option<Box<PrescribedWatch>>,
    /// Vibrations that grow in steps of one size, about the start.
    unstable_vibrations: Option<Box<UnstableVibrations>>,
    /// Impacts in steps of one size.
    resolves_impacts: bool,
    may_resolve_impacts: bool,
    impact_resolver: ImpactResolver,
    stop: Option<Stop>,
}

impl<M: Model> Run<M> {
    /// Creates a run of `model` from `q0`, `v0`, whose first interval is `t_span`. Evaluates no motion.
    ///
    /// Fails if an argument is invalid, or if the model does not resolve `q0`.
    pub fn new(
        mut model: M,
        t_span: (f64, f64),
        q0: &[f64],
        v0: &[f64],
        method: &Method,
    ) -> Result<Self, InvalidInput> {
        let (n, dt) = (model.facts().n, method.dt());
        second_order::check_start(n, t_span, q0, v0, dt)?;
        let known = model.facts().time_span;
        check_span(known, t_span)?;
        if !method.has_inertia() {
            model = without_inertia(model, v0)?;
        }
        let start = Start::fitted(&mut model, t_span.0, q0, v0)?;
        let (q0, v0) = (&start.q[..], &start.v[..]);
        model.check_shape(q0, "q0")?;
        // The run reports errors of functions of time.
        if model.facts().has_contact
            && model.set_time(t_span.0).is_ok()
            && let Some(invalid_shape) = model.deep_penetration(q0)
        {
            let mut expected = "a start in which surfaces overlap by less than a radius".to_owned();
            if let InvalidShape::DeepPenetration { contact, .. } = invalid_shape {
                let advice = model.text_of_contact(contact, ContactText::AdviceOnDeepOverlap);
                expected += if advice.is_empty() { "" } else { "." };
                expected += &advice;
            }
            let found = format_args!("one in which the model {invalid_shape}");
            return Err(InvalidInput::new("q0", found, expected));
        }
        if let Some(dt) = method.fixed_step() {
            check_step(dt, model.facts().shortest_period)?;
        }
        let inputs = model.facts().default_inputs.clone();
        model.set_steps(method.fixed_step().unwrap_or(0.0));
        model.start_at(t_span.0);
        let facts = model.facts();
        let resolves_impacts = method.resolves_impacts(facts);
        let may_resolve = method.fixed_step().is_some() && !facts.is_one_sided;
        // Without inertia nothing keeps a velocity over a jump.
        let jumps = method.has_inertia() && model.jumps() != Jumps::Nothing;
        let scratch = ForwardScratch::of(&model);
        let mut integrator = Integrator::new(model, t_span, q0, v0, method)?;
        let is_one_sided = integrator.model().facts().is_one_sided;
        let changes = is_one_sided.then(|| Box::new(Changes::new(t_span)));
        Ok(Self {
            integrator,
            dt,
            known,
            grid: Grid::new(t_span.0, dt),
            inputs_before: inputs.clone(),
            inputs,
            inputs_have_jumped: false,
            jumped: vec![0.0; n],
            scratch,
            jumps,
            jumped_at: None,
            work: None,
            has_mass: false,
            moved: start.moved,
            changes,
            energy: None,
            supply: None,
            is_watched: false,
            prescribed_watch: None,
            unstable_vibrations: None,
            resolves_impacts,
            may_resolve_impacts: may_resolve,
            impact_resolver: ImpactResolver::new(n),
            stop: None,
        })
    }

    /// End of an interval of this duration from now; default: `dt`. Whole multiples of `dt` end at the same time as
    /// that number of single intervals, and at corners of prescribed motions there, but for rounding.
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
        let end = self.integrator.end_at_corner(end, self.dt);
        if !(end > t && end.is_finite()) {
            let expected = "one that rounding of the time does not swallow";
            return Err(InvalidInput::new(place, Number(way), expected));
        }
        if !covers(self.known, end) {
            let [from, to] = self.known;
            let found = format_args!("a step from {} to {}", Time(t), Number(end)).to_string();
            let expected = format!(
                "one that ends within [{from}, {to}] (seconds), where all prescribed motion is known"
            );
            return Err(InvalidInput::new(place, found, expected));
        }
        Ok(end)
    }

    /// Begins an interval that ends at this time, which must be later than the current one.
    pub fn begin_interval(&mut self, t_end: f64) {
        self.grid = self.grid_now();
        self.stop = None;
        if let Some(changes) = &mut self.changes {
            changes.t_span = (self.integrator.t(), t_end);
        }
        self.integrator.extend_to(t_end);
    }

    /// Lets a step of an adaptive method end there first, within the interval, or goes on to its end.
    pub(crate) fn end_part_at(&mut self, t: f64) {
        self.integrator.extend_to(t);
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
            if !self.inputs_have_jumped {
                self.inputs_before.copy_from_slice(&self.inputs);
            }
            self.inputs.copy_from_slice(inputs);
            self.integrator.model().set_inputs(inputs);
            self.inputs_have_jumped = true;
            // The work of jumps of inputs is unknown here.
            (self.energy, self.supply) = (None, None);
            self.is_watched = self.steps() > 0;
        }
    }

    /// Computes the accelerations at the start, or after a jump of the inputs. [`Self::step`] calls this if
    /// necessary. Returns `Some(status)` if there are none.
    ///
    /// A run that begins before its first inputs are set agrees bit for bit with [`simulate_controlled`].
    /// Inputs set before belong to the start, for which an adaptive method may choose another first step.
    ///
    /// [`simulate_controlled`]: crate::simulation::simulate::simulate_controlled
    pub fn begin(&mut self) -> Result<Option<Status>, Interrupted> {
        if !self.has_mass
            && let Some(status) = self.find_mass()?
        {
            return Ok(Some(status));
        }
        if self.changes.as_ref().is_some_and(|changes| !changes.has_begun)
            && let Some(status) = self.find_active_set()?
        {
            return Ok(Some(status));
        }
        if let Some(status) = self.integrator.start()? {
            return Ok(Some(status));
        }
        if !self.is_watched {
            self.is_watched = true;
            self.energy = self.watch();
            self.prescribed_watch = self.follow();
            self.unstable_vibrations = self.find_unstable_vibrations();
        }
        if !self.inputs_have_jumped {
            return Ok(None);
        }
        if !self.lengths_jump()?
            && let Some(changes) = &mut self.changes
        {
            let without = changes.due.take().flatten();
            self.inputs_have_jumped = false;
            return self.change(without);
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

    /// Makes one accepted step of this interval. Returns `Some(status)` if the interval has ended: its end was reached,
    /// or no step could be made, which leaves the state unchanged. After an interruption the state is that of
    /// the last accepted step, and the step can be repeated.
    ///
    /// A step to an invalid shape is made, and ends the interval. Where inextensible tendons become taut or slack, the
    /// change is made instead of a step; so are jumps of velocities where prescribed velocities jump.
    ///
    /// `monitor` is called with the time of its start within a step that takes many evaluations, and may interrupt it.
    ///
    /// # Panics
    /// If the interval had already ended.
    pub fn step(
        &mut self,
        monitor: &mut dyn FnMut(f64) -> Result<(), Interrupted>,
    ) -> Result<Option<Status>, Interrupted> {
        if let Some(status) = self.begin()? {
            return Ok(Some(status));
        }
        if self.jumps {
            let t = self.t();
            if let Some(corner) = self.integrator.model().jump_near(t)
                && self.jumped_at != Some(corner)
            {
                return self.jump(corner);
            }
        }
        let steps = self.prescribed_watch.is_some().then(|| self.steps());
        let status = match &self.changes {
            None => self.single_step(Lengths::Smooth, monitor)?,
            Some(changes) if changes.jumps => self.step_over_jump(monitor)?,
            Some(_) => self.step_to_change(monitor)?,
        };
        if steps.is_some_and(|steps| self.steps() > steps) {
            self.follow_prescribed(PrescribedWatch::step)?;
        }
        Ok(self.where_grown(status))
    }

    /// Vibrations that grow about the current state, if steps are of one size.
    fn find_unstable_vibrations(&mut self) -> Option<Box<UnstableVibrations>> {
        let (scheme, dt) = (self.integrator.fixed_scheme()?, self.dt);
        self.integrator
            .observe(|model, state| UnstableVibrations::new(model, state, scheme, dt))
            .map(Box::new)
    }

    /// Why the motion is wrong, if a vibration has grown that was within the limit of stability at the start.
    fn late_instability(&mut self) -> Option<String> {
        let (vibrations, steps) = (self.find_unstable_vibrations()?, self.steps());
        self.observe(|_, state| vibrations.stop(state, steps)).map(|stop| stop.message)
    }

    /// The status after a step: at the end of an interval it is no success if the method has let a vibration grow.
    fn where_grown(&mut self, status: Option<Status>) -> Option<Status> {
        let Self { integrator, unstable_vibrations: Some(vibrations), .. } = self else { return status };
        if !status.is_some_and(Status::is_success) {
            return status;
        }
        let steps = integrator.steps();
        let Some(stop) = integrator.observe(|_, state| vibrations.stop(state, steps)) else { return status };
        Some(self.stop.insert(stop).status)
    }

    /// The energy watch, if steps are of one size.
    fn watch(&mut self) -> Option<Box<EnergyWatch>> {
        let (scheme, dt) = (self.integrator.fixed_scheme()?, self.dt);
        self.integrator.observe(|model, state| EnergyWatch::new(model, state, scheme, dt)).map(Box::new)
    }

    /// The watch on prescribed motions, if steps are of one size.
    fn follow(&mut self) -> Option<Box<PrescribedWatch>> {
        let (scheme, dt) = (self.integrator.fixed_scheme()?, self.dt);
        self.integrator.observe(|model, state| PrescribedWatch::new(model, state, scheme, dt)).map(Box::new)
    }

    fn follow_prescribed(
        &mut self,
        follow: impl FnOnce(&mut PrescribedWatch, &mut M, f64),
    ) -> Result<(), Interrupted> {
        let Self { integrator, prescribed_watch: Some(prescribed_watch), .. } = self else { return Ok(()) };
        integrator.observe(|model, state| {
            model.set_time(state.t)?;
            follow(prescribed_watch, model, state.t);
            Ok(())
        })
    }

    /// Examines the energy after a step; `supplied` is an upper bound of the energy supplied by loads.
    pub(crate) fn check_energy(&mut self, supplied: f64) -> Result<(), Interrupted> {
        let Self { integrator, energy: Some(energy), .. } = self else { return Ok(()) };
        integrator.observe(|model, state| energy.step(model, state, supplied))
    }

    /// Like [`Self::step`], with an examination of the energy.
    pub fn watched_step(
        &mut self,
        monitor: &mut dyn FnMut(f64) -> Result<(), Interrupted>,
    ) -> Result<Option<Status>, Interrupted> {
        if let Some(status) = self.begin()? {
            return Ok(Some(status));
        }
        if self.energy.is_none() {
            return self.step(monitor);
        }
        if self.steps() == 0 && self.supply.is_none() {
            self.supply = self
                .observe(|model, State { t, q, v, .. }| FlowMeter::of_supply(model, t, [q, v]))
                .map(Box::new);
        }
        let steps = self.steps();
        let status = self.step(monitor)?;
        let (flow, has_stepped) = (self.take_flow(), self.steps() > steps);
        let mut supplied = 0.0;
        if let Some(mut meter) = self.supply.take() {
            self.observe(|_, state| flow.into_iter().for_each(|flow| meter.jump(state, flow)));
            let measured = if has_stepped { self.measure(&mut meter) } else { Ok(()) };
            supplied = meter.supplied();
            self.supply = Some(meter);
            measured?;
        }
        if has_stepped {
            self.check_energy(supplied)?;
        }
        Ok(status)
    }

    /// Adds what flows in the last step to what a meter has measured before it.
    pub(crate) fn measure(&mut self, meter: &mut FlowMeter<'_>) -> Result<(), Interrupted> {
        let Self { integrator, impact_resolver, .. } = self;
        let has_bridged_jump = integrator.has_bridged_jump();
        integrator.observe(|model, state| match impact_resolver.within() {
            Some(within) => meter.steps(model, within.steps()),
            None if has_bridged_jump => meter.step_after_jump(model, state),
            None => meter.step(model, state),
        })
    }

    /// Makes velocities and accelerations jump with prescribed ones, loads and commands. What prescribes them does the work that the energies gain.
    fn jump(&mut self, corner: f64) -> Result<Option<Status>, Interrupted> {
        let before = self.observe(|model, state| -> Result<f64, Interrupted> {
            // An earlier run of the model may have passed it.
            model.pass_jump(f64::NAN);
            model.set_time(corner)?;
            Ok(model.energy(state.q, state.v).total())
        })?;
        let Some([q, v, a]) = self.integrator.after_jump(corner)? else {
            return Ok(Some(self.integrator.no_acceleration(Failure::SingularJacobian)));
        };
        self.jumped_at = Some(corner);
        self.integrator.restart([&q, &v, &a])?;
        if self.prescribed_watch.is_some() {
            self.integrator.ignore_jump();
        }
        self.follow_prescribed(|prescribed_watch, model, _| prescribed_watch.jump(model))?;
        let work = self.energy()?.total() - before;
        self.work = Some(self.work.unwrap_or(0.0) + work);
        Ok(None)
    }

    fn single_step(
        &mut self,
        lengths: Lengths,
        monitor: &mut dyn FnMut(f64) -> Result<(), Interrupted>,
    ) -> Result<Option<Status>, Interrupted> {
        let steps = self.integrator.steps();
        self.impact_resolver.begin_step();
        let status = self.integrator.step(lengths, monitor)?;
        if self.integrator.steps() > steps {
            if self.resolves_impacts {
                self.integrator.resolve_impact(&mut self.impact_resolver)?;
            }
            self.stop = match self.integrator.hold()? {
                true => self.integrator.observe(|model, state| Stop::where_invalid(model, state.t, state.q)),
                false if self.changes.is_some() => Some(Stop::at_jump_or_singular_position(self.t())),
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

    /// Ends the interval before its first step where the mass is singular. Factors of such a matrix may exist by rounding, and the
    /// accelerations from these mean nothing, however large. With constraints all methods factorise it themselves.
    fn find_mass(&mut self) -> Result<Option<Status>, Interrupted> {
        let Self { integrator, jumped, scratch, .. } = self;
        let found = integrator.observe(|model, state| {
            model.set_time(state.t)?;
            // The energies of states whose squares overflow are unknown.
            if !model.energy(state.q, state.v).total().is_finite() {
                return Ok(Some(Stop::without_energy(state.t)));
            }
            if model.facts().constraints() > 0 {
                return Ok(None);
            }
            let found = model.forward_dynamics(state.q, state.v, jumped, scratch);
            Ok(found.err().map(|SingularMass| Stop::without_mass(state.t)))
        })?;
        self.has_mass = found.is_none();
        Ok(found.map(|stop| self.stop.insert(stop).status))
    }

    /// Energy lost in changes of the active set, and work done in them and in jumps of prescribed velocities, in joules,
    /// since the last call; `None` if there was neither.
    pub(crate) fn take_flow(&mut self) -> Option<[f64; 2]> {
        let of_changes = self.changes.as_mut().and_then(|changes| changes.flow.take());
        let of_jump = self.work.take().map(|work| [0.0, work]);
        of_changes
            .into_iter()
            .chain(of_jump)
            .reduce(|[lost, work], [more_lost, more]| [lost + more_lost, work + more])
    }

    /// Shortens rotation vectors that have become longer than pi in a step, as the next step would.
    pub fn shorten_rotation_vectors(&mut self) {
        self.integrator.shorten_rotation_vectors();
    }

    /// Makes steps to the end of this interval, [shortens rotation vectors](Self::shorten_rotation_vectors), and returns the status. `monitor` is
    /// called with the time after every step, and within steps of many evaluations with that of their start; it may interrupt the interval.
    pub fn finish(
        &mut self,
        monitor: &mut dyn FnMut(f64) -> Result<(), Interrupted>,
    ) -> Result<Status, Interrupted> {
        loop {
            if let Some(status) = self.watched_step(monitor)? {
                self.shorten_rotation_vectors();
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
        self.integrator.state().1[0]
    }

    /// Current velocities.
    pub fn v(&self) -> &[f64] {
        self.integrator.state().1[1]
    }

    /// Current accelerations; at the end of an interval, with the inputs of this interval until the next one begins.
    pub fn a(&self) -> &[f64] {
        self.integrator.state().1[2]
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

    /// The attempts since the last call.
    pub(crate) fn take_retries(&mut self) -> Retries {
        self.integrator.take_retries()
    }

    /// Why the motion so far may be wrong although all steps were made: energy that fixed steps add or lose, as long as inputs are
    /// those of the start, and prescribed motions and impacts that they do not resolve.
    pub fn doubt(&mut self) -> Option<String> {
        let Self { integrator, energy, prescribed_watch, .. } = self;
        if integrator.steps() == 0 {
            return None;
        }
        let of_motion = integrator.observe(|model, state| {
            let of_energy = energy.as_ref().and_then(|energy| energy.verdict(model, state));
            of_energy.or_else(|| prescribed_watch.as_ref()?.verdict(model, state))
        });
        let of_growth = self.late_instability();
        let Self { changes, .. } = self;
        let remedy = match (self.resolves_impacts, self.may_resolve_impacts) {
            (true, _) if self.impact_resolver.is_exhausted() => Remedy::Bounded,
            (false, true) => Remedy::Resolve,
            _ => Remedy::Shorten,
        };
        let of_lengths = changes.as_ref().and_then(|changes| changes.missed).map(|(by, t)| {
            format!(
                "At t = {} s lengths of tendons that do not stretch jump against each other: one is longer by {by:.1e} of the length of what \
                 it joins. Change lengths gradually, take shorter steps, or give the tendons a `stiffness`.",
                Time(t)
            )
        });
        let Self { integrator, .. } = self;
        let known = of_growth.or(of_motion).or(of_lengths).or_else(|| integrator.doubt(remedy));
        let known = known.or_else(|| self.impact_resolver.doubt());
        let known = known.or_else(|| self.integrator.doubt_of_rods(remedy).ok().flatten());
        let of_sticking = self.static_friction_doubt();
        let Self { integrator, energy, .. } = self;
        let of_losses = |model: &mut M, state: State<'_>| energy.as_ref()?.loss_in_contact(model, state);
        known.or_else(|| integrator.observe(of_losses)).or(of_sticking)
    }

    /// Why bodies that static friction should hold may slide: in a step of fixed size from rest, where friction is still zero, they gain a
    /// velocity at which friction has begun to fall.
    fn static_friction_doubt(&mut self) -> Option<String> {
        self.integrator.fixed_scheme()?;
        let (dt, time) = (self.dt, self.integrator.model().facts().sticking_time);
        let longest = STEP_OVER_STICKING_TIME * time;
        (dt > longest).then(|| {
            format!(
                "Steps of {} s are long for static friction: in one step a body at rest gains a velocity at which friction has begun to fall, and \
                 may slide where it should stick. Take steps of at most {longest:.1e} s, a larger `stribeck_velocity`, or `method=\"radau\"`.",
                Number(dt)
            )
        })
    }

    /// Describes a status of this run, with advice unless it is a success.
    pub fn explain(&mut self, status: Status) -> String {
        if let Some(stop) = &self.stop {
            return stop.message.clone();
        }
        let cause = if status.is_success() { None } else { self.integrator.model().not_finite() };
        let mut message = match cause {
            Some(what) => format!(
                "{what}, where a finite number is needed: the result ends at t = {}.",
                Time(self.integrator.t())
            ),
            None => self.integrator.explain(status),
        };
        if self.moved > 0.0 {
            message.push_str(&Start::sentence(self.moved));
        }
        message
    }

    /// Advice about contacts that were too soft, and about the cause of a failed run: sentences, or nothing.
    pub fn advice_at_end(&mut self, status: Status, deepest: Option<Overlap>) -> String {
        if status.is_success() || status.is_interrupted() {
            return self.observe(|model, _| model.advice_at_end(&[], deepest));
        }
        self.advice_where_it_ends(deepest)
    }

    /// The same, with what touches and holds where the run ends.
    pub(crate) fn advice_where_it_ends(&mut self, deepest: Option<Overlap>) -> String {
        let dt = self.dt;
        self.observe(|model, State { q, v, a, .. }| {
            // A step into a first contact starts without contact, maybe at rest: also examine the shape after the step.
            let has_accelerations = a.iter().all(|a| a.is_finite());
            let speed = |(v, a): (&f64, &f64)| if has_accelerations { v + 0.5 * dt * a } else { *v };
            let ahead: Vec<f64> = q.iter().zip(v.iter().zip(a)).map(|(q, va)| q + dt * speed(va)).collect();
            model.advice_at_end(&[q, &ahead[..]], deepest)
        })
    }

    /// Status of an interrupted run.
    pub(crate) fn interrupted(&self) -> Status {
        self.integrator.interrupted()
    }

    /// Calls `observe` with the model and its current state.
    pub(crate) fn observe<T>(&mut self, observe: impl FnOnce(&mut M, State<'_>) -> T) -> T {
        self.integrator.observe(observe)
    }

    /// Writes the states at these times within the last step, one after another; false where they are not finite. Accelerations are
    /// those of methods that [know them](Self::knows_accelerations).
    pub(crate) fn interpolate(
        &mut self,
        times: &[f64],
        [q, v, a]: [&mut [f64]; 3],
    ) -> Result<bool, Interrupted> {
        if let Some(within) = self.impact_resolver.within() {
            let n = self.q().len();
            let motions = q.chunks_exact_mut(n).zip(v.chunks_exact_mut(n)).zip(a.chunks_exact_mut(n));
            motions.zip(times).for_each(|(((q, v), a), &t)| within.interpolate(t, [q, v, a]));
            return Ok(true);
        }
        let is_finite = self.integrator.interpolate(times, [&mut *q, &mut *v, a])?;
        if is_finite && self.changes.as_ref().is_some_and(|changes| !changes.has_jumped) {
            // Within a step, lengths are only as accurate as the step: taut tendons would seem slack.
            let model: &mut dyn Model = self.integrator.model();
            let n = model.facts().n;
            for ((q, v), &t) in q.chunks_exact_mut(n).zip(v.chunks_exact_mut(n)).zip(times) {
                model.set_time(t)?;
                let _ = projection::close(model, q).and_then(|_| projection::fit_velocities(model, q, v));
            }
        }
        Ok(is_finite)
    }

    /// Whether the method knows accelerations between the ends of its steps.
    pub(crate) fn knows_accelerations(&self) -> bool {
        self.integrator.knows_accelerations()
    }

    /// Current time, coordinates, velocities and accelerations.
    pub(crate) fn state(&self) -> (f64, [&[f64]; 3]) {
        self.integrator.state()
    }

    /// Accepted steps so far.
    pub(crate) fn steps(&self) -> usize {
        self.integrator.steps()
    }

    /// All data that persist from interval to interval, as numbers.
    pub fn memory(&mut self) -> Vec<f64> {
        let mut numbers = Vec::new();
        self.serialise(&mut Tape::writing(&mut numbers));
        numbers
    }

    /// Restores the [memory](Self::memory) of a run of the same model with the same method; the run then
    /// continues as that one does, bit for bit.
    ///
    /// Fails for an invalid memory; this run is then invalid.
    pub fn recall(&mut self, memory: &[f64]) -> Result<(), InvalidInput> {
        let mut tape = Tape::reading(memory);
        self.serialise(&mut tape);
        let is_right = tape.is_right() && self.t().is_finite();
        let (t, steps) = (self.t(), self.steps());
        let model = self.integrator.model();
        model.set_inputs(&self.inputs);
        model.pass_jump(self.jumped_at.unwrap_or(f64::NAN));
        if self.jumped_at.is_none() && steps == 0 {
            model.start_at(t);
        }
        if is_right {
            return Ok(());
        }
        let found = format_args!("{} numbers", memory.len()).to_string();
        Err(InvalidInput::new("memory", found, "those of a run of the same model by the same method"))
    }

    fn serialise(&mut self, tape: &mut Tape<'_>) {
        tape.numbers(&mut self.inputs);
        tape.flag(&mut self.inputs_have_jumped);
        tape.optional(&mut self.jumped_at, 0.0, Tape::number);
        self.grid.serialise(tape);
        self.integrator.serialise(tape);
        self.impact_resolver.serialise(tape);
        self.has_mass |= self.integrator.steps() > 0;
        self.serialise_watch(tape);
        self.serialise_changes(tape);
        self.serialise_unstable_vibrations(tape);
        // Versions before do not know it.
        if self.resolves_impacts && !tape.is_over() {
            self.impact_resolver.serialise_rounding(tape);
        }
    }

    fn serialise_unstable_vibrations(&mut self, tape: &mut Tape<'_>) {
        let Some(scheme) = self.integrator.fixed_scheme() else { return };
        // Memories of earlier versions lack it.
        if scheme.stability_limit().is_finite() && !tape.is_over() {
            let (n, blank) = (self.q().len(), Box::new(UnstableVibrations::empty(scheme, self.dt)));
            tape.optional(&mut self.unstable_vibrations, blank, |tape, vibrations| {
                vibrations.serialise(n, tape);
            });
        }
    }

    fn serialise_changes(&mut self, tape: &mut Tape<'_>) {
        let (is_fixed, has_stepped) = (self.integrator.pulls().is_some(), self.steps() > 0);
        let Some(changes) = &mut self.changes else { return };
        if is_fixed && tape.is_over() {
            // Memories of earlier versions lack it, because active sets changed within such steps: they are found again.
            (changes.has_begun, changes.due) = (has_stepped, has_stepped.then_some(None));
            return;
        }
        changes.serialise(self.integrator.model(), tape);
        if is_fixed {
            tape.numbers(&mut self.inputs_before);
            changes.serialise_jumps(tape);
        }
    }

    fn serialise_watch(&mut self, tape: &mut Tape<'_>) {
        let mut has = [self.energy.is_some(), self.supply.is_some(), self.prescribed_watch.is_some()];
        tape.flag(&mut self.is_watched);
        has.iter_mut().for_each(|flag| tape.flag(flag));
        if tape.reads() {
            let t = self.t();
            self.energy = if has[0] { self.watch() } else { None };
            self.supply = if has[1] {
                self.observe(|model, state| FlowMeter::of_supply(model, t, [state.q, state.v])).map(Box::new)
            } else {
                None
            };
            self.prescribed_watch = if has[2] { self.follow() } else { None };
        }
        self.energy.iter_mut().for_each(|energy| energy.serialise(tape));
        self.supply.iter_mut().for_each(|supply| supply.serialise(tape));
        self.prescribed_watch.iter_mut().for_each(|prescribed_watch| prescribed_watch.serialise(tape));
    }
}
