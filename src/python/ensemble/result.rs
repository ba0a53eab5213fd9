//! `lissom.EnsembleResult`.

use numpy::{IntoPyArray, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};

use super::super::record::{self, ReadOnly, Reduced};
use super::super::remarks::with;
use crate::simulation::ensemble::{Ensemble, Keep, Outcome, Size};

/// Result of `simulate_many`: arrays with a row for each run. Missing values are NaN.
///
/// Attributes
/// ----------
/// t : ndarray, shape (m,)
///     Times of all rows, seconds. With keep='final', the output times that a complete run would have had.
/// q, v : ndarray, shape (count, m, n) for keep='states', else (count, n)
///     Coordinates and velocities of each row at all times, or its last ones.
/// poses : ndarray, shape (count, m, k, 4, 4) for keep='states', else (count, k, 4, 4), or None
///     Homogeneous matrices of the k requested places, as returned by `Robot.pose`.
/// lowest, highest : ndarray, shape (count, n), or None
///     Extremes of the coordinates over time in each row, for keep='summary'.
/// mean, variance : ndarray, shape (m, k, 3), or None
///     Mean and unbiased variance of the positions of the places at each time over the successful rows, metres and square
///     metres, for keep='summary'.
/// reached : ndarray, shape (count,)
///     Last time of each row, seconds.
/// success : ndarray of bool, shape (count,)
///     True for rows that reached the end.
/// status : ndarray of str, shape (count,)
///     As in `MotionResult`, or 'not_begun' for rows that were skipped after Ctrl-C, `progress` or an exception.
/// message : tuple of str
///     Status of each row in words, as in `MotionResult`.
/// doubt : tuple of str or None
///     Why the motion of a row may be inaccurate, as in `MotionResult`.
/// slack : tuple of tuple of str
///     Slack tendons of each row, as in `MotionResult`.
/// stats : dict of str to ndarray, shape (count,)
///     Cost of each row: the attributes of `Statistics` by name; NaN or zero if missing.
/// keep : str
///     The argument `keep`.
/// workers : int
///     Maximum number of threads.
/// wall_time : float
///     Run time of the whole ensemble, seconds.
/// nbytes : int
///     Memory of the arrays, bytes.
#[pyclass(name = "EnsembleResult", module = "lissom", frozen, get_all)]
#[derive(FromPyObject)]
pub(crate) struct PyEnsembleResult {
    t: ReadOnly,
    q: ReadOnly,
    v: ReadOnly,
    poses: Option<ReadOnly>,
    lowest: Option<ReadOnly>,
    highest: Option<ReadOnly>,
    mean: Option<ReadOnly>,
    variance: Option<ReadOnly>,
    reached: ReadOnly,
    success: ReadOnly,
    status: ReadOnly,
    message: Py<PyTuple>,
    doubt: Py<PyTuple>,
    slack: Py<PyTuple>,
    stats: ReadOnly,
    keep: String,
    workers: usize,
    wall_time: f64,
}

/// Status of an interrupted run.
pub(super) const INTERRUPTED: &str = "interrupted";

/// Status of a row that was not started.
const NOT_BEGUN: &str = "not_begun";

impl PyEnsembleResult {
    pub(super) fn new(
        py: Python<'_>,
        ensemble: Ensemble,
        times: Vec<f64>,
        workers: usize,
        keep: Keep,
        questions: &dyn Fn(usize) -> Vec<String>,
    ) -> PyResult<Self> {
        let Ensemble { size, q, v, poses, extremes, spread, outcomes, wall_time } = ensemble;
        let Size { count, times: m, n, places } = size;
        let array = |values: Vec<f64>, shape: &[usize]| {
            ReadOnly::new(values.into_pyarray(py).reshape(shape.to_vec())?.into_any())
        };
        let of_row = |rest: &[usize]| -> Vec<usize> {
            let times = (keep == Keep::States).then_some(m);
            [count].into_iter().chain(times).chain(rest.iter().copied()).collect()
        };
        let (lowest, highest) = match extremes {
            Some([lowest, highest]) => {
                (Some(array(lowest, &[count, n])?), Some(array(highest, &[count, n])?))
            }
            None => (None, None),
        };
        let (mean, variance) = match spread {
            Some(spread) => {
                let shape = [m, places, 3];
                (Some(array(spread.mean(), &shape)?), Some(array(spread.variance(), &shape)?))
            }
            None => (None, None),
        };
        let of_outcomes = |of: &dyn Fn(&Outcome) -> f64, unknown: f64| -> PyResult<ReadOnly> {
            let values = outcomes.iter().map(|outcome| outcome.as_ref().map_or(unknown, of));
            array(values.collect(), &[count])
        };
        let (status, success) = statuses(py, &outcomes)?;
        let texts = outcomes.iter().enumerate().map(|(row, outcome)| match outcome {
            Some(it) => with(&it.message, &questions(row)),
            None => "The run was not begun.".to_owned(),
        });
        let doubts = outcomes.iter().map(|outcome| outcome.as_ref().and_then(|it| it.doubt.as_deref()));
        let slack = outcomes.iter().map(|outcome| {
            let slack = outcome.iter().flat_map(|it| &it.slack).map(|slack| slack.name.as_str());
            PyTuple::new(py, slack.collect::<Vec<_>>())
        });
        let message = PyTuple::new(py, texts.collect::<Vec<_>>())?.unbind();
        let doubt = PyTuple::new(py, doubts.collect::<Vec<_>>())?.unbind();
        let slack = PyTuple::new(py, slack.collect::<PyResult<Vec<_>>>()?)?.unbind();
        Ok(Self {
            t: array(times, &[m])?,
            q: array(q, &of_row(&[n]))?,
            v: array(v, &of_row(&[n]))?,
            poses: if places > 0 { Some(array(poses, &of_row(&[places, 4, 4]))?) } else { None },
            lowest,
            highest,
            mean,
            variance,
            reached: of_outcomes(&|outcome| outcome.reached, f64::NAN)?,
            success,
            status,
            message,
            doubt,
            slack,
            stats: ReadOnly::new(statistics(py, &outcomes)?.into_any())?,
            keep: match keep {
                Keep::States => "states",
                Keep::Final => "final",
                Keep::Summary => "summary",
            }
            .to_owned(),
            workers,
            wall_time,
        })
    }
}

/// The status of each row, and whether it is a success.
fn statuses(py: Python<'_>, outcomes: &[Option<Outcome>]) -> PyResult<(ReadOnly, ReadOnly)> {
    let names: Vec<&str> =
        outcomes.iter().map(|outcome| outcome.as_ref().map_or(NOT_BEGUN, |it| it.status.name())).collect();
    let numpy = py.import("numpy")?;
    let status = match names[..] {
        [] => numpy.call_method1("empty", (0, "U1"))?,
        _ => numpy.call_method1("array", (&names,))?,
    };
    let success: Vec<bool> = outcomes
        .iter()
        .map(|outcome| outcome.as_ref().is_some_and(|outcome| outcome.status.is_success()))
        .collect();
    Ok((ReadOnly::new(status)?, ReadOnly::new(success.into_pyarray(py).into_any())?))
}

/// Costs of the rows, by the names of `Statistics`.
fn statistics<'py>(py: Python<'py>, outcomes: &[Option<Outcome>]) -> PyResult<Bound<'py, PyDict>> {
    let stats = PyDict::new(py);
    let numbers = |of: &dyn Fn(&Outcome) -> Option<f64>| {
        let values = outcomes.iter().map(|outcome| outcome.as_ref().and_then(of).unwrap_or(f64::NAN));
        values.collect::<Vec<_>>().into_pyarray(py)
    };
    let counts = |of: &dyn Fn(&crate::integrators::second_order::Counters) -> usize| {
        let values = outcomes
            .iter()
            .map(|outcome| outcome.as_ref().map_or(0, |outcome| of(&outcome.statistics.counters) as i64));
        values.collect::<Vec<i64>>().into_pyarray(py)
    };
    stats.set_item("wall_time", numbers(&|outcome| Some(outcome.statistics.wall_time)))?;
    stats.set_item("time_error", numbers(&|outcome| outcome.statistics.time_error))?;
    stats.set_item("space_error", numbers(&|outcome| outcome.statistics.space_error))?;
    stats.set_item("steps", counts(&|counters| counters.steps))?;
    stats.set_item("rejected", counts(&|counters| counters.rejected))?;
    stats.set_item("unsolved", counts(&|counters| counters.unsolved))?;
    stats.set_item("newton_iterations", counts(&|counters| counters.newton_iterations))?;
    stats.set_item("nfev", counts(&|counters| counters.nfev))?;
    stats.set_item("nfev_jac", counts(&|counters| counters.nfev_jacobian))?;
    stats.set_item("njev", counts(&|counters| counters.njev))?;
    stats.set_item("nlu", counts(&|counters| counters.nlu))?;
    stats.set_item("reuse_failures", counts(&|counters| counters.reuse_failures))?;
    stats.set_item("full_newton", counts(&|counters| counters.full_newton))?;
    Ok(stats)
}

#[pymethods]
impl PyEnsembleResult {
    fn __len__(&self, py: Python<'_>) -> PyResult<usize> {
        self.success.bind(py).len()
    }

    /// Memory of the arrays, bytes.
    #[getter]
    fn nbytes(&self, py: Python<'_>) -> PyResult<usize> {
        let Self { t, q, v, poses, lowest, highest, mean, variance, reached, success, status, stats, .. } =
            self;
        let given = [t, q, v, reached, success, status].into_iter();
        let optional = [poses, lowest, highest, mean, variance].into_iter().flatten();
        let bytes = |array: &Bound<'_, PyAny>| array.getattr("nbytes")?.extract::<usize>();
        let mut sum = 0;
        for array in given.chain(optional) {
            sum += bytes(array.bind(py))?;
        }
        for (_, array) in stats.bind(py).cast::<PyDict>()?.iter() {
            sum += bytes(&array)?;
        }
        Ok(sum)
    }

    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        let success = self.success.bind(py);
        let count = success.len()?;
        let done: usize = success.call_method0("sum")?.extract()?;
        let shape = self.q.bind(py).getattr("shape")?;
        let Self { keep, wall_time, .. } = self;
        Ok(format!(
            "<EnsembleResult: {done} of {count} runs succeeded, keep={keep:?}, q of shape {shape}, {wall_time:.3e} s>"
        ))
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
