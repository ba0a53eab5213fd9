//! Common arguments of computations with many rows: models, vectors and threads.

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use super::convert;
use super::inputs::numbered;
use super::model::{MODEL, PyModel, not_a_model};
use crate::numerics::parallel;

/// One vector for all rows, or a vector for each.
pub(super) struct Vectors {
    values: Vec<f64>,
    width: usize,
    is_of_all: bool,
}

impl Vectors {
    /// Reads the vectors, and their number unless one vector was given for all rows.
    pub(super) fn of_any(
        value: &Bound<'_, PyAny>,
        width: usize,
        name: &str,
    ) -> PyResult<(Self, Option<usize>)> {
        let (values, rows) = convert::finite_rows_of(value, width, name)?;
        Ok((Self { values, width, is_of_all: rows.is_none() }, rows))
    }

    pub(super) fn read(value: &Bound<'_, PyAny>, count: usize, width: usize, name: &str) -> PyResult<Self> {
        match Self::of_any(value, width, name)? {
            (_, Some(rows)) if rows != count => Err(PyValueError::new_err(format!(
                "{name}: expected shape ({width},) or ({count}, {width}), got ({rows}, {width})"
            ))),
            (vectors, _) => Ok(vectors),
        }
    }

    pub(super) fn read_optional(
        value: Option<&Bound<'_, PyAny>>,
        count: usize,
        width: usize,
        name: &str,
    ) -> PyResult<Option<Self>> {
        value.map(|value| Self::read(value, count, width, name)).transpose()
    }

    /// The vector of a row.
    pub(super) fn of(&self, row: usize) -> &[f64] {
        let start = if self.is_of_all { 0 } else { row * self.width };
        &self.values[start..start + self.width]
    }
}

/// Adds the row to the message of an error.
pub(super) fn of_row(py: Python<'_>, row: usize, error: &PyErr) -> PyErr {
    if error.is_instance_of::<PyValueError>(py) {
        return PyValueError::new_err(format!("row {row}: {}", error.value(py)));
    }
    error.clone_ref(py)
}

/// The models in a sequence; they must have the same coordinates and inputs.
pub(super) fn each(models: &Bound<'_, PyAny>) -> PyResult<Vec<Py<PyModel>>> {
    let wrong = |place: &str, found: &Bound<'_, PyAny>| {
        not_a_model(found, place, &format!("{MODEL} or a sequence of them"))
    };
    let mut found: Vec<Py<PyModel>> = Vec::new();
    for (i, row) in models.try_iter().map_err(|_| wrong("model", models))?.enumerate() {
        let row = row?;
        let model = row.cast::<PyModel>().map_err(|_| wrong(&format!("model[{i}]"), &row))?;
        model.get().check_modes()?;
        if let Some(first) = found.first() {
            check_alike(i, model.get(), first.get())?;
        }
        found.push(model.clone().unbind());
    }
    Ok(found)
}

/// Checks that a model has as many coordinates as the first one, and the same inputs.
pub(super) fn check_alike(i: usize, model: &PyModel, first: &PyModel) -> PyResult<()> {
    let ([n, expected], inputs) = ([model.n(), first.n()], model.input_names());
    if n != expected {
        let message = format!("model[{i}]: got {n} coordinates, expected {expected} as model[0] has");
        return Err(PyValueError::new_err(message));
    }
    if inputs != first.input_names() {
        let expected = first.input_names();
        let message = format!("model[{i}]: got inputs {inputs:?}, expected {expected:?} as model[0] has");
        return Err(PyValueError::new_err(message));
    }
    Ok(())
}

/// Inputs of rows with numbers in place of names, as an array-like: of one model for all rows, or of one for each.
#[pyfunction]
pub(crate) fn inputs_by_name<'py>(
    u: &Bound<'py, PyAny>,
    models: Vec<PyRef<'py, PyModel>>,
) -> PyResult<Bound<'py, PyAny>> {
    let held: Vec<_> = models.iter().map(|model| model.default_inputs()).collect();
    numbered(u, &models.first().map_or_else(Vec::new, |model| model.input_names()), &held, "u")
}

/// Number of threads; by default the number of processors.
pub(super) fn threads(workers: Option<i64>) -> PyResult<usize> {
    match workers {
        None => Ok(parallel::processors()),
        Some(workers) if workers > 0 => convert::count(workers, "workers"),
        Some(workers) => {
            Err(PyValueError::new_err(format!("workers: got {workers}, expected a whole number > 0")))
        }
    }
}
