//! Extraction of arguments of Python functions, one function per name:
//! `#[pyo3(from_py_with = arguments::number::mass)] mass: f64`.
//!
//! Messages must contain the name of the argument, which PyO3 does not pass to an extractor. Extractors of classes are beside the class.

use std::collections::BTreeMap;
use std::path::PathBuf;

use numpy::{IntoPyArray, PyArrayDyn, PyArrayMethods};
use pyo3::exceptions::PyValueError;
use pyo3::exceptions::{PyOSError, PyTypeError};
use pyo3::prelude::*;
use pyo3::types::PyFloat;
use pyo3::types::PyString;

use super::convert;
use crate::error::Number;

/// A module with an extractor for each name, which passes the name to a function of `convert`.
macro_rules! extractors {
    ($module:ident: $convert:path => $type:ty { $($name:ident)* }) => {
        #[allow(non_snake_case, reason = "arc lengths are called X in Python")]
        #[allow(clippy::needless_lifetimes, reason = "only texts are borrowed")]
        pub(super) mod $module {
            use super::*;
            $(pub(in super::super) fn $name<'a>(value: &'a Bound<'_, PyAny>) -> PyResult<$type> {
                $convert(value, stringify!($name))
            })*
        }
    };
}

extractors!(number: convert::number => f64 {
    X dt frequency gravity length load_factor mass memory_limit
    min_step phase rtol stiffness t t0 tol x xtol
    xtol_abs
});
extractors!(optional_number: optional_numbers => Option<f64> {
    X alpha beta control_step dt duration first_step gamma max_seconds max_step rho_inf rtol t t0
    tol
});
// Of arguments that must be given: functions first refuse keywords that they do not have.
extractors!(given_number: given_numbers => Option<f64> { dt length poisson_ratio t0 t_bound t_end });
extractors!(given_text: given_texts => Option<&'a str> { name text });
extractors!(whole: convert::whole => i64 { max_iter row });
extractors!(optional_whole: optional_wholes => Option<i64> {
    count event_samples frequencies max_iter max_steps restarts workers
});
extractors!(flag: convert::flag => bool {
    accelerate adaptive anywhere dense_output history keep_jacobian raise_on_failure reuse_jacobian stability vectorized
});
extractors!(optional_flag: optional_flags => Option<bool> { adaptive reuse_jacobian space_error });
extractors!(text: convert::text => &'a str { by controller keep link method name predictor });
extractors!(optional_text: optional_texts => Option<&'a str> { jac link name predictor });

/// The value, unless it is None.
pub(super) fn optional<'a, 'py, T>(
    value: &'a Bound<'py, PyAny>,
    name: &str,
    convert: impl FnOnce(&'a Bound<'py, PyAny>, &str) -> PyResult<T>,
) -> PyResult<Option<T>> {
    if value.is_none() { Ok(None) } else { convert(value, name).map(Some) }
}

fn optional_numbers(value: &Bound<'_, PyAny>, name: &str) -> PyResult<Option<f64>> {
    optional(value, name, convert::number)
}

fn given_numbers(value: &Bound<'_, PyAny>, name: &str) -> PyResult<Option<f64>> {
    convert::number(value, name).map(Some)
}

fn given_texts<'a>(value: &'a Bound<'_, PyAny>, name: &str) -> PyResult<Option<&'a str>> {
    convert::text(value, name).map(Some)
}

/// An argument that must be given; None is a value.
#[allow(clippy::unnecessary_wraps, reason = "extractors can fail")]
pub(super) fn given<'a, 'py>(value: &'a Bound<'py, PyAny>) -> PyResult<Option<&'a Bound<'py, PyAny>>> {
    Ok(Some(value))
}

fn optional_wholes(value: &Bound<'_, PyAny>, name: &str) -> PyResult<Option<i64>> {
    optional(value, name, convert::whole)
}

fn optional_flags(value: &Bound<'_, PyAny>, name: &str) -> PyResult<Option<bool>> {
    optional(value, name, convert::flag)
}

fn optional_texts<'a>(value: &'a Bound<'_, PyAny>, name: &str) -> PyResult<Option<&'a str>> {
    optional(value, name, convert::text)
}

/// Contents of files by name.
pub(super) fn imports(value: &Bound<'_, PyAny>) -> PyResult<Option<BTreeMap<String, Vec<u8>>>> {
    optional(value, "imports", |value, name| {
        value.extract().map_err(|_| {
            let found = convert::describe(value);
            PyTypeError::new_err(format!("{name}: expected a dict from names of files to bytes, got {found}"))
        })
    })
}

pub(super) fn callback<'a, 'py>(value: &'a Bound<'py, PyAny>) -> PyResult<Option<&'a Bound<'py, PyAny>>> {
    optional(value, "callback", convert::function)
}

pub(super) fn progress<'a, 'py>(value: &'a Bound<'py, PyAny>) -> PyResult<Option<&'a Bound<'py, PyAny>>> {
    optional(value, "progress", convert::function)
}

/// Indices of segments.
pub(super) fn segments(value: &Bound<'_, PyAny>) -> PyResult<Option<Vec<usize>>> {
    optional(value, "segments", |value, name| {
        let wrong = || {
            let found = convert::describe(value);
            PyTypeError::new_err(format!("segments: expected a sequence of whole numbers, got {found}"))
        };
        if value.is_instance_of::<PyString>() {
            return Err(wrong());
        }
        let index = |index: PyResult<Bound<'_, PyAny>>| convert::count(convert::whole(&index?, name)?, name);
        value.try_iter().map_err(|_| wrong())?.map(index).collect()
    })
}

/// The path of a file, which must be given.
pub(super) fn given_path(value: &Bound<'_, PyAny>) -> PyResult<Option<PathBuf>> {
    value.extract().map(Some).map_err(|error: PyErr| {
        if error.is_instance_of::<PyOSError>(value.py()) {
            return error;
        }
        PyTypeError::new_err(format!("path: expected a str or a path, got {}", convert::describe(value)))
    })
}

/// An array of finite numbers with any shape, for arguments of functions written in Python.
#[pyfunction]
pub(crate) fn finite_array<'py>(
    value: &Bound<'py, PyAny>,
    #[pyo3(from_py_with = text::name)] name: &str,
) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
    let convert::Numbers { values, shape } = match value.cast::<PyFloat>() {
        Ok(number) => convert::Numbers { values: vec![number.value()], shape: Vec::new() },
        Err(_) => convert::numbers(value, name, "real numbers")?,
    };
    if let Some(index) = values.iter().position(|x| !x.is_finite()) {
        let mut place = Vec::new();
        let mut rest = index;
        for &size in shape.iter().rev() {
            place.push((rest % size).to_string());
            rest /= size;
        }
        place.reverse();
        let place = if place.is_empty() { String::new() } else { format!("[{}]", place.join(", ")) };
        let found = Number(values[index]);
        return Err(PyValueError::new_err(format!("{name}{place}: got {found}, expected a finite number")));
    }
    values.into_pyarray(value.py()).reshape(shape)
}
