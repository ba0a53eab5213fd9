//! Lengths of the parts that constraints join, with which gaps are compared.

use super::{Robot, link::Link};
use crate::robot::effects::actuator::Actuator;
use crate::robot::effects::loops::{Loop, LoopEnd, Tie};

/// Place of stretch among the strains.
const STRETCH: usize = 3;

/// Lengths that differ by less are equal.
const ROUNDING: f64 = 1e-9;

/// Lengths of the chains of links that move the ends of loops and tendons, in metres: from the first joint or rod that moves an end to
/// this end. Other links and the position of the first joint have no influence. For points that only prismatic joints move, it is the
/// length of the tendon or of the distance itself.
#[derive(Debug)]
pub struct Spans<'a> {
    robot: &'a Robot,
    /// For every link, the distance along the chain to its base, and the extent of its rod and bodies.
    arms: Vec<[f64; 2]>,
}

impl Robot {
    /// Length of the chain that moves a point of a link, given in its axes, in metres.
    pub fn span(&self, link: usize, point: [f64; 3]) -> f64 {
        let spans = Spans::new(self);
        spans.or_robot(spans.to(link, point))
    }
}

impl<'a> Spans<'a> {
    /// The lengths of the chains of a robot.
    pub fn new(robot: &'a Robot) -> Self {
        let mut extents: Vec<f64> = robot.links.iter().map(Link::length).collect();
        for body in robot.all_bodies() {
            extents[body.link] = extents[body.link].max(body.extent());
        }
        let starts = starts(robot).into_iter().map(|(start, _)| start);
        let arms = starts.zip(extents).map(|(start, extent)| [start, extent]).collect();
        Self { robot, arms }
    }

    /// The length of the chain to the end of a link.
    pub fn of_link(&self, link: usize) -> f64 {
        self.or_robot(self.arms[link].iter().sum())
    }

    /// The length of the chains to the ends of a loop, the larger one of both.
    pub(crate) fn of_loop(&self, closed: &Loop) -> f64 {
        if let Tie::Coordinates { coordinates: [first, _], .. } = closed.tie {
            let has_it = |&link: &usize| self.robot.coordinates_of(link).contains(&first);
            return self.of_link((0..self.robot.links.len()).find(has_it).unwrap_or_default());
        }
        let of_end = |end: &LoopEnd| end.link.map_or(0.0, |link| self.to(link, end.position));
        let of_ends = closed.tie.ends().into_iter().flatten().map(of_end).fold(0.0, f64::max);
        let own = if let Tie::Distance { length, .. } = closed.tie { length } else { 0.0 };
        self.or_robot(if of_ends > 0.0 { of_ends } else { own })
    }

    /// The length of the longest chain that a tendon passes.
    pub(crate) fn of_tendon(&self, actuator: &Actuator) -> f64 {
        let vias = actuator.vias();
        let of_vias = vias.iter().map(|via| via.link.map_or(0.0, |link| self.to(link, via.point)));
        let along = actuator.along();
        let of_rods = along.iter().map(|along| self.of_link(along.link));
        let of_chains = of_vias.chain(of_rods).fold(0.0, f64::max);
        let own = || actuator.shortest_command().unwrap_or(0.0);
        self.or_robot(if of_chains > 0.0 { of_chains } else { own() })
    }

    fn to(&self, link: usize, point: [f64; 3]) -> f64 {
        let [start, extent] = self.arms[link];
        start + extent.max(size(point))
    }

    /// This span, or the length of the robot if it is zero.
    fn or_robot(&self, span: f64) -> f64 {
        if span > 0.0 { span } else { self.robot.length() }
    }
}

/// How a chain that does not stretch compares with the distance of its ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Tightness {
    TooShort,
    /// Exactly as long: a straight line, whose force nothing determines.
    Taut,
}

impl Robot {
    /// The distance of the base of a chain from the place in the world to which a loop ties its end, and the length of the chain, in
    /// metres, and how they compare; `None` if the chain is longer, or if joints or stretch make it longer.
    pub(crate) fn tightness(&self, closed: &Loop) -> Option<(Tightness, [f64; 2])> {
        let [a, b] = closed.tie.ends()?;
        let (end, anchor) = if b.link.is_none() { (a, b) } else { (b, a) };
        let (mut link, None) = (&self.links[end.link?], anchor.link) else { return None };
        let bar = if let Tie::Distance { length, .. } = closed.tie { length } else { 0.0 };
        let mut length = bar + end.at.unwrap_or(link.length()) + size(end.position);
        let is_fixed = |link: &Link| {
            let turns = link.joint.motions().iter().all(|motion| motion.is_turn());
            turns && link.rod.iter().all(|segment| segment.modes[STRETCH] == 0)
        };
        while is_fixed(link) {
            let Some(parent) = link.parent else {
                let apart = size(std::array::from_fn(|i| anchor.position[i] - link.position[i]));
                let tightness = match apart / length {
                    ratio if ratio > 1.0 + ROUNDING => Tightness::TooShort,
                    ratio if ratio > 1.0 - ROUNDING => Tightness::Taut,
                    _ => return None,
                };
                return Some((tightness, [apart, length]));
            };
            length += self.distance_to(link);
            link = &self.links[parent];
        }
        None
    }
}

/// For every link, the distance along its chain from the first joint or rod that moves it, in metres, and whether there is one.
pub(super) fn starts(robot: &Robot) -> Vec<(f64, bool)> {
    let mut starts: Vec<(f64, bool)> = Vec::with_capacity(robot.links.len());
    for link in &robot.links {
        let carrier = link.parent.map(|parent| starts[parent]).filter(|&(_, moves)| moves);
        let start = carrier.map_or(0.0, |(start, _)| start + robot.distance_to(link));
        starts.push((start, carrier.is_some() || link.coordinates() > 0 || link.driven.is_some()));
    }
    starts
}

pub(super) fn size(v: [f64; 3]) -> f64 {
    v.into_iter().map(|x| x * x).sum::<f64>().sqrt()
}
