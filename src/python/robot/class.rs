//! The class `lissom.Robot`: a description, the Python objects of its functions, and compiled models.

use std::sync::{Mutex, MutexGuard, OnceLock, PoisonError};

use pyo3::prelude::*;

use super::super::model::PyModel;
use super::super::signal::Functions;
use crate::error::InvalidInput;
use crate::model::Dynamics as _;
use crate::robot::{Robot, RobotModel};

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
    pub(super) functions: Functions,
    // A separate model for kinematics; the base class knows its model only as a Model.
    kinematics: Mutex<RobotModel>,
    // The wrench that keeps a planar robot in its plane is known only to a spatial model, compiled on first
    // use.
    spatial: OnceLock<RobotModel>,
}

impl PyRobot {
    /// The description of the robot.
    pub(in crate::python) fn description(&self) -> &Robot {
        &self.description
    }

    /// The Python objects that own the functions of this robot must still be alive.
    pub(in crate::python) fn initializer(description: Robot) -> PyResult<PyClassInitializer<Self>> {
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

    /// The model for kinematics, locked.
    pub(super) fn kinematics(&self) -> MutexGuard<'_, RobotModel> {
        self.kinematics.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// A copy of the model.
    pub(in crate::python) fn model(&self) -> RobotModel {
        self.kinematics().clone()
    }

    /// The time interval over which the prescribed motions are defined.
    pub(super) fn span(&self) -> [f64; 2] {
        self.kinematics().facts().time_span
    }

    /// A copy of the spatial model.
    pub(super) fn spatial(&self) -> PyResult<RobotModel> {
        if let Some(model) = self.spatial.get() {
            return Ok(model.clone());
        }
        let model = RobotModel::spatial(&self.description)?;
        Ok(self.spatial.get_or_init(|| model).clone())
    }
}
