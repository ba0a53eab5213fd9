//! Loops of robots: the parts that `description` describes, whose links and coordinates are resolved when a robot is made.

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyTuple;

use super::errors::at_place;
use super::link::unknown;
use super::part::{object_of, parts_of, resolved};
use super::signal::Functions;
use crate::description::schema::Data as _;
use crate::robot::effects::loops::{Loop, described};
use crate::robot::{Named, Robot, number_default_names};

/// The loops of a sequence.
pub(super) fn loops_of(loops: &Bound<'_, PyAny>, named: &Named<'_>) -> PyResult<Vec<Loop>> {
    let described: Vec<described::Loop> = parts_of(loops, "loops", &mut Functions::default())?;
    let mut found = resolved(loops.py(), "loops", &described, |it, reader| named.closed(it, reader))?;
    let are_default = described.iter().map(|it| it.name == it.default_name());
    number_default_names(found.iter_mut().map(|closed| &mut closed.name).zip(are_default));
    Ok(found)
}

/// The Python objects of the loops of a robot.
pub(super) fn loops_out<'py>(py: Python<'py>, robot: &Robot) -> PyResult<Bound<'py, PyTuple>> {
    let out = |closed: described::Loop| object_of(py, &closed.write());
    PyTuple::new(py, robot.described_loops().map(out).collect::<PyResult<Vec<_>>>()?)
}

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
