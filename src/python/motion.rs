//! The results of `newmark` and `simulate`, and their common options.

use std::ffi::CString;
use std::time::{Duration, Instant};

use numpy::{IntoPyArray, PyArray1, PyArray2, PyArrayMethods};
use pyo3::class::{PyTraverseError, PyVisit};
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::{PyFloat, PyInt};

use super::balance::PyBalance;
use super::callback::{Raised, or_raised, with_result};
use super::convert;
use super::errors::{AccuracyWarning, OrRaise as _};
use super::hard_steps::PyHardSteps;
use super::model::PyModel;
use super::overlap::PyOverlap;
use super::record::{self, ReadOnly, Reduced};
use super::remarks;
use crate::error::{Checker, Interrupted};
use crate::simulation::balance::{Balance, Flow};

use crate::integrators::second_order::Counters;
use crate::simulation::simulate::{Simulation, Slack, Statistics, accelerations};

/// Result of `simulate` and `newmark`. After a failure or interruption it contains everything computed until then.
///
/// Attributes
/// ----------
/// t : ndarray, shape (m,)
///     Times, seconds.
/// q, v, a : ndarray, shape (m, n)
///     Coordinates, velocities and accelerations at these times: ``q[i]`` is the state at ``t[i]``. Explicit
///     methods do not solve for accelerations: `a` is then computed on first access, with one evaluation per
///     time.
/// u : ndarray, shape (m, inputs)
///     Inputs from each of these times on; without a controller their defaults.
/// stats : Statistics
///     Counts of steps, iterations and evaluations.
/// balance : Balance or None
///     Energy balance at these times; None for `newmark`, which has no energies. Dissipation by damping is
///     integrated over every step of the run; the energies are computed on first access, with one evaluation
///     per time.
/// evaluations : ndarray of int, shape (m,), or None
///     Evaluations of the residual up to each of these times (explicit methods: of the forward dynamics): ``numpy.diff`` of it shows
///     where a run does its work, such as at first contacts. Those of the run that is returned, of method 'auto' without its trials.
///     None for `newmark` and for loaded results.
/// model : Model or None
///     The simulated model. Method 'auto' may replace the given one by one with more quadrature nodes. None
///     for `newmark`.
/// success : bool
///     True if the end of the interval was reached.
/// status : str
///     'finished', 'interrupted' (by the callback), 'no_initial_acceleration', 'newton_not_converged',
///     'singular_jacobian', 'non_finite', 'non_finite_jacobian' (method 'radau'), 'step_too_small', 'too_many_steps',
///     'accuracy_not_reached' (method 'auto'), 'stiff' (explicit methods: stability would require far too many steps),
///     'unstable' (steps of a conditionally stable method are beyond its limit, and a vibration has grown),
///     'unresolved' (the rod turns by more than half a turn between neighbouring quadrature nodes), 'inverted' (the stretch is
///     not positive somewhere), 'collapsed' (a tendon has pulled two points together, where its force has no direction),
///     'deep_penetration' (surfaces overlap by more than a radius), 'passed_through' (a body would pass through another one), 'loop_open' (closed
///     loops or tendons of given length cannot be held), 'singular_position' (of closed loops, which the method cannot pass),
///     'chattering' (tendons of given length become taut and slack ever faster) or 'time_limit' (`max_seconds` of wall-clock time
///     were over).
/// message : str
///     The status in words, what to change, the names of slack tendons, limits of segments that are exceeded (`min_bend_radius`,
///     `max_strain`, `max_stress`), and questions about numbers that are probably in other units.
/// slack : list of str
///     Tendons of a robot that were slack at any of these times: those of a given length whose path was
///     shorter, and those whose commanded tension was negative. Only these times are checked, not those in
///     between. Empty for `newmark`.
/// doubt : str or None
///     Why the motion may be inaccurate although the run succeeded: fixed steps that do not resolve a
///     vibration, or whose energy rises though nothing supplies any. It is in the message, and `simulate` issues it as
///     an `AccuracyWarning`.
/// deepest : Overlap or None
///     The overlap of surfaces, at the end of a step, that was deepest for their thickness; None if nothing touched.
/// hard_steps : HardSteps or None
///     The steps that were attempted more than once, or whose equations converged slowly: when, why, and what they cost. Those of the
///     run that is returned, of method 'auto' without its trials. None for `newmark` and for results of older versions.
#[pyclass(name = "MotionResult", module = "lissom", frozen)]
pub(crate) struct PyMotionResult {
    #[pyo3(get)]
    t: ReadOnly<PyArray1<f64>>,
    #[pyo3(get)]
    q: ReadOnly<PyArray2<f64>>,
    #[pyo3(get)]
    v: ReadOnly<PyArray2<f64>>,
    #[pyo3(get)]
    u: ReadOnly<PyArray2<f64>>,
    /// Computed on first access if the method does not solve for accelerations.
    a: PyOnceLock<ReadOnly<PyArray2<f64>>>,
    #[pyo3(get)]
    evaluations: Option<ReadOnly<PyArray1<i64>>>,
    #[pyo3(get)]
    stats: Py<PyStatistics>,
    #[pyo3(get)]
    success: bool,
    #[pyo3(get)]
    status: String,
    /// Without what is found when the message is read.
    outcome: String,
    message: PyOnceLock<String>,
    #[pyo3(get)]
    slack: Vec<String>,
    #[pyo3(get)]
    doubt: Option<String>,
    #[pyo3(get)]
    deepest: Option<Py<PyOverlap>>,
    #[pyo3(get)]
    hard_steps: Option<Py<PyHardSteps>>,
    #[pyo3(get)]
    model: Option<Py<PyModel>>,
    flow: Flow,
    balance: PyOnceLock<Py<PyBalance>>,
}

impl PyMotionResult {
    fn new(
        py: Python<'_>,
        simulation: Simulation,
        slack: &[Slack],
        model: Option<Py<PyModel>>,
    ) -> PyResult<Self> {
        let Simulation {
            t,
            q,
            v,
            a,
            u,
            n,
            evaluations,
            hard_steps,
            flow,
            statistics,
            status,
            mut message,
            doubt,
            deepest,
            held: _,
        } = simulation;
        for slack in slack {
            message = format!("{message} {}", slack.sentence());
        }
        let points = t.len();
        let inputs = u.len().checked_div(points).unwrap_or_default();
        let array = |values: Vec<f64>, n| ReadOnly::new(values.into_pyarray(py).reshape([points, n])?);
        let rows = |values| array(values, n);
        let known = PyOnceLock::new();
        if let Some(a) = a {
            let a = rows(a)?;
            known.get_or_init(py, || a);
        }
        Ok(Self {
            t: ReadOnly::new(t.into_pyarray(py))?,
            q: rows(q)?,
            v: rows(v)?,
            u: array(u, inputs)?,
            a: known,
            evaluations: model.as_ref().map(|_| counted(py, evaluations)).transpose()?,
            stats: Py::new(py, PyStatistics(statistics))?,
            success: status.is_success(),
            status: status.name().to_owned(),
            outcome: message,
            message: PyOnceLock::new(),
            slack: slack.iter().map(|slack| slack.name.clone()).collect(),
            doubt,
            deepest: PyOverlap::of_run(py, deepest, model.as_ref())?,
            hard_steps: PyHardSteps::of_run(py, &hard_steps, model.as_ref())?,
            model,
            flow,
            balance: PyOnceLock::new(),
        })
    }
}

impl PyMotionResult {
    /// Copies of the times, coordinates, velocities and inputs.
    fn states(&self, py: Python<'_>) -> PyResult<(Vec<f64>, [Vec<f64>; 3])> {
        let Self { q, v, u, .. } = self;
        let copy = |values: &ReadOnly<PyArray2<f64>>| values.bind(py).to_vec();
        Ok((self.t.bind(py).to_vec()?, [copy(q)?, copy(v)?, copy(u)?]))
    }
}

#[pymethods]
impl PyMotionResult {
    /// Accelerations at the times of the result, shape (m, n).
    #[getter]
    fn a<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let a = self.a.get_or_try_init(py, || {
            let model = self.model.as_ref().expect("all other runs solve for accelerations");
            let mut model = model.get().native();
            let (t, [q, v, u]) = self.states(py)?;
            let dims = [t.len(), model.facts().n];
            let a = or_raised(py.detach(|| accelerations(&mut *model, &t, &q, &v, &u)))?;
            ReadOnly::new(a.into_pyarray(py).reshape(dims)?)
        })?;
        Ok(a.bind(py).clone())
    }

    /// Energy balance at the times of the result; None for `newmark`, which has no energies.
    #[getter]
    fn balance(&self, py: Python<'_>) -> PyResult<Option<Py<PyBalance>>> {
        let Some(model) = &self.model else { return Ok(None) };
        let balance = self.balance.get_or_try_init(py, || {
            let mut model = model.get().native();
            let (t, [q, v, u]) = self.states(py)?;
            let balance = or_raised(py.detach(|| Balance::new(&mut *model, &t, &q, &v, &u, &self.flow)))?;
            Py::new(py, PyBalance::from_core(py, balance)?)
        })?;
        Ok(Some(balance.clone_ref(py)))
    }

    /// The status in words, what to change, the names of slack tendons, limits of segments that are exceeded, and questions about
    /// numbers that are probably in other units.
    #[getter]
    fn message<'a>(slf: &'a Bound<'_, Self>) -> PyResult<&'a str> {
        let own = slf.get();
        let whole = own
            .message
            .get_or_try_init(slf.py(), || remarks::of_motion(slf.as_any(), &own.outcome, own.model.as_ref()));
        whole.map(String::as_str)
    }

    fn __repr__(slf: &Bound<'_, Self>) -> PyResult<String> {
        let (py, own) = (slf.py(), slf.get());
        let dims = own.q.bind(py).dims();
        let (points, n) = (dims[0], dims[1]);
        Ok(format!(
            "MotionResult(success={}, status={:?}, message={:?}, t=<{points} times>, q=<{points} x {n}>, stats={})",
            if own.success { "True" } else { "False" },
            own.status,
            Self::message(slf)?,
            own.stats.get().__repr__()
        ))
    }

    /// For copies and pickles.
    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<Reduced<'py>> {
        let Self {
            t,
            q,
            v,
            u,
            a,
            evaluations,
            stats,
            success,
            status,
            outcome,
            message: _,
            slack,
            doubt,
            deepest,
            hard_steps,
            model,
            flow,
            balance: _,
        } = self;
        let states = (t, q, v, u, a.get(py));
        let flow = (flow.dissipated.as_slice(), flow.work.as_slice());
        record::reduce_to::<Self>(
            py,
            (
                states,
                flow,
                (stats, *success, status, outcome, slack, doubt),
                model,
                deepest,
                evaluations,
                hard_steps,
            ),
        )
    }

    #[staticmethod]
    #[pyo3(signature = (states, flow, outcome, model, deepest=None, evaluations=None, hard_steps=None))]
    #[allow(clippy::type_complexity, clippy::too_many_arguments, reason = "the parts of a result")]
    fn _restore(
        py: Python<'_>,
        states: (Py<PyAny>, Py<PyAny>, Py<PyAny>, Py<PyAny>, Option<Py<PyAny>>),
        flow: (Vec<f64>, Vec<f64>),
        outcome: (Py<PyStatistics>, bool, String, String, Vec<String>, Option<String>),
        model: Option<Py<PyModel>>,
        deepest: Option<Py<PyOverlap>>,
        evaluations: Option<Vec<usize>>,
        hard_steps: Option<Py<PyHardSteps>>,
    ) -> PyResult<Self> {
        let t = convert::vector(states.0.bind(py), "t")?;
        let n = states.1.bind(py).cast::<PyArray2<f64>>()?.dims()[1];
        let inputs = states.3.bind(py).cast::<PyArray2<f64>>()?.dims()[1];
        let array = |value: &Py<PyAny>, name, n| {
            let (points, value) = (t.len(), value.bind(py));
            let values = convert::numbers(value, name, "an array of real numbers")?;
            values.matrix((points, n), name)?;
            ReadOnly::new(values.values.into_pyarray(py).reshape([points, n])?)
        };
        let rows = |value, name| array(value, name, n);
        let a = PyOnceLock::new();
        if let Some(known) = &states.4 {
            _ = a.set(py, rows(known, "a")?);
        }
        let mut check = Checker::new();
        for (values, name) in [(&flow.0, "dissipated"), (&flow.1, "work")] {
            check.require(values.is_empty() || values.len() == t.len(), name, values.len(), "one a time");
        }
        let of_model = model.as_ref().map_or(n, |model| model.get().n());
        check.require(of_model == n, "model", of_model, "a model of as many coordinates");
        let of_model =
            model.as_ref().map_or(inputs, |model| model.get().inspect(|model| model.facts().inputs()));
        check.require([0, of_model].contains(&inputs), "u", inputs, "the inputs of the model");
        let counted_states = evaluations.as_ref().map_or(t.len(), Vec::len);
        check.require(counted_states == t.len(), "evaluations", counted_states, "one for each time");
        check.finish().or_raise()?;
        let (stats, success, status, outcome, slack, doubt) = outcome;
        let (q, v, u) = (rows(&states.1, "q")?, rows(&states.2, "v")?, array(&states.3, "u", inputs)?);
        let flow = Flow { dissipated: flow.0, work: flow.1 };
        let (t, balance) = (ReadOnly::new(t.into_pyarray(py))?, PyOnceLock::new());
        Ok(Self {
            t,
            q,
            v,
            u,
            a,
            evaluations: evaluations.map(|evaluations| counted(py, evaluations)).transpose()?,
            stats,
            success,
            status,
            outcome,
            message: PyOnceLock::new(),
            slack,
            doubt,
            deepest,
            hard_steps,
            model,
            flow,
            balance,
        })
    }

    fn __traverse__(&self, visit: PyVisit<'_>) -> Result<(), PyTraverseError> {
        visit.call(&self.model)
    }
}

/// Numbers of evaluations as an array.
fn counted(py: Python<'_>, evaluations: Vec<usize>) -> PyResult<ReadOnly<PyArray1<i64>>> {
    let numbers: Vec<i64> = evaluations.into_iter().map(|number| number as i64).collect();
    ReadOnly::new(numbers.into_pyarray(py))
}

/// Cost of a run. Counters that do not apply to the method are zero.
///
/// Attributes
/// ----------
/// wall_time : float
///     Run time, seconds.
/// time_error, space_error : float or None
///     Estimated errors of the tip due to the time steps and due to the number of modes and nodes, relative to the model's
///     length; None unless the method is 'auto'.
/// steps : int
///     Accepted steps.
/// rejected : int
///     Steps rejected because of their error estimate.
/// unsolved : int
///     Adaptive steps cut because their equations could not be solved.
/// newton_iterations : int
///     Newton iterations of all steps and for the initial accelerations.
/// nfev : int
///     Evaluations of the residual (explicit methods: of the forward dynamics), excluding those for finite-difference Jacobians.
/// nfev_jac : int
///     Evaluations for finite-difference Jacobians.
/// njev, nlu : int
///     Numbers of Jacobians and of factorisations.
/// reuse_failures : int
///     Steps in which Newton's method failed with the Jacobian of an earlier step.
/// full_newton : int
///     Steps that needed a fresh Jacobian in every iteration.
#[pyclass(name = "Statistics", module = "lissom", frozen)]
pub(crate) struct PyStatistics(Statistics);

impl PyStatistics {
    fn counters(&self) -> &Counters {
        &self.0.counters
    }
}

#[pymethods]
impl PyStatistics {
    /// Seconds.
    #[getter]
    fn wall_time(&self) -> f64 {
        self.0.wall_time
    }

    /// Estimated error of the tip due to the time steps, relative to the model's length; None unless the method is 'auto'.
    #[getter]
    fn time_error(&self) -> Option<f64> {
        self.0.time_error
    }

    /// Estimated error of the tip due to the number of modes and nodes, relative to the model's length, or None.
    #[getter]
    fn space_error(&self) -> Option<f64> {
        self.0.space_error
    }

    /// Accepted steps.
    #[getter]
    fn steps(&self) -> usize {
        self.counters().steps
    }

    /// Steps rejected because of their error estimate.
    #[getter]
    fn rejected(&self) -> usize {
        self.counters().rejected
    }

    /// Adaptive steps cut because their equations could not be solved.
    #[getter]
    fn unsolved(&self) -> usize {
        self.counters().unsolved
    }

    /// Newton iterations, in all steps and for the initial accelerations.
    #[getter]
    fn newton_iterations(&self) -> usize {
        self.counters().newton_iterations
    }

    /// Evaluations, excluding those for finite-difference Jacobians.
    #[getter]
    fn nfev(&self) -> usize {
        self.counters().nfev
    }

    /// Evaluations for finite-difference Jacobians.
    #[getter]
    fn nfev_jac(&self) -> usize {
        self.counters().nfev_jacobian
    }

    /// Jacobians.
    #[getter]
    fn njev(&self) -> usize {
        self.counters().njev
    }

    /// Factorisations.
    #[getter]
    fn nlu(&self) -> usize {
        self.counters().nlu
    }

    /// Steps in which Newton's method failed with the Jacobian of an earlier step.
    #[getter]
    fn reuse_failures(&self) -> usize {
        self.counters().reuse_failures
    }

    /// Steps that needed a fresh Jacobian in every iteration.
    #[getter]
    fn full_newton(&self) -> usize {
        self.counters().full_newton
    }

    fn __repr__(&self) -> String {
        let Counters { steps, rejected, unsolved, newton_iterations, nfev, .. } = *self.counters();
        let Counters { nfev_jacobian, njev, nlu, reuse_failures, full_newton, .. } = *self.counters();
        format!(
            "Statistics(wall_time={:.3e}, steps={steps}, rejected={rejected}, unsolved={unsolved}, \
             newton_iterations={newton_iterations}, nfev={nfev}, nfev_jac={nfev_jacobian}, njev={njev}, nlu={nlu}, \
             reuse_failures={reuse_failures}, full_newton={full_newton})",
            self.wall_time()
        )
    }

    /// For copies and pickles.
    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<Reduced<'py>> {
        let Statistics { wall_time, time_error, space_error, counters } = &self.0;
        let Counters { steps, rejected, unsolved, newton_iterations, nfev, .. } = *counters;
        let Counters { nfev_jacobian, njev, nlu, reuse_failures, full_newton, .. } = *counters;
        let counts = [steps, rejected, unsolved, newton_iterations, nfev];
        let more = [nfev_jacobian, njev, nlu, reuse_failures, full_newton];
        record::reduce_to::<Self>(py, (*wall_time, *time_error, *space_error, counts, more))
    }

    #[staticmethod]
    fn _restore(
        wall_time: f64,
        time_error: Option<f64>,
        space_error: Option<f64>,
        counts: [usize; 5],
        more: [usize; 5],
    ) -> Self {
        let [steps, rejected, unsolved, newton_iterations, nfev] = counts;
        let [nfev_jacobian, njev, nlu, reuse_failures, full_newton] = more;
        let counters = Counters {
            steps,
            rejected,
            unsolved,
            newton_iterations,
            nfev,
            nfev_jacobian,
            njev,
            nlu,
            reuse_failures,
            full_newton,
        };
        Self(Statistics { wall_time, time_error, space_error, counters })
    }
}

/// The result of a run, with a warning if it is doubtful; or the exception that ended the run, with the
/// result as an attribute.
pub(super) fn finish(
    py: Python<'_>,
    simulation: Simulation,
    slack: &[Slack],
    model: Option<Py<PyModel>>,
    raised: PyResult<()>,
) -> PyResult<PyMotionResult> {
    let doubt = simulation.doubt.clone();
    let warned = || match doubt {
        Some(doubt) => PyErr::warn(py, &py.get_type::<AccuracyWarning>(), &CString::new(doubt)?, 1),
        None => Ok(()),
    };
    match raised.and_then(|()| warned()) {
        Ok(()) => PyMotionResult::new(py, simulation, slack, model),
        Err(error) => Err(with_result(py, error, || PyMotionResult::new(py, simulation, slack, model))),
    }
}

/// A monitor that only responds to Ctrl-C.
pub(super) fn signals(raised: &mut Raised) -> impl FnMut(f64) -> Result<(), Interrupted> {
    let mut ticker = Ticker::new();
    move |_| {
        raised.none_yet()?;
        if ticker.tick() {
            raised.catch(Python::attach(|py| py.check_signals()))?;
        }
        Ok(())
    }
}

/// Determines when to check for signals and report progress: at the first step, then about twenty times a
/// second.
pub(super) struct Ticker {
    last: Option<Instant>,
    // Time of the last reading of the clock, steps since then, and steps until the next reading.
    looked: Instant,
    steps: u32,
    stride: u32,
}

impl Ticker {
    /// Too short for a waiting user to notice, and long enough not to affect the run time.
    const INTERVAL: Duration = Duration::from_millis(50);
    /// Maximum number of steps between two readings of the clock, which cost as much as a step of a small
    /// system.
    const STEPS: u32 = 64;
    /// Intervals between readings that are too short or too long.
    const FREQUENT: Duration = Duration::from_millis(2);
    const RARE: Duration = Duration::from_millis(10);

    pub(super) fn new() -> Self {
        Self { last: None, looked: Instant::now(), steps: 0, stride: 1 }
    }

    /// Counts a step; returns true if a check is due.
    pub(super) fn tick(&mut self) -> bool {
        self.steps += 1;
        if self.steps < self.stride {
            return false;
        }
        let now = Instant::now();
        let since = now - self.looked;
        if since < Self::FREQUENT {
            self.stride = (2 * self.stride).min(Self::STEPS);
        } else if since > Self::RARE {
            self.stride = (self.stride / 8).max(1);
        }
        (self.looked, self.steps) = (now, 0);
        let due = self.last.is_none_or(|last| now - last >= Self::INTERVAL);
        if due {
            self.last = Some(now);
        }
        due
    }
}

/// Times from the argument `t_eval`.
pub(super) fn times(t_eval: Option<&Bound<'_, PyAny>>) -> PyResult<Option<Vec<f64>>> {
    let Some(t_eval) = t_eval else { return Ok(None) };
    if t_eval.is_instance_of::<PyFloat>() || t_eval.is_instance_of::<PyInt>() {
        return Err(PyTypeError::new_err(
            "t_eval: got a number, expected the times of the result, such as numpy.linspace(t0, t_end, 101)",
        ));
    }
    convert::vector(t_eval, "t_eval").map(Some)
}
