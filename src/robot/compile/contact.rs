//! Compiles contacts to parts of a plan.

use std::f64::consts::{FRAC_PI_4, PI};
use std::ops::Range;
use std::sync::Arc;

use super::links::Tree;
use crate::contact::{Contact, Obstacle, Surface};
use crate::lie::{Quaternion, Rotation, Vector};
use crate::robot::algebra::convex_mesh::ConvexMesh;
use crate::robot::algebra::height_field::HeightField;
use crate::robot::algebra::obstacle::Solid;
use crate::robot::algebra::touch::Law;
use crate::robot::description::{Link, Robot};
use crate::robot::kernel::kinematics;
use crate::robot::plan::contact::{
    Ball, Contacts, Curve, MOST_CHANGES, MOST_INTERVALS, NODES, PLACES, Pair, Sample, Side,
};
use crate::robot::plan::point::{Place, Point};
use crate::robot::plan::{Plan, packed};
use crate::robot::turning::{Turning, place};

/// Places of a rod are neighbours, which do not touch, up to that many of its largest radius along it: half the way around a
/// ring as tight as it can be, and as much again.
const NEIGHBOURHOOD: f64 = 2.0 * PI;

/// Sections whose half extents differ by less than that part are round.
const ROUND: f64 = 1e-12;

/// The places of all balls, in the order of the contacts and their surfaces.
pub(crate) fn places<G: Turning>(robot: &Robot, tree: &Tree<G>) -> Vec<Option<Place>> {
    let place_of = |surface: &Surface| match surface {
        Surface::Ball { link, at, .. } => Some(Some(place::on_link(&tree.pieces, &tree.links[*link], *at))),
        _ => None,
    };
    robot.contacts.iter().flat_map(|contact| &contact.surfaces).filter_map(place_of).collect()
}

/// What touches of a plan whose points are known: `balls` of these says which balls are at which.
pub(crate) fn compile<G: Turning>(plan: &Plan<G>, robot: &Robot) -> Contacts<G> {
    let mut contacts = Contacts::none();
    let mut curves_of: Vec<Option<Range<usize>>> = vec![None; robot.links.len()];
    for (c, contact) in robot.contacts.iter().enumerate() {
        let mut sides = contact.surfaces.each_ref().map(|surface| match surface {
            Surface::Rod { link } => {
                let known = curves_of[*link].clone();
                let own = known.unwrap_or_else(|| add_rod(&mut contacts, plan, *link));
                curves_of[*link] = Some(own.clone());
                Side::Rod(own)
            }
            Surface::Ball { position, radius, .. } => {
                contacts.balls.push(ball(plan, contacts.balls.len(), *position, *radius));
                Side::Ball(contacts.balls.len() - 1)
            }
            Surface::Obstacle(obstacle) => {
                contacts.solids.push(solid(obstacle, &robot.links[0]));
                Side::Solid(contacts.solids.len() - 1)
            }
        });
        let is_turned = matches!(sides, [Side::Ball(_), Side::Rod(_)]);
        if is_turned {
            sides.reverse();
        }
        let neighbourhood = match &sides {
            [Side::Rod(a), Side::Rod(b)] if a == b => NEIGHBOURHOOD * thickest(&contacts, a),
            _ => 0.0,
        };
        let Contact { dissipation, friction, slip_velocity, patch_radius, .. } = *contact;
        let stiffness = stiffness(contact, robot);
        let law = Law { stiffness, dissipation, friction, slip_velocity, patch_radius };
        let reaches = reaches(plan, &contacts, &sides);
        contacts.pairs.push(Pair { contact: c, is_turned, sides, law, neighbourhood, reaches });
    }
    contacts.capacity = contacts.pairs.iter().map(|pair| places_of(&contacts, &pair.sides)).sum();
    contacts
}

/// How many places of a first side can be touched.
fn places_of<G: Turning>(contacts: &Contacts<G>, [side, other]: &[Side; 2]) -> usize {
    let has_features = |solid: &usize| contacts.solids[*solid].has_features();
    let is_divided = if let Side::Solid(solid) = other { has_features(solid) } else { false };
    let divided = if is_divided { MOST_CHANGES + 1 } else { 1 };
    match side {
        Side::Rod(curves) => {
            let parts = contacts.curves[curves.clone()].iter().map(|curve| curve.samples.len() - 1);
            parts.map(|parts| PLACES * MOST_INTERVALS * divided * parts).sum()
        }
        _ => 1,
    }
}

fn thickest<G: Turning>(contacts: &Contacts<G>, curves: &Range<usize>) -> f64 {
    let samples = contacts.curves[curves.clone()].iter().flat_map(|curve| &curve.samples);
    samples.map(|sample| sample.radius).fold(0.0, f64::max)
}

/// The coordinates that move any of two sides, as runs of neighbouring ones.
fn reaches<G: Turning>(plan: &Plan<G>, contacts: &Contacts<G>, sides: &[Side; 2]) -> Vec<Range<usize>> {
    let mut pieces: Vec<usize> = Vec::new();
    for side in sides {
        match side {
            Side::Rod(curves) => {
                for curve in &contacts.curves[curves.clone()] {
                    pieces.extend(curve.moved_by.iter().map(|(piece, _)| *piece));
                }
            }
            Side::Ball(ball) => pieces.extend(contacts.balls[*ball].moved_by.iter().map(|(piece, _)| *piece)),
            Side::Solid(_) => {}
        }
    }
    let mut reaches: Vec<usize> = pieces.into_iter().flat_map(|s| plan.pieces[s].coordinates()).collect();
    reaches.sort_unstable();
    reaches.dedup();
    let mut runs: Vec<Range<usize>> = Vec::new();
    for k in reaches {
        match runs.last_mut() {
            Some(run) if run.end == k => run.end += 1,
            _ => runs.push(k..k + 1),
        }
    }
    runs
}

/// Adds the curves of a link's rod; returns where they are.
fn add_rod<G: Turning>(contacts: &mut Contacts<G>, plan: &Plan<G>, link: usize) -> Range<usize> {
    let first = contacts.curves.len();
    // A plane cuts sections along one of their axes, and sees that alone.
    let is_seen = [Vector::new(0.0, 1.0, 0.0), Vector::new(0.0, 0.0, 1.0)].map(|axis| {
        let kept = G::in_space(plan.frame, G::vector_of(plan.frame, axis));
        kept.dot(kept) > 0.5
    });
    let seen = |[y, z]: [f64; 2]| match is_seen {
        [true, false] => [y; 2],
        [false, true] => [z; 2],
        _ => [y, z],
    };
    let mut start = 0.0;
    for s in plan.links[link].rod.clone() {
        let piece = &plan.pieces[s];
        let nodes = piece.gauss.nodes.len();
        let integral = piece.gauss.integral();
        // Nodes are so close that shapes of the piece's degree hardly turn twice between them.
        let samples: Vec<_> = std::iter::once(0.0)
            .chain(piece.gauss.nodes.iter().copied())
            .chain([1.0])
            .map(|x| {
                let half_extents = seen(piece.part().half_extents(x));
                Sample { x, radius: half_extents[0].max(half_extents[1]), half_extents }
            })
            .collect();
        let is_round = samples.iter().all(|sample| {
            let [y, z] = sample.half_extents;
            (y - z).abs() <= ROUND * sample.radius
        });
        let whole = samples
            .windows(2)
            .map(|ends| {
                NODES.map(|node| {
                    let up_to = integral.weights_up_to(ends[0].x + (ends[1].x - ends[0].x) * node);
                    packed(nodes, |l| piece.length * up_to[l])
                })
            })
            .collect();
        let moved_by = kinematics::moved_by(plan, &place::at_fraction(&plan.pieces, s, 1.0));
        let expansion: Vec<_> = integral.expansion().iter().map(|row| packed(nodes, |l| row[l])).collect();
        let first_coefficient = contacts.curves.iter().map(|curve| curve.expansion.len()).sum();
        let first_term = contacts.curves.iter().map(Curve::terms).sum();
        let first_sample = contacts.curves.iter().map(|curve| curve.samples.len()).sum();
        let inverse_weights = packed(nodes, |l| 1.0 / (piece.length * piece.gauss.weights[l]));
        contacts.packs = contacts.packs.max(piece.packs);
        contacts.curves.push(Curve {
            piece: s,
            length: piece.length,
            start,
            is_round,
            whole,
            samples,
            first_sample,
            expansion,
            first_coefficient,
            first_term,
            integral,
            inverse_weights,
            moved_by,
        });
        start += piece.length;
    }
    first..contacts.curves.len()
}

fn ball<G: Turning>(plan: &Plan<G>, number: usize, position: [f64; 3], radius: f64) -> Ball<G::Pack> {
    let has_it = |point: &Point<G>| point.balls.contains(&number);
    let point = plan.points.iter().position(has_it).expect("every ball is at a point");
    let at = &plan.points[point].place;
    let position = Vector::from(position);
    let beside =
        at.beside.map_or(position, |place| place.position + place.orientation.rotation().apply(position));
    Ball { point, beside, radius, moved_by: kinematics::moved_by(plan, at) }
}

/// An obstacle as it is seen from the frame of the plan, that of the first link's joint.
fn solid(obstacle: &Obstacle, root: &Link) -> Solid {
    let base = Quaternion::from_array(root.orientation).rotation();
    let turned = |v: Vector<f64>| base.apply_transposed(v);
    let seen = |point: &[f64; 3]| turned(Vector::from(*point) - Vector::from(root.position));
    let axes_of = |orientation: &[f64; 4]| {
        let Rotation { x, y, z } = Quaternion::from_array(*orientation).rotation();
        Rotation { x: turned(x), y: turned(y), z: turned(z) }
    };
    match obstacle {
        Obstacle::HalfSpace { point, normal } => {
            let normal = Vector::from(crate::joint::unit(*normal));
            Solid::HalfSpace { point: seen(point), normal: turned(normal) }
        }
        Obstacle::Sphere { centre, radius } => Solid::Ball { centre: seen(centre), radius: *radius },
        Obstacle::Capsule { ends: [start, end], radius } => {
            Solid::Capsule { ends: [seen(start), seen(end)], radius: *radius }
        }
        Obstacle::Cuboid { centre, half_extents, orientation } => {
            let axes = axes_of(orientation);
            Solid::Cuboid { centre: seen(centre), axes, half_extents: Vector::from(*half_extents) }
        }
        Obstacle::HeightField { heights, shape, spacing, corner, orientation } => {
            let axes = axes_of(orientation);
            Solid::HeightField(Arc::new(HeightField::new(heights, *shape, *spacing, seen(corner), axes)))
        }
        Obstacle::ConvexMesh { points, faces, radius } => {
            let points: Vec<_> = points.iter().map(seen).collect();
            Solid::ConvexMesh(Arc::new(ConvexMesh::new(&points, faces, *radius)))
        }
    }
}

/// What was given, or that of the material: a cylinder is pressed into a half-space with `pi / 4 E*` a metre and overlap, with
/// `E* = E / (1 - nu^2)` (Popov 2010, eq. 5.33), two of them in a row.
pub(crate) fn stiffness(contact: &Contact, robot: &Robot) -> f64 {
    if let Some(stiffness) = contact.stiffness {
        return stiffness;
    }
    let of_rod = |surface: &Surface| match surface {
        Surface::Rod { link } => robot.links[*link]
            .rod
            .iter()
            .map(|segment| {
                let nu = segment.poisson_ratio();
                (1.0 - nu * nu) / segment.young_modulus
            })
            .reduce(f64::max),
        _ => None,
    };
    let compliance: f64 = contact.surfaces.iter().filter_map(of_rod).sum();
    FRAC_PI_4 / compliance
}
