//! `lissom.HardSteps`.

use numpy::{Element, IntoPyArray as _, PyArray1};
use pyo3::prelude::*;

use super::model::PyModel;
use super::record::{self, ReadOnly, Reduced};
use crate::model::ContactText;
use crate::simulation::simulate::HardStep;

/// The steps of a run that were attempted more than once, or whose equations converged slowly, in the order of time.
///
/// Attributes
/// ----------
/// t : ndarray
///     Times at their starts, seconds, shape (k,).
/// dt : ndarray
///     Their sizes, seconds, shape (k,); zero of a step that could not be made, where the run ended.
/// attempts : ndarray of int
///     Attempts of the step and of its parts, shape (k,).
/// halvings : ndarray of int
///     How often the shortest part of a step of fixed size was halved, shape (k,).
/// iterations : ndarray of int
///     Newton iterations, shape (k,); zero of explicit methods.
/// tangents : ndarray of int
///     Jacobians, shape (k,).
/// evaluations : ndarray of int
///     Evaluations of the equations of motion, without those for Jacobians by differences, shape (k,).
/// reasons : list of str
///     Why the first attempt did not make the step: 'not_converged', 'singular' or 'non_finite' (its equations were not solved),
///     'error' (its error estimate was too large), 'impact' (it was too long for an impact), 'missed' (a contact or a stop acted
///     between its ends only), 'invalid_end' (such as surfaces deep in each other), 'passed_through' (surfaces passed through each
///     other), 'energy_gain' (it added energy), 'event' (a tendon became slack or taut within it), 'in_parts' (the steps before had
///     to be made in parts, so that it was not attempted as a whole), or 'slow_convergence' (the first attempt made it, with a fresh
///     Jacobian in every iteration).
/// contacts : list of (str or None)
///     Name of the contact that is deepest at the end of each step, or was at its start.
#[pyclass(name = "HardSteps", module = "lissom", frozen, get_all)]
#[derive(FromPyObject)]
pub(crate) struct PyHardSteps {
    t: ReadOnly<PyArray1<f64>>,
    dt: ReadOnly<PyArray1<f64>>,
    attempts: ReadOnly<PyArray1<i64>>,
    halvings: ReadOnly<PyArray1<i64>>,
    iterations: ReadOnly<PyArray1<i64>>,
    tangents: ReadOnly<PyArray1<i64>>,
    evaluations: ReadOnly<PyArray1<i64>>,
    reasons: Vec<String>,
    contacts: Vec<Option<String>>,
}

impl PyHardSteps {
    /// Of a run of this model; none of runs without one.
    pub(super) fn of_run(
        py: Python<'_>,
        steps: &[HardStep],
        model: Option<&Py<PyModel>>,
    ) -> PyResult<Option<Py<Self>>> {
        let Some(model) = model else { return Ok(None) };
        let contacts = model.get().inspect(|model| {
            let name = |contact| model.text_of_contact(contact, ContactText::Name);
            steps.iter().map(|step| step.contact.map(name)).collect()
        });
        let counts = |of: fn(&HardStep) -> usize| array(py, steps.iter().map(|step| of(step) as i64));
        let found = Self {
            t: array(py, steps.iter().map(|step| step.t))?,
            dt: array(py, steps.iter().map(|step| step.h))?,
            attempts: counts(|step| step.attempts)?,
            halvings: counts(|step| step.halvings)?,
            iterations: counts(|step| step.iterations)?,
            tangents: counts(|step| step.tangents)?,
            evaluations: counts(|step| step.evaluations)?,
            reasons: steps.iter().map(|step| step.reason.name().to_owned()).collect(),
            contacts,
        };
        Ok(Some(Py::new(py, found)?))
    }
}

fn array<T: Element>(py: Python<'_>, values: impl Iterator<Item = T>) -> PyResult<ReadOnly<PyArray1<T>>> {
    ReadOnly::new(values.collect::<Vec<T>>().into_pyarray(py))
}

#[pymethods]
impl PyHardSteps {
    fn __len__(&self) -> usize {
        self.reasons.len()
    }

    fn __repr__(&self) -> String {
        format!("<HardSteps: {}>", self.reasons.len())
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
