//! `lissom.actuate`: inputs for target poses.

use numpy::{IntoPyArray, PyArray1, PyArrayMethods, PyUntypedArrayMethods};
use pyo3::class::{PyTraverseError, PyVisit};
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList, PyTuple};

use super::arguments;
use super::convert;
use super::inputs::{Pair, entries, limit, pair, pairs};
use super::model::{PyModel, check_time};
use super::reach::{PoseArguments, Targets};
use super::record::{self, ReadOnly, Reduced};
use super::remarks::{Message, Subject};
use super::robot::PyRobot;
use super::search::{inputs_of, run};
use super::space_error::{PySpaceError, warned};
use crate::analysis::actuate as core;
use crate::analysis::actuate::{Found, Options};
use crate::analysis::stability::Stability;
use crate::analysis::statics::{Monitor, SpaceError};
use crate::error::{Interrupted, Unfinished};
use crate::model::Dynamics as _;
use crate::python::words::required;
use crate::robot::Robot;

/// Result of `actuate`.
///
/// Attributes
/// ----------
/// u : ndarray, shape (m,)
///     All inputs; if the targets are not reached, those that come nearest.
/// q : ndarray, shape (n,)
///     The equilibrium at these inputs.
/// success : bool
///     True if all targets are reached with locally smallest inputs.
/// status : str
///     'reached', 'not_settled' (reached, but the search for the smallest inputs did not converge), 'nearest' (not reachable: a
///     local minimum of the error by first and second derivatives), 'at_limits' (a local minimum within the limits, some of
///     which are active), 'equilibrium_lost' (the robot buckles or snaps on the way to the targets), 'no_start' (no
///     equilibrium at the initial inputs), 'iteration_limit', 'stalled' or 'interrupted' (in the `result` of a
///     KeyboardInterrupt).
/// message : str
///     The status in words, with the remaining error, and what to change.
/// position_error : float, or ndarray of shape (k,) for a mapping or a sequence of k targets
///     Distance of the point from its target, metres, along the axes with a weight; zero without a position
///     target.
/// orientation_error : float, or ndarray of shape (k,)
///     Angle from the target orientation, radians, about the axes with a weight; zero if there is none.
/// pose : ndarray, shape (4, 4) or (k, 4, 4)
///     Poses of the sections and bodies of the targets, as from `Robot.pose`.
/// at_limits : list of str
///     Inputs whose limits are active, for the status 'at_limits'.
/// is_stable : bool or None
///     Whether small disturbances of the equilibrium stay small.
/// stability : str or None
///     As in StaticsResult.
/// space_error : SpaceError or None
///     Estimated error of the equilibrium due to the finite number of modes, as for `statics`; None without an equilibrium.
/// nit, nfev, njev : int
///     Numbers of steps, evaluations of the error, and evaluations of its derivative with respect to the inputs.
/// equilibria : int
///     Number of equilibria computed.
#[pyclass(name = "ActuateResult", module = "lissom", frozen, get_all)]
#[derive(FromPyObject)]
pub(crate) struct PyActuateResult {
    u: ReadOnly<PyArray1<f64>>,
    q: ReadOnly<PyArray1<f64>>,
    success: bool,
    status: String,
    message: Message,
    position_error: ReadOnly,
    orientation_error: ReadOnly,
    pose: ReadOnly,
    at_limits: Vec<String>,
    is_stable: Option<bool>,
    stability: Option<String>,
    space_error: Option<Py<PySpaceError>>,
    nit: usize,
    nfev: usize,
    njev: usize,
    equilibria: usize,
}

impl PyActuateResult {
    fn new(
        model: &Bound<'_, PyModel>,
        robot: &Robot,
        (found, error): (Found, Option<&SpaceError>),
        (t, is_single): (f64, bool),
    ) -> PyResult<Self> {
        let py = model.py();
        let Found { u, q, status, message, errors, poses, at_limits, verdict, counters, equilibria } = found;
        let names = robot.inputs().names();
        let numbers = |values: Vec<f64>| -> PyResult<ReadOnly> {
            ReadOnly::new(match values[..] {
                [value] if is_single => value.into_pyobject(py)?.into_any(),
                _ => values.into_pyarray(py).into_any(),
            })
        };
        let matrices: Vec<f64> = poses.iter().flat_map(convert::homogeneous).collect();
        let shape = if is_single { vec![4, 4] } else { vec![poses.len(), 4, 4] };
        let [q, u] = [q, u].map(|values| ReadOnly::new(values.into_pyarray(py)));
        let (q, u) = (q?, u?);
        let of_modes = error.filter(|_| status.is_success()).map_or_else(String::new, SpaceError::sentences);
        let message = message + &of_modes;
        let message = Message::new(message, Subject::at_rest(model, [&q, &u], t));
        Ok(Self {
            u,
            q,
            success: status.is_success(),
            status: status.name().to_owned(),
            message,
            position_error: numbers(errors.iter().map(|error| error.position).collect())?,
            orientation_error: numbers(errors.iter().map(|error| error.orientation).collect())?,
            pose: ReadOnly::new(matrices.into_pyarray(py).reshape(shape)?.into_any())?,
            at_limits: at_limits.into_iter().map(|k| names[k].clone()).collect(),
            is_stable: verdict.map(|verdict| verdict.stability == Stability::Stable),
            stability: verdict.map(|verdict| verdict.stability.name().to_owned()),
            space_error: error.map(|error| Py::new(py, PySpaceError::new(error.clone()))).transpose()?,
            nit: counters.iterations,
            nfev: counters.residuals,
            njev: counters.jacobians,
            equilibria,
        })
    }
}

#[pymethods]
impl PyActuateResult {
    fn __traverse__(&self, visit: PyVisit<'_>) -> Result<(), PyTraverseError> {
        self.message.traverse(&visit)
    }

    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        let (inputs, status, nit) = (self.u.bind(py).len(), &self.status, self.nit);
        let stable = self.stability.as_deref().unwrap_or("stability unknown");
        Ok(format!("<ActuateResult: {status}, {stable}, {inputs} inputs, {nit} iterations>"))
    }

    /// For copies and pickles.
    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<Reduced<'py>> {
        record::reduce(slf)
    }

    #[staticmethod]
    fn _restore(state: &Bound<'_, PyAny>) -> PyResult<Self> {
        record::add_missing(state, &["space_error"])?;
        state.extract()
    }
}

/// Find the inputs (tensions, pressures, torques, lengths) that bring links to given poses.
///
/// Every step follows the equilibrium from the previous inputs to the new ones, as if they changed slowly. If there are more
/// inputs than needed, as with antagonistic tendons, the smallest inputs that reach the targets are chosen. They minimise the
/// sum of squares, each input relative to what the strongest input of its kind (tension, pressure, ...) needs to move the
/// shape. Lengths and positions count from their defaults.
///
/// Parameters
/// ----------
/// robot : Robot
///     A robot, or a rod, with inputs (`lissom.Input`).
/// target : array_like, mapping, Target or sequence of Target
///     Target poses of links: a mapping from their names to poses (as for `Robot.reach`), one `Target` or
///     several; for a robot of one link a pose of its tip is enough. Targets at several stations `X` of a rod
///     prescribe its shape.
/// inputs : sequence of str, optional
///     Names of the inputs that may change; by default all except sliding directions (`sliding` of a `Tendon`).
/// limits : (lower, upper) or mapping from str to (lower, upper), optional
///     Bounds of all inputs, or bounds by name; infinite for no bound. In addition tensions and lengths are
///     not negative, torques stay within the `limits` of their motor, and directions of sliding between -1
///     and 1.
/// u : array_like, shape (m,), or dict, optional
///     The initial inputs, moved within the limits; inputs that may not change keep these values. By default
///     `u0` of the robot. A slack tendon has no effect on the shape: if its length is an input, start with
///     the tendon taut.
/// q0 : array_like, shape (n,), optional
///     Shape near the initial equilibrium, from which the robot is released. By default the loads are increased from zero, as in
///     `statics`.
/// t : float
///     Time at which time-dependent loads and motions are evaluated, seconds.
/// tol : float
///     A target counts as reached if the position error is at most `tol` times the length of the chain of links that carries it and
///     the orientation error at most `tol` radians.
/// max_iter : int
///     Maximum number of steps.
///
/// Returns
/// -------
/// ActuateResult
///     `u`, `q`, `success`, `status`, `message`, `position_error`, `stability` and more. An unreachable target does not raise.
///
/// Raises
/// ------
/// ValueError, TypeError
///     If an argument is invalid.
/// KeyboardInterrupt
///     On Ctrl-C. Its attribute `result` is the ActuateResult with the best inputs until then; exceptions of functions of time have it, too.
///
/// Warns
/// -----
/// AccuracyWarning
///     If the finite number of modes leaves an error of the equilibrium of more than a hundredth of the length.
///
/// Notes
/// -----
/// A step costs a few tangents of the model, or a few per input while the smallest inputs or an unreachable target's nearest
/// shape are sought. The sensitivity of the equilibrium is exact, ``dq/du = -solve(dtau_dq, dtau_du)``. The method of
/// multipliers (Hestenes 1969; Powell 1969) finds the smallest inputs.
///
/// Examples
/// --------
/// >>> import lissom
/// >>> finger = lissom.Segment(0.2, 2e-3, 1e9, 4e8, 1200, {"bend_y": 3})
/// >>> pull = lissom.Tendon("pull", [lissom.Along(offset=(0, 0.01))], tension=lissom.Input("pull", 1.0))
/// >>> rod = lissom.Rod([finger], actuators=[pull], gravity=(0, 0, 0))
/// >>> height = lissom.Target("rod", (0, 0, 0.05), position_weight=(0, 0, 1))
/// >>> found = lissom.actuate(rod, height)
/// >>> found.status, rod.pose(found.q)[2, 3].round(6)
/// ('reached', np.float64(0.05))
/// >>> weak = lissom.actuate(rod, height, limits={"pull": (0, 2)})
/// >>> weak.status, weak.at_limits, weak.u
/// ('at_limits', ['pull'], array([2.]))
#[pyfunction]
#[pyo3(signature = (robot=None, target=None, *more, inputs=None, limits=None, u=None, q0=None, t=0.0, tol=None, max_iter=None, **others),
       text_signature = "(robot, target, *, inputs=None, limits=None, u=None, q0=None, t=0.0, tol=1e-09, max_iter=100)")]
#[allow(clippy::too_many_arguments, reason = "keyword-only options of a Python function")]
pub(crate) fn actuate<'py>(
    py: Python<'py>,
    #[pyo3(from_py_with = arguments::given)] robot: Option<&Bound<'py, PyAny>>,
    #[pyo3(from_py_with = arguments::given)] target: Option<&Bound<'py, PyAny>>,
    more: &Bound<'_, PyTuple>,
    inputs: Option<&Bound<'py, PyAny>>,
    limits: Option<&Bound<'py, PyAny>>,
    u: Option<&Bound<'py, PyAny>>,
    q0: Option<&Bound<'py, PyAny>>,
    #[pyo3(from_py_with = arguments::number::t)] t: f64,
    #[pyo3(from_py_with = arguments::optional_number::tol)] tol: Option<f64>,
    #[pyo3(from_py_with = arguments::optional_whole::max_iter)] max_iter: Option<i64>,
    others: Option<&Bound<'_, PyDict>>,
) -> PyResult<PyActuateResult> {
    let (robot, target) = required!("actuate", others; more, robot, target);
    let Ok(of_python) = robot.cast::<PyRobot>() else {
        let found = convert::describe(robot);
        return Err(PyTypeError::new_err(format!("robot: expected a Robot or a Rod, got {found}")));
    };
    let u = u.map(|u| inputs_of(robot, u)).transpose()?;
    let mut model = of_python.get().model()?;
    check_time(t, model.facts().time_span)?;
    let robot = model.description().clone();
    let names = robot.inputs().names();
    let targets = targets_of(&robot, target)?;
    let n = robot.coordinates();
    let defaults = Options::default();
    let options = Options {
        u,
        q0: q0.map(|q0| convert::finite_vector_of(q0, n, "q0")).transpose()?,
        free: inputs.map(|inputs| entries_of(inputs, &names)).transpose()?,
        limits: limits.map_or(Ok(Vec::new()), |limits| limits_of(limits, &names))?,
        time: t,
        tol: tol.unwrap_or(defaults.tol),
        max_iter: max_iter.map_or(Ok(defaults.max_iter), |max_iter| convert::count(max_iter, "max_iter"))?,
    };
    let Targets { targets, places, is_single } = targets;
    let search = move |monitor: Monitor<'_>| {
        let found = core::actuate(&mut model, &targets, &options, monitor)
            .map_err(|error| super::reach::named(&places, error))?;
        let found = match found {
            Ok(found) => found,
            Err(unfinished) => return Ok(Err(unfinished.map(|found| (found, None)))),
        };
        Ok(match core::space_error(&mut model, &found, t) {
            Ok(error) => Ok((found, error)),
            Err(Interrupted) => Err(Unfinished::new((found, None))),
        })
    };
    run(py, n, search, |(found, error)| {
        warned(py, error.as_ref(), || {
            PyActuateResult::new(of_python.as_super(), &robot, (found, error.as_ref()), (t, is_single))
        })
    })
}

/// Targets in all accepted forms.
fn targets_of(robot: &Robot, target: &Bound<'_, PyAny>) -> PyResult<Targets> {
    let is_target = |value: &Bound<'_, PyAny>| value.get_type().name().is_ok_and(|name| name == "Target");
    if is_target(target) {
        let one = PyList::new(target.py(), [target])?;
        let targets = Targets::of(robot, &one, None, "target")?;
        return Ok(Targets { is_single: true, ..targets });
    }
    let is_sequence = target
        .try_iter()
        .is_ok_and(|mut items| items.next().is_none_or(|item| item.is_ok_and(|item| is_target(&item))));
    if is_sequence || target.hasattr("items")? {
        return Targets::of(robot, target, None, "target");
    }
    let given = PoseArguments { pose: target, at: None, point: None, weights: [None; 2] };
    let none = target.py().None().into_bound(target.py());
    Targets::of(robot, &none, Some(&given), "target")
}

/// Indices in u of the inputs with these names.
fn entries_of(inputs: &Bound<'_, PyAny>, names: &[String]) -> PyResult<Vec<usize>> {
    let wrong = |found: &Bound<'_, PyAny>| {
        let found = convert::describe(found);
        PyTypeError::new_err(format!("inputs: expected a sequence of names of inputs, got {found}"))
    };
    if let Ok(name) = inputs.extract::<String>() {
        return Ok(entries(names, &name, "inputs")?.collect());
    }
    let mut all = Vec::new();
    for (i, name) in inputs.try_iter().map_err(|_| wrong(inputs))?.enumerate() {
        let name = name?;
        let name: String = name.extract().map_err(|_| wrong(&name))?;
        for entry in entries(names, &name, &format!("inputs[{i}]"))? {
            if !all.contains(&entry) {
                all.push(entry);
            }
        }
    }
    Ok(all)
}

/// Limits for all inputs, or by name.
fn limits_of(limits: &Bound<'_, PyAny>, names: &[String]) -> PyResult<Vec<(usize, [f64; 2])>> {
    let all = if limits.hasattr("items")? {
        pairs(limits, names, "limits", limit)?
    } else {
        vec![(0..names.len(), pair(limits, names.len(), "limits", limit)?)]
    };
    let of_entries = |(range, [lower, upper]): Pair| {
        range.zip(lower.into_iter().zip(upper)).map(|(entry, (lower, upper))| (entry, [lower, upper]))
    };
    Ok(all.into_iter().flat_map(of_entries).collect())
}
