//! The actuators of a robot, and the inputs of actuators and loads.

use std::collections::HashSet;
use std::sync::Arc;

use super::carriers::{Carrier, Carriers};
use super::driven::Driven;
use super::link::Link;
use super::robot::{Robot, check_name};
use super::signals::SignalOf;
use crate::description::joint::Joint;
use crate::description::rod::arc_length::check_place;
use crate::description::rod::{STRAIN_NAMES, Segment};
use crate::description::schema::Item as _;
use crate::description::signal::{Input, Signal};
use crate::error::{Checker, Number};
use crate::robot::effects::actuator::{Actuator, Along, Motor, Part, Tendon, Via};

/// Suffixes of vector inputs.
const AXES: [&str; 3] = ["x", "y", "z"];

/// Inputs of a robot, in the order of their first appearance in its description.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Inputs {
    known: Vec<Known>,
    defaults: Vec<f64>,
}

#[derive(Clone, Debug, PartialEq)]
struct Known {
    name: Arc<str>,
    first: usize,
    size: usize,
    /// First appearance in the description.
    place: String,
}

impl Known {
    /// Names of all entries.
    fn names(&self) -> Vec<String> {
        match self.size {
            1 => vec![self.name.to_string()],
            size => AXES[..size].iter().map(|axis| format!("{}.{axis}", self.name)).collect(),
        }
    }
}

impl Inputs {
    /// Inputs of the loads of a robot, then of its actuators.
    pub(crate) fn of(robot: &Robot) -> Self {
        let mut inputs = Self::default();
        // Validation of the robot has reported all problems.
        let mut check = Checker::new();
        inputs.take_all(robot, &mut check);
        inputs
    }

    fn take_all(&mut self, robot: &Robot, check: &mut Checker) {
        for placed in robot.signals_with_places() {
            match placed.signal {
                SignalOf::Number(Signal::Input(input)) => self.take(input, check, &placed.place()),
                SignalOf::Vector(Signal::Input(input)) => self.take(input, check, &placed.place()),
                _ => {}
            }
        }
    }

    fn take<const N: usize>(&mut self, Input { name, value }: &Input<N>, check: &mut Checker, place: &str) {
        let Some(known) = self.known.iter().find(|known| known.name == *name) else {
            let new = Known {
                name: Arc::clone(name),
                first: self.defaults.len(),
                size: N,
                place: place.to_owned(),
            };
            let names = new.names();
            for known in &self.known {
                if let Some(taken) = known.names().iter().find(|taken| names.contains(taken)) {
                    let expected = format!(
                        "another name: that is an entry of the input \"{}\" at {}, too",
                        known.name, known.place
                    );
                    let entry = if N == 1 { String::new() } else { format!(" with an entry \"{taken}\"") };
                    check.require(false, place, format_args!("the input \"{name}\"{entry}"), &expected);
                }
            }
            self.known.push(new);
            self.defaults.extend(value);
            return;
        };
        let before = &self.defaults[known.first..known.first + known.size];
        let [found, expected] = [value, before].map(|default| match default {
            [number] => format!("the default {}", Number(*number)),
            vector => {
                format!("the default ({})", vector.iter().map(f64::to_string).collect::<Vec<_>>().join(", "))
            }
        });
        let found = format_args!("the input \"{name}\" with {found}");
        let expected = format!("{expected} as before: inputs of one name are one");
        check.require(before == value, place, found, &expected);
    }

    /// Index in u of an input's first entry.
    pub fn place<const N: usize>(&self, input: &Input<N>) -> usize {
        let known = self.known.iter().find(|known| known.name == input.name);
        known.expect("all inputs of a robot are known").first
    }

    /// Default values of u.
    pub fn defaults(&self) -> &[f64] {
        &self.defaults
    }

    /// Names of the entries of u: the name of the input, with a suffix for each axis of a vector.
    pub fn names(&self) -> Vec<String> {
        self.known.iter().flat_map(Known::names).collect()
    }
}

/// Whether all coordinates of a joint are rotations about or translations along axes, which motors can drive.
/// Other joints have rotation vectors, or the position of a free joint.
fn has_axes(joint: &Joint) -> bool {
    !matches!(joint, Joint::Weld | Joint::Spherical | Joint::Free)
}

/// Whether the joint's motion is prescribed in time. A joint that mimics another one is not prescribed
/// itself.
fn is_prescribed(link: &Link) -> bool {
    matches!(link.driven, Some(Driven::Coordinate(_) | Driven::Base(_)))
}

impl Robot {
    /// Inputs of the robot.
    pub fn inputs(&self) -> Inputs {
        Inputs::of(self)
    }

    /// Reports problems of the actuators and inputs.
    pub(super) fn check_actuators(&self, check: &mut Checker, carriers: &Carriers<'_>) {
        let mut names = HashSet::with_capacity(self.actuators.len());
        for (i, actuator) in self.actuators.iter().enumerate() {
            let place = format!("actuators[{i}]");
            check.nested(&place, self.described_actuator(actuator).validate());
            check_name(check, &mut names, actuator.name(), &place, "actuator");
            match actuator {
                Actuator::Tendon(tendon) => {
                    if tendon.path.len() > 1
                        && let Some(body) = self.only_body(tendon, carriers)
                    {
                        let expected = "parts along a rod, or points of which not all are there: else it acts on nothing";
                        let found = format_args!("only points {body}");
                        check.require(false, &format!("{place}.path"), found, expected);
                    }
                    for (k, part) in tendon.path.iter().enumerate() {
                        let place = format!("{place}.path[{k}]");
                        match part {
                            Part::Along(along) => self.check_along(check, along, &place),
                            Part::Via(via) => self.check_via(check, via, &place),
                        }
                    }
                }
                Actuator::Chamber(chamber) => {
                    for (k, along) in chamber.path.iter().enumerate() {
                        self.check_along(check, along, &format!("{place}.path[{k}]"));
                    }
                }
                Actuator::Motor(motor) => self.check_motor(check, motor, &format!("{place}.joint")),
                Actuator::ActiveStrain(active) => {
                    let Some(link) = self.links.get(active.link) else {
                        check.require(false, &format!("{place}.link"), active.link, "a link with a rod");
                        continue;
                    };
                    let found = format_args!("\"{}\", which has no rod", link.name);
                    if !check.require(
                        !link.rod.is_empty(),
                        &format!("{place}.link"),
                        found,
                        "a link with a rod",
                    ) {
                        continue;
                    }
                    let modes = |strain: usize| {
                        let of_segment = |segment: &Segment| segment.modes.get(strain).copied().unwrap_or(0);
                        link.rod.iter().map(of_segment).sum::<usize>()
                    };
                    let strain = active.strain.name();
                    let found = format_args!("{strain}, of which \"{}\" has no modes", link.name);
                    let known: Vec<_> = STRAIN_NAMES
                        .iter()
                        .enumerate()
                        .filter(|(i, _)| modes(*i) > 0)
                        .map(|(_, name)| *name)
                        .collect();
                    let expected = match known.is_empty() {
                        true => "modes of it in a segment: without, nothing can move".to_owned(),
                        false => format!("modes of it in a segment, or one of {}", known.join(", ")),
                    };
                    check.require(
                        modes(active.strain as usize) > 0,
                        &format!("{place}.strain"),
                        found,
                        &expected,
                    );
                }
            }
        }
        Inputs::default().take_all(self, check);
    }

    /// The body that carries all points of a tendon's path, in words, if it is a single one: the tendon's length is then constant.
    fn only_body(&self, tendon: &Tendon, carriers: &Carriers<'_>) -> Option<String> {
        let vias = tendon.path.iter().map(Part::via).collect::<Option<Vec<_>>>()?;
        let carrier = |via: &Via| match via.link {
            None => Some(Carrier::World),
            Some(link) => carriers.at(link, via.at),
        };
        let first = vias.first()?;
        let body = carrier(first)?;
        if vias.iter().any(|via| carrier(via) != Some(body)) {
            return None;
        }
        let Some(other) = vias.iter().find(|via| via.link != first.link) else {
            let where_to = if first.link.is_some() { "on one body or section" } else { "in the world" };
            return Some(where_to.to_owned());
        };
        let [a, b] = [first.link, other.link].map(|link| self.name_of(link));
        Some(format!("on {a} and {b}, which are welded together"))
    }

    /// Link and joint coordinate of a motor's place, which is the name of a link whose joint has one
    /// coordinate, or the name of a coordinate. Includes coordinates that no motor can drive.
    pub fn motor_coordinate(&self, name: &str) -> Option<(usize, usize)> {
        let is_one = |link: &Link| link.joint.coordinates().len() == 1 || !has_axes(&link.joint);
        if let Some(link) = self.links.iter().position(|link| link.name == name && is_one(link)) {
            return Some((link, 0));
        }
        let of_link = |link: &Link| {
            let coordinate = name.strip_prefix(&link.name)?.strip_prefix('.')?;
            link.joint.coordinates().iter().position(|known| *known == coordinate)
        };
        self.links.iter().enumerate().find_map(|(i, link)| of_link(link).map(|coordinate| (i, coordinate)))
    }

    /// Names of all coordinates that a motor can drive.
    pub fn motor_coordinates(&self) -> Vec<String> {
        let can_move = |link: &&Link| has_axes(&link.joint) && !is_prescribed(link);
        let names = |link: &Link| -> Vec<String> {
            link.joint.coordinates().iter().map(|coordinate| format!("{}.{coordinate}", link.name)).collect()
        };
        self.links.iter().filter(can_move).flat_map(names).collect()
    }

    /// Names of all valid places of motors: links whose joint has a single coordinate that can be driven, and
    /// coordinates.
    pub fn motor_places(&self) -> Vec<String> {
        let is_one = |link: &&Link| {
            has_axes(&link.joint) && !is_prescribed(link) && link.joint.coordinates().len() == 1
        };
        let links = self.links.iter().filter(is_one).map(|link| link.name.clone());
        links.chain(self.motor_coordinates()).collect()
    }

    fn check_motor(&self, check: &mut Checker, motor: &Motor, place: &str) {
        let Some(link) = self.links.get(motor.link) else {
            check.require(false, place, motor.link, "a link with a joint");
            return;
        };
        let kind = link.joint.name();
        let found = format_args!("\"{}\", a {kind} joint", link.name);
        let expected = "a revolute, prismatic, screw, cylindrical, universal or planar joint; a Load with frame \"body\" turns and \
                        pushes other links";
        if !check.require(has_axes(&link.joint), place, found, expected) {
            return;
        }
        let found = format_args!("\"{}\", whose motion is prescribed", link.name);
        let expected = "a joint that moves freely; joint_wrench says what a prescribed motion takes, and a motor with \
                        position and gains follows a position";
        check.require(!is_prescribed(link), place, found, expected);
        let found = format_args!("coordinate {} of \"{}\"", motor.coordinate, link.name);
        let is_there = motor.coordinate < link.joint.coordinates().len();
        check.require(is_there, place, found, "a coordinate of the joint");
    }

    fn check_along(&self, check: &mut Checker, along: &Along, place: &str) {
        let Some(link) = self.links.get(along.link) else {
            check.require(false, &format!("{place}.link"), along.link, "a link with a rod");
            return;
        };
        let found = format_args!("\"{}\", which has no rod", link.name);
        let expected = "a link with a rod; through a rigid body leads a point";
        let has_rod = check.require(!link.rod.is_empty(), &format!("{place}.link"), found, expected);
        let [from, to] = along.along;
        if has_rod && 0.0 <= from && from < to {
            check_place(check, to, &format!("{place}.along[1]"), link.length());
        }
    }

    fn check_via(&self, check: &mut Checker, via: &Via, place: &str) {
        let Some(link) = via.link else {
            let expected = "none: a point of the world lies on no rod";
            check.require(via.at.is_none(), &format!("{place}.at"), via.at.unwrap_or(0.0), expected);
            return;
        };
        let Some(link) = self.links.get(link) else {
            check.require(false, &format!("{place}.link"), link, "a link, or none for the world");
            return;
        };
        let Some(x) = via.at else { return };
        let place = format!("{place}.at");
        if link.rod.is_empty() {
            let found = format_args!("{x} on \"{}\", which has no rod", link.name);
            check.require(false, &place, found, "none: the point is on a body");
        } else {
            check_place(check, x, &place, link.length());
        }
    }
}
