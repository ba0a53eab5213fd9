//! The method of an integration from Python.

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::{PyString, PyType};

use super::stepper::{PyDop853, PyRadau, PyRk45};
use crate::description::schema::suggestion;
use crate::integrators::ode::Method;

const METHODS: &str = "'rk45', 'dop853' or 'radau' (or one of the classes RK45, DOP853 and Radau)";

/// Names of the methods, and those of SciPy's `solve_ivp`, whose arguments are those of lissom's.
const NAMES: [(&str, &str, Method); 3] =
    [("rk45", "RK45", Method::Rk45), ("dop853", "DOP853", Method::Dop853), ("radau", "Radau", Method::Radau)];

/// A method by name or class.
pub(super) fn method(value: &Bound<'_, PyAny>) -> PyResult<Method> {
    let py = value.py();
    if let Ok(class) = value.cast::<PyType>() {
        if class.is_subclass_of::<PyRk45>()? {
            return Ok(Method::Rk45);
        }
        if class.is_subclass_of::<PyDop853>()? {
            return Ok(Method::Dop853);
        }
        if class.is_subclass_of::<PyRadau>()? {
            return Ok(Method::Radau);
        }
    }
    let name = value.cast::<PyString>().map(|name| name.to_string_lossy().into_owned()).ok();
    let is_named = |&&(own, of_scipy, _): &&(&str, &str, Method)| {
        name.as_deref().is_some_and(|name| [own, of_scipy].contains(&name))
    };
    NAMES.iter().find(is_named).map(|&(_, _, method)| method).ok_or_else(|| {
        let found = value.repr().unwrap_or_else(|_| PyString::new(py, "an unknown object"));
        let meant = name.as_deref().and_then(|name| suggestion(name, NAMES.iter().map(|(own, ..)| *own)));
        let meant = meant.map_or_else(String::new, |meant| format!("; did you mean '{meant}'?"));
        PyValueError::new_err(format!("method: got {found}, expected {METHODS}{meant}"))
    })
}
