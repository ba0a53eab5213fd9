//! Links by their names.

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use crate::description::schema::{Problem, suggestion};
use crate::error::InvalidInput;
use crate::robot::{LinkNames, Robot};

/// Index of a link of a robot; of the only one if no name is given.
pub(super) fn index_of(robot: &Robot, name: Option<&str>, place: &str) -> Result<usize, InvalidInput> {
    let links = &robot.links;
    let found = match name {
        None => (links.len() == 1).then_some(0),
        Some(name) => links.iter().position(|link| link.name == name),
    };
    found.ok_or_else(|| {
        let names = LinkNames::new(links.iter().map(|link| link.name.as_str()), false);
        let problem = Problem { place: place.to_owned(), fault: names.unknown(name) };
        InvalidInput { problems: vec![problem.into()] }
    })
}

/// The refusal of a name that no part of a robot has; `what` is the kind of the part.
pub(super) fn unknown<'a>(name: &str, known: impl Iterator<Item = &'a str>, what: &str) -> PyErr {
    let meant =
        suggestion(name, known).map_or_else(String::new, |meant| format!("; did you mean '{meant}'?"));
    PyValueError::new_err(format!("got '{name}', expected the name of {what} of the robot{meant}"))
}
