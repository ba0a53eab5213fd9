//! Quantities of states: of one or many rows of coordinates, velocities and accelerations, at their times and with their inputs.

use numpy::{IntoPyArray, PyArrayMethods};
use pyo3::IntoPyObjectExt;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use super::super::callback::or_raised;
use super::super::convert;
use super::super::errors::check_finite;
use super::super::inputs::numbered;
use super::super::model::{check_time, time_of_state};
use super::class::PyRobot;
use crate::model::{Dynamics as _, InTime as _};
use crate::numerics::lie::Vector;
use crate::robot::{Robot, RobotModel};

/// Number of poses computed between checks for signals; for the largest rods this takes some milliseconds.
pub(super) const POSES_BETWEEN_SIGNALS: usize = 256;

/// A moment and a force, or another pair of vectors, as six numbers.
pub(super) fn flat(halves: [Vector<f64>; 2]) -> Vec<f64> {
    halves.into_iter().flat_map(Vector::to_array).collect()
}

/// Times and inputs of states as passed from Python.
#[derive(Clone, Copy, Default)]
pub(super) struct At<'a, 'py> {
    t: Option<&'a Bound<'py, PyAny>>,
    u: Option<&'a Bound<'py, PyAny>>,
    /// Whether forces are requested; the loads at that time then matter.
    is_of_forces: bool,
}

impl<'a, 'py> At<'a, 'py> {
    /// For quantities that do not depend on forces.
    pub(super) fn time(t: Option<&'a Bound<'py, PyAny>>) -> Self {
        Self { t, u: None, is_of_forces: false }
    }

    /// For forces.
    pub(super) fn forces(t: Option<&'a Bound<'py, PyAny>>, u: Option<&'a Bound<'py, PyAny>>) -> Self {
        Self { t, u, is_of_forces: true }
    }
}

/// The inputs of states: m numbers for all states, or m for each; or these by names.
fn inputs_of_states(u: &Bound<'_, PyAny>, robot: &Robot, states: Option<usize>) -> PyResult<Vec<f64>> {
    let inputs = robot.inputs();
    let m = inputs.defaults().len();
    let u = &numbered(u, &inputs.names(), &[inputs.defaults().to_vec()], "u")?;
    let (inputs, rows) = convert::finite_rows_of(u, m, "u")?;
    if rows.is_some() && rows != states {
        let found = convert::describe(u);
        let expected = states
            .map_or_else(|| format!("shape ({m},)"), |states| format!("shape ({m},) or ({states}, {m})"));
        return Err(PyValueError::new_err(format!("u: expected {expected}, got {found}")));
    }
    Ok(inputs)
}

/// States as passed from Python, with argument names: coordinates, and velocities and accelerations if
/// needed.
pub(super) type States<'a, 'py> = [Option<(&'a Bound<'py, PyAny>, &'a str)>; 3];

/// Computes numbers of a state. A dynamic call, so that the loop over states is compiled once.
pub(super) type OfState<'a> = &'a mut dyn FnMut(&mut RobotModel, [&[f64]; 3]) -> Vec<f64>;

impl PyRobot {
    /// Evaluates `of` for every state of `model`; each result has the shape `shape`.
    pub(super) fn of_states<'py>(
        &self,
        mut model: RobotModel,
        states: States<'_, 'py>,
        at: At<'_, 'py>,
        name: &str,
        shape: &[usize],
        of: OfState<'_>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let At { t, u, is_of_forces } = at;
        let robot = self.description();
        let depends_on_time = if is_of_forces { robot.depends_on_time() } else { robot.is_moved() };
        let takes_time = is_of_forces || robot.is_prescribed();
        let n = robot.coordinates();
        let mut parts: [Vec<f64>; 3] = Default::default();
        let mut number: Option<Option<usize>> = None;
        let mut py = None;
        for (part, given) in parts.iter_mut().zip(states) {
            let Some((value, place)) = given else { continue };
            py = Some(value.py());
            let (rows, number_of_states) = convert::finite_rows_of(value, n, place)?;
            if *number.get_or_insert(number_of_states) != number_of_states {
                let found = convert::describe(value);
                return Err(PyValueError::new_err(format!("{place}: expected the shape of q, got {found}")));
            }
            *part = rows;
        }
        let (number, py) = (number.flatten(), py.expect("coordinates are always given"));
        let times = self.times(t, number, depends_on_time)?;
        let inputs = u.map(|u| inputs_of_states(u, robot, number)).transpose()?;
        let rows = number.unwrap_or(1);
        let mut values = Vec::new();
        for row in 0..rows {
            if row > 0 && row.is_multiple_of(POSES_BETWEEN_SIGNALS) {
                py.check_signals()?;
            }
            if let Some(inputs) = &inputs {
                let m = model.facts().inputs();
                model.set_inputs(inputs.get(row * m..(row + 1) * m).unwrap_or(inputs));
            }
            if takes_time {
                or_raised(model.set_time(times[row % times.len()]))?;
            }
            let state = parts.each_ref().map(|part| part.get(row * n..(row + 1) * n).unwrap_or(&[]));
            values.extend(of(&mut model, state));
        }
        check_finite(&values, name)?;
        let shape: Vec<usize> = number.into_iter().chain(shape.iter().copied()).collect();
        if shape.is_empty() {
            return values[0].into_bound_py_any(py);
        }
        Ok(values.into_pyarray(py).reshape(shape)?.into_any())
    }

    /// The time of each state, or one time for all.
    pub(super) fn times(
        &self,
        t: Option<&Bound<'_, PyAny>>,
        states: Option<usize>,
        depends_on_time: bool,
    ) -> PyResult<Vec<f64>> {
        let Some(t) = t else {
            return time_of_state(None, depends_on_time).map(|t| vec![t]);
        };
        let (times, is_number) = convert::scalar_or_vector(t, "t")?;
        if !is_number && Some(times.len()) != states {
            let expected =
                states.map_or("a number".to_owned(), |k| format!("a number or {k} times, one a state"));
            return Err(PyValueError::new_err(format!(
                "t: expected {expected}, got {}",
                convert::describe(t)
            )));
        }
        times.iter().try_for_each(|&t| check_time(t, self.span()))?;
        Ok(times)
    }
}
