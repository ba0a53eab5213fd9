//! Loops of robots by their names, and other parts that have names.

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use super::errors::at_place;
use crate::description::schema::or_meant;
use crate::robot::Robot;

/// Index of a loop of a robot.
pub(super) fn loop_index(robot: &Robot, name: Option<&str>) -> PyResult<usize> {
    index_of_one(name, robot.loops.iter().map(|closed| closed.name.as_str()), "loop")
}

/// Index of a part of a robot, of which there are several with these names; `kind` is that of the part.
pub(super) fn index_of_one<'a>(
    name: Option<&str>,
    names: impl ExactSizeIterator<Item = &'a str> + Clone,
    kind: &str,
) -> PyResult<usize> {
    let Some(name) = name else {
        return match names.len() {
            1 => Ok(0),
            many => Err(PyValueError::new_err(format!(
                "name: got nothing, expected the name of one of the {many} {kind}s of the robot"
            ))),
        };
    };
    names.clone().position(|known| known == name).ok_or_else(|| {
        let error = unknown(name, names, &format!("a {kind}"));
        Python::attach(|py| at_place(py, "name", error))
    })
}

/// The refusal of a name that no part of a robot has; `what` is the kind of the part.
fn unknown<'a>(name: &str, known: impl Iterator<Item = &'a str>, what: &str) -> PyErr {
    let meant = or_meant(name, known);
    PyValueError::new_err(format!("got '{name}', expected the name of {what} of the robot{meant}"))
}
