//! Common arguments of computations with many rows: models, vectors and threads.

use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;

use super::convert;
use super::model::PyModel;
use crate::parallel;

/// One vector for all rows, or a vector for each.
pub(super) struct Vectors {
    values: Vec<f64>,
    width: usize,
    is_of_all: bool,
}

impl Vectors {
    /// What is given, and how many rows it has, if it has any.
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

    /// That of a row.
    pub(super) fn of(&self, row: usize) -> &[f64] {
        let start = if self.is_of_all { 0 } else { row * self.width };
        &self.values[start..start + self.width]
    }
}

/// A refusal that says which row it is of.
pub(super) fn of_row(py: Python<'_>, row: usize, error: &PyErr) -> PyErr {
    if error.is_instance_of::<PyValueError>(py) {
        return PyValueError::new_err(format!("row {row}: {}", error.value(py)));
    }
    error.clone_ref(py)
}

/// The models of a sequence, which must be alike.
pub(super) fn each(models: &Bound<'_, PyAny>) -> PyResult<Vec<Py<PyModel>>> {
    let wrong = |place: &str, found: &Bound<'_, PyAny>| {
        PyTypeError::new_err(format!(
            "{place}: expected a Model (Rod, Robot, SpringPendulum) or a sequence of them, got {}",
            convert::describe(found)
        ))
    };
    let mut found: Vec<Py<PyModel>> = Vec::new();
    for (i, row) in models.try_iter().map_err(|_| wrong("model", models))?.enumerate() {
        let row = row?;
        let model = row.cast::<PyModel>().map_err(|_| wrong(&format!("model[{i}]"), &row))?;
        if let Some(first) = found.first() {
            check_alike(i, model.get(), first.get())?;
        }
        found.push(model.clone().unbind());
    }
    Ok(found)
}

/// Rows of one array need as many coordinates, and the same inputs.
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

/// How many threads are asked for: by default as many as there are processors.
pub(super) fn threads(workers: Option<i64>) -> PyResult<usize> {
    match workers {
        None => Ok(parallel::processors()),
        Some(workers) if workers > 0 => convert::count(workers, "workers"),
        Some(workers) => {
            Err(PyValueError::new_err(format!("workers: got {workers}, expected a whole number > 0")))
        }
    }
}
