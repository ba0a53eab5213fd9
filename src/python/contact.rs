//! Contacts of robots: the parts that `description` describes, whose links are resolved when a robot is made.

use std::sync::Arc;

use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::PyTuple;

use super::actuation::at_place;
use super::convert;
use super::link::Links;
use super::loops::index_of_one;
use super::part::{PyPart, wrapped};
use crate::contact::{Contact, described};
use crate::description::LinkName;
use crate::robot::{Robot, number_default_names};

/// A contact of a robot with these links, and whether it has its default name.
fn contact_of(object: &Bound<'_, PyAny>, links: &Links<'_>) -> PyResult<(Contact, bool)> {
    let py = object.py();
    let part = object.cast::<PyPart>().ok().and_then(|part| part.get().of_type::<described::Contact>());
    let Some(contact) = part else {
        let found = convert::describe(object);
        return Err(PyTypeError::new_err(format!("expected lissom.Contact, got {found}")));
    };
    let mut failure = None;
    let resolved = contact.resolved(|place, LinkName(name)| {
        // The surface is at fault, whichever way it names its link.
        let surface = place.split('.').next().unwrap_or(place);
        links.link(name).map_err(|error| failure.get_or_insert(at_place(py, surface, error))).ok()
    });
    match (resolved, failure) {
        (Some(resolved), None) => Ok((resolved, contact.name == contact.default_name())),
        (_, Some(error)) => Err(error),
        (None, None) => unreachable!("without a failure all links have been found"),
    }
}

/// The contacts of a sequence.
pub(super) fn contacts_of(contacts: &Bound<'_, PyAny>, links: &Links<'_>) -> PyResult<Vec<Contact>> {
    let wrong = || {
        let found = convert::describe(contacts);
        PyTypeError::new_err(format!("contacts: expected a sequence of lissom.Contact, got {found}"))
    };
    let mut found = Vec::new();
    for (i, object) in contacts.try_iter().map_err(|_| wrong())?.enumerate() {
        let object = object?;
        let contact = contact_of(&object, links);
        found.push(contact.map_err(|error| at_place(object.py(), &format!("contacts[{i}]"), error))?);
    }
    number_default_names(found.iter_mut().map(|(contact, is_default)| (&mut contact.name, *is_default)));
    Ok(found.into_iter().map(|(contact, _)| contact).collect())
}

/// Python objects of a robot's contacts.
pub(super) fn contacts_out<'py>(py: Python<'py>, robot: &Robot) -> PyResult<Bound<'py, PyTuple>> {
    let name = |link: usize| LinkName(robot.links[link].name.clone());
    let out = |contact: &Contact| wrapped(py, Arc::new(contact.described(&name)));
    PyTuple::new(py, robot.contacts.iter().map(out).collect::<PyResult<Vec<_>>>()?)
}

/// Index of a contact of a robot.
pub(super) fn contact_index(robot: &Robot, name: Option<&str>) -> PyResult<usize> {
    index_of_one(name, robot.contacts.iter().map(|contact| contact.name.as_str()), "contact")
}
