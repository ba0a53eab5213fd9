//! Inverse kinematics: `lissom.Robot.reach`, the targets that Python describes, and the result.

use numpy::{IntoPyArray, PyArray1, PyArrayMethods, PyUntypedArrayMethods};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyMapping, PyString};

use super::convert::{self, Numbers};
use super::record::{self, ReadOnly, Reduced};
use super::remarks::with;
use super::search::run;
use crate::analysis::reach as core;
use crate::analysis::reach::{Options, Preference, Reached, Target};
use crate::analysis::statics::Monitor;
use crate::error::{InvalidInput, Problem};
use crate::numerics::lie::{QUATERNION_TOLERANCE, Quaternion, Rotation};
use crate::python::errors::OrRaise as _;
use crate::robot::{Robot, RobotModel};

/// Allowed deviation of the last row of a homogeneous transformation from (0, 0, 0, 1), for rounding errors
/// of its computation.
const ROW_TOLERANCE: f64 = 1e-9;

/// Result of `Robot.reach`.
///
/// Attributes
/// ----------
/// q : ndarray, shape (n,)
///     Coordinates, with rotation vectors of at most half a turn; if the targets are not reached, those that come nearest.
/// success : bool
///     True if all targets are reached, by the preferred shape if one was requested.
/// status : str
///     'reached', 'not_settled' (reached, but the search for the preferred shape did not converge), 'nearest' (a local minimum of
///     the error, by first and second derivatives), 'at_limits' (a local minimum within the limits, some of which are
///     active), 'iteration_limit', 'stalled', 'unresolved', 'inverted' or 'collapsed' (the search led to shapes that the model
///     cannot represent), or 'interrupted' (in the `result` of a KeyboardInterrupt).
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
///     Coordinates whose limits are active, for the status 'at_limits'.
/// starts : int
///     Number of starts tried.
/// nit, nfev, njev : int
///     Numbers of steps, evaluations of the shape, and Jacobians, from all starts together.
#[pyclass(name = "ReachResult", module = "lissom", frozen, get_all)]
#[derive(FromPyObject)]
pub(crate) struct PyReachResult {
    q: ReadOnly<PyArray1<f64>>,
    success: bool,
    status: String,
    message: String,
    position_error: ReadOnly,
    orientation_error: ReadOnly,
    pose: ReadOnly,
    at_limits: Vec<String>,
    starts: usize,
    nit: usize,
    nfev: usize,
    njev: usize,
}

impl PyReachResult {
    fn new(py: Python<'_>, robot: &Robot, found: Reached, is_single: bool) -> PyResult<Self> {
        let Reached { q, status, message, errors, poses, at_limits, starts, counters } = found;
        let names = robot.coordinate_names();
        let numbers = |values: Vec<f64>| -> PyResult<ReadOnly> {
            ReadOnly::new(match values[..] {
                [value] if is_single => value.into_pyobject(py)?.into_any(),
                _ => values.into_pyarray(py).into_any(),
            })
        };
        let matrices: Vec<f64> = poses.iter().flat_map(convert::homogeneous).collect();
        let shape = if is_single { vec![4, 4] } else { vec![poses.len(), 4, 4] };
        Ok(Self {
            q: ReadOnly::new(q.into_pyarray(py))?,
            success: status.is_success(),
            status: status.name().to_owned(),
            message: with(&message, &robot.implausible_units()),
            position_error: numbers(errors.iter().map(|error| error.position).collect())?,
            orientation_error: numbers(errors.iter().map(|error| error.orientation).collect())?,
            pose: ReadOnly::new(matrices.into_pyarray(py).reshape(shape)?.into_any())?,
            at_limits: at_limits.into_iter().map(|k| names[k].clone()).collect(),
            starts,
            nit: counters.iterations,
            nfev: counters.residuals,
            njev: counters.jacobians,
        })
    }
}

#[pymethods]
impl PyReachResult {
    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        let (q, status, nit) = (self.q.bind(py).len(), &self.status, self.nit);
        Ok(format!("<ReachResult: {status}, {q} coordinates, {nit} iterations>"))
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

/// A target as passed from Python.
pub(super) struct PoseArguments<'a, 'py> {
    pub(super) pose: &'a Bound<'py, PyAny>,
    pub(super) at: Option<f64>,
    pub(super) point: Option<&'a Bound<'py, PyAny>>,
    pub(super) weights: [Option<&'a Bound<'py, PyAny>>; 2],
}

impl PoseArguments<'_, '_> {
    /// The target for the link with this index.
    fn target(&self, link: usize) -> PyResult<Target> {
        let [position_weight, orientation_weight] =
            [(0, "position_weight"), (1, "orientation_weight")].map(|(half, name)| {
                let Some(value) = self.weights[half] else { return Ok([1.0; 3]) };
                let Numbers { values, shape } =
                    convert::numbers(value, name, "a number or three, one an axis")?;
                match (values[..].try_into(), &shape[..]) {
                    (_, []) => Ok([values[0]; 3]),
                    (Ok(three), [3]) => Ok(three),
                    _ => {
                        let found = convert::describe(value);
                        let message = format!("{name}: expected a number or three, one an axis, got {found}");
                        Err(PyValueError::new_err(message))
                    }
                }
            });
        let (position, orientation) = pose_of(self.pose)?;
        Ok(Target {
            at: self.at,
            point: self.point.map_or(Ok([0.0; 3]), |point| convert::array_of(point, "point"))?,
            position,
            orientation,
            weights: [position_weight?, orientation_weight?],
            ..Target::new(link)
        })
    }
}

/// A position, the rows of a rotation matrix, or both.
type Wanted = (Option<[f64; 3]>, Option<[[f64; 3]; 3]>);

fn pose_of(value: &Bound<'_, PyAny>) -> PyResult<Wanted> {
    const EXPECTED: &str =
        "a homogeneous matrix (4, 4), a position (3,), a rotation matrix (3, 3) or a quaternion (4,)";
    let Numbers { values, shape } = convert::numbers(value, "pose", EXPECTED)?;
    let rows = |stride: usize| std::array::from_fn(|i| std::array::from_fn(|j| values[stride * i + j]));
    match shape[..] {
        [3] => Ok((Some([values[0], values[1], values[2]]), None)),
        [4] => {
            let norm = values.iter().map(|x| x * x).sum::<f64>().sqrt();
            if norm.is_nan() || (norm - 1.0).abs() > QUATERNION_TOLERANCE {
                let message = format!(
                    "pose: got a quaternion of norm {norm}, expected a quaternion (w, x, y, z) of norm 1"
                );
                return Err(PyValueError::new_err(message));
            }
            let quaternion = Quaternion::from_array([values[0], values[1], values[2], values[3]]);
            let Rotation { x, y, z } = quaternion.rotation();
            Ok((None, Some([[x.x, y.x, z.x], [x.y, y.y, z.y], [x.z, y.z, z.z]])))
        }
        [3, 3] => Ok((None, Some(rows(3)))),
        [4, 4] => {
            let last = [values[12], values[13], values[14], values[15]];
            let is_last = last.iter().zip([0.0, 0.0, 0.0, 1.0]).all(|(x, y)| (x - y).abs() <= ROW_TOLERANCE);
            if !is_last {
                let [a, b, c, d] = last;
                let message = format!(
                    "pose[3]: got ({a}, {b}, {c}, {d}), expected (0, 0, 0, 1), the last row of a motion"
                );
                return Err(PyValueError::new_err(message));
            }
            Ok((Some([values[3], values[7], values[11]]), Some(rows(4))))
        }
        _ => {
            let message = format!("pose: expected {EXPECTED}, got {}", convert::describe(value));
            Err(PyValueError::new_err(message))
        }
    }
}

/// Returns an error if a target is invalid by itself.
#[pyfunction]
pub(crate) fn check_target(target: &Bound<'_, PyAny>) -> PyResult<()> {
    if target.getattr("link")?.cast::<PyString>().is_err() {
        let found = convert::describe(&target.getattr("link")?);
        return Err(PyTypeError::new_err(format!("link: expected the name of a link, got {found}")));
    }
    of_object(target, 0)?.validate().or_raise()
}

/// The target that an object with the attributes of `lissom.Target` describes.
fn of_object(object: &Bound<'_, PyAny>, link: usize) -> PyResult<Target> {
    let attribute = |name: &str| object.getattr(name);
    let at = attribute("X")?;
    let at = if at.is_none() { None } else { Some(convert::number(&at, "X")?) };
    let (pose, point) = (attribute("pose")?, attribute("point")?);
    let weights = [attribute("position_weight")?, attribute("orientation_weight")?];
    let weights = weights.each_ref().map(Some);
    PoseArguments { pose: &pose, at, point: Some(&point), weights }.target(link)
}

/// Targets with their names in messages, and whether a single target was given directly.
pub(super) struct Targets {
    pub(super) targets: Vec<Target>,
    pub(super) places: Vec<String>,
    pub(super) is_single: bool,
}

impl Targets {
    /// Targets for one link, from a mapping of links to poses, or from a sequence of `lissom.Target`. Errors
    /// refer to the name of this argument.
    pub(super) fn of(
        robot: &Robot,
        link: &Bound<'_, PyAny>,
        single: Option<&PoseArguments<'_, '_>>,
        argument: &str,
    ) -> PyResult<Self> {
        if link.is_none() || link.is_instance_of::<PyString>() {
            let name: Option<String> = link.extract()?;
            let index = robot.link_named(name.as_deref(), argument).or_raise()?;
            let Some(given) = single else {
                return Err(PyTypeError::new_err("pose: expected where the link shall be, got None"));
            };
            return Ok(Self {
                targets: vec![given.target(index)?],
                places: vec![String::new()],
                is_single: true,
            });
        }
        let mut all = Self { targets: Vec::new(), places: Vec::new(), is_single: false };
        if let Ok(mapping) = link.cast::<PyMapping>() {
            for item in mapping.items()? {
                let (name, pose): (Bound<'_, PyAny>, Bound<'_, PyAny>) = item.extract()?;
                let Ok(name) = name.extract::<String>() else {
                    let found = convert::describe(&name);
                    return Err(PyTypeError::new_err(format!(
                        "{argument}: expected names of links, got {found}"
                    )));
                };
                let given = PoseArguments { pose: &pose, at: None, point: None, weights: [None; 2] };
                all.push(robot, &name, format!("{argument}['{name}']"), |index| given.target(index))?;
            }
            return Ok(all);
        }
        let wrong = |found: &Bound<'_, PyAny>| {
            let found = convert::describe(found);
            let expected =
                "the name of a link, a mapping from links to poses, or a sequence of lissom.Target";
            PyTypeError::new_err(format!("{argument}: expected {expected}, got {found}"))
        };
        if convert::numbers(link, argument, "numbers").is_ok_and(|numbers| !numbers.values.is_empty()) {
            let error = wrong(link);
            return Err(PyTypeError::new_err(format!(
                "{}; a pose of the last link is the second argument: `reach(None, pose)`",
                error.value(link.py())
            )));
        }
        for (i, target) in link.try_iter().map_err(|_| wrong(link))?.enumerate() {
            let target = target?;
            if target.get_type().name()? != "Target" {
                return Err(wrong(&target));
            }
            let name: String = target.getattr("link")?.extract()?;
            all.push(robot, &name, format!("{argument}[{i}]"), |index| of_object(&target, index))?;
        }
        Ok(all)
    }

    fn push(
        &mut self,
        robot: &Robot,
        name: &str,
        place: String,
        target: impl FnOnce(usize) -> PyResult<Target>,
    ) -> PyResult<()> {
        let index = robot.link_named(Some(name), &place).or_raise()?;
        let target = target(index).map_err(|error| Python::attach(|py| placed(py, &error, &place)))?;
        self.targets.push(target);
        self.places.push(format!("{place}."));
        Ok(())
    }
}

/// Replaces the indices of targets in messages by their names.
pub(super) fn named(places: &[String], error: InvalidInput) -> InvalidInput {
    let named = |problem: Problem| {
        let inner = places.iter().enumerate().find_map(|(i, place)| {
            problem.place.strip_prefix(&format!("targets[{i}].")).map(|rest| format!("{place}{rest}"))
        });
        Problem { place: inner.unwrap_or(problem.place), ..problem }
    };
    InvalidInput { problems: error.problems.into_iter().map(named).collect() }
}

/// Adds a place to the message of an error.
fn placed(py: Python<'_>, error: &PyErr, place: &str) -> PyErr {
    let message = format!("{place}.{}", error.value(py));
    if error.is_instance_of::<PyTypeError>(py) {
        PyTypeError::new_err(message)
    } else {
        PyValueError::new_err(message)
    }
}

/// The other arguments of `Robot.reach`.
pub(super) struct ReachArguments<'a, 'py> {
    pub(super) q0: Option<&'a Bound<'py, PyAny>>,
    pub(super) bounds: Option<&'a Bound<'py, PyAny>>,
    pub(super) prefer: Option<&'a Bound<'py, PyAny>>,
    pub(super) tol: Option<f64>,
    pub(super) max_iter: Option<i64>,
    pub(super) restarts: Option<i64>,
}

impl ReachArguments<'_, '_> {
    fn options(&self, n: usize) -> PyResult<Options> {
        let defaults = Options::default();
        let count =
            |value: Option<i64>, name, default| value.map_or(Ok(default), |v| convert::count(v, name));
        Ok(Options {
            q0: self.q0.map(|q0| convert::finite_vector_of(q0, n, "q0")).transpose()?,
            bounds: self.bounds.map(|bounds| bounds_of(bounds, n)).transpose()?,
            prefer: self.prefer.map_or(Ok(Preference::Any), |prefer| preference_of(prefer, n))?,
            tol: self.tol.unwrap_or(defaults.tol),
            max_iter: count(self.max_iter, "max_iter", defaults.max_iter)?,
            restarts: count(self.restarts, "restarts", defaults.restarts)?,
        })
    }
}

/// Lower and upper bounds, each a number for all or one for every coordinate.
fn bounds_of(value: &Bound<'_, PyAny>, n: usize) -> PyResult<[Vec<f64>; 2]> {
    let wrong = || {
        let found = convert::describe(value);
        PyTypeError::new_err(format!("bounds: expected lower and upper bounds, (lower, upper), got {found}"))
    };
    let halves: Vec<Bound<'_, PyAny>> =
        value.try_iter().map_err(|_| wrong())?.take(3).collect::<PyResult<_>>()?;
    let [lower, upper] = halves.as_slice() else { return Err(wrong()) };
    let half = |value: &Bound<'_, PyAny>, name: &str| {
        let (values, is_number) = convert::scalar_or_vector(value, name)?;
        if is_number { Ok(vec![values[0]; n]) } else { convert::vector_of(value, n, name) }
    };
    Ok([half(lower, "bounds[0]")?, half(upper, "bounds[1]")?])
}

fn preference_of(value: &Bound<'_, PyAny>, n: usize) -> PyResult<Preference> {
    if let Ok(word) = value.cast::<PyString>() {
        return match word.to_str()? {
            "start" => Ok(Preference::Start),
            "energy" => Ok(Preference::Energy),
            word => Err(PyValueError::new_err(format!(
                "prefer: got {word:?}, expected \"start\", \"energy\", weights of the coordinates, or None"
            ))),
        };
    }
    Ok(Preference::Weights(convert::vector_of(value, n, "prefer")?))
}

/// Runs the search with its own copy of the model.
pub(super) fn search(
    py: Python<'_>,
    mut model: RobotModel,
    link: &Bound<'_, PyAny>,
    single: Option<&PoseArguments<'_, '_>>,
    arguments: &ReachArguments<'_, '_>,
) -> PyResult<PyReachResult> {
    let robot = model.description().clone();
    let targets = Targets::of(&robot, link, single, "link")?;
    let options = arguments.options(robot.coordinates())?;
    let of_search = targets.targets.clone();
    let n = robot.coordinates();
    let places = targets.places;
    let search = move |monitor: Monitor<'_>| {
        core::reach(&mut model, &of_search, &options, monitor).map_err(|error| named(&places, error))
    };
    run(py, n, search, |found| PyReachResult::new(py, &robot, found, targets.is_single))
}
