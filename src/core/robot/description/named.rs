//! Resolves names of links and coordinates in descriptions to indices, and indices to names.

use std::cell::OnceCell;
use std::collections::HashMap;

use super::driven::Driven;
use super::link::{Link, described as links};
use super::robot::Robot;
use crate::description::schema::{
    Fault, LISTED, LinkName, Problem, Reader, compared, expected_name, or_meant, quoted,
};
use crate::error::InvalidInput;
use crate::robot::effects::actuator::described::PathPart;
use crate::robot::effects::actuator::{
    ActiveStrain, Actuator, Along, AlongRod, Chamber, Motor, Part, Tendon, Via, described,
};
use crate::robot::effects::contact::{Contact, described as contacts};
use crate::robot::effects::loops::described::{Loop as Looped, LoopKind, LoopPlace};
use crate::robot::effects::loops::{Loop, LoopEnd, Tie, described as loops};

/// Links that are found by their names.
#[derive(Debug)]
pub(crate) struct LinkNames<'a> {
    /// All names in the order of the robot.
    all: Vec<&'a str>,
    /// The first link of each name; validation rejects a second one.
    places: HashMap<&'a str, usize>,
    /// Whether there are further links that could not be read: unknown names may be theirs.
    are_incomplete: bool,
}

/// A robot with the names of its links, to resolve the names of many parts.
#[derive(Debug)]
pub(crate) struct Named<'a> {
    robot: &'a Robot,
    /// Whether the model is a rod, which is the default link of parts that name none.
    is_rod: bool,
    links: LinkNames<'a>,
    coordinates: OnceCell<HashMap<String, usize>>,
}

/// Names of the world in other programs.
const WORLDS: [&str; 3] = ["world", "ground", "earth"];

/// The problem of a name that is not among `names`, or of a missing name.
fn unknown(what: &'static str, name: Option<&str>, names: &[&str], expected: &str) -> Fault {
    let word = name.unwrap_or_default();
    let listed = || names.iter().map(|name| format!("'{name}'")).collect::<Vec<_>>().join(", ");
    let meant = or_meant(word, compared(names));
    let expected = match (expected, names.len() <= LISTED) {
        ("", true) => format!("one of the {what}s: {}{meant}", listed()),
        ("", false) => format!("the name of a {what} of the robot{meant}"),
        (expected, _) => format!("{expected}{meant}"),
    };
    let is_world = what == "link" && WORLDS.contains(&word);
    let [expected, in_scenes] = match is_world {
        true => [
            format!("{expected}; the world is no link: None in its place"),
            "leave it out: what is on no link is in the world".to_owned(),
        ],
        false => [expected, expected_name(word, names, what)],
    };
    let found = name.map_or_else(|| "none".to_owned(), |name| format!("'{name}'"));
    let wrong = name.map_or_else(
        || format!("no {what}, and there are several"),
        |name| format!("no {what} is called \"{name}\""),
    );
    Fault::Name { python: [found, expected], scene: [wrong, in_scenes] }
}

impl<'a> LinkNames<'a> {
    /// Names of links in their order; `are_incomplete` if further links could not be read.
    pub(crate) fn new(all: impl Iterator<Item = &'a str>, are_incomplete: bool) -> Self {
        let all: Vec<_> = all.collect();
        let mut places = HashMap::with_capacity(all.len());
        for (i, &name) in all.iter().enumerate() {
            places.entry(name).or_insert(i);
        }
        Self { all, places, are_incomplete }
    }

    /// The problem of a name that no link has, or of a missing name.
    fn unknown(&self, name: Option<&str>) -> Fault {
        unknown("link", name, &self.all, "")
    }

    /// Index of the link with this name; `None` after reporting a problem at the key.
    fn link(&self, key: &str, LinkName(name): &LinkName, reader: &mut Reader) -> Option<usize> {
        let found = self.places.get(name.as_str()).copied();
        if found.is_none() && !self.are_incomplete {
            reader.refuse(key, self.unknown(Some(name)));
        }
        found
    }

    /// Index of the parent of the link with this index; `None` after reporting a problem.
    fn parent(&self, link: usize, LinkName(name): &LinkName, reader: &mut Reader) -> Option<usize> {
        let found = self.places.get(name.as_str()).copied();
        let wrong = match found {
            Some(parent) if parent < link => return found,
            Some(parent) if parent == link => "a link cannot carry itself".to_owned(),
            Some(_) => format!("\"{name}\" stands behind the link that it carries"),
            None if self.are_incomplete => return None,
            None => format!("no link is called \"{name}\""),
        };
        let before = &self.all[..link];
        let right = match before.len() {
            0 => "remove it: the first link is attached to the world".to_owned(),
            1..=LISTED => format!("expected one of the links before: {}", quoted(before, ", ")),
            _ => expected_name(name, before, "link"),
        };
        let meant = if found.is_none() { or_meant(name, compared(before)) } else { String::new() };
        let is_world = found.is_none() && WORLDS.contains(&name.as_str());
        let world = if is_world { "; the world is no link: leave `parent` out" } else { "" };
        let expected = format!("the name of a link that stands before this one{meant}{world}");
        reader
            .refuse("parent", Fault::Name { python: [format!("'{name}'"), expected], scene: [wrong, right] });
        None
    }

    /// The link with this index of a robot; reports unknown links that it names.
    pub(crate) fn resolved(&self, link: usize, described: &links::Link, reader: &mut Reader) -> Link {
        let parent = described.parent.as_ref().and_then(|name| self.parent(link, name, reader));
        let driven = Driven::of(&described.joint, |name| {
            reader.at_key("joint", |reader| reader.at_key("mimic", |reader| self.link("link", name, reader)))
        });
        described.resolved(parent, driven)
    }
}

impl<'a> Named<'a> {
    /// The names of a robot, or of a rod, which is its only link; `are_incomplete` if further links could not be read.
    pub(crate) fn of(robot: &'a Robot, is_rod: bool, are_incomplete: bool) -> Self {
        Self {
            robot,
            is_rod,
            links: LinkNames::new(robot.links.iter().map(|link| link.name.as_str()), are_incomplete),
            coordinates: OnceCell::new(),
        }
    }

    /// Index of the coordinate with this name; `None` after reporting a problem at the key.
    fn coordinate(&self, key: &str, name: &str, reader: &mut Reader) -> Option<usize> {
        let coordinates = self.coordinates.get_or_init(|| {
            self.robot.coordinate_names().into_iter().enumerate().map(|(i, name)| (name, i)).collect()
        });
        let found = coordinates.get(name).copied();
        // The coordinates of an invalid robot are unknown.
        if found.is_none() && !self.links.are_incomplete && self.robot.validate().is_ok() {
            let names = self.robot.coordinate_names();
            let names: Vec<_> = names.iter().map(String::as_str).collect();
            reader.refuse(key, unknown("coordinate", Some(name), &names, ""));
        }
        found
    }

    /// Index of the link with this name; `None` after reporting a problem at the key.
    pub(crate) fn link(&self, key: &str, name: &LinkName, reader: &mut Reader) -> Option<usize> {
        self.links.link(key, name, reader)
    }

    /// Likewise; without a name the only link.
    pub(crate) fn only_link(&self, key: &str, name: Option<&LinkName>, reader: &mut Reader) -> Option<usize> {
        match name {
            Some(name) => self.link(key, name, reader),
            None if self.robot.links.len() == 1 && !self.links.are_incomplete => Some(0),
            None => {
                reader.refuse(key, self.links.unknown(None));
                None
            }
        }
    }

    fn length(&self, link: usize) -> f64 {
        self.robot.links[link].length()
    }

    /// The link and the joint coordinate that a motor moves; `None` after reporting a problem.
    fn motor(&self, joint: &str, reader: &mut Reader) -> Option<(usize, usize)> {
        let found = self.robot.motor_coordinate(joint);
        if found.is_none() && !self.links.are_incomplete {
            let (known, places) = (self.robot.motor_coordinates(), self.robot.motor_places());
            let places: Vec<_> = places.iter().map(String::as_str).collect();
            let fault = match known.is_empty() {
                true => Fault::Name {
                    python: [
                        format!("'{joint}'"),
                        "a coordinate of a joint, but no link has one that a motor can move".to_owned(),
                    ],
                    scene: [
                        format!("no coordinate is called \"{joint}\""),
                        "remove it: no link has a joint that a motor can move".to_owned(),
                    ],
                },
                false => {
                    let expected =
                        format!("a link with a joint of one coordinate, or one of {}", known.join(", "));
                    unknown("coordinate", Some(joint), &places, &expected)
                }
            };
            reader.refuse("joint", fault);
        }
        found
    }

    /// The actuator of the robot; `None` after reporting problems.
    pub(crate) fn actuator(&self, it: &described::Actuator, reader: &mut Reader) -> Option<Actuator> {
        Some(match it {
            described::Actuator::Tendon(tendon) => {
                let parts = tendon.path.iter().enumerate().map(|(i, part)| {
                    reader.at_key("path", |reader| reader.at_item(i, |reader| self.part(part, reader)))
                });
                let parts: Vec<_> = parts.collect();
                Actuator::Tendon(Tendon {
                    name: tendon.name.clone(),
                    path: parts.into_iter().collect::<Option<_>>()?,
                    drive: tendon.drive(),
                    friction: tendon.friction,
                    friction_velocity: tendon.friction_velocity,
                    sliding: tendon.sliding.clone(),
                })
            }
            described::Actuator::Chamber(chamber) => {
                let parts = chamber.path.iter().enumerate().map(|(i, along)| {
                    reader.at_key("path", |reader| reader.at_item(i, |reader| self.along(along, reader)))
                });
                let parts: Vec<_> = parts.collect();
                Actuator::Chamber(Chamber {
                    name: chamber.name.clone(),
                    path: parts.into_iter().collect::<Option<_>>()?,
                    area: chamber.area,
                    pressure: chamber.pressure.clone(),
                })
            }
            described::Actuator::Motor(motor) => {
                let (link, coordinate) = self.motor(&motor.joint, reader)?;
                Actuator::Motor(Motor {
                    name: motor.name.clone().unwrap_or_default(),
                    link,
                    coordinate,
                    command: motor.command(),
                    limits: motor.limits,
                })
            }
            described::Actuator::ActiveStrain(active) => {
                let link = self.only_link("link", active.link.as_ref(), reader)?;
                let length = self.length(link);
                let shape =
                    reader.at_key("shape", |reader| active.shape.resolved([0.0, length], length, reader))?;
                Actuator::ActiveStrain(ActiveStrain {
                    name: active.name.clone().unwrap_or_default(),
                    link,
                    strain: active.strain,
                    shape,
                    amount: active.amount.clone(),
                })
            }
        })
    }

    /// The loop of the robot; `None` after reporting problems.
    pub(crate) fn closed(&self, it: &Looped, reader: &mut Reader) -> Option<Loop> {
        let mut ends = [("a", &it.a), ("b", &it.b)].map(|(key, place)| match place {
            LoopPlace::Name(name) => (self.coordinate(key, name, reader), None),
            LoopPlace::End(end) => (None, self.end(key, end, reader)),
        });
        let [(first, a), (second, b)] = &mut ends;
        let tie = match (&it.kind, it.kind.joint()) {
            (LoopKind::Gear(gear), _) => {
                let coordinates = [(*first)?, (*second)?];
                Tie::Coordinates { coordinates, ratio: gear.ratio, offset: gear.offset }
            }
            (LoopKind::Distance(distance), _) => {
                Tie::Distance { ends: [a.take()?, b.take()?], length: distance.length }
            }
            (_, joint) => Tie::Joint { ends: [a.take()?, b.take()?], joint: joint?.resolved() },
        };
        Some(Loop { name: it.name.clone(), tie })
    }

    fn end(&self, key: &'static str, end: &loops::LoopEnd, reader: &mut Reader) -> Option<LoopEnd> {
        let link = match &end.link {
            Some(name) => Some(reader.at_key(key, |reader| self.link("link", name, reader))?),
            None => None,
        };
        Some(LoopEnd { link, at: end.at, position: end.position, orientation: end.orientation })
    }

    fn part(&self, part: &PathPart, reader: &mut Reader) -> Option<Part> {
        match part {
            PathPart::Along(along) => self.along(along, reader).map(Part::Along),
            PathPart::Via(described::Via { link, point, at }) => {
                let link = match link {
                    Some(name) => Some(self.link("link", name, reader)?),
                    None => self.is_rod.then_some(0),
                };
                Some(Part::Via(Via { link, point: *point, at: *at }))
            }
        }
    }

    fn along(&self, described: &described::Along, reader: &mut Reader) -> Option<Along> {
        let link = self.only_link("link", described.link.as_ref(), reader)?;
        let length = self.length(link);
        let along = described.along.unwrap_or([0.0, length]);
        let resolve = |i: usize, offset: &AlongRod, reader: &mut Reader| {
            reader.at_item(i, |reader| offset.resolved(along, length, reader))
        };
        let [y, z] = &described.offset;
        let [y, z] = reader.at_key("offset", |reader| [resolve(0, y, reader), resolve(1, z, reader)]);
        Some(Along { link, offset: [y?, z?], along })
    }
}

impl Robot {
    /// Index of the link with this name; of the only one if no name is given.
    ///
    /// # Errors
    /// No link has this name, or none is given and there are several; the problem is at this place.
    pub fn link_named(&self, name: Option<&str>, place: &str) -> Result<usize, InvalidInput> {
        let found = match name {
            None => (self.links.len() == 1).then_some(0),
            Some(name) => self.links.iter().position(|link| link.name == name),
        };
        found.ok_or_else(|| {
            let names = LinkNames::new(self.links.iter().map(|link| link.name.as_str()), false);
            let problem = Problem { place: place.to_owned(), fault: names.unknown(name) };
            InvalidInput { problems: vec![problem.into()] }
        })
    }

    /// The description of the joint of a link of this robot.
    fn described_joint(&self, link: &Link) -> crate::description::joint::described::Joint {
        match &link.driven {
            Some(driven) => driven.described(&link.joint, |link| self.name_and_length(link).0),
            None => link.joint.described(),
        }
    }

    /// The description of a link of this robot.
    pub(super) fn described_link(&self, link: &Link) -> links::Link {
        link.described(link.parent.map(|parent| self.name_and_length(parent).0), self.described_joint(link))
    }

    /// Name of a link, and its length; empty for no link.
    fn name_and_length(&self, link: usize) -> (LinkName, f64) {
        let empty = || (LinkName(String::new()), 0.0);
        self.links.get(link).map_or_else(empty, |link| (LinkName(link.name.clone()), link.length()))
    }

    /// The descriptions of the loops of this robot.
    pub(crate) fn described_loops(&self) -> impl Iterator<Item = Looped> {
        let names = OnceCell::new();
        self.loops.iter().map(move |closed| {
            let coordinate = |k: usize| {
                let names: &Vec<String> = names.get_or_init(|| self.coordinate_names());
                names.get(k).cloned().unwrap_or_default()
            };
            closed.described(&|link| self.name_and_length(link).0, &coordinate)
        })
    }

    /// The description of a contact of this robot.
    pub(super) fn described_contact(&self, contact: &Contact) -> contacts::Contact {
        contact.described(&|link| self.name_and_length(link).0)
    }

    /// The description of an actuator of this robot.
    pub(crate) fn described_actuator(&self, actuator: &Actuator) -> described::Actuator {
        actuator.described(&|link| self.name_and_length(link), |link, k| {
            let of = |link: &Link| Some(format!("{}.{}", link.name, link.joint.coordinates().get(k)?));
            self.links.get(link).and_then(of).unwrap_or_default()
        })
    }
}
