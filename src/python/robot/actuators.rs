//! Lengths and forces of actuators.

use pyo3::prelude::*;

use super::super::actuation::actuator_index;
use super::class::PyRobot;
use super::states::At;
use crate::python::errors::OrRaise as _;
use crate::robot::RobotModel;

/// Length of an actuator.
pub(super) fn length<'py>(
    robot: &PyRobot,
    name: &str,
    q: &Bound<'py, PyAny>,
    t: Option<&Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyAny>> {
    let i = actuator_index(robot.description(), name).or_raise()?;
    let n = robot.description().coordinates();
    let (zeros, mut gradient) = (vec![0.0; n], vec![0.0; n]);
    robot.of_states(
        robot.model()?,
        [Some((q, "q")), None, None],
        At::time(t),
        "actuator_length",
        &[],
        &mut |model, [q, ..]| vec![model.actuator(q, &zeros, i, &mut gradient)[0]],
    )
}

/// Rate of change of an actuator's length.
pub(super) fn rate<'py>(
    robot: &PyRobot,
    name: &str,
    [q, qd]: [&Bound<'py, PyAny>; 2],
    t: Option<&Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyAny>> {
    let i = actuator_index(robot.description(), name).or_raise()?;
    let mut gradient = vec![0.0; robot.description().coordinates()];
    let states = [Some((q, "q")), Some((qd, "qd")), None];
    robot.of_states(robot.model()?, states, At::time(t), "actuator_rate", &[], &mut |model, [q, qd, _]| {
        vec![model.actuator(q, qd, i, &mut gradient)[1]]
    })
}

/// Derivative of an actuator's length with respect to the coordinates.
pub(super) fn gradient<'py>(
    robot: &PyRobot,
    name: &str,
    q: &Bound<'py, PyAny>,
    t: Option<&Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyAny>> {
    let i = actuator_index(robot.description(), name).or_raise()?;
    let n = robot.description().coordinates();
    let (zeros, mut gradient) = (vec![0.0; n], vec![0.0; n]);
    let states = [Some((q, "q")), None, None];
    robot.of_states(robot.model()?, states, At::time(t), "actuator_gradient", &[n], &mut |model, [q, ..]| {
        model.actuator(q, &zeros, i, &mut gradient);
        gradient.clone()
    })
}

/// Force of an actuator.
pub(super) fn force<'py>(
    robot: &PyRobot,
    name: &str,
    [q, qd]: [&Bound<'py, PyAny>; 2],
    qdd: Option<&Bound<'py, PyAny>>,
    at: At<'_, 'py>,
) -> PyResult<Bound<'py, PyAny>> {
    let i = actuator_index(robot.description(), name).or_raise()?;
    let actuator = &robot.description().actuators[i];
    let sign = if actuator.pulls() { 1.0 } else { -1.0 };
    let mut gradient = vec![0.0; robot.description().coordinates()];
    let states = [Some((q, "q")), Some((qd, "qd")), qdd.map(|qdd| (qdd, "qdd"))];
    if actuator.is_inextensible() {
        let mut tension = |model: &mut RobotModel, [q, qd, qdd]: [&[f64]; 3]| {
            let qdd = (!qdd.is_empty()).then_some(qdd);
            vec![model.held_tension(q, qd, qdd, i).unwrap_or(f64::NAN)]
        };
        return robot.of_states(robot.model()?, states, at, "actuator_force", &[], &mut tension);
    }
    robot.of_states(robot.model()?, states, at, "actuator_force", &[], &mut |model, [q, qd, _]| {
        vec![sign * model.actuator(q, qd, i, &mut gradient)[2]]
    })
}
