//! Conversion of links: Python objects with the attributes of `lissom.Link`.

use std::collections::HashMap;

use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;

use super::convert;
use super::part::{optional_part, part_of};
use super::segment::segments_of;
use super::signal::Functions;
use crate::body::described::Body;
use crate::description::{LinkName, suggestion};
use crate::error::{Checker, InvalidInput};
use crate::joint::described::Joint;
use crate::robot::{Driven, Link, Robot};

/// The object at a place of an error.
fn attribute<'py>(object: &Bound<'py, PyAny>, name: &str) -> PyResult<Bound<'py, PyAny>> {
    object.getattr(name)
}

fn array<const N: usize>(object: &Bound<'_, PyAny>, name: &str) -> PyResult<[f64; N]> {
    convert::array_of(&attribute(object, name)?, name)
}

fn number(object: &Bound<'_, PyAny>, name: &str) -> PyResult<f64> {
    convert::number(&attribute(object, name)?, name)
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
        segments = segments_of(&rod, "rod")?;
        if segments.is_empty() {
            return Err(PyValueError::new_err("rod: got no segments, expected at least one, or None"));
        }
    }
    let body: Option<Body> = optional_part(&body, "body")?;
    if body.as_ref().is_some_and(|body| body.link.is_some()) {
        return Err(PyValueError::new_err("body.link: got a name, expected none: the body is this link's"));
    }
    let joint: Joint = part_of(&attribute(object, "joint")?, "joint", functions)?;
    let (driven, mimicked) = Driven::of(&joint).unzip();
    let link = Link {
        name: attribute(object, "name")?
            .extract()
            .map_err(|_| PyTypeError::new_err("name: expected a string"))?,
        parent: None,
        at: if at.is_none() { None } else { Some(number(object, "at")?) },
        position: array(object, "position")?,
        orientation: array(object, "orientation")?,
        joint: joint.resolved(),
        driven,
        rod: segments,
        body: body.map(|body| body.resolved(0)),
    };
    Ok((link, mimicked.flatten().map(|LinkName(name)| name.clone())))
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

/// The refusal of a name that no part of a robot has; `what` is the kind of the part.
pub(super) fn unknown<'a>(name: &str, known: impl Iterator<Item = &'a str>, what: &str) -> PyErr {
    let meant =
        suggestion(name, known).map_or_else(String::new, |meant| format!("; did you mean '{meant}'?"));
    PyValueError::new_err(format!("got '{name}', expected the name of {what} of the robot{meant}"))
}
