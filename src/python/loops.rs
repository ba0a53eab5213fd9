//! Conversion of closed loops: Python objects with the attributes of `lissom.Loop`, its ends and kinds.

use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};

use super::actuation::at_place;
use super::convert;
use super::link::{joint_class, joint_of};
use crate::loops::{Loop, LoopEnd, Tie};
use crate::robot::Robot;
use crate::scene::suggestion::suggestion;

/// Index of a name.
pub(super) fn index(name: &str, names: &[String], what: &str) -> PyResult<usize> {
    names.iter().position(|known| known == name).ok_or_else(|| {
        let meant = suggestion(name, names.iter().map(String::as_str));
        let meant = meant.map_or_else(String::new, |meant| format!("; did you mean '{meant}'?"));
        PyValueError::new_err(format!("got '{name}', expected the name of {what} of the robot{meant}"))
    })
}

/// An end; for an unknown robot, ends on links are on the first one.
fn end_of(object: &Bound<'_, PyAny>, robot: Option<&Robot>) -> PyResult<LoopEnd> {
    let link: Option<String> = object.getattr("link")?.extract().map_err(|_| {
        PyTypeError::new_err("link: expected the name of a link, or None for the world".to_owned())
    })?;
    let link = match (link, robot) {
        (None, _) => None,
        (Some(_), None) => Some(0),
        (Some(name), Some(robot)) => {
            let names: Vec<String> = robot.links.iter().map(|link| link.name.clone()).collect();
            Some(index(&name, &names, "a link")?)
        }
    };
    let at = object.getattr("at")?;
    Ok(LoopEnd {
        link,
        at: if at.is_none() { None } else { Some(convert::number(&at)?) },
        position: convert::array_of(&object.getattr("position")?, "position")?,
        orientation: convert::array_of(&object.getattr("orientation")?, "orientation")?,
    })
}

/// A loop of a robot, or of a robot that is not known yet.
fn loop_of(object: &Bound<'_, PyAny>, robot: Option<&Robot>) -> PyResult<Loop> {
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
    let part = |name: &str| {
        convert::number(&kind.getattr(name)?)
            .map_err(|error| PyTypeError::new_err(format!("kind.{name}: {}", error.value(py))))
    };
    let ends = || -> PyResult<[LoopEnd; 2]> {
        let [a, b] = ["a", "b"]
            .map(|place| end_of(&object.getattr(place)?, robot).map_err(|error| at_place(py, place, error)));
        Ok([a?, b?])
    };
    let tie = match kind_name.as_str() {
        "Distance" => Tie::Distance { ends: ends()?, length: part("length")? },
        "Gear" => {
            let names = robot.map(Robot::coordinate_names);
            let coordinates = ["a", "b"].into_iter().enumerate().map(|(i, place)| {
                let name: String = object.getattr(place)?.extract()?;
                let Some(names) = &names else { return Ok(i) };
                index(&name, names, "a coordinate").map_err(|error| at_place(py, place, error))
            });
            let found = coordinates.collect::<PyResult<Vec<usize>>>()?;
            Tie::Coordinates {
                coordinates: [found[0], found[1]],
                ratio: part("ratio")?,
                offset: part("offset")?,
            }
        }
        _ => {
            let joint = joint_of(&kind).map_err(|_| {
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
            Tie::Joint { ends: ends()?, joint }
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
pub(super) fn loops_of(loops: &Bound<'_, PyAny>, robot: &Robot) -> PyResult<Vec<Loop>> {
    let wrong = || {
        let found = convert::describe(loops);
        PyTypeError::new_err(format!("loops: expected a sequence of lissom.Loop, got {found}"))
    };
    let mut found = Vec::new();
    for (i, object) in loops.try_iter().map_err(|_| wrong())?.enumerate() {
        let object = object?;
        let described = loop_of(&object, Some(robot));
        found.push(described.map_err(|error| at_place(object.py(), &format!("loops[{i}]"), error))?);
    }
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
            Tie::Joint { ends: [a, b], joint } => (end_out(a)?, end_out(b)?, joint_class(py, joint)?),
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
    let names: Vec<String> = robot.loops.iter().map(|closed| closed.name.clone()).collect();
    match name {
        Some(name) => index(name, &names, "a loop").map_err(|error| {
            Python::attach(|py| PyValueError::new_err(format!("name: {}", error.value(py))))
        }),
        None if names.len() == 1 => Ok(0),
        None => Err(PyValueError::new_err(format!(
            "name: got nothing, expected the name of one of the {} loops of the robot",
            names.len()
        ))),
    }
}
