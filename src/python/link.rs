//! Conversion of links and joints: Python objects with the attributes of `lissom.Link` and the joint classes.

use std::cell::OnceCell;
use std::collections::HashMap;
use std::sync::Arc;

use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use super::convert;
use super::part::{optional_part, wrapped};
use super::segment::PySegment;
use super::signal::{Functions, signal_of, signal_out};
use crate::body::described::Body;
use crate::description::suggestion;
use crate::error::{Checker, InvalidInput};
use crate::joint::{Joint, JointForces};
use crate::robot::{Driven, Link, Robot};
use crate::world::described::BaseMotion;

/// The object at a place of an error: the joint's attribute, such as `axis`, or the joint itself.
fn attribute<'py>(object: &Bound<'py, PyAny>, name: &str) -> PyResult<Bound<'py, PyAny>> {
    object.getattr(name)
}

fn array<const N: usize>(object: &Bound<'_, PyAny>, name: &str) -> PyResult<[f64; N]> {
    convert::array_of(&attribute(object, name)?, name)
}

fn number(object: &Bound<'_, PyAny>, name: &str) -> PyResult<f64> {
    convert::number(&attribute(object, name)?, name)
}

fn forces(object: &Bound<'_, PyAny>) -> PyResult<JointForces> {
    let limits = attribute(object, "limits")?;
    Ok(JointForces {
        stiffness: number(object, "stiffness")?,
        rest: number(object, "rest")?,
        damping: number(object, "damping")?,
        friction: number(object, "friction")?,
        friction_velocity: number(object, "friction_velocity")?,
        limits: if limits.is_none() { None } else { Some(convert::array_of(&limits, "limits")?) },
        limit_stiffness: number(object, "limit_stiffness")?,
        limit_dissipation: number(object, "limit_dissipation")?,
        armature: number(object, "armature")?,
    })
}

/// Converts an object of one of the joint classes to a joint.
pub(super) fn joint_of(object: &Bound<'_, PyAny>) -> PyResult<Joint> {
    let kind = object.get_type().name()?.to_string();
    Ok(match kind.as_str() {
        "Weld" => Joint::Weld,
        "Revolute" => Joint::Revolute { axis: array(object, "axis")?, forces: forces(object)? },
        "Prismatic" => Joint::Prismatic { axis: array(object, "axis")?, forces: forces(object)? },
        "Cylindrical" => Joint::Cylindrical { axis: array(object, "axis")? },
        "Universal" => Joint::Universal { axes: [array(object, "axis1")?, array(object, "axis2")?] },
        "Planar" => Joint::Planar { normal: array(object, "normal")? },
        "Spherical" => Joint::Spherical,
        "Free" => Joint::Free,
        _ => {
            let expected = "a joint: lissom.Weld, Revolute, Prismatic, Cylindrical, Universal, Planar, Spherical or Free";
            let found = convert::describe(object);
            return Err(PyTypeError::new_err(format!("joint: expected {expected}, got {found}")));
        }
    })
}

/// Stands for the mimicked joint until all links are known.
const UNKNOWN: usize = usize::MAX;

/// Source of a driven joint, and the name of the link that it mimics; adds its functions of time to
/// `functions`.
fn driven_of(
    object: &Bound<'_, PyAny>,
    functions: &mut Functions,
) -> PyResult<(Option<Driven>, Option<String>)> {
    let given = |name: &str| -> PyResult<Option<Bound<'_, PyAny>>> {
        Ok(object.getattr_opt(name)?.filter(|value| !value.is_none()))
    };
    let (motion, mimic) = (given("motion")?, given("mimic")?);
    let Some(mimic) = mimic else {
        let Some(motion) = motion else { return Ok((None, None)) };
        let driven = match object.get_type().name()? == "Free" {
            true => {
                Driven::Base(optional_part::<BaseMotion>(&motion, "motion")?.expect("it is given").resolved())
            }
            false => Driven::Coordinate(signal_of(&motion, "motion", functions)?),
        };
        return Ok((Some(driven), None));
    };
    if motion.is_some() {
        return Err(PyValueError::new_err("mimic: got both motion and mimic, expected one of them"));
    }
    if mimic.get_type().name()? != "Mimic" {
        let found = convert::describe(&mimic);
        return Err(PyTypeError::new_err(format!("mimic: expected lissom.Mimic or None, got {found}")));
    }
    let (driven, name) = mimic_of(&mimic)?;
    Ok((Some(driven), Some(name)))
}

/// The relation by which a joint mimics that of the link with this name.
fn mimic_of(mimic: &Bound<'_, PyAny>) -> PyResult<(Driven, String)> {
    let name = attribute(mimic, "link")?
        .extract()
        .map_err(|_| PyTypeError::new_err("mimic.link: expected the name of a link"))?;
    let part = |name: &str| convert::number(&attribute(mimic, name)?, &format!("mimic.{name}"));
    let driven = Driven::Mimic { link: UNKNOWN, multiplier: part("multiplier")?, offset: part("offset")? };
    Ok((driven, name))
}

/// Rejects an invalid relation between joints; the robot checks whether the other joint exists.
#[pyfunction]
pub(crate) fn check_mimic(mimic: &Bound<'_, PyAny>) -> PyResult<()> {
    let mut check = Checker::new();
    mimic_of(mimic)?.0.check_numbers(&mut check);
    Ok(check.finish()?)
}

/// Rejects an invalid joint with all its problems; the robot checks whether a mimicked joint exists.
#[pyfunction]
pub(crate) fn check_joint(object: &Bound<'_, PyAny>) -> PyResult<()> {
    let joint = joint_of(object)?;
    let (driven, _) = driven_of(object, &mut Functions::default())?;
    let mut check = Checker::new();
    check.all(joint.validate());
    if let Some(driven) = driven {
        check.all(driven.validate(&joint));
    }
    Ok(check.finish()?)
}

/// Rejects a link that is invalid on its own; the robot checks whether it fits.
#[pyfunction]
pub(crate) fn check_link(link: &Bound<'_, PyAny>) -> PyResult<()> {
    parent_of(link)?;
    Ok(alone(link, &mut Functions::default())?.0.validate()?)
}

/// Name of the parent of a link.
fn parent_of(object: &Bound<'_, PyAny>) -> PyResult<Option<String>> {
    let parent = attribute(object, "parent")?;
    if parent.is_none() {
        Ok(None)
    } else {
        convert::text(&parent, "parent").map(|name| Some(name.to_owned()))
    }
}

/// A link without its parent, and the name of the link whose joint it mimics.
fn alone(object: &Bound<'_, PyAny>, functions: &mut Functions) -> PyResult<(Link, Option<String>)> {
    let rod = attribute(object, "rod")?;
    let body = attribute(object, "body")?;
    let at = attribute(object, "at")?;
    let mut segments = Vec::new();
    if !rod.is_none() {
        let wrong = |found: &Bound<'_, PyAny>| {
            let found = convert::describe(found);
            PyTypeError::new_err(format!("rod: expected a sequence of lissom.Segment, got {found}"))
        };
        for segment in rod.try_iter().map_err(|_| wrong(&rod))? {
            let segment = segment?;
            segments.push(segment.cast::<PySegment>().map_err(|_| wrong(&segment))?.get().0.clone());
        }
        if segments.is_empty() {
            return Err(PyValueError::new_err("rod: got no segments, expected at least one, or None"));
        }
    }
    let body: Option<Body> = optional_part(&body, "body")?;
    if body.as_ref().is_some_and(|body| body.link.is_some()) {
        return Err(PyValueError::new_err("body.link: got a name, expected none: the body is this link's"));
    }
    let joint = attribute(object, "joint")?;
    let (driven, mimicked) = driven_of(&joint, functions)?;
    let link = Link {
        name: attribute(object, "name")?
            .extract()
            .map_err(|_| PyTypeError::new_err("name: expected a string"))?,
        parent: None,
        at: if at.is_none() { None } else { Some(number(object, "at")?) },
        position: array(object, "position")?,
        orientation: array(object, "orientation")?,
        joint: joint_of(&joint)?,
        driven,
        rod: segments,
        body: body.map(|body| body.resolved(0)),
    };
    Ok((link, mimicked))
}

/// Links of a sequence, with their parents resolved by name, and the functions of time of their joints.
pub(super) fn links_of(links: &Bound<'_, PyAny>) -> PyResult<(Vec<Link>, Functions)> {
    let wrong = |found: &Bound<'_, PyAny>| {
        let found = convert::describe(found);
        PyTypeError::new_err(format!("links: expected a sequence of lissom.Link, got {found}"))
    };
    let mut found: Vec<Link> = Vec::new();
    let mut places: HashMap<String, usize> = HashMap::new();
    let mut mimicked = Vec::new();
    let mut functions = Functions::default();
    let mut check = Checker::new();
    for (i, object) in links.try_iter().map_err(|_| wrong(links))?.enumerate() {
        let object = object?;
        if object.get_type().name()? != "Link" {
            return Err(wrong(&object));
        }
        let (mut link, mimics) = alone(&object, &mut functions)?;
        mimicked.push(mimics);
        if let Some(parent) = parent_of(&object)? {
            link.parent = places.get(&parent).copied();
            let place = format!("links[{i}].parent");
            let expected = "the name of a link that stands before this one";
            check.require(link.parent.is_some(), &place, format_args!("'{parent}'"), expected);
        }
        // The robot refuses names that two links have.
        places.entry(link.name.clone()).or_insert(i);
        found.push(link);
    }
    for (i, name) in mimicked.into_iter().enumerate() {
        let Some(name) = name else { continue };
        let Some(&place) = places.get(&name) else {
            check.require(
                false,
                &format!("links[{i}].joint.mimic.link"),
                format_args!("'{name}'"),
                &expected_link(&name, &found),
            );
            continue;
        };
        if let Some(Driven::Mimic { link, .. }) = &mut found[i].driven {
            *link = place;
        }
    }
    check.finish()?;
    Ok((found, functions))
}

/// Index of a link of a robot; of the only one if no name is given.
pub(super) fn index_of(robot: &Robot, name: Option<&str>, place: &str) -> Result<usize, InvalidInput> {
    let links = &robot.links;
    let (found, expected) = match name {
        None if links.len() == 1 => return Ok(0),
        None => ("none".to_owned(), one_of_the_links(links)),
        Some(name) => match links.iter().position(|link| link.name == name) {
            Some(link) => return Ok(link),
            None => (format!("'{name}'"), expected_link(name, links)),
        },
    };
    Err(InvalidInput::new(place, found, expected))
}

fn one_of_the_links(links: &[Link]) -> String {
    let names: Vec<String> = links.iter().map(|link| format!("'{}'", link.name)).collect();
    format!("one of the links: {}", names.join(", "))
}

/// What is expected in place of a name that no link has.
fn expected_link(name: &str, links: &[Link]) -> String {
    let similar = suggestion(name, links.iter().map(|link| link.name.as_str()));
    let meant = similar.map_or_else(String::new, |similar| format!("; did you mean '{similar}'?"));
    format!("{}{meant}", one_of_the_links(links))
}

/// The links of a robot by name, for as many searches as the robot has parts.
pub(super) struct Links<'a> {
    robot: &'a Robot,
    places: HashMap<&'a str, usize>,
    coordinates: OnceCell<HashMap<String, usize>>,
}

impl<'a> Links<'a> {
    pub(super) fn of(robot: &'a Robot) -> Self {
        let mut places = HashMap::with_capacity(robot.links.len());
        for (i, link) in robot.links.iter().enumerate() {
            places.entry(link.name.as_str()).or_insert(i);
        }
        Self { robot, places, coordinates: OnceCell::new() }
    }

    /// Index of the link with this name.
    pub(super) fn link(&self, name: &str) -> PyResult<usize> {
        let names = || self.robot.links.iter().map(|link| link.name.as_str());
        self.places.get(name).copied().ok_or_else(|| unknown(name, names(), "a link"))
    }

    /// Index of the coordinate with this name.
    pub(super) fn coordinate(&self, name: &str) -> PyResult<usize> {
        let coordinates = self.coordinates.get_or_init(|| {
            self.robot.coordinate_names().into_iter().enumerate().map(|(i, name)| (name, i)).collect()
        });
        coordinates.get(name).copied().ok_or_else(|| {
            let names = self.robot.coordinate_names();
            unknown(name, names.iter().map(String::as_str), "a coordinate")
        })
    }
}

/// Whether a part of a robot has the name that it would have without one.
pub(super) fn has_default_name(object: &Bound<'_, PyAny>, name: &str) -> PyResult<bool> {
    match object.getattr_opt("_default_name")? {
        Some(default) => default.call0()?.eq(name),
        None => Ok(false),
    }
}

/// The refusal of a name that no part of a robot has; `what` is the kind of the part.
pub(super) fn unknown<'a>(name: &str, known: impl Iterator<Item = &'a str>, what: &str) -> PyErr {
    let meant =
        suggestion(name, known).map_or_else(String::new, |meant| format!("; did you mean '{meant}'?"));
    PyValueError::new_err(format!("got '{name}', expected the name of {what} of the robot{meant}"))
}

/// Python object of the joint of a link.
pub(super) fn joint_out<'py>(py: Python<'py>, link: &Link, links: &[Link]) -> PyResult<Bound<'py, PyAny>> {
    let lissom = py.import("lissom")?;
    let arguments = joint_arguments(py, &link.joint)?;
    match &link.driven {
        None => {}
        Some(Driven::Coordinate(signal)) => arguments.set_item("motion", signal_out(py, signal)?)?,
        Some(Driven::Base(motion)) => {
            arguments.set_item("motion", wrapped(py, Arc::new(motion.described()))?)?;
        }
        Some(Driven::Mimic { link, multiplier, offset }) => {
            let of_mimic = PyDict::new(py);
            of_mimic.set_item("multiplier", multiplier)?;
            of_mimic.set_item("offset", offset)?;
            let mimic = lissom.getattr("Mimic")?.call((&links[*link].name,), Some(&of_mimic))?;
            arguments.set_item("mimic", mimic)?;
        }
    }
    call_class(py, &link.joint, &arguments)
}

/// Constructor arguments of a joint, without its source if it is driven.
fn joint_arguments<'py>(py: Python<'py>, joint: &Joint) -> PyResult<Bound<'py, PyDict>> {
    let arguments = PyDict::new(py);
    let vector = |v: [f64; 3]| <(f64, f64, f64)>::from(v);
    match joint {
        Joint::Weld | Joint::Spherical | Joint::Free => {}
        Joint::Revolute { axis, .. } | Joint::Prismatic { axis, .. } | Joint::Cylindrical { axis } => {
            arguments.set_item("axis", vector(*axis))?;
        }
        Joint::Universal { axes: [first, second] } => {
            arguments.set_item("axis1", vector(*first))?;
            arguments.set_item("axis2", vector(*second))?;
        }
        Joint::Planar { normal } => arguments.set_item("normal", vector(*normal))?,
    }
    if let Some(forces) = joint.forces() {
        arguments.set_item("stiffness", forces.stiffness)?;
        arguments.set_item("rest", forces.rest)?;
        arguments.set_item("damping", forces.damping)?;
        arguments.set_item("friction", forces.friction)?;
        arguments.set_item("friction_velocity", forces.friction_velocity)?;
        arguments.set_item("limits", forces.limits.map(<(f64, f64)>::from))?;
        arguments.set_item("limit_stiffness", forces.limit_stiffness)?;
        arguments.set_item("limit_dissipation", forces.limit_dissipation)?;
        arguments.set_item("armature", forces.armature)?;
    }
    Ok(arguments)
}

/// Python object of a joint that is not driven.
pub(super) fn joint_class<'py>(py: Python<'py>, joint: &Joint) -> PyResult<Bound<'py, PyAny>> {
    call_class(py, joint, &joint_arguments(py, joint)?)
}

fn call_class<'py>(
    py: Python<'py>,
    joint: &Joint,
    arguments: &Bound<'py, PyDict>,
) -> PyResult<Bound<'py, PyAny>> {
    let mut class = joint.name().to_owned();
    class[..1].make_ascii_uppercase();
    py.import("lissom")?.getattr(class.as_str())?.call((), Some(arguments))
}
