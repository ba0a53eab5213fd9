//! The runs of an ensemble, row by row: checked, computed and observed.

use std::sync::{Mutex, PoisonError};

use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;

use super::super::callback::raised_by_function;
use super::super::choice::with_python_names;
use super::super::convert;
use super::super::model::Native;
use super::super::rows::{Vectors, of_row};
use super::inputs::Inputs;
use super::models::Models;
use super::places::OnLink;
use crate::description::signal::Cell;
use crate::error::{Interrupted, InvalidInput};
use crate::numerics::lie::{Quaternion, Vector};
use crate::python::errors::raise;
use crate::robot::{Place, Pose};
use crate::simulation::ensemble;
use crate::simulation::ensemble::{Keep, Monitor, Refusal, Run};
use crate::simulation::methods::Configuration;
use crate::simulation::simulate::{Control, Simulation, add_overloads, creep, slackness, times_of_run};
use crate::simulation::time_limit::TimeLimit;

/// Arguments of all runs.
pub(super) struct Rows {
    pub(super) models: Models,
    /// Places of the single model, or of each model.
    pub(super) places: Vec<Vec<OnLink>>,
    pub(super) t_span: (f64, f64),
    pub(super) q0: Option<Vectors>,
    pub(super) v0: Option<Vectors>,
    pub(super) zeros: Vec<f64>,
    pub(super) inputs: Inputs,
    pub(super) configuration: Configuration,
    pub(super) t_eval: Option<Vec<f64>>,
    /// Limit of each run.
    pub(super) limit: TimeLimit,
    pub(super) keep: Keep,
    /// First exception of a function of time.
    pub(super) of_function: Mutex<Option<PyErr>>,
}

/// Times of all rows.
pub(super) struct Times {
    pub(super) of_rows: Vec<f64>,
    /// Whether steps of some rows end at other times, too.
    pub(super) differ: bool,
}

impl Rows {
    fn start(&self, row: usize) -> [&[f64]; 2] {
        [&self.q0, &self.v0].map(|given| given.as_ref().map_or(self.zeros.as_slice(), |given| given.of(row)))
    }

    /// Rejects invalid arguments of any row; returns the times of all rows.
    pub(super) fn check(&self, py: Python<'_>, count: usize) -> PyResult<Times> {
        let mut last: Option<(*mut pyo3::ffi::PyObject, Box<dyn Native>)> = None;
        let (mut times, mut differ) = (None, false);
        for row in 0..count.max(1) {
            if row % ROWS_BETWEEN_SIGNALS == 0 {
                py.check_signals()?;
            }
            let model = self.models.of_row(row);
            // Without rows there are no initial states, but the other arguments are checked.
            let [q0, v0] = if count == 0 { [self.zeros.as_slice(); 2] } else { self.start(row) };
            let is_new = last.as_ref().is_none_or(|(before, _)| *before != model.as_ptr());
            let checked = if is_new {
                let mut native = model.get().native();
                let checked = self.check_all(&mut *native, [q0, v0], &mut times).map(|other| differ |= other);
                last = Some((model.as_ptr(), native));
                checked
            } else {
                last.as_mut().map_or(Ok(()), |(_, native)| native.check_shape(q0, "q0"))
            };
            checked.map_err(|error| {
                let error = raise(with_python_names(error));
                // Do not mention a row if the problem concerns all rows.
                if count > 1 && (row > 0 || error.value(py).to_string().starts_with("q0")) {
                    of_row(py, row, &error)
                } else {
                    error
                }
            })?;
        }
        match times {
            Some(of_rows) => Ok(Times { of_rows, differ: differ && self.keep != Keep::Final }),
            None if self.keep == Keep::Final => Ok(Times { of_rows: vec![self.t_span.1], differ: false }),
            None => Err(PyTypeError::new_err(
                "t_eval: missing: adaptive steps end at times of their own in every row; give the times that are wanted, or keep=\"final\"",
            )),
        }
    }

    /// Whether its steps end at other times than those of the models before; then `times` are without the corners of tables.
    fn check_all(
        &self,
        model: &mut dyn Native,
        [q0, v0]: [&[f64]; 2],
        times: &mut Option<Vec<f64>>,
    ) -> Result<bool, InvalidInput> {
        let (t_span, t_eval) = (self.t_span, self.t_eval.as_deref());
        match &self.configuration {
            Configuration::Accuracy(request) => {
                *times =
                    Some(model.check_to_accuracy(t_span, q0, v0, *request, t_eval, self.inputs.step())?);
            }
            Configuration::Method(method) => {
                let step = self.inputs.step();
                model.check(t_span, q0, v0, method, t_eval, step)?;
                let of_run = |corner: &dyn Fn(Cell) -> Option<f64>| {
                    times_of_run(model.facts().n, t_span, method, t_eval, step, corner)
                };
                let own = of_run(&|cell| model.corner(cell))?;
                let differs = times.is_some() && *times != own;
                *times = if differs { of_run(&|_| None)? } else { own };
                return Ok(differs);
            }
        }
        Ok(false)
    }

    /// Computes the run of a row, in any thread.
    pub(super) fn run(&self, row: usize, monitor: &mut Monitor<'_>) -> Result<Run, Refusal> {
        let model = self.models.of_row(row).get().native();
        let [q0, v0] = self.start(row);
        let t_eval = self.t_eval.as_deref();
        let mut limit = self.limit.again();
        let monitor = &mut |t| {
            limit.check(t)?;
            monitor(t)
        };
        let simulated = match &self.configuration {
            Configuration::Accuracy(request) => {
                let inputs = self.inputs.of_row(row);
                model.boxed_clone().simulate_to_accuracy(
                    self.t_span,
                    [q0, v0],
                    *request,
                    t_eval,
                    inputs,
                    monitor,
                )
            }
            Configuration::Method(method) => {
                let mut steps = 0;
                let mut set = |_: f64, _: &[f64], _: &[f64], inputs: &mut [f64]| {
                    inputs.copy_from_slice(self.inputs.at(row, steps));
                    steps += 1;
                    Ok(())
                };
                let control = self.inputs.step().map(|step| Control { step, inputs: &mut set });
                let simulated =
                    model.boxed_clone().simulate(self.t_span, q0, v0, method, t_eval, control, monitor);
                simulated.map(|simulation| (simulation, None))
            }
        };
        let (mut simulation, replacement) = simulated.map_err(Refusal::Input)?;
        limit.judge(&mut simulation);
        let model = &mut *replacement.unwrap_or(model);
        let mut run = Run { simulation, slack: Vec::new(), poses: Vec::new() };
        let observed = raised_by_function().and_then(|()| {
            // Its exception is handled below.
            let _ = self.observe(model, row, &mut run);
            raised_by_function()
        });
        match observed {
            Ok(()) => Ok(run),
            Err(error) => {
                self.of_function.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(error);
                Err(Refusal::Ended(Box::new(run)))
            }
        }
    }

    /// Computes additional data of a motion.
    fn observe(&self, model: &mut dyn Native, row: usize, run: &mut Run) -> Result<(), Interrupted> {
        let Run { simulation, slack, poses } = run;
        let from = if self.keep == Keep::Final { simulation.t.len().saturating_sub(1) } else { 0 };
        let places = self.places.get(row).or(self.places.first()).map_or(&[][..], Vec::as_slice);
        if let Some(robot) = model.robot_model() {
            *slack = slackness(robot, simulation)?;
            add_overloads(robot, simulation)?;
            if let Some(doubt) = creep(robot, simulation)? {
                simulation.add_doubt(&doubt);
            }
            let places: Vec<Place> = places.iter().map(|&(link, x)| robot.place_on(link, x)).collect();
            if !places.is_empty() {
                let found = ensemble::poses(robot, simulation, &places, from)?;
                *poses = found.iter().flat_map(convert::homogeneous).collect();
            }
        } else if !places.is_empty() {
            *poses = tips(model, simulation, from);
        }
        Ok(())
    }
}

/// The tip of a model without links, as poses without rotation.
fn tips(model: &mut dyn Native, simulation: &Simulation, from: usize) -> Vec<f64> {
    let tips = ensemble::tips(model, simulation, from);
    let poses = tips.into_iter().map(|tip| Pose {
        rotation: Quaternion::from_array([1.0, 0.0, 0.0, 0.0]).rotation(),
        position: Vector::new(tip[0], tip[1], tip[2]),
    });
    poses.flat_map(|pose| convert::homogeneous(&pose)).collect()
}

/// Number of rows between two checks for signals.
const ROWS_BETWEEN_SIGNALS: usize = 256;
