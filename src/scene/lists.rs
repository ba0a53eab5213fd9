//! Lists of the parts of a model from their tables, with the keys of the items in the file.

use super::described::{read, reported};
use super::document::Document;
use super::shape::Shape;
use super::written::Written;
use crate::description::schema::{Data, Problem, Reader};
use crate::robot::described::Places;
use crate::robot::effects::actuator::described::Actuator;
use crate::robot::effects::contact::described::Contact;
use crate::robot::effects::loops::described::Loop;

/// Keys in the file of the items of the lists that describe a model.
#[derive(Debug, Default)]
pub(super) struct Keys(Vec<(&'static str, Vec<Key>)>);

/// The key of an item.
#[derive(Debug)]
struct Key {
    table: String,
    /// Whether the file gives it a name.
    is_named: bool,
}

impl Keys {
    /// What the tables of an array describe, as further items of a list. Omits those with problems.
    pub(super) fn read<T: Data>(
        &mut self,
        list: &'static str,
        written: &[Written<T>],
        here: &str,
        shape: &mut Shape,
    ) -> Vec<T> {
        let mut found = Vec::with_capacity(written.len());
        for (i, written) in written.iter().enumerate() {
            let table = format!("{here}[{i}]");
            if let Some(part) = read(written, &table, shape) {
                found.push(part);
                self.add(list, Key { table, is_named: written.text("name").is_some() });
            }
        }
        found
    }

    fn add(&mut self, list: &'static str, key: Key) {
        match self.0.iter_mut().find(|(name, _)| *name == list) {
            Some((_, keys)) => keys.push(key),
            None => self.0.push((list, vec![key])),
        }
    }

    /// Key in the file of a place in a description.
    pub(super) fn of(&self, place: &str) -> Option<String> {
        let (list, rest) = place.split_once('[')?;
        let (_, keys) = self.0.iter().find(|(name, _)| *name == list)?;
        let (i, rest) = rest.split_once(']')?;
        let Key { table, is_named } = keys.get(i.parse::<usize>().ok()?)?;
        let rest = if rest == ".name" && !is_named { "" } else { rest };
        Some(format!("{table}{rest}"))
    }

    /// Key in the file of a place in the model that was made of a description.
    pub(super) fn of_model(&self, place: &str, places: &Places) -> Option<String> {
        self.of(&places.described(place)?)
    }
}

/// The actuators: tendons, then chambers, motors and active strains.
pub(super) fn actuators(document: &Document, keys: &mut Keys, shape: &mut Shape) -> Vec<Actuator> {
    const LIST: &str = "actuators";
    let tendons = keys.read(LIST, &document.tendon, "tendon", shape);
    let chambers = keys.read(LIST, &document.chamber, "chamber", shape);
    let motors = keys.read(LIST, &document.motor, "motor", shape);
    let active_strains = keys.read(LIST, &document.active_strain, "active_strain", shape);
    let fluidic = tendons.into_iter().map(Actuator::from).chain(chambers.into_iter().map(Actuator::from));
    let others = motors.into_iter().map(Actuator::from).chain(active_strains.into_iter().map(Actuator::from));
    fluidic.chain(others).collect()
}

/// The contacts.
pub(super) fn contacts(document: &Document, keys: &mut Keys, shape: &mut Shape) -> Vec<Contact> {
    refuse_empty_names(&document.contact, "contact", shape);
    keys.read("contacts", &document.contact, "contact", shape)
}

/// The closed loops.
pub(super) fn loops(document: &Document, keys: &mut Keys, shape: &mut Shape) -> Vec<Loop> {
    refuse_empty_names(&document.r#loop, "loop", shape);
    keys.read("loops", &document.r#loop, "loop", shape)
}

/// Reports empty names of parts that have a default one.
fn refuse_empty_names<T>(written: &[Written<T>], here: &str, shape: &mut Shape) {
    for (i, _) in written.iter().enumerate().filter(|(_, written)| written.text("name") == Some("")) {
        shape.refuse(&format!("{here}[{i}].name"), "got ''", "expected a name");
    }
}

/// What is made of a description whose places have these keys, after reporting problems.
pub(super) fn resolved<T>(
    shape: &mut Shape,
    key: impl Fn(&str) -> String,
    resolve: impl FnOnce(&mut Reader) -> T,
) -> T {
    let mut reader = Reader::default();
    let found = resolve(&mut reader);
    let problems = reader.finish().into_iter();
    reported(problems.map(|problem| Problem { place: key(&problem.place), ..problem }).collect(), "", shape);
    found
}
