//! Models of the core as trait objects, and their runs.

use std::any::Any;

use super::stepped::Stepped;
use crate::analysis::refined_modes::{self, RefinedModes};
use crate::analysis::statics::{self, Effort, Equilibrium, Path, Rest, SpaceError};
use crate::error::{Interrupted, InvalidInput};
use crate::integrators::ode;
use crate::integrators::ode::FirstOrder;
use crate::model;
use crate::robot::{Robot, RobotModel};
use crate::simulation::accuracy;
use crate::simulation::methods::Configuration;
use crate::simulation::simulate;
use crate::simulation::simulate::{Control, Simulation};
use crate::simulation::stepping::Run;

/// A native model as a trait object.
///
/// Runs are methods of this trait, so that their loops are compiled for the concrete model type: one virtual
/// call per run instead of several per step.
pub(crate) trait Native: model::Model + Send + Sync {
    /// A copy with separate scratch memory for a run, so that several runs of one model can proceed in
    /// parallel.
    fn boxed_clone(&self) -> Box<dyn Native>;

    /// The free motion of a copy as a first-order system.
    fn first_order(&self) -> Box<dyn ode::FirstOrderSystem + Send + Sync>;

    /// [`simulate::simulate`], or [`simulate::simulate_controlled`].
    #[allow(clippy::too_many_arguments, reason = "those of the core")]
    fn simulate(
        self: Box<Self>,
        t_span: (f64, f64),
        q0: &[f64],
        v0: &[f64],
        method: &simulate::Method,
        t_eval: Option<&[f64]>,
        control: Option<Control<'_>>,
        monitor: &mut dyn FnMut(f64) -> Result<(), Interrupted>,
    ) -> Result<Simulation, InvalidInput>;

    /// [`accuracy::simulate_to_accuracy`], and the model that replaced it, if any.
    fn simulate_to_accuracy(
        self: Box<Self>,
        t_span: (f64, f64),
        start: [&[f64]; 2],
        request: accuracy::Request,
        t_eval: Option<&[f64]>,
        inputs: accuracy::Inputs<'_>,
        monitor: &mut dyn FnMut(f64) -> Result<(), Interrupted>,
    ) -> Result<(Simulation, Option<Box<dyn Native>>), InvalidInput>;

    /// [`simulate::check`] of a copy.
    fn check(
        &self,
        t_span: (f64, f64),
        q0: &[f64],
        v0: &[f64],
        method: &simulate::Method,
        t_eval: Option<&[f64]>,
        control_step: Option<f64>,
    ) -> Result<(), InvalidInput>;

    /// [`accuracy::check`].
    fn check_to_accuracy(
        &mut self,
        t_span: (f64, f64),
        q0: &[f64],
        v0: &[f64],
        request: accuracy::Request,
        t_eval: Option<&[f64]>,
        control_step: Option<f64>,
    ) -> Result<Vec<f64>, InvalidInput>;

    /// A [run](Run) of a copy, or one [to an accuracy](accuracy::AccurateRun), advanced step by step.
    fn run(
        &self,
        t_span: (f64, f64),
        q0: &[f64],
        v0: &[f64],
        configuration: &Configuration,
    ) -> Result<Box<dyn Stepped>, InvalidInput>;

    /// [`statics::space_error`].
    fn space_error(
        &mut self,
        found: &Equilibrium,
        at: (f64, Option<&[f64]>),
        effort: Effort,
    ) -> Result<Option<SpaceError>, Interrupted>;

    /// [`statics::error_along`].
    fn error_along(
        &mut self,
        path: &Path,
        at: (f64, Option<&[f64]>),
    ) -> Result<Option<(usize, SpaceError)>, Interrupted>;

    /// [`statics::error_at_rest`] with little effort, if the shape is an equilibrium.
    fn error_of_shape(
        &mut self,
        rest: Rest<'_>,
        at: (f64, Option<&[f64]>),
    ) -> Result<Option<SpaceError>, Interrupted>;

    /// [`refined_modes::refined_modes`].
    fn refined_modes(
        &mut self,
        q: &[f64],
        at: (f64, Option<&[f64]>),
    ) -> Result<Option<RefinedModes>, Interrupted>;

    /// The description, for a robot.
    fn robot(&self) -> Option<&Robot>;

    /// The model as a robot, if it is one.
    fn robot_model(&mut self) -> Option<&mut RobotModel>;
}

impl<M: model::Model + Clone + Send + Sync + 'static> Native for M {
    fn boxed_clone(&self) -> Box<dyn Native> {
        Box::new(self.clone())
    }

    fn first_order(&self) -> Box<dyn ode::FirstOrderSystem + Send + Sync> {
        Box::new(FirstOrder::new(self.clone()))
    }

    fn simulate(
        self: Box<Self>,
        t_span: (f64, f64),
        q0: &[f64],
        v0: &[f64],
        method: &simulate::Method,
        t_eval: Option<&[f64]>,
        control: Option<Control<'_>>,
        monitor: &mut dyn FnMut(f64) -> Result<(), Interrupted>,
    ) -> Result<Simulation, InvalidInput> {
        let model = *self;
        match control {
            Some(control) => {
                simulate::simulate_controlled(model, t_span, q0, v0, method, t_eval, control, monitor)
            }
            None => simulate::simulate(model, t_span, q0, v0, method, t_eval, monitor),
        }
    }

    fn run(
        &self,
        t_span: (f64, f64),
        q0: &[f64],
        v0: &[f64],
        configuration: &Configuration,
    ) -> Result<Box<dyn Stepped>, InvalidInput> {
        let model = self.clone();
        Ok(match configuration {
            Configuration::Method(method) => Box::new(Run::new(model, t_span, q0, v0, method)?),
            Configuration::Accuracy(request) => {
                Box::new(accuracy::AccurateRun::new(model, t_span, q0, v0, *request)?)
            }
        })
    }

    fn simulate_to_accuracy(
        self: Box<Self>,
        t_span: (f64, f64),
        start: [&[f64]; 2],
        request: accuracy::Request,
        t_eval: Option<&[f64]>,
        inputs: accuracy::Inputs<'_>,
        monitor: &mut dyn FnMut(f64) -> Result<(), Interrupted>,
    ) -> Result<(Simulation, Option<Box<dyn Native>>), InvalidInput> {
        let (simulation, model) =
            accuracy::simulate_to_accuracy(*self, t_span, start, request, t_eval, inputs, monitor)?;
        Ok((simulation, model.map(|model| Box::new(model) as Box<dyn Native>)))
    }

    fn check(
        &self,
        t_span: (f64, f64),
        q0: &[f64],
        v0: &[f64],
        method: &simulate::Method,
        t_eval: Option<&[f64]>,
        control_step: Option<f64>,
    ) -> Result<(), InvalidInput> {
        simulate::check(self.clone(), t_span, q0, v0, method, t_eval, control_step)
    }

    fn check_to_accuracy(
        &mut self,
        t_span: (f64, f64),
        q0: &[f64],
        v0: &[f64],
        request: accuracy::Request,
        t_eval: Option<&[f64]>,
        control_step: Option<f64>,
    ) -> Result<Vec<f64>, InvalidInput> {
        accuracy::check(self, t_span, [q0, v0], request, t_eval, control_step)
    }

    fn space_error(
        &mut self,
        found: &Equilibrium,
        at: (f64, Option<&[f64]>),
        effort: Effort,
    ) -> Result<Option<SpaceError>, Interrupted> {
        statics::space_error(self, found, at, effort)
    }

    fn error_along(
        &mut self,
        path: &Path,
        at: (f64, Option<&[f64]>),
    ) -> Result<Option<(usize, SpaceError)>, Interrupted> {
        statics::error_along(self, path, at)
    }

    fn error_of_shape(
        &mut self,
        rest: Rest<'_>,
        at: (f64, Option<&[f64]>),
    ) -> Result<Option<SpaceError>, Interrupted> {
        if !statics::is_at_rest(self, rest.q) {
            return Ok(None);
        }
        statics::error_at_rest(self, rest, at, Effort::Little)
    }

    fn refined_modes(
        &mut self,
        q: &[f64],
        at: (f64, Option<&[f64]>),
    ) -> Result<Option<RefinedModes>, Interrupted> {
        refined_modes::refined_modes(self, q, at)
    }

    fn robot(&self) -> Option<&Robot> {
        (self as &dyn Any).downcast_ref().map(RobotModel::description)
    }

    fn robot_model(&mut self) -> Option<&mut RobotModel> {
        (self as &mut dyn Any).downcast_mut()
    }
}
