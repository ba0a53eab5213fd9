//! The class `lissom.Robot`: a description, the Python objects of its functions, and compiled models.

use std::sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError};

use pyo3::PyTypeInfo;
use pyo3::prelude::*;

use super::super::model::{PyModel, Source, check_modes};
use super::super::part::describe_model;
use super::super::signal::Functions;
use crate::description::schema::Part;
use crate::model::Dynamics as _;
use crate::python::errors::OrRaise as _;
use crate::robot::{Robot, RobotModel, described};

/// A robot. The table [`described::Robot`] documents its arguments.
#[pyclass(name = "Robot", module = "lissom", extends = PyModel, subclass, frozen)]
pub(crate) struct PyRobot {
    description: Robot,
    /// Its parts as users describe them, made on first use.
    described: OnceLock<Arc<described::Robot>>,
    pub(super) functions: Functions,
    source: Source,
    // A separate model for kinematics, made on first use.
    kinematics: OnceLock<Mutex<RobotModel>>,
    // The wrench that keeps a planar robot in its plane is known only to a spatial model, compiled on first
    // use.
    spatial: OnceLock<RobotModel>,
}

impl PyRobot {
    /// The description of the robot.
    pub(in crate::python) fn description(&self) -> &Robot {
        &self.description
    }

    /// The same, unless its modes are open.
    pub(super) fn with_coordinates(&self) -> PyResult<&Robot> {
        check_modes(&self.description).map(|()| &self.description)
    }

    /// The parts of the robot as users describe them.
    pub(super) fn described(&self) -> Arc<described::Robot> {
        self.described.get_or_init(|| Arc::new(self.description.described())).clone()
    }

    /// The Python objects that own the functions of this robot must still be alive.
    pub(in crate::python) fn initializer(description: Robot) -> PyResult<PyClassInitializer<Self>> {
        description.validate().or_raise()?;
        Self::initializer_of_valid(description)
    }

    /// The same for a description that has been found valid.
    pub(in crate::python) fn initializer_of_valid(description: Robot) -> PyResult<PyClassInitializer<Self>> {
        Python::attach(|py| {
            let functions = Functions::of_robot(py, &description)?;
            let model = py.detach(|| RobotModel::of_valid(&description).map(PyModel::new)).or_raise()?;
            let source = model.source();
            Ok(PyClassInitializer::from(model).add_subclass(Self {
                description,
                described: OnceLock::new(),
                functions,
                source,
                kinematics: OnceLock::new(),
                spatial: OnceLock::new(),
            }))
        })
    }

    /// The model for kinematics, locked, unless modes are open.
    pub(super) fn kinematics(&self) -> PyResult<MutexGuard<'_, RobotModel>> {
        self.with_coordinates().map(|_| self.compiled())
    }

    /// The same, also of a robot that stands in for one with open modes.
    pub(super) fn compiled(&self) -> MutexGuard<'_, RobotModel> {
        let model = self.kinematics.get_or_init(|| Mutex::new(self.source.robot_model()));
        model.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// A copy of the model, unless modes are open.
    pub(in crate::python) fn model(&self) -> PyResult<RobotModel> {
        Ok(self.kinematics()?.clone())
    }

    /// The time interval over which the prescribed motions are defined.
    pub(super) fn span(&self) -> [f64; 2] {
        self.compiled().facts().time_span
    }

    /// A copy of the spatial model.
    pub(super) fn spatial(&self) -> PyResult<RobotModel> {
        self.with_coordinates()?;
        if let Some(model) = self.spatial.get() {
            return Ok(model.clone());
        }
        let model = RobotModel::spatial(&self.description).or_raise()?;
        Ok(self.spatial.get_or_init(|| model).clone())
    }
}

/// Gives the class what follows from the table of its description.
pub(in crate::python) fn describe_class(py: Python<'_>) -> PyResult<()> {
    describe_model(&PyRobot::type_object(py), described::Robot::SCHEMA, |object| {
        object.cast::<PyRobot>().ok().map(|robot| robot.get().described() as _)
    })
}

/// The number of coordinates, or that modes are open.
pub(in crate::python) fn coordinates(robot: &Robot) -> String {
    match robot.open_segments().is_empty() {
        true => format!("n = {}", robot.coordinates()),
        false => "modes open".to_owned(),
    }
}
