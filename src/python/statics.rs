//! `lissom.statics` and `lissom.continuation`.

use std::ffi::CString;
use std::time::Duration;

use numpy::{IntoPyArray, PyArray1, PyArray2, PyArrayMethods};
use pyo3::class::{PyTraverseError, PyVisit};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList, PyTuple};

use super::arguments;
use super::background;
use super::callback::{Raised, or_raised, raised_by_function, with_result};
use super::convert;
use super::inputs::{self, or_rows};
use super::model::{Native, PyModel, check_time, model_of};
use super::motion::Ticker;
use super::overlap::PyOverlap;
use super::record::{self, ReadOnly, Reduced};
use super::remarks::{Message, Subject};
use super::space_error::PySpaceError;
use crate::analysis::statics as core;
use crate::analysis::statics::{
    ContinuationOptions, Counters, CriticalPoint, Effort, Equilibrium, InputPath, Monitor, Options, Path,
    SpaceError, Stability, Start, Tendons,
};
use crate::error::{Interrupted, InvalidInput, Unfinished};
use crate::python::errors::{AccuracyWarning, OrRaise as _};
use crate::python::words::required;

/// A point of a path of equilibria at which the tangent stiffness is singular.
///
/// Attributes
/// ----------
/// kind : {'limit', 'bifurcation'}
///     'limit': the load factor has an extremum (snap-through). 'bifurcation': paths cross (buckling).
/// index : int
///     The critical point lies between this point of the path and the next one.
/// load_factor : float
///     Fraction of the loads; for a path of inputs, the path parameter from 0 to 1.
/// u : ndarray, shape (m,), or None
///     The inputs, if the path varies them.
/// q : ndarray, shape (n,)
///     Coordinates.
/// directions : ndarray, shape (m, n)
///     Null vectors of the tangent stiffness; m > 1 if several modes buckle at once. Each has norm one when divided by the
///     typical sizes of the coordinates, about a radian of bending.
#[pyclass(name = "CriticalPoint", module = "lissom", frozen, get_all)]
#[derive(FromPyObject)]
pub(crate) struct PyCriticalPoint {
    kind: String,
    index: usize,
    load_factor: f64,
    u: Option<ReadOnly<PyArray1<f64>>>,
    q: ReadOnly<PyArray1<f64>>,
    directions: ReadOnly<PyArray2<f64>>,
}

impl PyCriticalPoint {
    fn new(py: Python<'_>, point: CriticalPoint) -> PyResult<Self> {
        let CriticalPoint { kind, index, load_factor, inputs, q, directions } = point;
        let directions = rows(py, directions, q.len())?;
        let q = ReadOnly::new(q.into_pyarray(py))?;
        let u = if inputs.is_empty() { None } else { Some(ReadOnly::new(inputs.into_pyarray(py))?) };
        Ok(Self { kind: kind.name().to_owned(), index, load_factor, u, q, directions })
    }
}

#[pymethods]
impl PyCriticalPoint {
    fn __repr__(&self) -> String {
        format!("<CriticalPoint {} at load factor {:.6}>", self.kind, self.load_factor)
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

/// A sequence of equilibria, and the critical points between them.
///
/// Attributes
/// ----------
/// load_factor : ndarray, shape (m,)
///     Fraction of the loads, including gravity; for a path of inputs, the path parameter from 0 to 1.
/// u : ndarray, shape (m, k), or None
///     The k inputs, if the path varies them.
/// q : ndarray, shape (m, n)
///     Coordinates.
/// lowest_eigenvalue : ndarray, shape (m,)
///     Smallest eigenvalue of the tangent stiffness relative to the stiffness of material and springs: one without load, zero
///     at critical points, negative at unstable equilibria.
/// stability : list of str or None
///     As in StaticsResult. Of growing loads (`statics`) only the end is judged.
/// critical_points : list of CriticalPoint
///     In the order of the path.
#[pyclass(name = "EquilibriumPath", module = "lissom", frozen, get_all)]
#[derive(FromPyObject)]
pub(crate) struct PyEquilibriumPath {
    load_factor: ReadOnly<PyArray1<f64>>,
    u: Option<ReadOnly<PyArray2<f64>>>,
    q: ReadOnly<PyArray2<f64>>,
    lowest_eigenvalue: ReadOnly<PyArray1<f64>>,
    stability: Vec<Option<String>>,
    critical_points: Py<PyList>,
}

impl PyEquilibriumPath {
    fn new(py: Python<'_>, path: Path, n: usize) -> PyResult<Py<Self>> {
        let Path { load_factor, inputs, q, lowest, stability, critical } = path;
        let critical_points = PyList::empty(py);
        for point in critical {
            critical_points.append(Bound::new(py, PyCriticalPoint::new(py, point)?)?)?;
        }
        let q = rows(py, q, n)?;
        let entries = inputs.len() / load_factor.len().max(1);
        let u = if inputs.is_empty() { None } else { Some(rows(py, inputs, entries)?) };
        let path = Self {
            load_factor: ReadOnly::new(load_factor.into_pyarray(py))?,
            u,
            q,
            lowest_eigenvalue: ReadOnly::new(lowest.into_pyarray(py))?,
            stability: stability.into_iter().map(|stability| stability.map(named)).collect(),
            critical_points: critical_points.unbind(),
        };
        Py::new(py, path)
    }
}

#[pymethods]
impl PyEquilibriumPath {
    fn __traverse__(&self, visit: PyVisit<'_>) -> Result<(), PyTraverseError> {
        visit.call(&self.critical_points)
    }

    fn __repr__(&self, py: Python<'_>) -> String {
        let (points, critical) = (self.stability.len(), self.critical_points.bind(py).len());
        format!("<EquilibriumPath of {points} points, {critical} of them critical in between>")
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

fn rows(py: Python<'_>, values: Vec<f64>, n: usize) -> PyResult<ReadOnly<PyArray2<f64>>> {
    let count = values.len().checked_div(n).unwrap_or(0);
    ReadOnly::new(values.into_pyarray(py).reshape([count, n])?)
}

fn named(stability: Stability) -> String {
    stability.name().to_owned()
}

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
///     not closed), 'interrupted' (in the `result` of a KeyboardInterrupt), or for method 'newton' a status of RootResult.
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
///     Estimated error due to the finite number of modes; None after a failure, with `space_error=False`, or without rods,
///     and where it is not known: where forces change so much with the shape that neither their balance nor steps of a model with more modes
///     determine it, as of slack cables without bending stiffness.
/// nit, nfev, njev : int
///     Numbers of Newton iterations, force evaluations and tangent evaluations.
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
    nit: usize,
    nfev: usize,
    njev: usize,
}

#[pymethods]
impl PyStaticsResult {
    fn __traverse__(&self, visit: PyVisit<'_>) -> Result<(), PyTraverseError> {
        visit.call(&self.path)?;
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
        record::add_missing(state, &["deepest", "space_error", "u", "t"])?;
        state.extract()
    }
}

/// Result of `continuation`.
///
/// Attributes
/// ----------
/// path : EquilibriumPath
///     The path, up to the failure if there was one.
/// success : bool
///     True if the path reached one of its bounds.
/// status : str
///     'finished', 'no_start' (no equilibrium near `q0`), 'step_too_small', 'too_many_steps', 'unresolved', 'inverted',
///     'collapsed', 'deep_penetration' (surfaces would overlap by more than a radius) or 'interrupted' (in the `result` of a
///     KeyboardInterrupt).
/// message : str
///     The status in words, and what to change.
/// u : ndarray, shape (m,), or None
///     The inputs that do not vary along the path, and the default values of those that do (`path.u` has all); None in results saved by
///     versions that did not keep them.
/// t : float or None
///     The time of the search, seconds; None as for `u`.
/// nit, nfev, njev : int
///     Numbers of Newton iterations, force evaluations and tangent evaluations.
#[pyclass(name = "ContinuationResult", module = "lissom", frozen, get_all)]
#[derive(FromPyObject)]
pub(crate) struct PyContinuationResult {
    path: Py<PyEquilibriumPath>,
    success: bool,
    status: String,
    message: Message,
    u: Option<ReadOnly<PyArray1<f64>>>,
    t: Option<f64>,
    nit: usize,
    nfev: usize,
    njev: usize,
}

#[pymethods]
impl PyContinuationResult {
    fn __traverse__(&self, visit: PyVisit<'_>) -> Result<(), PyTraverseError> {
        visit.call(&self.path)?;
        self.message.traverse(&visit)
    }

    fn __repr__(&self, py: Python<'_>) -> String {
        format!("<ContinuationResult: {}, {}>", self.status, self.path.bind(py).get().__repr__(py))
    }

    /// For copies and pickles.
    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<Reduced<'py>> {
        record::reduce(slf)
    }

    #[staticmethod]
    fn _restore(state: &Bound<'_, PyAny>) -> PyResult<Self> {
        record::add_missing(state, &["u", "t"])?;
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
///     Whether to judge the stability of the equilibrium. Without, `stability` is None.
/// space_error : bool, optional
///     Whether to estimate the error due to the finite number of modes. By default by the balance of forces, which costs a few
///     evaluations of them, and with more modes only where that leaves doubts; True: always with more modes; False: not at all.
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
#[pyo3(signature = (model=None, q0=None, *more, load_steps=None, method="auto", t=0.0, tol=None, max_iter=None, max_steps=None, u=None, stability=true, space_error=None, **others),
       text_signature = "(model, q0=None, *, load_steps='auto', method='auto', t=0.0, tol=1e-10, max_iter=500, max_steps=500, u=None, stability=True, space_error=None)")]
#[allow(clippy::too_many_arguments, reason = "keyword-only options of a Python function")]
pub(crate) fn statics<'py>(
    py: Python<'py>,
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
    others: Option<&Bound<'_, PyDict>>,
) -> PyResult<PyStaticsResult> {
    let model = required!("statics", others; more, model);
    let u = u.map(|u| inputs_of(model, u)).transpose()?;
    let held = inputs_or_default(model, u.as_deref())?;
    let of_names = model.clone();
    let mut model = native_with(model, t, u.as_deref())?;
    let n = model.facts().n;
    let q0 = q0.map(|q0| convert::finite_vector_of(q0, n, "q0")).transpose()?;
    let defaults = Options::of(model.facts());
    let start = start(method, q0, load_steps, n, defaults.start)?;
    let options = Options {
        start,
        tol: tol.unwrap_or(defaults.tol),
        max_iter: count(max_iter, "max_iter", defaults.max_iter)?,
        max_steps: count(max_steps, "max_steps", defaults.max_steps)?,
        stability,
    };
    let effort = match space_error {
        Some(false) => None,
        Some(true) => Some(Effort::Full),
        None => Some(Effort::Little),
    };
    let search = move |monitor: Monitor<'_>| {
        let mut found = match core::equilibrium(&mut *model, &options, monitor)? {
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
    run(py, n, search, |(found, tendons, error)| {
        let deepest = PyOverlap::new(base(&of_names)?, found.deepest, None)?;
        let doubt = error.as_ref().and_then(SpaceError::doubt);
        let result = PyStaticsResult::new(base(&of_names)?, found, (t, held), &tendons, deepest, error)?;
        let Some(doubt) = doubt else { return Ok(result) };
        match PyErr::warn(py, &py.get_type::<AccuracyWarning>(), &CString::new(doubt)?, 1) {
            Ok(()) => Ok(result),
            Err(raised) => Err(with_result(py, raised, || Ok(result))),
        }
    })
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
        let of_modes = error.iter().flat_map(|error| [error.doubt(), error.about_stretch()]).flatten();
        let doubt: String = of_modes.map(|sentence| format!(" {sentence}")).collect();
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
        let message = if status.is_success() {
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
            nit: iterations,
            nfev: forces,
            njev: tangents,
        })
    }
}

/// Follow a path of equilibria over the load factor, through limit points and onto branches.
///
/// The load factor scales all loads. With `inputs`, it interpolates inputs such as tensions, pressures and lengths between two
/// values, at 0 and at 1, under the full load.
///
/// Parameters
/// ----------
/// model : Model
///     A `Rod`, `Robot` or `SpringPendulum`.
/// q0 : array_like, shape (n,), optional
///     Coordinates at or near the equilibrium at which the path begins; by default zero, with `inputs` the equilibrium found by
///     `statics`.
/// load_factor : float
///     Fraction of the loads, including gravity, at the beginning; with `inputs` the path parameter.
/// direction : array_like, shape (n,), optional
///     The initial direction of the path: one of the `directions` of a bifurcation, or its opposite, to
///     follow the branches there. By default the path leads towards larger load factors.
/// bounds : (float, float)
///     Lowest and highest load factor, at which the path ends.
/// max_step : float
///     Maximum step, measured jointly in radians of the whole rod, stretch, shear and load factor.
/// max_steps : int
///     Maximum number of steps.
/// t : float
///     Time at which time-dependent loads are evaluated, seconds.
/// tol : float
///     As for `statics`.
/// u : array_like, shape (m,), or dict, optional
///     Inputs that do not vary along the path; by default `u0` of the model.
/// inputs : mapping from str to (from, to), optional
///     Names of the inputs that vary, with their values at 0 and at 1: two numbers, or two triples for a vector input. A vector
///     input and its single entries cannot both be given.
///
/// Returns
/// -------
/// ContinuationResult
///     `path` with its `load_factor`, `q`, `stability` and `critical_points`; `success`, `status`, `message`.
///
/// Raises
/// ------
/// ValueError, TypeError
///     If an argument is invalid.
/// KeyboardInterrupt
///     On Ctrl-C. Its attribute `result` is the ContinuationResult with the path until then; exceptions of functions of time have it, too.
///
/// Examples
/// --------
/// A column under one and a half times its buckling load, straight and then buckled to one side:
///
/// >>> import numpy as np, lissom
/// >>> column = lissom.Segment(1.0, 0.01, 1e9, 4e8, 1000, modes={"bend_y": 4})
/// >>> buckling_load = np.pi**2 / 4 * 1e9 * np.pi / 4 * 0.01**4
/// >>> rod = lissom.Rod([column], gravity=(0, 0, 0), tip_force=(-1.5 * buckling_load, 0, 0))
/// >>> point = lissom.continuation(rod).path.critical_points[0]
/// >>> point.kind, round(1.5 * point.load_factor, 5)
/// ('bifurcation', 1.0)
/// >>> buckled = lissom.continuation(
/// ...     rod, point.q, load_factor=point.load_factor, direction=point.directions[0]
/// ... )
/// >>> buckled.success, buckled.path.stability[-1]
/// (True, 'stable')
#[pyfunction]
#[pyo3(signature = (model=None, q0=None, *more, load_factor=0.0, direction=None, bounds=None, max_step=None, max_steps=None, t=0.0, tol=None, u=None, inputs=None, **others),
       text_signature = "(model, q0=None, *, load_factor=0.0, direction=None, bounds=(0.0, 1.0), max_step=0.25, max_steps=500, t=0.0, tol=1e-10, u=None, inputs=None)")]
#[allow(clippy::too_many_arguments, reason = "keyword-only options of a Python function")]
pub(crate) fn continuation<'py>(
    py: Python<'py>,
    #[pyo3(from_py_with = arguments::given)] model: Option<&Bound<'py, PyAny>>,
    q0: Option<&Bound<'py, PyAny>>,
    more: &Bound<'_, PyTuple>,
    #[pyo3(from_py_with = arguments::number::load_factor)] load_factor: f64,
    direction: Option<&Bound<'py, PyAny>>,
    bounds: Option<&Bound<'py, PyAny>>,
    #[pyo3(from_py_with = arguments::optional_number::max_step)] max_step: Option<f64>,
    #[pyo3(from_py_with = arguments::optional_whole::max_steps)] max_steps: Option<i64>,
    #[pyo3(from_py_with = arguments::number::t)] t: f64,
    #[pyo3(from_py_with = arguments::optional_number::tol)] tol: Option<f64>,
    u: Option<&Bound<'py, PyAny>>,
    inputs: Option<&Bound<'py, PyAny>>,
    others: Option<&Bound<'_, PyDict>>,
) -> PyResult<PyContinuationResult> {
    let model = required!("continuation", others; more, model);
    let u = u.map(|u| inputs_of(model, u)).transpose()?;
    let of_model = model;
    let held = inputs_or_default(of_model, u.as_deref())?;
    let mut model = native_with(of_model, t, u.as_deref())?;
    let inputs = inputs.map(|inputs| input_path(of_model, u, inputs, t)).transpose()?;
    let n = model.facts().n;
    let vector = |value: Option<&Bound<'py, PyAny>>, name| {
        value.map(|value| convert::finite_vector_of(value, n, name)).transpose()
    };
    let defaults = ContinuationOptions::default();
    let options = ContinuationOptions {
        inputs,
        q0: vector(q0, "q0")?,
        load_factor,
        direction: vector(direction, "direction")?,
        bounds: bounds.map_or(Ok(defaults.bounds), |bounds| convert::array_of(bounds, "bounds"))?,
        max_step: max_step.unwrap_or(defaults.max_step),
        max_steps: count(max_steps, "max_steps", defaults.max_steps)?,
        tol: tol.unwrap_or(defaults.tol),
        ..defaults
    };
    let search = move |monitor: Monitor<'_>| core::continuation(&mut *model, &options, monitor);
    run(py, n, search, |found| {
        let Counters { iterations, forces, tangents } = found.counters;
        Ok(PyContinuationResult {
            path: PyEquilibriumPath::new(py, found.path, n)?,
            success: found.status.is_success(),
            status: found.status.name().to_owned(),
            message: Message::new(found.message, Subject::of_model(base(of_model)?)),
            u: Some(ReadOnly::new(held.into_pyarray(py))?),
            t: Some(t),
            nit: iterations,
            nfev: forces,
            njev: tangents,
        })
    })
}

/// The base class of a model.
pub(super) fn base<'a, 'py>(model: &'a Bound<'py, PyAny>) -> PyResult<&'a Bound<'py, PyModel>> {
    model_of(model, "model")
}

/// Values for all inputs of a model.
pub(super) fn inputs_of(model: &Bound<'_, PyAny>, u: &Bound<'_, PyAny>) -> PyResult<Vec<f64>> {
    let model = base(model)?.get();
    let instead = |_| "`lissom.statics_many(model, u)` takes one set of inputs in each row".to_owned();
    model.inputs_of(u).map_err(|error| or_rows(u, model.input_names().len(), error, instead))
}

/// These inputs, or the defaults of a model.
pub(super) fn inputs_or_default(model: &Bound<'_, PyAny>, u: Option<&[f64]>) -> PyResult<Vec<f64>> {
    let model = base(model)?.get();
    Ok(u.map_or_else(|| model.default_inputs(), <[f64]>::to_vec))
}

/// A separate copy of a model, at a time and with these inputs.
pub(super) fn native_with(model: &Bound<'_, PyAny>, t: f64, u: Option<&[f64]>) -> PyResult<Box<dyn Native>> {
    let mut model = base(model)?.get().native();
    check_time(t, model.facts().time_span)?;
    if let Some(u) = u {
        model.set_inputs(u);
    }
    or_raised(model.set_time(t))?;
    if let Some(what) = model.not_finite() {
        return Err(PyValueError::new_err(format!("{what}, expected finite numbers")));
    }
    Ok(model)
}

/// The linear path of inputs from one value to another; the other inputs are constant, as in `u`.
fn input_path(
    model: &Bound<'_, PyAny>,
    u: Option<Vec<f64>>,
    inputs: &Bound<'_, PyAny>,
    time: f64,
) -> PyResult<InputPath> {
    let model = base(model)?.get();
    let from = u.unwrap_or_else(|| model.default_inputs());
    let mut path = InputPath { to: from.clone(), from, time };
    for (entries, [from, to]) in inputs::pairs(inputs, &model.input_names(), "inputs", inputs::value)? {
        path.from[entries.clone()].copy_from_slice(&from);
        path.to[entries].copy_from_slice(&to);
    }
    Ok(path)
}

/// Runs a computation of a model of `n` coordinates without the interpreter, and converts what it found. Ctrl-C and
/// exceptions of functions of time stop it; the exception then has what was found until then as its `result`.
pub(super) fn run<'py, T: Send + 'static, R: IntoPyObject<'py>>(
    py: Python<'py>,
    n: usize,
    search: impl FnOnce(Monitor<'_>) -> Result<Result<T, Unfinished<T>>, InvalidInput> + Send + 'static,
    result: impl FnOnce(T) -> PyResult<R>,
) -> PyResult<R> {
    /// An evaluation of a model of a thousand coordinates, with its decompositions, ends within this time.
    const PATIENCE: Duration = Duration::from_secs(5);
    let (found, raised) = if n >= background::LARGE {
        let ((found, of_function), raised) = background::run_to_check(py, PATIENCE, move |abandoned| {
            let found = search(&mut || abandoned.check());
            // Functions of time keep their exceptions in the thread that called them.
            (found, raised_by_function())
        })?;
        (found, of_function.and(raised))
    } else {
        let mut raised = Raised::default();
        let mut ticker = Ticker::new();
        let found = py.detach(|| {
            search(&mut || {
                raised.none_yet()?;
                if !ticker.tick() {
                    return Ok(());
                }
                raised.catch(Python::attach(|py| py.check_signals()))
            })
        });
        (found, raised.into_result())
    };
    let found = found.or_raise()?.unwrap_or_else(Unfinished::into_inner);
    match raised {
        Ok(()) => result(found),
        Err(error) => Err(with_result(py, error, || result(found))),
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

fn count(value: Option<i64>, name: &str, default: usize) -> PyResult<usize> {
    value.map_or(Ok(default), |value| convert::count(value, name))
}
