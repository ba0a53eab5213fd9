//! Exceptions of the package. Invalid input raises `ValueError` or `TypeError`; these are for failures that
//! no check can predict.

use pyo3::create_exception;
use pyo3::exceptions::{PyException, PyTypeError, PyUserWarning, PyValueError};
use pyo3::prelude::*;

use crate::error::InvalidInput;

/// Input that the core rejects, as an exception.
pub(crate) fn raise(error: InvalidInput) -> PyErr {
    PyValueError::new_err(error.to_string())
}

/// Results of the core, whose errors raise.
pub(crate) trait OrRaise<T> {
    fn or_raise(self) -> PyResult<T>;
}

impl<T> OrRaise<T> for Result<T, InvalidInput> {
    fn or_raise(self) -> PyResult<T> {
        self.map_err(raise)
    }
}

create_exception!(
    lissom,
    LissomError,
    PyException,
    "Base class of the numerical failures that lissom raises."
);

/// Rejects results that are not finite: finite input can be too large for the computation.
pub(crate) fn check_finite(values: &[f64], name: &str) -> PyResult<()> {
    if values.iter().all(|value| value.is_finite()) {
        return Ok(());
    }
    Err(LissomError::new_err(format!(
        "{name}: the result is NaN or infinite, because numbers overflow on the way: check q, qd, qdd, t and the sizes of the model"
    )))
}

create_exception!(
    lissom,
    ConvergenceError,
    LissomError,
    "A search that did not converge, raised on request; its result is the attribute `result`."
);

create_exception!(
    lissom,
    AccuracyWarning,
    PyUserWarning,
    "A run reached its end, but its result may be far from the right one."
);

/// Adds the place to the message of a refusal. Exceptions of user functions have a traceback; they are
/// unchanged except for a note with the place.
pub(super) fn at_place(py: Python<'_>, place: &str, error: PyErr) -> PyErr {
    if error.traceback(py).is_some() {
        // Some exceptions do not accept notes.
        _ = error.value(py).call_method1("add_note", (format!("in {place}"),));
        return error;
    }
    let kind = error.get_type(py);
    let is_refusal = kind.is(py.get_type::<PyValueError>()) || kind.is(py.get_type::<PyTypeError>());
    if !is_refusal {
        return error;
    }
    let has_place = |problem: &str| problem.split(' ').next().is_some_and(|word| word.ends_with(':'));
    let placed = |problem: &str| match has_place(problem) {
        true => format!("{place}.{problem}"),
        false => format!("{place}: {problem}"),
    };
    let problems: Vec<String> = error.value(py).to_string().lines().map(placed).collect();
    PyErr::from_type(kind, problems.join("\n"))
}
