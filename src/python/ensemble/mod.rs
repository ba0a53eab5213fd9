//! `lissom.simulate_many`.

mod inputs;
mod models;
mod places;
mod progress;
mod result;
mod rows;

use std::ffi::CString;
use std::sync::{Mutex, PoisonError};

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};

use self::inputs::Inputs;
use self::models::{Count, Models};
use self::places::places_of;
use self::progress::Progress;
use self::result::INTERRUPTED;
use self::rows::Rows;
use super::arguments;
use super::callback::{Raised, with_result};
use super::choice::with_python_names;
use super::errors::{AccuracyWarning, OrRaise as _, raise};
use super::motion::times;
use super::rows::{of_row, threads};
use super::simulate::{MethodOf, OptionArguments, method, needs_damping};
use crate::error::{Interrupted, InvalidInput};
use crate::integrators::newmark::Parameters;
use crate::python::words::required;
use crate::simulation::ensemble;
use crate::simulation::ensemble::{Ensemble, Keep, Monitor, Outcome, Size};
use crate::simulation::time_limit::TimeLimit;

pub(super) use self::result::PyEnsembleResult;

/// Simulate many motions in parallel: of many models, or of one model with many initial states or inputs.
///
/// Each run is a row of the result, bitwise equal to that of `simulate` with the same model, initial state
/// and inputs, for any number of threads. A run that fails has a status and does not affect the others.
/// Models without Python callables run without the interpreter; callables run in one thread at a time, so
/// more threads gain little.
///
/// Parameters
/// ----------
/// model : Model or sequence of Model
///     One model for all rows, or one per row. All must have the same number of coordinates and the same
///     inputs.
/// t_end : float
///     End of all simulations, seconds.
/// t0 : float
///     As for `simulate`.
/// q0, v0 : array_like, shape (n,) or (count, n), optional
///     Initial coordinates and velocities for all rows or one row each; by default zero. The models, `q0`, `v0` and `u` must
///     agree in their number of rows.
/// u : array_like, shape (inputs,), (count, inputs) or (count, steps, inputs), or dict, optional
///     Inputs of the models: constant during the run, for all rows or one row each; or for each row one set per control step,
///     starting at `t0`. By default the defaults of the inputs. Some of them by name: a dict for each row, or one dict whose values
///     have rows, such as ``{"pull": [1, 2, 3]}``.
/// control_step : float, optional
///     Duration of a control step, seconds; by default `dt`. Not accepted for constant inputs.
/// workers : int, optional
///     Maximum number of threads; by default the number of processors.
/// progress : bool or callable, optional
///     True shows a bar in the terminal. A callable is called as ``progress(done)`` with the number of finished runs about
///     twenty times a second; returning True or raising StopIteration skips the remaining runs. Other exceptions are raised.
/// keep : {'states', 'final', 'summary'}
///     Data to store for each row. 'states': the states at all times, as in `simulate`. 'final': the last state. 'summary': the
///     last state, the lowest and highest coordinates and, over all successful rows, mean and variance of the positions of
///     the places at each time.
/// places : sequence, optional
///     Points whose poses are stored: arc lengths (if there is one link, metres), names of links (their tips; rigid links
///     themselves), or pairs (link, arc length). For 'summary' by default the tip of the last link, or the mass of a
///     `SpringPendulum`.
/// memory_limit : float
///     Memory limit in bytes, by default 4 GiB. An ensemble that needs more raises before the first run.
/// max_seconds : float, optional
///     Limit of the wall-clock time of each run, seconds, as for `simulate`: rows that take longer have the status 'time_limit'.
/// method, dt, jac, rtol, atol, t_eval, beta, gamma, alpha, rho_inf, adaptive, max_step, min_step, max_steps, predictor, reuse_jacobian : optional
///     As for `simulate`. Adaptive steps of the Newmark family need `t_eval`, because their times differ between rows, except
///     with keep='final'.
///
/// Returns
/// -------
/// EnsembleResult
///     Stacked arrays `t`, `q`, `v`, `poses`, `success`, `status`, `stats`.
///
/// Raises
/// ------
/// ValueError, TypeError
///     Before the first run: if an argument of any row is invalid, or if the result needs too much memory.
/// KeyboardInterrupt
///     On Ctrl-C. Its attribute `result` is the EnsembleResult so far; exceptions raised by callables have it, too.
///
/// Warns
/// -----
/// AccuracyWarning
///     Once, if the fixed steps of some runs do not resolve their motion; `doubt` lists the runs.
///
/// Examples
/// --------
/// >>> import lissom, numpy as np
/// >>> starts = np.column_stack([np.full(5, -0.8), np.linspace(0, 0.4, 5)])
/// >>> result = lissom.simulate_many(lissom.SpringPendulum(), 1.0, q0=starts)
/// >>> result.success.all(), result.t.shape, result.q.shape
/// (np.True_, (101,), (5, 101, 2))
#[pyfunction]
#[pyo3(
    signature = (
        model=None, t_end=None, *more, t0=0.0, q0=None, v0=None, u=None, control_step=None, workers=None, progress=None, keep="states",
        places=None, memory_limit=MEMORY_LIMIT, method=MethodOf::Name("newmark"), dt=1e-2, jac=None, rtol=None, atol=None, t_eval=None, beta=None,
        gamma=None, alpha=None, rho_inf=None, adaptive=None, max_step=None, min_step=0.0, max_steps=None, predictor=None,
        reuse_jacobian=None, max_seconds=None, **others
    ),
    text_signature = "(model, t_end, *, t0=0.0, q0=None, v0=None, u=None, control_step=None, workers=None, progress=False, \
                      keep='states', places=None, memory_limit=4294967296.0, method='newmark', dt=0.01, jac='analytic', rtol=1e-06, \
                      atol=None, t_eval=None, beta=0.25, gamma=0.5, alpha=None, rho_inf=None, adaptive=False, \
                      max_step=None, min_step=0.0, max_steps=None, predictor='best', reuse_jacobian=True, max_seconds=None)"
)]
#[allow(clippy::too_many_arguments, reason = "keyword-only options of a Python function")]
pub(crate) fn simulate_many<'py>(
    #[pyo3(from_py_with = arguments::given)] model: Option<&Bound<'py, PyAny>>,
    #[pyo3(from_py_with = arguments::given_number::t_end)] t_end: Option<f64>,
    more: &Bound<'_, PyTuple>,
    #[pyo3(from_py_with = arguments::number::t0)] t0: f64,
    q0: Option<&Bound<'py, PyAny>>,
    v0: Option<&Bound<'py, PyAny>>,
    u: Option<&Bound<'py, PyAny>>,
    #[pyo3(from_py_with = arguments::optional_number::control_step)] control_step: Option<f64>,
    #[pyo3(from_py_with = arguments::optional_whole::workers)] workers: Option<i64>,
    progress: Option<&Bound<'py, PyAny>>,
    #[pyo3(from_py_with = arguments::text::keep)] keep: &str,
    places: Option<&Bound<'py, PyAny>>,
    #[pyo3(from_py_with = arguments::number::memory_limit)] memory_limit: f64,
    #[pyo3(from_py_with = method)] method: MethodOf<'_>,
    #[pyo3(from_py_with = arguments::number::dt)] dt: f64,
    #[pyo3(from_py_with = arguments::optional_text::jac)] jac: Option<&str>,
    rtol: Option<&Bound<'py, PyAny>>,
    atol: Option<&Bound<'py, PyAny>>,
    t_eval: Option<&Bound<'py, PyAny>>,
    #[pyo3(from_py_with = arguments::optional_number::beta)] beta: Option<f64>,
    #[pyo3(from_py_with = arguments::optional_number::gamma)] gamma: Option<f64>,
    #[pyo3(from_py_with = arguments::optional_number::alpha)] alpha: Option<f64>,
    #[pyo3(from_py_with = arguments::optional_number::rho_inf)] rho_inf: Option<f64>,
    #[pyo3(from_py_with = arguments::optional_flag::adaptive)] adaptive: Option<bool>,
    #[pyo3(from_py_with = arguments::optional_number::max_step)] max_step: Option<f64>,
    #[pyo3(from_py_with = arguments::number::min_step)] min_step: f64,
    #[pyo3(from_py_with = arguments::optional_whole::max_steps)] max_steps: Option<i64>,
    #[pyo3(from_py_with = arguments::optional_text::predictor)] predictor: Option<&str>,
    #[pyo3(from_py_with = arguments::optional_flag::reuse_jacobian)] reuse_jacobian: Option<bool>,
    #[pyo3(from_py_with = arguments::optional_number::max_seconds)] max_seconds: Option<f64>,
    others: Option<&Bound<'_, PyDict>>,
) -> PyResult<PyEnsembleResult> {
    let (model, t_end) = required!("simulate_many", others; more, model, t_end);
    let (py, keep, workers) = (model.py(), keep_of(keep)?, threads(workers)?);
    let models = Models::of(model)?;
    let first = models.first();
    let (n, inputs, t_span) = (first.n(), first.default_inputs().len(), (t0, t_end));
    let configuration = OptionArguments {
        method,
        dt,
        jac,
        rtol,
        atol,
        parameters: Parameters { beta, gamma, alpha, rho_inf },
        adaptive,
        max_step,
        min_step,
        max_steps,
        predictor,
        reuse_jacobian,
        needs_damping: first.inspect(needs_damping),
        returns_steps: false,
    }
    .configuration(n)?;
    let mut count = Count(models.rows().map(|rows| (rows, "model")));
    let (q0, v0) = (count.vectors(q0, n, "q0")?, count.vectors(v0, n, "v0")?);
    let inputs_of_rows = Inputs::of(u, &models, control_step, (t_span, dt), &mut count)?;
    let count = count.0.map_or(1, |(rows, _)| rows);
    let mut rows = Rows {
        models,
        places: Vec::new(),
        t_span,
        q0,
        v0,
        zeros: vec![0.0; n],
        inputs: inputs_of_rows,
        configuration,
        t_eval: times(t_eval)?,
        limit: TimeLimit::new(max_seconds, t_end).or_raise()?,
        keep,
        of_function: Mutex::new(None),
    };
    let times = rows.check(py, count)?;
    rows.t_eval = if times.differ { Some(times.of_rows.clone()) } else { rows.t_eval };
    rows.places = places_of(py, &rows.models, count, places, keep)?;
    let size = Size { count, times: times.of_rows.len(), n, places: rows.places.first().map_or(0, Vec::len) };
    check_memory(size, keep, inputs, workers, memory_limit)?;
    computed(py, &rows, size, times.of_rows, workers, &Progress::new(py, progress, count)?)
}

/// Default memory limit of results, bytes.
const MEMORY_LIMIT: f64 = crate::numerics::memory::LARGEST_RESULT as f64;

fn keep_of(keep: &str) -> PyResult<Keep> {
    match keep {
        "states" => Ok(Keep::States),
        "final" => Ok(Keep::Final),
        "summary" => Ok(Keep::Summary),
        _ => Err(PyValueError::new_err(format!(
            "keep: got {keep:?}, expected \"states\", \"final\" or \"summary\""
        ))),
    }
}

fn check_memory(size: Size, keep: Keep, inputs: usize, workers: usize, limit: f64) -> PyResult<()> {
    if limit.is_nan() || limit <= 0.0 {
        return Err(PyValueError::new_err(format!(
            "memory_limit: got {limit:?}, expected a number > 0 (bytes)"
        )));
    }
    let numbers = size.numbers(keep, inputs, workers);
    let bytes = numbers as f64 * size_of::<f64>() as f64;
    let found = format!("{} rows of {} times and {} coordinates", size.count, size.times, size.n);
    let instead = "ask for fewer times with `t_eval`, or keep \"final\" or \"summary\"";
    if bytes > limit {
        return Err(PyValueError::new_err(format!(
            "keep: {found} take {:.3} GB, more than `memory_limit`, {:.3} GB: {instead}, or raise `memory_limit`",
            bytes / 1e9,
            limit / 1e9
        )));
    }
    crate::numerics::memory::check(numbers, "keep", found, instead).or_raise()
}

/// The result of all runs, or what was refused or raised.
fn computed(
    py: Python<'_>,
    rows: &Rows,
    size: Size,
    times: Vec<f64>,
    workers: usize,
    progress: &Progress,
) -> PyResult<PyEnsembleResult> {
    let (ensemble, refused, raised) = run(py, rows, size, workers, progress);
    progress.close(py)?;
    if let Err((row, error)) = refused {
        return Err(of_row(py, row, &raise(with_python_names(error))));
    }
    finish(py, ensemble, times, workers, rows, raised)
}

/// Computes all runs without holding the interpreter, except for progress and Ctrl-C.
#[allow(clippy::type_complexity, reason = "what came of them, what was refused and what was raised")]
fn run(
    py: Python<'_>,
    rows: &Rows,
    size: Size,
    workers: usize,
    progress: &Progress,
) -> (Ensemble, Result<(), (usize, InvalidInput)>, PyResult<()>) {
    let mut raised = Raised::default();
    let (ensemble, refused) = py.detach(|| {
        let mut watch = |done: usize| {
            let stop = raised.catch(Python::attach(|py| {
                py.check_signals()?;
                progress.report(py, done)
            }))?;
            if stop { Err(Interrupted) } else { Ok(()) }
        };
        let run = |row: usize, monitor: &mut Monitor<'_>| rows.run(row, monitor);
        ensemble::simulate_many(size, rows.keep, workers, &run, &mut watch)
    });
    let of_function = rows.of_function.lock().unwrap_or_else(PoisonError::into_inner).take();
    let raised = of_function.map_or(Ok(()), Err).and(raised.into_result());
    // Runs may have finished since the last report.
    let was_cut = |outcome: &&Outcome| outcome.status.name() != INTERRUPTED;
    let done = ensemble.outcomes.iter().flatten().filter(was_cut).count();
    let raised = raised.and_then(|()| progress.report(py, done).map(|_| ()));
    (ensemble, refused, raised)
}

/// The result, with one warning about doubtful runs; or the exception that ended the runs, with the result as
/// an attribute.
fn finish(
    py: Python<'_>,
    ensemble: Ensemble,
    times: Vec<f64>,
    workers: usize,
    rows: &Rows,
    raised: PyResult<()>,
) -> PyResult<PyEnsembleResult> {
    let doubts = ensemble.outcomes.iter().flatten().filter_map(|outcome| outcome.doubt.as_ref());
    let doubts: Vec<&String> = doubts.collect();
    let warned = || match doubts[..] {
        [] => Ok(()),
        [first, ..] => {
            let text = format!("{} of {} runs: {first}", doubts.len(), ensemble.size.count);
            PyErr::warn(py, &py.get_type::<AccuracyWarning>(), &CString::new(text)?, 1)
        }
    };
    let ended = raised.and_then(|()| warned());
    let questions = rows.models.questions();
    let result = || PyEnsembleResult::new(py, ensemble, times, workers, rows.keep, &questions);
    match ended {
        Ok(()) => result(),
        Err(error) => Err(with_result(py, error, result)),
    }
}
