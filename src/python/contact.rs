//! Conversion of contacts: Python objects with the attributes of `lissom.Contact` and its surfaces.

use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};

use super::actuation::at_place;
use super::convert;
use super::link::{Links, has_default_name};
use super::loops::index_of_one;
use crate::contact::{Contact, Obstacle, Surface};
use crate::robot::{Robot, number_default_names};

/// The link with this name; the first one for an unknown robot.
fn link_of(object: &Bound<'_, PyAny>, links: Option<&Links<'_>>) -> PyResult<usize> {
    let name: String =
        object.extract().map_err(|_| PyTypeError::new_err("link: expected the name of a link".to_owned()))?;
    links.map_or(Ok(0), |links| links.link(&name))
}

fn surface_of(object: &Bound<'_, PyAny>, links: Option<&Links<'_>>) -> PyResult<Surface> {
    let wrong = || {
        let found = convert::describe(object);
        PyTypeError::new_err(format!(
            "expected the name of a link with a rod, lissom.Ball, HalfSpace, Sphere, Capsule, Box, HeightField or ConvexMesh, got {found}"
        ))
    };
    if object.extract::<String>().is_ok() {
        return Ok(Surface::Rod { link: link_of(object, links)? });
    }
    let vector = |name: &str| convert::array_of(&object.getattr(name)?, name);
    let number = |name: &str| convert::number(&object.getattr(name)?, name);
    let optional = |name: &str| {
        let value = object.getattr(name)?;
        PyResult::Ok(if value.is_none() { None } else { Some(value) })
    };
    let at = || optional("at")?.map(|at| convert::number(&at, "at")).transpose();
    let shape = match object.get_type().name()?.to_str()? {
        "Ball" => {
            return Ok(Surface::Ball {
                link: link_of(&object.getattr("link")?, links)?,
                at: at()?,
                position: vector("position")?,
                radius: number("radius")?,
            });
        }
        "HalfSpace" => Obstacle::HalfSpace { point: vector("point")?, normal: vector("normal")? },
        "Sphere" => Obstacle::Sphere { centre: vector("centre")?, radius: number("radius")? },
        "Capsule" => {
            Obstacle::Capsule { ends: [vector("start")?, vector("end")?], radius: number("radius")? }
        }
        "Box" => Obstacle::Cuboid {
            centre: vector("centre")?,
            half_extents: vector("half_extents")?,
            orientation: convert::array_of(&object.getattr("orientation")?, "orientation")?,
        },
        "HeightField" => {
            let expected = "heights in metres: rows along x of numbers along y";
            let found = convert::numbers(&object.getattr("heights")?, "heights", expected)?;
            let [rows, columns] = found.shape[..] else {
                let found = found.shape.len();
                return Err(PyValueError::new_err(format!(
                    "heights: {found} dimensions, expected {expected}"
                )));
            };
            Obstacle::HeightField {
                heights: found.values,
                shape: [rows, columns],
                spacing: convert::array_of(&object.getattr("spacing")?, "spacing")?,
                corner: vector("corner")?,
                orientation: convert::array_of(&object.getattr("orientation")?, "orientation")?,
            }
        }
        "ConvexMesh" => {
            let rows = |name: &str, expected: &str| {
                let found = convert::numbers(&object.getattr(name)?, name, expected)?;
                if let [_, 3] = found.shape[..] {
                    return Ok(found.values);
                }
                Err(PyValueError::new_err(format!("{name}: shape {:?}, expected {expected}", found.shape)))
            };
            let points = rows("points", "points in metres, of shape (k, 3)")?;
            let faces = rows("faces", "triangles by the places of their corners, of shape (k, 3)")?;
            if let Some(corner) = faces.iter().find(|x| x.fract() != 0.0 || **x < 0.0 || !x.is_finite()) {
                return Err(PyValueError::new_err(format!(
                    "faces: {corner} is no place of a point, expected an integer from 0"
                )));
            }
            Obstacle::ConvexMesh {
                points: points.chunks_exact(3).map(|p| [p[0], p[1], p[2]]).collect(),
                faces: faces.chunks_exact(3).map(|f| [f[0] as usize, f[1] as usize, f[2] as usize]).collect(),
                radius: number("radius")?,
            }
        }
        _ => return Err(wrong()),
    };
    match (optional("link")?, at()?) {
        (Some(link), at) => Ok(Surface::Solid { link: link_of(&link, links)?, at, shape }),
        (None, None) => Ok(Surface::Obstacle(shape)),
        (None, Some(at)) => Err(PyValueError::new_err(format!(
            "at: got {at} without a link, expected None: the shape is fixed in the world"
        ))),
    }
}

/// A contact of a robot, or of a robot that is not known yet.
fn contact_of(object: &Bound<'_, PyAny>, links: Option<&Links<'_>>) -> PyResult<Contact> {
    let py = object.py();
    if object.get_type().name()? != "Contact" {
        let found = convert::describe(object);
        return Err(PyTypeError::new_err(format!("expected lissom.Contact, got {found}")));
    }
    let name = object.getattr("name")?;
    let name = name.extract().map_err(|_| PyTypeError::new_err("name: expected a str"))?;
    let [a, b] = ["a", "b"]
        .map(|place| surface_of(&object.getattr(place)?, links).map_err(|error| at_place(py, place, error)));
    let number = |name: &str| convert::number(&object.getattr(name)?, name);
    let stiffness = object.getattr("stiffness")?;
    Ok(Contact {
        name,
        surfaces: [a?, b?],
        stiffness: if stiffness.is_none() { None } else { Some(number("stiffness")?) },
        dissipation: number("dissipation")?,
        friction: convert::array_of(&object.getattr("friction")?, "friction")?,
        slip_velocity: number("slip_velocity")?,
        patch_radius: number("patch_radius")?,
    })
}

/// Rejects a contact that is invalid on its own; the robot checks whether it fits.
#[pyfunction]
pub(crate) fn check_contact(object: &Bound<'_, PyAny>) -> PyResult<()> {
    let mut found = contact_of(object, None)?;
    // Links are unknown; check only whether both names are equal.
    let names = ["a", "b"].map(|place| {
        let surface = object.getattr(place)?;
        PyResult::Ok(match surface.getattr_opt("link")? {
            Some(link) if !link.is_none() => link,
            _ => surface,
        })
    });
    let [a, b] = names;
    if a?.ne(b?)?
        && let Surface::Rod { link } | Surface::Ball { link, .. } | Surface::Solid { link, .. } =
            &mut found.surfaces[1]
    {
        *link = 1;
    }
    Ok(found.validate(&|_| Some(f64::INFINITY))?)
}

/// The contacts of a sequence.
pub(super) fn contacts_of(contacts: &Bound<'_, PyAny>, links: &Links<'_>) -> PyResult<Vec<Contact>> {
    let wrong = || {
        let found = convert::describe(contacts);
        PyTypeError::new_err(format!("contacts: expected a sequence of lissom.Contact, got {found}"))
    };
    let (mut found, mut has_default) = (Vec::new(), Vec::new());
    for (i, object) in contacts.try_iter().map_err(|_| wrong())?.enumerate() {
        let object = object?;
        let described = contact_of(&object, Some(links));
        let contact = described.map_err(|error| at_place(object.py(), &format!("contacts[{i}]"), error))?;
        has_default.push(has_default_name(&object, &contact.name)?);
        found.push(contact);
    }
    number_default_names(found.iter_mut().map(|contact| &mut contact.name).zip(has_default));
    Ok(found)
}

fn surface_out<'py>(py: Python<'py>, robot: &Robot, surface: &Surface) -> PyResult<Bound<'py, PyAny>> {
    let lissom = py.import("lissom")?;
    let tuple = <(f64, f64, f64)>::from;
    match surface {
        Surface::Rod { link } => Ok(robot.links[*link].name.as_str().into_pyobject(py)?.into_any()),
        Surface::Ball { link, at, position, radius } => {
            let options = PyDict::new(py);
            options.set_item("at", at)?;
            options.set_item("position", tuple(*position))?;
            lissom.getattr("Ball")?.call((robot.links[*link].name.as_str(), *radius), Some(&options))
        }
        Surface::Obstacle(shape) => shape_out(&lissom, shape, &PyDict::new(py)),
        Surface::Solid { link, at, shape } => {
            let options = PyDict::new(py);
            options.set_item("link", &robot.links[*link].name)?;
            options.set_item("at", at)?;
            shape_out(&lissom, shape, &options)
        }
    }
}

/// Python object of a shape; options contain the link.
fn shape_out<'py>(
    lissom: &Bound<'py, PyModule>,
    shape: &Obstacle,
    options: &Bound<'py, PyDict>,
) -> PyResult<Bound<'py, PyAny>> {
    let tuple = <(f64, f64, f64)>::from;
    let options = Some(options);
    match shape {
        Obstacle::HalfSpace { point, normal } => {
            lissom.getattr("HalfSpace")?.call((tuple(*point), tuple(*normal)), options)
        }
        Obstacle::Sphere { centre, radius } => {
            lissom.getattr("Sphere")?.call((tuple(*centre), *radius), options)
        }
        Obstacle::Capsule { ends: [start, end], radius } => {
            lissom.getattr("Capsule")?.call((tuple(*start), tuple(*end), *radius), options)
        }
        Obstacle::Cuboid { centre, half_extents, orientation } => {
            let orientation = <(f64, f64, f64, f64)>::from(*orientation);
            lissom.getattr("Box")?.call((tuple(*centre), tuple(*half_extents), orientation), options)
        }
        Obstacle::HeightField { heights, shape, spacing, corner, orientation } => {
            let rows: Vec<_> = heights.chunks_exact(shape[1]).map(<[f64]>::to_vec).collect();
            let orientation = <(f64, f64, f64, f64)>::from(*orientation);
            let spacing = <(f64, f64)>::from(*spacing);
            lissom.getattr("HeightField")?.call((rows, spacing, tuple(*corner), orientation), options)
        }
        Obstacle::ConvexMesh { points, faces, radius } => {
            lissom.getattr("ConvexMesh")?.call((points.clone(), faces.clone(), *radius), options)
        }
    }
}

/// Python objects of a robot's contacts.
pub(super) fn contacts_out<'py>(py: Python<'py>, robot: &Robot) -> PyResult<Bound<'py, PyTuple>> {
    let class = py.import("lissom")?.getattr("Contact")?;
    let out = |contact: &Contact| {
        let [a, b] = contact.surfaces.each_ref().map(|surface| surface_out(py, robot, surface));
        let options = PyDict::new(py);
        options.set_item("name", &contact.name)?;
        options.set_item("stiffness", contact.stiffness)?;
        options.set_item("dissipation", contact.dissipation)?;
        options.set_item("friction", <(f64, f64, f64)>::from(contact.friction))?;
        options.set_item("slip_velocity", contact.slip_velocity)?;
        options.set_item("patch_radius", contact.patch_radius)?;
        class.call((a?, b?), Some(&options))
    };
    PyTuple::new(py, robot.contacts.iter().map(out).collect::<PyResult<Vec<_>>>()?)
}

/// Index of a contact of a robot.
pub(super) fn contact_index(robot: &Robot, name: Option<&str>) -> PyResult<usize> {
    index_of_one(name, robot.contacts.iter().map(|contact| contact.name.as_str()), "contact")
}
