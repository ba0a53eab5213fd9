//! A robot from the arguments of `lissom.Robot`: parts whose links and coordinates are resolved by their names.

use pyo3::prelude::*;

use super::super::actuation::actuators_of;
use super::super::contact::contacts_of;
use super::super::convert;
use super::super::loops::loops_of;
use super::super::part::{optional_part, parts_of, resolved};
use super::super::signal::Functions;
use super::class::PyRobot;
use crate::description::body::described::Body;
use crate::description::schema::{LinkName, Reader};
use crate::description::world::described::BaseMotion;
use crate::robot::described::Link;
use crate::robot::effects::fluid::Fluid;
use crate::robot::effects::load::described::Load;
use crate::robot::effects::support::described::Support;
use crate::robot::{LinkNames, Named, Robot};

/// Arguments of `lissom.Robot`.
pub(super) struct Arguments<'a, 'py> {
    pub(super) links: &'a Bound<'py, PyAny>,
    pub(super) gravity: Option<&'a Bound<'py, PyAny>>,
    pub(super) loads: Option<&'a Bound<'py, PyAny>>,
    pub(super) bodies: Option<&'a Bound<'py, PyAny>>,
    pub(super) supports: Option<&'a Bound<'py, PyAny>>,
    pub(super) fluid: Option<Fluid>,
    pub(super) base_motion: Option<BaseMotion>,
    pub(super) actuators: Option<&'a Bound<'py, PyAny>>,
    pub(super) loops: Option<&'a Bound<'py, PyAny>>,
    pub(super) contacts: Option<&'a Bound<'py, PyAny>>,
}

/// The robot of these parts.
pub(super) fn assembled(arguments: Arguments<'_, '_>) -> PyResult<PyClassInitializer<PyRobot>> {
    let Arguments { links, gravity, loads, bodies, supports, fluid, base_motion, actuators, loops, contacts } =
        arguments;
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
    let on = |link: &Option<LinkName>, reader: &mut Reader| named.only_link("link", link.as_ref(), reader);
    let (mut all_loads, mut all_bodies, mut all_supports) = (Vec::new(), Vec::new(), Vec::new());
    if let Some(loads) = loads {
        let loads: Vec<Load> = parts_of(loads, "loads", &mut functions)?;
        all_loads = resolved(py, "loads", &loads, |it, reader| Some(it.resolved(on(&it.link, reader)?)))?;
    }
    if let Some(bodies) = bodies {
        let bodies: Vec<Body> = parts_of(bodies, "bodies", &mut functions)?;
        all_bodies = resolved(py, "bodies", &bodies, |it, reader| Some(it.resolved(on(&it.link, reader)?)))?;
    }
    if let Some(supports) = supports {
        let supports: Vec<Support> = parts_of(supports, "supports", &mut functions)?;
        all_supports =
            resolved(py, "supports", &supports, |it, reader| Some(it.resolved(on(&it.link, reader)?)))?;
    }
    let mut all_actuators = Vec::new();
    if let Some(actuators) = actuators {
        all_actuators = actuators_of(actuators, &named, &mut functions)?;
    }
    let all_loops = loops.map_or(Ok(Vec::new()), |loops| loops_of(loops, &named))?;
    let all_contacts = contacts.map_or(Ok(Vec::new()), |contacts| contacts_of(contacts, &named))?;
    (robot.loads, robot.bodies, robot.supports) = (all_loads, all_bodies, all_supports);
    (robot.actuators, robot.loops, robot.contacts) = (all_actuators, all_loops, all_contacts);
    robot.fluid = fluid;
    robot.base_motion = base_motion.map(|motion| motion.resolved());
    PyRobot::initializer(robot)
}

/// The argument `fluid`.
pub(in crate::python) fn optional_fluid(value: &Bound<'_, PyAny>) -> PyResult<Option<Fluid>> {
    optional_part(value, "fluid")
}

/// The argument `base_motion`.
pub(in crate::python) fn optional_motion(value: &Bound<'_, PyAny>) -> PyResult<Option<BaseMotion>> {
    optional_part(value, "base_motion")
}
