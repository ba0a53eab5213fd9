//! Common behaviour of results: read-only arrays, copies and pickles.

use numpy::PyUntypedArray;
use pyo3::PyTypeInfo;
use pyo3::intern;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList, PyTuple};

/// A Python object that is part of a result. Arrays in it, also in a list or dict, are read-only, because
/// later computations use the same numbers.
pub(super) struct ReadOnly<T = PyAny>(Py<T>);

impl<T> ReadOnly<T> {
    pub(super) fn new(value: Bound<'_, T>) -> PyResult<Self> {
        make_read_only(value.as_any())?;
        Ok(Self(value.unbind()))
    }

    pub(super) fn bind<'py>(&self, py: Python<'py>) -> &Bound<'py, T> {
        self.0.bind(py)
    }

    pub(super) fn get(&self) -> &Py<T> {
        &self.0
    }
}

impl<'a, 'py, T> FromPyObject<'a, 'py> for ReadOnly<T>
where
    Py<T>: FromPyObject<'a, 'py, Error: Into<PyErr>>,
{
    type Error = PyErr;

    fn extract(object: Borrowed<'a, 'py, PyAny>) -> PyResult<Self> {
        let value: Py<T> = object.extract().map_err(Into::into)?;
        make_read_only(&object)?;
        Ok(Self(value))
    }
}

impl<'py, T> IntoPyObject<'py> for &ReadOnly<T> {
    type Target = T;
    type Output = Bound<'py, T>;
    type Error = std::convert::Infallible;

    fn into_pyobject(self, py: Python<'py>) -> Result<Self::Output, Self::Error> {
        Ok(self.0.bind(py).clone())
    }
}

/// Makes arrays read-only, with the arrays of which they are views.
fn make_read_only(value: &Bound<'_, PyAny>) -> PyResult<()> {
    if let Ok(list) = value.cast::<PyList>() {
        return list.iter().try_for_each(|item| make_read_only(&item));
    }
    if let Ok(dict) = value.cast::<PyDict>() {
        return dict.iter().try_for_each(|(_, item)| make_read_only(&item));
    }
    if value.is_instance_of::<PyUntypedArray>() {
        let py = value.py();
        make_read_only(&value.getattr(intern!(py, "base"))?)?;
        value.getattr(intern!(py, "flags"))?.setattr(intern!(py, "writeable"), false)?;
    }
    Ok(())
}

/// The return value of `__reduce__`: a function and its arguments.
pub(super) type Reduced<'py> = (Bound<'py, PyAny>, Bound<'py, PyTuple>);

/// `__reduce__` for results that consist of their attributes: `_restore` receives a namespace of them, from
/// which the derived `FromPyObject` recreates the result.
pub(super) fn reduce<'py>(object: &Bound<'py, PyAny>) -> PyResult<Reduced<'py>> {
    let class = object.get_type();
    let state = PyDict::new(object.py());
    for item in class.getattr("__dict__")?.call_method0("items")?.try_iter()? {
        let (name, attribute): (Bound<'py, PyAny>, Bound<'py, PyAny>) = item?.extract()?;
        // Attributes are descriptors with `__set__`, even if it only raises.
        if attribute.get_type().hasattr("__set__")? {
            state.set_item(&name, object.getattr(name.cast()?)?)?;
        }
    }
    let namespace = object.py().import("types")?.getattr("SimpleNamespace")?.call((), Some(&state))?;
    Ok((class.getattr("_restore")?, PyTuple::new(object.py(), [namespace])?))
}

/// Sets attributes to None that records of older versions lack.
pub(super) fn add_missing(state: &Bound<'_, PyAny>, names: &[&str]) -> PyResult<()> {
    for &name in names {
        if !state.hasattr(name)? {
            state.setattr(name, state.py().None())?;
        }
    }
    Ok(())
}

/// `__reduce__` for other classes: `_restore` receives these arguments.
pub(super) fn reduce_to<'py, C: PyTypeInfo>(
    py: Python<'py>,
    arguments: impl IntoPyObject<'py, Target = PyTuple, Output = Bound<'py, PyTuple>, Error = PyErr>,
) -> PyResult<Reduced<'py>> {
    Ok((py.get_type::<C>().getattr("_restore")?, arguments.into_pyobject(py)?))
}
