//! Actuators from their tables, which follow the rod or the links on which they act.

use super::described::{made, read};
use super::document::Document;
use super::shape::Shape;
use super::written::Written;
use crate::description::schema::Data;
use crate::robot::effects::actuator::{Actuator, described};
use crate::robot::{Named, number_default_names};

/// Actuators of a scene with their keys in the file: tendons, then chambers, motors and active strains. Omits those with
/// problems.
pub(super) fn actuators(
    document: &Document,
    named: &Named<'_>,
    shape: &mut Shape,
) -> (Vec<Actuator>, Vec<String>) {
    let mut found = Vec::new();
    add(&document.tendon, "tendon", named, shape, &mut found);
    add(&document.chamber, "chamber", named, shape, &mut found);
    add(&document.motor, "motor", named, shape, &mut found);
    add(&document.active_strain, "active_strain", named, shape, &mut found);
    let is_default: Vec<_> = found.iter().map(|(_, _, is_default)| *is_default).collect();
    number_default_names(found.iter_mut().map(|(actuator, ..)| actuator.name_mut()).zip(is_default));
    found.into_iter().map(|(actuator, key, _)| (actuator, key)).unzip()
}

/// Adds the actuators of one kind, and whether they have no name of their own.
fn add<T: Data + Into<described::Actuator>>(
    written: &[Written<T>],
    list: &str,
    named: &Named<'_>,
    shape: &mut Shape,
    found: &mut Vec<(Actuator, String, bool)>,
) {
    for (i, written) in written.iter().enumerate() {
        let here = format!("{list}[{i}]");
        let Some(described) = read(written, &here, shape) else { continue };
        let actuator = made(&here, shape, |reader| named.actuator(&described.into(), reader));
        found.extend(actuator.map(|actuator| (actuator, here, written.text("name").is_none())));
    }
}
