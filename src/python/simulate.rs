//! `lissom.simulate`.

use numpy::ToPyArray;
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;

use super::arguments;
use super::callback::{Raised, call, or_raised, wants_to_stop, with_result};
use super::convert;
use super::errors::LissomError;
use super::model::{Native, PyModel};
use super::motion::{PyMotionResult, Ticker, finish, predictor, signals, step_size, times};
use super::ode::options::tolerance;
use super::robot::PyRobot;
use super::rod::PyRod;
use crate::accuracy;
use crate::error::{Checker, Interrupted, InvalidInput};
use crate::newmark::{self, Parameters, Scheme};
use crate::ode;
use crate::radau;
use crate::robot::Robot;
use crate::roots::Derivative;
use crate::simulate::{Control, Method, slackness};

/// Value of `t_eval` that requests all accepted steps.
const EVERY_STEP: &str = "steps";

/// Simulate the motion of a model from an initial state.
///
/// Parameters
/// ----------
/// model : Model
///     A `Rod`, `Robot` or `SpringPendulum`.
/// t_end : float
///     End of the simulation, seconds.
/// t0 : float
///     Start of the simulation, seconds: the time of `q0` and `v0`.
/// q0, v0 : array_like, shape (n,), optional
///     Initial coordinates and velocities; by default zero.
/// method : str
///     Implicit methods of second order, which use the inverse dynamics: 'newmark' (average acceleration unless `beta` and
///     `gamma` are given), 'average_acceleration', 'linear_acceleration', 'fox_goodwin', 'central_difference', 'hht' (with
///     `alpha`), 'generalised_alpha' (with `rho_inf`). Implicit, adaptive, of order 5: 'radau' (Radau IIA). Explicit and
///     adaptive, using the forward dynamics: 'rk45', 'dop853'. 'auto' chooses among the adaptive methods by the stiffness of
///     the model, and repeats the run until the estimated error meets the requested accuracy `rtol`; see
///     ``docs/accuracy.md``.
/// dt : float
///     Step size of the Newmark family, seconds; the last step may be shorter, and steps also end at corners of tables
///     (``docs/time.md``). For the other methods, the interval of the output times.
/// jac : {'analytic', 'forward', 'central'}
///     Jacobian of a step of the Newmark family: exact, by forward differences (n additional evaluations) or by central
///     differences (2n). 'radau' always uses the exact one.
/// rtol, atol : float or array_like of shape (n,)
///     Newmark family: a step is solved until the estimated error of the acceleration i is far below
///     ``atol[i] + rtol[i] * abs(a[i])``. Adaptive steps and the other methods: the local errors of coordinate and velocity i
///     are kept below ``atol[i] + rtol[i] * abs(q[i])`` and ``atol[i] + rtol[i] * abs(v[i])``, in the root mean square. The
///     unit of `atol` is that of q, of q per second, and of q per second squared, respectively. 'auto': `rtol` (by default
///     1e-4) is the largest error of the tip relative to the model's length; `atol` is not used.
/// t_eval : array_like or 'steps', optional
///     Increasing output times from `t0` to `t_end`, or 'steps' for every accepted step. By default every step (Newmark family)
///     or every `dt`.
/// control : callable, optional
///     Controller, called as ``control(t, q, v)`` at `t0` and after every `control_step`. It returns the model's inputs, shape
///     (inputs,), which are held until the next call. Steps end at these times; steps of fixed size are equal in between and
///     at most `dt`. Its exceptions are raised with the partial result as their attribute `result`. By default inputs keep
///     their defaults.
/// control_step : float, optional
///     Interval of the controller, seconds; by default `dt`.
/// progress : callable, optional
///     Called as ``progress(t)`` at the first step and then about twenty times a second. Returning True or raising
///     StopIteration stops the run, whose result then has the status 'interrupted'. Other exceptions are raised unchanged.
/// beta, gamma : float
///     Parameters of method 'newmark'; other methods do not accept them.
/// alpha : float, optional
///     Parameter of method 'hht', in [-1/3, 0]; by default -0.1.
/// rho_inf : float, optional
///     Parameter of method 'generalised_alpha', in [0, 1]: the spectral radius at infinite frequency, that is, the factor by
///     which a step multiplies infinitely fast oscillations. By default 0.8.
/// adaptive : bool
///     Whether the Newmark family adapts its steps by an error estimate, starting with `dt`. The other methods are always
///     adaptive.
/// max_step, min_step : float, optional
///     Bounds of adaptive steps, seconds ('auto': `max_step` only). Adaptive steps end at the times of tables, and there are at
///     least four per period of harmonic loads and base motions. To be sure that a pulse in a callable is not missed, choose
///     a `max_step` shorter than the pulse.
/// max_steps : int, optional
///     Maximum number of accepted steps; by default unlimited. 'auto': maximum for each of its runs, by default a million.
/// predictor : {'best', 'last', 'zero'}
///     Initial guess of the accelerations for Newton's method in a step of the Newmark family. 'last': those of the last step;
///     'zero'; 'best': zero, the last ones or an extrapolation of the last two, whichever was best in the last step.
/// reuse_jacobian : bool
///     Whether the Newmark family reuses factorised Jacobians while they converge; otherwise every Newton iteration evaluates
///     one.
///
/// Returns
/// -------
/// MotionResult
///     `t` of shape (m,), `q`, `v`, `a` of shape (m, n), `stats`, `success`, `status`, `message`. A numerical failure does not
///     raise: `success` is False, and the result contains everything up to the failure.
///
/// Raises
/// ------
/// ValueError, TypeError
///     If an argument is invalid or not accepted by the method, or if the result would not fit in memory.
/// KeyboardInterrupt
///     On Ctrl-C. Its attribute `result` is the MotionResult up to then.
///
/// Examples
/// --------
/// >>> import lissom
/// >>> result = lissom.simulate(lissom.SpringPendulum(), 1.0, q0=[-0.8, 0.5])
/// >>> result.success, result.q.shape
/// (True, (101, 2))
#[pyfunction]
#[pyo3(
    signature = (
        model, t_end, *, t0=0.0, q0=None, v0=None, method="newmark", dt=1e-2, jac=None, rtol=None, atol=None,
        t_eval=None, progress=None, beta=None, gamma=None, alpha=None, rho_inf=None, adaptive=None,
        max_step=None, min_step=0.0, max_steps=None, predictor=None, reuse_jacobian=None, control=None,
        control_step=None
    ),
    text_signature = "(model, t_end, *, t0=0.0, q0=None, v0=None, method='newmark', dt=0.01, jac='analytic', rtol=1e-06, \
                      atol=1e-09, t_eval=None, progress=None, beta=0.25, gamma=0.5, alpha=None, rho_inf=None, \
                      adaptive=False, max_step=None, min_step=0.0, max_steps=None, predictor='best', \
                      reuse_jacobian=True, control=None, control_step=None)"
)]
#[allow(clippy::too_many_arguments, reason = "keyword-only options of a Python function")]
pub(crate) fn simulate<'py>(
    model: &Bound<'py, PyAny>,
    #[pyo3(from_py_with = arguments::number::t_end)] t_end: f64,
    #[pyo3(from_py_with = arguments::number::t0)] t0: f64,
    q0: Option<&Bound<'py, PyAny>>,
    v0: Option<&Bound<'py, PyAny>>,
    #[pyo3(from_py_with = arguments::text::method)] method: &str,
    #[pyo3(from_py_with = arguments::number::dt)] dt: f64,
    #[pyo3(from_py_with = arguments::optional_text::jac)] jac: Option<&str>,
    rtol: Option<&Bound<'py, PyAny>>,
    atol: Option<&Bound<'py, PyAny>>,
    t_eval: Option<&Bound<'py, PyAny>>,
    #[pyo3(from_py_with = arguments::progress)] progress: Option<&Bound<'py, PyAny>>,
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
    control: Option<&Bound<'py, PyAny>>,
    #[pyo3(from_py_with = arguments::optional_number::control_step)] control_step: Option<f64>,
) -> PyResult<PyMotionResult> {
    let Ok(model) = model.cast::<PyModel>() else {
        return Err(PyTypeError::new_err(format!(
            "model: expected a Model (Rod, Robot, SpringPendulum), got {}; for equations of your own there are newmark and \
             solve_ivp",
            convert::describe(model)
        )));
    };
    let n = model.get().n();
    let state = |value: Option<&Bound<'py, PyAny>>, name| match value {
        Some(value) => convert::finite_vector_of(value, n, name),
        None => Ok(vec![0.0; n]),
    };
    let (q0, v0) = (state(q0, "q0")?, state(v0, "v0")?);
    let tells_steps = t_eval.is_some_and(is_every_step);
    let t_eval = times(t_eval.filter(|_| !tells_steps))?;
    let given = Given {
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
        needs_damping: model.get().look(needs_damping),
        tells_steps,
    };
    let way = given.way(n)?;
    let controller = Controller::new(model, control, control_step, dt, &way)?;
    run(model, (t0, t_end), [&q0, &v0], &way, t_eval.as_deref(), controller, progress)
}

/// Whether `t_eval` asks for every accepted step.
fn is_every_step(t_eval: &Bound<'_, PyAny>) -> bool {
    t_eval.extract::<&str>().is_ok_and(|text| text == EVERY_STEP)
}

/// The controller: a function of the user that sets inputs.
struct Controller {
    function: Py<PyAny>,
    step: f64,
}

impl Controller {
    fn new(
        model: &Bound<'_, PyModel>,
        function: Option<&Bound<'_, PyAny>>,
        step: Option<f64>,
        dt: f64,
        way: &Way,
    ) -> PyResult<Option<Self>> {
        let Some(function) = function else {
            return match step {
                None => Ok(None),
                Some(step) => Err(PyValueError::new_err(format!(
                    "control_step: got {step:?}, expected nothing: it is how far calls of `control` are apart, and there is none"
                ))),
            };
        };
        if !function.is_callable() {
            return Err(PyTypeError::new_err(format!(
                "control: expected a callable (t, q, v) -> u, got {}",
                convert::describe(function)
            )));
        }
        if model.get().look(|model| model.inputs() == 0) {
            return Err(PyValueError::new_err(
                "control: got a callable, expected nothing: this model has no inputs (give loads or actuators a lissom.Input)",
            ));
        }
        if matches!(way, Way::Accuracy(_)) {
            return Err(PyValueError::new_err(
                "control: got a callable, expected nothing: method \"auto\" computes motions several times; take another one",
            ));
        }
        Ok(Some(Self { function: function.clone().unbind(), step: step.unwrap_or(dt) }))
    }

    /// The inputs that the controller returns for a state.
    fn inputs(&self, py: Python<'_>, t: f64, [q, v]: [&[f64]; 2], inputs: &mut [f64]) -> PyResult<()> {
        let returned = call(self.function.bind(py), (t, q.to_pyarray(py), v.to_pyarray(py)))?;
        let read = convert::finite_vector_into(&returned, inputs, "control");
        read.map_err(|error| at_time(py, error, t))
    }
}

/// Adds the time to the message of an error about a returned value.
fn at_time(py: Python<'_>, error: PyErr, t: f64) -> PyErr {
    if error.is_instance_of::<PyValueError>(py) || error.is_instance_of::<PyTypeError>(py) {
        let message = format!("{} (at t = {t})", error.value(py));
        return PyErr::from_type(error.get_type(py), message);
    }
    error
}

/// The method of a simulation.
pub(super) enum Way {
    Method(Method),
    /// Any method that reaches the requested accuracy.
    Accuracy(accuracy::Request),
}

/// Whether the Newmark family needs numerical damping of infinite frequencies: for closed loops, and for
/// contact, which starts abruptly.
pub(super) fn needs_damping(model: &dyn Native) -> bool {
    model.constraints() > 0 || model.has_contact()
}

/// The options of the method as passed from Python.
pub(super) struct Given<'a, 'py> {
    pub(super) method: &'a str,
    pub(super) dt: f64,
    pub(super) jac: Option<&'a str>,
    pub(super) rtol: Option<&'a Bound<'py, PyAny>>,
    pub(super) atol: Option<&'a Bound<'py, PyAny>>,
    pub(super) parameters: Parameters,
    pub(super) adaptive: Option<bool>,
    pub(super) max_step: Option<f64>,
    pub(super) min_step: f64,
    pub(super) max_steps: Option<i64>,
    pub(super) predictor: Option<&'a str>,
    pub(super) reuse_jacobian: Option<bool>,
    /// Whether numerical damping of infinite frequencies is needed.
    pub(super) needs_damping: bool,
    /// Whether the result contains all accepted steps.
    pub(super) tells_steps: bool,
}

impl Given<'_, '_> {
    /// The method for a model of `n` coordinates.
    pub(super) fn way(&self, n: usize) -> PyResult<Way> {
        Ok(match self.method {
            "auto" => Way::Accuracy(self.accuracy()?),
            "radau" => Way::Method(self.radau(n)?),
            "rk45" => Way::Method(self.first_order(ode::Method::Rk45, n)?),
            "dop853" => Way::Method(self.first_order(ode::Method::Dop853, n)?),
            _ => Way::Method(self.newmark()?),
        })
    }

    fn accuracy(&self) -> PyResult<accuracy::Request> {
        self.refuse_options_of_newmark()?;
        let of_others = [
            ("atol", self.atol.is_some()),
            ("min_step", self.min_step != 0.0),
            ("t_eval='steps'", self.tells_steps),
        ];
        self.refuse(of_others)?;
        let tolerance = self.rtol.map_or(Ok(accuracy::DEFAULT_RTOL), PyAnyMethods::extract)?;
        let limit = self.max_steps.map(|limit| convert::count(limit, "max_steps")).transpose()?;
        let default = accuracy::Request::new(tolerance, self.dt);
        Ok(accuracy::Request {
            max_steps: limit.unwrap_or(default.max_steps),
            max_step: self.max_step.unwrap_or(default.max_step),
            ..default
        })
    }

    /// Relative and absolute tolerance, each a number or one per coordinate.
    fn tolerances(&self) -> PyResult<[ode::Tolerance; 2]> {
        let newmark::Options { rtol, atol, .. } = newmark::Options::new(self.dt);
        let rtol = self.rtol.map_or(Ok(rtol), |rtol| tolerance(rtol, "rtol"))?;
        let atol = self.atol.map_or(Ok(atol), |atol| tolerance(atol, "atol"))?;
        Ok([rtol, atol])
    }

    /// The tolerances of coordinates and velocities.
    fn tolerances_of_states(&self, n: usize) -> PyResult<[ode::Tolerance; 2]> {
        let [rtol, atol] = self.tolerances()?;
        Ok([twice(rtol, n, "rtol")?, twice(atol, n, "atol")?])
    }

    fn radau(&self, n: usize) -> PyResult<Method> {
        let max_steps = convert::step_limit(self.max_steps)?;
        self.refuse_options_of_newmark()?;
        let [rtol, atol] = self.tolerances_of_states(n)?;
        let options = radau::Options {
            rtol,
            atol,
            first_step: None,
            max_step: self.max_step.unwrap_or(f64::INFINITY),
            min_step: self.min_step,
            max_steps,
        };
        Ok(Method::Radau { options, dt: self.dt, tells_steps: self.tells_steps })
    }

    fn first_order(&self, method: ode::Method, n: usize) -> PyResult<Method> {
        let max_steps = convert::step_limit(self.max_steps)?;
        self.refuse_options_of_newmark()?;
        let [rtol, atol] = self.tolerances_of_states(n)?;
        let options = ode::Options {
            method,
            rtol,
            atol,
            max_step: self.max_step.unwrap_or(f64::INFINITY),
            min_step: self.min_step,
            max_steps,
            ..ode::Options::default()
        };
        Ok(Method::FirstOrder { options, dt: self.dt, tells_steps: self.tells_steps })
    }

    /// The scheme of the Newmark family; by default one with numerical damping if needed.
    fn scheme(&self) -> PyResult<Scheme> {
        let is_said = self.method != "newmark" || self.parameters != Parameters::default();
        if self.needs_damping && !is_said {
            return Ok(Scheme::generalised_alpha(Parameters::RHO_INF)?);
        }
        Ok(Scheme::by_name(self.method, &self.parameters).map_err(name_all_methods)?)
    }

    fn newmark(&self) -> PyResult<Method> {
        let [rtol, atol] = self.tolerances()?;
        let max_steps = convert::step_limit(self.max_steps)?;
        let defaults = newmark::Options::new(self.dt);
        Ok(Method::Newmark(newmark::Options {
            scheme: self.scheme()?,
            step_size: step_size(self.adaptive.unwrap_or(false), self.max_step, self.min_step)?,
            derivative: self.jac.map_or(Ok(Derivative::Analytic), derivative)?,
            rtol,
            atol,
            predictor: self.predictor.map_or(Ok(defaults.predictor), predictor)?,
            reuse_jacobian: self.reuse_jacobian.unwrap_or(defaults.reuse_jacobian),
            max_steps,
            ..defaults
        }))
    }

    /// Returns an error if options of the Newmark family are given for another method, even with their
    /// default values.
    fn refuse_options_of_newmark(&self) -> PyResult<()> {
        let Parameters { beta, gamma, alpha, rho_inf } = self.parameters;
        self.refuse([
            ("jac", self.jac.is_some()),
            ("beta", beta.is_some()),
            ("gamma", gamma.is_some()),
            ("alpha", alpha.is_some()),
            ("rho_inf", rho_inf.is_some()),
            ("adaptive", self.adaptive.is_some()),
            ("predictor", self.predictor.is_some()),
            ("reuse_jacobian", self.reuse_jacobian.is_some()),
        ])
    }

    /// Returns an error if options are given that the method does not have.
    fn refuse(&self, options: impl IntoIterator<Item = (&'static str, bool)>) -> PyResult<()> {
        match options.into_iter().find(|&(_, is_given)| is_given) {
            None => Ok(()),
            Some((name, _)) if self.method == "auto" => Err(PyValueError::new_err(format!(
                "{name}: expected nothing: the method is \"auto\", which takes `rtol` and chooses the rest"
            ))),
            Some((name, _)) => Err(PyValueError::new_err(format!(
                "{name}: expected nothing: it is an option of the Newmark family, the method is {:?}",
                self.method
            ))),
        }
    }
}

/// Computes a motion without the interpreter, which is acquired only for progress calls and Ctrl-C.
fn run(
    model: &Bound<'_, PyModel>,
    t_span: (f64, f64),
    [q0, v0]: [&[f64]; 2],
    way: &Way,
    t_eval: Option<&[f64]>,
    controller: Option<Controller>,
    progress: Option<&Bound<'_, PyAny>>,
) -> PyResult<PyMotionResult> {
    let py = model.py();
    let object = model.clone().unbind();
    let model = model.get().native();
    let (mut raised, mut raised_by_control) = (Raised::default(), Raised::default());
    let mut ticker = Ticker::new();
    let progress = progress.map(|progress| progress.clone().unbind());
    let simulation = py.detach(|| {
        let mut monitor = |t: f64| {
            raised.none_yet()?;
            if !ticker.tick() {
                return Ok(());
            }
            let stop = raised.catch(Python::attach(|py| {
                py.check_signals()?;
                match &progress {
                    Some(progress) => wants_to_stop(py, call(progress.bind(py), (t,))),
                    None => Ok(false),
                }
            }))?;
            if stop { Err(Interrupted) } else { Ok(()) }
        };
        match way {
            Way::Accuracy(request) => {
                model.simulate_to_accuracy(t_span, q0, v0, *request, t_eval, &mut monitor)
            }
            Way::Method(method) => {
                let mut inputs = |t: f64, q: &[f64], v: &[f64], inputs: &mut [f64]| {
                    let Some(controller) = &controller else { return Ok(()) };
                    raised_by_control.catch(Python::attach(|py| controller.inputs(py, t, [q, v], inputs)))
                };
                let step = controller.as_ref().map(|controller| controller.step);
                let control = step.map(|step| Control { step, inputs: &mut inputs });
                let simulation = model.simulate(t_span, q0, v0, method, t_eval, control, &mut monitor);
                simulation.map(|simulation| (simulation, None))
            }
        }
    });
    let (simulation, replacement) = simulation.map_err(with_python_names)?;
    let moved = match replacement.as_ref().and_then(|model| model.robot()) {
        Some(robot) => like(object.bind(py), robot)?.cast_into::<PyModel>()?.unbind(),
        None => object,
    };
    let raised = raised_by_control.into_result().and(raised.into_result());
    let has_tendons = |model: &dyn Native| model.robot().is_some_and(|robot| !robot.actuators.is_empty());
    let slack = moved.get().look(has_tendons).then(|| {
        let mut model = moved.get().native();
        py.detach(|| model.robot_model().map(|robot| slackness(robot, &simulation)))
    });
    // The first exception raised by a function of time tells more than later ones.
    let (raised, slack) = match (raised, or_raised(slack.flatten().unwrap_or(Ok(Vec::new())))) {
        (Ok(()), Ok(slack)) => (Ok(()), slack),
        (Err(error), slack) => (Err(error), slack.unwrap_or_default()),
        (Ok(()), Err(error)) => (Err(error), Vec::new()),
    };
    finish(py, simulation, &slack, Some(moved), raised)
}

/// The Python object for a robot: a Rod if the original is one, with the chosen modes.
fn like<'py>(original: &Bound<'py, PyAny>, robot: &Robot) -> PyResult<Bound<'py, PyAny>> {
    let py = original.py();
    match original.cast::<PyRod>() {
        Ok(rod) => {
            let rod = rod.get().description().with_segments_of(robot);
            Ok(Bound::new(py, PyRod::initializer(rod)?)?.into_any())
        }
        Err(_) => Ok(Bound::new(py, PyRobot::initializer(robot.clone())?)?.into_any()),
    }
}

/// Choose the numbers of modes of a rod or robot for a requested accuracy.
///
/// Trial runs with more modes of each strain show which modes affect the tip; these are kept. Strains that a perfectly
/// symmetric motion does not excite get no modes. The cost is that of about five to fifteen simulations.
///
/// Parameters
/// ----------
/// rod : Rod or Robot
///     Model whose numbers of modes are replaced.
/// t_end : float
///     End of the trial runs, seconds. They start at `t0` with zero coordinates and velocities.
/// rtol : float
///     Largest error of the tip due to the modes, relative to the rod's length.
/// dt : float
///     Interval of the times at which the tip is compared, seconds.
/// segments : sequence of int, optional
///     Segments whose modes are chosen, counted link by link; by default all of them.
/// t0 : float
///     Start of the trial runs, seconds.
///
/// Returns
/// -------
/// Rod or Robot
///     The model with the chosen numbers of modes.
///
/// Raises
/// ------
/// ValueError, TypeError
///     If an argument is invalid.
/// LissomError
///     If no such numbers are found; the message gives the reason.
/// KeyboardInterrupt
///     On Ctrl-C. Its attribute `result` is the model with the modes that the trials until then needed.
///
/// Examples
/// --------
/// >>> import lissom
/// >>> wire = lissom.Segment(1.0, 1e-3, 210e9, 80e9, 7800, modes={}, retardation_time=1e-4)
/// >>> rod = lissom.choose_modes(lissom.Rod([wire]), 0.5, rtol=1e-3)
/// >>> rod.segments[0].modes
/// {'bend_y': 4}
#[pyfunction]
#[pyo3(
    signature = (rod, t_end, *, rtol=accuracy::DEFAULT_RTOL, dt=1e-2, segments=None, t0=0.0),
    text_signature = "(rod, t_end, *, rtol=0.0001, dt=0.01, segments=None, t0=0.0)"
)]
pub(crate) fn choose_modes<'py>(
    #[pyo3(from_py_with = rod_of)] rod: &Bound<'py, PyRobot>,
    #[pyo3(from_py_with = arguments::number::t_end)] t_end: f64,
    #[pyo3(from_py_with = arguments::number::rtol)] rtol: f64,
    #[pyo3(from_py_with = arguments::number::dt)] dt: f64,
    #[pyo3(from_py_with = arguments::segments)] segments: Option<Vec<usize>>,
    #[pyo3(from_py_with = arguments::number::t0)] t0: f64,
) -> PyResult<Bound<'py, PyAny>> {
    let description = rod.get().description();
    let segments = segments.unwrap_or_else(|| (0..description.segments().count()).collect());
    let request = accuracy::Request::new(rtol, dt);
    let mut raised = Raised::default();
    let chosen = rod.py().detach(|| {
        accuracy::choose_modes(description, &segments, (t0, t_end), request, &mut signals(&mut raised))
    });
    let modes = chosen.map_err(with_python_names)?;
    if let Err(error) = raised.into_result() {
        let py = rod.py();
        return Err(with_result(py, error, || like(rod.as_any(), &modes.robot)));
    }
    if !modes.status.is_success() {
        return Err(LissomError::new_err(modes.message));
    }
    like(rod.as_any(), &modes.robot)
}

fn derivative(jac: &str) -> PyResult<Derivative> {
    match jac {
        "analytic" => Ok(Derivative::Analytic),
        "forward" => Ok(Derivative::Forward),
        "central" => Ok(Derivative::Central),
        _ => Err(PyValueError::new_err(format!(
            "jac: got {jac:?}, expected \"analytic\", \"forward\" or \"central\""
        ))),
    }
}

/// Tolerances of coordinates and velocities from those of the coordinates.
fn twice(tolerance: ode::Tolerance, n: usize, name: &str) -> Result<ode::Tolerance, InvalidInput> {
    let ode::Tolerance::Each(values) = tolerance else { return Ok(tolerance) };
    let mut checker = Checker::new();
    checker.length(&values, n, name);
    checker.finish()?;
    Ok(ode::Tolerance::Each([values.as_slice(), values.as_slice()].concat()))
}

/// Lists all methods of this function in a message that lists only the Newmark family.
fn name_all_methods(mut error: InvalidInput) -> InvalidInput {
    for problem in &mut error.problems {
        if problem.place == "method" {
            problem.expected.push_str(", \"rk45\", \"dop853\", \"radau\", \"auto\"");
        }
    }
    error
}

/// Replaces the core's interval by the two arguments in Python.
pub(super) fn with_python_names(mut error: InvalidInput) -> InvalidInput {
    for problem in &mut error.problems {
        match problem.place.as_str() {
            "t_span[0]" => problem.place = "t0".to_owned(),
            "t_span[1]" => problem.place = "t_end".to_owned(),
            _ => continue,
        }
        problem.expected = problem.expected.replace("t_span[0]", "t0");
    }
    error
}

/// The argument `rod`.
fn rod_of<'a, 'py>(value: &'a Bound<'py, PyAny>) -> PyResult<&'a Bound<'py, PyRobot>> {
    convert::instance(value, "rod", "lissom.Rod")
}
