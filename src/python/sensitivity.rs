//! What `lissom.sensitivity` asks of the core.

use numpy::{IntoPyArray, PyArrayMethods};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyTuple;

use super::callback::Raised;
use super::convert::{self, Numbers};
use super::errors::LissomError;
use super::model::{Native, PyModel};
use super::motion::Ticker;
use crate::error::Interrupted;
use crate::linalg::Matrix;
use crate::newmark::{Parameters, Scheme};
use crate::sensitivity::{self, Course, Failure, ForceDerivative};

/// Models that differ in a parameter, with their weights in the derivative with respect to it.
type Terms = Vec<(Py<PyModel>, f64)>;

/// Derivatives of a run with fixed steps of the Newmark family: of all states forward, or of a number by the adjoint.
///
/// `lissom.sensitivity` says what they are.
///
/// Parameters
/// ----------
/// model : Model
///     What has moved.
/// t : array_like, shape (m,)
/// q, v, a : array_like, shape (m, n)
///     All accepted steps.
/// terms : list of list of (Model, float)
///     For each of p parameters the models whose weighted sum of forces is their derivative; none for what no force depends on.
/// dq0, dv0 : array_like, shape (n, p)
///     How the start moves with the parameters.
/// weights : pair of array_like, shape (m, n), optional
///     Derivatives of the number with respect to `q` and `v`.
///
/// Returns
/// -------
/// tuple of ndarray
///     Two of shape (m, n, p), or with `weights` one of shape (p,).
///
/// Raises
/// ------
/// ValueError, TypeError
///     If an argument is invalid.
/// LissomError
///     If the matrix of a step is singular.
#[pyfunction]
#[pyo3(signature = (model, t, q, v, a, terms, dq0, dv0, *, method="newmark", beta=None, gamma=None, alpha=None, rho_inf=None, weights=None))]
#[allow(clippy::too_many_arguments, reason = "a run, and what is asked of it")]
pub(crate) fn sensitivities<'py>(
    model: &Bound<'py, PyModel>,
    t: &Bound<'py, PyAny>,
    q: &Bound<'py, PyAny>,
    v: &Bound<'py, PyAny>,
    a: &Bound<'py, PyAny>,
    terms: Vec<Terms>,
    dq0: &Bound<'py, PyAny>,
    dv0: &Bound<'py, PyAny>,
    method: &str,
    beta: Option<f64>,
    gamma: Option<f64>,
    alpha: Option<f64>,
    rho_inf: Option<f64>,
    weights: Option<(Bound<'py, PyAny>, Bound<'py, PyAny>)>,
) -> PyResult<Bound<'py, PyTuple>> {
    let py = model.py();
    let mut native = model.get().native();
    sensitivity::check(&*native)?;
    let n = native.n();
    let scheme = Scheme::by_name(method, &Parameters { beta, gamma, alpha, rho_inf })?;
    let t = convert::vector(t, "t")?;
    if t.is_empty() {
        return Err(PyValueError::new_err("t: got no times, expected at least the start"));
    }
    let states = |value: &Bound<'_, PyAny>, name: &str| {
        let Numbers { values, shape } = convert::numbers(value, name, "an array of shape (m, n)")?;
        if shape == [t.len(), n] {
            return Ok(values);
        }
        Err(PyValueError::new_err(format!("{name}: got shape {shape:?}, expected [{}, {n}]", t.len())))
    };
    let (q, v, a) = (states(q, "q")?, states(v, "v")?, states(a, "a")?);
    let weights = match &weights {
        Some((on_q, on_v)) => Some((states(on_q, "weights[0]")?, states(on_v, "weights[1]")?)),
        None => None,
    };
    let p = terms.len();
    let (dq0, dv0) = (convert::matrix_of(dq0, (n, p), "dq0")?, convert::matrix_of(dv0, (n, p), "dv0")?);
    let terms = terms.iter().map(|terms| of_parameter(terms, n)).collect::<PyResult<Vec<_>>>()?;
    let course = Course { t: &t, q: &q, v: &v, a: &a, scheme };
    let mut raised = Raised::default();
    let mut ticker = Ticker::new();
    let computed = py.detach(|| {
        let mut monitor = || {
            if !ticker.tick() {
                return Ok(());
            }
            raised.catch(Python::attach(|py| py.check_signals()))
        };
        let weights = weights.as_ref().map(|(q, v)| [q.as_slice(), v.as_slice()]);
        compute(&mut *native, &course, terms, [&dq0, &dv0], weights, &mut monitor)
    });
    raised.into_result()?;
    let computed = computed.map_err(|failure| match failure {
        Failure::Singular(step) => LissomError::new_err(format!(
            "the matrix of the step that ends at t = {} s is singular or not finite: there are no derivatives",
            t[step]
        )),
        Failure::Interrupted => LissomError::new_err("a function of time failed while derivatives were computed"),
    })?;
    let arrays = computed.into_iter().map(|values| {
        let array = values.into_pyarray(py);
        if weights.is_some() { Ok(array.into_any()) } else { Ok(array.reshape([t.len(), n, p])?.into_any()) }
    });
    PyTuple::new(py, arrays.collect::<PyResult<Vec<_>>>()?)
}

fn of_parameter(terms: &Terms, n: usize) -> PyResult<Vec<(Box<dyn Native>, f64)>> {
    let natives = terms.iter().map(|(model, weight)| (model.get().native(), *weight));
    let natives: Vec<_> = natives.collect();
    match natives.iter().find(|(model, _)| model.n() != n) {
        Some((model, _)) => Err(PyTypeError::new_err(format!(
            "terms: got a model of {} coordinates, expected {n}: parameters must not change their number",
            model.n()
        ))),
        None => Ok(natives),
    }
}

fn compute(
    model: &mut dyn Native,
    course: &Course<'_>,
    terms: Vec<Vec<(Box<dyn Native>, f64)>>,
    [dq0, dv0]: [&Matrix; 2],
    weights: Option<[&[f64]; 2]>,
    monitor: &mut dyn FnMut() -> Result<(), Interrupted>,
) -> Result<Vec<Vec<f64>>, Failure> {
    let n = dq0.nrows();
    let forces = terms.into_iter().map(|terms| ForceDerivative::new(terms, n));
    let mut forces = forces.collect::<Result<Vec<_>, _>>()?;
    let mut parameters = sensitivity::Parameters { dq0, dv0, forces: &mut forces };
    match weights {
        Some(weights) => sensitivity::adjoint(model, course, weights, &mut parameters, monitor)
            .map(|gradient| vec![gradient]),
        None => sensitivity::forward(model, course, &mut parameters, monitor).map(Vec::from),
    }
}
