//! Contacts from their tables.

use super::described::{made, read};
use super::document::Document;
use super::shape::Shape;
use super::written::Written;
use crate::robot::effects::contact::{Contact, described};
use crate::robot::{Named, number_default_names};

/// Contacts of a scene with their indices in the file. Omits those with problems, and those on unknown links.
pub(super) fn contacts(
    document: &Document,
    named: &Named<'_>,
    shape: &mut Shape,
) -> (Vec<Contact>, Vec<usize>) {
    let mut found = Vec::new();
    for (i, written) in document.contact.iter().enumerate() {
        let here = format!("contact[{i}]");
        if written.text("name") == Some("") {
            shape.refuse(&format!("{here}.name"), "got ''", "expected a name");
        }
        let Some(contact) = read::<described::Contact>(written, &here, shape) else { continue };
        let contact =
            made(&here, shape, |reader| contact.resolved(|place, name| named.link(place, name, reader)));
        found.extend(contact.map(|contact| (contact, i)));
    }
    let is_default = |i: usize| document.contact[i].text("name").is_none();
    number_default_names(found.iter_mut().map(|(contact, i)| (&mut contact.name, is_default(*i))));
    found.into_iter().unzip()
}

/// Key in the file for a place in the contacts of a robot, which have these indices in the file.
pub(super) fn key_of_contact(
    place: &str,
    written: &[Written<described::Contact>],
    places: &[usize],
) -> Option<String> {
    let (i, rest) = place.strip_prefix("contacts[")?.split_once(']')?;
    let i = *places.get(i.parse::<usize>().ok()?)?;
    let rest = if rest == ".name" && written[i].text("name").is_none() { "" } else { rest };
    Some(format!("contact[{i}]{rest}"))
}
