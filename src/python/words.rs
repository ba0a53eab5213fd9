//! Names that may be meant by others, and deprecated names, which are still accepted with a warning that gives the new name.

use pyo3::exceptions::PyFutureWarning;
use pyo3::prelude::*;

use crate::description::schema::suggestion;

/// The known name that a word may stand for: one that ends with it (`orientation` may mean `base_orientation`), of which it is
/// the symbol, or that is spelt alike.
pub(super) fn meant<'a>(word: &str, known: impl Iterator<Item = &'a str> + Clone) -> Option<&'a str> {
    let end = format!("_{word}");
    known.clone().find(|name| name.ends_with(&end)).or_else(|| suggestion(word, known))
}

/// The known name that a word may mean.
#[pyfunction]
#[pyo3(name = "meant", signature = (word, known, /))]
pub(super) fn meant_in_python(word: &str, known: Vec<String>) -> Option<String> {
    meant(word, known.iter().map(String::as_str)).map(str::to_owned)
}

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
