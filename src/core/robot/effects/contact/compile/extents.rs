//! Half extents of the sections of rods in contact. Sections given by stiffness and inertia have those of the ellipse with the same
//! inertia; without inertia they have none, and contact is rejected.

use super::stiffness::PARTS;
use crate::description::rod::Segment;
use crate::error::{Checker, InvalidInput};
use crate::numerics::lie::Vector;
use crate::robot::description::Robot;
use crate::robot::effects::contact::Surface;
use crate::robot::plan::Plan;
use crate::robot::turning::Turning;

/// The half extents along y and z that can touch: a plane of motion intersects sections along one of their axes, and only that extent
/// matters.
pub(super) fn in_plan<G: Turning>(plan: &Plan<G>, [y, z]: [f64; 2]) -> [f64; 2] {
    let is_seen = [Vector::new(0.0, 1.0, 0.0), Vector::new(0.0, 0.0, 1.0)].map(|axis| {
        let kept = G::in_space(plan.frame, G::vector_of(plan.frame, axis));
        kept.dot(kept) > 0.5
    });
    match is_seen {
        [true, false] => [y; 2],
        [false, true] => [z; 2],
        _ => [y, z],
    }
}

/// Rejects contacts of rods whose sections have no extent.
pub(super) fn check_extents<G: Turning>(robot: &Robot, plan: &Plan<G>) -> Result<(), InvalidInput> {
    let has_extent = |segment: &Segment, x: f64| {
        let extents = in_plan(plan, segment.section.half_extents(x));
        extents.iter().all(|&extent| extent > 0.0)
    };
    let mut check = Checker::new();
    for (i, contact) in robot.contacts.iter().enumerate() {
        for (surface, place) in contact.surfaces.iter().zip(["a", "b"]) {
            let Surface::Rod { link } = surface else { continue };
            let link = &robot.links[*link];
            let flat = link
                .rod
                .iter()
                .position(|segment| (0..=PARTS).any(|part| !has_extent(segment, part as f64 / PARTS as f64)));
            check.require(
                flat.is_none(),
                &format!("contacts[{i}].{place}"),
                format_args!(
                    "the rod of \"{}\", of which segments[{}] has no radius: its section is given without inertia",
                    link.name,
                    flat.unwrap_or(0)
                ),
                "a section with the `inertia` of what touches (an ellipse of that inertia and mass is what touches), or a Ball at a \
                 place of the rod instead of all of it",
            );
        }
    }
    check.finish()
}
