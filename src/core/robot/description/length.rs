//! The length of a robot, to which accuracies, sizes and steps are relative.

use std::f64::consts::TAU;

use super::link::Link;
use super::robot::Robot;
use super::span::{size, starts};
use crate::description::joint::Joint;
use crate::robot::effects::actuator::{Actuator, Via};
use crate::robot::effects::contact::Surface;
use crate::robot::effects::loops::Tie;

/// Centres of mass closer to the section than this part of the radius of gyration count as on it.
const ROUNDING: f64 = 1e-9;

impl Robot {
    /// Length of the robot in metres: the largest distance of stretched-out links and bodies from the first joint or rod that moves
    /// them; if this is zero, the first positive one of `Self::breadth`, `Self::travel` and `Self::apart`; otherwise one.
    pub fn length(&self) -> f64 {
        let starts = starts(self);
        let of_links = self.links.iter().enumerate().map(|(i, link)| (i, link.length()));
        let of_bodies = self.all_bodies().map(|body| {
            let centre = size(body.centre);
            // An offset of the centre that is rounding of the input has no influence.
            let beside = if centre > ROUNDING * body.radius_of_gyration() { centre } else { 0.0 };
            (body.link, body.at.unwrap_or(self.links[body.link].length()) + beside)
        });
        let extents: Vec<(usize, f64)> = of_links.chain(of_bodies).collect();
        let is_any_moving = starts.iter().any(|&(_, moves)| moves);
        let counted = extents.iter().filter(|&&(link, _)| starts[link].1 || !is_any_moving);
        let longest = counted.map(|&(link, extent)| starts[link].0 + extent).fold(0.0, f64::max);
        let sizes = [longest, self.breadth(), self.travel(), self.apart()];
        let known = sizes.into_iter().find(|length| *length > 0.0);
        known.unwrap_or(1.0)
    }

    /// Distance from the base of its parent to a link, along the parent's rod, in metres.
    pub(super) fn distance_to(&self, link: &Link) -> f64 {
        let along = link.parent.map_or(0.0, |parent| link.at.unwrap_or(self.links[parent].length()));
        along + size(link.position)
    }

    /// Size of a robot without extent along its links, in metres: the largest of the radii of gyration of bodies, the radii of balls
    /// and the lengths of tendons.
    fn breadth(&self) -> f64 {
        let of_bodies = self.all_bodies().map(|body| body.radius_of_gyration());
        let surfaces = self.contacts.iter().flat_map(|contact| &contact.surfaces);
        let of_balls = surfaces.filter_map(|surface| match surface {
            Surface::Ball { radius, .. } => Some(*radius),
            _ => None,
        });
        let of_tendons = self.actuators.iter().filter_map(Actuator::shortest_command);
        of_bodies.chain(of_balls).chain(of_tendons).fold(0.0, f64::max)
    }

    /// Largest travel of links without size, in metres: along the straight parts of tendons, to where springs of joints are relaxed or
    /// carry the weight, and between stops.
    fn travel(&self) -> f64 {
        // Nothing is beside its parent.
        let root = |mut link: usize| {
            while let Some(parent) = self.links[link].parent {
                link = parent;
            }
            self.links[link].position
        };
        let place = |via: &Via| via.link.map_or(via.point, root);
        let between = |from: [f64; 3], to: [f64; 3]| size(std::array::from_fn(|k| to[k] - from[k]));
        let of_tendons = self.actuators.iter().flat_map(|actuator| {
            let vias = actuator.vias();
            let straight = vias.windows(2).map(|ends| between(place(ends[0]), place(ends[1])));
            let beside = vias.iter().filter(|via| via.link.is_some()).map(|via| size(via.point));
            straight.chain(beside).collect::<Vec<_>>()
        });
        let weight = self.all_bodies().map(|body| body.mass).sum::<f64>() * size(self.gravity);
        // With the translation by a unit of the coordinate.
        let of_joints = self.links.iter().filter_map(|link| match &link.joint {
            Joint::Prismatic { forces, .. } => Some((forces, 1.0)),
            Joint::Screw { forces, lead, .. } => Some((forces, lead.abs() / TAU)),
            _ => None,
        });
        let of_springs = of_joints.map(|(forces, advance)| {
            let sag = if forces.stiffness > 0.0 { advance * weight / forces.stiffness } else { 0.0 };
            let range = forces.limits.map_or(0.0, |[lower, upper]| upper - lower);
            let rest = if forces.stiffness > 0.0 { forces.rest.abs() } else { 0.0 };
            advance * sag.max(rest).max(if range.is_finite() { range } else { 0.0 })
        });
        of_tendons.chain(of_springs).fold(0.0, f64::max)
    }

    /// Largest distance between links without size and travel, in metres: the diagonal of the box around the first links of all
    /// chains, and the lengths of distance loops.
    fn apart(&self) -> f64 {
        let roots = self.links.iter().filter(|link| link.parent.is_none()).map(|link| link.position);
        let none = [[f64::INFINITY; 3], [f64::NEG_INFINITY; 3]];
        let [least, most] = roots.fold(none, |[least, most], place| {
            let each =
                |pick: fn(f64, f64) -> f64, of: [f64; 3]| std::array::from_fn(|k| pick(of[k], place[k]));
            [each(f64::min, least), each(f64::max, most)]
        });
        let of_roots = size(std::array::from_fn(|k| most[k] - least[k]));
        let of_loops = self.loops.iter().filter_map(|closed| match closed.tie {
            Tie::Distance { length, .. } => Some(length),
            _ => None,
        });
        of_loops.fold(of_roots, f64::max)
    }
}
