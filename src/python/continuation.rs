//! `lissom.continuation`.

use numpy::{IntoPyArray, PyArray1};
use pyo3::class::{PyTraverseError, PyVisit};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};

use super::arguments;
use super::convert;
use super::equilibrium_path::PyEquilibriumPath;
use super::inputs;
use super::record::{self, ReadOnly, Reduced};
use super::remarks::{Message, Subject};
use super::search::{base, count, inputs_of, inputs_or_default, native_with, run};
use super::space_error::{PySpaceError, warned};
use crate::analysis::statics as core;
use crate::analysis::statics::{ContinuationOptions, Counters, InputPath, Monitor, SpaceError};
use crate::error::{Interrupted, Unfinished};
use crate::python::words::required;

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
/// space_error : SpaceError or None
///     Estimated error due to the finite number of modes at the point of the path where it is largest, of sixteen evenly along it; None where it is not known, as for
///     `statics`. Of robots with closed loops, supports or tendons that do not stretch, under growing loads, at load factor one alone.
/// space_error_at : float or None
///     The load factor, or the path parameter, of this point.
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
    space_error: Option<Py<PySpaceError>>,
    space_error_at: Option<f64>,
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
        record::add_missing(state, &["u", "t", "space_error", "space_error_at"])?;
        state.extract()
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
/// Warns
/// -----
/// AccuracyWarning
///     If the finite number of modes leaves an error of more than a hundredth of the length somewhere on the path.
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
    let inputs = inputs.map(|inputs| input_path(of_model, u.clone(), inputs, t)).transpose()?;
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
    let of_inputs = u.clone();
    let search = move |monitor: Monitor<'_>| {
        let found = match core::continuation(&mut *model, &options, monitor)? {
            Ok(found) => found,
            Err(unfinished) => return Ok(Err(unfinished.map(|found| (found, None)))),
        };
        Ok(match model.error_along(&found.path, (t, of_inputs.as_deref())) {
            Ok(error) => Ok((found, error)),
            Err(Interrupted) => Err(Unfinished::new((found, None))),
        })
    };
    run(py, n, search, |(found, error)| {
        let Counters { iterations, forces, tangents } = found.counters;
        let at = error.as_ref().map(|(i, _)| found.path.load_factor[*i]);
        let error = error.map(|(_, error)| error);
        let said = error.as_ref().map_or_else(String::new, SpaceError::sentences);
        let place = at.filter(|_| !said.is_empty()).map(|at| format!(" At load factor {at:.6}:"));
        let message = found.message + &place.unwrap_or_default() + &said;
        warned(py, error.as_ref(), || {
            Ok(PyContinuationResult {
                path: PyEquilibriumPath::new(py, found.path, n)?,
                success: found.status.is_success(),
                status: found.status.name().to_owned(),
                message: Message::new(message, Subject::of_model(base(of_model)?)),
                u: Some(ReadOnly::new(held.into_pyarray(py))?),
                t: Some(t),
                space_error: error.clone().map(|error| Py::new(py, PySpaceError::new(error))).transpose()?,
                space_error_at: at,
                nit: iterations,
                nfev: forces,
                njev: tangents,
            })
        })
    })
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
