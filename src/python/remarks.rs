//! What messages say beyond a status: questions about numbers that are probably in other units, and limits of segments that are
//! exceeded. It is found when a message is first read, so that searches and runs do not pay for it.

use numpy::PyArray1;
use pyo3::class::{PyTraverseError, PyVisit};
use pyo3::intern;
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::PyString;

use super::model::PyModel;
use super::record::ReadOnly;
use crate::robot::Robot;

/// The message of a search, as an attribute of its result.
pub(super) struct Message {
    /// What is known when the search ends.
    outcome: String,
    /// `None` for a message that was saved with its remarks.
    subject: Option<Subject>,
    whole: PyOnceLock<Py<PyString>>,
}

/// What the remarks are about.
pub(super) struct Subject {
    model: Py<PyModel>,
    equilibrium: Option<Rest>,
}

/// A shape at rest, with its inputs and the time of its loads.
struct Rest {
    q: Py<PyArray1<f64>>,
    u: Py<PyArray1<f64>>,
    t: f64,
}

impl Subject {
    /// A model of which no state is looked at.
    pub(super) fn of_model(model: &Bound<'_, PyModel>) -> Self {
        Self { model: model.clone().unbind(), equilibrium: None }
    }

    /// An equilibrium of a model, all of whose loads act.
    pub(super) fn at_rest(model: &Bound<'_, PyModel>, [q, u]: [&ReadOnly<PyArray1<f64>>; 2], t: f64) -> Self {
        let [q, u] = [q, u].map(|array| array.bind(model.py()).clone().unbind());
        Self { model: model.clone().unbind(), equilibrium: Some(Rest { q, u, t }) }
    }

    fn remarks(&self, py: Python<'_>) -> PyResult<Vec<String>> {
        let mut said = questions(self.model.get());
        if let Some(Rest { q, u, t }) = &self.equilibrium
            && has_limits(self.model.get())
        {
            let exceeded = limits(py)?.call_method1("exceeded_at_rest", (&self.model, q, *t, u))?;
            said.extend(exceeded.extract::<Vec<String>>()?);
        }
        Ok(said)
    }
}

impl Message {
    pub(super) fn new(outcome: String, subject: Subject) -> Self {
        Self { outcome, subject: Some(subject), whole: PyOnceLock::new() }
    }

    fn read<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyString>> {
        let whole = self.whole.get_or_try_init(py, || {
            let said = self.subject.as_ref().map_or_else(|| Ok(Vec::new()), |subject| subject.remarks(py))?;
            PyResult::Ok(PyString::new(py, &with(&self.outcome, &said)).unbind())
        })?;
        Ok(whole.bind(py).clone())
    }

    /// For the garbage collector: models may have functions of time.
    pub(super) fn traverse(&self, visit: &PyVisit<'_>) -> Result<(), PyTraverseError> {
        self.subject.as_ref().map_or(Ok(()), |subject| visit.call(&subject.model))
    }
}

impl<'py> IntoPyObject<'py> for &Message {
    type Target = PyString;
    type Output = Bound<'py, PyString>;
    type Error = PyErr;

    fn into_pyobject(self, py: Python<'py>) -> PyResult<Self::Output> {
        self.read(py)
    }
}

impl<'py> FromPyObject<'_, 'py> for Message {
    type Error = PyErr;

    fn extract(object: Borrowed<'_, 'py, PyAny>) -> PyResult<Self> {
        Ok(Self { outcome: object.extract()?, subject: None, whole: PyOnceLock::new() })
    }
}

/// Questions about numbers of a model that are probably in other units than SI.
pub(super) fn questions(model: &PyModel) -> Vec<String> {
    model.inspect(|model| model.robot().map(Robot::implausible_units).unwrap_or_default())
}

/// The message of a motion with what it leaves open.
pub(super) fn of_motion(
    result: &Bound<'_, PyAny>,
    outcome: &str,
    model: Option<&Py<PyModel>>,
) -> PyResult<String> {
    let Some(model) = model else { return Ok(outcome.to_owned()) };
    let mut said = questions(model.get());
    if has_limits(model.get()) {
        let exceeded = limits(result.py())?.call_method1("exceeded_by_motion", (result,))?;
        said.extend(exceeded.extract::<Vec<String>>()?);
    }
    Ok(with(outcome, &said))
}

/// A message with further sentences.
pub(super) fn with(outcome: &str, said: &[String]) -> String {
    said.iter().fold(outcome.to_owned(), |message, sentence| format!("{message} {sentence}"))
}

fn has_limits(model: &PyModel) -> bool {
    model.inspect(|model| model.robot().is_some_and(Robot::has_limits))
}

/// The module that compares peaks with limits.
fn limits(py: Python<'_>) -> PyResult<Bound<'_, PyModule>> {
    py.import(intern!(py, "lissom.analysis.limits"))
}
