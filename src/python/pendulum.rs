//! `lissom.SpringPendulum`.

use std::hash::{DefaultHasher, Hash as _, Hasher as _};

use pyo3::prelude::*;
use pyo3::types::PyDict;

use super::arguments;
use super::model::PyModel;
use crate::model::pendulum::SpringPendulum;
use crate::python::errors::OrRaise as _;
use crate::python::words::no_others;

/// A point mass on a massless spring, hinged at the origin, that swings in a vertical plane.
///
/// The coordinate ``q[0]`` is the angle of the spring from the horizontal axis +x, counter-clockwise positive, in radians; the
/// mass hangs at ``-pi/2``. ``q[1]`` is the elongation, in metres.
///
/// Parameters
/// ----------
/// length : float
///     Rest length of the spring, metres, > 0.
/// mass : float
///     Mass, kilograms, > 0.
/// stiffness : float
///     Stiffness of the spring, newtons per metre, >= 0.
/// gravity : float
///     Downward acceleration of gravity, metres per second squared.
///
/// Raises
/// ------
/// ValueError
///     If parameters are invalid; the message lists all of them.
#[pyclass(name = "SpringPendulum", module = "lissom", extends = PyModel, frozen)]
pub(crate) struct PySpringPendulum(SpringPendulum);

impl PySpringPendulum {
    pub(crate) fn initializer(pendulum: SpringPendulum) -> PyClassInitializer<Self> {
        PyClassInitializer::from(PyModel::new(pendulum.clone())).add_subclass(Self(pendulum))
    }
}

#[pymethods]
impl PySpringPendulum {
    /// Describe what lissom computes for this model. Print the returned text.
    #[allow(clippy::unused_self, reason = "a method of every model")]
    fn explain(&self) -> &'static str {
        "Spring pendulum with 2 coordinates: everything in closed form, nothing to skip\n"
    }

    #[new]
    #[pyo3(signature = (length=1.0, mass=1.0, stiffness=10.0, gravity=9.81, **others), text_signature = "(length=1.0, mass=1.0, stiffness=10.0, gravity=9.81)")]
    fn new(
        #[pyo3(from_py_with = arguments::number::length)] length: f64,
        #[pyo3(from_py_with = arguments::number::mass)] mass: f64,
        #[pyo3(from_py_with = arguments::number::stiffness)] stiffness: f64,
        #[pyo3(from_py_with = arguments::number::gravity)] gravity: f64,
        others: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<PyClassInitializer<Self>> {
        no_others("SpringPendulum", others)?;
        Ok(Self::initializer(SpringPendulum::new(length, mass, stiffness, gravity).or_raise()?))
    }

    /// Rest length of the spring, metres.
    #[getter]
    fn length(&self) -> f64 {
        self.0.length()
    }

    /// The mass, kilograms.
    #[getter]
    fn mass(&self) -> f64 {
        self.0.mass()
    }

    /// Stiffness of the spring, newtons per metre.
    #[getter]
    fn stiffness(&self) -> f64 {
        self.0.stiffness()
    }

    /// Downward gravity, metres per second squared.
    #[getter]
    fn gravity(&self) -> f64 {
        self.0.gravity()
    }

    fn __repr__(&self) -> String {
        format!(
            "SpringPendulum(length={:?}, mass={:?}, stiffness={:?}, gravity={:?})",
            self.length(),
            self.mass(),
            self.stiffness(),
            self.gravity()
        )
    }

    fn __eq__(&self, other: &Self) -> bool {
        self.0 == other.0
    }

    fn __hash__(&self) -> u64 {
        let mut hasher = DefaultHasher::new();
        // Zeros of both signs are equal.
        [self.length(), self.mass(), self.stiffness(), self.gravity() + 0.0]
            .map(f64::to_bits)
            .hash(&mut hasher);
        hasher.finish()
    }

    /// For copies and pickles.
    fn __getnewargs__(&self) -> (f64, f64, f64, f64) {
        (self.length(), self.mass(), self.stiffness(), self.gravity())
    }
}
