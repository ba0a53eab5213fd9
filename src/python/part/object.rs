//! The object of Python that holds a part, and the classes of these objects.

use std::any::Any;
use std::sync::Arc;

use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::PyType;

use crate::description::schema::{AnyPart, Data, Part as _, Reader, Schema, Value};
use crate::python::signal::Functions;
use crate::scene::PARTS;
use crate::simulation::methods::{Auto, Dop853, Newmark, QuasiStatic, Radau, Rk45};

/// A part of a model. It cannot be changed: `dataclasses.replace` makes another one.
// In the module where it is found: old protocols of pickles name it.
#[pyclass(name = "Part", module = "lissom._lissom", subclass, frozen, weakref)]
#[derive(Debug)]
pub(crate) struct PyPart {
    pub(super) part: Arc<dyn AnyPart>,
    /// The functions of its signals, visible here to Python's garbage collector, because the part itself is shared.
    pub(super) functions: Functions,
}

/// The methods of simulations.
pub(super) const METHODS: [&Schema; 6] =
    [Newmark::SCHEMA, Radau::SCHEMA, Rk45::SCHEMA, Dop853::SCHEMA, QuasiStatic::SCHEMA, Auto::SCHEMA];

/// Classes of the parts and of the methods, in the order of their tables.
pub(super) static CLASSES: PyOnceLock<Vec<Py<PyType>>> = PyOnceLock::new();

/// An object of the part's class around it; nothing is read again.
pub(super) fn wrapped(py: Python<'_>, part: Arc<dyn AnyPart>) -> PyResult<Bound<'_, PyAny>> {
    let place = PARTS.iter().chain(&METHODS).position(|schema| std::ptr::eq(*schema, part.schema()));
    let classes = CLASSES.get(py).expect("made at import");
    let class = &classes[place.expect("all parts are listed")];
    let functions = Functions::of_part(py, part.as_ref())?;
    class.bind(py).call1((Bound::new(py, PyPart { part, functions })?,))
}

impl PyPart {
    /// The part as this type, if it is one.
    pub(in crate::python) fn read<T: Data>(&self) -> Option<T> {
        T::read(&Value::Part(self.part.clone()), &mut Reader::default())
    }

    /// The part, if it is one of this type.
    pub(in crate::python) fn of_type<T: 'static>(&self) -> Option<&T> {
        (self.part.as_ref() as &dyn Any).downcast_ref()
    }

    /// The table of its fields.
    pub(in crate::python) fn schema(&self) -> &'static Schema {
        self.part.schema()
    }
}
