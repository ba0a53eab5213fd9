//! Deprecated names, which are still accepted with a warning that gives the new name.

use pyo3::exceptions::PyFutureWarning;
use pyo3::prelude::*;

/// Warns that `place` uses an old name.
pub(super) fn warn_of_old_word(py: Python<'_>, place: &str, instead: &str) -> PyResult<()> {
    warn(py, &format!("{place}: an old name that the next version refuses; {instead}"))
}

/// Raises a FutureWarning at the calling line of Python.
pub(super) fn warn(py: Python<'_>, message: &str) -> PyResult<()> {
    // Unlike the function of the C API, this one accepts texts that contain NUL.
    py.import("warnings")?.call_method1("warn", (message, py.get_type::<PyFutureWarning>(), 1))?;
    Ok(())
}
