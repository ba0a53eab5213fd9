//! `lissom.Support`.

use pyo3::prelude::*;
use pyo3::types::PyDict;

use super::arguments;
use super::convert;
use super::load::on;
use crate::support::Support;

/// Springs and dampers between a section of a rod and a fixed pose in the world, its anchor.
///
/// For small angles the rotational springs are linear; a rotation by any angle about a single axis of the anchor gives the
/// moment ``rotational_stiffness * sin(angle)``. ``rotational_stiffness=(0, k, k)`` holds the direction of the rod and leaves
/// its twist free, through any number of turns.
///
/// Parameters
/// ----------
/// stiffness : float or array_like, shape (3,)
///     Stiffness along the axes of the anchor, newtons per metre; one number applies to all three.
/// rotational_stiffness : float or array_like, shape (3,)
///     Stiffness about the axes of the anchor, newton metres per radian.
/// damping, rotational_damping : float or array_like, shape (3,)
///     Viscous damping along and about the axes of the anchor, newton seconds per metre and newton metre seconds per radian.
/// at : float, optional
///     Arc length of the supported section on the unstretched rod, metres; by default the tip.
/// position : array_like, shape (3,), optional
///     Position of the anchor in the world, metres; by default that of the section when all coordinates are zero and the base is
///     at ``base_position``, without base motion.
/// orientation : array_like, shape (4,), optional
///     Orientation of the anchor: unit quaternion (w, x, y, z) that maps its axes to world axes; by default that of the section
///     at this shape, with the x axis along the rod.
/// link : str, optional
///     Supported link of a `Robot`; optional if there is only one. `at` is an arc length of its rod.
///
/// Raises
/// ------
/// ValueError
///     If parameters are invalid; the message lists all of them. `Rod` and `Robot` check that `at` is on the rod.
///
/// Examples
/// --------
/// >>> import lissom
/// >>> wire = lissom.Segment(0.4, 1e-3, 2e11, 8e10, 7800, {"bend_y": 5})
/// >>> prop = lissom.Support(stiffness=(0, 0, 1e4))
/// >>> rod = lissom.Rod([wire], supports=[prop])
#[pyclass(name = "Support", module = "lissom", frozen, eq)]
#[derive(Clone, PartialEq)]
pub(crate) struct PySupport {
    pub(crate) support: Support,
    pub(crate) link: Option<String>,
}

#[pymethods]
impl PySupport {
    #[new]
    #[pyo3(
        signature = (*, stiffness=None, rotational_stiffness=None, damping=None, rotational_damping=None, at=None, position=None, orientation=None, link=None),
        text_signature = "(*, stiffness=0.0, rotational_stiffness=0.0, damping=0.0, rotational_damping=0.0, at=None, position=None, orientation=None, link=None)"
    )]
    #[allow(clippy::too_many_arguments, reason = "the signature of the Python class")]
    fn new(
        stiffness: Option<&Bound<'_, PyAny>>,
        rotational_stiffness: Option<&Bound<'_, PyAny>>,
        damping: Option<&Bound<'_, PyAny>>,
        rotational_damping: Option<&Bound<'_, PyAny>>,
        #[pyo3(from_py_with = arguments::optional_number::at)] at: Option<f64>,
        position: Option<&Bound<'_, PyAny>>,
        orientation: Option<&Bound<'_, PyAny>>,
        #[pyo3(from_py_with = arguments::optional_name::link)] link: Option<String>,
    ) -> PyResult<Self> {
        let support = Support {
            link: 0,
            at,
            stiffness: per_axis(stiffness, "stiffness")?,
            rotational_stiffness: per_axis(rotational_stiffness, "rotational_stiffness")?,
            damping: per_axis(damping, "damping")?,
            rotational_damping: per_axis(rotational_damping, "rotational_damping")?,
            position: position.map(|value| convert::array_of(value, "position")).transpose()?,
            orientation: orientation.map(|value| convert::array_of(value, "orientation")).transpose()?,
        };
        // The length of the rod is not known yet.
        support.validate(f64::INFINITY)?;
        Ok(Self { support, link })
    }

    /// Stiffness along the axes of the anchor, newtons per metre.
    #[getter]
    fn stiffness(&self) -> (f64, f64, f64) {
        self.support.stiffness.into()
    }

    /// Rotational stiffness about the axes of the anchor, newton metres per radian.
    #[getter]
    fn rotational_stiffness(&self) -> (f64, f64, f64) {
        self.support.rotational_stiffness.into()
    }

    /// Damping along the axes of the anchor, newton seconds per metre.
    #[getter]
    fn damping(&self) -> (f64, f64, f64) {
        self.support.damping.into()
    }

    /// Damping of rotation about the axes of the anchor, newton metre seconds per radian.
    #[getter]
    fn rotational_damping(&self) -> (f64, f64, f64) {
        self.support.rotational_damping.into()
    }

    /// Arc length of the supported section, metres; None for the tip.
    #[getter]
    fn at(&self) -> Option<f64> {
        self.support.at
    }

    /// Position of the anchor in the world, metres; None for the position of the section when all coordinates
    /// are zero.
    #[getter]
    fn position(&self) -> Option<(f64, f64, f64)> {
        self.support.position.map(Into::into)
    }

    /// Orientation of the anchor, quaternion (w, x, y, z) as given; None for the orientation of the section
    /// when all coordinates are zero.
    #[getter]
    fn orientation(&self) -> Option<(f64, f64, f64, f64)> {
        self.support.orientation.map(Into::into)
    }

    /// Name of the supported link; None on a rod.
    #[getter]
    fn link(&self) -> Option<&str> {
        self.link.as_deref()
    }

    fn __repr__(&self) -> String {
        let mut parts = vec![
            format!("stiffness={:?}", self.stiffness()),
            format!("rotational_stiffness={:?}", self.rotational_stiffness()),
            format!("damping={:?}", self.damping()),
            format!("rotational_damping={:?}", self.rotational_damping()),
        ];
        parts.extend(self.at().map(|x| format!("at={x:?}")));
        parts.extend(self.position().map(|position| format!("position={position:?}")));
        parts.extend(self.orientation().map(|orientation| format!("orientation={orientation:?}")));
        format!("Support({}{})", parts.join(", "), on(&self.link))
    }

    /// For copies and pickles.
    fn __getnewargs_ex__<'py>(&self, py: Python<'py>) -> PyResult<((), Bound<'py, PyDict>)> {
        let arguments = PyDict::new(py);
        arguments.set_item("stiffness", self.stiffness())?;
        arguments.set_item("rotational_stiffness", self.rotational_stiffness())?;
        arguments.set_item("damping", self.damping())?;
        arguments.set_item("rotational_damping", self.rotational_damping())?;
        arguments.set_item("at", self.at())?;
        arguments.set_item("position", self.position())?;
        arguments.set_item("orientation", self.orientation())?;
        arguments.set_item("link", self.link())?;
        Ok(((), arguments))
    }
}

/// Three numbers, or one for all three.
fn per_axis(value: Option<&Bound<'_, PyAny>>, name: &str) -> PyResult<[f64; 3]> {
    let Some(value) = value else { return Ok([0.0; 3]) };
    match convert::number_if_one(value, name)? {
        Some(number) => Ok([number; 3]),
        None => convert::array_of(value, name),
    }
}
