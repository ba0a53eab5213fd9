//! Checks that balls and rods in contact with tubes fit into their bores.

use crate::error::{Checker, InvalidInput};
use crate::robot::description::Robot;
use crate::robot::effects::contact::plan::{Contacts, Side};
use crate::robot::effects::contact::shapes::obstacle::Solid;
use crate::robot::effects::contact::{Obstacle, Surface, Tube};
use crate::robot::plan::space::Space;

/// Rejects contacts of tubes with balls and rods as thick as the bore: they would touch the wall all around, but the force law has a
/// single point of contact. Sections of rods must be round, for the same reason.
pub(super) fn check_bores<G: Space>(robot: &Robot, contacts: &Contacts<G>) -> Result<(), InvalidInput> {
    let mut check = Checker::new();
    for (i, contact) in robot.contacts.iter().enumerate() {
        for (s, place) in ["a", "b"].into_iter().enumerate() {
            let Some(Obstacle::Tube(Tube { radius, .. })) = contact.surfaces[1 - s].obstacle() else {
                continue;
            };
            let place = format!("contacts[{i}].{place}");
            let thickness = match &contact.surfaces[s] {
                Surface::Rod { .. } => {
                    let (thinnest, is_round) = of_rod(contacts, i);
                    let expected = "round sections: flat ones would touch the wall on both sides";
                    check.require(is_round, &place, "a rod with sections that are not round", expected);
                    thinnest
                }
                Surface::Ball { radius, .. } => *radius,
                Surface::Solid { shape, .. } | Surface::Obstacle(shape) => shape.shape().thickness(),
            };
            let expected = format!(
                "a radius or half thickness < {radius} m, the radius of the bore: what only touches the outside of a tube meets it as \
                 a `Capsule`"
            );
            check.require(thickness < *radius, &place, format_args!("{thickness} m thick"), &expected);
        }
    }
    check.finish()
}

/// Smallest radius of the rod of a contact with a tube, and whether all sections are round.
fn of_rod<G: Space>(contacts: &Contacts<G>, contact: usize) -> (f64, bool) {
    let (mut thinnest, mut is_round) = (f64::INFINITY, true);
    for pair in contacts.pairs.iter().filter(|pair| pair.contact == contact) {
        let [Side::Rod(curves), Side::Solid(solid)] = &pair.sides else { continue };
        if !matches!(contacts.solids[*solid].solid, Solid::Tube(_)) {
            continue;
        }
        for curve in &contacts.curves[curves.clone()] {
            let radii = curve.samples.iter().map(|sample| sample.radius);
            thinnest = radii.fold(thinnest, f64::min);
            is_round &= curve.is_round;
        }
    }
    (thinnest, is_round)
}
