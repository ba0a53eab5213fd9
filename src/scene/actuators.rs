//! Actuators from their tables, which follow the rod or the links on which they act.

use super::described::Written;
use super::document::{self, AlongRod, AlongRodTable, Document, PathPart, Strain};
use super::loops::expected_name;
use super::parts;
use super::shape::{Shape, report};
use crate::actuator::{
    ActiveStrain, Actuator, Along, Chamber, Drive, Motor, MotorCommand, Part, Tendon, Via,
};
use crate::robot::{Robot, number_default_names};
use crate::rod::{Profile, STRAIN_NAMES};
use crate::signal::Signal;

/// Default rate of length, in m/s, below which a tendon's friction is smoothed.
const FRICTION_VELOCITY: f64 = 1e-3;

/// The model on which actuators act.
#[derive(Clone, Copy)]
pub(super) struct Surroundings<'a> {
    /// The robot with its links.
    pub(super) robot: &'a Robot,
    /// Whether the model is a rod, which actuators need not name.
    pub(super) is_rod: bool,
    /// Whether there are further links that could not be read.
    pub(super) are_incomplete: bool,
}

/// Actuators of a scene with their keys in the file: tendons, then chambers, motors and active strains. Omits
/// actuators on unknown links.
pub(super) fn actuators(
    document: &Document,
    surroundings: Surroundings<'_>,
    shape: &mut Shape,
) -> (Vec<Actuator>, Vec<String>) {
    let mut found = Vec::new();
    let mut has_default_name = Vec::new();
    for (i, written) in document.tendon.iter().enumerate() {
        let key = format!("tendon[{i}]");
        found.extend(tendon(written, &key, surroundings, shape).map(|it| (Actuator::Tendon(it), key)));
    }
    for (i, written) in document.chamber.iter().enumerate() {
        let key = format!("chamber[{i}]");
        found.extend(chamber(written, &key, surroundings, shape).map(|it| (Actuator::Chamber(it), key)));
    }
    has_default_name.resize(found.len(), false);
    for (i, written) in document.motor.iter().enumerate() {
        let key = format!("motor[{i}]");
        found.extend(motor(written, &key, surroundings, shape).map(|it| (Actuator::Motor(it), key)));
        has_default_name.resize(found.len(), written.name.is_none());
    }
    for (i, written) in document.active_strain.iter().enumerate() {
        let key = format!("active_strain[{i}]");
        let active = active_strain(written, &key, surroundings, shape);
        found.extend(active.map(|it| (Actuator::ActiveStrain(it), key)));
        has_default_name.resize(found.len(), written.name.is_none());
    }
    let names = found.iter_mut().map(|(actuator, _): &mut (Actuator, String)| actuator.name_mut());
    number_default_names(names.zip(has_default_name));
    found.into_iter().unzip()
}

/// Key in the file for a place in the actuators of a robot, which have these keys.
pub(super) fn key_of_actuator(place: &str, keys: &[String]) -> Option<String> {
    let (i, rest) = place.strip_prefix("actuators[")?.split_once(']')?;
    Some(format!("{}{rest}", keys.get(i.parse::<usize>().ok()?)?))
}

impl Surroundings<'_> {
    /// The link with this name, or the only link; `None` after reporting a problem.
    fn link(self, name: Option<&str>, key: &str, shape: &mut Shape) -> Option<usize> {
        let names: Vec<&str> = self.robot.links.iter().map(|link| link.name.as_str()).collect();
        let (wrong, right) = match name {
            Some(name) if self.is_rod => {
                (format!("\"{name}\", but a rod is one link"), "remove it: it is on the rod".to_owned())
            }
            None if names.len() == 1 && !self.are_incomplete => return Some(0),
            None => ("no link, and there are several".to_owned(), expected_name("", &names, "link")),
            Some(name) => match names.iter().position(|known| *known == name) {
                Some(link) => return Some(link),
                None => (format!("no link is called \"{name}\""), expected_name(name, &names, "link")),
            },
        };
        if (!self.are_incomplete || name.is_none()) && shape.is_readable(key) {
            shape.refuse(key, wrong, right);
        }
        None
    }
}

/// The one of two commands that the scene contains; `None` after reporting a problem.
fn one_of(
    written: [(&str, &Option<Written<Signal<1>>>); 2],
    here: &str,
    shape: &mut Shape,
) -> Option<(usize, Signal<1>)> {
    let [(first, one), (second, other)] = written;
    match (one, other) {
        (Some(one), None) => Some((0, parts::command(one, &format!("{here}.{first}"), shape))),
        (None, Some(other)) => Some((1, parts::command(other, &format!("{here}.{second}"), shape))),
        (Some(_), Some(_)) => {
            shape.refuse(
                &format!("{here}.{second}"),
                format!("both {first} and {second}"),
                "keep one of them",
            );
            None
        }
        (None, None) => {
            if [first, second].iter().all(|key| shape.is_readable(&format!("{here}.{key}"))) {
                shape.refuse(here, format!("neither {first} nor {second}"), "add one of them");
            }
            None
        }
    }
}

/// Reports keys that only another kind of command uses.
fn refuse_with(key: &str, here: &str, what: &str, shape: &mut Shape) {
    shape.refuse(&format!("{here}.{key}"), format!("{key} with {what}"), "remove it");
}

fn tendon(
    written: &document::Tendon,
    here: &str,
    surroundings: Surroundings<'_>,
    shape: &mut Shape,
) -> Option<Tendon> {
    let path: Vec<_> = (written.path.iter().enumerate())
        .map(|(i, written)| part(written, &format!("{here}.path[{i}]"), surroundings, shape))
        .collect();
    let command = one_of([("tension", &written.tension), ("length", &written.length)], here, shape);
    let sliding =
        written.sliding.as_ref().map(|written| parts::command(written, &format!("{here}.sliding"), shape));
    let drive = match (command?, written.stiffness) {
        ((0, tension), stiffness) => {
            for (key, value) in [("stiffness", stiffness), ("damping", written.damping)] {
                if value.is_some() {
                    refuse_with(key, here, "a tension: it belongs to a tendon of a given length", shape);
                }
            }
            Drive::Tension(tension)
        }
        ((_, length), stiffness) => {
            Drive::Length { length, stiffness, damping: written.damping.unwrap_or(0.0) }
        }
    };
    Some(Tendon {
        name: written.name.clone(),
        path: path.into_iter().collect::<Option<_>>()?,
        drive,
        friction: written.friction.unwrap_or(0.0),
        friction_velocity: written.friction_velocity.unwrap_or(FRICTION_VELOCITY),
        sliding,
    })
}

fn chamber(
    written: &document::Chamber,
    here: &str,
    surroundings: Surroundings<'_>,
    shape: &mut Shape,
) -> Option<Chamber> {
    let mut path = Vec::new();
    for (i, written) in written.path.iter().enumerate() {
        let key = format!("{here}.path[{i}]");
        match part(written, &key, surroundings, shape) {
            Some(Part::Along(along)) => path.push(Some(along)),
            Some(Part::Via(_)) => {
                shape.refuse(&format!("{key}.point"), "a point", "remove it: a chamber is embedded in rods");
                path.push(None);
            }
            None => path.push(None),
        }
    }
    let pressure =
        written.pressure.as_ref().map(|written| parts::command(written, &format!("{here}.pressure"), shape));
    Some(Chamber {
        name: written.name.clone(),
        path: path.into_iter().collect::<Option<_>>()?,
        area: written.area,
        pressure: pressure.unwrap_or_default(),
    })
}

fn motor(
    written: &document::Motor,
    here: &str,
    surroundings: Surroundings<'_>,
    shape: &mut Shape,
) -> Option<Motor> {
    let command = one_of([("torque", &written.torque), ("position", &written.position)], here, shape);
    let key = format!("{here}.joint");
    let robot = surroundings.robot;
    let place = robot.motor_coordinate(&written.joint);
    if place.is_none() && !surroundings.are_incomplete && shape.is_readable(&key) {
        let known = robot.motor_places();
        let known: Vec<&str> = known.iter().map(String::as_str).collect();
        let right = match known.is_empty() {
            true => "remove it: no link has a joint that a motor can move".to_owned(),
            false => expected_name(&written.joint, &known, "joint"),
        };
        shape.refuse(&key, format!("no coordinate is called \"{}\"", written.joint), right);
    }
    let command = match (command?, written.gains) {
        ((0, torque), gains) => {
            if gains.is_some() {
                refuse_with("gains", here, "a torque: they belong to a motor of a given position", shape);
            }
            MotorCommand::Torque(torque)
        }
        ((_, position), Some([stiffness, damping])) => {
            MotorCommand::Position { position, stiffness, damping }
        }
        ((_, _), None) => {
            let key = format!("{here}.gains");
            if shape.is_readable(&key) {
                shape.refuse(
                    &key,
                    "missing",
                    "add gains = [stiffness, damping], by which it holds the position",
                );
            }
            return None;
        }
    };
    let (link, coordinate) = place?;
    let name = written.name.clone().unwrap_or_else(|| written.joint.clone());
    Some(Motor { name, link, coordinate, command, limits: written.limits })
}

fn active_strain(
    written: &document::ActiveStrain,
    here: &str,
    surroundings: Surroundings<'_>,
    shape: &mut Shape,
) -> Option<ActiveStrain> {
    let place = |key: &str| format!("{here}.{key}");
    let amount = written.amount.as_ref().map(|written| parts::command(written, &place("amount"), shape));
    let link = surroundings.link(written.link.as_deref(), &place("link"), shape)?;
    if !shape.is_readable(&place("strain")) {
        return None;
    }
    let length = surroundings.robot.links[link].length();
    let strain = match written.strain {
        Strain::Torsion => 0,
        Strain::BendY => 1,
        Strain::BendZ => 2,
        Strain::Stretch => 3,
        Strain::ShearY => 4,
        Strain::ShearZ => 5,
    };
    let along = |written| profile(written, [0.0, length], length, &place("shape"), shape);
    let default = match &written.link {
        Some(link) => format!("{link}.{}", STRAIN_NAMES[strain]),
        None => STRAIN_NAMES[strain].to_owned(),
    };
    Some(ActiveStrain {
        name: written.name.clone().unwrap_or(default),
        link,
        strain,
        shape: written.shape.as_ref().map_or_else(|| 1.0.into(), along),
        amount: amount.unwrap_or_default(),
    })
}

/// A part of a path; `None` after reporting a problem.
fn part(written: &PathPart, here: &str, surroundings: Surroundings<'_>, shape: &mut Shape) -> Option<Part> {
    let place = |key: &str| format!("{here}.{key}");
    let link_key = place("link");
    let name = written.link.as_deref();
    if let Some(point) = written.point {
        for (key, is_there) in [("offset", written.offset.is_some()), ("along", written.along.is_some())] {
            if is_there {
                let right = "keep the point, or what is embedded in a rod";
                shape.refuse(&place(key), format!("{key} with a point"), right);
            }
        }
        let is_of_world = name.is_none() && !surroundings.is_rod;
        let link = match is_of_world {
            true => None,
            false => Some(surroundings.link(name, &link_key, shape)?),
        };
        return Some(Part::Via(Via { link, point, at: written.at }));
    }
    if !shape.is_readable(&place("point")) {
        return None;
    }
    if written.at.is_some() {
        let right = "add its point, or write along = [from, to] for what is embedded in a rod";
        shape.refuse(&place("at"), "at without a point", right);
    }
    let link = surroundings.link(name, &link_key, shape)?;
    let length = surroundings.robot.links[link].length();
    let along = written.along.unwrap_or([0.0, length]);
    let offset = match &written.offset {
        None => [0.0.into(), 0.0.into()],
        Some([y, z]) => [(y, 0), (z, 1)]
            .map(|(written, i)| profile(written, along, length, &format!("{here}.offset[{i}]"), shape)),
    };
    Some(Part::Along(Along { link, offset, along }))
}

/// A number along a rod of this length; two numbers are the values at both ends.
fn profile(
    written: &AlongRod,
    [from, to]: [f64; 2],
    length: f64,
    place: &str,
    shape: &mut Shape,
) -> Profile<1> {
    let finite = |numbers: &[f64], shape: &mut Shape| {
        let bad = numbers.iter().find(|number| !number.is_finite());
        if let Some(bad) = bad {
            shape.refuse(place, format!("got {bad}"), "expected a finite number");
        }
        bad.is_none()
    };
    match written {
        AlongRod::Constant(number) if finite(&[*number], shape) => (*number).into(),
        AlongRod::Linear([start, end]) if finite(&[*start, *end], shape) => {
            if from == 0.0 && to == length {
                return Profile::linear([[*start], [*end]]);
            }
            let slope = (end - start) / (to - from);
            // Problems of the ends are reported separately.
            let slope = if slope.is_finite() { slope } else { 0.0 };
            Profile::linear([[start - slope * from], [start + slope * (length - from)]])
        }
        AlongRod::Table(AlongRodTable { stations, values }) if shape.is_readable(place) => {
            let values: Vec<[f64; 1]> = values.iter().map(|&value| [value]).collect();
            let table = Profile::table(stations, &values).and_then(|table| {
                table.validate(length)?;
                Ok(table)
            });
            report(table, shape, |problem| format!("{place}.{problem}")).unwrap_or(0.0.into())
        }
        _ => 0.0.into(),
    }
}
