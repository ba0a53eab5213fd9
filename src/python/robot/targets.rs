//! Shapes in which links have given poses.

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyString;

use super::super::callback::or_raised;
use super::super::model::{check_time, time_of_state};
use super::super::reach::{PoseArguments, PyReachResult, ReachArguments, search};
use super::class::PyRobot;
use crate::model::InTime as _;

/// Inverse kinematics: of the link `link`, or of several.
pub(super) fn reach<'py>(
    robot: &PyRobot,
    link: &Bound<'py, PyAny>,
    pose: Option<&Bound<'py, PyAny>>,
    (x, point): (Option<f64>, Option<&Bound<'py, PyAny>>),
    weights: [Option<&Bound<'py, PyAny>>; 2],
    arguments: &ReachArguments<'_, 'py>,
    t: Option<f64>,
) -> PyResult<PyReachResult> {
    let single = pose.map(|pose| PoseArguments { pose, at: x, point, weights });
    let of_one = x.is_some() || point.is_some() || weights.iter().any(Option::is_some);
    let is_one = link.is_none() || link.is_instance_of::<PyString>();
    if !is_one && (pose.is_some() || of_one) {
        return Err(PyValueError::new_err(
            "pose: leave out pose, X, point and weights beside several targets: each lissom.Target has its own",
        ));
    }
    let time = time_of_state(t, robot.description().is_moved())?;
    let mut model = robot.model()?;
    if robot.description().is_prescribed() {
        check_time(time, robot.span())?;
        or_raised(model.set_time(time))?;
    }
    search(link.py(), model, link, single.as_ref(), arguments)
}
