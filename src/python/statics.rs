//! `lissom.statics`.

use numpy::{IntoPyArray, PyArray1};
use pyo3::class::{PyTraverseError, PyVisit};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};

use super::arguments;
use super::callback::with_result;
use super::choice::{self, Chosen};
use super::convert;
use super::equilibrium_path::PyEquilibriumPath;
use super::model::{PyModel, any_model_of, check_time};
use super::overlap::PyOverlap;
use super::record::{self, ReadOnly, Reduced};
use super::remarks::{Message, Subject};
use super::search::{base, count, inputs_of, inputs_or_default, native_with, run};
use super::space_error::{PySpaceError, warned};
use crate::analysis::statics as core;
use crate::analysis::statics::{
    Counters, Effort, Equilibrium, Monitor, Options, SpaceError, Stability, Start, Tendons,
};
use crate::error::{Interrupted, Unfinished};
use crate::model::Facts;
use crate::python::words::required;
use crate::simulation::accuracy::Search;

/// An equilibrium, or the last state of a failed search.
///
/// Attributes
/// ----------
/// q : ndarray, shape (n,)
///     Coordinates; after a failure those of the last good state.
/// success : bool
///     True if `q` is an equilibrium under the full load.
/// status : str
///     'converged', 'released' (the load path ended before the full load, and the model was released there and came to rest),
///     'step_too_small', 'too_many_steps', 'iteration_limit', 'stalled', 'unheld' (nothing holds the model in some direction),
///     'non_finite', 'unresolved' (the rod turns by more than half a turn between neighbouring quadrature nodes), 'inverted'
///     (the stretch is not positive somewhere), 'collapsed' (a tendon has pulled two points together, where its force has no
///     direction), 'deep_penetration' (surfaces overlap by more than a radius), 'loop_open' (loops or tendons of given length are
///     not closed), 'accuracy_not_reached' (an equilibrium, but no numbers of modes gave it the `rtol`), 'interrupted' (in the `result` of a KeyboardInterrupt), or for method 'newton' a status of RootResult.
/// message : str
///     The status in words, what to change, and notes on the equilibrium.
/// load_factor : float
///     Fraction of the loads at `q`: 1 unless the search failed.
/// residual_norm : float
///     Joules: generalised forces times typical sizes of the coordinates, before the last step.
/// step_norm : float
///     Norm of the last Newton step, divided by the typical sizes: an estimate of the error of `q`. NaN if no step was taken.
/// is_stable : bool or None
///     Whether small disturbances stay small; None after a failure, with `stability=False`, or if it is unknown.
/// stability : str or None
///     'stable', 'neutral' (no stiffness in some direction), 'divergence' or 'flutter'. It includes damping, drag and Coriolis
///     forces and agrees with `modes`.
/// undamped_stability : str or None
///     The same without velocity-dependent forces. Under follower loads, damping can stabilise or destabilise.
/// lowest_eigenvalue : float
///     Smallest eigenvalue of the symmetric part of the tangent stiffness relative to the stiffness of material and springs: one
///     without load, zero at critical points.
/// slack : list of str
///     Slack tendons: those of a given length whose path is shorter, and those with a negative tension command. The message
///     names them, and also tendons whose friction is left out because no sliding direction is given.
/// path : EquilibriumPath or None
///     The load path, if one was followed.
/// deepest : Overlap or None
///     The overlap of surfaces that is deepest for their thickness; None if nothing touches.
/// u : ndarray, shape (m,), or None
///     The inputs of the search; None in results saved by versions that did not keep them.
/// t : float or None
///     The time of the search, seconds; None as for `u`.
/// space_error : SpaceError or None
///     Estimated error due to the finite number of modes; None after a failure other than 'accuracy_not_reached', with `space_error=False`, or without rods,
///     and where it is not known: where forces change so much with the shape that neither their balance nor steps of a model with more modes
///     determine it, as of slack cables without bending stiffness.
/// model : Model or None
///     The robot with the modes that were chosen for `rtol`, to which `q` belongs; None if nothing was chosen.
/// nit, nfev, njev : int
///     Numbers of Newton iterations, force evaluations and tangent evaluations; those of choosing modes do not count.
#[pyclass(name = "StaticsResult", module = "lissom", frozen, get_all)]
#[derive(FromPyObject)]
pub(crate) struct PyStaticsResult {
    q: ReadOnly<PyArray1<f64>>,
    success: bool,
    status: String,
    message: Message,
    load_factor: f64,
    residual_norm: f64,
    step_norm: f64,
    is_stable: Option<bool>,
    stability: Option<String>,
    undamped_stability: Option<String>,
    lowest_eigenvalue: f64,
    slack: Vec<String>,
    path: Option<Py<PyEquilibriumPath>>,
    deepest: Option<Py<PyOverlap>>,
    u: Option<ReadOnly<PyArray1<f64>>>,
    t: Option<f64>,
    space_error: Option<Py<PySpaceError>>,
    model: Option<Py<PyModel>>,
    nit: usize,
    nfev: usize,
    njev: usize,
}

#[pymethods]
impl PyStaticsResult {
    fn __traverse__(&self, visit: PyVisit<'_>) -> Result<(), PyTraverseError> {
        visit.call(&self.path)?;
        visit.call(&self.model)?;
        self.message.traverse(&visit)
    }

    fn __repr__(&self) -> String {
        format!(
            "<StaticsResult: {}, load factor {}, {}, {} iterations>",
            self.status,
            self.load_factor,
            self.stability.as_deref().unwrap_or("stability unknown"),
            self.nit
        )
    }

    /// For copies and pickles.
    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<Reduced<'py>> {
        record::reduce(slf)
    }

    #[staticmethod]
    fn _restore(state: &Bound<'_, PyAny>) -> PyResult<Self> {
        record::add_missing(state, &["deepest", "space_error", "u", "t", "model"])?;
        state.extract()
    }
}

/// Find an equilibrium of a model at rest.
///
/// Without `q0`, the loads including gravity are increased from zero, in as few steps as Newton's method needs to stay on the
/// path of equilibria from the unloaded shape. The path is followed around limit points, and bifurcations on it are reported.
/// With `q0`, the model is released from that shape, and its energy decreases until it reaches a stable equilibrium.
///
/// Parameters
/// ----------
/// model : Model
///     A `Rod`, `Robot` or `SpringPendulum`.
/// q0 : array_like, shape (n,), optional
///     Initial shape for a search under the full load.
/// load_steps : 'auto', int or array_like
///     Load fractions at which the load path must stop: only the full load ('auto'), this many equal increments, or these
///     fractions (increasing, the last one 1). Further steps are added as needed.
/// method : {'auto', 'load_path', 'descent', 'newton'}
///     'load_path' increases the loads and 'descent' releases the model, as described above. 'auto' chooses 'descent' if `q0` is
///     given or the model has contacts (then from zero), because the path of equilibria has a kink at every new contact.
///     'newton' finds a nearby equilibrium, stable or not, by Newton's method in a trust region, from `q0` or zero.
/// t : float
///     Time at which time-dependent loads are evaluated, seconds.
/// tol : float
///     The search ends when a Newton step is below this number, measured in radians of the whole rod, stretch and shear.
/// max_iter : int
///     Maximum number of Newton iterations of 'descent' and 'newton'; the default is ten times as large with contact.
/// max_steps : int
///     Maximum number of steps of 'load_path'.
/// u : array_like, shape (m,), or dict, optional
///     Inputs, or some of them by name; by default `u0` of the model.
/// stability : bool
///     Whether to judge the stability of the equilibrium. Without, `stability` is None; so it is where modes are chosen, since strains that
///     the loads do not excite get none.
/// space_error : bool, optional
///     Whether to estimate the error due to the finite number of modes. By default by the balance of forces, which costs a few
///     evaluations of them, and with more modes only where that leaves doubts; True: always with more modes; False: not at all.
/// rtol : float, optional
///     Largest error due to the numbers of modes, relative to the length: they are chosen for it as by `choose_modes`, for the segments
///     with ``modes="auto"`` or, if there are none, for all. The result has the robot with these modes as its `model`. A robot with
///     ``modes="auto"`` has 1e-4 by default; other robots keep their modes unless it is given. Costs five to fifteen searches.
///
/// Returns
/// -------
/// StaticsResult
///     `q`, `success`, `status`, `message`, `is_stable`, `path` and more. A numerical failure does not raise.
///
/// Raises
/// ------
/// ValueError, TypeError
///     If an argument is invalid.
/// KeyboardInterrupt
///     On Ctrl-C. Its attribute `result` is the StaticsResult until then: the path, and the last
///     shape of the search, which need not be an equilibrium; exceptions of functions of time have it, too.
///
/// Warns
/// -----
/// AccuracyWarning
///     If the finite number of modes leaves an error of more than a hundredth of the length.
///
/// Examples
/// --------
/// >>> import lissom
/// >>> wire = lissom.Segment(1.0, 1e-3, 210e9, 80e9, 7800, modes={"bend_y": 3})
/// >>> sagging = lissom.statics(lissom.Rod([wire]))
/// >>> sagging.success, sagging.stability, sagging.q.round(6)
/// (True, 'stable', array([ 0.238212, -0.358564,  0.121461]))
#[pyfunction]
#[pyo3(signature = (model=None, q0=None, *more, load_steps=None, method="auto", t=0.0, tol=None, max_iter=None, max_steps=None, u=None, stability=true, space_error=None, rtol=None, **others),
       text_signature = "(model, q0=None, *, load_steps='auto', method='auto', t=0.0, tol=1e-10, max_iter=500, max_steps=500, u=None, stability=True, space_error=None, rtol=None)")]
#[allow(clippy::too_many_arguments, reason = "keyword-only options of a Python function")]
pub(crate) fn statics<'py>(
    #[pyo3(from_py_with = arguments::given)] model: Option<&Bound<'py, PyAny>>,
    q0: Option<&Bound<'py, PyAny>>,
    more: &Bound<'_, PyTuple>,
    load_steps: Option<&Bound<'py, PyAny>>,
    #[pyo3(from_py_with = arguments::text::method)] method: &str,
    #[pyo3(from_py_with = arguments::number::t)] t: f64,
    #[pyo3(from_py_with = arguments::optional_number::tol)] tol: Option<f64>,
    #[pyo3(from_py_with = arguments::optional_whole::max_iter)] max_iter: Option<i64>,
    #[pyo3(from_py_with = arguments::optional_whole::max_steps)] max_steps: Option<i64>,
    u: Option<&Bound<'py, PyAny>>,
    #[pyo3(from_py_with = arguments::flag::stability)] stability: bool,
    #[pyo3(from_py_with = arguments::optional_flag::space_error)] space_error: Option<bool>,
    #[pyo3(from_py_with = arguments::optional_number::rtol)] rtol: Option<f64>,
    others: Option<&Bound<'_, PyDict>>,
) -> PyResult<PyStaticsResult> {
    let model = required!("statics", others; more, model);
    let given = any_model_of(model, "model")?;
    let chooses = rtol.is_some() || given.get().is_open();
    if chooses && space_error == Some(false) {
        return Err(PyValueError::new_err(
            "space_error: numbers of modes are chosen by this error: leave `space_error=False` out, or choose them before with \
             `lissom.choose_modes`",
        ));
    }
    if given.get().is_open() && q0.is_some() {
        return Err(PyValueError::new_err(
            "q0: the modes are open, and coordinates belong to numbers of modes: leave `q0` out, or choose the modes before with \
             `lissom.choose_modes`",
        ));
    }
    let u = u.map(|u| inputs_of(model, u)).transpose()?;
    let asked = Asked { q0, load_steps, method, tol, max_iter, max_steps, stability };
    let options = given.get().inspect(|model| asked.options(model.facts()))?;
    let effort = match space_error {
        _ if chooses => Some(Effort::Full),
        Some(false) => None,
        Some(true) => Some(Effort::Full),
        None => Some(Effort::Little),
    };
    if !chooses {
        return search(model, options, (t, u), effort, None);
    }
    let wanted = Search { t, u, options };
    given.get().inspect(|model| check_time(t, model.facts().time_span))?;
    let Some(chosen) = choice::for_equilibrium(given, rtol, &wanted)? else {
        return search(model, wanted.options, (t, wanted.u), effort, None);
    };
    let robots = [given, &chosen.model].map(|model| model.get().inspect(|model| model.robot().cloned()));
    let options = match robots {
        [Some(given), Some(robot)] => wanted.options_for(&given, &robot),
        _ => wanted.options.clone(),
    };
    // Of what no load excites there are no modes, in which the equilibrium may be unstable.
    let options = Options { stability: false, ..options };
    search(chosen.model.clone().as_any(), options, (t, wanted.u.clone()), effort, Some(chosen))
}

/// The arguments that say how an equilibrium is searched.
struct Asked<'a, 'py> {
    q0: Option<&'a Bound<'py, PyAny>>,
    load_steps: Option<&'a Bound<'py, PyAny>>,
    method: &'a str,
    tol: Option<f64>,
    max_iter: Option<i64>,
    max_steps: Option<i64>,
    stability: bool,
}

impl Asked<'_, '_> {
    fn options(&self, facts: &Facts) -> PyResult<Options> {
        let q0 = self.q0.map(|q0| convert::finite_vector_of(q0, facts.n, "q0")).transpose()?;
        let defaults = Options::of(facts);
        Ok(Options {
            start: start(self.method, q0, self.load_steps, facts.n, defaults.start)?,
            tol: self.tol.unwrap_or(defaults.tol),
            max_iter: count(self.max_iter, "max_iter", defaults.max_iter)?,
            max_steps: count(self.max_steps, "max_steps", defaults.max_steps)?,
            stability: self.stability,
        })
    }
}

/// Searches an equilibrium of a model, whose modes may have been chosen for it.
fn search(
    model: &Bound<'_, PyAny>,
    options: Options,
    (t, u): (f64, Option<Vec<f64>>),
    effort: Option<Effort>,
    chosen: Option<Chosen<'_>>,
) -> PyResult<PyStaticsResult> {
    let py = model.py();
    let of_python = base(model)?;
    let held = inputs_or_default(model, u.as_deref())?;
    let mut model = native_with(model, t, u.as_deref())?;
    let n = model.facts().n;
    // What stopped the trials stops the search, too, before it begins.
    let is_stopped = chosen.as_ref().is_some_and(|chosen| chosen.raised.is_err());
    let search = move |monitor: Monitor<'_>| {
        let mut monitor = || if is_stopped { Err(Interrupted) } else { monitor() };
        let mut found = match core::equilibrium(&mut *model, &options, &mut monitor)? {
            Ok(found) => found,
            Err(unfinished) => return Ok(Err(unfinished.map(|found| (found, Tendons::default(), None)))),
        };
        let of_robot = model.robot_model().map(|robot| Tendons::of(robot, &found.q, t, u.as_deref()));
        if let (Some(Ok(Tendons { overloads, .. })), Some(ended)) =
            (&of_robot, found.status.without_cure(found.load_factor))
            && !overloads.is_empty()
        {
            found.message = ended;
        }
        let judged = of_robot.transpose().and_then(|tendons| {
            let error =
                effort.map(|effort| model.space_error(&found, (t, u.as_deref()), effort)).transpose()?;
            Ok((tendons.unwrap_or_default(), error.flatten()))
        });
        Ok(match judged {
            Ok((tendons, error)) => Ok((found, tendons, error)),
            Err(Interrupted) => Err(Unfinished::new((found, Tendons::default(), None))),
        })
    };
    let result = |(mut found, tendons, error): (Equilibrium, Tendons, Option<SpaceError>)| {
        if let Some(chosen) = &chosen {
            chosen.judge(&mut found, error.as_ref());
        }
        let deepest = PyOverlap::new(of_python, found.deepest, None)?;
        warned(py, error.as_ref(), || {
            let replaced = chosen.as_ref().map(|chosen| chosen.model.clone().unbind());
            let result = PyStaticsResult::new(of_python, found, (t, held), &tendons, deepest, error.clone())?;
            Ok(PyStaticsResult { model: replaced, ..result })
        })
    };
    let found = run(py, n, search, result);
    match chosen.map(|chosen| chosen.raised) {
        Some(Err(raised)) => Err(with_result(py, raised, || found)),
        _ => found,
    }
}

impl Chosen<'_> {
    /// What the result of a search says of the accuracy.
    fn judge(&self, found: &mut Equilibrium, error: Option<&SpaceError>) {
        let too_large = error.map(|error| error.relative).filter(|error| *error > self.rtol);
        match (&self.failure, too_large) {
            (Some(why), _) => found.miss_accuracy(why),
            (None, Some(error)) => found.miss_accuracy(&format!(
                "The space error is {error:.0e} of the length (requested: {:.0e}).",
                self.rtol
            )),
            (None, None) => {}
        }
        if found.status.is_equilibrium() {
            let of_stability = "Stability is not judged: strains that the loads do not excite have no modes.";
            found.message += &format!(" {of_stability} {}", self.words);
        }
    }
}

/// Where a search begins, by the method and what is given for it.
fn start(
    method: &str,
    q0: Option<Vec<f64>>,
    load_steps: Option<&Bound<'_, PyAny>>,
    n: usize,
    default: Start,
) -> PyResult<Start> {
    let zeros = || vec![0.0; n];
    let start = match (method, q0) {
        ("auto", None) if load_steps.is_none() => default,
        ("auto" | "load_path", None) => Start::Unloaded { stops: stops(load_steps)? },
        ("auto", Some(q0)) => Start::Descent(q0),
        ("descent", q0) => Start::Descent(q0.unwrap_or_else(zeros)),
        ("newton", q0) => Start::Newton(q0.unwrap_or_else(zeros)),
        ("load_path", Some(_)) => {
            return Err(PyValueError::new_err(
                "q0: the method \"load_path\" begins at the unloaded shape: leave `q0` out, or use \"descent\" or \"newton\"",
            ));
        }
        _ => {
            return Err(PyValueError::new_err(format!(
                "method: got {method:?}, expected \"auto\", \"load_path\", \"descent\" or \"newton\""
            )));
        }
    };
    let has_path = matches!(start, Start::Unloaded { .. });
    if load_steps.is_some() && !has_path {
        return Err(PyValueError::new_err(
            "load_steps: with `q0`, \"descent\" and \"newton\" the whole load acts from the start: leave `load_steps` out",
        ));
    }
    Ok(start)
}

impl PyStaticsResult {
    fn new(
        model: &Bound<'_, PyModel>,
        found: Equilibrium,
        (t, u): (f64, Vec<f64>),
        tendons: &Tendons,
        deepest: Option<Py<PyOverlap>>,
        error: Option<SpaceError>,
    ) -> PyResult<Self> {
        let py = model.py();
        let doubt = error.as_ref().map_or_else(String::new, SpaceError::sentences);
        let n = found.q.len();
        let Equilibrium {
            q,
            load_factor,
            status,
            message,
            residual_norm,
            step_norm,
            verdict,
            lowest,
            path,
            deepest: _,
            counters,
        } = found;
        let Counters { iterations, forces, tangents } = counters;
        let path =
            if path.load_factor.is_empty() { None } else { Some(PyEquilibriumPath::new(py, path, n)?) };
        let [q, u] = [q, u].map(|values| ReadOnly::new(values.into_pyarray(py)));
        let (q, u) = (q?, u?);
        let message = if status.is_equilibrium() {
            Message::new(message + &tendons.message() + &doubt, Subject::at_rest(model, [&q, &u], t))
        } else {
            Message::new(message + &tendons.of_failure(), Subject::of_model(model))
        };
        Ok(Self {
            q,
            success: status.is_success(),
            status: status.name().to_owned(),
            message,
            load_factor,
            residual_norm,
            step_norm,
            is_stable: verdict.map(|verdict| verdict.stability == Stability::Stable),
            stability: verdict.map(|verdict| verdict.stability.name().to_owned()),
            undamped_stability: verdict.map(|verdict| verdict.undamped.name().to_owned()),
            lowest_eigenvalue: lowest,
            slack: tendons.slack.clone(),
            path,
            deepest,
            u: Some(u),
            t: Some(t),
            space_error: error.map(|error| Py::new(py, PySpaceError::new(error))).transpose()?,
            model: None,
            nit: iterations,
            nfev: forces,
            njev: tangents,
        })
    }
}

fn stops(load_steps: Option<&Bound<'_, PyAny>>) -> PyResult<Vec<f64>> {
    let Some(value) = load_steps else { return Ok(vec![1.0]) };
    if value.extract::<String>().is_ok_and(|text| text == "auto") {
        return Ok(vec![1.0]);
    }
    if !convert::is_array(value) {
        let steps = convert::count(convert::whole(value, "load_steps")?, "load_steps")?;
        if !(1..=core::MAX_STOPS).contains(&steps) {
            return Err(PyValueError::new_err(format!(
                "load_steps: got {steps}, expected a whole number between 1 and {}",
                core::MAX_STOPS
            )));
        }
        return Ok((1..=steps).map(|i| i as f64 / steps as f64).collect());
    }
    convert::vector(value, "load_steps").map_err(|_| {
        PyTypeError::new_err(format!(
            "load_steps: expected \"auto\", a whole number or an array of parts of the load, got {}",
            convert::describe(value)
        ))
    })
}
