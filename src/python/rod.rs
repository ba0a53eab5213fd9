//! `lissom.Rod`.

use std::sync::Arc;

use pyo3::class::{PyTraverseError, PyVisit};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};

use super::actuation::actuators_of;
use super::arguments;
use super::contact::contacts_of;
use super::convert;
use super::part::{parts_of, wrapped};
use super::robot::{PyRobot, optional_fluid, optional_motion};
use super::segment::{segments_of, segments_out};
use super::signal::Functions;
use crate::description::body::described::Body;
use crate::description::schema::LinkName;
use crate::description::world::described::BaseMotion;
use crate::error::InvalidInput;
use crate::robot::effects::fluid::Fluid;
use crate::robot::effects::load::described::Load;
use crate::robot::effects::support::described::Support;
use crate::robot::{Named, Robot, Rod};

/// A Cosserat rod that is clamped at its base: a sequence of segments with loads and rigid bodies.
///
/// The coordinates are the amplitudes of the strain modes, ordered by segment, then by strain (torsion, bend_y, bend_z,
/// stretch, shear_y, shear_z), then by mode (the degree of a Legendre polynomial). With piecewise constant strain, each
/// piece counts as a segment of its own in this order.
///
/// Parameters
/// ----------
/// segments : sequence of Segment
///     Segments from base to tip, at least one.
/// base_position : array_like, shape (3,)
///     Position of the base, metres.
/// base_orientation : array_like, shape (4,)
///     Orientation of the base: unit quaternion (w, x, y, z) that maps body axes to world axes. The rod starts along the body
///     x axis.
/// gravity : array_like, shape (3,)
///     Acceleration of gravity in world axes, metres per second squared.
/// tip_force, tip_moment : array_like, shape (3,)
///     Dead loads at the tip in world axes, newtons and newton metres. A dead moment has no potential, so `energy` does not
///     include it.
/// tip_mass : float
///     Point mass at the tip, kilograms.
/// loads : sequence of Load
///     Additional forces and moments, anywhere on the rod.
/// bodies : sequence of Body
///     Additional rigid bodies, anywhere on the rod.
/// base_motion : BaseMotion, optional
///     Motion of the base relative to its position and orientation. By default the base is fixed.
/// supports : sequence of Support
///     Springs and dampers to the world, anywhere on the rod.
/// fluid : Fluid, optional
///     Fluid around the rod. By default there is none.
/// actuators : sequence of Tendon, Chamber, Motor, ActiveStrain
///     The actuators of the rod.
/// contacts : sequence of Contact
///     Contacts of the rod, which they name as the link "rod".
///
/// Raises
/// ------
/// ValueError
///     If parameters are invalid; the message lists all of them.
#[pyclass(name = "Rod", module = "lissom", extends = PyRobot, frozen)]
pub(crate) struct PyRod {
    description: Rod,
    // The base class has its own functions. A class without a traversal would share that of `Model`; PyO3
    // 0.30 then calls it recursively without end.
    functions: Functions,
}

impl PyRod {
    /// The description of the rod.
    pub(crate) fn description(&self) -> &Rod {
        &self.description
    }

    /// The Python objects that own the functions of this rod must still be alive.
    pub(crate) fn initializer(description: Rod) -> PyResult<PyClassInitializer<Self>> {
        description.validate()?;
        let robot = Robot::from(&description);
        let functions = Python::attach(|py| Functions::of_robot(py, &robot))?;
        Ok(PyRobot::initializer(robot)?.add_subclass(Self { description, functions }))
    }
}

#[pymethods]
impl PyRod {
    #[new]
    #[pyo3(signature = (segments, base_position=None, base_orientation=None, gravity=None, tip_force=None, tip_moment=None, tip_mass=0.0, *, loads=None, bodies=None, base_motion=None, supports=None, fluid=None, actuators=None, contacts=None),
           text_signature = "(segments, base_position=(0, 0, 0), base_orientation=(1, 0, 0, 0), gravity=(0, 0, -9.81), tip_force=(0, 0, 0), tip_moment=(0, 0, 0), tip_mass=0.0, *, loads=(), bodies=(), base_motion=None, supports=(), fluid=None, actuators=(), contacts=())")]
    #[allow(clippy::too_many_arguments, reason = "the signature of the Python class")]
    fn new(
        segments: &Bound<'_, PyAny>,
        base_position: Option<&Bound<'_, PyAny>>,
        base_orientation: Option<&Bound<'_, PyAny>>,
        gravity: Option<&Bound<'_, PyAny>>,
        tip_force: Option<&Bound<'_, PyAny>>,
        tip_moment: Option<&Bound<'_, PyAny>>,
        #[pyo3(from_py_with = arguments::number::tip_mass)] tip_mass: f64,
        loads: Option<&Bound<'_, PyAny>>,
        bodies: Option<&Bound<'_, PyAny>>,
        #[pyo3(from_py_with = optional_motion)] base_motion: Option<BaseMotion>,
        supports: Option<&Bound<'_, PyAny>>,
        #[pyo3(from_py_with = optional_fluid)] fluid: Option<Fluid>,
        actuators: Option<&Bound<'_, PyAny>>,
        contacts: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<PyClassInitializer<Self>> {
        let segments = segments_of(segments, "segments")?;
        let mut rod = Rod { tip_mass, fluid, ..Rod::new(segments) };
        // Items on a rod do not name a link.
        let mut named = Vec::new();
        // The arguments own the functions until the rod does; iterators keep none of what they give.
        let mut functions = Functions::default();
        if let Some(loads) = loads {
            let loads: Vec<Load> = parts_of(loads, "loads", &mut functions)?;
            named.extend(loads.iter().map(|load| ("loads", load.link.clone())));
            rod.loads = loads.iter().map(|load| load.resolved(0)).collect();
        }
        if let Some(bodies) = bodies {
            let bodies: Vec<Body> = parts_of(bodies, "bodies", &mut functions)?;
            named.extend(bodies.iter().map(|body| ("bodies", body.link.clone())));
            rod.bodies = bodies.iter().map(|body| body.resolved(0)).collect();
        }
        rod.base_motion = base_motion.map(|motion| motion.resolved());
        if let Some(supports) = supports {
            let supports: Vec<Support> = parts_of(supports, "supports", &mut functions)?;
            named.extend(supports.iter().map(|support| ("supports", support.link.clone())));
            rod.supports = supports.iter().map(|support| support.resolved(0)).collect();
        }
        if let Some((what, Some(LinkName(link)))) = named.into_iter().find(|(_, link)| link.is_some()) {
            let found = format_args!("'{link}' in {what}");
            return Err(
                InvalidInput::new("link", found, "none: a rod is one link, a Robot has several").into()
            );
        }
        let mut vectors = [
            (base_position, &mut rod.base_position, "base_position"),
            (gravity, &mut rod.gravity, "gravity"),
            (tip_force, &mut rod.tip_force, "tip_force"),
            (tip_moment, &mut rod.tip_moment, "tip_moment"),
        ];
        for (value, field, name) in &mut vectors {
            if let Some(value) = value {
                **field = convert::array_of(value, name)?;
            }
        }
        if let Some(orientation) = base_orientation {
            rod.base_orientation = convert::array_of(orientation, "base_orientation")?;
        }
        if let Some(actuators) = actuators {
            let robot = Robot::from(&rod);
            rod.actuators = actuators_of(actuators, &Named::of_rod(&robot), &mut functions)?;
        }
        if let Some(contacts) = contacts {
            rod.contacts = contacts_of(contacts, &Named::of(&Robot::from(&rod)))?;
        }
        Self::initializer(rod)
    }

    /// The segments, from base to tip.
    #[getter]
    fn segments<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyTuple>> {
        segments_out(py, &self.description.segments)
    }

    /// Length of the unstretched rod, metres.
    #[getter]
    fn length(&self) -> f64 {
        self.description.length()
    }

    /// Position of the base, metres.
    #[getter]
    fn base_position(&self) -> (f64, f64, f64) {
        self.description.base_position.into()
    }

    /// Orientation of the base, quaternion (w, x, y, z) as given.
    #[getter]
    fn base_orientation(&self) -> (f64, f64, f64, f64) {
        self.description.base_orientation.into()
    }

    /// Dead force at the tip in world axes, newtons.
    #[getter]
    fn tip_force(&self) -> (f64, f64, f64) {
        self.description.tip_force.into()
    }

    /// Dead moment at the tip in world axes, newton metres.
    #[getter]
    fn tip_moment(&self) -> (f64, f64, f64) {
        self.description.tip_moment.into()
    }

    /// Point mass at the tip, kilograms.
    #[getter]
    fn tip_mass(&self) -> f64 {
        self.description.tip_mass
    }

    /// Additional loads.
    #[getter]
    fn loads<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyTuple>> {
        let loads = self.description.loads.iter().map(|load| wrapped(py, Arc::new(load.described(None))));
        PyTuple::new(py, loads.collect::<PyResult<Vec<_>>>()?)
    }

    /// Additional rigid bodies.
    #[getter]
    fn bodies<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyTuple>> {
        let bodies = self.description.bodies.iter().map(|body| wrapped(py, Arc::new(body.described(None))));
        PyTuple::new(py, bodies.collect::<PyResult<Vec<_>>>()?)
    }

    fn __repr__(&self) -> String {
        let segments = self.description.segments.len();
        let plural = if segments == 1 { "" } else { "s" };
        format!(
            "<lissom.Rod of {segments} segment{plural}, {:?} m long, n = {}>",
            self.description.length(),
            self.description.coordinates()
        )
    }

    /// For copies and pickles.
    fn __getnewargs_ex__<'py>(
        slf: &Bound<'py, Self>,
    ) -> PyResult<((Bound<'py, PyTuple>,), Bound<'py, PyDict>)> {
        let (py, this, robot) = (slf.py(), slf.get(), slf.as_super().get());
        let rod = &this.description;
        let arguments = PyDict::new(py);
        arguments.set_item("base_position", rod.base_position)?;
        arguments.set_item("base_orientation", rod.base_orientation)?;
        arguments.set_item("gravity", rod.gravity)?;
        arguments.set_item("tip_force", rod.tip_force)?;
        arguments.set_item("tip_moment", rod.tip_moment)?;
        arguments.set_item("tip_mass", rod.tip_mass)?;
        arguments.set_item("loads", this.loads(py)?)?;
        arguments.set_item("bodies", this.bodies(py)?)?;
        arguments.set_item("base_motion", robot.base_motion(py)?)?;
        arguments.set_item("supports", robot.supports(py)?)?;
        arguments.set_item("fluid", robot.fluid(py)?)?;
        arguments.set_item("actuators", robot.actuators(py)?)?;
        arguments.set_item("contacts", robot.contacts(py)?)?;
        Ok(((this.segments(py)?,), arguments))
    }

    fn __traverse__(&self, visit: PyVisit<'_>) -> Result<(), PyTraverseError> {
        self.functions.traverse(&visit)
    }
}
