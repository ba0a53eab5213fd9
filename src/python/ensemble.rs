//! `lissom.simulate_many`.

use std::ffi::CString;
use std::sync::{Mutex, PoisonError};

use numpy::{IntoPyArray, PyArrayMethods};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};

use super::arguments;
use super::callback::{Raised, call, raised_by_function, wants_to_stop, with_result};
use super::convert::{self, Numbers};
use super::errors::AccuracyWarning;
use super::link::index_of;
use super::model::{Native, PyModel};
use super::motion::times;
use super::record::{self, ReadOnly, Reduced};
use super::robot::PyRobot;
use super::rows::{Vectors, each, of_row, threads};
use super::simulate::{Given, MethodOf, method, needs_damping, with_python_names};
use crate::description::signal::Cell;
use crate::error::{Interrupted, InvalidInput};
use crate::integrators::newmark::Parameters;
use crate::integrators::second_order::number_of_steps;
use crate::numerics::lie::{Quaternion, Vector};
use crate::robot::{Place, Pose};
use crate::simulation::ensemble;
use crate::simulation::ensemble::{Ensemble, Keep, Monitor, Outcome, Refusal, Run, Size};
use crate::simulation::methods::Way;
use crate::simulation::simulate::{Control, Simulation, slackness, times_of_run};

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
/// u : array_like, shape (inputs,), (count, inputs) or (count, steps, inputs), optional
///     Inputs of the models: constant during the run, for all rows or one row each; or for each row one set per control step,
///     starting at `t0`. By default the defaults of the inputs.
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
        model, t_end, *, t0=0.0, q0=None, v0=None, u=None, control_step=None, workers=None, progress=None, keep="states",
        places=None, memory_limit=MEMORY_LIMIT, method=MethodOf::Name("newmark"), dt=1e-2, jac=None, rtol=None, atol=None, t_eval=None, beta=None,
        gamma=None, alpha=None, rho_inf=None, adaptive=None, max_step=None, min_step=0.0, max_steps=None, predictor=None,
        reuse_jacobian=None
    ),
    text_signature = "(model, t_end, *, t0=0.0, q0=None, v0=None, u=None, control_step=None, workers=None, progress=False, \
                      keep='states', places=None, memory_limit=4294967296.0, method='newmark', dt=0.01, jac='analytic', rtol=1e-06, \
                      atol=1e-09, t_eval=None, beta=0.25, gamma=0.5, alpha=None, rho_inf=None, adaptive=False, \
                      max_step=None, min_step=0.0, max_steps=None, predictor='best', reuse_jacobian=True)"
)]
#[allow(clippy::too_many_arguments, reason = "keyword-only options of a Python function")]
pub(crate) fn simulate_many<'py>(
    model: &Bound<'py, PyAny>,
    #[pyo3(from_py_with = arguments::number::t_end)] t_end: f64,
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
) -> PyResult<PyEnsembleResult> {
    let py = model.py();
    let keep = keep_of(keep)?;
    let workers = threads(workers)?;
    let models = Models::of(model)?;
    let first = models.first();
    let (n, inputs) = (first.n(), first.default_inputs().len());
    let parameters = Parameters { beta, gamma, alpha, rho_inf };
    let way = Given {
        method,
        dt,
        jac,
        rtol,
        atol,
        parameters,
        adaptive,
        max_step,
        min_step,
        max_steps,
        predictor,
        reuse_jacobian,
        needs_damping: first.look(needs_damping),
        tells_steps: false,
    }
    .way(n)?;
    let mut count = Count(models.rows().map(|rows| (rows, "model")));
    let mut vectors = |value: Option<&Bound<'py, PyAny>>, name| {
        let Some(value) = value else { return Ok(None) };
        let (vectors, rows) = Vectors::of_any(value, n, name)?;
        count.agree(rows, name)?;
        Ok::<_, PyErr>(Some(vectors))
    };
    let (q0, v0) = (vectors(q0, "q0")?, vectors(v0, "v0")?);
    let t_span = (t0, t_end);
    let inputs_of_rows = Inputs::of(u, inputs, control_step, (t_span, dt), &way, &mut count)?;
    let count = count.0.map_or(1, |(rows, _)| rows);
    let mut rows = Rows {
        models,
        places: Vec::new(),
        t_span,
        q0,
        v0,
        zeros: vec![0.0; n],
        inputs: inputs_of_rows,
        way,
        t_eval: times(t_eval)?,
        keep,
        of_function: Mutex::new(None),
    };
    let times = rows.check(py, count)?;
    if times.differ {
        rows.t_eval = Some(times.of_rows.clone());
    }
    let times = times.of_rows;
    rows.places = places_of(py, &rows.models, count, places, keep)?;
    let size = Size { count, times: times.len(), n, places: rows.places.first().map_or(0, Vec::len) };
    check_memory(size, keep, inputs, workers, memory_limit)?;
    let progress = Progress::new(py, progress, count)?;
    let (ensemble, refused, raised) = run(py, &rows, size, workers, &progress);
    progress.close(py)?;
    if let Err((row, error)) = refused {
        return Err(of_row(py, row, &PyErr::from(with_python_names(error))));
    }
    finish(py, ensemble, times, workers, keep, raised)
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

/// Models of the rows.
enum Models {
    One(Py<PyModel>),
    Each(Vec<Py<PyModel>>),
}

impl Models {
    fn of(model: &Bound<'_, PyAny>) -> PyResult<Self> {
        if let Ok(model) = model.cast::<PyModel>() {
            return Ok(Self::One(model.clone().unbind()));
        }
        let models = each(model)?;
        if models.is_empty() {
            return Err(PyValueError::new_err(
                "model: got 0 models, expected at least one (one model and starts of shape (0, n) are no rows)",
            ));
        }
        Ok(Self::Each(models))
    }

    fn rows(&self) -> Option<usize> {
        match self {
            Self::One(_) => None,
            Self::Each(models) => Some(models.len()),
        }
    }

    fn first(&self) -> &PyModel {
        self.of_row(0).get()
    }

    fn of_row(&self, row: usize) -> &Py<PyModel> {
        match self {
            Self::One(model) => model,
            Self::Each(models) => &models[row],
        }
    }
}

/// Number of rows, and the argument that determines it.
struct Count(Option<(usize, &'static str)>);

impl Count {
    fn agree(&mut self, rows: Option<usize>, name: &'static str) -> PyResult<()> {
        match (rows, self.0) {
            (Some(rows), Some((known, by))) if rows != known => {
                Err(PyValueError::new_err(format!("{name}: got {rows} rows, expected {known} as {by} has")))
            }
            (Some(rows), None) => {
                self.0 = Some((rows, name));
                Ok(())
            }
            _ => Ok(()),
        }
    }
}

/// Inputs of the rows.
enum Inputs {
    Defaults,
    Held { values: Vectors, step: f64 },
    Steps { values: Vec<f64>, of_row: usize, width: usize, step: f64 },
}

impl Inputs {
    fn of(
        given: Option<&Bound<'_, PyAny>>,
        width: usize,
        control_step: Option<f64>,
        ((t0, t_end), dt): ((f64, f64), f64),
        way: &Way,
        count: &mut Count,
    ) -> PyResult<Self> {
        let no_steps = |control_step: Option<f64>| match control_step {
            None => Ok(()),
            Some(step) => Err(PyValueError::new_err(format!(
                "control_step: got {step:?}, expected nothing: it is how long each of inputs of shape (count, steps, inputs) is held"
            ))),
        };
        let Some(given) = given else { return no_steps(control_step).map(|()| Self::Defaults) };
        if width == 0 {
            return Err(PyValueError::new_err(
                "u: got inputs, expected nothing: this model has no inputs (give loads or actuators a lissom.Input)",
            ));
        }
        if matches!(way, Way::Accuracy(_)) {
            return Err(PyValueError::new_err(
                "u: got inputs, expected nothing: method \"auto\" takes their defaults; take another one",
            ));
        }
        let of_three = convert::numbers(given, "u", "an array of real numbers, of one to three dimensions")?;
        let Numbers { values, shape } = of_three;
        let [rows, steps, inputs] = shape[..] else {
            no_steps(control_step)?;
            let (values, rows) = Vectors::of_any(given, width, "u")?;
            count.agree(rows, "u")?;
            let step = if t_end > t0 { t_end - t0 } else { dt };
            return Ok(Self::Held { values, step });
        };
        let step = control_step.unwrap_or(dt);
        let is_step = step.is_finite() && step > 0.0;
        let wanted = if is_step { number_of_steps(t_end - t0, step).max(1) } else { steps };
        if inputs != width || steps != wanted {
            let message =
                format!("u: expected shape (count, {wanted}, {width}), got ({rows}, {steps}, {inputs})");
            return Err(PyValueError::new_err(message));
        }
        if let Some(index) = values.iter().position(|x| !x.is_finite()) {
            let (row, rest) = (index / (steps * width), index % (steps * width));
            let message = format!(
                "u[{row}, {}, {}]: got {}, expected a finite number",
                rest / width,
                rest % width,
                values[index]
            );
            return Err(PyValueError::new_err(message));
        }
        count.agree(Some(rows), "u")?;
        Ok(Self::Steps { values, of_row: steps * width, width, step })
    }

    /// Duration of a control step, unless the inputs have their defaults.
    fn step(&self) -> Option<f64> {
        match self {
            Self::Defaults => None,
            Self::Held { step, .. } | Self::Steps { step, .. } => Some(*step),
        }
    }

    /// Inputs of a row in this control step.
    fn at(&self, row: usize, step: usize) -> &[f64] {
        match self {
            Self::Defaults => &[],
            Self::Held { values, .. } => values.of(row),
            Self::Steps { values, of_row, width, .. } => {
                let values = &values[row * of_row..(row + 1) * of_row];
                &values[(step * width).min(of_row - width)..][..*width]
            }
        }
    }
}

/// A place on a link, by the index of the link: at an arc length, or the tip.
type OnLink = (usize, Option<f64>);

/// Arguments of all runs.
struct Rows {
    models: Models,
    /// Places of the single model, or of each model.
    places: Vec<Vec<OnLink>>,
    t_span: (f64, f64),
    q0: Option<Vectors>,
    v0: Option<Vectors>,
    zeros: Vec<f64>,
    inputs: Inputs,
    way: Way,
    t_eval: Option<Vec<f64>>,
    keep: Keep,
    /// First exception of a function of time.
    of_function: Mutex<Option<PyErr>>,
}

/// Times of all rows.
struct Times {
    of_rows: Vec<f64>,
    /// Whether steps of some rows end at other times, too.
    differ: bool,
}

impl Rows {
    fn start(&self, row: usize) -> [&[f64]; 2] {
        [&self.q0, &self.v0].map(|given| given.as_ref().map_or(self.zeros.as_slice(), |given| given.of(row)))
    }

    /// Rejects invalid arguments of any row; returns the times of all rows.
    fn check(&self, py: Python<'_>, count: usize) -> PyResult<Times> {
        let mut last: Option<(*mut pyo3::ffi::PyObject, Box<dyn Native>)> = None;
        let (mut times, mut differ) = (None, false);
        for row in 0..count.max(1) {
            if row % ROWS_BETWEEN_SIGNALS == 0 {
                py.check_signals()?;
            }
            let model = self.models.of_row(row);
            // Without rows there are no initial states, but the other arguments are checked.
            let [q0, v0] = if count == 0 { [self.zeros.as_slice(); 2] } else { self.start(row) };
            let is_new = last.as_ref().is_none_or(|(before, _)| *before != model.as_ptr());
            let checked = if is_new {
                let mut native = model.get().native();
                let checked = self.check_all(&mut *native, [q0, v0], &mut times).map(|other| differ |= other);
                last = Some((model.as_ptr(), native));
                checked
            } else {
                last.as_mut().map_or(Ok(()), |(_, native)| native.check_shape(q0, "q0"))
            };
            checked.map_err(|error| {
                let error = PyErr::from(with_python_names(error));
                // Do not mention a row if the problem concerns all rows.
                if count > 1 && (row > 0 || error.value(py).to_string().starts_with("q0")) {
                    of_row(py, row, &error)
                } else {
                    error
                }
            })?;
        }
        match times {
            Some(of_rows) => Ok(Times { of_rows, differ: differ && self.keep != Keep::Final }),
            None if self.keep == Keep::Final => Ok(Times { of_rows: vec![self.t_span.1], differ: false }),
            None => Err(PyTypeError::new_err(
                "t_eval: missing: adaptive steps end at times of their own in every row; give the times that are wanted, or keep=\"final\"",
            )),
        }
    }

    /// Whether its steps end at other times than those of the models before; then `times` are without the corners of tables.
    fn check_all(
        &self,
        model: &mut dyn Native,
        [q0, v0]: [&[f64]; 2],
        times: &mut Option<Vec<f64>>,
    ) -> Result<bool, InvalidInput> {
        let (t_span, t_eval) = (self.t_span, self.t_eval.as_deref());
        match &self.way {
            Way::Accuracy(request) => {
                *times = Some(model.check_to_accuracy(t_span, q0, v0, *request, t_eval)?);
            }
            Way::Method(method) => {
                let step = self.inputs.step();
                model.check(t_span, q0, v0, method, t_eval, step)?;
                let of_run = |corner: &dyn Fn(Cell) -> Option<f64>| {
                    times_of_run(model.facts().n, t_span, method, t_eval, step, corner)
                };
                let own = of_run(&|cell| model.corner(cell))?;
                let differs = times.is_some() && *times != own;
                *times = if differs { of_run(&|_| None)? } else { own };
                return Ok(differs);
            }
        }
        Ok(false)
    }

    /// Computes the run of a row, in any thread.
    fn run(&self, row: usize, monitor: &mut Monitor<'_>) -> Result<Run, Refusal> {
        let model = self.models.of_row(row).get().native();
        let [q0, v0] = self.start(row);
        let t_eval = self.t_eval.as_deref();
        let simulated = match &self.way {
            Way::Accuracy(request) => {
                model.boxed_clone().simulate_to_accuracy(self.t_span, q0, v0, *request, t_eval, monitor)
            }
            Way::Method(method) => {
                let mut steps = 0;
                let mut set = |_: f64, _: &[f64], _: &[f64], inputs: &mut [f64]| {
                    inputs.copy_from_slice(self.inputs.at(row, steps));
                    steps += 1;
                    Ok(())
                };
                let control = self.inputs.step().map(|step| Control { step, inputs: &mut set });
                let simulated =
                    model.boxed_clone().simulate(self.t_span, q0, v0, method, t_eval, control, monitor);
                simulated.map(|simulation| (simulation, None))
            }
        };
        let (simulation, replacement) = simulated.map_err(Refusal::Input)?;
        let model = &mut *replacement.unwrap_or(model);
        let mut run = Run { simulation, slack: Vec::new(), poses: Vec::new() };
        let observed = raised_by_function().and_then(|()| {
            // Its exception is handled below.
            let _ = self.observe(model, row, &mut run);
            raised_by_function()
        });
        match observed {
            Ok(()) => Ok(run),
            Err(error) => {
                self.of_function.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(error);
                Err(Refusal::Ended(Box::new(run)))
            }
        }
    }

    /// Computes additional data of a motion.
    fn observe(&self, model: &mut dyn Native, row: usize, run: &mut Run) -> Result<(), Interrupted> {
        let Run { simulation, slack, poses } = run;
        let from = if self.keep == Keep::Final { simulation.t.len().saturating_sub(1) } else { 0 };
        let places = self.places.get(row).or(self.places.first()).map_or(&[][..], Vec::as_slice);
        if let Some(robot) = model.robot_model() {
            *slack = slackness(robot, simulation)?;
            let places: Vec<Place> = places.iter().map(|&(link, x)| robot.place_on(link, x)).collect();
            if !places.is_empty() {
                let found = ensemble::poses(robot, simulation, &places, from)?;
                *poses = found.iter().flat_map(convert::homogeneous).collect();
            }
        } else if !places.is_empty() {
            *poses = tips(model, simulation, from);
        }
        Ok(())
    }
}

/// The tip of a model without links, as poses without rotation.
fn tips(model: &mut dyn Native, simulation: &Simulation, from: usize) -> Vec<f64> {
    let tips = ensemble::tips(model, simulation, from);
    let poses = tips.into_iter().map(|tip| Pose {
        rotation: Quaternion::from_array([1.0, 0.0, 0.0, 0.0]).rotation(),
        position: Vector::new(tip[0], tip[1], tip[2]),
    });
    poses.flat_map(|pose| convert::homogeneous(&pose)).collect()
}

/// Number of rows between two checks for signals.
const ROWS_BETWEEN_SIGNALS: usize = 256;

/// The recorded places, of the single model or of each; None without places.
fn places_of(
    py: Python<'_>,
    models: &Models,
    count: usize,
    given: Option<&Bound<'_, PyAny>>,
    keep: Keep,
) -> PyResult<Vec<Vec<OnLink>>> {
    if given.is_none() && keep != Keep::Summary {
        return Ok(Vec::new());
    }
    let rows = if models.rows().is_some() { count } else { 1 };
    let mut all: Vec<Vec<OnLink>> = Vec::with_capacity(rows);
    for row in 0..rows {
        let of_model = places_of_model(models.of_row(row).bind(py), given);
        all.push(of_model.map_err(|error| if rows > 1 { of_row(py, row, &error) } else { error })?);
    }
    Ok(all)
}

fn places_of_model(model: &Bound<'_, PyModel>, given: Option<&Bound<'_, PyAny>>) -> PyResult<Vec<OnLink>> {
    let robot = model.cast::<PyRobot>().ok();
    let links = robot.map_or(1, |robot| robot.get().description().links.len());
    let Some(given) = given else { return Ok(vec![(links - 1, None)]) };
    let Some(robot) = robot else {
        return Err(PyTypeError::new_err("places: got some, expected None: this model has no links"));
    };
    let robot = robot.get();
    let expected = "arc lengths, names of links, or pairs (link, arc length)";
    let wrong = |place: &str, found: &Bound<'_, PyAny>| {
        PyTypeError::new_err(format!("{place}: expected {expected}, got {}", convert::describe(found)))
    };
    if given.is_instance_of::<pyo3::types::PyString>() {
        return Err(wrong("places", given));
    }
    let mut places = Vec::new();
    for (i, item) in given.try_iter().map_err(|_| wrong("places", given))?.enumerate() {
        let (item, place) = (item?, format!("places[{i}]"));
        let (name, x): (Option<String>, Option<f64>) = if let Ok(name) = item.extract::<String>() {
            (Some(name), None)
        } else if let Ok((name, x)) = item.extract::<(String, Bound<'_, PyAny>)>() {
            (Some(name), Some(convert::number(&x, &place).map_err(|_| wrong(&place, &item))?))
        } else {
            (None, Some(convert::number(&item, &place).map_err(|_| wrong(&place, &item))?))
        };
        let link = index_of(robot.description(), name.as_deref(), &place)?;
        robot
            .check_place(link, x)
            .map_err(|error| PyValueError::new_err(format!("{place}: {}", error.value(item.py()))))?;
        places.push((link, x));
    }
    Ok(places)
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
            "keep: got {found}, expected what takes at most {:.3} GB; this takes {:.3} GB: {instead}, or raise `memory_limit`",
            limit / 1e9,
            bytes / 1e9
        )));
    }
    Ok(crate::numerics::memory::check(numbers, "keep", found, instead)?)
}

/// Receiver of the number of finished runs.
enum Progress {
    Nobody,
    Callable(Py<PyAny>),
    Bar(Py<PyAny>),
}

impl Progress {
    fn new(py: Python<'_>, given: Option<&Bound<'_, PyAny>>, count: usize) -> PyResult<Self> {
        let Some(given) = given else { return Ok(Self::Nobody) };
        if let Ok(wanted) = given.extract::<bool>() {
            if !wanted {
                return Ok(Self::Nobody);
            }
            let arguments = PyDict::new(py);
            arguments.set_item("total", count)?;
            arguments.set_item("unit", " runs")?;
            let bar = py.import("tqdm")?.getattr("tqdm")?.call((), Some(&arguments))?;
            return Ok(Self::Bar(bar.unbind()));
        }
        if !given.is_callable() {
            let found = convert::describe(given);
            return Err(PyTypeError::new_err(format!(
                "progress: expected a bool or a callable, got {found}"
            )));
        }
        Ok(Self::Callable(given.clone().unbind()))
    }

    /// Reports progress; returns whether to stop.
    fn tell(&self, py: Python<'_>, done: usize) -> PyResult<bool> {
        match self {
            Self::Nobody => Ok(false),
            Self::Callable(function) => wants_to_stop(py, call(function.bind(py), (done,))),
            Self::Bar(bar) => {
                let bar = bar.bind(py);
                let shown: usize = bar.getattr("n")?.extract()?;
                bar.call_method1("update", (done.saturating_sub(shown),))?;
                Ok(false)
            }
        }
    }

    fn close(&self, py: Python<'_>) -> PyResult<()> {
        if let Self::Bar(bar) = self {
            bar.call_method0(py, "close")?;
        }
        Ok(())
    }
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
                progress.tell(py, done)
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
    let raised = raised.and_then(|()| progress.tell(py, done).map(|_| ()));
    (ensemble, refused, raised)
}

/// The result, with one warning about doubtful runs; or the exception that ended the runs, with the result as
/// an attribute.
fn finish(
    py: Python<'_>,
    ensemble: Ensemble,
    times: Vec<f64>,
    workers: usize,
    keep: Keep,
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
    match raised.and_then(|()| warned()) {
        Ok(()) => PyEnsembleResult::new(py, ensemble, times, workers, keep),
        Err(error) => {
            Err(with_result(py, error, || PyEnsembleResult::new(py, ensemble, times, workers, keep)))
        }
    }
}

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
const INTERRUPTED: &str = "interrupted";

/// Status of a row that was not started.
const NOT_BEGUN: &str = "not_begun";

impl PyEnsembleResult {
    fn new(
        py: Python<'_>,
        ensemble: Ensemble,
        times: Vec<f64>,
        workers: usize,
        keep: Keep,
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
        let numpy = py.import("numpy")?;
        let of_outcomes = |of: &dyn Fn(&Outcome) -> f64, unknown: f64| -> PyResult<ReadOnly> {
            let values = outcomes.iter().map(|outcome| outcome.as_ref().map_or(unknown, of));
            array(values.collect(), &[count])
        };
        let names: Vec<&str> = outcomes
            .iter()
            .map(|outcome| outcome.as_ref().map_or(NOT_BEGUN, |it| it.status.name()))
            .collect();
        let status = match names[..] {
            [] => numpy.call_method1("empty", (0, "U1"))?,
            _ => numpy.call_method1("array", (&names,))?,
        };
        let success: Vec<bool> = outcomes
            .iter()
            .map(|outcome| outcome.as_ref().is_some_and(|outcome| outcome.status.is_success()))
            .collect();
        let texts = outcomes
            .iter()
            .map(|outcome| outcome.as_ref().map_or("The run was not begun.", |it| it.message.as_str()));
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
            success: ReadOnly::new(success.into_pyarray(py).into_any())?,
            status: ReadOnly::new(status)?,
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
