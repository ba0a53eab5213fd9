//! Compiles contacts to parts of a plan.

mod axes;
mod bodies;
mod bores;
mod extents;
mod stiffness;

use std::f64::consts::PI;
use std::ops::Range;

use crate::error::{Checker, InvalidInput};
use crate::numerics::lie::Vector;
use crate::robot::compile::links::Tree;
use crate::robot::description::Robot;
use crate::robot::effects::contact::clearance;
use crate::robot::effects::contact::obstacles::{Frame, Role, Shape};
use crate::robot::effects::contact::plan::{
    Ball, Contacts, Curve, Fixed, MOST_CHANGES, MOST_INTERVALS, NODES, PLACES, Pair, Sample, Side,
};
use crate::robot::effects::contact::shapes::obstacle::Solid;
use crate::robot::effects::contact::shapes::touch::{Law, excess_at_rest};
use crate::robot::effects::contact::{Contact, Surface};
use crate::robot::kernel::kinematics;
use crate::robot::plan::point::Place;
use crate::robot::plan::{Plan, packed};
use crate::robot::turning::{Turning, place};

use axes::Axes;
use bores::check_bores;
use extents::check_extents;
use stiffness::check_stiffness;
pub(crate) use stiffness::{OVERLAP, default_stiffness, needed_stiffness, of_material, stiffnesses};

/// Sections of a rod do not touch each other if their distance along it is within this multiple of its
/// largest radius: twice half the circumference of the tightest possible ring.
const NEIGHBOURHOOD_IN_RADII: f64 = 2.0 * PI;

/// Sections whose half extents differ by less than this fraction are round.
const ROUND_TOLERANCE: f64 = 1e-12;

/// Rods of a smaller radius, relative to the length of the robot, have softest contacts of this part of the length: a wire with a radius of
/// 1e-4 of its length is at rest over an edge after 160 tangents, after 2700 where its thickness is the measure
/// (`benches/python/speed/contact_stiffness.py`).
const THIN_RADIUS: f64 = 1e-2;

/// Rejects contacts without a stiffness, of sections without extent, and of rods that are thicker than their bores.
pub(crate) fn check<G: Turning>(robot: &Robot, plan: &Plan<G>) -> Result<(), InvalidInput> {
    let mut check = Checker::new();
    check.all(check_stiffness(robot));
    check.all(check_extents(robot, plan));
    check.finish()?;
    check_bores(robot, &plan.effects.contacts)
}

/// Places of all surfaces fixed to links, in the order of contacts and their surfaces.
pub(crate) fn places<G: Turning>(robot: &Robot, tree: &Tree<G>) -> Vec<Option<Place>> {
    let place_of = |surface: &Surface| match surface {
        Surface::Ball { link, at, .. } | Surface::Solid { link, at, .. } => {
            Some(Some(place::on_link(&tree.pieces, &tree.links[*link], *at)))
        }
        Surface::Rod { .. } | Surface::Obstacle(_) => None,
    };
    robot.contacts.iter().flat_map(|contact| &contact.surfaces).filter_map(place_of).collect()
}

/// Compiles the contacts of a plan whose points are known: `surfaces` of its points lists the surfaces fixed
/// to each.
pub(crate) fn compile<G: Turning>(plan: &mut Plan<G>, robot: &Robot) {
    let mut contacts = Contacts::default();
    let mut curves_of: Vec<Option<Range<usize>>> = vec![None; robot.links.len()];
    let mut number = 0;
    let (stiffnesses, length) = (stiffnesses(robot), robot.length());
    for (c, contact) in robot.contacts.iter().enumerate() {
        let axes = contact.surfaces.each_ref().map(|surface| match surface {
            Surface::Ball { link, at, .. } | Surface::Solid { link, at, .. } => {
                number += 1;
                Axes::on_link(&mut contacts, plan, number - 1, *link, *at)
            }
            Surface::Rod { .. } | Surface::Obstacle(_) => {
                Axes::in_world(&mut contacts, plan, &robot.links[0])
            }
        });
        let [a, b] = &contact.surfaces;
        if let Some(pairs) = bodies::pairs_of_bodies([a, b], &axes, &mut contacts) {
            for (is_turned, sides) in pairs {
                let pair = pair(
                    plan,
                    &contacts,
                    (c, law(contact, stiffnesses[c])),
                    contact,
                    is_turned,
                    sides,
                    length,
                );
                contacts.pairs.push(pair);
            }
            continue;
        }
        let forms = [Form::beside(a, &axes[0].frame, b), Form::beside(b, &axes[1].frame, a)];
        let mut place = |(s, form): (usize, Form)| match form {
            Form::Rod { link } => {
                let known = curves_of[link].clone();
                let own = known.unwrap_or_else(|| add_rod(&mut contacts, plan, link));
                curves_of[link] = Some(own.clone());
                vec![Side::Rod(own)]
            }
            Form::Balls { centres, radius, thickness } => {
                let first = contacts.balls.len();
                let on = axes[s].on;
                contacts.balls.extend(centres.into_iter().map(|centre| Ball {
                    on,
                    centre,
                    radius,
                    thickness,
                }));
                (first..contacts.balls.len()).map(Side::Ball).collect()
            }
            Form::Solid(solid) => {
                contacts.solids.push(Fixed { on: axes[s].on, solid });
                vec![Side::Solid(contacts.solids.len() - 1)]
            }
        };
        let [first, second] = forms;
        let mut sides = [place((0, first)), place((1, second))];
        let rank = |sides: &[Side]| match sides[0] {
            Side::Rod(_) => 0,
            Side::Ball(_) => 1,
            Side::Body(_) | Side::Solid(_) => 2,
        };
        let is_turned = rank(&sides[1]) < rank(&sides[0]);
        if is_turned {
            sides.reverse();
        }
        let [first, second] = sides;
        let second = second.into_iter().next().expect("the second side is one");
        for first in first {
            let sides = [first, second.clone()];
            let pair =
                pair(plan, &contacts, (c, law(contact, stiffnesses[c])), contact, is_turned, sides, length);
            contacts.pairs.push(pair);
        }
    }
    contacts.rods = curves_of.into_iter().flatten().collect();
    contacts.capacity = contacts.pairs.iter().map(|pair| places_of(&contacts, &pair.sides)).sum();
    contacts.mobilities = clearance::mobilities(plan, &contacts.curves);
    plan.effects.contacts = contacts;
}

fn law(contact: &Contact, stiffness: f64) -> Law {
    let Contact { dissipation, static_friction, slip_velocity, stribeck_velocity, patch_radius, .. } =
        *contact;
    let friction = contact.largest_friction();
    let excess = match (static_friction, friction) {
        (Some(at_rest), [sliding, ..]) if at_rest > sliding => {
            // The ratio to the friction of fast sliding, by which the law is scaled.
            excess_at_rest(at_rest / sliding, stribeck_velocity / slip_velocity)
        }
        _ => 0.0,
    };
    Law { stiffness, dissipation, friction, slip_velocity, excess, stribeck_velocity, patch_radius }
}

/// The pair of two sides of a contact.
fn pair<G: Turning>(
    plan: &Plan<G>,
    contacts: &Contacts<G>,
    (number, law): (usize, Law),
    contact: &Contact,
    is_turned: bool,
    sides: [Side; 2],
    length: f64,
) -> Pair {
    let neighbourhood = match &sides {
        [Side::Rod(a), Side::Rod(b)] if a == b => NEIGHBOURHOOD_IN_RADII * thickest(contacts, a),
        _ => 0.0,
    };
    let thickness = thickness(contacts, contact, &sides);
    let [soft_depth, growth] = softest(contacts, &sides, thickness, length);
    Pair {
        contact: number,
        is_turned,
        law,
        friction_along: contact.varying_friction(),
        thickness,
        soft_depth,
        growth,
        power: power(contact),
        neighbourhood,
        reaches: reaches(plan, contacts, &sides),
        sides,
    }
}

/// Thickness of the thinner one of two surfaces.
fn thickness<G: Turning>(contacts: &Contacts<G>, contact: &Contact, sides: &[Side; 2]) -> f64 {
    let of_rod = |side: &Side| {
        let Side::Rod(curves) = side else { return f64::INFINITY };
        let samples = contacts.curves[curves.clone()].iter().flat_map(|curve| &curve.samples);
        samples.flat_map(|sample| sample.half_extents).fold(f64::INFINITY, f64::min)
    };
    let of_surface = |surface: &Surface| surface.shape().map_or(f64::INFINITY, Shape::thickness);
    let of_ball = |surface: &Surface| {
        if let Surface::Ball { radius, .. } = surface { *radius } else { f64::INFINITY }
    };
    let surfaces = contact.surfaces.iter().map(|surface| of_surface(surface).min(of_ball(surface)));
    surfaces.chain(sides.iter().map(of_rod)).fold(f64::INFINITY, f64::min)
}

/// Softest contacts of a search: the overlap under the whole force, and the distance by which the obstacle is larger. Thin rods overlap with
/// half-spaces, whose surface shows at any depth on which side they are, by a part of the length. Other obstacles are rounded by that part, so
/// that distances from their edges stay smooth, and the force presses rods into an edge by a quarter of it: their middles stay outside.
fn softest<G: Turning>(contacts: &Contacts<G>, sides: &[Side; 2], thickness: f64, length: f64) -> [f64; 2] {
    let part = THIN_RADIUS * length;
    let grown = [0.5 * part, part];
    match sides {
        [Side::Rod(_), Side::Ball(_)] if thickness < part => grown,
        [Side::Rod(_), Side::Solid(solid)] if thickness < part => match contacts.solids[*solid].solid {
            Solid::HalfSpace { .. } => [part, 0.0],
            // The bore of a tube and hollows of a height field or grid would become narrower.
            Solid::Tube(_) | Solid::HeightField(_) | Solid::DistanceGrid(_) => [thickness, 0.0],
            Solid::Ball { .. } | Solid::Capsule { .. } | Solid::Cuboid { .. } | Solid::ConvexMesh(_) => grown,
        },
        _ => [thickness, 0.0],
    }
}

/// Exponent of the length in the unit N/m^p of a contact's stiffness: 2 along rods (stiffness per length), otherwise 1.
fn power(contact: &Contact) -> i32 {
    let is_rod = |surface: &Surface| matches!(surface, Surface::Rod { .. });
    if contact.surfaces.iter().any(is_rod) { 2 } else { 1 }
}

/// Maximum number of contact points of a pair of sides.
fn places_of<G: Turning>(contacts: &Contacts<G>, [side, other]: &[Side; 2]) -> usize {
    let has_features = |solid: &usize| contacts.solids[*solid].solid.has_features();
    let is_divided = if let Side::Solid(solid) = other { has_features(solid) } else { false };
    let divided = if is_divided { MOST_CHANGES + 1 } else { 1 };
    match side {
        Side::Rod(curves) => {
            let parts = contacts.curves[curves.clone()].iter().map(|curve| curve.samples.len() - 1);
            parts.map(|parts| PLACES * MOST_INTERVALS * divided * parts).sum()
        }
        Side::Body(body) => {
            let body = &contacts.bodies[*body];
            body.corners.len() + body.edges.len()
        }
        Side::Ball(_) | Side::Solid(_) => 1,
    }
}

fn thickest<G: Turning>(contacts: &Contacts<G>, curves: &Range<usize>) -> f64 {
    let samples = contacts.curves[curves.clone()].iter().flat_map(|curve| &curve.samples);
    samples.map(|sample| sample.radius).fold(0.0, f64::max)
}

/// Coordinates that move any of two sides, as ranges of consecutive ones.
fn reaches<G: Turning>(plan: &Plan<G>, contacts: &Contacts<G>, sides: &[Side; 2]) -> Vec<Range<usize>> {
    let moving = |on: Option<usize>| {
        let moved_by = on.map_or(&[][..], |fixture| &contacts.fixtures[fixture].moved_by);
        moved_by.iter().map(|(piece, _)| *piece)
    };
    let mut pieces: Vec<usize> = Vec::new();
    for side in sides {
        match side {
            Side::Rod(curves) => {
                for curve in &contacts.curves[curves.clone()] {
                    pieces.extend(curve.moved_by.iter().map(|(piece, _)| *piece));
                }
            }
            Side::Ball(ball) => pieces.extend(moving(contacts.balls[*ball].on)),
            Side::Body(body) => pieces.extend(moving(contacts.bodies[*body].on)),
            Side::Solid(solid) => pieces.extend(moving(contacts.solids[*solid].on)),
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

/// Adds the curves of a link's rod; returns their indices.
fn add_rod<G: Turning>(contacts: &mut Contacts<G>, plan: &Plan<G>, link: usize) -> Range<usize> {
    let first = contacts.curves.len();
    let mut start = 0.0;
    for s in plan.links[link].rod.clone() {
        let piece = &plan.pieces[s];
        let nodes = piece.gauss.nodes.len();
        let integral = piece.gauss.integral();
        // The nodes are dense enough to resolve all shapes of the piece's degree.
        let samples: Vec<_> = std::iter::once(0.0)
            .chain(piece.gauss.nodes.iter().copied())
            .chain([1.0])
            .map(|x| {
                let half_extents = extents::in_plan(plan, piece.part().half_extents(x));
                Sample { x, radius: half_extents[0].max(half_extents[1]), half_extents }
            })
            .collect();
        let is_round = samples.iter().all(|sample| {
            let [y, z] = sample.half_extents;
            (y - z).abs() <= ROUND_TOLERANCE * sample.radius
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
            thickest: samples.iter().map(|sample| sample.radius).fold(0.0, f64::max),
            samples,
            largest_gap: piece.length * piece.gauss.largest_gap(),
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

/// Representation of a surface, in the axes in which it is computed.
enum Form {
    Rod {
        link: usize,
    },
    /// A ball; or the corners of a body or the ends of a capsule, which are the points that can touch a
    /// half-space first.
    Balls {
        centres: Vec<Vector<f64>>,
        radius: f64,
        thickness: f64,
    },
    Solid(Solid),
}

impl Form {
    fn beside(surface: &Surface, frame: &Frame, other: &Surface) -> Self {
        let ball = |centre, radius| Self::Balls { centres: vec![centre], radius, thickness: radius };
        let shape = match surface {
            Surface::Rod { link } => return Self::Rod { link: *link },
            Surface::Ball { position, radius, .. } => return ball(frame.place(*position), *radius),
            Surface::Solid { shape, .. } | Surface::Obstacle(shape) => shape.shape(),
        };
        let is_plane = |other: &dyn Shape| other.role() == Role::Plane;
        match (shape.solid(frame), other.shape(), shape.corners()) {
            // Against other shapes, spheres are solids.
            (Solid::Ball { centre, radius }, Some(_), _) => ball(centre, radius),
            (_, Some(other), Some(body)) if is_plane(other) => {
                let (corners, radius) = body.corners();
                Self::Balls { centres: frame.places(&corners), radius, thickness: shape.thickness() }
            }
            (solid, ..) => Self::Solid(solid),
        }
    }
}
