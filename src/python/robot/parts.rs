//! The Python objects of the parts of a robot.

use std::sync::Arc;

use pyo3::prelude::*;
use pyo3::types::PyTuple;

use super::super::part::wrapped;
use super::class::PyRobot;
use crate::description::schema::LinkName;

impl PyRobot {
    /// The name of a link as loads refer to it; None if there is only one link.
    fn name_of(&self, link: usize) -> Option<LinkName> {
        let links = &self.description().links;
        (links.len() > 1).then(|| LinkName(links[link].name.clone()))
    }
}

/// The links, parents before their children.
pub(super) fn links<'py>(robot: &PyRobot, py: Python<'py>) -> PyResult<Bound<'py, PyTuple>> {
    let robot = robot.description();
    let links = robot.links.iter().map(|link| wrapped(py, Arc::new(robot.described_link(link))));
    PyTuple::new(py, links.collect::<PyResult<Vec<_>>>()?)
}

/// The loads.
pub(super) fn loads<'py>(robot: &PyRobot, py: Python<'py>) -> PyResult<Bound<'py, PyTuple>> {
    let loads = &robot.description().loads;
    let out = loads.iter().map(|load| wrapped(py, Arc::new(load.described(robot.name_of(load.link)))));
    PyTuple::new(py, out.collect::<PyResult<Vec<_>>>()?)
}

/// Additional rigid bodies.
pub(super) fn bodies<'py>(robot: &PyRobot, py: Python<'py>) -> PyResult<Bound<'py, PyTuple>> {
    let bodies = &robot.description().bodies;
    let out = bodies.iter().map(|body| wrapped(py, Arc::new(body.described(robot.name_of(body.link)))));
    PyTuple::new(py, out.collect::<PyResult<Vec<_>>>()?)
}

/// Springs and dampers to the world.
pub(super) fn supports<'py>(robot: &PyRobot, py: Python<'py>) -> PyResult<Bound<'py, PyTuple>> {
    let out = robot.description().supports.iter().map(|support| {
        let link = robot.name_of(support.link);
        wrapped(py, Arc::new(support.described(link)))
    });
    PyTuple::new(py, out.collect::<PyResult<Vec<_>>>()?)
}
