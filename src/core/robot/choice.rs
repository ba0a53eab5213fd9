//! Choice of the kernel and the linear solver of a robot.

use super::description::{Link, Robot};
use crate::description::joint::Motion;
use crate::description::rod::{STRAIGHT, piece};
use crate::numerics::lie::{Plane, Quaternion};
use crate::robot::effects::actuator::{Actuator, Via};
use crate::robot::effects::contact::{Contact, Surface};
use crate::robot::effects::loops::{Loop, LoopEnd};

/// Kernel of a robot: the geometry of its recursions.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kernel {
    /// Planar motion: for robots whose joints, modes and reference strains stay in one plane.
    Planar,
    /// Spatial motion: for all robots.
    Spatial,
}

impl Kernel {
    /// The plane that a robot cannot leave, if there is one: that of modes and joints, unless the base may
    /// leave it. Loads out of the plane do not move the robot, whatever the direction of gravity.
    pub(crate) fn plane(robot: &Robot) -> Option<Plane> {
        let stays_in = |plane: &Plane| {
            let root = &robot.links[0];
            robot.links.iter().all(|link| {
                let is_placed = std::ptr::eq(link, root) || is_placed_in(plane, link, root);
                is_placed && moves_in(plane, link)
            }) && robot.actuators.iter().all(|actuator| acts_in(plane, actuator))
                && robot.loops.iter().all(|tied| is_tied_in(plane, tied, root))
                && robot.contacts.iter().all(|contact| touches_in(plane, contact, root))
        };
        let base = Quaternion::from_array(robot.links[0].orientation).rotation();
        let base_stays_in = |plane: &Plane| {
            robot.base_motion.as_ref().is_none_or(|motion| motion.stays_in_plane(base.axis(plane.normal)))
        };
        [Plane::ABOUT_Y, Plane::ABOUT_Z].into_iter().filter(stays_in).find(base_stays_in)
    }
}

/// Whether the actuator's forces lie in the plane.
fn acts_in(plane: &Plane, actuator: &Actuator) -> bool {
    let is_along = actuator.along().into_iter().all(|along| {
        // Offsets are along y and z.
        let across = &along.offset[plane.normal - 1];
        across.constant() == Some([0.0])
    });
    // Points of the world are given relative to the root, which may be rotated.
    let is_via = |via: &Via| via.link.is_some() && via.point[plane.normal] == 0.0;
    is_along && actuator.vias().into_iter().all(is_via)
}

/// Whether contact forces lie in the plane.
fn touches_in(plane: &Plane, contact: &Contact, root: &Link) -> bool {
    let i = plane.normal;
    contact.surfaces.iter().all(|surface| match surface {
        Surface::Rod { .. } => true,
        Surface::Ball { position, .. } => position[i] == 0.0,
        // In the axes of a section or body that stays in the plane.
        Surface::Solid { shape, .. } => shape.shape().lies_across(i, 0.0),
        // Obstacles are given relative to the root.
        Surface::Obstacle(obstacle) => {
            root.orientation == [1.0, 0.0, 0.0, 0.0] && obstacle.shape().lies_across(i, root.position[i])
        }
    })
}

/// Whether a loop's constraints do not leave the plane: rows perpendicular to it are then satisfied
/// automatically.
fn is_tied_in(plane: &Plane, tied: &Loop, root: &Link) -> bool {
    let ends = tied.tie.ends().into_iter().flatten();
    let lies_in = |end: &LoopEnd| {
        let [_, turn @ ..] = end.orientation;
        // Points of the world are given relative to the root.
        let is_seen = end.link.is_some()
            || (root.orientation == [1.0, 0.0, 0.0, 0.0] && root.position[plane.normal] == 0.0);
        is_seen && end.position[plane.normal] == 0.0 && plane.axes.iter().all(|&axis| turn[axis] == 0.0)
    };
    ends.into_iter().all(lies_in)
}

/// Whether the joint's frame of a link lies in the plane of its parent. The test is exact, because a small
/// deviation may be intended. Further roots are compared with the first one.
fn is_placed_in(plane: &Plane, link: &Link, root: &Link) -> bool {
    let is_root = link.parent.is_none();
    if is_root && root.orientation != [1.0, 0.0, 0.0, 0.0] {
        return link.position == root.position && link.orientation == root.orientation;
    }
    let [_, turn @ ..] = link.orientation;
    let offset = link.position[plane.normal] - if is_root { root.position[plane.normal] } else { 0.0 };
    offset == 0.0 && plane.axes.iter().all(|&axis| turn[axis] == 0.0)
}

/// Whether joint and rod keep a link in the plane.
fn moves_in(plane: &Plane, link: &Link) -> bool {
    let is_inside = |strain: usize| match strain {
        0..3 => strain == plane.normal,
        _ => plane.axes.contains(&(strain - 3)),
    };
    let motions = link.joint.motions().into_iter().all(|motion| match motion {
        Motion::About(axis) => plane.axes.iter().all(|&i| axis[i] == 0.0),
        Motion::Along(axis) => axis[plane.normal] == 0.0,
        Motion::Screw(..) | Motion::AboutAll => false,
    });
    motions
        && link.rod.iter().all(|segment| {
            (0..STRAIGHT.len()).filter(|&strain| !is_inside(strain)).all(|strain| {
                segment.modes[strain] == 0
                    && segment.reference_strain.is_entry_constant(strain) == Some(STRAIGHT[strain])
            })
        })
}

/// Solver of a robot's linear systems, in the Newton iteration and in forward dynamics.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Solve {
    /// Dense factorisation, at the cost n^3.
    Dense,
    /// Recursions over segments and links ([`crate::numerics::linalg::TreeLu`]), at a cost linear in their number.
    Tree,
}

impl Solve {
    /// The cheaper solver for a robot.
    pub(crate) fn cheapest(robot: &Robot) -> Self {
        let segments: usize = robot.segments().map(piece::number).sum();
        let is_large = match robot.is_rod() {
            true => segments >= SEGMENTS_OF_A_CHAIN && robot.coordinates() >= COORDINATES_OF_A_CHAIN,
            false => robot.coordinates() >= COORDINATES_OF_A_ROBOT,
        };
        if is_large { Self::Tree } else { Self::Dense }
    }
}

/// Number of coordinates from which the chain solver is cheaper for segments of a single rod. Instructions of
/// residual, tangent, factorisation and solve by the chain solver, relative to the dense one (callgrind,
/// x86-64, 2026), by coordinates per segment:
///
/// | coordinates per segment | relative instructions at a number of segments (coordinates) |
/// |---|---|
/// | 1, planar | 1.03 at 8 (8), 1.00 at 12 (12), 0.97 at 16 (16) |
/// | 2, planar | 1.02 at 4 (8), 0.98 at 6 (12), 0.94 at 8 (16), 0.86 at 12 (24) |
/// | 2, spatial | 1.04 at 6 (12), 1.02 at 8 (16), 0.98 at 10 (20) |
/// | 4, spatial | 1.05 at 3 (12), 1.02 at 4 (16), 0.98 at 5 (20), 0.97 at 6 (24) |
/// | 6, spatial | 1.05 at 2 (12), 0.99 at 3 (18), 0.98 at 4 (24) |
/// | 12, spatial | 1.00 at 2 (24) |
/// | 18, spatial | 0.99 at 2 (36), 0.94 at 3 (54) |
pub(crate) const COORDINATES_OF_A_CHAIN: usize = 20;

pub(crate) const SEGMENTS_OF_A_CHAIN: usize = 3;

/// The same for robots of several links. Time of a hundred steps of Newmark's method with the tree solver,
/// relative to the dense one (`cargo bench --bench robot -- 'hundred steps'`, x86-64 with AVX2, 2026):
///
/// | robot | relative time at a number of coordinates |
/// |---|---|
/// | revolute joints in a row | 1.12 at 7, 1.02 at 12, 0.88 at 20, 0.76 at 30, 0.59 at 64 |
/// | a star of them | 0.99 at 7, 0.96 at 12, 0.95 at 20, 0.79 at 30, 0.66 at 64 |
/// | a binary tree of them | 1.02 at 7, 1.00 at 12, 0.89 at 20, 0.72 at 30, 0.50 at 64 |
/// | two joints and one rod | 1.08 at 14, 0.95 at 38 |
/// | two joints and two rods | 0.93 at 26, 0.92 at 74 |
/// | two joints and five rods | 0.99 at 12, 0.98 at 22, 0.88 at 42, 0.86 at 62 |
pub(crate) const COORDINATES_OF_A_ROBOT: usize = 16;
