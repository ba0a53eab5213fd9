//! The places whose poses are recorded.

use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;

use super::super::convert;
use super::super::model::PyModel;
use super::super::robot::PyRobot;
use super::super::rows::of_row;
use super::models::Models;
use crate::python::errors::OrRaise as _;
use crate::simulation::ensemble::Keep;

/// A place on a link, by the index of the link: at an arc length, or the tip.
pub(super) type OnLink = (usize, Option<f64>);

/// The recorded places, of the single model or of each; None without places.
pub(super) fn places_of(
    py: Python<'_>,
    models: &Models,
    count: usize,
    given: Option<&Bound<'_, PyAny>>,
    keep: Keep,
) -> PyResult<Vec<Vec<OnLink>>> {
    if given.is_none() && keep != Keep::Summary {
        return Ok(Vec::new());
    }
    let rows = if models.rows().is_some() { count } else { 1 };
    let mut all: Vec<Vec<OnLink>> = Vec::with_capacity(rows);
    for row in 0..rows {
        let of_model = places_of_model(models.of_row(row).bind(py), given);
        all.push(of_model.map_err(|error| if rows > 1 { of_row(py, row, &error) } else { error })?);
    }
    Ok(all)
}

fn places_of_model(model: &Bound<'_, PyModel>, given: Option<&Bound<'_, PyAny>>) -> PyResult<Vec<OnLink>> {
    let robot = model.cast::<PyRobot>().ok();
    let links = robot.map_or(1, |robot| robot.get().description().links.len());
    let Some(given) = given else { return Ok(vec![(links - 1, None)]) };
    let Some(robot) = robot else {
        return Err(PyTypeError::new_err("places: this model has no links: leave `places` out"));
    };
    let robot = robot.get();
    let expected = "arc lengths, names of links, or pairs (link, arc length)";
    let wrong = |place: &str, found: &Bound<'_, PyAny>| {
        PyTypeError::new_err(format!("{place}: expected {expected}, got {}", convert::describe(found)))
    };
    if given.is_instance_of::<pyo3::types::PyString>() {
        return Err(wrong("places", given));
    }
    let mut places = Vec::new();
    for (i, item) in given.try_iter().map_err(|_| wrong("places", given))?.enumerate() {
        let (item, place) = (item?, format!("places[{i}]"));
        let (name, x): (Option<String>, Option<f64>) = if let Ok(name) = item.extract::<String>() {
            (Some(name), None)
        } else if let Ok((name, x)) = item.extract::<(String, Bound<'_, PyAny>)>() {
            (Some(name), Some(convert::number(&x, &place).map_err(|_| wrong(&place, &item))?))
        } else {
            (None, Some(convert::number(&item, &place).map_err(|_| wrong(&place, &item))?))
        };
        let link = robot.description().link_named(name.as_deref(), &place).or_raise()?;
        robot
            .check_place(link, x)
            .map_err(|error| PyValueError::new_err(format!("{place}: {}", error.value(item.py()))))?;
        places.push((link, x));
    }
    Ok(places)
}
