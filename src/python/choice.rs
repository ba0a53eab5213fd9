//! Modes that are chosen for an accuracy: `lissom.choose_modes`, and robots that leave their modes open.

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};

use super::arguments;
use super::callback::{Raised, with_result};
use super::convert;
use super::errors::{LissomError, OrRaise as _};
use super::model::PyModel;
use super::motion::signals;
use super::robot::PyRobot;
use super::rod::PyRod;
use crate::error::{Interrupted, InvalidInput};
use crate::python::words::required;
use crate::robot::Robot;
use crate::simulation::accuracy;
use crate::simulation::time_limit::TimeLimit;

/// A robot with modes that were chosen for what is computed with it.
pub(super) struct Chosen<'py> {
    /// The robot; without success that of the most accurate trial.
    pub(super) model: Bound<'py, PyModel>,
    /// The requested accuracy.
    pub(super) rtol: f64,
    /// Why the accuracy was not reached.
    pub(super) failure: Option<String>,
    /// The numbers of modes.
    pub(super) words: String,
    /// What stopped the trials, if anything did.
    pub(super) raised: PyResult<()>,
}

/// The segments whose modes are chosen: those that are open, or all.
fn open_or_all(robot: &Robot) -> Vec<usize> {
    let open = robot.open_segments();
    if open.is_empty() { (0..robot.segments().count()).collect() } else { open }
}

/// Chooses the modes of a robot for the equilibrium of a search, if an accuracy is requested or modes are open; `None` if there is nothing
/// to choose.
pub(super) fn for_equilibrium<'py>(
    model: &Bound<'py, PyModel>,
    rtol: Option<f64>,
    search: &accuracy::Search,
) -> PyResult<Option<Chosen<'py>>> {
    let Ok(robot) = model.cast::<PyRobot>() else {
        return rtol.map_or(Ok(None), |rtol| request(rtol).map(|_| None));
    };
    let description = robot.get().description();
    let has_none = description.segments().next().is_none();
    if has_none || rtol.is_none() && description.open_segments().is_empty() {
        return rtol.map_or(Ok(None), |rtol| request(rtol).map(|_| None));
    }
    let request = request(rtol.unwrap_or(accuracy::DEFAULT_RTOL))?;
    chosen(model, accuracy::Purpose::Search(search), request, None).map(Some)
}

/// Chooses open modes of a robot for its equilibrium and the lowest natural frequencies about it.
pub(super) fn for_vibrations<'py>(
    model: &Bound<'py, PyModel>,
    search: &accuracy::Search,
    count: usize,
) -> PyResult<Chosen<'py>> {
    let request = request(accuracy::DEFAULT_RTOL)?;
    choosing(model, request, None, |robot, open, monitor| {
        accuracy::choose_modes_for_vibrations(robot, open, search, count, request, monitor)
    })
}

/// Chooses the modes of a robot for its motion from rest, with these inputs.
pub(super) fn for_motion<'py>(
    model: &Bound<'py, PyModel>,
    t_span: (f64, f64),
    (rtol, dt): (f64, f64),
    u: Option<&[f64]>,
    limit: &mut TimeLimit,
) -> PyResult<Chosen<'py>> {
    let dt = if t_span.1 > t_span.0 { dt.min(t_span.1 - t_span.0) } else { dt };
    let request = accuracy::Request::new(rtol, dt);
    let purpose = u.map_or(accuracy::Purpose::Motion(t_span), |u| accuracy::Purpose::Held(t_span, u));
    chosen(model, purpose, request, Some(limit))
}

/// A valid request.
fn request(rtol: f64) -> PyResult<accuracy::Request> {
    let request = accuracy::Request::new(rtol, COMPARED_EVERY);
    request.validate().or_raise().map(|()| request)
}

fn chosen<'py>(
    model: &Bound<'py, PyModel>,
    purpose: accuracy::Purpose<'_>,
    request: accuracy::Request,
    limit: Option<&mut TimeLimit>,
) -> PyResult<Chosen<'py>> {
    choosing(model, request, limit, |robot, open, monitor| {
        accuracy::choose_modes(robot, open, purpose, request, monitor)
    })
}

fn choosing<'py>(
    model: &Bound<'py, PyModel>,
    request: accuracy::Request,
    mut limit: Option<&mut TimeLimit>,
    choose: impl FnOnce(
        &Robot,
        &[usize],
        &mut dyn FnMut(f64) -> Result<(), Interrupted>,
    ) -> Result<accuracy::Modes, InvalidInput>
    + Send,
) -> PyResult<Chosen<'py>> {
    let py = model.py();
    let description = model.cast::<PyRobot>()?.get().description();
    let open = open_or_all(description);
    let mut raised = Raised::default();
    let found = py.detach(|| {
        let mut signals = signals(&mut raised);
        choose(description, &open, &mut |t| {
            // A trial may be at the end of its motion, but it is not the last one.
            limit.as_mut().map_or(Ok(()), |limit| limit.check(f64::NEG_INFINITY))?;
            signals(t)
        })
    });
    let modes = found.map_err(with_python_names).or_raise()?;
    Ok(Chosen {
        model: like(model.as_any(), &modes.robot)?.cast_into()?,
        rtol: request.rtol,
        failure: (!modes.is_success).then_some(modes.message),
        words: accuracy::in_words(&modes.robot, &open),
        raised: raised.into_result(),
    })
}

/// The Python object for a robot: a Rod if the original is one, with the chosen modes.
pub(super) fn like<'py>(original: &Bound<'py, PyAny>, robot: &Robot) -> PyResult<Bound<'py, PyAny>> {
    let py = original.py();
    match original.cast::<PyRod>() {
        Ok(rod) => {
            let rod = rod.get().description().with_segments_of(robot);
            Ok(Bound::new(py, PyRod::initializer(rod)?)?.into_any())
        }
        Err(_) => Ok(Bound::new(py, PyRobot::initializer(robot.clone())?)?.into_any()),
    }
}

/// Interval of the times at which trials are compared by default, in seconds.
const COMPARED_EVERY: f64 = 1e-2;

/// Choose the numbers of modes of a rod or robot for a requested accuracy of a motion or an equilibrium.
///
/// Trials with more modes of each strain show which modes move the tip; these are kept. In equilibria, and in robots with closed
/// loops or supports, those are kept that move any quarter of a segment. Strains that a perfectly symmetric motion does not excite
/// get no modes. The cost is that of about five to fifteen simulations, or equilibria.
///
/// Parameters
/// ----------
/// rod : Rod or Robot
///     Model whose numbers of modes are replaced.
/// t_end : float, optional
///     End of the trial runs, seconds. They start at `t0` with zero coordinates and velocities. By default modes are chosen for the
///     equilibrium at `t0` that `statics` finds without a start.
/// rtol : float
///     Largest error of the measured places due to the modes, relative to the rod's length.
/// dt : float
///     Interval of the times at which runs are compared, seconds. Not for equilibria.
/// segments : sequence of int, optional
///     Segments whose modes are chosen, counted link by link; by default those that are described with ``modes="auto"``, or all of them if
///     there are none.
/// t0 : float
///     Start of the trial runs, or time of the equilibrium, seconds.
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
///
/// For an equilibrium:
///
/// >>> bent = lissom.choose_modes(lissom.Rod([wire], tip_force=(0, 0, -1)), rtol=1e-5)
/// >>> lissom.statics(bent).space_error.relative < 1e-5
/// True
#[pyfunction]
#[pyo3(
    signature = (rod=None, t_end=None, *more, rtol=accuracy::DEFAULT_RTOL, dt=None, segments=None, t0=0.0, **others),
    text_signature = "(rod, t_end=None, *, rtol=0.0001, dt=0.01, segments=None, t0=0.0)"
)]
#[allow(clippy::too_many_arguments, reason = "keyword-only options of a Python function")]
pub(crate) fn choose_modes<'py>(
    #[pyo3(from_py_with = rod_of)] rod: Option<&Bound<'py, PyRobot>>,
    #[pyo3(from_py_with = arguments::given_number::t_end)] t_end: Option<f64>,
    more: &Bound<'_, PyTuple>,
    #[pyo3(from_py_with = arguments::number::rtol)] rtol: f64,
    #[pyo3(from_py_with = arguments::optional_number::dt)] dt: Option<f64>,
    #[pyo3(from_py_with = arguments::segments)] segments: Option<Vec<usize>>,
    #[pyo3(from_py_with = arguments::number::t0)] t0: f64,
    others: Option<&Bound<'_, PyDict>>,
) -> PyResult<Bound<'py, PyAny>> {
    let rod = required!("choose_modes", others; more, rod);
    let description = rod.get().description();
    let segments = segments.unwrap_or_else(|| open_or_all(description));
    let purpose = match t_end {
        Some(t_end) => accuracy::Purpose::Motion((t0, t_end)),
        None if dt.is_some() => {
            return Err(PyValueError::new_err(
                "dt: only for motions, which end at `t_end`: leave `dt` out, or give `t_end`",
            ));
        }
        None => accuracy::Purpose::Equilibrium(t0),
    };
    let request = accuracy::Request::new(rtol, dt.unwrap_or(COMPARED_EVERY));
    let mut raised = Raised::default();
    let chosen = rod.py().detach(|| {
        accuracy::choose_modes(description, &segments, purpose, request, &mut signals(&mut raised))
    });
    let modes = chosen.map_err(with_python_names).or_raise()?;
    if let Err(error) = raised.into_result() {
        let py = rod.py();
        return Err(with_result(py, error, || like(rod.as_any(), &modes.robot)));
    }
    if !modes.is_success {
        return Err(LissomError::new_err(modes.message));
    }
    like(rod.as_any(), &modes.robot)
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
fn rod_of<'a, 'py>(value: &'a Bound<'py, PyAny>) -> PyResult<Option<&'a Bound<'py, PyRobot>>> {
    convert::instance(value, "rod", "lissom.Rod").map(Some)
}
