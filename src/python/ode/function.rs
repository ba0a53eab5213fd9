//! Python callables of time and state.

use numpy::{PyArrayMethods, PyUntypedArrayMethods, ToPyArray};
use pyo3::class::{PyTraverseError, PyVisit};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyFloat, PyInt, PyList, PyTuple};

use super::super::callback::{Form, call};
use super::super::convert;
use crate::numerics::linalg::Matrix;

/// Arguments of functions of a state.
const STATE: &str = "t, y";

/// Calls `fun(t, y, *args)`. Every call gets a new array: creating it is cheaper than checking whether the
/// previous one was kept.
#[derive(Debug)]
pub(super) struct Function {
    form: Form<'static>,
    fun: Py<PyAny>,
    args: Option<Py<PyTuple>>,
}

impl Function {
    pub(super) fn new(name: &'static str, fun: &Bound<'_, PyAny>, args: Option<&Bound<'_, PyTuple>>) -> Self {
        let args = args.filter(|args| !args.is_empty());
        let form = Form { name, arguments: STATE, args: Some(args.map_or(0, PyTupleMethods::len)) };
        Self { form, fun: fun.clone().unbind(), args: args.map(|args| args.clone().unbind()) }
    }

    /// A function that takes no `args`.
    pub(super) fn callback(fun: &Bound<'_, PyAny>) -> Self {
        let form = Form { name: "callback", arguments: STATE, args: None };
        Self { form, fun: fun.clone().unbind(), args: None }
    }

    pub(super) fn traverse(&self, visit: &PyVisit<'_>) -> Result<(), PyTraverseError> {
        visit.call(&self.fun)?;
        visit.call(&self.args)
    }

    /// Value at a state.
    pub(super) fn call<'py>(&self, py: Python<'py>, t: f64, y: &[f64]) -> PyResult<Bound<'py, PyAny>> {
        self.call_with(py, t, y.to_pyarray(py).into_any())
    }

    /// Values at several states, one per column.
    pub(super) fn call_columns<'py>(
        &self,
        py: Python<'py>,
        t: f64,
        y: &Matrix,
    ) -> PyResult<Bound<'py, PyAny>> {
        self.call_with(py, t, convert::matrix_out(py, y).into_any())
    }

    fn call_with<'py>(&self, py: Python<'py>, t: f64, y: Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
        let fun = self.fun.bind(py);
        match &self.args {
            None => call(self.form, fun, (t, y)),
            Some(args) => {
                let mut arguments = vec![t.into_pyobject(py)?.into_any(), y];
                arguments.extend(args.bind(py).iter());
                call(self.form, fun, PyTuple::new(py, arguments)?)
            }
        }
    }
}

/// Reads n real numbers returned by a callable: fast for an array of doubles and for a list or tuple of
/// numbers, slower for other array-likes.
pub(crate) fn read_vector(value: &Bound<'_, PyAny>, out: &mut [f64], name: &str) -> PyResult<()> {
    if let Some(array) = convert::plain(value)
        && array.ndim() == 1
    {
        return copy(&array.to_vec()?, out, name);
    }
    if let Ok(list) = value.cast::<PyList>()
        && list.len() == out.len()
        && read_numbers(list.iter(), out)
    {
        return Ok(());
    }
    if let Ok(tuple) = value.cast::<PyTuple>()
        && tuple.len() == out.len()
        && read_numbers(tuple.iter(), out)
    {
        return Ok(());
    }
    if value.is_none() {
        return Err(PyTypeError::new_err(format!("{name}: returned None; is there a `return` missing?")));
    }
    match convert::scalar_or_vector(value, &format!("value of {name}"))? {
        (number, true) if out.len() == 1 => copy(&number, out, name),
        (_, true) => {
            Err(PyValueError::new_err(format!("{name}: expected {} values, got a single number", out.len())))
        }
        (values, false) => copy(&values, out, name),
    }
}

/// Reads n real numbers returned by a callable as a single column.
pub(crate) fn read_column(value: &Bound<'_, PyAny>, out: &mut [f64], name: &str) -> PyResult<()> {
    if value.is_none() {
        return read_vector(value, out, name);
    }
    copy(&convert::numbers(value, &format!("value of {name}"), "a column of real numbers")?.values, out, name)
}

/// False for entries other than floats and integers, and for a wrong number of entries.
fn read_numbers<'py>(numbers: impl Iterator<Item = Bound<'py, PyAny>>, out: &mut [f64]) -> bool {
    numbers.zip(out).all(|(number, out)| {
        let read = match number.cast::<PyFloat>() {
            Ok(number) => Some(number.value()),
            Err(_) if number.is_exact_instance_of::<PyInt>() => number.extract().ok(),
            Err(_) => None,
        };
        read.map(|number| *out = number).is_some()
    })
}

fn copy(values: &[f64], out: &mut [f64], name: &str) -> PyResult<()> {
    if values.len() != out.len() {
        return Err(PyValueError::new_err(format!(
            "{name}: expected {} values, got {}",
            out.len(),
            values.len()
        )));
    }
    out.copy_from_slice(values);
    Ok(())
}

/// Reads a dense or sparse matrix returned by a callable, with the shape of `out`.
pub(crate) fn read_matrix(value: &Bound<'_, PyAny>, out: &mut Matrix, name: &str) -> PyResult<()> {
    out.copy_from(&matrix_of(value, out.shape(), name)?);
    Ok(())
}

/// A matrix of a given shape, from an array-like or a sparse matrix of SciPy.
pub(crate) fn matrix_of(value: &Bound<'_, PyAny>, shape: (usize, usize), name: &str) -> PyResult<Matrix> {
    // Avoids the attribute check for plain arrays.
    if convert::plain(value).is_none() && value.hasattr("toarray")? {
        convert::matrix_of(&value.call_method0("toarray")?, shape, name)
    } else {
        convert::matrix_of(value, shape, name)
    }
}
