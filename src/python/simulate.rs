//! `lissom.simulate`.

use numpy::ToPyArray;
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyString, PyTuple};

use super::arguments;
use super::callback::{Form, Raised, call, or_raised, requests_stop};
use super::choice::{self, Chosen, like, with_python_names};
use super::convert;
use super::errors::OrRaise as _;
use super::inputs::{Rows, mapping_of, or_rows, set_named};
use super::model::{Native, PyModel, any_model_of};
use super::motion::{PyMotionResult, Ticker, finish, times};
use super::ode::options::tolerance;
use super::part::PyPart;
use crate::description::schema::{Data, Kind, Reader, Value, did_you_mean};
use crate::error::{Interrupted, InvalidInput, Time};
use crate::integrators::newmark::{ATOL, Impacts, METHODS, Parameters, Predictor, RTOL};
use crate::python::words::required;
use crate::robot::RobotModel;
use crate::simulation::accuracy;
use crate::simulation::methods::{
    Auto, Configuration, Dop853, Integration, Jacobian, Newmark, QuasiStatic, Radau, Rk45,
};
use crate::simulation::simulate::{
    Control, Simulation, Slack, add_overloads, creep, has_friction, slackness,
};
use crate::simulation::stepping::Status;
use crate::simulation::time_limit::TimeLimit;

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
/// method : str or one of `lissom.methods`
///     An object has all of its options, such as ``lissom.methods.Radau(rtol=1e-8)``; the name of a method takes them from below.
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
///     unit of `atol` is that of q, of q per second, and of q per second squared, respectively. By default it is 1e-9 for local
///     errors; accelerations near zero are solved to what moves coordinates by rounding alone, in any units (see
///     ``docs/newmark.md``). 'auto': `rtol` (by default 1e-4) is the largest error of the tip relative to the model's length;
///     `atol` is not used.
/// t_eval : array_like or 'steps', optional
///     Increasing output times from `t0` to `t_end`, or 'steps' for every accepted step. By default every step (Newmark family)
///     or every `dt`.
/// u : array_like, shape (m,), or dict, optional
///     Inputs, or some of them by name, which are held during the run; by default `u0` of the model. With `control`, those at `t0` that it
///     leaves out. For inputs that follow a function u(t) there is `control`.
/// control : callable, optional
///     Controller, called as ``control(t, q, v)`` at `t0` and after every `control_step`. It returns the model's inputs, shape
///     (inputs,), or some of them as a dict; they are held until the next call. Steps end at these times; steps of fixed size are equal in between and
///     at most `dt`. Its exceptions are raised with the partial result as their attribute `result`. By default inputs keep
///     their defaults. 'auto' calls it once for each interval, too, and estimates the error of the loop from runs under the inputs that it
///     gave; see ``docs/accuracy.md``.
/// control_step : float, optional
///     Interval of the controller, seconds; by default `dt`.
/// progress : callable, optional
///     Called as ``progress(t)`` at the first step and then about twenty times a second. Returning True or raising
///     StopIteration stops the run, whose result then has the status 'interrupted'. Other exceptions are raised unchanged.
/// beta, gamma : float
///     Parameters of method 'newmark'; other methods do not accept them.
/// alpha : float, optional
///     Parameter of method 'hht', in [-1/3, 0]; by default -0.1. With it, 'newmark' is that method.
/// rho_inf : float, optional
///     Parameter of method 'generalised_alpha', which 'newmark' is with it, in [0, 1]: the spectral radius at infinite
///     frequency, that is, the factor by which a step multiplies infinitely fast oscillations. By default 0.8.
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
/// max_seconds : float, optional
///     Limit of the wall-clock time of the run, seconds; by default none. It is also looked at within steps that take long, which
///     are given up. The result then has the status 'time_limit' and what was computed until then.
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
        model=None, t_end=None, *more, t0=0.0, q0=None, v0=None, method=MethodOf::Name("newmark"), dt=1e-2, jac=None, rtol=None, atol=None,
        t_eval=None, progress=None, beta=None, gamma=None, alpha=None, rho_inf=None, adaptive=None,
        max_step=None, min_step=0.0, max_steps=None, predictor=None, reuse_jacobian=None, control=None,
        control_step=None, max_seconds=None, u=None, **others
    ),
    text_signature = "(model, t_end, *, t0=0.0, q0=None, v0=None, method='newmark', dt=0.01, jac='analytic', rtol=1e-06, \
                      atol=None, t_eval=None, progress=None, beta=0.25, gamma=0.5, alpha=None, rho_inf=None, \
                      adaptive=False, max_step=None, min_step=0.0, max_steps=None, predictor='best', \
                      reuse_jacobian=True, control=None, control_step=None, max_seconds=None, u=None)"
)]
#[allow(clippy::too_many_arguments, reason = "keyword-only options of a Python function")]
pub(crate) fn simulate<'py>(
    #[pyo3(from_py_with = arguments::given)] model: Option<&Bound<'py, PyAny>>,
    #[pyo3(from_py_with = arguments::given_number::t_end)] t_end: Option<f64>,
    more: &Bound<'_, PyTuple>,
    #[pyo3(from_py_with = arguments::number::t0)] t0: f64,
    q0: Option<&Bound<'py, PyAny>>,
    v0: Option<&Bound<'py, PyAny>>,
    #[pyo3(from_py_with = method)] method: MethodOf<'_>,
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
    #[pyo3(from_py_with = arguments::optional_number::max_seconds)] max_seconds: Option<f64>,
    u: Option<&Bound<'py, PyAny>>,
    others: Option<&Bound<'_, PyDict>>,
) -> PyResult<PyMotionResult> {
    // Before what is missing: files and scenes are given without it.
    model.map(|model| any_model_of(model, "model")).transpose()?;
    let (model, t_end) = required!("simulate", others; more, model, t_end);
    let model = any_model_of(model, "model")?;
    let mut limit = TimeLimit::new(max_seconds, t_end).or_raise()?;
    let begun = Begun { start: [q0, v0], u, is_controlled: control.is_some() };
    let chosen = choose(model, (t0, t_end), (&method, rtol, dt), &begun, &mut limit)?;
    let model = chosen.as_ref().map_or(model, |chosen| &chosen.model);
    let n = model.get().n();
    let state = |value: Option<&Bound<'py, PyAny>>, name| match value {
        Some(value) => convert::finite_vector_of(value, n, name),
        None => Ok(vec![0.0; n]),
    };
    let (q0, v0) = (state(q0, "q0")?, state(v0, "v0")?);
    let returns_steps = t_eval.is_some_and(is_every_step);
    let t_eval = times(t_eval.filter(|_| !returns_steps))?;
    let given = OptionArguments {
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
        needs_damping: model.get().inspect(needs_damping),
        returns_steps,
    };
    let configuration = given.configuration(n)?;
    let held = u.map(|u| held_inputs(model, u)).transpose()?;
    let controller = match (Controller::new(model, control, control_step, dt)?, held) {
        (None, Some(held)) => {
            let whole = t_end - t0;
            let step = if whole > 0.0 && whole.is_finite() { whole } else { dt };
            Some(Controller { function: None, held, step, names: Vec::new() })
        }
        (controller, held) => controller.map(|own| Controller { held: held.unwrap_or_default(), ..own }),
    };
    let span = (t0, t_end);
    let watched = Watched { progress, limit, chosen: chosen.as_ref() };
    run(model, span, [&q0, &v0], &configuration, t_eval.as_deref(), controller, watched)
}

/// How a motion begins, and what drives it.
struct Begun<'a, 'py> {
    start: [Option<&'a Bound<'py, PyAny>>; 2],
    u: Option<&'a Bound<'py, PyAny>>,
    is_controlled: bool,
}

/// Chooses open modes for a motion from rest to its accuracy; `None` if there are none.
fn choose<'py>(
    model: &Bound<'py, PyModel>,
    t_span: (f64, f64),
    (method, rtol, dt): (&MethodOf<'_>, Option<&Bound<'py, PyAny>>, f64),
    &Begun { start, u, is_controlled }: &Begun<'_, 'py>,
    limit: &mut TimeLimit,
) -> PyResult<Option<Chosen<'py>>> {
    if !model.get().is_open() {
        return Ok(None);
    }
    if is_controlled {
        return Err(PyValueError::new_err(
            "control: the modes are open, and what a controller will give is not known when they are chosen: choose the modes before \
             with `lissom.choose_modes`",
        ));
    }
    let rtol = match method {
        MethodOf::Name("auto") => {
            rtol.map_or(Ok(accuracy::DEFAULT_RTOL), |rtol| convert::number(rtol, "rtol"))?
        }
        MethodOf::Described(Integration::Auto(Auto { rtol, .. })) => *rtol,
        _ => {
            return Err(PyValueError::new_err(
                "method: the modes are open, and are chosen to the `rtol` of method=\"auto\": give that, or choose the modes before \
                 with `lissom.choose_modes(robot, t_end, rtol=1e-3)`",
            ));
        }
    };
    if let Some((name, _)) = ["q0", "v0"].into_iter().zip(start).find(|(_, value)| value.is_some()) {
        return Err(PyValueError::new_err(format!(
            "{name}: the modes are open, and coordinates belong to numbers of modes: leave `{name}` out to start at rest, or choose \
             the modes before with `lissom.choose_modes`"
        )));
    }
    let held = u.map(|u| held_inputs(model, u)).transpose()?;
    choice::for_motion(model, t_span, (rtol, dt), held.as_deref(), limit).map(Some)
}

/// What looks at a run from outside, and the modes that were chosen for it.
struct Watched<'a, 'py> {
    progress: Option<&'a Bound<'py, PyAny>>,
    limit: TimeLimit,
    chosen: Option<&'a Chosen<'py>>,
}

/// Whether `t_eval` requests every accepted step.
fn is_every_step(t_eval: &Bound<'_, PyAny>) -> bool {
    t_eval.extract::<&str>().is_ok_and(|text| text == EVERY_STEP)
}

/// Inputs that are held during a run.
fn held_inputs(model: &Bound<'_, PyModel>, u: &Bound<'_, PyAny>) -> PyResult<Vec<f64>> {
    if u.is_callable() {
        return Err(PyTypeError::new_err(
            "u: got a function, expected inputs that are held; for u(t) write `control=lambda t, q, v: u(t)`",
        ));
    }
    let inputs = model.get().inspect(|model| model.facts().inputs());
    model.get().inputs_of(u).map_err(|error| or_rows(u, inputs, error, |rows| control_of(rows).to_owned()))
}

/// The `control` of inputs of several moments.
fn control_of(rows: Rows) -> &'static str {
    match rows {
        Rows::Array => "for a row per step write `control=lambda t, q, v: u[min(round(t / dt), len(u) - 1)]`",
        Rows::Mapping => {
            "for values per step write `control=lambda t, q, v: {name: x[min(round(t / dt), len(x) - 1)] for name, x in \
             u.items()}`"
        }
        Rows::Table => {
            "for a table write `control=lambda t, q, v: [numpy.interp(t, times, x) for x in \
             numpy.atleast_2d(numpy.transpose(values))]`"
        }
    }
}

/// How controllers are called.
const CONTROL: Form<'_> = Form { name: "control", arguments: "t, q, v", args: None };

/// How a `progress` is called.
const PROGRESS: Form<'_> = Form { name: "progress", arguments: "t", args: None };

/// The controller: a function of the user that sets inputs, or inputs that are held.
struct Controller {
    function: Option<Py<PyAny>>,
    /// Inputs at the start; empty for the defaults.
    held: Vec<f64>,
    step: f64,
    /// Names of the inputs.
    names: Vec<String>,
}

impl Controller {
    fn new(
        model: &Bound<'_, PyModel>,
        function: Option<&Bound<'_, PyAny>>,
        step: Option<f64>,
        dt: f64,
    ) -> PyResult<Option<Self>> {
        let Some(function) = function else {
            return match step {
                None => Ok(None),
                Some(step) => Err(PyValueError::new_err(format!(
                    "control_step: got {step:?}, the time between calls of `control`, without a `control`: leave it out"
                ))),
            };
        };
        if !function.is_callable() {
            return Err(PyTypeError::new_err(format!(
                "control: expected a callable (t, q, v) -> u, got {}; for a table of values write `control=lambda t, q, v: \
                 [numpy.interp(t, times, values)]`, for inputs that are held `u=...`",
                convert::describe(function)
            )));
        }
        if model.get().inspect(|model| model.facts().inputs() == 0) {
            return Err(PyValueError::new_err(
                "control: this model has no inputs: leave `control` out, or give loads or actuators a lissom.Input",
            ));
        }
        if let Some(error) = CONTROL.refusal(function) {
            return Err(error);
        }
        let names = model.get().input_names();
        let function = Some(function.clone().unbind());
        Ok(Some(Self { function, held: Vec::new(), step: step.unwrap_or(dt), names }))
    }

    /// Inputs that do not change, with the time for which they are held.
    fn constant(&self) -> Option<(f64, Vec<f64>)> {
        self.function.is_none().then(|| (self.step, self.held.clone()))
    }

    /// Sets the inputs that the controller returns for a state: all, or some by name.
    fn inputs(&self, py: Python<'_>, t: f64, [q, v]: [&[f64]; 2], inputs: &mut [f64]) -> PyResult<()> {
        let Some(function) = &self.function else { return Ok(()) };
        let returned = call(CONTROL, function.bind(py), (t, q.to_pyarray(py), v.to_pyarray(py)))?;
        if returned.is_none() {
            let error = PyTypeError::new_err("control: returned None; is there a `return` missing?");
            return Err(at_time(py, error, t));
        }
        let read = match mapping_of(&returned) {
            Some(mapping) => set_named(mapping, &self.names, inputs, "control"),
            None => convert::finite_vector_into(&returned, inputs, "control"),
        };
        read.map_err(|error| at_time(py, error, t))
    }
}

/// Adds the time to the message of an error about a returned value.
fn at_time(py: Python<'_>, error: PyErr, t: f64) -> PyErr {
    if error.is_instance_of::<PyValueError>(py) || error.is_instance_of::<PyTypeError>(py) {
        let message = format!("{} (at t = {})", error.value(py), Time(t));
        return PyErr::from_type(error.get_type(py), message);
    }
    error
}

/// Whether the Newmark family needs numerical damping of infinite frequencies: for closed loops, and for
/// contact, which starts abruptly.
pub(super) fn needs_damping(model: &dyn Native) -> bool {
    model.facts().constraints() > 0 || model.facts().has_contact
}

/// The argument `method`.
#[derive(Clone, Debug)]
pub(super) enum MethodOf<'a> {
    Name(&'a str),
    Described(Integration),
}

/// The name of a method, or one with its options.
pub(super) fn method<'a>(value: &'a Bound<'_, PyAny>) -> PyResult<MethodOf<'a>> {
    if let Ok(part) = value.cast::<PyPart>()
        && let Some(method) = part.get().read()
    {
        return Ok(MethodOf::Described(method));
    }
    if value.is_instance_of::<PyString>() {
        return convert::text(value, "method").map(MethodOf::Name);
    }
    Err(PyTypeError::new_err(format!(
        "method: expected the name of a method, or one of lissom.methods, got {}",
        convert::describe(value)
    )))
}

/// The options of the method as passed from Python.
pub(super) struct OptionArguments<'a, 'py> {
    pub(super) method: MethodOf<'a>,
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
    pub(super) returns_steps: bool,
}

impl OptionArguments<'_, '_> {
    /// The way to compute a motion of a model with `n` coordinates.
    pub(super) fn configuration(&self, n: usize) -> PyResult<Configuration> {
        let method = match &self.method {
            MethodOf::Name(name) => &self.named(name)?,
            MethodOf::Described(method) => {
                let beside = self.options_of_newmark().into_iter().chain(self.options_of_others());
                if let Some((name, _)) = beside.into_iter().find(|&(_, is_given)| is_given) {
                    return Err(PyValueError::new_err(format!(
                        "{name}: `method` is one of lissom.methods and has all of its options: leave `{name}` out"
                    )));
                }
                method
            }
        };
        if self.returns_steps && matches!(method, Integration::Auto(_)) {
            return Err(refused("t_eval='steps'", "auto"));
        }
        method.configuration(n, self.dt, self.needs_damping, self.returns_steps).or_raise()
    }

    /// The method of this name with the options that are given beside it.
    fn named(&self, name: &str) -> PyResult<Integration> {
        let is_newmark = !OTHERS.contains(&name);
        if !is_newmark {
            refuse(self.options_of_newmark(), name)?;
        }
        let max_steps = self.max_steps.map(|limit| convert::count(limit, "max_steps")).transpose()?;
        let Self { max_step, min_step, .. } = *self;
        if name == "auto" {
            refuse([("atol", self.atol.is_some()), ("min_step", min_step != 0.0)], name)?;
            let rtol = self.rtol.map_or(Ok(accuracy::DEFAULT_RTOL), PyAnyMethods::extract)?;
            return Ok(Auto { rtol, max_step, max_steps, space_error: true }.into());
        }
        let rtol = self.rtol.map_or(Ok(RTOL.into()), |rtol| tolerance(rtol, "rtol"))?;
        let atol = self.atol.map(|atol| tolerance(atol, "atol")).transpose()?;
        let atol_of_states = atol.clone().unwrap_or_else(|| ATOL.into());
        Ok(match name {
            "radau" => Radau { rtol, atol: atol_of_states, max_step, min_step, max_steps }.into(),
            "rk45" => Rk45 { rtol, atol: atol_of_states, max_step, min_step, max_steps }.into(),
            "dop853" => Dop853 { rtol, atol: atol_of_states, max_step, min_step, max_steps }.into(),
            "quasi_static" => {
                let given = [("max_step", max_step.is_some()), ("min_step", min_step != 0.0)];
                refuse(given, name)?;
                QuasiStatic { rtol, atol, max_steps }.into()
            }
            _ => {
                let Parameters { beta, gamma, alpha, rho_inf } = Parameters::by_name(name, &self.parameters)
                    .map_err(|error| name_methods(error, name, &OTHERS))
                    .or_raise()?;
                Newmark {
                    rho_inf,
                    alpha,
                    beta,
                    gamma,
                    rtol,
                    atol,
                    adaptive: self.adaptive.unwrap_or(false),
                    max_step,
                    min_step,
                    max_steps,
                    jac: self.jac.map_or(Ok(Jacobian::Analytic), |jac| word(jac, "jac"))?,
                    predictor: self.predictor.map_or(Ok(Predictor::Best), |name| word(name, "predictor"))?,
                    reuse_jacobian: self.reuse_jacobian.unwrap_or(true),
                    impacts: Impacts::default(),
                }
                .into()
            }
        })
    }

    /// Options of the Newmark family alone, and whether they are given.
    fn options_of_newmark(&self) -> [(&'static str, bool); 8] {
        let Parameters { beta, gamma, alpha, rho_inf } = self.parameters;
        [
            ("jac", self.jac.is_some()),
            ("beta", beta.is_some()),
            ("gamma", gamma.is_some()),
            ("alpha", alpha.is_some()),
            ("rho_inf", rho_inf.is_some()),
            ("adaptive", self.adaptive.is_some()),
            ("predictor", self.predictor.is_some()),
            ("reuse_jacobian", self.reuse_jacobian.is_some()),
        ]
    }

    fn options_of_others(&self) -> [(&'static str, bool); 5] {
        [
            ("rtol", self.rtol.is_some()),
            ("atol", self.atol.is_some()),
            ("max_step", self.max_step.is_some()),
            ("min_step", self.min_step != 0.0),
            ("max_steps", self.max_steps.is_some()),
        ]
    }
}

/// Returns an error if options are given that the method does not have, even with their default values.
fn refuse<const N: usize>(options: [(&'static str, bool); N], method: &str) -> PyResult<()> {
    let given = options.into_iter().find(|&(_, is_given)| is_given);
    given.map_or(Ok(()), |(name, _)| Err(refused(name, method)))
}

fn refused(option: &str, method: &str) -> PyErr {
    PyValueError::new_err(match method {
        "auto" => {
            format!("{option}: the method \"auto\" takes `rtol` and chooses the rest: leave `{option}` out")
        }
        _ => format!(
            "{option}: an option of the Newmark family, which the method {method:?} does not have: leave it out"
        ),
    })
}

/// Computes a motion without the interpreter, which is acquired only for progress calls and Ctrl-C.
fn run(
    model: &Bound<'_, PyModel>,
    t_span: (f64, f64),
    [q0, v0]: [&[f64]; 2],
    configuration: &Configuration,
    t_eval: Option<&[f64]>,
    mut controller: Option<Controller>,
    Watched { progress, mut limit, chosen }: Watched<'_, '_>,
) -> PyResult<PyMotionResult> {
    let py = model.py();
    let object = model.clone().unbind();
    let model = model.get().native();
    let (mut raised, mut raised_by_control) = (Raised::default(), Raised::default());
    let mut ticker = Ticker::new();
    let progress = progress.map(|progress| progress.clone().unbind());
    // What stopped the choice of modes stops the run, too, before it begins.
    let is_stopped = chosen.is_some_and(|chosen| chosen.raised.is_err());
    let constant = controller.as_ref().and_then(Controller::constant);
    let simulation = py.detach(|| {
        let mut monitor = |t: f64| {
            raised.none_yet()?;
            if is_stopped {
                return Err(Interrupted);
            }
            limit.check(t)?;
            if !ticker.tick() {
                return Ok(());
            }
            let stop = raised.catch(Python::attach(|py| {
                py.check_signals()?;
                match &progress {
                    Some(progress) => requests_stop(py, call(PROGRESS, progress.bind(py), (t,))),
                    None => Ok(false),
                }
            }))?;
            if stop { Err(Interrupted) } else { Ok(()) }
        };
        if let (Configuration::Accuracy(request), Some((step, values))) = (configuration, constant) {
            let inputs = accuracy::Inputs::Rows { step, values };
            return model.simulate_to_accuracy(t_span, [q0, v0], *request, t_eval, inputs, &mut monitor);
        }
        let step = controller.as_ref().map(|controller| controller.step);
        let mut inputs = |t: f64, q: &[f64], v: &[f64], inputs: &mut [f64]| {
            let Some(controller) = &mut controller else { return Ok(()) };
            if !controller.held.is_empty() {
                inputs.copy_from_slice(&std::mem::take(&mut controller.held));
            }
            raised_by_control.catch(Python::attach(|py| controller.inputs(py, t, [q, v], inputs)))
        };
        let control = step.map(|step| Control { step, inputs: &mut inputs });
        match configuration {
            Configuration::Accuracy(request) => {
                let inputs = control.map_or(accuracy::Inputs::Defaults, accuracy::Inputs::Controller);
                model.simulate_to_accuracy(t_span, [q0, v0], *request, t_eval, inputs, &mut monitor)
            }
            Configuration::Method(method) => {
                let simulation = model.simulate(t_span, q0, v0, method, t_eval, control, &mut monitor);
                simulation.map(|simulation| (simulation, None))
            }
        }
    });
    let (mut simulation, replacement) = simulation.map_err(with_python_names).or_raise()?;
    limit.judge(&mut simulation);
    chosen.iter().for_each(|chosen| of_modes(chosen, &mut simulation));
    let moved = match replacement.as_ref().and_then(|model| model.robot()) {
        Some(robot) => like(object.bind(py), robot)?.cast_into::<PyModel>()?.unbind(),
        None => object,
    };
    let stopped =
        chosen.map_or(Ok(()), |chosen| chosen.raised.as_ref().copied().map_err(|error| error.clone_ref(py)));
    let raised = stopped.and(raised_by_control.into_result()).and(raised.into_result());
    let slack = slack_in(py, moved.get(), &mut simulation);
    // The first exception raised by a function of time is the most informative one.
    let (raised, slack) = match (raised, slack) {
        (Ok(()), Ok(slack)) => (Ok(()), slack),
        (Err(error), slack) => (Err(error), slack.unwrap_or_default()),
        (Ok(()), Err(error)) => (Err(error), Vec::new()),
    };
    finish(py, simulation, &slack, Some(moved), raised)
}

/// Slack tendons of a motion, to which a doubt about friction and forces that were absurd are added; none of models that have neither
/// actuators nor friction.
fn slack_in(py: Python<'_>, model: &PyModel, simulation: &mut Simulation) -> PyResult<Vec<Slack>> {
    let is_looked_at = |model: &dyn Native| {
        model.robot().is_some_and(|robot| !robot.actuators.is_empty() || has_friction(robot))
    };
    let slack = model.inspect(is_looked_at).then(|| {
        let mut model = model.native();
        py.detach(|| model.robot_model().map(|robot| of_tendons_and_friction(robot, simulation)))
    });
    or_raised(slack.flatten().unwrap_or(Ok(Vec::new())))
}

/// Adds what the message of a motion says of the modes that were chosen for it.
fn of_modes(chosen: &Chosen<'_>, simulation: &mut Simulation) {
    if let Some(why) = &chosen.failure
        && simulation.status.is_success()
    {
        simulation.status = Status::AccuracyNotReached;
        simulation.message += &format!(" {why}");
    }
    let error = simulation.statistics.space_error.filter(|error| *error > chosen.rtol);
    if let Some(error) = error
        && simulation.status.is_success()
    {
        simulation.status = Status::AccuracyNotReached;
        simulation.message += &format!(
            " Of the modes that were chosen for {:.0e} the space error is {error:.0e}: divide segments, or choose modes for a smaller `rtol` \
             with `lissom.choose_modes`.",
            chosen.rtol
        );
    }
    simulation.message += &format!(" {}", chosen.words);
}

/// Slack tendons of a motion; adds a doubt about friction that crept, and forces that were absurd.
fn of_tendons_and_friction(
    robot: &mut RobotModel,
    simulation: &mut Simulation,
) -> Result<Vec<Slack>, Interrupted> {
    add_overloads(robot, simulation)?;
    if let Some(doubt) = creep(robot, simulation)? {
        simulation.add_doubt(&doubt);
    }
    slackness(robot, simulation)
}

/// The option with this name.
pub(super) fn word<T: Data>(word: &str, name: &str) -> PyResult<T> {
    let found = T::read(&Value::Text(word.to_owned()), &mut Reader::default());
    let Kind::Word(_, words) = T::KIND else { unreachable!("it is one of several words") };
    let (last, first) = words.split_last().expect("there is a word");
    let first: Vec<_> = first.iter().map(|word| format!("{word:?}")).collect();
    let wrong = || format!("{name}: got {word:?}, expected {} or {last:?}", first.join(", "));
    found.ok_or_else(|| PyValueError::new_err(wrong()))
}

/// Methods of this function beside the Newmark family.
const OTHERS: [&str; 5] = ["rk45", "dop853", "radau", "quasi_static", "auto"];

/// Adds other methods to a message that lists the Newmark family, and the one that may be meant.
pub(super) fn name_methods(mut error: InvalidInput, name: &str, others: &[&str]) -> InvalidInput {
    for problem in &mut error.problems {
        if problem.place == "method" {
            let meant = did_you_mean(name, METHODS.into_iter().chain(others.iter().copied()), "\"");
            let meant = meant.map(|meant| format!("; {meant}")).unwrap_or_default();
            problem.expected.extend(others.iter().map(|other| format!(", {other:?}")));
            problem.expected.push_str(&meant);
        }
    }
    error
}
