//! What is given in place of a model.

use std::path::{Path, PathBuf};

use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::{PyList, PyType};

use super::super::callback::or_raised;
use super::PyModel;
use crate::python::convert;

/// The models.
pub(crate) const MODEL: &str = "a Model (Rod, Robot, SpringPendulum)";

/// A model whose coordinates are known; anything else is refused with what makes one of it.
pub(crate) fn model_of<'a, 'py>(
    found: &'a Bound<'py, PyAny>,
    place: &str,
) -> PyResult<&'a Bound<'py, PyModel>> {
    let model = any_model_of(found, place)?;
    model.get().check_modes().map(|()| model)
}

/// The same for what chooses open modes.
pub(crate) fn any_model_of<'a, 'py>(
    found: &'a Bound<'py, PyAny>,
    place: &str,
) -> PyResult<&'a Bound<'py, PyModel>> {
    found.cast::<PyModel>().map_err(|_| not_a_model(found, place, MODEL))
}

/// The same for classes and functions in Python.
#[pyfunction]
pub(crate) fn check_model(found: &Bound<'_, PyAny>, place: &str) -> PyResult<()> {
    model_of(found, place).map(drop)
}

/// The length of a model, to which accuracies of motions are relative, and the typical sizes of its coordinates, for tolerances.
#[pyfunction]
pub(crate) fn scales_of(model: &Bound<'_, PyModel>) -> (f64, Vec<f64>) {
    model.get().inspect(|model| (model.facts().length, model.facts().typical_coordinates.clone()))
}

/// The places by which accuracies are measured, of states at these times: one after the other.
#[pyfunction]
pub(crate) fn measured_places(
    model: &Bound<'_, PyModel>,
    t: &Bound<'_, PyAny>,
    q: &Bound<'_, PyAny>,
) -> PyResult<Vec<[f64; 3]>> {
    let (times, shapes) =
        (convert::numbers(t, "t", "times")?.values, convert::numbers(q, "q", "states")?.values);
    let mut model = model.get().native();
    let n = model.facts().n;
    let mut places = Vec::new();
    for (&t, q) in times.iter().zip(shapes.chunks_exact(n.max(1))) {
        or_raised(model.set_time(t))?;
        model.places(q, &mut places);
    }
    Ok(places)
}

/// The error of what is no model.
pub(crate) fn not_a_model(found: &Bound<'_, PyAny>, place: &str, expected: &str) -> PyErr {
    let instead = instead(found).map_or_else(String::new, |instead| format!("; {instead}"));
    PyTypeError::new_err(format!("{place}: expected {expected}, got {}{instead}", convert::describe(found)))
}

/// What makes a model of it, or what to call with it.
fn instead(found: &Bound<'_, PyAny>) -> Option<String> {
    let kind = found.get_type().name().ok()?.to_string();
    if kind == "Scene" {
        return Some("`scene.run()` simulates a scene, and `scene.model` is its model".to_owned());
    }
    if let Ok(path) = found.extract::<PathBuf>() {
        return of_file(&path);
    }
    if found.is_callable() && !found.is_instance_of::<PyType>() {
        return Some("for equations of your own there are newmark and solve_ivp".to_owned());
    }
    let (part, brackets) = match found.cast::<PyList>() {
        Ok(list) => (list.get_item(0).ok()?, ["", ""]),
        Err(_) => (found.clone(), ["[", "]"]),
    };
    let (maker, what) = match part.get_type().name().ok()?.to_str().ok()? {
        "Segment" => ("Rod", "segment"),
        "Link" => ("Robot", "link"),
        _ => return None,
    };
    let [open, close] = brackets;
    let many = if open.is_empty() { "s" } else { "" };
    Some(format!("a model is `lissom.{maker}({open}{what}{many}{close})`"))
}

/// What reads a file of this name; `None` for other texts.
pub(crate) fn of_file(path: &Path) -> Option<String> {
    let shown = path.display();
    match path.extension()?.to_str()? {
        "urdf" | "xacro" | "xml" => Some(format!("`lissom.Robot.from_urdf(\"{shown}\")` reads a robot")),
        _ => Some(format!(
            "`scene = lissom.Scene.load(\"{shown}\")` reads a scene: `scene.run()` simulates it, `scene.model` is its model"
        )),
    }
}
