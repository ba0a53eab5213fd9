//! `lissom.solve_ivp` and the step-by-step solvers.

mod events;
pub(super) mod function;
mod method;
pub(super) mod options;
mod result;
mod stepper;
pub(super) mod system;

use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyString};

pub(super) use result::{PyDenseOutput, PyOdeResult};
pub(super) use stepper::{PyDop853, PyOdeSolver, PyRadau, PyRk45};

use super::arguments;
use super::callback::{requests_stop, with_result};
use super::convert;
use crate::error::{Interrupted, InvalidInput};
use crate::integrators::ode::{Event, Options, Output, Solution, Stepper, solve};
use crate::python::errors::OrRaise as _;
use crate::python::words::required;
use function::Function;
use system::{Parts, PySystem, SharedRaised};

/// Solve an initial value problem ``dy/dt = fun(t, y)``, ``y(t0) = y0``.
///
/// Arguments and result are those of `scipy.integrate.solve_ivp`, with extensions of both; only real states
/// are supported.
///
/// Parameters
/// ----------
/// fun : callable, compiled function or Model
///     The right-hand side. A callable ``fun(t, y, *args)`` receives a float and a new array of shape (n,),
///     and returns n numbers. Much faster are compiled functions, called without Python: a `numba.cfunc`, a
///     `scipy.LowLevelCallable` or a ctypes function (created from an address by
///     ``ctypes.CFUNCTYPE(...)(address)``), with the C signature
///     ``void (double t, const double *y, double *dydt, const double *args)`` (a function with another
///     signature crashes the process); or a model of lissom, whose free motion is then integrated with
///     ``y = (q, qd)``. Both of these release the GIL.
/// t_span : (t0, tf)
///     The interval. `tf` may be infinite, or before `t0`. Nothing is evaluated outside.
/// y0 : array_like, shape (n,)
///     Initial state, real.
/// method : {'rk45', 'dop853', 'radau'} or class
///     'rk45' (default): explicit Runge-Kutta pair 5(4) of Dormand and Prince. 'dop853': explicit, order 8,
///     for tight tolerances. 'radau': implicit, order 5, for stiff problems. SciPy's names 'RK45',
///     'DOP853' and 'Radau' mean the same.
/// t_eval : array_like, optional
///     Output times, within `t_span` and in its order. By default all accepted steps.
/// dense_output : bool
///     Whether to return the solution as a function of time, `sol`.
/// events : callable or list of callables, optional
///     Functions ``event(t, y, *args)`` whose zeros along the solution are located. Attributes of an event:
///     `terminal` (True, or the number of occurrences after which to stop) and `direction` (1: only from
///     negative to positive, -1: only from positive to negative, 0: both). Every step is checked in
///     `event_samples` parts, so that two zeros in a step can be found. A zero at the start is not an event.
/// vectorized : bool
///     Whether `fun` accepts states of shape (n, k) and returns an array of this shape; saves calls for
///     finite-difference Jacobians.
/// args : tuple, optional
///     Further arguments of `fun`, `jac` and `events`. For a compiled function: the numbers to which its
///     `args` points.
/// rtol, atol : float or array_like of shape (n,)
///     The local error of component i, relative to ``atol[i] + rtol[i] * abs(y[i])``, is kept below one in
///     the root mean square over i. By default 1e-3 and 1e-6; `rtol` below 100 rounding units is raised to
///     that, with a warning.
/// first_step : float, optional
///     Size of the first step; by default chosen automatically.
/// max_step, min_step : float, optional
///     Bounds of the step size; by default infinite and 0. The last step may be shorter.
/// max_steps : int, optional
///     Maximum number of accepted steps; by default unlimited.
/// jac : callable, compiled function or matrix, optional
///     For 'radau', the Jacobian of `fun` with respect to y, shape (n, n):
///     ``jac(t, y, *args)``; a compiled function ``void (double t, const double *y, double *jac, const double *args)``
///     that writes it row by row; or a constant matrix. Sparse matrices are converted to dense ones. By
///     default finite differences. Models provide their own Jacobian.
/// jac_sparsity : array_like or sparse matrix, shape (n, n), optional
///     For 'radau' without `jac`: entries of the Jacobian that can be nonzero, which saves calls for finite
///     differences.
/// controller : {'I', 'PI'}
///     Step-size control of the explicit methods, from the last error (as in SciPy) or from the last two.
/// event_samples : int
///     Number of parts into which a step is divided to search for events; 1 checks its ends only.
/// callback : callable, optional
///     Called as ``callback(t, y)`` after every accepted step. Returning True or raising StopIteration ends
///     the integration, and the result contains everything computed until then.
///
/// Returns
/// -------
/// OdeResult
///     `t`, `y`, `sol`, `t_events`, `y_events`, `success`, `status`, `message`, counters and more.
///
/// Raises
/// ------
/// ValueError, TypeError
///     If an argument or a value returned by `fun`, `jac` or an event is invalid. Exceptions of these
///     functions are raised unchanged. Numerical failures do not raise: see `success`, `reason` and
///     `message`.
/// KeyboardInterrupt
///     On Ctrl-C. Its attribute `result` is the OdeResult up to then.
///
/// Examples
/// --------
/// >>> import lissom
/// >>> result = lissom.solve_ivp(lambda t, y: -0.5 * y, (0.0, 10.0), [2.0, 4.0], t_eval=[0.0, 5.0, 10.0], rtol=1e-8)
/// >>> result.y.round(4)
/// array([[2.    , 0.1642, 0.0135],
///        [4.    , 0.3283, 0.027 ]])
#[pyfunction]
#[pyo3(
    signature = (
        fun=None, t_span=None, y0=None, method=None, t_eval=None, dense_output=false, events=None, vectorized=false, args=None, *,
        rtol=None, atol=None, first_step=None, max_step=None, min_step=0.0, max_steps=None, jac=None,
        jac_sparsity=None, controller="I", event_samples=None, callback=None, **others
    ),
    text_signature = "(fun, t_span, y0, method='rk45', t_eval=None, dense_output=False, events=None, vectorized=False, \
                      args=None, *, rtol=0.001, atol=1e-06, first_step=None, max_step=None, min_step=0.0, \
                      max_steps=None, jac=None, jac_sparsity=None, controller='I', event_samples=10, callback=None)"
)]
#[allow(clippy::too_many_arguments, reason = "the signature of scipy.integrate.solve_ivp")]
pub(super) fn solve_ivp<'py>(
    py: Python<'py>,
    #[pyo3(from_py_with = arguments::given)] fun: Option<&Bound<'py, PyAny>>,
    #[pyo3(from_py_with = arguments::given)] t_span: Option<&Bound<'py, PyAny>>,
    #[pyo3(from_py_with = arguments::given)] y0: Option<&Bound<'py, PyAny>>,
    method: Option<&Bound<'py, PyAny>>,
    t_eval: Option<&Bound<'py, PyAny>>,
    #[pyo3(from_py_with = arguments::flag::dense_output)] dense_output: bool,
    events: Option<&Bound<'py, PyAny>>,
    #[pyo3(from_py_with = arguments::flag::vectorized)] vectorized: bool,
    args: Option<&Bound<'py, PyAny>>,
    rtol: Option<&Bound<'py, PyAny>>,
    atol: Option<&Bound<'py, PyAny>>,
    #[pyo3(from_py_with = arguments::optional_number::first_step)] first_step: Option<f64>,
    #[pyo3(from_py_with = arguments::optional_number::max_step)] max_step: Option<f64>,
    #[pyo3(from_py_with = arguments::number::min_step)] min_step: f64,
    #[pyo3(from_py_with = arguments::optional_whole::max_steps)] max_steps: Option<i64>,
    jac: Option<&Bound<'py, PyAny>>,
    jac_sparsity: Option<&Bound<'py, PyAny>>,
    #[pyo3(from_py_with = arguments::text::controller)] controller: &str,
    #[pyo3(from_py_with = arguments::optional_whole::event_samples)] event_samples: Option<i64>,
    #[pyo3(from_py_with = arguments::callback)] callback: Option<&Bound<'py, PyAny>>,
    others: Option<&Bound<'_, PyDict>>,
) -> PyResult<PyOdeResult> {
    let (fun, t_span, y0) = required!("solve_ivp", others, fun, t_span, y0);
    let t_span = interval(t_span)?;
    let y0 = options::initial_state(y0)?;
    let default = PyString::new(py, "rk45").into_any();
    let mut options = Options {
        method: method::method(method.unwrap_or(&default))?,
        first_step,
        max_step: max_step.unwrap_or(f64::INFINITY),
        min_step,
        max_steps: convert::step_limit(max_steps)?,
        controller: options::controller(controller)?,
        sparsity: jac_sparsity.map(|pattern| options::sparsity(pattern, y0.len())).transpose()?,
        ..Options::default()
    };
    if let Some(rtol) = rtol {
        options.rtol = options::tolerance(rtol, "rtol")?;
    }
    if let Some(atol) = atol {
        options.atol = options::tolerance(atol, "atol")?;
    }
    let mut output =
        Output { t_eval: super::motion::times(t_eval)?, dense: dense_output, ..Output::default() };
    if let Some(event_samples) = event_samples {
        output.event_samples = convert::count(event_samples, "event_samples")?;
    }
    let raised = SharedRaised::default();
    let parts = Parts { fun, args, jac, vectorized, method: options.method, n: y0.len() };
    let mut system = PySystem::new(&parts, raised.clone())?;
    let has_events = events.is_some();
    let mut events = match events {
        Some(events) => events::from_python(events, args.map(system::unpack).transpose()?.as_ref(), &raised)?,
        None => Vec::new(),
    };
    let solution = if system.is_native() && events.is_empty() && callback.is_none() {
        // The system itself checks for signals.
        py.detach(|| solve(&mut system, t_span, &y0, &options, &output, &mut [], &mut |_| Ok(())))
    } else {
        let callback = callback.map(Function::callback);
        run_attached(py, &mut system, t_span, &y0, (&options, &output), &mut events, callback, &raised)
    };
    let solution = solution.or_raise()?;
    if let Err(error) = raised.raise() {
        return Err(with_result(py, error, || PyOdeResult::new(py, solution, has_events)));
    }
    if solution.rtol_raised {
        options::warn_of_raised_rtol(py)?;
    }
    PyOdeResult::new(py, solution, has_events)
}

pub(super) fn interval(t_span: &Bound<'_, PyAny>) -> PyResult<(f64, f64)> {
    const EXPECTED: &str = "two numbers, (t0, tf)";
    let instead = match convert::numbers(t_span, "t_span", EXPECTED)?.values[..] {
        [t0, tf] => return Ok((t0, tf)),
        [tf] => format!("; from zero it is (0, {tf:?})"),
        [t0, .., tf] => format!("; times of the result are `t_eval`, beside t_span=({t0:?}, {tf:?})"),
        [] => String::new(),
    };
    let found = convert::describe(t_span);
    Err(PyTypeError::new_err(format!("t_span: expected {EXPECTED}, got {found}{instead}")))
}

/// Integration with calls of Python functions.
#[allow(clippy::too_many_arguments, reason = "an integration and what watches it")]
fn run_attached(
    py: Python<'_>,
    system: &mut PySystem,
    t_span: (f64, f64),
    y0: &[f64],
    (options, output): (&Options, &Output),
    events: &mut [Event<'_>],
    callback: Option<Function>,
    raised: &SharedRaised,
) -> Result<Solution, InvalidInput> {
    let mut monitor = |stepper: &Stepper| {
        raised.catch(py.check_signals())?;
        let Some(callback) = &callback else { return Ok(()) };
        let stop = raised.catch(requests_stop(py, callback.call(py, stepper.t(), stepper.y())))?;
        if stop { Err(Interrupted) } else { Ok(()) }
    };
    solve(system, t_span, y0, options, output, events, &mut monitor)
}
