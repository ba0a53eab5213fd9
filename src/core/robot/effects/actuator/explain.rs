//! Explanations of actuators.

use crate::robot::description::Robot;
use crate::robot::effects::actuator::{
    ActiveStrain, Actuator, Along, Chamber, Drive, Motor, MotorCommand, Tendon,
};
use crate::robot::explain::cost::{OfActuator, Share};
use crate::robot::explain::text::{Explained, counted, listed};

/// Up to this number, all actuators with the same text are named; otherwise only the first and the last.
const LISTED_NAMES: usize = 3;

/// Texts for the actuators and inputs of a robot; one text for actuators with identical text.
pub(crate) fn explain(robot: &Robot, of_actuators: &[OfActuator]) -> Vec<Explained> {
    let mut groups: Vec<Group> = Vec::new();
    for (actuator, of_actuator) in robot.actuators.iter().zip(of_actuators) {
        let (kind, parts) = parts(robot, actuator, of_actuator);
        match groups.iter_mut().find(|group| group.kind == kind && group.parts == parts) {
            Some(group) => group.names.push(actuator.name()),
            None => groups.push(Group { kind, names: vec![actuator.name()], parts }),
        }
    }
    let mut explained: Vec<Explained> = groups.iter().flat_map(Group::explained).collect();
    if explained.is_empty() {
        explained.push((false, "actuators".into(), "none".into()));
    }
    let inputs = robot.inputs().names();
    if !inputs.is_empty() {
        let why = format!("{}: set from outside, with exact derivatives", inputs.join(", "));
        explained.push((true, "inputs".into(), why));
    }
    explained
}

/// Actuators with identical text.
struct Group<'a> {
    kind: &'static str,
    names: Vec<&'a str>,
    parts: Vec<Part>,
}

impl Group<'_> {
    /// `tendon a`, `tendons a, b`, `5 tendons, a to e`.
    fn name(&self) -> String {
        let kind = self.kind;
        match &self.names[..] {
            [name] => format!("{kind} {name}"),
            names if names.len() <= LISTED_NAMES => format!("{kind}s {}", names.join(", ")),
            [first, .., last] => format!("{} {kind}s, {first} to {last}", self.names.len()),
            [] => kind.to_owned(),
        }
    }

    fn explained(&self) -> Vec<Explained> {
        let name = self.name();
        let present = |part: &Part| {
            let what = if part.name.is_empty() { name.clone() } else { format!("{name}, {}", part.name) };
            Some((true, what, part.text.clone()?))
        };
        let mut explained: Vec<Explained> = self.parts.iter().filter_map(present).collect();
        let absent = self.parts.iter().filter(|part| part.text.is_none());
        let absent: Vec<&str> = absent.map(|part| part.name).collect();
        if !absent.is_empty() {
            explained.push((false, name, absent.join(", ")));
        }
        explained
    }
}

/// Explains which parts of an actuator are computed or skipped.
fn parts(robot: &Robot, actuator: &Actuator, of_actuator: &OfActuator) -> (&'static str, Vec<Part>) {
    match actuator {
        Actuator::Tendon(tendon) => ("tendon", of_tendon(robot, tendon, of_actuator)),
        Actuator::Chamber(chamber) => ("chamber", of_chamber(robot, chamber)),
        Actuator::Motor(motor) => ("motor", of_motor(robot, motor)),
        Actuator::ActiveStrain(active) => ("active strain", of_active_strain(robot, active)),
    }
}

/// A part of an actuator's computation, the first one without a name; parts without text are omitted.
#[derive(PartialEq)]
struct Part {
    name: &'static str,
    text: Option<String>,
}

fn part(name: &'static str, is_there: bool, text: impl FnOnce() -> String) -> Part {
    Part { name, text: is_there.then(text) }
}

fn absent(name: &'static str) -> Part {
    part(name, false, String::new)
}

/// The first part: the effect of the actuator.
fn first(text: impl Into<String>) -> Part {
    part("", true, || text.into())
}

fn of_tendon(robot: &Robot, tendon: &Tendon, of_actuator: &OfActuator) -> Vec<Part> {
    let force = match tendon.drive {
        Drive::Tension(_) => "commanded tension, never less than zero".to_owned(),
        Drive::Length { stiffness: None, .. } => {
            "1 constraint: the path is never longer than the commanded length; its multiplier is the tension"
                .to_owned()
        }
        Drive::Length { stiffness: Some(stiffness), damping, .. } => {
            let damping = if damping > 0.0 { format!(", damping {damping} N s/m") } else { String::new() };
            format!("a spring of {stiffness} N/m{damping}; slack below the commanded length")
        }
    };
    let along: Vec<&Along> = tendon.path.iter().filter_map(|part| part.along()).collect();
    let &OfActuator { share: Share { nodes, coordinates, .. }, lines, couples_pieces } = of_actuator;
    vec![
        first(force),
        part("along rods", nodes > 0, || {
            format!("{}, {}: from strains only, without poses", paths(robot, &along), counted(nodes, "node"))
        }),
        part("straight parts", lines > 0, || format!("{lines}: from poses; dead loads on both ends")),
        part("friction", tendon.friction > 0.0, || {
            let slides = match tendon.sliding {
                Some(_) => "direction of sliding as commanded",
                None => "direction of sliding from the rate of its length",
            };
            let what = "its angle, and a tangent with one more sweep out and back";
            format!("coefficient {}: {what}; {slides}", tendon.friction)
        }),
        part("coupling", couples_pieces, || {
            format!("of {}: dense linear systems", counted(coordinates, "coordinate"))
        }),
    ]
}

fn of_chamber(robot: &Robot, chamber: &Chamber) -> Vec<Part> {
    let along: Vec<&Along> = chamber.path.iter().collect();
    let paths = paths(robot, &along);
    vec![first(format!("{paths}: its volume is linear, its forces are constant")), absent("tangent")]
}

fn of_motor(robot: &Robot, motor: &Motor) -> Vec<Part> {
    let link = &robot.links[motor.link];
    let coordinate = format!("{}.{}", link.name, link.joint.coordinates()[motor.coordinate]);
    let (what, is_servo) = match motor.command {
        MotorCommand::Torque(_) => (format!("commanded force on {coordinate}"), false),
        MotorCommand::Position { stiffness, damping, .. } => {
            (format!("holds {coordinate} by a spring of {stiffness} and a damper of {damping}"), true)
        }
    };
    vec![
        first(what),
        part("limits", motor.limits.is_some(), || {
            let [lowest, highest] = motor.limits.unwrap_or_default();
            format!("from {lowest} to {highest}, smoothed to be differentiable")
        }),
        part("tangent", is_servo, || "one entry".to_owned()),
    ]
}

fn of_active_strain(robot: &Robot, active: &ActiveStrain) -> Vec<Part> {
    let (strain, link) = (active.strain.name(), &robot.links[active.link].name);
    let rod = if robot.is_rod() { "the rod" } else { link };
    vec![first(format!("a reference {strain} of {rod}: its forces are constant")), absent("tangent")]
}

/// Paths along rods: `finger from 0 m to 0.1 m`.
fn paths(robot: &Robot, parts: &[&Along]) -> String {
    let way = |along: &&Along| {
        let link = &robot.links[along.link];
        let name = if robot.is_rod() { "the rod" } else { &link.name };
        let [from, to] = along.along;
        if from <= 0.0 && to >= link.length() {
            name.to_owned()
        } else {
            format!("{name} from {from} m to {to} m")
        }
    };
    listed(parts.iter().map(way))
}
