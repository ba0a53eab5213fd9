//! Names that may be meant by others, and deprecated names, which are still accepted with a warning that gives the new name.

use pyo3::exceptions::{PyFutureWarning, PyTypeError};
use pyo3::prelude::*;
use pyo3::types::PyDict;

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

/// Refuses keyword arguments that a function or class of this module does not have, with those that it has and the one that may be
/// meant.
pub(super) fn no_others(name: &str, others: Option<&Bound<'_, PyDict>>) -> PyResult<()> {
    let Some((key, _)) = others.into_iter().flatten().next() else { return Ok(()) };
    let module = key.py().import("lissom._lissom")?;
    let key: String = key.extract()?;
    let signature: String = module.getattr(name)?.getattr("__text_signature__")?.extract()?;
    let known: Vec<_> = names_of(&signature).collect();
    let meant = meant(&key, known.iter().copied())
        .map_or_else(String::new, |meant| format!("; did you mean '{meant}'?"));
    Err(PyTypeError::new_err(format!(
        "{name}() got an unexpected keyword argument '{key}', expected {}{meant}",
        known.join(", ")
    )))
}

/// Names of the parameters in a text such as `(model, t_end, *, t0=0.0)`.
fn names_of(signature: &str) -> impl Iterator<Item = &str> {
    let names = signature.split(',').map(|part| part.split('=').next().unwrap_or(""));
    let names = names.map(|name| name.trim_matches(['(', ')', ' ']));
    names.filter(|name| name.starts_with(|letter: char| letter.is_alphabetic()))
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
