//! Coordinates of rods that follow points: `lissom.Robot.coordinates_of`, and its result.

#![allow(non_snake_case, reason = "X is the arc length of the unstretched rod everywhere in this field")]

use numpy::{IntoPyArray, PyArray1, PyUntypedArrayMethods};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use super::convert::{self, Numbers};
use super::record::{self, ReadOnly, Reduced};
use super::search::run;
use crate::analysis::curve as core;
use crate::analysis::curve::{Curve, Followed};
use crate::analysis::statics::Monitor;
use crate::numerics::lie::{QUATERNION_TOLERANCE, Quaternion, Rotation};
use crate::python::errors::OrRaise as _;
use crate::robot::Robot;

/// Result of `Robot.coordinates_of`: an array of the coordinates wherever one is expected, such as ``q0=``.
///
/// Attributes
/// ----------
/// q : ndarray, shape (n,)
///     Coordinates of the whole robot: those of the link follow the points, the others are those of `q0`.
/// success : bool
///     True if the coordinates are those of a best fit. How near that is say the distances.
/// status : str
///     'fitted', 'iteration_limit', 'stalled', 'unresolved', 'inverted' or 'collapsed' (the search led to shapes that the model
///     cannot represent), or 'interrupted' (in the `result` of a KeyboardInterrupt).
/// message : str
///     The status in words, with the distances, and what to change.
/// X : ndarray, shape (k,)
///     Arc lengths of the points on the unstretched rod, metres.
/// distance : ndarray, shape (k,)
///     Distance of each point from its section, metres.
/// angle : ndarray, shape (k,)
///     Angle of each frame from its section, radians; zero without frames.
/// largest_distance, rms_distance : float
///     The largest distance and the root mean square of all, metres.
/// nit, nfev, njev : int
///     Numbers of steps, evaluations of all distances, and Jacobians.
#[pyclass(name = "CurveResult", module = "lissom", frozen, get_all)]
#[derive(FromPyObject)]
pub(crate) struct PyCurveResult {
    q: ReadOnly<PyArray1<f64>>,
    success: bool,
    status: String,
    message: String,
    X: ReadOnly<PyArray1<f64>>,
    distance: ReadOnly<PyArray1<f64>>,
    angle: ReadOnly<PyArray1<f64>>,
    largest_distance: f64,
    rms_distance: f64,
    nit: usize,
    nfev: usize,
    njev: usize,
}

impl PyCurveResult {
    fn new(py: Python<'_>, q: Vec<f64>, found: Followed) -> PyResult<Self> {
        let (largest_distance, rms_distance) = (found.largest_distance(), found.rms_distance());
        let Followed { status, message, at, distances, angles, counters, .. } = found;
        Ok(Self {
            q: ReadOnly::new(q.into_pyarray(py))?,
            success: status.is_success(),
            status: status.name().to_owned(),
            message,
            X: ReadOnly::new(at.into_pyarray(py))?,
            distance: ReadOnly::new(distances.into_pyarray(py))?,
            angle: ReadOnly::new(angles.into_pyarray(py))?,
            largest_distance,
            rms_distance,
            nit: counters.iterations,
            nfev: counters.residuals,
            njev: counters.jacobians,
        })
    }
}

#[pymethods]
impl PyCurveResult {
    /// The coordinates, where NumPy expects an array.
    #[pyo3(signature = (dtype=None, copy=None))]
    fn __array__<'py>(
        &self,
        py: Python<'py>,
        dtype: Option<&Bound<'py, PyAny>>,
        copy: Option<bool>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let q = self.q.bind(py);
        match (dtype, copy) {
            (None, Some(false) | None) => Ok(q.clone().into_any()),
            (None, Some(true)) => q.call_method0("copy"),
            (Some(dtype), _) => q.call_method1("astype", (dtype,)),
        }
    }

    fn __repr__(&self, py: Python<'_>) -> String {
        let (q, status, largest) = (self.q.bind(py).len(), &self.status, self.largest_distance);
        format!("<CurveResult: {status}, {q} coordinates, at most {largest:.3e} m from the points>")
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

/// The arguments of `Robot.coordinates_of`.
pub(super) struct CurveArguments<'a, 'py> {
    pub(super) points: &'a Bound<'py, PyAny>,
    pub(super) frames: Option<&'a Bound<'py, PyAny>>,
    pub(super) x: Option<&'a Bound<'py, PyAny>>,
    pub(super) link: Option<&'a str>,
    pub(super) q0: Option<&'a Bound<'py, PyAny>>,
}

impl CurveArguments<'_, '_> {
    fn curve(&self) -> PyResult<Curve> {
        let rows_of_three = |value: &Bound<'_, PyAny>, name: &str| {
            let expected = "an array of shape (k, 3), metres";
            let Numbers { values, shape } = convert::numbers(value, name, expected)?;
            match shape[..] {
                [_, 3] => Ok(values.chunks_exact(3).map(|p| [p[0], p[1], p[2]]).collect::<Vec<_>>()),
                _ => Err(wrong_shape(value, name, expected)),
            }
        };
        Ok(Curve {
            points: rows_of_three(self.points, "points")?,
            frames: self.frames.map(frames_of).transpose()?,
            at: self.x.map(|x| convert::vector(x, "X")).transpose()?,
        })
    }
}

fn wrong_shape(value: &Bound<'_, PyAny>, name: &str, expected: &str) -> PyErr {
    PyValueError::new_err(format!("{name}: expected {expected}, got {}", convert::describe(value)))
}

/// The rows of rotation matrices.
fn frames_of(value: &Bound<'_, PyAny>) -> PyResult<Vec<[[f64; 3]; 3]>> {
    let expected = "rotation matrices, shape (k, 3, 3), or quaternions (w, x, y, z), shape (k, 4)";
    let Numbers { values, shape } = convert::numbers(value, "frames", expected)?;
    match shape[..] {
        [_, 3, 3] => {
            let rows = |m: &[f64]| std::array::from_fn(|i| std::array::from_fn(|j| m[3 * i + j]));
            Ok(values.chunks_exact(9).map(rows).collect())
        }
        [_, 4] => values.chunks_exact(4).enumerate().map(|(i, four)| matrix_of(four, i)).collect(),
        _ => Err(wrong_shape(value, "frames", expected)),
    }
}

/// The rotation of a quaternion.
fn matrix_of(four: &[f64], i: usize) -> PyResult<[[f64; 3]; 3]> {
    let norm = four.iter().map(|x| x * x).sum::<f64>().sqrt();
    if norm.is_nan() || (norm - 1.0).abs() > QUATERNION_TOLERANCE {
        let message = format!(
            "frames[{i}]: got a quaternion of norm {norm}, expected a quaternion (w, x, y, z) of norm 1"
        );
        return Err(PyValueError::new_err(message));
    }
    let quaternion = Quaternion::from_array([four[0], four[1], four[2], four[3]]);
    let Rotation { x, y, z } = quaternion.rotation();
    Ok([[x.x, y.x, z.x], [x.y, y.y, z.y], [x.z, y.z, z.z]])
}

/// The coordinates of a robot one of whose rods follows points.
pub(super) fn coordinates_of(
    py: Python<'_>,
    robot: &Robot,
    given: &CurveArguments<'_, '_>,
) -> PyResult<PyCurveResult> {
    let link = robot.link_named(given.link, "link").or_raise()?;
    let n = robot.coordinates();
    let mut q = given.q0.map_or(Ok(vec![0.0; n]), |q0| convert::finite_vector_of(q0, n, "q0"))?;
    let curve = given.curve()?;
    let own = robot.coordinates_of(link);
    let robot = robot.clone();
    let search = move |monitor: Monitor<'_>| core::coordinates_of(&robot, link, &curve, monitor);
    run(py, n, search, |found: Followed| {
        q[own].copy_from_slice(&found.q);
        PyCurveResult::new(py, q, found)
    })
}
