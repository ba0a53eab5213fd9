//! `lissom.BaseMotion`.

use pyo3::class::{PyTraverseError, PyVisit};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use super::arguments;
use super::convert;
use super::signal::{Functions, signal_of, signal_out};
use crate::error::Checker;
use crate::world::{BaseMotion, BaseRotation};

/// Prescribed motion of the base of a rod, as a function of time.
///
/// The base is at ``base_position + translation(t)``. Its axes are those of ``base_orientation``, rotated by ``rotation(t)``
/// or by ``angle(t)`` about `axis`.
///
/// Parameters
/// ----------
/// translation : (times, values), (times, values, interpolation), Harmonic or callable
///     Displacement in world axes, three numbers, metres; by default zero.
/// axis : array_like, shape (3,), optional
///     Axis of the rotation in world axes. Its length does not matter.
/// angle : (times, values), (times, values, interpolation), Harmonic or callable
///     Angle about `axis`, one number, radians.
/// rotation : (times, values), (times, values, interpolation) or callable, optional
///     Rotation in world axes as a unit quaternion (w, x, y, z), instead of `axis` and `angle`.
///
/// Raises
/// ------
/// ValueError
///     If parameters are invalid; the message lists all of them.
///
/// Notes
/// -----
/// The motion needs velocities and accelerations. A table is interpolated by a twice continuously differentiable cubic
/// spline (quaternions in R^4 and normalised; consecutive ones must differ by less than a right angle) and must cover the
/// time of a run. Its interpolation may also be 'monotone', by cubic pieces that do not overshoot and have a continuous
/// velocity (PCHIP; Fritsch and Butland 1984), or 'linear', held constant outside: the velocity then jumps at corners, and
/// velocities of the model jump by the impulse (``docs/time.md``). A callable returns the value, or a tuple of value, velocity and acceleration: for `translation` in m/s and
/// m/s^2, for `angle` in rad/s and rad/s^2, for `rotation` the angular velocity and angular acceleration in world axes, three
/// numbers each. Without derivatives they are computed by finite differences (nine values or more, up to 4 ms before and
/// after). A ValueError that names the time is raised if values are not finite, quaternions do not have norm 1, or derivatives
/// cannot be found or contradict the values; in a run, its attribute `result` is the partial result.
///
/// Examples
/// --------
/// >>> import lissom
/// >>> blade = lissom.Segment(1.0, 0.01, 7e10, 2.6e10, 2700, {"bend_z": 4})
/// >>> rotor = lissom.BaseMotion(axis=(0, 0, 1), angle=lissom.Harmonic(rate=20.0))
/// >>> lissom.Rod([blade], base_motion=rotor).kernel
/// 'planar'
/// >>> shaken = lissom.BaseMotion(translation=lissom.Harmonic((0, 0.01, 0), 5.0))
/// >>> rod = lissom.Rod([blade], base_motion=shaken)
#[pyclass(name = "BaseMotion", module = "lissom", frozen, eq)]
pub(crate) struct PyBaseMotion {
    motion: BaseMotion,
    functions: Functions,
}

impl PartialEq for PyBaseMotion {
    fn eq(&self, other: &Self) -> bool {
        self.motion == other.motion
    }
}

impl PyBaseMotion {
    pub(super) fn of(py: Python<'_>, motion: &BaseMotion) -> PyResult<Self> {
        Ok(Self { functions: Functions::of_motion(py, motion)?, motion: motion.clone() })
    }

    pub(super) fn motion(&self) -> &BaseMotion {
        &self.motion
    }
}

#[pymethods]
impl PyBaseMotion {
    #[new]
    #[pyo3(
        signature = (*, translation=None, axis=None, angle=None, rotation=None),
        text_signature = "(*, translation=(0, 0, 0), axis=None, angle=None, rotation=None)"
    )]
    fn new(
        translation: Option<&Bound<'_, PyAny>>,
        axis: Option<&Bound<'_, PyAny>>,
        angle: Option<&Bound<'_, PyAny>>,
        rotation: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Self> {
        let mut check = Checker::new();
        check.require(
            rotation.is_none() || (axis.is_none() && angle.is_none()),
            "rotation",
            "both rotation and axis or angle",
            "one of the two ways",
        );
        check.require(angle.is_none() || axis.is_some(), "axis", "none", "the axis of the angle");
        check.require(axis.is_none() || angle.is_some(), "angle", "none", "an angle about the axis");
        check.finish()?;
        let mut motion = BaseMotion::rest();
        let mut functions = Functions::default();
        if let Some(translation) = translation {
            motion.translation = signal_of(translation, "translation", &mut functions)?;
        }
        if let (Some(axis), Some(angle)) = (axis, angle) {
            let axis = convert::array_of(axis, "axis")?;
            let angle = signal_of(angle, "angle", &mut functions)?;
            motion.rotation = BaseRotation::About { axis, angle };
        }
        if let Some(rotation) = rotation {
            motion.rotation = BaseRotation::By(signal_of(rotation, "rotation", &mut functions)?);
        }
        motion.validate()?;
        Ok(Self { motion, functions })
    }

    /// Displacement in world axes, metres, as given.
    #[getter]
    fn translation<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        signal_out(py, &self.motion.translation)
    }

    /// Axis of the rotation in world axes; None without one.
    #[getter]
    fn axis(&self) -> Option<(f64, f64, f64)> {
        match &self.motion.rotation {
            BaseRotation::About { axis, angle } if !angle.is_zero() => Some((*axis).into()),
            _ => None,
        }
    }

    /// Angle about the axis, radians, as given; None without one.
    #[getter]
    fn angle<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyAny>>> {
        match &self.motion.rotation {
            BaseRotation::About { angle, .. } if !angle.is_zero() => signal_out(py, angle).map(Some),
            _ => Ok(None),
        }
    }

    /// Quaternions of the rotation, as given; None where it is about an axis.
    #[getter]
    fn rotation<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyAny>>> {
        match &self.motion.rotation {
            BaseRotation::By(quaternion) => signal_out(py, quaternion).map(Some),
            BaseRotation::About { .. } => Ok(None),
        }
    }

    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        let mut text = format!("BaseMotion(translation={}", self.translation(py)?.repr()?);
        if let (Some(axis), Some(angle)) = (self.axis(), self.angle(py)?) {
            text += &format!(", axis={axis:?}, angle={}", angle.repr()?);
        }
        if let Some(rotation) = self.rotation(py)? {
            text += &format!(", rotation={}", rotation.repr()?);
        }
        Ok(text + ")")
    }

    /// For copies and pickles.
    fn __getnewargs_ex__<'py>(&self, py: Python<'py>) -> PyResult<((), Bound<'py, PyDict>)> {
        let arguments = PyDict::new(py);
        arguments.set_item("translation", self.translation(py)?)?;
        arguments.set_item("axis", self.axis())?;
        arguments.set_item("angle", self.angle(py)?)?;
        arguments.set_item("rotation", self.rotation(py)?)?;
        Ok(((), arguments))
    }

    fn __traverse__(&self, visit: PyVisit<'_>) -> Result<(), PyTraverseError> {
        self.functions.traverse(&visit)
    }
}

/// The argument `base_motion`.
pub(super) fn optional_motion<'a, 'py>(
    value: &'a Bound<'py, PyAny>,
) -> PyResult<Option<&'a Bound<'py, PyBaseMotion>>> {
    arguments::optional(value, "base_motion", |value, name| {
        convert::instance(value, name, "lissom.BaseMotion or None")
    })
}
