//! `lissom.Rod`.

use std::sync::{Arc, OnceLock};

use pyo3::PyTypeInfo;
use pyo3::class::{PyTraverseError, PyVisit};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};

use super::part::{describe_model, model_of, new_arguments, resolved};
use super::robot::{PyRobot, coordinates, hash_of};
use super::signal::Functions;
use crate::description::schema::Part;
use crate::python::errors::OrRaise as _;
use crate::robot::{Rod, described};

/// A rod. The table [`described::Rod`] documents its arguments.
#[pyclass(name = "Rod", module = "lissom", extends = PyRobot, frozen)]
pub(crate) struct PyRod {
    description: Rod,
    /// Its parts as users describe them, made on first use.
    described: OnceLock<Arc<described::Rod>>,
    // The base class has its own functions. A class without a traversal would share that of `Model`; PyO3
    // 0.30 then calls it recursively without end.
    functions: Functions,
}

impl PyRod {
    /// The description of the rod.
    pub(crate) fn description(&self) -> &Rod {
        &self.description
    }

    fn described(&self) -> Arc<described::Rod> {
        self.described.get_or_init(|| Arc::new(self.description.described())).clone()
    }

    /// The Python objects that own the functions of this rod must still be alive.
    pub(crate) fn initializer(description: Rod) -> PyResult<PyClassInitializer<Self>> {
        let robot = description.valid_robot().or_raise()?;
        let functions = Python::attach(|py| Functions::of_robot(py, &robot))?;
        let rod = Self { description, described: OnceLock::new(), functions };
        // A valid rod is a valid robot, since it names no link: all parts are on its only one.
        Ok(PyRobot::initializer_of_valid(robot)?.add_subclass(rod))
    }
}

/// Gives the class what follows from the table of its description.
pub(super) fn describe_class(py: Python<'_>) -> PyResult<()> {
    describe_model(&PyRod::type_object(py), described::Rod::SCHEMA, |object| {
        object.cast::<PyRod>().ok().map(|rod| rod.get().described() as _)
    })
}

#[pymethods]
impl PyRod {
    #[new]
    #[pyo3(signature = (*args, **kwargs))]
    fn new(
        args: &Bound<'_, PyTuple>,
        kwargs: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<PyClassInitializer<Self>> {
        // Own the functions until the rod does; iterators keep no references to their items.
        let mut functions = Functions::default();
        let described = model_of::<described::Rod>(args, kwargs, &mut functions)?;
        let (rod, _) = resolved(args.py(), |reader| described.resolved(reader))?;
        Self::initializer(rod)
    }

    /// Length of the unstretched rod, metres.
    #[getter]
    fn length(&self) -> f64 {
        self.description.length()
    }

    fn __repr__(slf: &Bound<'_, Self>) -> String {
        let this = slf.get();
        let segments = this.description.segments.len();
        let plural = if segments == 1 { "" } else { "s" };
        format!(
            "<lissom.Rod of {segments} segment{plural}, {:?} m long, {}>",
            this.description.length(),
            coordinates(slf.as_super().get().description())
        )
    }

    /// Rods are equal if their descriptions are.
    fn __eq__(slf: &Bound<'_, Self>, other: &Bound<'_, Self>) -> bool {
        let are_alike = slf.get_type().is(other.get_type());
        are_alike && (slf.is(other) || slf.get().description == other.get().description)
    }

    fn __hash__(slf: &Bound<'_, Self>) -> u64 {
        hash_of(slf.as_super().get().description())
    }

    /// For copies and pickles.
    fn __getnewargs_ex__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyTuple>, Bound<'py, PyDict>)> {
        new_arguments(py, self.described().as_ref())
    }

    fn __traverse__(&self, visit: PyVisit<'_>) -> Result<(), PyTraverseError> {
        self.functions.traverse(&visit)
    }
}
