//! The actuators of a robot and the inputs of all that acts on it.

use std::sync::Arc;

use super::robot::Robot;
use crate::actuator::{Actuator, Along, Part, Via};
use crate::error::Checker;
use crate::load::check_place;
use crate::rod::STRAIN_NAMES;
use crate::signal::Input;

/// Axes of inputs that are vectors.
const AXES: [&str; 3] = ["x", "y", "z"];

/// The inputs of a robot, in the order in which they first stand in its description.
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
}

impl Inputs {
    /// Those of the loads of a robot, then of its actuators.
    pub(crate) fn of(robot: &Robot) -> Self {
        let mut inputs = Self::default();
        // Problems were found when the robot was checked.
        let mut check = Checker::new();
        inputs.take_all(robot, &mut check);
        inputs
    }

    fn take_all(&mut self, robot: &Robot, check: &mut Checker) {
        for (i, load) in robot.loads.iter().enumerate() {
            for (signal, name) in [(&load.force, "force"), (&load.moment, "moment")] {
                self.take(signal.input(), check, &format!("loads[{i}].{name}"));
            }
        }
        for (i, actuator) in robot.actuators.iter().enumerate() {
            for signal in actuator.signals() {
                self.take(signal.input(), check, &format!("actuators[{i}]"));
            }
        }
    }

    fn take<const N: usize>(&mut self, input: Option<&Input<N>>, check: &mut Checker, place: &str) {
        let Some(Input { name, value }) = input else { return };
        let Some(known) = self.known.iter().find(|known| known.name == *name) else {
            self.known.push(Known { name: Arc::clone(name), first: self.defaults.len(), size: N });
            self.defaults.extend(value);
            return;
        };
        let is_same = known.size == N && self.defaults[known.first..known.first + N] == *value;
        let found = format_args!("the input \"{name}\" with another size or default than elsewhere");
        check.require(is_same, place, found, "one size and one default for all inputs of a name");
    }

    /// Where an input begins in u.
    pub(crate) fn place<const N: usize>(&self, input: &Input<N>) -> usize {
        let known = self.known.iter().find(|known| known.name == input.name);
        known.expect("all inputs of a robot are known").first
    }

    /// The values that they have as long as nobody sets them: u.
    pub fn defaults(&self) -> &[f64] {
        &self.defaults
    }

    /// A name for every entry of u: that of the input, with the axis where it is a vector.
    pub fn names(&self) -> Vec<String> {
        let of_input = |known: &Known| -> Vec<String> {
            match known.size {
                1 => vec![known.name.to_string()],
                size => AXES[..size].iter().map(|axis| format!("{}.{axis}", known.name)).collect(),
            }
        };
        self.known.iter().flat_map(of_input).collect()
    }
}

impl Robot {
    /// What is set from outside.
    pub fn inputs(&self) -> Inputs {
        Inputs::of(self)
    }

    /// Notes what is wrong with its actuators and its inputs.
    pub(super) fn check_actuators(&self, check: &mut Checker) {
        for (i, actuator) in self.actuators.iter().enumerate() {
            let place = format!("actuators[{i}]");
            check.nested(&place, actuator.validate());
            let name = actuator.name();
            let is_new = self.actuators[..i].iter().all(|other| other.name() != name);
            let found = format_args!("\"{name}\", which another actuator has");
            check.require(is_new, &format!("{place}.name"), found, "a new name");
            match actuator {
                Actuator::Tendon(tendon) => {
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
                Actuator::Motor(motor) => {
                    let coordinates = self.links.get(motor.link).map(|link| link.joint.coordinates().len());
                    let found = format_args!("coordinate {} of link {}", motor.coordinate, motor.link);
                    let is_there = coordinates.is_some_and(|number| motor.coordinate < number);
                    check.require(is_there, &format!("{place}.joint"), found, "a coordinate of a joint");
                }
                Actuator::ActiveStrain(active) => {
                    let Some(link) = self.links.get(active.link) else {
                        check.require(false, &format!("{place}.link"), active.link, "a link with a rod");
                        continue;
                    };
                    let has_modes = link
                        .rod
                        .iter()
                        .any(|segment| segment.modes.get(active.strain).is_some_and(|&m| m > 0));
                    let strain = STRAIN_NAMES.get(active.strain).copied().unwrap_or("none");
                    let found = format_args!("{strain} of \"{}\", which has no modes of it", link.name);
                    check.require(has_modes, &format!("{place}.strain"), found, "a strain with modes");
                }
            }
        }
        Inputs::default().take_all(self, check);
    }

    fn check_along(&self, check: &mut Checker, along: &Along, place: &str) {
        let Some(link) = self.links.get(along.link) else {
            check.require(false, &format!("{place}.link"), along.link, "a link with a rod");
            return;
        };
        let found = format_args!("\"{}\", which has no rod", link.name);
        let expected = "a link with a rod; through a rigid body leads a Via";
        if check.require(!link.rod.is_empty(), &format!("{place}.link"), found, expected) {
            for (i, x) in along.along.into_iter().enumerate() {
                check_place(check, x, &format!("{place}.along[{i}]"), link.length());
            }
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
