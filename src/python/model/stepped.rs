//! Runs of models, advanced step by step, as trait objects.

use std::any::Any;

use crate::analysis::statics::Tendons;
use crate::error::{Interrupted, InvalidInput};
use crate::model;
use crate::robot::RobotModel;
use crate::simulation::accuracy::AccurateRun;
use crate::simulation::balance::State;
use crate::simulation::stepping::{Run, Status};

/// A [`Run`] with any model: one virtual call per step.
pub(crate) trait Stepped: Send + Sync {
    fn boxed_clone(&self) -> Box<dyn Stepped>;
    fn end_of(&self, duration: Option<f64>) -> Result<f64, InvalidInput>;
    fn begin_interval(&mut self, t_end: f64);
    fn set_inputs(&mut self, inputs: &[f64]);
    fn begin(&mut self) -> Result<Option<Status>, Interrupted>;
    fn watched_step(
        &mut self,
        monitor: &mut dyn FnMut(f64) -> Result<(), Interrupted>,
    ) -> Result<Option<Status>, Interrupted>;
    fn finish(
        &mut self,
        monitor: &mut dyn FnMut(f64) -> Result<(), Interrupted>,
    ) -> Result<Status, Interrupted>;
    fn shorten_rotation_vectors(&mut self);
    fn t(&self) -> f64;
    /// Coordinates, velocities and accelerations.
    fn state(&self) -> [&[f64]; 3];
    fn inputs(&self) -> &[f64];
    fn energy(&mut self) -> Result<model::Energy, Interrupted>;
    fn explain(&mut self, status: Status) -> String;
    fn doubt(&mut self) -> Option<String>;
    /// Estimated error due to the steps, relative to the length, of a simulation to an accuracy.
    fn time_error(&self) -> Option<f64>;
    fn interrupted(&self) -> Status;
    fn memory(&mut self) -> Vec<f64>;
    fn recall(&mut self, memory: &[f64]) -> Result<(), InvalidInput>;
}

impl<M: model::Model + Clone + Send + Sync + 'static> Stepped for Run<M> {
    fn boxed_clone(&self) -> Box<dyn Stepped> {
        Box::new(self.clone())
    }
    fn end_of(&self, duration: Option<f64>) -> Result<f64, InvalidInput> {
        self.end_of(duration)
    }
    fn begin_interval(&mut self, t_end: f64) {
        self.begin_interval(t_end);
    }
    fn set_inputs(&mut self, inputs: &[f64]) {
        self.set_inputs(inputs);
    }
    fn begin(&mut self) -> Result<Option<Status>, Interrupted> {
        self.begin()
    }
    fn watched_step(
        &mut self,
        monitor: &mut dyn FnMut(f64) -> Result<(), Interrupted>,
    ) -> Result<Option<Status>, Interrupted> {
        self.watched_step(monitor)
    }
    fn finish(
        &mut self,
        monitor: &mut dyn FnMut(f64) -> Result<(), Interrupted>,
    ) -> Result<Status, Interrupted> {
        self.finish(monitor)
    }
    fn shorten_rotation_vectors(&mut self) {
        self.shorten_rotation_vectors();
    }
    fn t(&self) -> f64 {
        self.t()
    }
    fn state(&self) -> [&[f64]; 3] {
        [self.q(), self.v(), self.a()]
    }
    fn inputs(&self) -> &[f64] {
        self.inputs()
    }
    fn energy(&mut self) -> Result<model::Energy, Interrupted> {
        self.energy()
    }
    fn explain(&mut self, status: Status) -> String {
        // First, while the model is where the step failed.
        let explained = self.explain(status);
        let doubt = self.doubt().map_or_else(String::new, |doubt| format!(" {doubt}"));
        let of_contact = self.advice_at_end(status, None);
        explained + &of_contact + &slack_now(self) + &doubt
    }
    fn doubt(&mut self) -> Option<String> {
        self.doubt()
    }
    fn time_error(&self) -> Option<f64> {
        None
    }
    fn interrupted(&self) -> Status {
        self.interrupted()
    }
    fn memory(&mut self) -> Vec<f64> {
        self.memory()
    }
    fn recall(&mut self, memory: &[f64]) -> Result<(), InvalidInput> {
        self.recall(memory)
    }
}

impl<M: model::Model + Clone + Send + Sync + 'static> Stepped for AccurateRun<M> {
    fn boxed_clone(&self) -> Box<dyn Stepped> {
        Box::new(self.clone())
    }
    fn end_of(&self, duration: Option<f64>) -> Result<f64, InvalidInput> {
        self.run().end_of(duration)
    }
    fn begin_interval(&mut self, t_end: f64) {
        self.begin_interval(t_end);
    }
    fn set_inputs(&mut self, inputs: &[f64]) {
        self.set_inputs(inputs);
    }
    fn begin(&mut self) -> Result<Option<Status>, Interrupted> {
        self.begin()
    }
    fn watched_step(
        &mut self,
        monitor: &mut dyn FnMut(f64) -> Result<(), Interrupted>,
    ) -> Result<Option<Status>, Interrupted> {
        self.watched_step(monitor)
    }
    fn finish(
        &mut self,
        monitor: &mut dyn FnMut(f64) -> Result<(), Interrupted>,
    ) -> Result<Status, Interrupted> {
        self.finish(monitor)
    }
    fn shorten_rotation_vectors(&mut self) {
        self.run_mut().shorten_rotation_vectors();
    }
    fn t(&self) -> f64 {
        self.run().t()
    }
    fn state(&self) -> [&[f64]; 3] {
        Stepped::state(self.run())
    }
    fn inputs(&self) -> &[f64] {
        self.run().inputs()
    }
    fn energy(&mut self) -> Result<model::Energy, Interrupted> {
        self.energy()
    }
    fn explain(&mut self, status: Status) -> String {
        let explained = self.explain(status);
        let doubt = self.doubt().map_or_else(String::new, |doubt| format!(" {doubt}"));
        let of_contact = self.run_mut().advice_at_end(status, None);
        explained + &of_contact + &slack_now(self.run_mut()) + &doubt
    }
    fn doubt(&mut self) -> Option<String> {
        self.doubt()
    }
    fn time_error(&self) -> Option<f64> {
        Some(self.time_error())
    }
    fn interrupted(&self) -> Status {
        self.run().interrupted()
    }
    fn memory(&mut self) -> Vec<f64> {
        self.memory()
    }
    fn recall(&mut self, memory: &[f64]) -> Result<(), InvalidInput> {
        self.recall(memory)
    }
}

/// Message about the tendons of a robot in a state; empty without findings.
fn slack_now<M: model::Model + Clone + 'static>(run: &mut Run<M>) -> String {
    let u = run.inputs().to_vec();
    let of_robot = |model: &mut M, state: State<'_>| {
        // On a copy, because the set of active tendons is part of the run.
        let mut robot = (model as &mut dyn Any).downcast_mut::<RobotModel>()?.clone();
        Tendons::of(&mut robot, state.q, state.t, (!u.is_empty()).then_some(&u)).ok()
    };
    let found = run.observe(of_robot);
    // Friction at rest does not matter in a motion.
    found.map_or_else(String::new, |found| Tendons { without_friction: Vec::new(), ..found }.message())
}
