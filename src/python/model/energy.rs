//! `lissom.Energy`.

use pyo3::prelude::*;

use super::super::record::{self, Reduced};
use crate::model;

/// Energies of a state, in joules.
#[pyclass(name = "Energy", module = "lissom", frozen)]
pub(crate) struct PyEnergy(pub(in crate::python) model::Energy);

#[pymethods]
impl PyEnergy {
    /// Kinetic energy.
    #[getter]
    fn kinetic(&self) -> f64 {
        self.0.kinetic
    }

    /// Elastic (strain) energy.
    #[getter]
    fn elastic(&self) -> f64 {
        self.0.elastic
    }

    /// Potential energy in the gravity field, zero at the world's origin.
    #[getter]
    fn gravitational(&self) -> f64 {
        self.0.gravitational
    }

    /// Potential energy of the loads that have one: constant dead forces.
    #[getter]
    fn loads(&self) -> f64 {
        self.0.loads
    }

    /// Sum of all parts; constant in free motion without damping.
    #[getter]
    fn total(&self) -> f64 {
        self.0.total()
    }

    fn __repr__(&self) -> String {
        let model::Energy { kinetic, elastic, gravitational, loads } = self.0;
        format!(
            "Energy(kinetic={kinetic:?}, elastic={elastic:?}, gravitational={gravitational:?}, loads={loads:?})"
        )
    }

    /// For copies and pickles.
    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<Reduced<'py>> {
        let model::Energy { kinetic, elastic, gravitational, loads } = self.0;
        record::reduce_to::<Self>(py, (kinetic, elastic, gravitational, loads))
    }

    #[staticmethod]
    fn _restore(kinetic: f64, elastic: f64, gravitational: f64, loads: f64) -> Self {
        Self(model::Energy { kinetic, elastic, gravitational, loads })
    }
}
