//! Conversion of closed loops: Python objects with the attributes of `lissom.Loop`, its ends and kinds.

use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};

use super::actuation::at_place;
use super::convert;
use super::link::{Links, has_default_name, unknown};
use super::part::{object_of, part_of};
use super::signal::Functions;
use crate::description::Data as _;
use crate::joint::described::Joint;
use crate::loops::{Loop, LoopEnd, Tie};
use crate::robot::{Robot, number_default_names};

/// An end; for an unknown robot, ends on links are on the first one.
fn end_of(object: &Bound<'_, PyAny>, links: Option<&Links<'_>>) -> PyResult<LoopEnd> {
    let link: Option<String> = object.getattr("link")?.extract().map_err(|_| {
        PyTypeError::new_err("link: expected the name of a link, or None for the world".to_owned())
    })?;
    let link = match (link, links) {
        (None, _) => None,
        (Some(_), None) => Some(0),
        (Some(name), Some(links)) => Some(links.link(&name)?),
    };
    let at = object.getattr("at")?;
    Ok(LoopEnd {
        link,
        at: if at.is_none() { None } else { Some(convert::number(&at, "at")?) },
        position: convert::array_of(&object.getattr("position")?, "position")?,
        orientation: convert::array_of(&object.getattr("orientation")?, "orientation")?,
    })
}

/// A loop of a robot, or of a robot that is not known yet.
fn loop_of(object: &Bound<'_, PyAny>, links: Option<&Links<'_>>) -> PyResult<Loop> {
    let py = object.py();
    let wrong = || {
        let found = convert::describe(object);
        PyTypeError::new_err(format!("expected lissom.Loop, got {found}"))
    };
    if object.get_type().name()? != "Loop" {
        return Err(wrong());
    }
    let name = object.getattr("name")?;
    let name = name.extract().map_err(|_| PyTypeError::new_err("name: expected a str"))?;
    let kind = object.getattr("kind")?;
    let kind_name = kind.get_type().name()?.to_string();
    let part = |name: &str| convert::number(&kind.getattr(name)?, &format!("kind.{name}"));
    let ends = || -> PyResult<[LoopEnd; 2]> {
        let [a, b] = ["a", "b"]
            .map(|place| end_of(&object.getattr(place)?, links).map_err(|error| at_place(py, place, error)));
        Ok([a?, b?])
    };
    let tie = match kind_name.as_str() {
        "Distance" => Tie::Distance { ends: ends()?, length: part("length")? },
        "Gear" => {
            let coordinates = ["a", "b"].into_iter().enumerate().map(|(i, place)| {
                let name: String = object.getattr(place)?.extract()?;
                let Some(links) = links else { return Ok(i) };
                links.coordinate(&name).map_err(|error| at_place(py, place, error))
            });
            let found = coordinates.collect::<PyResult<Vec<usize>>>()?;
            Tie::Coordinates {
                coordinates: [found[0], found[1]],
                ratio: part("ratio")?,
                offset: part("offset")?,
            }
        }
        _ => {
            let joint = part_of::<Joint>(&kind, "kind", &mut Functions::default()).map_err(|_| {
                let found = convert::describe(&kind);
                PyTypeError::new_err(format!(
                    "kind: expected a joint (lissom.Weld, Revolute, Prismatic, Cylindrical, Universal, Planar or Spherical), \
                     lissom.Distance or lissom.Gear, got {found}"
                ))
            })?;
            for driven in ["motion", "mimic"] {
                if kind.getattr_opt(driven)?.is_some_and(|value| !value.is_none()) {
                    return Err(PyValueError::new_err(format!(
                        "kind.{driven}: expected None: the joint of a loop is not driven; drive a joint of a link"
                    )));
                }
            }
            Tie::Joint { ends: ends()?, joint: joint.resolved() }
        }
    };
    Ok(Loop { name, tie })
}

/// Rejects a loop that is invalid on its own; the robot checks whether it fits.
#[pyfunction]
pub(crate) fn check_loop(object: &Bound<'_, PyAny>) -> PyResult<()> {
    let mut found = loop_of(object, None)?;
    if let Tie::Joint { ends, .. } | Tie::Distance { ends, .. } = &mut found.tie {
        // Links are unknown; check only whether both names are equal.
        let names = ["a", "b"].map(|place| object.getattr(place).and_then(|end| end.getattr("link")));
        let [a, b] = names;
        let is_other = a?.ne(b?)?;
        ends[1].link = ends[1].link.map(|_| usize::from(is_other));
    }
    Ok(found.validate(|_| Some(f64::INFINITY), 2)?)
}

/// The loops of a sequence.
pub(super) fn loops_of(loops: &Bound<'_, PyAny>, links: &Links<'_>) -> PyResult<Vec<Loop>> {
    let wrong = || {
        let found = convert::describe(loops);
        PyTypeError::new_err(format!("loops: expected a sequence of lissom.Loop, got {found}"))
    };
    let (mut found, mut has_default) = (Vec::new(), Vec::new());
    for (i, object) in loops.try_iter().map_err(|_| wrong())?.enumerate() {
        let object = object?;
        let described = loop_of(&object, Some(links));
        let closed = described.map_err(|error| at_place(object.py(), &format!("loops[{i}]"), error))?;
        has_default.push(has_default_name(&object, &closed.name)?);
        found.push(closed);
    }
    number_default_names(found.iter_mut().map(|closed: &mut Loop| &mut closed.name).zip(has_default));
    Ok(found)
}

/// The Python objects of the loops of a robot.
pub(super) fn loops_out<'py>(py: Python<'py>, robot: &Robot) -> PyResult<Bound<'py, PyTuple>> {
    let lissom = py.import("lissom")?;
    let end_out = |end: &LoopEnd| {
        let link = end.link.map(|link| robot.links[link].name.as_str());
        let (position, orientation) =
            (<(f64, f64, f64)>::from(end.position), <(f64, f64, f64, f64)>::from(end.orientation));
        lissom.getattr("LoopEnd")?.call1((link, end.at, position, orientation))
    };
    let names = robot.coordinate_names();
    let out = |Loop { name, tie }: &Loop| {
        let options = PyDict::new(py);
        options.set_item("name", name)?;
        let arguments = match tie {
            Tie::Joint { ends: [a, b], joint } => {
                (end_out(a)?, end_out(b)?, object_of(py, &joint.described().write())?)
            }
            Tie::Distance { ends: [a, b], length } => {
                (end_out(a)?, end_out(b)?, lissom.getattr("Distance")?.call1((*length,))?)
            }
            Tie::Coordinates { coordinates: [first, second], ratio, offset } => {
                let of_gear = PyDict::new(py);
                of_gear.set_item("offset", offset)?;
                let gear = lissom.getattr("Gear")?.call((*ratio,), Some(&of_gear))?;
                let name = |k: &usize| names[*k].as_str().into_pyobject(py).map(Bound::into_any);
                (name(first)?, name(second)?, gear)
            }
        };
        lissom.getattr("Loop")?.call(arguments, Some(&options))
    };
    PyTuple::new(py, robot.loops.iter().map(out).collect::<PyResult<Vec<_>>>()?)
}

/// Index of a loop of a robot.
pub(super) fn loop_index(robot: &Robot, name: Option<&str>) -> PyResult<usize> {
    index_of_one(name, robot.loops.iter().map(|closed| closed.name.as_str()), "loop")
}

/// Index of a part of a robot, of which there are several with these names; `kind` is that of the part.
pub(super) fn index_of_one<'a>(
    name: Option<&str>,
    names: impl ExactSizeIterator<Item = &'a str> + Clone,
    kind: &str,
) -> PyResult<usize> {
    let Some(name) = name else {
        return match names.len() {
            1 => Ok(0),
            many => Err(PyValueError::new_err(format!(
                "name: got nothing, expected the name of one of the {many} {kind}s of the robot"
            ))),
        };
    };
    names.clone().position(|known| known == name).ok_or_else(|| {
        let error = unknown(name, names, &format!("a {kind}"));
        Python::attach(|py| at_place(py, "name", error))
    })
}
