//! A run in progress.

use super::control::Control;
use super::growth_errors::GrowthErrors;
use super::hard_steps::{BeforeStep, HardSteps};
use super::recorder::Recorder;
use super::watch::Watch;
use crate::error::Interrupted;
use crate::integrators::ode;
use crate::integrators::second_order::number_of_steps;
use crate::model::{Model, Overlap};
use crate::simulation::balance::{FlowMeter, Rule, State};
use crate::simulation::stepping::{Method, Run, Status, Stop};

/// A run with its recorders and checks.
pub(super) struct Runner<'a, 'c, M> {
    pub(super) run: Run<M>,
    pub(super) recorder: Recorder<'a>,
    pub(super) meter: Option<FlowMeter<'a>>,
    pub(super) watch: Watch,
    pub(super) growth_errors: Option<GrowthErrors>,
    judges_growth: bool,
    /// Reason why a check stopped the run.
    pub(super) stop: Option<Stop>,
    /// The overlap with the largest share so far, with its time.
    pub(super) deepest: Option<(f64, Overlap)>,
    pub(super) hard_steps: HardSteps,
    t_span: (f64, f64),
    control: Option<Control<'c>>,
    has_begun: bool,
}

impl<'a, 'c, M: Model> Runner<'a, 'c, M> {
    pub(super) fn new(
        run: Run<M>,
        recorder: Recorder<'a>,
        t_span: (f64, f64),
        control: Option<Control<'c>>,
        judges_growth: bool,
    ) -> Self {
        let (meter, watch, growth_errors, stop) = (None, Watch::Nothing, None, None);
        Self {
            run,
            recorder,
            meter,
            watch,
            growth_errors,
            judges_growth,
            stop,
            deepest: None,
            hard_steps: HardSteps::default(),
            t_span,
            control,
            has_begun: false,
        }
    }

    /// Runs all intervals and returns the status. States reached before a failure are recorded too.
    pub(super) fn finish(
        &mut self,
        method: &Method,
        t_eval: Option<&'a [f64]>,
        monitor: &mut dyn FnMut(f64) -> Result<(), Interrupted>,
    ) -> Status {
        let found = self.intervals(method, t_eval, monitor);
        // The controller may have failed at the end of an interval; a second failure adds nothing.
        if self.has_begun {
            let _ = self.recorder.record(&mut self.run, true);
        }
        found.unwrap_or_else(|Interrupted| self.run.interrupted())
    }

    fn intervals(
        &mut self,
        method: &Method,
        t_eval: Option<&'a [f64]>,
        monitor: &mut dyn FnMut(f64) -> Result<(), Interrupted>,
    ) -> Result<Status, Interrupted> {
        let (t0, t_end) = self.t_span;
        if let Some(status) = self.run.begin()? {
            return Ok(status);
        }
        self.has_begun = true;
        let intervals = match &self.control {
            Some(control) => number_of_steps(t_end - t0, control.step).max(1),
            None => 1,
        };
        for interval in 1..=intervals {
            if let Some(status) = self.begin_interval(interval == intervals)? {
                return Ok(status);
            }
            if interval == 1 {
                let rule = if matches!(method, Method::Newmark(_)) { Rule::Mean } else { Rule::Quintic };
                let t_span = self.t_span;
                // The run may have projected the initial state onto closed loops.
                self.meter = self
                    .run
                    .observe(|model, state| FlowMeter::new(model, rule, t0, [state.q, state.v], t_eval));
                self.watch = self
                    .run
                    .observe(|model, State { q, v, a, .. }| Watch::new(model, t_span, [q, v, a], method));
                if self.judges_growth {
                    self.growth_errors = self.run.observe(|model, State { q, v, a, .. }| {
                        GrowthErrors::new(model, t_span, [q, v, a], method)
                    });
                }
            }
            self.recorder.record(&mut self.run, true)?;
            let status = self.finish_interval(interval == intervals, monitor)?;
            if interval == intervals || !status.is_success() {
                return Ok(status);
            }
        }
        unreachable!("the last interval returns")
    }

    /// Calls the controller, if there is one, and records jumps caused by new inputs.
    fn begin_interval(&mut self, is_last: bool) -> Result<Option<Status>, Interrupted> {
        let Some(control) = &mut self.control else { return Ok(None) };
        let end = if is_last { None } else { self.run.end_of(Some(control.step)).ok() };
        self.run.begin_interval(end.unwrap_or(self.t_span.1));
        self.run.shorten_rotation_vectors();
        let mut inputs = self.run.inputs().to_vec();
        (control.inputs)(self.run.t(), self.run.q(), self.run.v(), &mut inputs)?;
        if inputs == self.run.inputs() {
            return Ok(None);
        }
        let before = self.run.energy()?.total();
        self.run.set_inputs(&inputs);
        let work = self.run.energy()?.total() - before;
        let status = self.run.begin()?;
        let [dissipated, of_impact] = self.run.take_flow().unwrap_or_default();
        if let Some(meter) = &mut self.meter {
            self.run.observe(|_, state| meter.jump(state, [dissipated, work + of_impact]));
        }
        Ok(status)
    }

    fn finish_interval(
        &mut self,
        is_last: bool,
        monitor: &mut dyn FnMut(f64) -> Result<(), Interrupted>,
    ) -> Result<Status, Interrupted> {
        let mut before = BeforeStep::new(&self.run);
        loop {
            let status = self.run.step(monitor)?;
            if let (Some(flow), Some(meter)) = (self.run.take_flow(), &mut self.meter) {
                self.run.observe(|_, state| meter.jump(state, flow));
            }
            let steps = self.run.steps();
            if steps > before.steps() {
                // Before another interval, accelerations and inputs of this state are recorded after the
                // controller's call.
                let is_followed = !is_last && status.is_some_and(Status::is_success);
                // Before other shapes than that at the end of the step are evaluated.
                let overlap = self.record_deepest_overlap()?;
                before = self.hard_steps.record(&mut self.run, &before, overlap);
                let is_finite = self.recorder.record(&mut self.run, !is_followed)?;
                let Self { run, meter, watch, growth_errors, stop, .. } = self;
                if let Some(meter) = meter {
                    run.measure(meter)?;
                }
                *stop = run.observe(|model, state| {
                    if let Some(growth_errors) = growth_errors {
                        growth_errors.step(model, state);
                    }
                    watch.check(model, state, steps)
                });
                run.check_energy(meter.as_ref().map_or(0.0, FlowMeter::supplied))?;
                if !is_finite {
                    return Ok(Status::FirstOrder(ode::Status::NonFinite));
                }
                if status.is_none_or(Status::is_success) {
                    if let Some(stop) = &self.stop {
                        return Ok(stop.status);
                    }
                    monitor(self.run.t())?;
                }
            }
            if let Some(status) = status {
                if steps == before.steps() && !status.is_success() {
                    // The step that could not be made.
                    let overlap = self.record_deepest_overlap()?;
                    self.hard_steps.record(&mut self.run, &before, overlap);
                }
                return Ok(status);
            }
        }
    }

    /// Records the deepest overlap, and returns that of the current state.
    fn record_deepest_overlap(&mut self) -> Result<Option<Overlap>, Interrupted> {
        let Self { run, deepest, .. } = self;
        run.observe(|model, state| {
            if !(model.facts().has_contact && model.may_touch()) {
                return Ok(None);
            }
            if model.facts().varies_in_time {
                model.set_time(state.t)?;
            }
            let found = model.deepest_overlap(state.q);
            if let Some(found) =
                found.filter(|found| deepest.is_none_or(|(_, known)| found.share > known.share))
            {
                *deepest = Some((state.t, found));
            }
            Ok(found)
        })
    }
}
