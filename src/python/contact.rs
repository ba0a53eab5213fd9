//! Contacts of robots: the parts that `description` describes, whose links are resolved when a robot is made.

use std::sync::Arc;

use pyo3::prelude::*;
use pyo3::types::PyTuple;

use super::loops::index_of_one;
use super::part::{parts_of, resolved, wrapped};
use super::signal::Functions;
use crate::description::schema::LinkName;
use crate::robot::effects::contact::{Contact, described};
use crate::robot::{Named, Robot, number_default_names};

/// The contacts of a sequence.
pub(super) fn contacts_of(contacts: &Bound<'_, PyAny>, named: &Named<'_>) -> PyResult<Vec<Contact>> {
    let described: Vec<described::Contact> = parts_of(contacts, "contacts", &mut Functions::default())?;
    let mut found = resolved(contacts.py(), "contacts", &described, |contact, reader| {
        contact.resolved(|place, name| named.link(place, name, reader))
    })?;
    let are_default = described.iter().map(|contact| contact.name == contact.default_name());
    number_default_names(found.iter_mut().map(|contact| &mut contact.name).zip(are_default));
    Ok(found)
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
