//! Exceptions of the package. Invalid input raises `ValueError` or `TypeError`; these are for failures that
//! no check can predict.

use pyo3::create_exception;
use pyo3::exceptions::{PyException, PyUserWarning};
use pyo3::prelude::*;

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
