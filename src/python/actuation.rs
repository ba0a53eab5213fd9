//! Actuators of robots: the parts that `description` describes, whose links and joints are resolved when a robot is made.

use pyo3::prelude::*;
use pyo3::types::PyTuple;

use super::part::{object_of, parts_of, resolved};
use super::signal::Functions;
use crate::description::schema::{Data as _, suggestion};
use crate::error::InvalidInput;
use crate::robot::effects::actuator::{Actuator, described};
use crate::robot::{Named, Robot, number_default_names};

/// The actuators of a sequence.
pub(super) fn actuators_of(
    actuators: &Bound<'_, PyAny>,
    named: &Named<'_>,
    functions: &mut Functions,
) -> PyResult<Vec<Actuator>> {
    let described: Vec<described::Actuator> = parts_of(actuators, "actuators", functions)?;
    let mut found =
        resolved(actuators.py(), "actuators", &described, |it, reader| named.actuator(it, reader))?;
    let are_default = described.iter().map(described::Actuator::has_default_name);
    number_default_names(found.iter_mut().map(Actuator::name_mut).zip(are_default));
    Ok(found)
}

/// Index of an actuator of a robot.
pub(super) fn actuator_index(robot: &Robot, name: &str) -> Result<usize, InvalidInput> {
    let names = || robot.actuators.iter().map(Actuator::name);
    names().position(|known| known == name).ok_or_else(|| {
        let all = names().map(|name| format!("'{name}'")).collect::<Vec<_>>().join(", ");
        let meant = suggestion(name, names());
        let meant = meant.map_or_else(String::new, |meant| format!("; did you mean '{meant}'?"));
        let expected = match all.is_empty() {
            true => "an actuator, but the robot has none".to_owned(),
            false => format!("one of the actuators: {all}{meant}"),
        };
        InvalidInput::new("name", format_args!("'{name}'"), expected)
    })
}

/// The Python objects of the actuators of a robot.
pub(super) fn actuators_out<'py>(py: Python<'py>, robot: &Robot) -> PyResult<Bound<'py, PyTuple>> {
    let out = |actuator: &Actuator| object_of(py, &robot.described_actuator(actuator).write());
    PyTuple::new(py, robot.actuators.iter().map(out).collect::<PyResult<Vec<_>>>()?)
}
