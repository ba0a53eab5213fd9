//! Closed loops from their tables.

use super::described::{made, read};
use super::document::{Document, Jacobian, Simulation as Settings};
use super::shape::Shape;
use crate::robot::effects::loops::{Loop, described};
use crate::robot::{Named, Robot, number_default_names};

/// Loops of a scene with their keys in the file. Omits those with problems.
pub(super) fn loops(
    document: &Document,
    robot: &Robot,
    are_incomplete: bool,
    shape: &mut Shape,
) -> (Vec<Loop>, Vec<String>) {
    // The number of coordinates of an invalid robot is unknown.
    let is_unknown = !document.r#loop.is_empty() && (are_incomplete || robot.validate().is_err());
    let named = Named::incomplete(robot, are_incomplete).without_coordinates(is_unknown);
    let (mut found, mut keys, mut are_default) = (Vec::new(), Vec::new(), Vec::new());
    for (i, written) in document.r#loop.iter().enumerate() {
        let here = format!("loop[{i}]");
        if written.text("name") == Some("") {
            shape.refuse(&format!("{here}.name"), "got ''", "expected a name");
        }
        let Some(described) = read::<described::Loop>(written, &here, shape) else { continue };
        if let Some(closed) = made(&here, shape, |reader| named.closed(&described, reader)) {
            found.push(closed);
            keys.push(here);
            are_default.push(written.text("name").is_none());
        }
    }
    number_default_names(found.iter_mut().map(|closed| &mut closed.name).zip(are_default));
    (found, keys)
}

/// Reports a Jacobian option that does not support closed loops.
pub(super) fn check_jacobian(document: &Document, shape: &mut Shape) {
    if document.r#loop.is_empty() {
        return;
    }
    let Settings { jac, .. } = &document.simulation;
    if *jac != Jacobian::Analytic && shape.is_readable("simulation.jac") {
        let right = "expected \"analytic\" (the default): that of the constraints is exact";
        shape.refuse("simulation.jac", "differences do not see closed loops", right);
    }
}
