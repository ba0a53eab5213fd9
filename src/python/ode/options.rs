//! The options of integrations from Python.

use pyo3::exceptions::{PyTypeError, PyUserWarning, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyFloat;

use super::super::convert;
use crate::integrators::ode::{Controller, Sparsity, Tolerance};
use crate::python::errors::OrRaise as _;

/// The initial state.
pub(super) fn initial_state(y0: &Bound<'_, PyAny>) -> PyResult<Vec<f64>> {
    convert::vector(y0, "y0").map_err(|error| {
        let is_complex = |numpy: Bound<'_, PyModule>| numpy.call_method1("iscomplexobj", (y0,))?.is_truthy();
        // Values that NumPy cannot convert are rejected for that reason.
        if y0.py().import("numpy").and_then(is_complex).unwrap_or(false) {
            return PyTypeError::new_err(
                "y0: complex states are not supported; integrate the n real and n imaginary parts as 2n components",
            );
        }
        error
    })
}

pub(super) fn controller(name: &str) -> PyResult<Controller> {
    match name {
        "I" => Ok(Controller::Integral),
        "PI" => Ok(Controller::ProportionalIntegral),
        _ => Err(PyValueError::new_err(format!("controller: got '{name}', expected 'I' or 'PI'"))),
    }
}

/// A number for all components, or one for each.
pub(crate) fn tolerance(value: &Bound<'_, PyAny>, name: &str) -> PyResult<Tolerance> {
    // The common case, without attribute lookups.
    if let Ok(number) = value.cast::<PyFloat>() {
        return Ok(Tolerance::Same(number.value()));
    }
    Ok(match convert::scalar_or_vector(value, name)? {
        (number, true) => Tolerance::Same(number[0]),
        (numbers, false) => Tolerance::Each(numbers),
    })
}

/// Pattern of a dense or sparse (n, n) matrix.
pub(super) fn sparsity(value: &Bound<'_, PyAny>, n: usize) -> PyResult<Sparsity> {
    // Booleans are accepted like numbers.
    let dense = if value.hasattr("toarray")? { value.call_method0("toarray")? } else { value.clone() };
    let array = value.py().import("numpy")?.call_method1("asarray", (&dense,));
    let truth = array.ok().filter(|array| convert::kind_of(array) == Some('b'));
    let numbers = truth.map_or(Ok(dense), |truth| truth.call_method1("astype", ("float64",)))?;
    let pattern = convert::matrix_of(&numbers, (n, n), "jac_sparsity")?;
    let places = (0..n).flat_map(|i| (0..n).map(move |j| (i, j)));
    Sparsity::new(n, places.filter(|&place| pattern[place] != 0.0)).or_raise()
}

/// SciPy's warning about a relative tolerance below the accuracy of the arithmetic.
pub(super) fn warn_of_raised_rtol(py: Python<'_>) -> PyResult<()> {
    PyErr::warn(
        py,
        &py.get_type::<PyUserWarning>(),
        c"At least one element of `rtol` is too small: 100 rounding units, 2.2e-14, are used instead.",
        1,
    )
}
