//! Contacts of robots by their names, and centre lines of tubes.

use numpy::PyArray2;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use super::convert::{self, Numbers};
use super::loops::index_of_one;
use crate::python::errors::OrRaise as _;
use crate::robot::Robot;
use crate::robot::effects::contact;

/// Index of a contact of a robot.
pub(super) fn contact_index(robot: &Robot, name: Option<&str>) -> PyResult<usize> {
    index_of_one(name, robot.contacts.iter().map(|contact| contact.name.as_str()), "contact")
}

/// Places (m, 3) along the smooth centre line of a `Tube` through points (n, 3), for drawings.
#[pyfunction]
pub(crate) fn centre_line<'py>(points: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let expected = "an array of shape (n, 3), metres";
    let Numbers { values, shape } = convert::numbers(points, "points", expected)?;
    let [_, 3] = shape[..] else {
        let found = convert::describe(points);
        return Err(PyValueError::new_err(format!("points: expected {expected}, got {found}")));
    };
    let places = contact::centre_line(values.as_chunks().0).or_raise()?;
    let rows: Vec<Vec<f64>> = places.into_iter().map(|place| place.to_vec()).collect();
    Ok(PyArray2::from_vec2(points.py(), &rows)?)
}
