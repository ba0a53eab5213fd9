//! Compiles contacts of bodies with corners and edges.
//!
//! Each of two bodies is a solid for the corners and edges of the other one. Sharp edges have no normal, so
//! that forces would jump where a corner slides over an edge. Therefore boxes and sharp meshes are computed
//! as smaller cores, rounded by the difference.

use super::axes::Axes;
use crate::numerics::lie::Vector;
use crate::robot::effects::contact::Surface;
use crate::robot::effects::contact::obstacles::Role;
use crate::robot::effects::contact::plan::{Body, Contacts, Fixed, Side};
use crate::robot::effects::contact::shapes::obstacle::Solid;
use crate::robot::plan::space::Space;

/// Rounding radius of edges of boxes and sharp meshes, relative to half the thickness of the thinner body.
/// Overlaps are usually far smaller; a box's support becomes narrower by no more than this radius.
const ROUNDING: f64 = 0.04;

/// Pairs by which the contact of two bodies, or of a body and a height field or tube, is computed, each with a flag
/// for swapped surfaces; `None` for other pairs.
pub(super) fn pairs_of_bodies<G: Space>(
    surfaces: [&Surface; 2],
    axes: &[Axes; 2],
    contacts: &mut Contacts<G>,
) -> Option<Vec<(bool, [Side; 2])>> {
    let [first, second] = [surfaces[0].shape()?, surfaces[1].shape()?];
    let mut found = Vec::new();
    if let (Some(corners), Some(others)) = (first.corners(), second.corners()) {
        let thickness = first.thickness().min(second.thickness());
        let bodies = [corners, others];
        let cores = bodies.map(|body| body.core(ROUNDING * thickness));
        for s in 0..2 {
            let other = 1 - s;
            let own = &cores[s];
            // Beyond the rounded edges the nearest face may differ from the one through which a corner has
            // entered.
            let measure = thickness.min(2.0 * (cores[0].radius + cores[1].radius));
            let body = Body {
                edges: own.edges.clone(),
                measure,
                ..body(&axes[s], &own.corners, own.radius, thickness)
            };
            let body = add_body(contacts, body);
            let solid = bodies[other].rounded(&cores[other], &axes[other].frame);
            found.push((s == 1, [body, add_solid(contacts, &axes[other], solid)]));
        }
        return Some(found);
    }
    for (s, shape, ground) in [(0, first, second), (1, second, first)] {
        if let (Some(corners), Role::Ground) = (shape.corners(), ground.role()) {
            let (places, radius) = corners.places_on_ground();
            let body = add_body(contacts, body(&axes[s], &places, radius, shape.thickness()));
            let ground = ground.solid(&axes[1 - s].frame);
            found.push((s == 1, [body, add_solid(contacts, &axes[1 - s], ground)]));
        }
    }
    if found.is_empty() { None } else { Some(found) }
}

/// A body with corners and without edges.
fn body(axes: &Axes, corners: &[Vector<f64>], radius: f64, thickness: f64) -> Body {
    let corners: Vec<_> = corners.iter().map(|corner| axes.frame.place(corner.to_array())).collect();
    let away = corners.iter().map(|&corner| (corner - corners[0]).dot(corner - corners[0]));
    let size = away.fold(0.0, f64::max).sqrt();
    let edges = Vec::new();
    Body { on: axes.on, corners, edges, first_corner: 0, size, radius, thickness, measure: thickness }
}

fn add_body<G: Space>(contacts: &mut Contacts<G>, body: Body) -> Side {
    let first_corner = contacts.bodies.iter().map(|body| body.corners.len()).sum();
    contacts.bodies.push(Body { first_corner, ..body });
    Side::Body(contacts.bodies.len() - 1)
}

fn add_solid<G: Space>(contacts: &mut Contacts<G>, axes: &Axes, solid: Solid) -> Side {
    contacts.solids.push(Fixed { on: axes.on, solid });
    Side::Solid(contacts.solids.len() - 1)
}
