//! Questions about obstacles and shapes whose lengths are probably in other units than those of the robot.

use super::sizes::half_width;
use super::text::significant;
use crate::description::joint::Joint;
use crate::numerics::lie::{Rotation, Vector};
use crate::robot::description::{Link, Robot};
use crate::robot::effects::contact::Surface;
use crate::robot::effects::contact::obstacles::{Frame, Obstacle};

/// Distance of an obstacle over what a robot can reach: nothing stretches so far, and millimetres are at least a hundred times as many.
const OUT_OF_REACH: f64 = 10.0;

/// Bore of a tube over the half width of the rod in it. A cable in a tunnel comes near to it; in millimetres it is at least a thousand.
const WIDEST_BORE: f64 = 500.0;

/// Size of a shape on a link over the reach of the robot, as of a platform that carries a small one.
const LARGEST_SHAPE: f64 = 100.0;

/// Size of an obstacle over the length of the rod that touches it, and its thickness over half the width of that: below both it is
/// neither a bump nor an edge.
const SMALLEST: f64 = 1e-3;
const THINNEST: f64 = 0.1;

/// Where a link can be: within a distance of the base of its chain of links.
#[derive(Clone, Copy)]
struct Reach {
    /// The first link of the chain.
    root: usize,
    base: Vector<f64>,
    /// Distance of the far end of the link.
    far: f64,
}

/// A question about each contact whose surfaces cannot touch or do not fit each other.
pub(super) fn implausible_distances(robot: &Robot) -> Vec<String> {
    let reaches = reaches(robot);
    let of_contact = |contact: &crate::robot::effects::contact::Contact| {
        let [a, b] = &contact.surfaces;
        let question = match (a, b) {
            (moving, Surface::Obstacle(obstacle)) | (Surface::Obstacle(obstacle), moving) => {
                of_obstacle(robot, &reaches, moving, obstacle)
            }
            _ => None,
        };
        let on_links = || [a, b].into_iter().find_map(|surface| of_shape_on_link(robot, surface));
        question
            .or_else(on_links)
            .map(|what| format!("In the contact {:?} {what}; are all lengths in metres?", contact.name))
    };
    robot.contacts.iter().filter_map(of_contact).collect()
}

/// How far links can be from the bases of their chains; `None` where something translates.
fn reaches(robot: &Robot) -> Vec<Option<Reach>> {
    let mut reaches: Vec<Option<Reach>> = Vec::with_capacity(robot.links.len());
    for (i, link) in robot.links.iter().enumerate() {
        let turns = matches!(
            link.joint,
            Joint::Weld | Joint::Revolute { .. } | Joint::Universal { .. } | Joint::Spherical
        );
        let own = link.length();
        let reach = match link.parent {
            _ if !turns || robot.base_motion.is_some() => None,
            None => Some(Reach { root: i, base: Vector::from(link.position), far: own }),
            Some(parent) => reaches[parent].map(|Reach { root, base, far }| {
                let beside = size(Vector::from(link.position));
                Reach { root, base, far: far + beside + own }
            }),
        };
        reaches.push(reach);
    }
    reaches
}

/// What is odd about an obstacle in the world and the surface that is to touch it.
fn of_obstacle(
    robot: &Robot,
    reaches: &[Option<Reach>],
    moving: &Surface,
    obstacle: &Obstacle,
) -> Option<String> {
    let link = moving.link()?;
    let (label, shape) = (obstacle.shape().label(), obstacle.shape());
    let rod = &robot.links[link];
    if matches!(moving, Surface::Rod { .. }) {
        let (width, length) = (width(rod), rod.length());
        if let Obstacle::Tube(tube) = obstacle
            && width > 0.0
            && tube.radius > WIDEST_BORE * width
        {
            let width = significant(2.0 * width);
            return Some(format!("{label} in radius is around {:?}, which is {width} m wide", rod.name));
        }
        let (across, thickness) = (extent(obstacle), shape.thickness());
        if across < SMALLEST * length && thickness < THINNEST * width {
            let [across, length] = [across, length].map(significant);
            return Some(format!("{label} is {across} m large, and {:?} {length} m long", rod.name));
        }
    }
    let Reach { root, base, far } = reaches[link]?;
    let far = far + beyond(moving);
    let frame = Frame::of(Rotation::identity(), Vector::zero());
    let distance = shape.solid(&frame).distance(base).value;
    if far <= 0.0 || distance <= OUT_OF_REACH * far {
        return None;
    }
    let [distance, far] = [distance, far].map(significant);
    Some(format!(
        "{label} lies {distance} m from the base of {:?}, and {:?} reaches {far} m from there: they never touch",
        robot.links[root].name, rod.name,
    ))
}

/// What is odd about a ball or another shape on a link.
fn of_shape_on_link(robot: &Robot, surface: &Surface) -> Option<String> {
    let beyond = beyond(surface);
    let sizes = robot.links.iter().map(|link| link.length() + size(Vector::from(link.position)));
    let whole: f64 = sizes.sum();
    // A robot of one body has no size.
    if whole <= 0.0 || beyond <= LARGEST_SHAPE * whole {
        return None;
    }
    let label = surface.obstacle().map_or_else(|| "a ball".to_owned(), |shape| shape.shape().label());
    let link = &robot.links[surface.link()?].name;
    let [beyond, whole] = [beyond, whole].map(significant);
    Some(format!(
        "{label} on {link:?} reaches {beyond} m from its place, and all links together are {whole} m long"
    ))
}

/// How far a bounded surface on a link reaches from its place.
fn beyond(surface: &Surface) -> f64 {
    match surface {
        Surface::Ball { position, radius, .. } => size(Vector::from(*position)) + radius,
        Surface::Solid { shape, .. } => {
            let frame = Frame::of(Rotation::identity(), Vector::zero());
            let reach = shape.shape().solid(&frame).reach();
            if reach.is_finite() { reach } else { 0.0 }
        }
        Surface::Rod { .. } | Surface::Obstacle(_) => 0.0,
    }
}

/// The largest extent of a bounded obstacle, from its own description; infinite for others.
fn extent(obstacle: &Obstacle) -> f64 {
    match obstacle {
        Obstacle::HalfSpace(_) | Obstacle::HeightField(_) => f64::INFINITY,
        Obstacle::Sphere(sphere) => 2.0 * sphere.radius,
        Obstacle::Capsule(capsule) => across(&[capsule.start, capsule.end]) + 2.0 * capsule.radius,
        Obstacle::Cuboid(cuboid) => 2.0 * size(Vector::from(cuboid.half_extents)),
        Obstacle::ConvexMesh(mesh) => across(&mesh.points) + 2.0 * mesh.radius,
        Obstacle::Tube(tube) => across(&tube.points) + 2.0 * tube.radius,
        Obstacle::DistanceGrid(grid) => {
            let sides = (0..3).map(|i| grid.spacing.0[i] * (grid.values.shape[i] as f64 - 1.0));
            sides.map(|side| side * side).sum::<f64>().sqrt()
        }
        Obstacle::Mesh(mesh) => across(&mesh.points),
    }
}

/// Diagonal of the box around some points.
fn across(points: &[[f64; 3]]) -> f64 {
    let along = |axis: usize| {
        let values = points.iter().map(|point| point[axis]);
        let [least, most] =
            values.fold([f64::INFINITY, -f64::INFINITY], |[least, most], x| [least.min(x), most.max(x)]);
        most - least
    };
    size(Vector::from(std::array::from_fn(along)))
}

fn size(v: Vector<f64>) -> f64 {
    v.dot(v).sqrt()
}

fn width(link: &Link) -> f64 {
    link.rod.iter().map(half_width).fold(0.0, f64::max)
}
