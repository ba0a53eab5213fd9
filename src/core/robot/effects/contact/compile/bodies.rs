//! Bodies that touch each other with corners and edges.
//!
//! Each of two bodies is a solid for the corners and edges of the other one. Sharp edges have no normal, so
//! that forces would jump where a corner slides over an edge. Therefore boxes and sharp meshes are computed
//! as smaller cores, rounded by the difference.

use super::axes::{Axes, solid};
use crate::numerics::lie::{Quaternion, Vector};
use crate::robot::effects::contact::plan::{Body, Contacts, Fixed, Side};
use crate::robot::effects::contact::shapes::convex_mesh::ConvexMesh;
use crate::robot::effects::contact::shapes::obstacle::Solid;
use crate::robot::effects::contact::{Obstacle, Surface};
use crate::robot::plan::space::Space;

/// Rounding radius of edges of boxes and sharp meshes, relative to half the thickness of the thinner body.
/// Overlaps are usually far smaller; a box's support becomes narrower by no more than this radius.
const ROUNDING: f64 = 0.04;

/// Number of points along a capsule for contact with height fields and tubes.
const PLACES_OF_CAPSULE: usize = 5;

/// Pairs by which the contact of two bodies, or of a body and a height field or tube, is computed, each with a flag
/// for swapped surfaces; `None` for other pairs.
pub(super) fn meet<G: Space>(
    surfaces: [&Surface; 2],
    axes: &[Axes; 2],
    contacts: &mut Contacts<G>,
) -> Option<Vec<(bool, [Side; 2])>> {
    let [first, second] = [surfaces[0].shape()?, surfaces[1].shape()?];
    let is_field = |shape: &Obstacle| matches!(shape, Obstacle::HeightField { .. } | Obstacle::Tube { .. });
    let mut found = Vec::new();
    if first.has_corners() && second.has_corners() {
        let thickness = thickness(first).min(thickness(second));
        let cores = [first, second].map(|shape| Core::of(shape, ROUNDING * thickness));
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
            let solid = cores[other].solid([first, second][other], &axes[other]);
            found.push((s == 1, [body, add_solid(contacts, &axes[other], solid)]));
        }
        return Some(found);
    }
    for (s, shape, field) in [(0, first, second), (1, second, first)] {
        if shape.has_corners() && is_field(field) {
            let (places, radius) = places_on_ground(shape);
            let body = add_body(contacts, body(&axes[s], &places, radius, thickness(shape)));
            let ground = solid(field, &axes[1 - s]);
            found.push((s == 1, [body, add_solid(contacts, &axes[1 - s], ground)]));
        }
    }
    if found.is_empty() { None } else { Some(found) }
}

/// A body with corners and without edges.
fn body(axes: &Axes, corners: &[Vector<f64>], radius: f64, thickness: f64) -> Body {
    let corners: Vec<_> = corners.iter().map(|corner| axes.place(corner.to_array())).collect();
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

/// Core of a body: the body is everything within a radius of it.
struct Core {
    corners: Vec<Vector<f64>>,
    edges: Vec<[usize; 2]>,
    radius: f64,
}

/// Distance from the middle of a body to its surface.
pub(super) fn thickness(shape: &Obstacle) -> f64 {
    match shape {
        Obstacle::Sphere { radius, .. } | Obstacle::Capsule { radius, .. } => *radius,
        Obstacle::Cuboid { half_extents, .. } => half_extents.iter().copied().fold(f64::INFINITY, f64::min),
        Obstacle::ConvexMesh { points, faces, radius } => {
            let points: Vec<_> = points.iter().map(|&point| Vector::from(point)).collect();
            ConvexMesh::new(&points, faces, *radius).thickness(&points)
        }
        Obstacle::Tube { radius, wall, .. } => 0.5 * wall.unwrap_or(*radius),
        _ => f64::INFINITY,
    }
}

impl Core {
    /// Core of a body whose sharp edges are rounded by a radius.
    fn of(shape: &Obstacle, rounding: f64) -> Self {
        match shape {
            Obstacle::Capsule { ends, radius } => Self {
                corners: ends.iter().map(|&end| Vector::from(end)).collect(),
                edges: vec![[0, 1]],
                radius: *radius,
            },
            Obstacle::Cuboid { centre, half_extents, orientation } => {
                let half_extents = half_extents.map(|half| half - rounding);
                let corners = corners_of_box(*centre, half_extents, *orientation);
                Self { corners, edges: edges_of_box(), radius: rounding }
            }
            Obstacle::ConvexMesh { points, faces, radius } => {
                let points: Vec<_> = points.iter().map(|&point| Vector::from(point)).collect();
                let mesh = ConvexMesh::new(&points, faces, *radius);
                let edges = mesh.edges();
                if *radius > 0.0 {
                    return Self { corners: points, edges, radius: *radius };
                }
                Self { corners: mesh.inset(&points, rounding), edges, radius: rounding }
            }
            _ => unreachable!("half-spaces, spheres, height fields and tubes have no corners"),
        }
    }

    /// The body as a solid for the other one.
    fn solid(&self, shape: &Obstacle, axes: &Axes) -> Solid {
        match shape {
            Obstacle::ConvexMesh { faces, .. } => {
                let points = self.corners.iter().map(|corner| corner.to_array()).collect();
                let core = Obstacle::ConvexMesh { points, faces: faces.clone(), radius: self.radius };
                solid(&core, axes)
            }
            _ => match solid(shape, axes) {
                Solid::Cuboid { centre, axes, half_extents, .. } => {
                    let by = Vector::from([self.radius; 3]);
                    Solid::Cuboid { centre, axes, half_extents: half_extents - by, radius: self.radius }
                }
                other => other,
            },
        }
    }
}

/// Corners of a box: bit i of the index is the side along axis i.
pub(super) fn corners_of_box(
    centre: [f64; 3],
    half_extents: [f64; 3],
    orientation: [f64; 4],
) -> Vec<Vector<f64>> {
    let axes = Quaternion::from_array(orientation).rotation();
    let corner = |k: usize| {
        let beside = std::array::from_fn(|i| half_extents[i] * if k >> i & 1 == 0 { -1.0 } else { 1.0 });
        Vector::from(centre) + axes.apply(Vector::from(beside))
    };
    (0..8).map(corner).collect()
}

fn edges_of_box() -> Vec<[usize; 2]> {
    let along = |i: usize| (0..8).filter(move |k| k >> i & 1 == 0).map(move |k| [k, k | 1 << i]);
    (0..3).flat_map(along).collect()
}

/// Points of a body that touch height fields and tubes, and their radius: corners, and middles of edges and faces; for
/// a capsule, points along it.
fn places_on_ground(shape: &Obstacle) -> (Vec<Vector<f64>>, f64) {
    let mean = |points: &[Vector<f64>]| {
        let sum = points.iter().fold(Vector::zero(), |sum, &point| sum + point);
        sum * (points.len() as f64).recip()
    };
    match shape {
        Obstacle::Capsule { ends, radius } => {
            let [start, end] = ends.map(Vector::from);
            let place = |k: usize| start + (end - start) * (k as f64 / (PLACES_OF_CAPSULE - 1) as f64);
            ((0..PLACES_OF_CAPSULE).map(place).collect(), *radius)
        }
        Obstacle::Cuboid { centre, half_extents, orientation } => {
            let mut places = corners_of_box(*centre, *half_extents, *orientation);
            let corners = places.clone();
            places.extend(edges_of_box().iter().map(|&[p, q]| mean(&[corners[p], corners[q]])));
            for i in 0..3 {
                for side in 0..2 {
                    let face: Vec<_> = (0..8).filter(|k| k >> i & 1 == side).map(|k| corners[k]).collect();
                    places.push(mean(&face));
                }
            }
            (places, 0.0)
        }
        Obstacle::ConvexMesh { points, faces, radius } => {
            let mut places: Vec<_> = points.iter().map(|&point| Vector::from(point)).collect();
            let corners = places.clone();
            let mesh = ConvexMesh::new(&corners, faces, *radius);
            places.extend(mesh.edges().iter().map(|&[p, q]| mean(&[corners[p], corners[q]])));
            places.extend(faces.iter().map(|face| mean(&face.map(|p| corners[p]))));
            (places, *radius)
        }
        _ => unreachable!("half-spaces, spheres and height fields have no corners"),
    }
}
