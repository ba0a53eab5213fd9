//! `lissom.Robot`.

use std::sync::{Arc, Mutex, OnceLock, PoisonError};

use numpy::{IntoPyArray, PyArray1, PyArrayMethods};
use pyo3::IntoPyObjectExt;
use pyo3::class::{PyTraverseError, PyVisit};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList, PySlice, PyString, PyTuple};

use super::actuation::{actuator_index, actuators_of, actuators_out};
use super::arguments;
use super::callback::or_raised;
use super::contact::{contact_index, contacts_of, contacts_out};
use super::convert;
use super::errors::check_finite;
use super::link::index_of;
use super::loops::{loop_index, loops_of, loops_out};
use super::model::{PyModel, check_time, time_of_state};
use super::part::{optional_part, parts_of, resolved, wrapped};
use super::reach::{self, PyReachResult};
use super::signal::{Functions, signal_of, signal_out};
use crate::description::body::described::Body;
use crate::description::rod::arc_length::is_on_rod;
use crate::description::schema::{LinkName, Reader};
use crate::description::world::described::BaseMotion;
use crate::error::InvalidInput;
use crate::model::{Dynamics as _, InTime as _, Tied as _};
use crate::numerics::lie::Vector;
use crate::numerics::linalg::Matrix;
use crate::robot::described::Link;
use crate::robot::effects::actuator::Actuator;
use crate::robot::effects::fluid::Fluid;
use crate::robot::effects::load::described::Load;
use crate::robot::effects::loops::Tie;
use crate::robot::effects::magnet::described::Magnet;
use crate::robot::effects::support::described::Support;
use crate::robot::{Kernel, LinkNames, Multiplications, Named, Place, Robot, RobotModel, Touching};

/// Number of poses computed between checks for signals; for the largest rods this takes some milliseconds.
const POSES_BETWEEN_SIGNALS: usize = 256;

/// A moment and a force, or another pair of vectors, as six numbers.
fn flat(halves: [Vector<f64>; 2]) -> Vec<f64> {
    halves.into_iter().flat_map(Vector::to_array).collect()
}

/// A robot: a tree of links, each of which is a joint followed by a rod or a rigid body, with loads, actuators, loops and
/// contacts.
///
/// Coordinates are ordered by link, in the order of `links`. Within a link, those of the joint come first, then the strain
/// modes of the rod: by segment, then by strain (torsion, bend_y, bend_z, stretch, shear_y, shear_z), then by mode.
/// Velocities are the time derivatives of the coordinates, also for rotation vectors. A `Rod` is a robot with one link,
/// welded to the world.
///
/// Parameters
/// ----------
/// links : sequence of Link
///     Links, parents before their children, at least one.
/// gravity : array_like, shape (3,)
///     Acceleration of gravity in world axes, metres per second squared.
/// loads : sequence of Load
///     Forces and moments. Each names its link.
/// bodies : sequence of Body
///     Additional rigid bodies on links; each one names its link.
/// supports : sequence of Support
///     Springs and dampers to the world; each one names its link.
/// fluid : Fluid, optional
///     The fluid around the rods; none by default. It does not act on rigid links.
/// base_motion : BaseMotion, optional
///     Motion of everything that is fixed to the world, about the frame of the first link's joint. By default it is at rest.
/// loops : sequence of Loop
///     Joints that close loops of links.
/// contacts : sequence of Contact
///     Pairs of surfaces that can touch.
/// actuators : sequence of Tendon, Chamber, Motor, ActiveStrain
///     The actuators of the robot.
/// magnets : sequence of Magnet
///     Magnetic dipoles on links; each one names its link. They act on each other, and on magnetised segments of other links.
/// field : array_like, shape (3,), or a function of time or an input
///     Uniform magnetic field in world axes, tesla, at magnets and magnetised segments. Takes the forms of a `Load`'s `force`.
///
/// Raises
/// ------
/// ValueError
///     If parameters are invalid; the message lists all of them.
///
/// Examples
/// --------
/// A double pendulum of a rigid and a soft link:
///
/// >>> import lissom
/// >>> soft = lissom.Segment(0.5, 5e-3, 1e7, poisson_ratio=0.5, density=1100, modes={"bend_y": 3})
/// >>> hinge = lissom.Revolute((0, 1, 0))
/// >>> robot = lissom.Robot([
/// ...     lissom.Link("upper", body=lissom.Body(0.2, centre=(0.25, 0, 0)), joint=hinge),
/// ...     lissom.Link("lower", rod=[soft], joint=hinge, parent="upper", position=(0.5, 0, 0)),
/// ... ])
/// >>> robot.coordinates
/// ('upper.angle', 'lower.angle', 'lower.bend_y[0]', 'lower.bend_y[1]', 'lower.bend_y[2]')
#[pyclass(name = "Robot", module = "lissom", extends = PyModel, subclass, frozen)]
pub(crate) struct PyRobot {
    description: Robot,
    functions: Functions,
    // A separate model for kinematics; the base class knows its model only as a Model.
    kinematics: Mutex<RobotModel>,
    // The wrench that keeps a planar robot in its plane is known only to a spatial model, compiled on first
    // use.
    spatial: OnceLock<RobotModel>,
}

/// Times and inputs of states as passed from Python.
#[derive(Clone, Copy, Default)]
struct At<'a, 'py> {
    t: Option<&'a Bound<'py, PyAny>>,
    u: Option<&'a Bound<'py, PyAny>>,
    /// Whether forces are requested; the loads at that time then matter.
    is_of_forces: bool,
}

impl<'a, 'py> At<'a, 'py> {
    /// For quantities that do not depend on forces.
    fn time(t: Option<&'a Bound<'py, PyAny>>) -> Self {
        Self { t, u: None, is_of_forces: false }
    }

    /// For forces.
    fn forces(t: Option<&'a Bound<'py, PyAny>>, u: Option<&'a Bound<'py, PyAny>>) -> Self {
        Self { t, u, is_of_forces: true }
    }
}

/// The inputs of states: m numbers for all states, or m for each.
fn inputs_of_states(u: &Bound<'_, PyAny>, m: usize, states: Option<usize>) -> PyResult<Vec<f64>> {
    let (inputs, rows) = convert::finite_rows_of(u, m, "u")?;
    if rows.is_some() && rows != states {
        let found = convert::describe(u);
        let expected = states
            .map_or_else(|| format!("shape ({m},)"), |states| format!("shape ({m},) or ({states}, {m})"));
        return Err(PyValueError::new_err(format!("u: expected {expected}, got {found}")));
    }
    Ok(inputs)
}

/// States as passed from Python, with argument names: coordinates, and velocities and accelerations if
/// needed.
type States<'a, 'py> = [Option<(&'a Bound<'py, PyAny>, &'a str)>; 3];

impl PyRobot {
    /// The description of the robot.
    pub(crate) fn description(&self) -> &Robot {
        &self.description
    }

    /// The Python objects that own the functions of this robot must still be alive.
    pub(crate) fn initializer(description: Robot) -> PyResult<PyClassInitializer<Self>> {
        Python::attach(|py| {
            let functions = Functions::of_robot(py, &description)?;
            let (model, kinematics) = py.detach(|| {
                let model = RobotModel::new(&description)?;
                let kinematics = Mutex::new(model.clone());
                Ok::<_, InvalidInput>((PyModel::new(model), kinematics))
            })?;
            Ok(PyClassInitializer::from(model).add_subclass(Self {
                description,
                functions,
                kinematics,
                spatial: OnceLock::new(),
            }))
        })
    }

    /// Returns an error if the place is not on the link.
    pub(super) fn check_place(&self, link: usize, x: Option<f64>) -> PyResult<()> {
        let Some(x) = x else { return Ok(()) };
        let link = &self.description.links[link];
        let length = link.length();
        if !link.rod.is_empty() && is_on_rod(x, length) {
            return Ok(());
        }
        Err(PyValueError::new_err(match link.rod.is_empty() {
            true => format!("X: got {x}, expected None: link '{}' has no rod", link.name),
            false => format!("X: got {x}, expected an arc length in [0, {length}] (metres)"),
        }))
    }

    /// Arc lengths on a link, and whether a single number was given; several places add a dimension to the
    /// result.
    fn arc_lengths(
        &self,
        given: Option<&Bound<'_, PyAny>>,
        link: usize,
    ) -> PyResult<(Vec<Option<f64>>, bool)> {
        let (places, is_number) = match given {
            Some(given) => {
                let (places, is_number) = convert::scalar_or_vector(given, "X")?;
                (places.into_iter().map(Some).collect(), is_number)
            }
            None => (vec![None], true),
        };
        places.iter().try_for_each(|&x| self.check_place(link, x))?;
        Ok((places, is_number))
    }

    /// The sections of a link's rod at these arc lengths, and the shape of a result with six numbers for
    /// each.
    fn sections(
        &self,
        model: &RobotModel,
        given: Option<&Bound<'_, PyAny>>,
        link: Option<&str>,
    ) -> PyResult<(Vec<Place>, Vec<usize>)> {
        let index = index_of(&self.description, link, "link")?;
        let (places, is_number) = self.arc_lengths(given, index)?;
        let links = &self.description.links;
        if links[index].rod.is_empty() {
            let rods = links.iter().filter(|link| !link.rod.is_empty());
            let names = rods.map(|link| format!("'{}'", link.name)).collect::<Vec<_>>().join(", ");
            let expected =
                if names.is_empty() { ", but no link has one".to_owned() } else { format!(": {names}") };
            let found = &links[index].name;
            return Err(PyValueError::new_err(format!(
                "link: got '{found}', which has no rod, expected a link with one{expected}"
            )));
        }
        let sections: Vec<_> = places.into_iter().map(|x| model.place_on(index, x)).collect();
        let shape = (!is_number).then_some(sections.len()).into_iter().chain([6]).collect();
        Ok((sections, shape))
    }

    /// A copy of the model.
    pub(super) fn model(&self) -> RobotModel {
        self.kinematics.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// Evaluates `of` for every state of `model`; each result has the shape `shape`.
    fn of_states<'py>(
        &self,
        mut model: RobotModel,
        states: States<'_, 'py>,
        at: At<'_, 'py>,
        name: &str,
        shape: &[usize],
        mut of: impl FnMut(&mut RobotModel, [&[f64]; 3]) -> Vec<f64>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let At { t, u, is_of_forces } = at;
        let robot = &self.description;
        let depends_on_time = if is_of_forces { robot.depends_on_time() } else { robot.is_moved() };
        let takes_time = is_of_forces || robot.is_prescribed();
        let n = self.description.coordinates();
        let mut parts: [Vec<f64>; 3] = Default::default();
        let mut number: Option<Option<usize>> = None;
        let mut py = None;
        for (part, given) in parts.iter_mut().zip(states) {
            let Some((value, place)) = given else { continue };
            py = Some(value.py());
            let (rows, number_of_states) = convert::finite_rows_of(value, n, place)?;
            if *number.get_or_insert(number_of_states) != number_of_states {
                let found = convert::describe(value);
                return Err(PyValueError::new_err(format!("{place}: expected the shape of q, got {found}")));
            }
            *part = rows;
        }
        let (number, py) = (number.flatten(), py.expect("coordinates are always given"));
        let times = self.times(t, number, depends_on_time)?;
        let inputs = u.map(|u| inputs_of_states(u, model.facts().inputs(), number)).transpose()?;
        let rows = number.unwrap_or(1);
        let mut values = Vec::new();
        for row in 0..rows {
            if row > 0 && row.is_multiple_of(POSES_BETWEEN_SIGNALS) {
                py.check_signals()?;
            }
            if let Some(inputs) = &inputs {
                let m = model.facts().inputs();
                model.set_inputs(inputs.get(row * m..(row + 1) * m).unwrap_or(inputs));
            }
            if takes_time {
                or_raised(model.set_time(times[row % times.len()]))?;
            }
            let state = parts.each_ref().map(|part| part.get(row * n..(row + 1) * n).unwrap_or(&[]));
            values.extend(of(&mut model, state));
        }
        check_finite(&values, name)?;
        let shape: Vec<usize> = number.into_iter().chain(shape.iter().copied()).collect();
        if shape.is_empty() {
            return values[0].into_bound_py_any(py);
        }
        Ok(values.into_pyarray(py).reshape(shape)?.into_any())
    }

    /// The time interval over which the prescribed motions are defined.
    fn span(&self) -> [f64; 2] {
        self.kinematics.lock().unwrap_or_else(PoisonError::into_inner).facts().time_span
    }

    /// A copy of the spatial model.
    fn spatial(&self) -> PyResult<RobotModel> {
        if let Some(model) = self.spatial.get() {
            return Ok(model.clone());
        }
        let model = RobotModel::spatial(&self.description)?;
        Ok(self.spatial.get_or_init(|| model).clone())
    }

    /// The time of each state, or one time for all.
    fn times(
        &self,
        t: Option<&Bound<'_, PyAny>>,
        states: Option<usize>,
        depends_on_time: bool,
    ) -> PyResult<Vec<f64>> {
        let Some(t) = t else {
            return time_of_state(None, depends_on_time).map(|t| vec![t]);
        };
        let (times, is_number) = convert::scalar_or_vector(t, "t")?;
        if !is_number && Some(times.len()) != states {
            let expected =
                states.map_or("a number".to_owned(), |k| format!("a number or {k} times, one a state"));
            return Err(PyValueError::new_err(format!(
                "t: expected {expected}, got {}",
                convert::describe(t)
            )));
        }
        times.iter().try_for_each(|&t| check_time(t, self.span()))?;
        Ok(times)
    }
}

#[pymethods]
impl PyRobot {
    #[new]
    #[pyo3(signature = (links, *, gravity=None, loads=None, bodies=None, supports=None, fluid=None, base_motion=None, actuators=None, loops=None, contacts=None, magnets=None, field=None),
           text_signature = "(links, *, gravity=(0, 0, -9.81), loads=(), bodies=(), supports=(), fluid=None, base_motion=None, actuators=(), loops=(), contacts=(), magnets=(), field=(0, 0, 0))")]
    #[allow(clippy::too_many_arguments, reason = "the signature of the Python class")]
    fn new(
        links: &Bound<'_, PyAny>,
        gravity: Option<&Bound<'_, PyAny>>,
        loads: Option<&Bound<'_, PyAny>>,
        bodies: Option<&Bound<'_, PyAny>>,
        supports: Option<&Bound<'_, PyAny>>,
        #[pyo3(from_py_with = optional_fluid)] fluid: Option<Fluid>,
        #[pyo3(from_py_with = optional_motion)] base_motion: Option<BaseMotion>,
        actuators: Option<&Bound<'_, PyAny>>,
        loops: Option<&Bound<'_, PyAny>>,
        contacts: Option<&Bound<'_, PyAny>>,
        magnets: Option<&Bound<'_, PyAny>>,
        field: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<PyClassInitializer<Self>> {
        let py = links.py();
        // The arguments own the functions until the robot does; iterators keep none of what they give.
        let mut functions = Functions::default();
        let links: Vec<Link> = parts_of(links, "links", &mut functions)?;
        let names = LinkNames::new(links.iter().map(|link| link.name.as_str()), false);
        let mut place = 0..;
        let links =
            resolved(py, "links", &links, |link, reader| Some(names.resolved(place.next()?, link, reader)))?;
        let mut robot = Robot::new(links);
        if let Some(gravity) = gravity {
            robot.gravity = convert::array_of(gravity, "gravity")?;
        }
        let named = Named::of(&robot);
        let on =
            |link: &Option<LinkName>, reader: &mut Reader| named.only_link("link", link.as_ref(), reader);
        let (mut all_loads, mut all_bodies, mut all_supports) = (Vec::new(), Vec::new(), Vec::new());
        if let Some(loads) = loads {
            let loads: Vec<Load> = parts_of(loads, "loads", &mut functions)?;
            all_loads = resolved(py, "loads", &loads, |it, reader| Some(it.resolved(on(&it.link, reader)?)))?;
        }
        if let Some(bodies) = bodies {
            let bodies: Vec<Body> = parts_of(bodies, "bodies", &mut functions)?;
            all_bodies =
                resolved(py, "bodies", &bodies, |it, reader| Some(it.resolved(on(&it.link, reader)?)))?;
        }
        if let Some(supports) = supports {
            let supports: Vec<Support> = parts_of(supports, "supports", &mut functions)?;
            all_supports =
                resolved(py, "supports", &supports, |it, reader| Some(it.resolved(on(&it.link, reader)?)))?;
        }
        let mut all_magnets = Vec::new();
        if let Some(magnets) = magnets {
            let magnets: Vec<Magnet> = parts_of(magnets, "magnets", &mut functions)?;
            all_magnets =
                resolved(py, "magnets", &magnets, |it, reader| Some(it.resolved(on(&it.link, reader)?)))?;
        }
        let mut all_actuators = Vec::new();
        if let Some(actuators) = actuators {
            all_actuators = actuators_of(actuators, &named, &mut functions)?;
        }
        let all_loops = loops.map_or(Ok(Vec::new()), |loops| loops_of(loops, &named))?;
        let all_contacts = contacts.map_or(Ok(Vec::new()), |contacts| contacts_of(contacts, &named))?;
        (robot.loads, robot.bodies, robot.supports) = (all_loads, all_bodies, all_supports);
        (robot.actuators, robot.loops, robot.contacts) = (all_actuators, all_loops, all_contacts);
        robot.magnets = all_magnets;
        if let Some(field) = field {
            robot.field = signal_of(field, "field", &mut functions)?;
        }
        robot.fluid = fluid;
        robot.base_motion = base_motion.map(|motion| motion.resolved());
        Self::initializer(robot)
    }

    /// Create a robot from a URDF file and additional links.
    ///
    /// Parameters
    /// ----------
    /// path : str or path-like
    ///     The URDF file. Run `xacro` on a xacro file first.
    /// **options
    ///     Options of `lissom.urdf.robot_from_urdf`: `floating`, `limit_stiffness`, `mend_inertia`, additional `links`, and
    ///     parameters of `Robot`.
    ///
    /// Returns
    /// -------
    /// Robot
    ///
    /// Raises
    /// ------
    /// UrdfError
    ///     If the file is invalid; the message lists all problems.
    ///
    /// Warns
    /// -----
    /// UrdfWarning
    ///     If the file has content that the robot does not include.
    #[staticmethod]
    #[pyo3(signature = (path, **options))]
    fn from_urdf<'py>(
        path: &Bound<'py, PyAny>,
        options: Option<&Bound<'py, PyDict>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let module = path.py().import("lissom.urdf")?;
        module.getattr("robot_from_urdf")?.call((path,), options)
    }

    /// The links, parents before their children.
    #[getter]
    fn links<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyTuple>> {
        let robot = &self.description;
        let links = robot.links.iter().map(|link| wrapped(py, Arc::new(robot.described_link(link))));
        PyTuple::new(py, links.collect::<PyResult<Vec<_>>>()?)
    }

    /// Names of the coordinates: the name of the link, a dot, and the name of the coordinate within the link.
    #[getter]
    fn coordinates<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyTuple>> {
        PyTuple::new(py, self.description.coordinate_names())
    }

    /// Slice of a link's coordinates: ``q[robot.slice("left")]``.
    ///
    /// Parameters
    /// ----------
    /// link : str
    ///     Name of the link.
    ///
    /// Returns
    /// -------
    /// slice
    fn slice<'py>(
        &self,
        py: Python<'py>,
        #[pyo3(from_py_with = arguments::text::link)] link: &str,
    ) -> PyResult<Bound<'py, PySlice>> {
        let range = self.description.coordinates_of(index_of(&self.description, Some(link), "link")?);
        Ok(PySlice::new(py, range.start.cast_signed(), range.end.cast_signed(), 1))
    }

    /// Gravity in the world, metres per second squared.
    #[getter]
    fn gravity(&self) -> (f64, f64, f64) {
        self.description.gravity.into()
    }

    /// The loads.
    #[getter]
    fn loads<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyTuple>> {
        let loads = &self.description.loads;
        let out = loads.iter().map(|load| wrapped(py, Arc::new(load.described(self.name_of(load.link)))));
        PyTuple::new(py, out.collect::<PyResult<Vec<_>>>()?)
    }

    /// Additional rigid bodies.
    #[getter]
    fn bodies<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyTuple>> {
        let bodies = &self.description.bodies;
        let out = bodies.iter().map(|body| wrapped(py, Arc::new(body.described(self.name_of(body.link)))));
        PyTuple::new(py, out.collect::<PyResult<Vec<_>>>()?)
    }

    /// Springs and dampers to the world.
    #[getter]
    pub(super) fn supports<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyTuple>> {
        let out = self.description.supports.iter().map(|support| {
            let link = self.name_of(support.link);
            wrapped(py, Arc::new(support.described(link)))
        });
        PyTuple::new(py, out.collect::<PyResult<Vec<_>>>()?)
    }

    /// Fluid around the rods, or None.
    #[getter]
    pub(super) fn fluid<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyAny>>> {
        self.description.fluid.clone().map(|fluid| wrapped(py, Arc::new(fluid))).transpose()
    }

    /// The motion of the base; None if it is fixed.
    #[getter]
    pub(super) fn base_motion<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyAny>>> {
        let motion = self.description.base_motion.as_ref();
        motion.map(|motion| wrapped(py, Arc::new(motion.described()))).transpose()
    }

    /// The actuators of the robot.
    #[getter]
    pub(super) fn actuators<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyTuple>> {
        actuators_out(py, &self.description)
    }

    /// Joints that close loops of links.
    #[getter]
    fn loops<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyTuple>> {
        loops_out(py, &self.description)
    }

    /// Pairs of surfaces that can touch.
    #[getter]
    pub(super) fn contacts<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyTuple>> {
        contacts_out(py, &self.description)
    }

    /// Magnetic dipoles on the links.
    #[getter]
    fn magnets<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyTuple>> {
        let magnets = &self.description.magnets;
        let out = magnets.iter().map(|it| wrapped(py, Arc::new(it.described(self.name_of(it.link)))));
        PyTuple::new(py, out.collect::<PyResult<Vec<_>>>()?)
    }

    /// Uniform magnetic field in the world, tesla.
    #[getter]
    fn field<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        signal_out(py, &self.description.field)
    }

    /// Number of constraints: those of all loops, plus one for each inextensible tendon.
    #[getter]
    fn constraints(&self) -> usize {
        self.description.constraints()
    }

    /// Number of redundant constraints of each loop at a shape, that is, of constraints that the others imply.
    ///
    /// Parameters
    /// ----------
    /// q : array_like, shape (n,)
    ///     Coordinates.
    ///
    /// Returns
    /// -------
    /// redundant : dict
    ///     Number of redundant constraints by the name of the loop or inextensible tendon; those without any are left out. The
    ///     total is unique, its distribution over several loops is not.
    fn redundant_constraints<'py>(
        &self,
        py: Python<'py>,
        q: &Bound<'py, PyAny>,
    ) -> PyResult<Bound<'py, PyDict>> {
        let q = convert::finite_vector_of(q, self.description.coordinates(), "q")?;
        let redundant = self.model().redundant_constraints(&q);
        let found = PyDict::new(py);
        let of_loops = self.description.loops.iter().map(|closed| closed.name.as_str());
        let names = of_loops.chain(self.description.inextensible_tendons().map(Actuator::name));
        for (name, number) in names.zip(redundant) {
            if number > 0 {
                found.set_item(name, number)?;
            }
        }
        Ok(found)
    }

    /// Length of an actuator: the path length of a tendon, the volume of a chamber, or the coordinate of a motor.
    ///
    /// Parameters
    /// ----------
    /// name : str
    ///     Name of the actuator.
    /// q : array_like, shape (n,) or (k, n)
    ///     Coordinates of a state, or of k states.
    /// t : float or array_like, shape (k,), optional
    ///     Time of the state, or of each of the k states, seconds. Required if the base moves.
    ///
    /// Returns
    /// -------
    /// length : float, or ndarray of shape (k,)
    ///     Metres for a tendon, cubic metres for a chamber, radians or metres for a motor. For an active strain, the generalised
    ///     displacement conjugate to its amount, joules for an amount of one.
    #[pyo3(signature = (name, q, *, t=None))]
    fn actuator_length<'py>(
        &self,
        #[pyo3(from_py_with = arguments::text::name)] name: &str,
        q: &Bound<'py, PyAny>,
        t: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let i = actuator_index(&self.description, name)?;
        let n = self.description.coordinates();
        let (zeros, mut gradient) = (vec![0.0; n], vec![0.0; n]);
        self.of_states(
            self.model(),
            [Some((q, "q")), None, None],
            At::time(t),
            "actuator_length",
            &[],
            |model, [q, ..]| vec![model.actuator(q, &zeros, i, &mut gradient)[0]],
        )
    }

    /// Rate of change of an actuator's length.
    ///
    /// Parameters
    /// ----------
    /// name : str
    ///     Name of the actuator.
    /// q, qd : array_like, shape (n,) or (k, n)
    ///     Coordinates and velocities of a state, or of k states.
    /// t : float or array_like, shape (k,), optional
    ///     Time of the state, or of each of the k states, seconds. Required if the base moves.
    ///
    /// Returns
    /// -------
    /// rate : float, or ndarray of shape (k,)
    ///     Unit of `actuator_length` per second.
    #[pyo3(signature = (name, q, qd, *, t=None))]
    fn actuator_rate<'py>(
        &self,
        #[pyo3(from_py_with = arguments::text::name)] name: &str,
        q: &Bound<'py, PyAny>,
        qd: &Bound<'py, PyAny>,
        t: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let i = actuator_index(&self.description, name)?;
        let mut gradient = vec![0.0; self.description.coordinates()];
        let states = [Some((q, "q")), Some((qd, "qd")), None];
        self.of_states(self.model(), states, At::time(t), "actuator_rate", &[], |model, [q, qd, _]| {
            vec![model.actuator(q, qd, i, &mut gradient)[1]]
        })
    }

    /// Derivative of an actuator's length with respect to the coordinates.
    ///
    /// Parameters
    /// ----------
    /// name : str
    ///     Name of the actuator.
    /// q : array_like, shape (n,) or (k, n)
    ///     Coordinates of a state, or of k states.
    /// t : float or array_like, shape (k,), optional
    ///     Time of the state, or of each of the k states, seconds. Required if the base moves.
    ///
    /// Returns
    /// -------
    /// gradient : ndarray, shape (n,) or (k, n)
    ///     Gradient of the length. ``gradient @ qd`` is the rate of the length; a tendon with the tension T exerts the
    ///     generalised forces ``-T * gradient``.
    #[pyo3(signature = (name, q, *, t=None))]
    fn actuator_gradient<'py>(
        &self,
        #[pyo3(from_py_with = arguments::text::name)] name: &str,
        q: &Bound<'py, PyAny>,
        t: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let i = actuator_index(&self.description, name)?;
        let n = self.description.coordinates();
        let (zeros, mut gradient) = (vec![0.0; n], vec![0.0; n]);
        let states = [Some((q, "q")), None, None];
        self.of_states(self.model(), states, At::time(t), "actuator_gradient", &[n], |model, [q, ..]| {
            model.actuator(q, &zeros, i, &mut gradient);
            gradient.clone()
        })
    }

    /// Force of an actuator: the tension of a tendon, the pressure of a chamber, or the torque of a motor.
    ///
    /// Parameters
    /// ----------
    /// name : str
    ///     Name of the actuator.
    /// q, qd : array_like, shape (n,) or (k, n)
    ///     Coordinates and velocities of a state, or of k states.
    /// t : float or array_like, shape (k,), optional
    ///     Time of the state, or of each of the k states, seconds. Required if anything varies in time.
    /// u : array_like, shape (m,) or (k, m), optional
    ///     Inputs for all states or for each; by default `u0`.
    /// qdd : array_like, shape (n,) or (k, n), optional
    ///     Accelerations, on which the tension of an inextensible tendon depends; by default those of the robot's free motion
    ///     from this state.
    ///
    /// Returns
    /// -------
    /// force : float, or ndarray of shape (k,)
    ///     Newtons for a tendon (zero if it is slack), pascals for a chamber, newton metres or newtons for a motor; for an active
    ///     strain its amount.
    #[pyo3(signature = (name, q, qd, *, t=None, u=None, qdd=None))]
    fn actuator_force<'py>(
        &self,
        #[pyo3(from_py_with = arguments::text::name)] name: &str,
        q: &Bound<'py, PyAny>,
        qd: &Bound<'py, PyAny>,
        t: Option<&Bound<'py, PyAny>>,
        u: Option<&Bound<'py, PyAny>>,
        qdd: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let i = actuator_index(&self.description, name)?;
        let actuator = &self.description.actuators[i];
        let sign = if actuator.pulls() { 1.0 } else { -1.0 };
        let mut gradient = vec![0.0; self.description.coordinates()];
        let states = [Some((q, "q")), Some((qd, "qd")), qdd.map(|qdd| (qdd, "qdd"))];
        if actuator.is_inextensible() {
            let tension = |model: &mut RobotModel, [q, qd, qdd]: [&[f64]; 3]| {
                let qdd = (!qdd.is_empty()).then_some(qdd);
                vec![model.held_tension(q, qd, qdd, i).unwrap_or(f64::NAN)]
            };
            return self.of_states(self.model(), states, At::forces(t, u), "actuator_force", &[], tension);
        }
        self.of_states(self.model(), states, At::forces(t, u), "actuator_force", &[], |model, [q, qd, _]| {
            vec![sign * model.actuator(q, qd, i, &mut gradient)[2]]
        })
    }

    /// Number of quadrature nodes of each segment.
    #[getter]
    fn nodes<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyTuple>> {
        let kinematics = self.kinematics.lock().unwrap_or_else(PoisonError::into_inner);
        PyTuple::new(py, kinematics.nodes())
    }

    /// Kernel that computes the robot: "planar" if its joints, modes and reference strains keep it in one plane, else "spatial".
    #[getter]
    fn kernel(&self) -> &'static str {
        match self.kinematics.lock().unwrap_or_else(PoisonError::into_inner).kernel() {
            Kernel::Planar => "planar",
            Kernel::Spatial => "spatial",
        }
    }

    /// Estimated number of floating-point multiplications of one evaluation, by kind of evaluation; accurate to about a tenth
    /// for rods.
    ///
    /// ``"residual"``: inverse dynamics; ``"tangent"``: Jacobian of an implicit step, given the residual; ``"mass_matrix"``:
    /// mass matrix, given the shape; ``"factorisation"`` (LU) and ``"solution"`` of the linear system of a step. A
    /// multiply-add counts as one.
    #[getter]
    fn multiplications<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let kinematics = self.kinematics.lock().unwrap_or_else(PoisonError::into_inner);
        let Multiplications { residual, tangent, mass_matrix, factorisation, solution } =
            kinematics.multiplications();
        let counts = PyDict::new(py);
        counts.set_item("residual", residual)?;
        counts.set_item("tangent", tangent)?;
        counts.set_item("mass_matrix", mass_matrix)?;
        counts.set_item("factorisation", factorisation)?;
        counts.set_item("solution", solution)?;
        Ok(counts)
    }

    /// Describe what lissom computes for this robot, what it skips and why, and how many multiplications the evaluations take.
    /// Print the returned text.
    fn explain(&self) -> String {
        self.kinematics.lock().unwrap_or_else(PoisonError::into_inner).full_explanation().to_string()
    }

    /// Poses of sections or bodies.
    ///
    /// Parameters
    /// ----------
    /// q : array_like, shape (n,) or (k, n)
    ///     Coordinates of a state, or of k states.
    /// X : float or array_like, shape (m,), optional
    ///     Arc lengths of the link's unstretched rod, 0 <= X <= length, metres; by default the tip. None for a rigid link.
    /// link : str, optional
    ///     Name of the link; optional if the robot has only one.
    /// t : float or array_like, shape (k,), optional
    ///     Time of the state, or of each of the k states, seconds. Required if the base moves.
    ///
    /// Returns
    /// -------
    /// pose : ndarray, shape (4, 4) for a number, (m, 4, 4) for an array; (k, 4, 4) and (k, m, 4, 4) for k states
    ///     Homogeneous transformations from body to world: ``pose[..., :3, :3]`` has the body axes as columns,
    ///     ``pose[..., :3, 3]`` is the position in metres.
    #[pyo3(signature = (q, X=None, *, link=None, t=None))]
    #[allow(non_snake_case, reason = "X is the arc length of the unstretched rod everywhere in this field")]
    fn pose<'py>(
        &self,
        q: &Bound<'py, PyAny>,
        X: Option<&Bound<'py, PyAny>>,
        #[pyo3(from_py_with = arguments::optional_text::link)] link: Option<&str>,
        t: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let py = q.py();
        let n = self.description.coordinates();
        let (states, number_of_states) = convert::finite_rows_of(q, n, "q")?;
        let link = index_of(&self.description, link, "link")?;
        let (places, is_number) = self.arc_lengths(X, link)?;
        let rows = number_of_states.unwrap_or(1);
        let times = self.times(t, number_of_states, self.description.is_moved())?;
        let shape: Vec<usize> =
            number_of_states.into_iter().chain((!is_number).then_some(places.len())).chain([4, 4]).collect();
        // Locked without the interpreter, and only for one place or pose at a time: signal handlers may use
        // the same robot.
        let model = || self.kinematics.lock().unwrap_or_else(PoisonError::into_inner);
        let answer_signals = |done: usize| {
            let is_time = done > 0 && done.is_multiple_of(POSES_BETWEEN_SIGNALS);
            if is_time { Python::attach(|py| py.check_signals()) } else { Ok(()) }
        };
        let poses = py.detach(|| {
            // Callables of time may use the model while it is being evaluated.
            let mut moving = self.description.is_prescribed().then(|| model().clone());
            let places = places
                .into_iter()
                .enumerate()
                .map(|(i, x)| answer_signals(i).map(|()| model().place_on(link, x)))
                .collect::<PyResult<Vec<Place>>>()?;
            let mut poses = Vec::with_capacity(16 * rows * places.len());
            for row in 0..rows {
                let q = &states[row * n..(row + 1) * n];
                if let Some(moving) = &mut moving {
                    or_raised(moving.set_time(times[row % times.len()]))?;
                }
                for place in &places {
                    answer_signals(poses.len() / 16)?;
                    let pose = match &mut moving {
                        Some(moving) => moving.pose_at(q, place),
                        None => model().pose_at(q, place),
                    };
                    poses.extend(convert::homogeneous(&pose));
                }
            }
            Ok::<_, PyErr>(poses)
        })?;
        check_finite(&poses, "pose")?;
        Ok(poses.into_pyarray(py).reshape(shape)?.into_any())
    }

    /// Jacobian of the pose of a section or body.
    ///
    /// Parameters
    /// ----------
    /// q : array_like, shape (n,) or (k, n)
    ///     Coordinates of a state, or of k states.
    /// X : float, optional
    ///     Arc length of the link's unstretched rod from its base, metres; by default its tip.
    /// link : str, optional
    ///     Name of the link; optional if the robot has only one.
    /// t : float or array_like, shape (k,), optional
    ///     Time of the state, or of each of the k states, seconds. Required if the base moves.
    ///
    /// Returns
    /// -------
    /// jacobian : ndarray, shape (6, n) or (k, 6, n)
    ///     ``jacobian @ qd`` is the angular velocity of the section at X and the velocity of its centre, in world axes, for a
    ///     fixed base; `velocity` adds the motion of the base. ``jacobian.T @ wrench`` are the generalised forces of a moment and
    ///     a force at the section.
    #[pyo3(signature = (q, X=None, *, link=None, t=None))]
    #[allow(non_snake_case, reason = "X is the arc length of the unstretched rod everywhere in this field")]
    fn jacobian<'py>(
        &self,
        q: &Bound<'py, PyAny>,
        #[pyo3(from_py_with = arguments::optional_number::X)] X: Option<f64>,
        #[pyo3(from_py_with = arguments::optional_text::link)] link: Option<&str>,
        t: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let link = index_of(&self.description, link, "link")?;
        self.check_place(link, X)?;
        let n = self.description.coordinates();
        let place = self.kinematics.lock().unwrap_or_else(PoisonError::into_inner).place_on(link, X);
        let mut jacobian = Matrix::zeros(6, n);
        self.of_states(
            self.model(),
            [Some((q, "q")), None, None],
            At::time(t),
            "jacobian",
            &[6, n],
            |model, [q, ..]| {
                model.jacobian_at(q, &place, &mut jacobian);
                jacobian.transpose().as_slice().to_vec()
            },
        )
    }

    /// Velocity of a section or body.
    ///
    /// Parameters
    /// ----------
    /// q, qd : array_like, shape (n,) or (k, n)
    ///     Coordinates and velocities of a state, or of k states.
    /// X : float, optional
    ///     Arc length of the link's unstretched rod from its base, metres; by default its tip.
    /// link : str, optional
    ///     Name of the link; optional if the robot has only one.
    /// t : float or array_like, shape (k,), optional
    ///     Time of the state, or of each of the k states, seconds. Required if the base moves.
    ///
    /// Returns
    /// -------
    /// velocity : ndarray, shape (6,) or (k, 6)
    ///     Angular velocity of the section at X, rad/s, and velocity of its centre, m/s, in world axes, with those of the base.
    #[pyo3(signature = (q, qd, X=None, *, link=None, t=None))]
    #[allow(non_snake_case, reason = "X is the arc length of the unstretched rod everywhere in this field")]
    fn velocity<'py>(
        &self,
        q: &Bound<'py, PyAny>,
        qd: &Bound<'py, PyAny>,
        #[pyo3(from_py_with = arguments::optional_number::X)] X: Option<f64>,
        #[pyo3(from_py_with = arguments::optional_text::link)] link: Option<&str>,
        t: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let link = index_of(&self.description, link, "link")?;
        self.check_place(link, X)?;
        let place = self.kinematics.lock().unwrap_or_else(PoisonError::into_inner).place_on(link, X);
        self.of_states(
            self.model(),
            [Some((q, "q")), Some((qd, "qd")), None],
            At::time(t),
            "velocity",
            &[6],
            |model, [q, qd, _]| flat(model.velocity_at(q, qd, &place)),
        )
    }

    /// Acceleration of a section or body.
    ///
    /// Time derivative of `velocity`. In free fall it is the acceleration of gravity. `lissom.sensors.Accelerometer` gives the
    /// specific force, which an instrument would measure.
    ///
    /// Parameters
    /// ----------
    /// q, qd, qdd : array_like, shape (n,) or (k, n)
    ///     Coordinates, velocities and accelerations of a state, or of k states.
    /// X : float, optional
    ///     Arc length of the link's unstretched rod from its base, metres; by default its tip.
    /// link : str, optional
    ///     Name of the link; optional if the robot has only one.
    /// t : float or array_like, shape (k,), optional
    ///     Time of the state, or of each of the k states, seconds. Required if the base moves.
    ///
    /// Returns
    /// -------
    /// acceleration : ndarray, shape (6,) or (k, 6)
    ///     Angular acceleration of the section at X, rad/s^2, and acceleration of its centre, m/s^2, in world axes, with those of the
    ///     base.
    ///
    /// Notes
    /// -----
    /// Exact, like `velocity`, at the cost of one inverse dynamics. Computed from the spatial acceleration (a; w') about the
    /// origin, at the point p: ``a + w' x p + w x (v + w x p)`` (Featherstone 2008, section 2.11).
    ///
    /// Examples
    /// --------
    /// >>> import lissom
    /// >>> hinge = lissom.Revolute((0, 1, 0))
    /// >>> bob = lissom.Link("bob", parent="arm", position=(0.5, 0, 0), body=lissom.Body(0.1))
    /// >>> robot = lissom.Robot([lissom.Link("arm", joint=hinge), bob])
    /// >>> robot.acceleration([0.0], [3.0], [0.0], link="bob")[3:]
    /// array([-4.5,  0. ,  0. ])
    #[pyo3(signature = (q, qd, qdd, X=None, *, link=None, t=None))]
    #[allow(non_snake_case, reason = "X is the arc length of the unstretched rod everywhere in this field")]
    fn acceleration<'py>(
        &self,
        q: &Bound<'py, PyAny>,
        qd: &Bound<'py, PyAny>,
        qdd: &Bound<'py, PyAny>,
        #[pyo3(from_py_with = arguments::optional_number::X)] X: Option<f64>,
        #[pyo3(from_py_with = arguments::optional_text::link)] link: Option<&str>,
        t: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let link = index_of(&self.description, link, "link")?;
        self.check_place(link, X)?;
        let place = self.kinematics.lock().unwrap_or_else(PoisonError::into_inner).place_on(link, X);
        self.of_states(
            self.model(),
            [Some((q, "q")), Some((qd, "qd")), Some((qdd, "qdd"))],
            At::time(t),
            "acceleration",
            &[6],
            |model, [q, qd, qdd]| flat(model.acceleration_at(q, qd, qdd, &place)),
        )
    }

    /// Centre of mass of all rods and bodies.
    ///
    /// Parameters
    /// ----------
    /// q : array_like, shape (n,) or (k, n)
    ///     Coordinates of a state, or of k states.
    /// t : float or array_like, shape (k,), optional
    ///     Time of the state, or of each of the k states, seconds. Required if the base moves.
    ///
    /// Returns
    /// -------
    /// centre : ndarray, shape (3,) or (k, 3)
    ///     Position in the world, metres.
    #[pyo3(signature = (q, *, t=None))]
    fn centre_of_mass<'py>(
        &self,
        q: &Bound<'py, PyAny>,
        t: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let zeros = vec![0.0; self.description.coordinates()];
        self.of_states(
            self.spatial()?,
            [Some((q, "q")), None, None],
            At::time(t),
            "centre_of_mass",
            &[3],
            |model, [q, ..]| {
                let momentum = model.momentum(q, &zeros);
                (momentum.first_moment * (1.0 / momentum.mass)).to_array().to_vec()
            },
        )
    }

    /// Linear and angular momentum of all rods and bodies.
    ///
    /// Parameters
    /// ----------
    /// q, qd : array_like, shape (n,) or (k, n)
    ///     Coordinates and velocities of a state, or of k states.
    /// t : float or array_like, shape (k,), optional
    ///     Time of the state, or of each of the k states, seconds. Required if the base moves.
    ///
    /// Returns
    /// -------
    /// momentum : ndarray, shape (6,) or (k, 6)
    ///     Angular momentum about the origin of the world, kg m^2/s, and linear momentum, kg m/s, in world axes.
    #[pyo3(signature = (q, qd, *, t=None))]
    fn momentum<'py>(
        &self,
        q: &Bound<'py, PyAny>,
        qd: &Bound<'py, PyAny>,
        t: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        self.of_states(
            self.spatial()?,
            [Some((q, "q")), Some((qd, "qd")), None],
            At::time(t),
            "momentum",
            &[6],
            |model, [q, qd, _]| {
                let momentum = model.momentum(q, qd);
                flat([momentum.angular, momentum.linear])
            },
        )
    }

    /// Moment and force that a link receives through its joint, from its parent or the world, during a
    /// motion.
    ///
    /// Parameters
    /// ----------
    /// q, qd, qdd : array_like, shape (n,) or (k, n)
    ///     Coordinates, velocities and accelerations of a state, or of k states.
    /// link : str, optional
    ///     Name of the link; optional if the robot has only one.
    /// t : float or array_like, shape (k,), optional
    ///     Time of the state, or of each of the k states, seconds. Required if loads vary or the base moves.
    /// u : array_like, shape (m,) or (k, m), optional
    ///     Inputs for all states or for each; by default `u0`.
    ///
    /// Returns
    /// -------
    /// wrench : ndarray, shape (6,) or (k, 6)
    ///     Moment about the origin of the joint's frame, newton metres, and force, newtons, in world axes.
    #[pyo3(signature = (q, qd, qdd, *, link=None, t=None, u=None))]
    fn joint_wrench<'py>(
        &self,
        q: &Bound<'py, PyAny>,
        qd: &Bound<'py, PyAny>,
        qdd: &Bound<'py, PyAny>,
        #[pyo3(from_py_with = arguments::optional_text::link)] link: Option<&str>,
        t: Option<&Bound<'py, PyAny>>,
        u: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let link = index_of(&self.description, link, "link")?;
        let states = [Some((q, "q")), Some((qd, "qd")), Some((qdd, "qdd"))];
        self.of_states(
            self.spatial()?,
            states,
            At::forces(t, u),
            "joint_wrench",
            &[6],
            |model, [q, qd, qdd]| flat(model.joint_wrench(q, qd, qdd, link)),
        )
    }

    /// Constraint forces of a closed loop during a motion.
    ///
    /// If constraints are redundant, the result is the minimum-norm solution, which distributes shared forces
    /// over the loops.
    ///
    /// Parameters
    /// ----------
    /// q, qd, qdd : array_like, shape (n,) or (k, n)
    ///     Coordinates, velocities and accelerations of a state, or of k states.
    /// name : str, optional
    ///     Name of the loop; optional if the robot has only one.
    /// t : float or array_like, shape (k,), optional
    ///     Time of the state, or of each of the k states, seconds. Required if loads vary or the base moves.
    /// u : array_like, shape (m,) or (k, m), optional
    ///     Inputs for all states or for each; by default `u0`.
    ///
    /// Returns
    /// -------
    /// wrench : ndarray, shape (6,) or (k, 6)
    ///     Moment about the origin of the second end, newton metres, and force, newtons, that the first end exerts on it, in
    ///     world axes. For a `Gear`, the generalised force on its first coordinate, a float or an array of
    ///     shape (k,).
    #[pyo3(signature = (q, qd, qdd, *, name=None, t=None, u=None))]
    fn loop_forces<'py>(
        &self,
        q: &Bound<'py, PyAny>,
        qd: &Bound<'py, PyAny>,
        qdd: &Bound<'py, PyAny>,
        #[pyo3(from_py_with = arguments::optional_text::name)] name: Option<&str>,
        t: Option<&Bound<'py, PyAny>>,
        u: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let i = loop_index(&self.description, name)?;
        let states = [Some((q, "q")), Some((qd, "qd")), Some((qdd, "qdd"))];
        let forces = |model: &mut RobotModel, [q, qd, qdd]: [&[f64]; 3]| {
            model.loop_forces(q, qd, qdd).map_or([f64::NAN; 6], |forces| forces[i])
        };
        if matches!(self.description.loops[i].tie, Tie::Coordinates { .. }) {
            let force = |model: &mut RobotModel, state: [&[f64]; 3]| vec![forces(model, state)[0]];
            return self.of_states(self.model(), states, At::forces(t, u), "loop_forces", &[], force);
        }
        self.of_states(self.model(), states, At::forces(t, u), "loop_forces", &[6], |model, state| {
            forces(model, state).to_vec()
        })
    }

    /// Resultant wrench of a contact on its first surface.
    ///
    /// Parameters
    /// ----------
    /// q, qd : array_like, shape (n,) or (k, n)
    ///     Coordinates and velocities of a state, or of k states.
    /// name : str, optional
    ///     Name of the contact; optional if the robot has only one.
    /// t : float or array_like, shape (k,), optional
    ///     Time of the state, or of each of the k states, seconds. Required if the motion of the base or a joint is prescribed.
    ///
    /// Returns
    /// -------
    /// wrench : ndarray, shape (6,) or (k, 6)
    ///     Moment about the world's origin, newton metres, and force, newtons, in world axes; zero without contact.
    #[pyo3(signature = (q, qd, *, name=None, t=None))]
    fn contact_forces<'py>(
        &self,
        q: &Bound<'py, PyAny>,
        qd: &Bound<'py, PyAny>,
        #[pyo3(from_py_with = arguments::optional_text::name)] name: Option<&str>,
        t: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let i = contact_index(&self.description, name)?;
        let states = [Some((q, "q")), Some((qd, "qd")), None];
        self.of_states(self.model(), states, At::time(t), "contact_forces", &[6], |model, [q, qd, _]| {
            flat(model.contact_wrench(q, qd, i))
        })
    }

    /// Places where surfaces touch in a state.
    ///
    /// Parameters
    /// ----------
    /// q : array_like, shape (n,)
    ///     Coordinates.
    /// qd : array_like, shape (n,), optional
    ///     Velocities; by default zero.
    /// t : float, optional
    ///     Time of the state, seconds. Required if the motion of the base or a joint is prescribed.
    ///
    /// Returns
    /// -------
    /// touches : list of Touch
    ///     Places ordered by contact, along rods from base to tip.
    #[pyo3(signature = (q, qd=None, *, t=None))]
    fn touches<'py>(
        &self,
        py: Python<'py>,
        q: &Bound<'py, PyAny>,
        qd: Option<&Bound<'py, PyAny>>,
        #[pyo3(from_py_with = arguments::optional_number::t)] t: Option<f64>,
    ) -> PyResult<Bound<'py, PyList>> {
        let n = self.description.coordinates();
        let q = convert::finite_vector_of(q, n, "q")?;
        let qd = qd.map_or_else(|| Ok(vec![0.0; n]), |qd| convert::finite_vector_of(qd, n, "qd"))?;
        let time = time_of_state(t, self.description.is_moved())?;
        let mut model = self.model();
        or_raised(model.set_time(time))?;
        let class = py.import("lissom.model.contacts")?.getattr("Touch")?;
        let touch = |touch: Touching| {
            let vector = |v: Vector<f64>| PyArray1::from_slice(py, &v.to_array());
            let Touching { contact, position, normal, force, overlap, sliding, along } = touch;
            let name = self.description.contacts[contact].name.as_str();
            let [on_first, on_second] = along;
            class.call1((
                name,
                vector(position),
                vector(normal),
                vector(force),
                overlap,
                vector(sliding),
                (on_first, on_second),
            ))
        };
        PyList::new(py, model.touches(&q, &qd).into_iter().map(touch).collect::<PyResult<Vec<_>>>()?)
    }

    /// Closed loops of a robot at rest, row by row: the contribution of their forces to the stiffness, and
    /// the derivative of the gaps.
    #[pyo3(signature = (q, *, t=None, u=None))]
    fn _loops_at_rest<'py>(
        &self,
        q: &Bound<'py, PyAny>,
        t: Option<&Bound<'py, PyAny>>,
        u: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let n = self.description.coordinates();
        self.of_states(
            self.model(),
            [Some((q, "q")), None, None],
            At::forces(t, u),
            "_loops_at_rest",
            &[n + self.constraints(), n],
            |model, [q, _, _]| {
                let parts = model.loops_at_rest(q);
                parts.iter().flat_map(|part| part.transpose().as_slice().to_vec()).collect()
            },
        )
    }

    /// Violation of the loop constraints.
    ///
    /// Parameters
    /// ----------
    /// q : array_like, shape (n,) or (k, n)
    ///     Coordinates of a state, or of k states.
    /// t : float or array_like, shape (k,), optional
    ///     Time of the state, or of each of the k states, seconds. Required if the motion of a joint is prescribed, or if
    ///     the robot has inextensible tendons and anything that acts on it depends on time.
    ///
    /// Returns
    /// -------
    /// gaps : ndarray, shape (m,) or (k, m)
    ///     Violation of each constraint: metres, a difference of cosines, or the unit of a coordinate. Inextensible tendons
    ///     follow the loops: how much each taut one is shorter (positive) or longer than its length; zero for slack ones.
    #[pyo3(signature = (q, *, t=None))]
    fn loop_gaps<'py>(
        &self,
        q: &Bound<'py, PyAny>,
        t: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let m = self.constraints();
        // Lengths of tendons are commands, as those of forces.
        let has_tendons = self.description.inextensible_tendons().next().is_some();
        self.of_states(
            self.model(),
            [Some((q, "q")), None, None],
            if has_tendons { At::forces(t, None) } else { At::time(t) },
            "loop_gaps",
            &[m],
            |model, [q, _, _]| {
                let mut gaps = vec![0.0; m];
                model.gaps(q, &mut gaps);
                gaps
            },
        )
    }

    /// Strains of sections of a rod.
    ///
    /// Parameters
    /// ----------
    /// q : array_like, shape (n,) or (k, n)
    ///     Coordinates of a state, or of k states.
    /// X : float or array_like, shape (m,), optional
    ///     Arc lengths of the link's unstretched rod, 0 <= X <= length, metres; by default the tip. Where two segments meet, the
    ///     strain is that of the first one.
    /// link : str, optional
    ///     Name of the link; optional if the robot has only one.
    ///
    /// Returns
    /// -------
    /// strain : ndarray, shape (6,) for a number, (m, 6) for an array; (k, 6) and (k, m, 6) for k states
    ///     Torsion, bend_y and bend_z, radians per metre; stretch, shear_y and shear_z, metres per metre; all in the axes of the
    ///     section and including the reference strain. An undeformed straight rod has (0, 0, 0, 1, 0, 0).
    ///
    /// Examples
    /// --------
    /// >>> import lissom
    /// >>> finger = lissom.Segment(0.2, 0.01, 1e6, poisson_ratio=0.5, density=1000, modes={"bend_y": 2})
    /// >>> lissom.Rod([finger]).strain([3.0, 1.0], [0.0, 0.1, 0.2])[:, 1]
    /// array([2., 3., 4.])
    #[pyo3(signature = (q, X=None, *, link=None))]
    #[allow(non_snake_case, reason = "X is the arc length of the unstretched rod everywhere in this field")]
    fn strain<'py>(
        &self,
        q: &Bound<'py, PyAny>,
        X: Option<&Bound<'py, PyAny>>,
        #[pyo3(from_py_with = arguments::optional_text::link)] link: Option<&str>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let mut model = self.model();
        let (sections, shape) = self.sections(&model, X, link)?;
        let n = self.description.coordinates();
        let (states, number) = convert::finite_rows_of(q, n, "q")?;
        let mut strains = Vec::new();
        for row in 0..number.unwrap_or(1) {
            if row > 0 && row.is_multiple_of(POSES_BETWEEN_SIGNALS) {
                q.py().check_signals()?;
            }
            let q = &states[row * n..(row + 1) * n];
            strains.extend(sections.iter().flat_map(|section| model.strain_at(q, section)));
        }
        check_finite(&strains, "strain")?;
        let shape: Vec<usize> = number.into_iter().chain(shape).collect();
        Ok(strains.into_pyarray(q.py()).reshape(shape)?.into_any())
    }

    /// Internal moment and force in sections of a rod during a motion: the wrench that the part before a section exerts on
    /// everything beyond it.
    ///
    /// A rod under tension has a negative force along x. At the base the result equals `joint_wrench`, in the axes of the
    /// section. Loads, bodies and links exactly at X count as beyond the section.
    ///
    /// Parameters
    /// ----------
    /// q, qd, qdd : array_like, shape (n,) or (k, n)
    ///     Coordinates, velocities and accelerations of a state, or of k states.
    /// X : float or array_like, shape (m,), optional
    ///     Arc lengths of the link's unstretched rod, 0 <= X <= length, metres; by default its tip.
    /// link : str, optional
    ///     Name of the link; optional if the robot has only one.
    /// t : float or array_like, shape (k,), optional
    ///     Time of the state, or of each of the k states, seconds. Required if loads vary or the base moves.
    /// by : {'balance', 'material'}
    ///     'balance': from inertia, weight, loads, fluid, supports and contact (at the places that `touches` reports) of everything
    ///     beyond the section. It is valid for any given
    ///     motion, also for strains without modes. 'material': from stiffness and damping of the section,
    ///     ``-(H (xi - xi_0) + mu H xi')``, with active strains as part of xi_0. It includes neither loads nor strains without
    ///     modes. In free motion and in equilibrium the two agree when projected onto the modes, and pointwise as the number of
    ///     modes grows, except for the forces of embedded tendons and chambers, which only 'balance' includes.
    /// u : array_like, shape (m,) or (k, m), optional
    ///     Inputs for all states or for each; by default `u0`.
    ///
    /// Returns
    /// -------
    /// wrench : ndarray, shape (6,) for a number, (m, 6) for an array; (k, 6) and (k, m, 6) for k states
    ///     Moment about the section's point, newton metres, and force, newtons, in the section's axes.
    ///
    /// Examples
    /// --------
    /// A hanging rod of one kilogram carries less of its weight towards the tip:
    ///
    /// >>> import numpy as np, lissom
    /// >>> wire = lissom.Segment(1.0, 1e-3, 2e11, 8e10, 1 / (np.pi * 1e-6), modes={"bend_y": 1})
    /// >>> rod = lissom.Rod([wire], gravity=(9.81, 0, 0))
    /// >>> rod.internal_wrench([0.0], [0.0], [0.0], [0.0, 0.5, 1.0])[:, 3].round(9) + 0.0
    /// array([-9.81 , -4.905,  0.   ])
    #[pyo3(signature = (q, qd, qdd, X=None, *, link=None, t=None, by="balance", u=None))]
    #[allow(non_snake_case, reason = "X is the arc length of the unstretched rod everywhere in this field")]
    #[allow(clippy::too_many_arguments, reason = "keyword-only options of a Python method")]
    fn internal_wrench<'py>(
        &self,
        q: &Bound<'py, PyAny>,
        qd: &Bound<'py, PyAny>,
        qdd: &Bound<'py, PyAny>,
        X: Option<&Bound<'py, PyAny>>,
        #[pyo3(from_py_with = arguments::optional_text::link)] link: Option<&str>,
        t: Option<&Bound<'py, PyAny>>,
        #[pyo3(from_py_with = arguments::text::by)] by: &str,
        u: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let is_balanced = match by {
            "balance" => true,
            "material" => false,
            _ => {
                let message = format!("by: got {by:?}, expected \"balance\" or \"material\"");
                return Err(PyValueError::new_err(message));
            }
        };
        // The spatial model, because the wrench that keeps a planar robot in its plane also passes through
        // sections.
        let model = self.spatial()?;
        let (sections, shape) = self.sections(&model, X, link)?;
        let states = [Some((q, "q")), Some((qd, "qd")), Some((qdd, "qdd"))];
        self.of_states(model, states, At::forces(t, u), "internal_wrench", &shape, |model, [q, qd, qdd]| {
            let wrench = |section: &Place| match is_balanced {
                true => model.internal_wrench_at(q, qd, qdd, section),
                false => model.material_wrench_at(q, qd, section),
            };
            sections.iter().map(wrench).flat_map(flat).collect()
        })
    }

    /// Inverse kinematics: find a shape in which links have given poses.
    ///
    /// Minimises the squared errors within the limits of joints, by Gauss-Newton steps in a trust region, and
    /// by Newton steps where those are slow. A target out of reach therefore converges fast to the nearest
    /// shape, and a stretched arm does not stop at a saddle. If the first start does not reach the target,
    /// others follow; they cover the range of the robot and are the same in every call. Forces are ignored:
    /// `statics` finds the shape that a soft robot takes under its loads.
    ///
    /// Parameters
    /// ----------
    /// link : str, mapping or sequence of Target
    ///     The link to place; or several: a mapping from names to poses, or a sequence of `Target`.
    /// pose : array_like, shape (4, 4), (3,), (3, 3) or (4,)
    ///     Its target pose in the world, for one link: a homogeneous matrix as from `pose`, a position alone,
    ///     metres, or an orientation alone, as a rotation matrix or a quaternion (w, x, y, z).
    /// X : float, optional
    ///     Arc length of the link's unstretched rod, 0 <= X <= length, metres; by default its tip. None for a rigid link.
    /// point : array_like, shape (3,), optional
    ///     The point to place, in the axes of the section or body, metres; by default its origin.
    /// position_weight, orientation_weight : float or array_like, shape (3,)
    ///     Weights of the position error along the world axes and of the orientation error about the target's axes; zero ignores
    ///     an axis. With weights of one, a radian counts as much as the length of the chain of links that carries the target. The
    ///     weights matter if the target cannot be reached.
    /// q0 : array_like, shape (n,), optional
    ///     Initial shape, projected onto the limits; by default zero.
    /// bounds : (lower, upper), optional
    ///     Bounds of the coordinates, each a number or of shape (n,). Infinite values mean no bound, equal values fix a
    ///     coordinate. The `limits` of joints apply in addition.
    /// prefer : {'start', 'energy'} or array_like of shape (n,), optional
    ///     Preference among the solutions: the one nearest to `q0`, measured with the coordinates' sizes (a radian of what they turn) or with the
    ///     given weights of their squares; or the one with the least elastic energy of rods and joint springs, without supports.
    ///     By default any solution near the start.
    /// t : float, optional
    ///     Time, seconds. Required if the base moves.
    /// tol : float
    ///     A target counts as reached if the position error is at most `tol` times the length of the chain of links that carries
    ///     it and the orientation error at most `tol` radians.
    /// max_iter : int
    ///     Maximum number of steps from each start.
    /// restarts : int
    ///     Maximum number of additional starts.
    ///
    /// Returns
    /// -------
    /// ReachResult
    ///     `q`, `success`, `status`, `message`, `position_error`, `orientation_error`, `pose` and more. An unreachable target
    ///     does not raise.
    ///
    /// Raises
    /// ------
    /// ValueError, TypeError
    ///     If an argument is invalid.
    /// KeyboardInterrupt
    ///     On Ctrl-C. Its attribute `result` is the ReachResult with the best shape until then.
    ///
    /// Notes
    /// -----
    /// A Gauss-Newton step costs one Jacobian per target; a step with second derivatives, and each step towards the preferred
    /// shape, cost n. The orientation error is the rotation vector of ``R_target.T @ R``, with its exact differential. The
    /// method of multipliers (Hestenes 1969; Powell 1969) finds the preferred shape, which is a local optimum.
    ///
    /// Examples
    /// --------
    /// >>> import lissom
    /// >>> soft = lissom.Segment(0.3, 0.01, 1e6, poisson_ratio=0.5, density=1000, modes={"bend_y": 2, "bend_z": 2})
    /// >>> rod = lissom.Rod([soft])
    /// >>> found = rod.reach("rod", [0.2, 0.1, 0.05], prefer="energy")
    /// >>> found.status, rod.pose(found.q)[:3, 3].round(6)
    /// ('reached', array([0.2 , 0.1 , 0.05]))
    /// >>> rod.reach("rod", [0.0, 0.4, 0.0]).status
    /// 'nearest'
    #[pyo3(signature = (link, pose=None, *, X=None, point=None, position_weight=None, orientation_weight=None, q0=None,
                        bounds=None, prefer=None, t=None, tol=None, max_iter=None, restarts=None),
           text_signature = "($self, link, pose=None, *, X=None, point=None, position_weight=1.0, orientation_weight=1.0, q0=None, bounds=None, prefer=None, t=None, tol=1e-09, max_iter=200, restarts=8)")]
    #[allow(non_snake_case, reason = "X is the arc length of the unstretched rod everywhere in this field")]
    #[allow(clippy::too_many_arguments, reason = "keyword-only options of a Python method")]
    fn reach<'py>(
        &self,
        link: &Bound<'py, PyAny>,
        pose: Option<&Bound<'py, PyAny>>,
        #[pyo3(from_py_with = arguments::optional_number::X)] X: Option<f64>,
        point: Option<&Bound<'py, PyAny>>,
        position_weight: Option<&Bound<'py, PyAny>>,
        orientation_weight: Option<&Bound<'py, PyAny>>,
        q0: Option<&Bound<'py, PyAny>>,
        bounds: Option<&Bound<'py, PyAny>>,
        prefer: Option<&Bound<'py, PyAny>>,
        #[pyo3(from_py_with = arguments::optional_number::t)] t: Option<f64>,
        #[pyo3(from_py_with = arguments::optional_number::tol)] tol: Option<f64>,
        #[pyo3(from_py_with = arguments::optional_whole::max_iter)] max_iter: Option<i64>,
        #[pyo3(from_py_with = arguments::optional_whole::restarts)] restarts: Option<i64>,
    ) -> PyResult<PyReachResult> {
        let weights = [position_weight, orientation_weight];
        let single = pose.map(|pose| reach::Given { pose, at: X, point, weights });
        let of_one = [X.is_some(), point.is_some(), position_weight.is_some(), orientation_weight.is_some()];
        let is_one = link.is_none() || link.is_instance_of::<PyString>();
        if !is_one && (pose.is_some() || of_one.contains(&true)) {
            return Err(PyValueError::new_err(
                "pose: expected nothing, nor X, point and weights, beside several targets: each lissom.Target has its own",
            ));
        }
        let time = time_of_state(t, self.description.is_moved())?;
        let mut model = self.model();
        if self.description.is_prescribed() {
            check_time(time, self.span())?;
            or_raised(model.set_time(time))?;
        }
        let wishes = reach::Wishes { q0, bounds, prefer, tol, max_iter, restarts };
        reach::search(link.py(), model, link, single.as_ref(), &wishes)
    }

    /// Moment and force that the base exerts on the robot during a motion.
    ///
    /// Parameters
    /// ----------
    /// q, qd, qdd : array_like, shape (n,) or (k, n)
    ///     Coordinates, velocities and accelerations of a state, or of k states.
    /// t : float or array_like, shape (k,), optional
    ///     Time of the state, or of each of the k states, seconds. Required if loads vary or the base moves.
    /// u : array_like, shape (m,) or (k, m), optional
    ///     Inputs for all states or for each; by default `u0`.
    ///
    /// Returns
    /// -------
    /// wrench : ndarray, shape (6,) or (k, 6)
    ///     Moment about the base, newton metres, and force, newtons, in world axes.
    #[pyo3(signature = (q, qd, qdd, *, t=None, u=None))]
    fn base_wrench<'py>(
        &self,
        q: &Bound<'py, PyAny>,
        qd: &Bound<'py, PyAny>,
        qdd: &Bound<'py, PyAny>,
        t: Option<&Bound<'py, PyAny>>,
        u: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let states = [Some((q, "q")), Some((qd, "qd")), Some((qdd, "qdd"))];
        self.of_states(
            self.spatial()?,
            states,
            At::forces(t, u),
            "base_wrench",
            &[6],
            |model, [q, qd, qdd]| flat(model.base_wrench(q, qd, qdd)),
        )
    }

    fn __repr__(&self) -> String {
        let links = self.description.links.len();
        let plural = if links == 1 { "" } else { "s" };
        format!("<lissom.Robot of {links} link{plural}, n = {}>", self.description.coordinates())
    }

    /// For copies and pickles.
    fn __getnewargs_ex__<'py>(
        &self,
        py: Python<'py>,
    ) -> PyResult<((Bound<'py, PyTuple>,), Bound<'py, PyDict>)> {
        let arguments = PyDict::new(py);
        arguments.set_item("gravity", self.gravity())?;
        arguments.set_item("loads", self.loads(py)?)?;
        arguments.set_item("bodies", self.bodies(py)?)?;
        arguments.set_item("supports", self.supports(py)?)?;
        arguments.set_item("fluid", self.fluid(py)?)?;
        arguments.set_item("base_motion", self.base_motion(py)?)?;
        arguments.set_item("actuators", self.actuators(py)?)?;
        arguments.set_item("loops", self.loops(py)?)?;
        arguments.set_item("contacts", self.contacts(py)?)?;
        arguments.set_item("magnets", self.magnets(py)?)?;
        arguments.set_item("field", self.field(py)?)?;
        Ok(((self.links(py)?,), arguments))
    }

    fn __traverse__(&self, visit: PyVisit<'_>) -> Result<(), PyTraverseError> {
        self.functions.traverse(&visit)
    }
}

impl PyRobot {
    /// The name of a link as loads refer to it; None if there is only one link.
    fn name_of(&self, link: usize) -> Option<LinkName> {
        let links = &self.description.links;
        (links.len() > 1).then(|| LinkName(links[link].name.clone()))
    }
}

/// The argument `fluid`.
pub(super) fn optional_fluid(value: &Bound<'_, PyAny>) -> PyResult<Option<Fluid>> {
    optional_part(value, "fluid")
}

/// The argument `base_motion`.
pub(super) fn optional_motion(value: &Bound<'_, PyAny>) -> PyResult<Option<BaseMotion>> {
    optional_part(value, "base_motion")
}
