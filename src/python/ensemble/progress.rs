//! Reports of the number of finished runs.

use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use super::super::callback::{Form, call, requests_stop};
use super::super::convert;

/// Receiver of the number of finished runs.
pub(super) enum Progress {
    Nobody,
    Callable(Py<PyAny>),
    Bar(Py<PyAny>),
}

impl Progress {
    pub(super) fn new(py: Python<'_>, given: Option<&Bound<'_, PyAny>>, count: usize) -> PyResult<Self> {
        let Some(given) = given else { return Ok(Self::Nobody) };
        if let Ok(wanted) = given.extract::<bool>() {
            if !wanted {
                return Ok(Self::Nobody);
            }
            let arguments = PyDict::new(py);
            arguments.set_item("total", count)?;
            arguments.set_item("unit", " runs")?;
            let bar = py.import("tqdm")?.getattr("tqdm")?.call((), Some(&arguments))?;
            return Ok(Self::Bar(bar.unbind()));
        }
        if !given.is_callable() {
            let found = convert::describe(given);
            return Err(PyTypeError::new_err(format!(
                "progress: expected a bool or a callable, got {found}"
            )));
        }
        Ok(Self::Callable(given.clone().unbind()))
    }

    /// Reports progress; returns whether to stop.
    pub(super) fn report(&self, py: Python<'_>, done: usize) -> PyResult<bool> {
        match self {
            Self::Nobody => Ok(false),
            Self::Callable(function) => {
                let form = Form { name: "progress", arguments: "done", args: None };
                requests_stop(py, call(form, function.bind(py), (done,)))
            }
            Self::Bar(bar) => {
                let bar = bar.bind(py);
                let shown: usize = bar.getattr("n")?.extract()?;
                bar.call_method1("update", (done.saturating_sub(shown),))?;
                Ok(false)
            }
        }
    }

    pub(super) fn close(&self, py: Python<'_>) -> PyResult<()> {
        if let Self::Bar(bar) = self {
            bar.call_method0(py, "close")?;
        }
        Ok(())
    }
}
