//! `lissom.Overlap`.

use pyo3::prelude::*;

use super::model::PyModel;
use super::record::{self, Reduced};
use crate::model::{ContactText, Overlap};

/// The deepest overlap of two surfaces in a shape or over a run.
///
/// Attributes
/// ----------
/// contact : str
///     Name of the contact.
/// depth : float
///     Overlap, metres.
/// share : float
///     Depth over the thickness of the thinner surface: the radius of a rod or a ball, half the thickness of a box. The default
///     stiffness aims at 0.15 or less; where it is more than 0.35, the message says which `stiffness` suits the load.
/// t : float or None
///     When that was, seconds; None in an equilibrium.
#[pyclass(name = "Overlap", module = "lissom", frozen, get_all)]
#[derive(FromPyObject)]
pub(crate) struct PyOverlap {
    contact: String,
    depth: f64,
    share: f64,
    t: Option<f64>,
}

impl PyOverlap {
    pub(super) fn new(
        model: &Bound<'_, PyModel>,
        found: Option<Overlap>,
        t: Option<f64>,
    ) -> PyResult<Option<Py<Self>>> {
        let Some(Overlap { contact, depth, share }) = found else { return Ok(None) };
        let contact = model.get().inspect(|model| model.text_of_contact(contact, ContactText::Name));
        Ok(Some(Py::new(model.py(), Self { contact, depth, share, t })?))
    }

    pub(super) fn of_run(
        py: Python<'_>,
        found: Option<(f64, Overlap)>,
        model: Option<&Py<PyModel>>,
    ) -> PyResult<Option<Py<Self>>> {
        let Some(((t, overlap), model)) = found.zip(model) else { return Ok(None) };
        Self::new(model.bind(py), Some(overlap), Some(t))
    }
}

#[pymethods]
impl PyOverlap {
    fn __repr__(&self) -> String {
        let at = self.t.map_or_else(String::new, |t| format!(" at t = {t:.4} s"));
        format!(
            "<Overlap of {:?}: {:.2e} m, {:.2} of the thickness{at}>",
            self.contact, self.depth, self.share
        )
    }

    /// For copies and pickles.
    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<Reduced<'py>> {
        record::reduce(slf)
    }

    #[staticmethod]
    fn _restore(state: Self) -> Self {
        state
    }
}
