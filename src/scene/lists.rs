//! Models and the lists of their parts from tables, with the keys of the items in the file.

use super::described::{read, reported};
use super::document::Document;
use super::parts;
use super::shape::Shape;
use super::written::Written;
use crate::description::body::described::Body;
use crate::description::schema::{Data, LinkName, Problem, Reader};
use crate::description::world::STANDARD_GRAVITY;
use crate::robot::described::{self, Link, Places};
use crate::robot::effects::actuator::described::Actuator;
use crate::robot::effects::contact::described::Contact;
use crate::robot::effects::load::described::Load;
use crate::robot::effects::loops::described::Loop;
use crate::robot::effects::magnet::described::Magnet;
use crate::robot::effects::support::described::Support;

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
    /// Reads the tables of an array as further items of a list. Omits those with problems.
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

/// The robot of the tables of a scene, with these links, of which the first ones are imported.
pub(super) fn robot(
    document: &Document,
    links: Vec<Link>,
    before: usize,
    keys: &mut Keys,
    shape: &mut Shape,
) -> described::Robot {
    // Loads, supports, magnets and further bodies are tables of their links.
    let (mut loads, mut bodies, mut supports, mut magnets) = (vec![], vec![], vec![], vec![]);
    for (i, (written, described)) in document.link.iter().zip(&links[before..]).enumerate() {
        let (below, link) = (&written.below, Some(LinkName(described.name.clone())));
        let here = |key: &str| format!("link[{i}].{key}");
        let of_link = keys.read("loads", &below.load, &here("load"), shape);
        loads.extend(of_link.into_iter().map(|load| Load { link: link.clone(), ..load }));
        let of_link = keys.read("bodies", &below.fixed_body, &here("fixed_body"), shape);
        bodies.extend(of_link.into_iter().map(|body| Body { link: link.clone(), ..body }));
        let of_link = keys.read("supports", &below.support, &here("support"), shape);
        supports.extend(of_link.into_iter().map(|support| Support { link: link.clone(), ..support }));
        let of_link = keys.read("magnets", &below.magnet, &here("magnet"), shape);
        magnets.extend(of_link.into_iter().map(|magnet| Magnet { link: link.clone(), ..magnet }));
    }
    let moving = document.base_motion.as_ref();
    described::Robot {
        links,
        gravity: document.scene.gravity.unwrap_or(STANDARD_GRAVITY),
        loads,
        bodies,
        supports,
        magnets,
        field: document.scene.field.clone(),
        fluid: document.fluid.as_ref().and_then(|fluid| read(fluid, "fluid", shape)),
        base_motion: moving
            .map(|written| parts::base_motion(written, "base_motion", &document.simulation, shape)),
        actuators: actuators(document, keys, shape),
        loops: loops(document, keys, shape),
        contacts: contacts(document, keys, shape),
    }
}

/// The rod of the tables of a scene.
pub(super) fn rod(document: &Document, keys: &mut Keys, shape: &mut Shape) -> described::Rod {
    let written = &document.rod[0];
    let segment = |(i, segment)| parts::segment(segment, &format!("rod[0].segment[{i}]"), shape);
    let segments = written.segment.iter().enumerate().map(segment).collect();
    let moving = written.base_motion.as_ref();
    described::Rod {
        segments,
        base_position: written.base.position,
        base_orientation: written.base.orientation,
        gravity: document.scene.gravity.unwrap_or(STANDARD_GRAVITY),
        tip_force: written.tip_force,
        tip_moment: written.tip_moment,
        tip_mass: written.tip_mass,
        loads: keys.read("loads", &written.load, "rod[0].load", shape),
        bodies: keys.read("bodies", &written.body, "rod[0].body", shape),
        base_motion: moving
            .map(|written| parts::base_motion(written, "rod[0].base_motion", &document.simulation, shape)),
        supports: keys.read("supports", &written.support, "rod[0].support", shape),
        fluid: written.fluid.as_ref().and_then(|fluid| read(fluid, "rod[0].fluid", shape)),
        actuators: actuators(document, keys, shape),
        contacts: contacts(document, keys, shape),
        magnets: keys.read("magnets", &written.magnet, "rod[0].magnet", shape),
        field: document.scene.field.clone(),
    }
}

/// The actuators: tendons, then chambers, motors and active strains.
fn actuators(document: &Document, keys: &mut Keys, shape: &mut Shape) -> Vec<Actuator> {
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
fn contacts(document: &Document, keys: &mut Keys, shape: &mut Shape) -> Vec<Contact> {
    refuse_empty_names(&document.contact, "contact", shape);
    keys.read("contacts", &document.contact, "contact", shape)
}

/// The closed loops.
fn loops(document: &Document, keys: &mut Keys, shape: &mut Shape) -> Vec<Loop> {
    refuse_empty_names(&document.r#loop, "loop", shape);
    keys.read("loops", &document.r#loop, "loop", shape)
}

/// Reports empty names of parts that have a default one.
fn refuse_empty_names<T>(written: &[Written<T>], here: &str, shape: &mut Shape) {
    for (i, _) in written.iter().enumerate().filter(|(_, written)| written.text("name") == Some("")) {
        shape.refuse(&format!("{here}[{i}].name"), "got ''", "expected a name");
    }
}

/// Resolves a description whose places have these keys, and reports its problems.
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
