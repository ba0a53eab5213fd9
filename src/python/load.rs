//! `lissom.Load` and `lissom.Body`.

use numpy::PyArray2;
use pyo3::class::{PyTraverseError, PyVisit};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use super::arguments;
use super::convert;
use super::signal::{Functions, signal_of, signal_out};
use crate::body::{Body, Hull};
use crate::error::Checker;
use crate::load::{Extent, Frame, Load};
use crate::signal::Signal;

/// A force and a moment on a rod, at a point or distributed along a part of it.
///
/// Parameters
/// ----------
/// force : array_like, shape (3,); or (times, values), Harmonic or callable
///     Force, newtons; newtons per metre of the unstretched rod if distributed. A time-dependent force is a table (`times` in
///     seconds, `values` of shape (m, 3), interpolated linearly and held constant outside), a `Harmonic`, or a function of
///     the time in seconds that returns three numbers.
/// moment : array_like, shape (3,); or (times, values), Harmonic or callable
///     Moment, newton metres; newton metres per metre if distributed. Takes the same forms as `force`.
/// at : float, optional
///     Arc length of the unstretched rod where the load acts, metres; by default the tip.
/// along : (float, float), optional
///     Arc lengths between which the load is distributed uniformly, instead of acting at a point.
/// frame : {'world', 'body'}
///     Axes of `force` and `moment`: 'world' for a load of constant direction (a dead load), or 'body' for a load that rotates
///     with its section (a follower load).
/// link : str, optional
///     Link of a `Robot` on which the load acts; optional if there is only one. `at` and `along` refer to its rod.
///
/// Raises
/// ------
/// ValueError
///     If parameters are invalid; the message lists all of them. `Rod` and `Robot` check that `at` and `along` are on the rod.
///
/// Examples
/// --------
/// >>> import lissom
/// >>> wind = lissom.Load(force=(0, 0.2, 0), along=(0, 0.4))
/// >>> thrust = lissom.Load(force=(-1, 0, 0), frame="body")
/// >>> knock = lissom.Load(force=([0.0, 0.01, 0.02], [[0, 0, 0], [0, 0, 5], [0, 0, 0]]), at=0.2)
/// >>> wire = lissom.Segment(0.4, 1e-3, 2e11, 8e10, 7800, {"bend_y": 3, "bend_z": 3})
/// >>> rod = lissom.Rod([wire], loads=[wind, thrust, knock])
#[pyclass(name = "Load", module = "lissom", frozen, eq)]
pub(crate) struct PyLoad {
    load: Load,
    link: Option<String>,
    functions: Functions,
}

impl PartialEq for PyLoad {
    fn eq(&self, other: &Self) -> bool {
        self.load == other.load && self.link == other.link
    }
}

impl PyLoad {
    pub(super) fn of(py: Python<'_>, load: &Load, link: Option<String>) -> PyResult<Self> {
        // Compare without the index of the link, whose name is known.
        let load = Load { link: 0, ..load.clone() };
        Ok(Self { functions: Functions::of_load(py, &load)?, load, link })
    }

    /// Name of the link.
    pub(super) fn link(&self) -> Option<&str> {
        self.link.as_deref()
    }

    pub(super) fn load(&self) -> &Load {
        &self.load
    }
}

#[pymethods]
impl PyLoad {
    #[new]
    #[pyo3(
        signature = (*, force=None, moment=None, at=None, along=None, frame="world", link=None),
        text_signature = "(*, force=(0, 0, 0), moment=(0, 0, 0), at=None, along=None, frame='world', link=None)"
    )]
    fn new(
        force: Option<&Bound<'_, PyAny>>,
        moment: Option<&Bound<'_, PyAny>>,
        #[pyo3(from_py_with = arguments::optional_number::at)] at: Option<f64>,
        along: Option<&Bound<'_, PyAny>>,
        #[pyo3(from_py_with = arguments::text::frame)] frame: &str,
        #[pyo3(from_py_with = arguments::optional_name::link)] link: Option<String>,
    ) -> PyResult<Self> {
        let mut check = Checker::new();
        check.require(at.is_none() || along.is_none(), "along", "both at and along", "one of them");
        check.require(
            force.is_some() || moment.is_some(),
            "force",
            "neither force nor moment",
            "one of them, or both",
        );
        let frame = match frame {
            "world" => Frame::World,
            "body" => Frame::Body,
            other => {
                check.require(false, "frame", format_args!("'{other}'"), "'world' or 'body'");
                Frame::World
            }
        };
        let extent = match (at, along) {
            (Some(x), _) => Extent::At(x),
            (None, Some(along)) => Extent::Along(convert::array_of(along, "along")?),
            (None, None) => Extent::Tip,
        };
        let mut functions = Functions::default();
        let mut signal = |value: Option<&Bound<'_, PyAny>>, name| {
            value.map_or(Ok(Signal::default()), |value| signal_of(value, name, &mut functions))
        };
        let load = Load {
            link: 0,
            extent,
            frame,
            force: signal(force, "force")?,
            moment: signal(moment, "moment")?,
        };
        // The length of the rod is not known yet.
        check.all(load.validate(f64::INFINITY));
        check.finish()?;
        Ok(Self { load, link, functions })
    }

    /// Force in newtons, or newtons per metre; a time-dependent force in the form in which it was given.
    #[getter]
    fn force<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        signal_out(py, &self.load.force)
    }

    /// Moment in newton metres, or newtons; a time-dependent moment in the form in which it was given.
    #[getter]
    fn moment<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        signal_out(py, &self.load.moment)
    }

    /// Arc length where the load acts, metres; None for the tip or a distributed load.
    #[getter]
    fn at(&self) -> Option<f64> {
        if let Extent::At(x) = self.load.extent { Some(x) } else { None }
    }

    /// Arc lengths between which the load is distributed, metres, or None.
    #[getter]
    fn along(&self) -> Option<(f64, f64)> {
        if let Extent::Along(ends) = self.load.extent { Some(ends.into()) } else { None }
    }

    /// Axes of force and moment: 'world' or 'body'.
    #[getter]
    fn frame(&self) -> &'static str {
        match self.load.frame {
            Frame::World => "world",
            Frame::Body => "body",
        }
    }

    /// Name of the link on which the load acts; None on a rod.
    #[getter(link)]
    fn link_name(&self) -> Option<&str> {
        self.link()
    }

    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        let place = match self.load.extent {
            Extent::Tip => String::new(),
            Extent::At(x) => format!(", at={x:?}"),
            Extent::Along([from, to]) => format!(", along=({from:?}, {to:?})"),
        };
        let (force, moment, frame) = (self.force(py)?.repr()?, self.moment(py)?.repr()?, self.frame());
        Ok(format!("Load(force={force}, moment={moment}{place}, frame='{frame}'{})", on(&self.link)))
    }

    /// For copies and pickles.
    fn __getnewargs_ex__<'py>(&self, py: Python<'py>) -> PyResult<((), Bound<'py, PyDict>)> {
        let arguments = PyDict::new(py);
        arguments.set_item("force", self.force(py)?)?;
        arguments.set_item("moment", self.moment(py)?)?;
        arguments.set_item("at", self.at())?;
        arguments.set_item("along", self.along())?;
        arguments.set_item("frame", self.frame())?;
        arguments.set_item("link", self.link())?;
        Ok(((), arguments))
    }

    fn __traverse__(&self, visit: PyVisit<'_>) -> Result<(), PyTraverseError> {
        self.functions.traverse(&visit)
    }
}

/// A rigid body fixed to a section of a rod.
///
/// Parameters
/// ----------
/// mass : float
///     Mass, kilograms.
/// at : float, optional
///     Arc length of the unstretched rod at which the body is fixed, metres; by default the tip.
/// link : str, optional
///     Link of a `Robot` to which the body is fixed, unless the body belongs to a `Link` itself.
/// centre : array_like, shape (3,)
///     Centre of mass relative to the section's centre, in the section's axes, metres.
/// inertia : array_like, shape (3,) or (3, 3)
///     Inertia tensor about the centre of mass in the section's axes, kg m^2, or its diagonal.
/// volume : float
///     Displaced volume, cubic metres: what the `Fluid` of the rod or robot bears, and what has an added mass. By default
///     zero: the fluid does not bear the body.
/// centre_of_volume : array_like, shape (3,), optional
///     Centre of the volume, where the fluid acts, in the axes of `centre`, metres; by default `centre`.
/// added_mass_coefficient : float
///     Added mass over the displaced mass, the same in all directions; by default 0.5, that of a sphere in an inviscid fluid.
/// drag_area : float
///     Reference area A of the quadratic drag ``density / 2 * drag_coefficient * A * |v| * v``, square metres.
/// drag_coefficient : float
///     Coefficient of the quadratic drag; by default one.
/// viscous_drag : float
///     Drag over velocity, newton seconds per metre; ``6 * pi * viscosity * radius`` for a small sphere (Stokes 1851).
///
/// Raises
/// ------
/// ValueError
///     If parameters are invalid, such as an inertia tensor that no body can have; the message lists all of them.
///
/// Examples
/// --------
/// >>> import lissom
/// >>> gripper = lissom.Body(0.1, centre=(0.03, 0, 0), inertia=(2e-5, 5e-5, 5e-5))
/// >>> wire = lissom.Segment(0.4, 1e-3, 2e11, 8e10, 7800, {"bend_y": 3})
/// >>> rod = lissom.Rod([wire], bodies=[gripper, lissom.Body(0.01, at=0.2)])
/// >>> buoy = lissom.Body(0.5, volume=8e-4, drag_area=0.01, drag_coefficient=0.47)
#[pyclass(name = "Body", module = "lissom", frozen, eq)]
#[derive(Clone, PartialEq)]
pub(crate) struct PyBody {
    pub(crate) body: Body,
    pub(crate) link: Option<String>,
}

/// The name of a link as a further argument.
pub(super) fn on(link: &Option<String>) -> String {
    link.as_ref().map_or(String::new(), |link| format!(", link='{link}'"))
}

impl PyBody {
    fn hull(&self) -> Hull {
        self.body.hull.unwrap_or_else(Hull::none)
    }
}

#[pymethods]
impl PyBody {
    #[new]
    #[pyo3(
        signature = (
            mass, *, at=None, centre=None, inertia=None, link=None, volume=0.0, centre_of_volume=None,
            added_mass_coefficient=0.5, drag_area=0.0, drag_coefficient=1.0, viscous_drag=0.0
        ),
        text_signature = "(mass, *, at=None, centre=(0, 0, 0), inertia=(0, 0, 0), link=None, volume=0.0, centre_of_volume=None, \
                          added_mass_coefficient=0.5, drag_area=0.0, drag_coefficient=1.0, viscous_drag=0.0)"
    )]
    #[allow(clippy::too_many_arguments, reason = "keyword-only options of a Python function")]
    fn new(
        #[pyo3(from_py_with = arguments::number::mass)] mass: f64,
        #[pyo3(from_py_with = arguments::optional_number::at)] at: Option<f64>,
        centre: Option<&Bound<'_, PyAny>>,
        inertia: Option<&Bound<'_, PyAny>>,
        #[pyo3(from_py_with = arguments::optional_name::link)] link: Option<String>,
        #[pyo3(from_py_with = arguments::number::volume)] volume: f64,
        centre_of_volume: Option<&Bound<'_, PyAny>>,
        #[pyo3(from_py_with = arguments::number::added_mass_coefficient)] added_mass_coefficient: f64,
        #[pyo3(from_py_with = arguments::number::drag_area)] drag_area: f64,
        #[pyo3(from_py_with = arguments::number::drag_coefficient)] drag_coefficient: f64,
        #[pyo3(from_py_with = arguments::number::viscous_drag)] viscous_drag: f64,
    ) -> PyResult<Self> {
        let centre_of_volume =
            centre_of_volume.map(|centre| convert::array_of(centre, "centre_of_volume")).transpose()?;
        let hull = Hull {
            volume,
            centre: centre_of_volume,
            added_mass_coefficient,
            drag_area,
            drag_coefficient,
            viscous_drag,
        };
        let mut body = Body { at, hull: hull.unless_none(), ..Body::point(mass) };
        if let Some(centre) = centre {
            body.centre = convert::array_of(centre, "centre")?;
        }
        if let Some(inertia) = inertia {
            body.inertia = convert::symmetric_of(inertia, "inertia")?;
        }
        body.validate(f64::INFINITY)?;
        Ok(Self { body, link })
    }

    /// Mass in kilograms.
    #[getter]
    fn mass(&self) -> f64 {
        self.body.mass
    }

    /// Arc length where the body is fixed, metres; None for the tip.
    #[getter]
    fn at(&self) -> Option<f64> {
        self.body.at
    }

    /// Centre of mass in the section's axes, metres.
    #[getter]
    fn centre(&self) -> (f64, f64, f64) {
        self.body.centre.into()
    }

    /// Inertia tensor about the centre of mass in the section's axes, shape (3, 3), kg m^2.
    #[getter]
    fn inertia<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let rows: Vec<Vec<f64>> = self.body.inertia.iter().map(|row| row.to_vec()).collect();
        Ok(PyArray2::from_vec2(py, &rows)?)
    }

    /// Displaced volume, cubic metres.
    #[getter]
    fn volume(&self) -> f64 {
        self.hull().volume
    }

    /// Centre of the volume in the section's axes, metres; None for the centre of mass.
    #[getter]
    fn centre_of_volume(&self) -> Option<(f64, f64, f64)> {
        self.hull().centre.map(Into::into)
    }

    /// Added mass over the displaced mass.
    #[getter]
    fn added_mass_coefficient(&self) -> f64 {
        self.hull().added_mass_coefficient
    }

    /// Reference area of the quadratic drag, square metres.
    #[getter]
    fn drag_area(&self) -> f64 {
        self.hull().drag_area
    }

    /// Coefficient of the quadratic drag.
    #[getter]
    fn drag_coefficient(&self) -> f64 {
        self.hull().drag_coefficient
    }

    /// Drag over velocity, newton seconds per metre.
    #[getter]
    fn viscous_drag(&self) -> f64 {
        self.hull().viscous_drag
    }

    /// Name of the link to which the body is fixed; None on a rod, and for the body of a link itself.
    #[getter]
    fn link(&self) -> Option<&str> {
        self.link.as_deref()
    }

    fn __repr__(&self) -> String {
        let Body { at, mass, inertia, .. } = &self.body;
        let at = at.map_or(String::new(), |x| format!(", at={x:?}"));
        let Hull { volume, drag_area, viscous_drag, .. } = self.hull();
        let mut hull = String::new();
        for (name, value) in [("volume", volume), ("drag_area", drag_area), ("viscous_drag", viscous_drag)] {
            if value != 0.0 {
                hull += &format!(", {name}={value:?}");
            }
        }
        format!("Body({mass:?}{at}, centre={:?}, inertia={inertia:?}{}{hull})", self.centre(), on(&self.link))
    }

    /// For copies and pickles.
    fn __getnewargs_ex__<'py>(&self, py: Python<'py>) -> PyResult<((f64,), Bound<'py, PyDict>)> {
        let arguments = PyDict::new(py);
        arguments.set_item("at", self.at())?;
        arguments.set_item("centre", self.centre())?;
        arguments.set_item("inertia", self.body.inertia)?;
        arguments.set_item("link", self.link())?;
        if self.body.hull.is_some() {
            arguments.set_item("volume", self.volume())?;
            arguments.set_item("centre_of_volume", self.centre_of_volume())?;
            arguments.set_item("added_mass_coefficient", self.added_mass_coefficient())?;
            arguments.set_item("drag_area", self.drag_area())?;
            arguments.set_item("drag_coefficient", self.drag_coefficient())?;
            arguments.set_item("viscous_drag", self.viscous_drag())?;
        }
        Ok(((self.body.mass,), arguments))
    }
}
