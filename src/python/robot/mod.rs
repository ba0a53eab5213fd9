//! `lissom.Robot`: its methods, each of which is in the file of its subject.

#![allow(non_snake_case, reason = "X is the arc length of the unstretched rod everywhere in this field")]

mod actuators;
mod class;
mod closure;
mod places;
mod states;
mod targets;
mod touching;
mod wrenches;

use std::hash::{DefaultHasher, Hash as _, Hasher as _};

use pyo3::class::{PyTraverseError, PyVisit};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList, PySlice, PyTuple};

use self::states::At;
use super::arguments;
use super::curve::{self, PyCurveResult};
use super::part::{model_of, new_arguments, resolved};
use super::reach::{PyReachResult, ReachArguments};
use super::signal::Functions;
use crate::python::errors::OrRaise as _;
use crate::python::words::required;
use crate::robot::{Kernel, Multiplications, Robot, described};

pub(super) use self::class::{PyRobot, coordinates, describe_class};

/// A hash that equal robots share, of names alone: functions of time may have no hash.
pub(super) fn hash_of(robot: &Robot) -> u64 {
    let mut hasher = DefaultHasher::new();
    robot.coordinate_names().hash(&mut hasher);
    hasher.finish()
}

#[pymethods]
impl PyRobot {
    #[new]
    #[pyo3(signature = (*args, **kwargs))]
    fn new(
        args: &Bound<'_, PyTuple>,
        kwargs: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<PyClassInitializer<Self>> {
        // Own the functions until the robot does; iterators keep no references to their items.
        let mut functions = Functions::default();
        let described = model_of::<described::Robot>(args, kwargs, &mut functions)?;
        let (robot, _) = resolved(args.py(), |reader| described.resolved(false, reader))?;
        Self::initializer(robot)
    }

    /// Robots are equal if their descriptions are.
    fn __eq__(slf: &Bound<'_, Self>, other: &Bound<'_, Self>) -> bool {
        let are_alike = slf.get_type().is(other.get_type());
        are_alike && (slf.is(other) || slf.get().description() == other.get().description())
    }

    fn __hash__(&self) -> u64 {
        hash_of(self.description())
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
    #[pyo3(signature = (*args, **options), text_signature = "(path, **options)")]
    fn from_urdf<'py>(
        args: &Bound<'py, PyTuple>,
        options: Option<&Bound<'py, PyDict>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        args.py().import("lissom.urdf")?.getattr("robot_from_urdf")?.call(args, options)
    }

    /// Names of the coordinates: the name of the link, a dot, and the name of the coordinate within the link.
    #[getter]
    fn coordinates<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyTuple>> {
        PyTuple::new(py, self.with_coordinates()?.coordinate_names())
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
        let range = self
            .with_coordinates()?
            .coordinates_of(self.description().link_named(Some(link), "link").or_raise()?);
        Ok(PySlice::new(py, range.start.cast_signed(), range.end.cast_signed(), 1))
    }

    /// Number of constraints: those of all loops, plus one for each inextensible tendon.
    #[getter]
    fn constraints(&self) -> usize {
        self.description().constraints()
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
        closure::redundant(self, py, q)
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
    #[pyo3(signature = (name=None, q=None, *, t=None, **others),
           text_signature = "($self, name, q, *, t=None)")]
    fn actuator_length<'py>(
        &self,
        #[pyo3(from_py_with = arguments::given_text::name)] name: Option<&str>,
        #[pyo3(from_py_with = arguments::given)] q: Option<&Bound<'py, PyAny>>,
        t: Option<&Bound<'py, PyAny>>,
        others: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let (name, q) = required!("Robot.actuator_length", others, name, q);
        actuators::length(self, name, q, t)
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
    #[pyo3(signature = (name=None, q=None, qd=None, *, t=None, **others),
           text_signature = "($self, name, q, qd, *, t=None)")]
    fn actuator_rate<'py>(
        &self,
        #[pyo3(from_py_with = arguments::given_text::name)] name: Option<&str>,
        #[pyo3(from_py_with = arguments::given)] q: Option<&Bound<'py, PyAny>>,
        #[pyo3(from_py_with = arguments::given)] qd: Option<&Bound<'py, PyAny>>,
        t: Option<&Bound<'py, PyAny>>,
        others: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let (name, q, qd) = required!("Robot.actuator_rate", others, name, q, qd);
        actuators::rate(self, name, [q, qd], t)
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
    #[pyo3(signature = (name=None, q=None, *, t=None, **others),
           text_signature = "($self, name, q, *, t=None)")]
    fn actuator_gradient<'py>(
        &self,
        #[pyo3(from_py_with = arguments::given_text::name)] name: Option<&str>,
        #[pyo3(from_py_with = arguments::given)] q: Option<&Bound<'py, PyAny>>,
        t: Option<&Bound<'py, PyAny>>,
        others: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let (name, q) = required!("Robot.actuator_gradient", others, name, q);
        actuators::gradient(self, name, q, t)
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
    #[pyo3(signature = (name=None, q=None, qd=None, *, t=None, u=None, qdd=None, **others),
           text_signature = "($self, name, q, qd, *, t=None, u=None, qdd=None)")]
    #[allow(clippy::too_many_arguments, reason = "keyword-only options of a Python method")]
    fn actuator_force<'py>(
        &self,
        #[pyo3(from_py_with = arguments::given_text::name)] name: Option<&str>,
        #[pyo3(from_py_with = arguments::given)] q: Option<&Bound<'py, PyAny>>,
        #[pyo3(from_py_with = arguments::given)] qd: Option<&Bound<'py, PyAny>>,
        t: Option<&Bound<'py, PyAny>>,
        u: Option<&Bound<'py, PyAny>>,
        qdd: Option<&Bound<'py, PyAny>>,
        others: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let (name, q, qd) = required!("Robot.actuator_force", others, name, q, qd);
        actuators::force(self, name, [q, qd], qdd, At::forces(t, u))
    }

    /// Number of quadrature nodes of each segment.
    #[getter]
    fn nodes<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyTuple>> {
        PyTuple::new(py, self.kinematics()?.nodes())
    }

    /// Kernel that computes the robot: "planar" if its joints, modes and reference strains keep it in one plane, else "spatial".
    #[getter]
    fn kernel(&self) -> PyResult<&'static str> {
        Ok(match self.kinematics()?.kernel() {
            Kernel::Planar => "planar",
            Kernel::Spatial => "spatial",
        })
    }

    /// Estimated number of floating-point multiplications of one evaluation, by kind of evaluation; accurate to about a tenth
    /// for rods.
    ///
    /// ``"residual"``: inverse dynamics; ``"tangent"``: Jacobian of an implicit step, given the residual; ``"mass_matrix"``:
    /// mass matrix, given the shape; ``"factorisation"`` (LU) and ``"solution"`` of the linear system of a step. A
    /// multiply-add counts as one.
    #[getter]
    fn multiplications<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let Multiplications { residual, tangent, mass_matrix, factorisation, solution } =
            self.kinematics()?.multiplications();
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
    fn explain(&self) -> PyResult<String> {
        Ok(self.kinematics()?.full_explanation().to_string())
    }

    /// Questions about numbers that are probably in other units.
    fn _implausible_units(&self) -> Vec<String> {
        self.description().implausible_units()
    }

    /// Stiffness of every contact: given, of the material or from the loads.
    fn _contact_stiffness(&self) -> Vec<f64> {
        self.compiled().contact_stiffness()
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
    #[pyo3(signature = (q=None, X=None, *more, link=None, t=None, **others),
           text_signature = "($self, q, X=None, *, link=None, t=None)")]
    fn pose<'py>(
        &self,
        #[pyo3(from_py_with = arguments::given)] q: Option<&Bound<'py, PyAny>>,
        X: Option<&Bound<'py, PyAny>>,
        more: &Bound<'_, PyTuple>,
        #[pyo3(from_py_with = arguments::optional_text::link)] link: Option<&str>,
        t: Option<&Bound<'py, PyAny>>,
        others: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let q = required!("Robot.pose", others; more, q);
        places::poses(self, q, X, link, t)
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
    #[pyo3(signature = (q=None, X=None, *, link=None, t=None, **others),
           text_signature = "($self, q, X=None, *, link=None, t=None)")]
    fn jacobian<'py>(
        &self,
        #[pyo3(from_py_with = arguments::given)] q: Option<&Bound<'py, PyAny>>,
        #[pyo3(from_py_with = arguments::optional_number::X)] X: Option<f64>,
        #[pyo3(from_py_with = arguments::optional_text::link)] link: Option<&str>,
        t: Option<&Bound<'py, PyAny>>,
        others: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let q = required!("Robot.jacobian", others, q);
        places::jacobian(self, q, X, link, t)
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
    #[pyo3(signature = (q=None, qd=None, X=None, *, link=None, t=None, **others),
           text_signature = "($self, q, qd, X=None, *, link=None, t=None)")]
    fn velocity<'py>(
        &self,
        #[pyo3(from_py_with = arguments::given)] q: Option<&Bound<'py, PyAny>>,
        #[pyo3(from_py_with = arguments::given)] qd: Option<&Bound<'py, PyAny>>,
        #[pyo3(from_py_with = arguments::optional_number::X)] X: Option<f64>,
        #[pyo3(from_py_with = arguments::optional_text::link)] link: Option<&str>,
        t: Option<&Bound<'py, PyAny>>,
        others: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let (q, qd) = required!("Robot.velocity", others, q, qd);
        places::velocity(self, [q, qd], X, link, t)
    }

    /// Acceleration of a section or body.
    ///
    #[doc = include_str!("acceleration.txt")]
    #[pyo3(signature = (q=None, qd=None, qdd=None, X=None, *, link=None, t=None, **others),
           text_signature = "($self, q, qd, qdd, X=None, *, link=None, t=None)")]
    #[allow(clippy::too_many_arguments, reason = "keyword-only options of a Python method")]
    fn acceleration<'py>(
        &self,
        #[pyo3(from_py_with = arguments::given)] q: Option<&Bound<'py, PyAny>>,
        #[pyo3(from_py_with = arguments::given)] qd: Option<&Bound<'py, PyAny>>,
        #[pyo3(from_py_with = arguments::given)] qdd: Option<&Bound<'py, PyAny>>,
        #[pyo3(from_py_with = arguments::optional_number::X)] X: Option<f64>,
        #[pyo3(from_py_with = arguments::optional_text::link)] link: Option<&str>,
        t: Option<&Bound<'py, PyAny>>,
        others: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let (q, qd, qdd) = required!("Robot.acceleration", others, q, qd, qdd);
        places::acceleration(self, [q, qd, qdd], X, link, t)
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
    #[pyo3(signature = (q=None, *, t=None, **others),
           text_signature = "($self, q, *, t=None)")]
    fn centre_of_mass<'py>(
        &self,
        #[pyo3(from_py_with = arguments::given)] q: Option<&Bound<'py, PyAny>>,
        t: Option<&Bound<'py, PyAny>>,
        others: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let q = required!("Robot.centre_of_mass", others, q);
        wrenches::centre_of_mass(self, q, t)
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
    #[pyo3(signature = (q=None, qd=None, *, t=None, **others),
           text_signature = "($self, q, qd, *, t=None)")]
    fn momentum<'py>(
        &self,
        #[pyo3(from_py_with = arguments::given)] q: Option<&Bound<'py, PyAny>>,
        #[pyo3(from_py_with = arguments::given)] qd: Option<&Bound<'py, PyAny>>,
        t: Option<&Bound<'py, PyAny>>,
        others: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let (q, qd) = required!("Robot.momentum", others, q, qd);
        wrenches::momentum(self, [q, qd], t)
    }

    /// Moment and force that a link receives through its joint, from its parent or the world, during a
    /// motion.
    ///
    /// Parameters
    /// ----------
    /// q, qd, qdd : array_like, shape (n,) or (k, n)
    ///     Coordinates, velocities and accelerations of a state, or of k states.
    /// link : str, optional
    ///     Name of the link; optional if the robot has only one. It may also stand before `q`.
    /// t : float or array_like, shape (k,), optional
    ///     Time of the state, or of each of the k states, seconds. Required if loads vary or the base moves.
    /// u : array_like, shape (m,) or (k, m), optional
    ///     Inputs for all states or for each; by default `u0`.
    ///
    /// Returns
    /// -------
    /// wrench : ndarray, shape (6,) or (k, 6)
    ///     Moment about the origin of the joint's frame, newton metres, and force, newtons, in world axes.
    #[pyo3(signature = (q=None, qd=None, qdd=None, last=None, *, link=None, t=None, u=None, **others),
           text_signature = "($self, q, qd, qdd, *, link=None, t=None, u=None)")]
    #[allow(clippy::too_many_arguments, reason = "keyword-only options of a Python method")]
    fn joint_wrench<'py>(
        &self,
        #[pyo3(from_py_with = arguments::given)] q: Option<&Bound<'py, PyAny>>,
        #[pyo3(from_py_with = arguments::given)] qd: Option<&Bound<'py, PyAny>>,
        #[pyo3(from_py_with = arguments::given)] qdd: Option<&Bound<'py, PyAny>>,
        last: Option<&Bound<'py, PyAny>>,
        #[pyo3(from_py_with = arguments::optional_text::link)] link: Option<&str>,
        t: Option<&Bound<'py, PyAny>>,
        u: Option<&Bound<'py, PyAny>>,
        others: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let (q, qd, qdd) = required!("Robot.joint_wrench", others, q, qd, qdd);
        let (state, link) = wrenches::named_state("joint_wrench", "link", [q, qd, qdd], last, link)?;
        wrenches::joint(self, state, link, At::forces(t, u))
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
    ///     Name of the loop; optional if the robot has only one. It may also stand before `q`.
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
    #[pyo3(signature = (q=None, qd=None, qdd=None, last=None, *, name=None, t=None, u=None, **others),
           text_signature = "($self, q, qd, qdd, *, name=None, t=None, u=None)")]
    #[allow(clippy::too_many_arguments, reason = "keyword-only options of a Python method")]
    fn loop_forces<'py>(
        &self,
        #[pyo3(from_py_with = arguments::given)] q: Option<&Bound<'py, PyAny>>,
        #[pyo3(from_py_with = arguments::given)] qd: Option<&Bound<'py, PyAny>>,
        #[pyo3(from_py_with = arguments::given)] qdd: Option<&Bound<'py, PyAny>>,
        last: Option<&Bound<'py, PyAny>>,
        #[pyo3(from_py_with = arguments::optional_text::name)] name: Option<&str>,
        t: Option<&Bound<'py, PyAny>>,
        u: Option<&Bound<'py, PyAny>>,
        others: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let (q, qd, qdd) = required!("Robot.loop_forces", others, q, qd, qdd);
        let (state, name) = wrenches::named_state("loop_forces", "name", [q, qd, qdd], last, name)?;
        closure::forces(self, state, name, At::forces(t, u))
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
    #[pyo3(signature = (q=None, qd=None, *, name=None, t=None, **others),
           text_signature = "($self, q, qd, *, name=None, t=None)")]
    fn contact_forces<'py>(
        &self,
        #[pyo3(from_py_with = arguments::given)] q: Option<&Bound<'py, PyAny>>,
        #[pyo3(from_py_with = arguments::given)] qd: Option<&Bound<'py, PyAny>>,
        #[pyo3(from_py_with = arguments::optional_text::name)] name: Option<&str>,
        t: Option<&Bound<'py, PyAny>>,
        others: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let (q, qd) = required!("Robot.contact_forces", others, q, qd);
        touching::forces(self, [q, qd], name, t)
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
    #[pyo3(signature = (q=None, qd=None, *, t=None, **others),
           text_signature = "($self, q, qd=None, *, t=None)")]
    fn touches<'py>(
        &self,
        py: Python<'py>,
        #[pyo3(from_py_with = arguments::given)] q: Option<&Bound<'py, PyAny>>,
        qd: Option<&Bound<'py, PyAny>>,
        #[pyo3(from_py_with = arguments::optional_number::t)] t: Option<f64>,
        others: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<Bound<'py, PyList>> {
        let q = required!("Robot.touches", others, q);
        touching::touches(self, py, q, qd, t)
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
        closure::at_rest(self, q, At::forces(t, u))
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
    #[pyo3(signature = (q=None, *, t=None, **others),
           text_signature = "($self, q, *, t=None)")]
    fn loop_gaps<'py>(
        &self,
        #[pyo3(from_py_with = arguments::given)] q: Option<&Bound<'py, PyAny>>,
        t: Option<&Bound<'py, PyAny>>,
        others: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let q = required!("Robot.loop_gaps", others, q);
        closure::gaps(self, q, t)
    }

    /// Strains of sections of a rod.
    ///
    #[doc = include_str!("strain.txt")]
    #[pyo3(signature = (q=None, X=None, *, link=None, **others),
           text_signature = "($self, q, X=None, *, link=None)")]
    fn strain<'py>(
        &self,
        #[pyo3(from_py_with = arguments::given)] q: Option<&Bound<'py, PyAny>>,
        X: Option<&Bound<'py, PyAny>>,
        #[pyo3(from_py_with = arguments::optional_text::link)] link: Option<&str>,
        others: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let q = required!("Robot.strain", others, q);
        places::strains(self, q, X, link)
    }

    /// Internal moment and force in sections of a rod during a motion: the wrench that the part before a section exerts on
    /// everything beyond it.
    ///
    #[doc = include_str!("internal_wrench.txt")]
    #[pyo3(signature = (q=None, qd=None, qdd=None, X=None, *, link=None, t=None, by="balance", u=None, **others),
           text_signature = "($self, q, qd, qdd, X=None, *, link=None, t=None, by='balance', u=None)")]
    #[allow(clippy::too_many_arguments, reason = "keyword-only options of a Python method")]
    fn internal_wrench<'py>(
        &self,
        #[pyo3(from_py_with = arguments::given)] q: Option<&Bound<'py, PyAny>>,
        #[pyo3(from_py_with = arguments::given)] qd: Option<&Bound<'py, PyAny>>,
        #[pyo3(from_py_with = arguments::given)] qdd: Option<&Bound<'py, PyAny>>,
        X: Option<&Bound<'py, PyAny>>,
        #[pyo3(from_py_with = arguments::optional_text::link)] link: Option<&str>,
        t: Option<&Bound<'py, PyAny>>,
        #[pyo3(from_py_with = arguments::text::by)] by: &str,
        u: Option<&Bound<'py, PyAny>>,
        others: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let (q, qd, qdd) = required!("Robot.internal_wrench", others, q, qd, qdd);
        wrenches::internal(self, [q, qd, qdd], X, link, by, At::forces(t, u))
    }

    /// Inverse kinematics: find a shape in which links have given poses.
    ///
    #[doc = include_str!("reach.txt")]
    #[pyo3(signature = (link=None, pose=None, *, X=None, point=None, position_weight=None, orientation_weight=None, q0=None,
                        bounds=None, prefer=None, t=None, tol=None, max_iter=None, restarts=None, **others),
           text_signature = "($self, link, pose=None, *, X=None, point=None, position_weight=1.0, orientation_weight=1.0, q0=None, bounds=None, prefer=None, t=None, tol=1e-09, max_iter=200, restarts=8)")]
    #[allow(clippy::too_many_arguments, reason = "keyword-only options of a Python method")]
    fn reach<'py>(
        &self,
        #[pyo3(from_py_with = arguments::given)] link: Option<&Bound<'py, PyAny>>,
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
        others: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<PyReachResult> {
        let link = required!("Robot.reach", others, link);
        let weights = [position_weight, orientation_weight];
        let arguments = ReachArguments { q0, bounds, prefer, tol, max_iter, restarts };
        targets::reach(self, link, pose, (X, point), weights, &arguments, t)
    }

    /// The coordinates with which a rod follows given points best.
    ///
    #[doc = include_str!("coordinates_of.txt")]
    #[pyo3(signature = (points=None, frames=None, *, X=None, link=None, q0=None, **others),
           text_signature = "($self, points, frames=None, *, X=None, link=None, q0=None)")]
    fn coordinates_of<'py>(
        &self,
        #[pyo3(from_py_with = arguments::given)] points: Option<&Bound<'py, PyAny>>,
        frames: Option<&Bound<'py, PyAny>>,
        X: Option<&Bound<'py, PyAny>>,
        #[pyo3(from_py_with = arguments::optional_text::link)] link: Option<&str>,
        q0: Option<&Bound<'py, PyAny>>,
        others: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<PyCurveResult> {
        let points = required!("Robot.coordinates_of", others, points);
        let given = curve::CurveArguments { points, frames, x: X, link, q0 };
        curve::coordinates_of(points.py(), self.description(), &given)
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
    #[pyo3(signature = (q=None, qd=None, qdd=None, *, t=None, u=None, **others),
           text_signature = "($self, q, qd, qdd, *, t=None, u=None)")]
    fn base_wrench<'py>(
        &self,
        #[pyo3(from_py_with = arguments::given)] q: Option<&Bound<'py, PyAny>>,
        #[pyo3(from_py_with = arguments::given)] qd: Option<&Bound<'py, PyAny>>,
        #[pyo3(from_py_with = arguments::given)] qdd: Option<&Bound<'py, PyAny>>,
        t: Option<&Bound<'py, PyAny>>,
        u: Option<&Bound<'py, PyAny>>,
        others: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let (q, qd, qdd) = required!("Robot.base_wrench", others, q, qd, qdd);
        wrenches::base(self, [q, qd, qdd], At::forces(t, u))
    }

    fn __repr__(&self) -> String {
        let links = self.description().links.len();
        let plural = if links == 1 { "" } else { "s" };
        format!("<lissom.Robot of {links} link{plural}, {}>", coordinates(self.description()))
    }

    /// For copies and pickles.
    fn __getnewargs_ex__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyTuple>, Bound<'py, PyDict>)> {
        new_arguments(py, self.described().as_ref())
    }

    fn __traverse__(&self, visit: PyVisit<'_>) -> Result<(), PyTraverseError> {
        self.functions.traverse(&visit)
    }
}
