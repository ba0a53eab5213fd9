//! Names that may be meant by others, and deprecated names, which are still accepted with a warning that gives the new name.

use pyo3::exceptions::{PyFutureWarning, PyTypeError};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyFloat, PyInt, PyString, PyTuple};

use crate::description::schema::{did_you_mean, suggestion, unexpected};

/// The known name that a word may mean.
#[pyfunction]
#[pyo3(name = "meant", signature = (word, known, /))]
pub(super) fn meant_in_python(word: &str, known: Vec<String>) -> Option<String> {
    suggestion(word, known.iter().map(String::as_str)).map(str::to_owned)
}

/// The end of a message about an unknown word: the name that it may mean, and what to know of its value.
#[pyfunction]
#[pyo3(name = "did_you_mean", signature = (word, known, /))]
pub(super) fn did_you_mean_in_python(word: &str, known: Vec<String>) -> Option<String> {
    did_you_mean(word, known.iter().map(String::as_str), "'")
}

/// What is said of keywords that a call does not take.
#[pyfunction]
#[pyo3(name = "unexpected_keywords", signature = (words, known, /))]
pub(super) fn unexpected_in_python(words: Vec<String>, known: Vec<String>) -> String {
    let [words, known] = [&words, &known].map(|names| names.iter().map(String::as_str).collect::<Vec<_>>());
    unexpected(&words, &known, |_| None)
}

/// Refuses keyword arguments that a function, class or method of this module, such as `Robot.pose`, does not have, with those that it has
/// and the one that may be meant.
pub(super) fn no_others(name: &str, others: Option<&Bound<'_, PyDict>>) -> PyResult<()> {
    let Some(others) = others.filter(|others| !others.is_empty()) else { return Ok(()) };
    let signature = signature_of(name, others.py())?;
    let known: Vec<_> = names_of(&signature).collect();
    let others: Vec<String> = others.keys().extract()?;
    // Some functions pass arguments of these names on.
    let others: Vec<_> = others.iter().map(String::as_str).filter(|other| !known.contains(other)).collect();
    if others.is_empty() {
        return Ok(());
    }
    Err(PyTypeError::new_err(format!("{name}() {}", unexpected(&others, &known, |_| None))))
}

/// Refuses more positional arguments than a function of this module takes, with the names by which the others are given.
pub(super) fn no_more(name: &str, more: &Bound<'_, PyTuple>) -> PyResult<()> {
    let Ok(first) = more.get_item(0) else { return Ok(()) };
    let signature = signature_of(name, more.py())?;
    let (positional, by_name) = signature.split_once(" *,").unwrap_or((&signature, ""));
    let positional: Vec<_> = names_of(positional).filter(|name| *name != "self").collect();
    let by_name: Vec<_> = names_of(by_name).collect();
    let may_be: &[&str] = match () {
        () if first.is_instance_of::<PyString>() => &["method", "link"],
        () if first.is_instance_of::<PyDict>() => &["u", "limits"],
        () if first.is_instance_of::<PyInt>() || first.is_instance_of::<PyFloat>() => &["dt", "t"],
        () if first.is_callable() => &["control", "jac"],
        () => &["q0", "u", "args"],
    };
    let meant = may_be.iter().find(|name| by_name.contains(name));
    let meant = meant.map_or_else(String::new, |meant| format!(", such as `{meant}=...`"));
    let others = match by_name.is_empty() {
        true => String::new(),
        false => format!(": give the others by name{meant}, of {}", by_name.join(", ")),
    };
    Err(PyTypeError::new_err(format!(
        "{name}() takes {} positional arguments ({}) but {} were given{others}",
        positional.len(),
        positional.join(", "),
        positional.len() + more.len(),
    )))
}

/// The signature of a function, class or method of this module as a text.
fn signature_of(name: &str, py: Python<'_>) -> PyResult<String> {
    let module = py.import("lissom._lissom")?.into_any();
    let called = name.split('.').try_fold(module, |owner, name| owner.getattr(name))?;
    called.getattr("__text_signature__")?.extract()
}

/// The arguments that a function requires, once other names, which may stand for them, and further positional arguments have been
/// refused.
macro_rules! required {
    ($function:literal, $others:expr; $more:ident, $($name:ident),+) => {{
        $crate::python::words::no_more($function, $more)?;
        $crate::python::words::required!($function, $others, $($name),+)
    }};
    ($function:literal, $others:expr, $($name:ident),+) => {{
        $crate::python::words::no_others($function, $others)?;
        $crate::python::words::no_missing($function, &[$((stringify!($name), $name.is_none())),+])?;
        ($($name.expect("nothing is missing")),+)
    }};
}
pub(super) use required;

/// What to give for arguments that other programs do not have: function, argument and remark.
const REMARKS: &[(&str, &str, &str)] = &[
    ("modes", "q", "the shape that vibrates, such as `lissom.statics(model).q`"),
    ("root", "x0", "a start of the search, such as 0.5 * (a + b) of a bracket (a, b)"),
    ("Motor", "joint", "the name of the link whose joint it drives"),
    ("newmark", "v0", "velocities at the start, such as numpy.zeros(n)"),
    ("newmark", "dt", "the size of the steps, such as dt=1e-3"),
    ("Simulation", "dt", "the size of the steps in seconds, such as dt=1e-3"),
    ("Robot.pose", "q", "the coordinates, such as numpy.zeros(robot.n) or `lissom.statics(robot).q`"),
    ("simulate", "t_end", "the end of the motion in seconds"),
];

/// Refuses a call without all required arguments: their names, and whether each is missing.
pub(super) fn no_missing(function: &str, arguments: &[(&str, bool)]) -> PyResult<()> {
    let missing = arguments.iter().filter(|(_, is_missing)| *is_missing);
    let missing: Vec<_> = missing.map(|(name, _)| format!("'{name}'")).collect();
    if missing.is_empty() {
        return Ok(());
    }
    let is_it = |(of, name, _): &&(&str, &str, &str)| *of == function && *missing == [format!("'{name}'")];
    let remark = REMARKS.iter().find(is_it).map_or_else(String::new, |(.., remark)| format!(": {remark}"));
    let missing = missing.join(", ");
    Err(PyTypeError::new_err(format!("{function}() missing required arguments: {missing}{remark}")))
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
