//! The result of an integration.

use std::sync::Arc;

use numpy::{IntoPyArray, PyArray1, PyArray2, PyArrayMethods};
use pyo3::class::{PyTraverseError, PyVisit};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyList;

use super::super::convert;
use super::super::record::{self, ReadOnly, Reduced};
use crate::integrators::ode::{DenseOutput, DenseParts, Occurrences, Solution, Status};
use crate::python::errors::OrRaise as _;

/// Result of `solve_ivp`.
///
/// Attributes
/// ----------
/// t : ndarray, shape (n_points,)
///     Times: `t_eval` as far as it was reached, otherwise the start and all accepted steps.
/// y : ndarray, shape (n, n_points)
///     States at these times.
/// sol : DenseOutput or None
///     The solution as a function of time, with ``dense_output=True``.
/// t_events : list of ndarray, or None
///     Times of the events of each event function. None without event functions.
/// y_events : list of ndarray, or None
///     States at these times, each of shape (n_times, n); (0,) for a function without events.
/// nfev : int
///     Evaluations of the right-hand side, excluding those for finite-difference Jacobians.
/// nfev_jac : int
///     Evaluations of the right-hand side for finite-difference Jacobians.
/// njev : int
///     Number of Jacobians, given or by finite differences.
/// nlu : int
///     LU factorisations, real and complex.
/// naccepted, nrejected : int
///     Accepted and rejected steps.
/// status : int
///     0: the end of the interval was reached. 1: a terminal event occurred. -1: neither, see `reason`.
/// reason : str
///     'finished', 'event', 'too_many_steps', 'step_too_small', 'non_finite', 'non_finite_jacobian' or 'interrupted' (by
///     `callback`).
/// message : str
///     The reason in words, and what to change.
/// success : bool
///     True if the end of the interval or a terminal event was reached.
/// stiff_at : float or None
///     Time at which an explicit method found the problem to be stiff.
#[pyclass(name = "OdeResult", module = "lissom", frozen, get_all)]
#[derive(FromPyObject)]
pub(crate) struct PyOdeResult {
    t: ReadOnly<PyArray1<f64>>,
    y: ReadOnly<PyArray2<f64>>,
    sol: Option<Py<PyDenseOutput>>,
    t_events: Option<ReadOnly<PyList>>,
    y_events: Option<ReadOnly<PyList>>,
    nfev: usize,
    nfev_jac: usize,
    njev: usize,
    nlu: usize,
    naccepted: usize,
    nrejected: usize,
    status: i32,
    reason: String,
    message: String,
    success: bool,
    stiff_at: Option<f64>,
}

impl PyOdeResult {
    pub(super) fn new(py: Python<'_>, solution: Solution, has_events: bool) -> PyResult<Self> {
        let Solution { t, y, n, dense, events, counters, status, message, stiff_at, .. } = solution;
        let t_events = PyList::empty(py);
        let y_events = PyList::empty(py);
        for Occurrences { t, y } in events {
            let points = t.len();
            t_events.append(t.into_pyarray(py))?;
            let y = y.into_pyarray(py);
            // SciPy's shape of an empty result.
            y_events.append(if points == 0 { y.into_any() } else { y.reshape([points, n])?.into_any() })?;
        }
        Ok(Self {
            y: ReadOnly::new(columns(py, y, t.len(), n)?)?,
            t: ReadOnly::new(t.into_pyarray(py))?,
            sol: dense.map(|dense| Py::new(py, PyDenseOutput::new(dense))).transpose()?,
            t_events: has_events.then(|| ReadOnly::new(t_events)).transpose()?,
            y_events: has_events.then(|| ReadOnly::new(y_events)).transpose()?,
            nfev: counters.nfev,
            nfev_jac: counters.nfev_jacobian,
            njev: counters.njev,
            nlu: counters.nlu,
            naccepted: counters.accepted,
            nrejected: counters.rejected,
            status: match status {
                Status::Finished => 0,
                Status::Event => 1,
                _ => -1,
            },
            reason: status.name().to_owned(),
            message,
            success: status.is_success(),
            stiff_at,
        })
    }
}

#[pymethods]
impl PyOdeResult {
    fn __traverse__(&self, visit: PyVisit<'_>) -> Result<(), PyTraverseError> {
        visit.call(self.t_events.as_ref().map(ReadOnly::get))?;
        visit.call(self.y_events.as_ref().map(ReadOnly::get))
    }

    fn __repr__(&self, py: Python<'_>) -> String {
        let points = self.t.bind(py).len().unwrap_or(0);
        let n = self.y.bind(py).dims()[0];
        format!(
            "OdeResult(success={}, reason={:?}, message={:?}, t=<{points} points>, y=<{n} x {points}>, nfev={}, \
             naccepted={}, nrejected={})",
            if self.success { "True" } else { "False" },
            self.reason,
            self.message,
            self.nfev,
            self.naccepted,
            self.nrejected
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

/// Vectors of n numbers as an array of shape (n, points), without a copy.
fn columns<'py>(
    py: Python<'py>,
    values: Vec<f64>,
    points: usize,
    n: usize,
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    values.into_pyarray(py).reshape([points, n])?.permute::<[usize; 2]>(None)
}

/// Solution of an initial value problem as a function of time: a polynomial for every step.
///
/// Call it with a time for an array of shape (n,), or with a 1-D array of m times for an array of shape (n,
/// m). Outside ``[t_min, t_max]`` the first and the last polynomial are extrapolated, without any guarantee
/// of accuracy.
///
/// Attributes
/// ----------
/// ts : ndarray, shape (n_steps + 1,)
///     Times at the ends of the polynomials, in the order of the integration.
/// t_min, t_max : float
///     The interval.
#[pyclass(name = "DenseOutput", module = "lissom", frozen)]
pub(crate) struct PyDenseOutput(Arc<DenseOutput>);

impl PyDenseOutput {
    pub(super) fn new(dense: DenseOutput) -> Self {
        Self(Arc::new(dense))
    }

    fn ends(&self) -> (f64, f64) {
        let times = self.0.times();
        (times[0], times[times.len() - 1])
    }
}

#[pymethods]
impl PyDenseOutput {
    /// Times at the ends of the polynomials.
    #[getter]
    fn ts<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        PyArray1::from_slice(py, self.0.times())
    }

    /// Start of the interval, or its end if the integration went backward.
    #[getter]
    fn t_min(&self) -> f64 {
        let (start, end) = self.ends();
        start.min(end)
    }

    /// End of the interval, or its start if the integration went backward.
    #[getter]
    fn t_max(&self) -> f64 {
        let (start, end) = self.ends();
        start.max(end)
    }

    /// The solution at a time or several.
    #[pyo3(signature = (t))]
    fn __call__<'py>(&self, py: Python<'py>, t: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
        let (times, is_single) = convert::scalar_or_vector(t, "t")
            .map_err(|_| PyValueError::new_err("`t` must be a float or a 1-D array."))?;
        let n = self.0.n();
        let mut y = vec![0.0; n * times.len()];
        if n > 0 {
            for (&t, y) in times.iter().zip(y.chunks_exact_mut(n)) {
                self.0.evaluate(t, y);
            }
        }
        if is_single {
            Ok(y.into_pyarray(py).into_any())
        } else {
            Ok(columns(py, y, times.len(), n)?.into_any())
        }
    }

    fn __repr__(&self) -> String {
        format!(
            "DenseOutput(t_min={:?}, t_max={:?}, {} steps)",
            self.t_min(),
            self.t_max(),
            self.0.times().len() - 1
        )
    }

    /// For copies and pickles.
    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<Reduced<'py>> {
        let DenseParts { is_nested, vectors, n, times, last_step_end, coefficients } = self.0.parts();
        let array = |values: &[f64]| PyArray1::from_slice(py, values);
        record::reduce_to::<Self>(
            py,
            (is_nested, vectors, n, array(times), last_step_end, array(coefficients)),
        )
    }

    #[staticmethod]
    fn _restore(
        is_nested: bool,
        vectors: usize,
        n: usize,
        times: &Bound<'_, PyAny>,
        last_step_end: f64,
        coefficients: &Bound<'_, PyAny>,
    ) -> PyResult<Self> {
        let times = &convert::vector(times, "times")?;
        let coefficients = &convert::vector(coefficients, "coefficients")?;
        let parts = DenseParts { is_nested, vectors, n, times, last_step_end, coefficients };
        Ok(Self::new(DenseOutput::from_parts(parts).or_raise()?))
    }
}
