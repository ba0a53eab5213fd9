//! Closed loops from their tables.

use super::document::{
    self, Document, Jacobian, LoopEnd as WrittenEnd, LoopKind, LoopPlace, LoopType, Simulation as Settings,
};
use super::shape::Shape;
use crate::description::expected_name;
use crate::joint::Joint;
use crate::loops::{Loop, LoopEnd, Tie};
use crate::robot::{Robot, number_default_names};

/// Name of the world within the names of loops.
const WORLD: &str = "the world";

/// Stand-in for directions and lengths that could not be read, so that the rest can be checked.
const STAND_IN: [f64; 3] = [1.0, 0.0, 0.0];
const OTHER_STAND_IN: [f64; 3] = [0.0, 1.0, 0.0];
const LENGTH_STAND_IN: f64 = 1.0;

/// Loops of a scene with their indices in the file. Omits loops between unknown places.
pub(super) fn loops(
    document: &Document,
    robot: &Robot,
    are_incomplete: bool,
    shape: &mut Shape,
) -> (Vec<Loop>, Vec<usize>) {
    // The number of coordinates of an invalid robot is unknown.
    let has_coordinates = !are_incomplete && robot.validate().is_ok();
    let known = Known {
        links: robot.links.iter().map(|link| link.name.clone()).collect(),
        coordinates: has_coordinates.then(|| robot.coordinate_names()),
        are_incomplete,
    };
    let mut found = Vec::new();
    for (i, written) in document.r#loop.iter().enumerate() {
        found.extend(one(written, &format!("loop[{i}]"), &known, shape).map(|closed| (closed, i)));
    }
    let is_default = |i: usize| document.r#loop[i].name.is_none();
    number_default_names(found.iter_mut().map(|(closed, i)| (&mut closed.name, is_default(*i))));
    found.into_iter().unzip()
}

/// Reports a Jacobian option that does not support closed loops.
pub(super) fn check_jacobian(document: &Document, shape: &mut Shape) {
    if document.r#loop.is_empty() {
        return;
    }
    let Settings { jac, .. } = &document.simulation;
    if *jac != Jacobian::Analytic && shape.is_readable("simulation.jac") {
        let right = "expected \"analytic\" (the default): that of the constraints is exact";
        shape.refuse("simulation.jac", "differences do not see closed loops", right);
    }
}

/// Key in the file for a place in the loops of a robot, which have these indices in the file.
pub(super) fn key_of_loop(place: &str, written: &[document::Loop], places: &[usize]) -> Option<String> {
    let (i, rest) = place.strip_prefix("loops[")?.split_once(']')?;
    let i = *places.get(i.parse::<usize>().ok()?)?;
    let is_named = written.get(i)?.name.is_some();
    let rest = match rest {
        ".kind.coordinates" | ".kind.coordinates[1]" => ".b",
        ".kind.coordinates[0]" => ".a",
        ".name" if !is_named => "",
        rest => rest,
    };
    Some(format!("loop[{i}]{rest}"))
}

/// The model to which ends belong.
struct Known {
    links: Vec<String>,
    /// Whether there are further links that could not be read.
    are_incomplete: bool,
    /// Names of the coordinates; `None` if they cannot be determined.
    coordinates: Option<Vec<String>>,
}

impl Known {
    /// The link with this name; `None` after reporting a problem.
    fn link(&self, name: &str, key: &str, shape: &mut Shape) -> Option<usize> {
        let found = place(&self.links, name);
        if found.is_none() && !self.are_incomplete && shape.is_readable(key) {
            let wrong = format!("no link is called \"{name}\"");
            shape.refuse(key, wrong, expected_name(name, &texts(&self.links), "link"));
        }
        found
    }

    /// The coordinate with this name; `None` if it is unknown.
    fn coordinate(&self, name: &str, key: &str, shape: &mut Shape) -> Option<usize> {
        let names = self.coordinates.as_ref()?;
        let found = place(names, name);
        if found.is_none() && shape.is_readable(key) {
            let wrong = format!("no coordinate is called \"{name}\"");
            shape.refuse(key, wrong, expected_name(name, &texts(names), "coordinate"));
        }
        found
    }
}

fn texts(names: &[String]) -> Vec<&str> {
    names.iter().map(String::as_str).collect()
}

pub(super) fn place(names: &[String], name: &str) -> Option<usize> {
    names.iter().position(|known| known == name)
}

fn one(written: &document::Loop, here: &str, known: &Known, shape: &mut Shape) -> Option<Loop> {
    check_keys(&written.kind, here, shape);
    let kind = &written.kind;
    let axis = kind.axis.unwrap_or(STAND_IN);
    let joint = match kind.r#type {
        LoopType::Gear => {
            let coordinates = [("a", &written.a), ("b", &written.b)]
                .map(|(key, end)| coordinate(end.as_ref(), &format!("{here}.{key}"), known, shape));
            let [(a, first), (b, second)] = coordinates.map(|(name, place)| (name.unwrap_or(""), place));
            let name = written.name.clone().unwrap_or_else(|| format!("{a} to {b}"));
            let (ratio, offset) = (kind.ratio.unwrap_or(1.0), kind.offset.unwrap_or(0.0));
            return Some(Loop {
                name,
                tie: Tie::Coordinates { coordinates: [first?, second?], ratio, offset },
            });
        }
        LoopType::Distance => None,
        LoopType::Weld => Some(Joint::Weld),
        LoopType::Revolute => Some(Joint::Revolute { axis, forces: Default::default() }),
        LoopType::Prismatic => Some(Joint::Prismatic { axis, forces: Default::default() }),
        LoopType::Cylindrical => Some(Joint::Cylindrical { axis }),
        LoopType::Universal => {
            let axes = [kind.axis1.unwrap_or(STAND_IN), kind.axis2.unwrap_or(OTHER_STAND_IN)];
            Some(Joint::Universal { axes })
        }
        LoopType::Planar => Some(Joint::Planar { normal: kind.normal.unwrap_or(STAND_IN) }),
        LoopType::Spherical => Some(Joint::Spherical),
    };
    let [a, b] = [("a", &written.a), ("b", &written.b)]
        .map(|(key, written)| end(written.as_ref(), &format!("{here}.{key}"), known, shape));
    if ["a", "b"].iter().any(|key| !shape.is_readable(&format!("{here}.{key}"))) {
        return None;
    }
    let ends = [a?, b?];
    let name_of = |end: &LoopEnd| end.link.map_or(WORLD, |link| &known.links[link]);
    let name =
        written.name.clone().unwrap_or_else(|| format!("{} to {}", name_of(&ends[0]), name_of(&ends[1])));
    let tie = match joint {
        Some(joint) => Tie::Joint { ends, joint },
        None => Tie::Distance { ends, length: kind.length.unwrap_or(LENGTH_STAND_IN) },
    };
    Some(Loop { name, tie })
}

/// Reports unknown keys of a kind of loop, and missing ones.
fn check_keys(kind: &LoopKind, here: &str, shape: &mut Shape) {
    let here = format!("{here}.kind");
    if !shape.is_readable(&format!("{here}.type")) {
        return;
    }
    // Required keys, then optional ones.
    let (needed, other): (&[&str], &[&str]) = match kind.r#type {
        LoopType::Weld | LoopType::Spherical => (&[], &[]),
        LoopType::Revolute | LoopType::Prismatic | LoopType::Cylindrical => (&["axis"], &[]),
        LoopType::Universal => (&["axis1", "axis2"], &[]),
        LoopType::Planar => (&["normal"], &[]),
        LoopType::Distance => (&["length"], &[]),
        LoopType::Gear => (&[], &["ratio", "offset"]),
    };
    let given = [
        ("axis", kind.axis.is_some()),
        ("axis1", kind.axis1.is_some()),
        ("axis2", kind.axis2.is_some()),
        ("normal", kind.normal.is_some()),
        ("length", kind.length.is_some()),
        ("ratio", kind.ratio.is_some()),
        ("offset", kind.offset.is_some()),
    ];
    for (key, is_given) in given {
        let place = format!("{here}.{key}");
        let (is_needed, is_other) = (needed.contains(&key), other.contains(&key));
        if is_given && !is_needed && !is_other {
            let taken: Vec<&str> = needed.iter().chain(other).copied().collect();
            let right = match taken.is_empty() {
                true => "remove it: it takes nothing but its type".to_owned(),
                false => format!("remove it: it takes {}", taken.join(" and ")),
            };
            shape.refuse(
                &place,
                format!("a loop of type \"{}\" does not take it", kind.r#type.name()),
                right,
            );
        } else if !is_given && is_needed && shape.is_readable(&place) {
            let right = match key {
                "length" => "add length, the distance of the ends in metres".to_owned(),
                _ => format!("add {key}, a direction such as [0, 1, 0]"),
            };
            shape.refuse(&here, format!("{key} is missing"), right);
            shape.replaced.insert(place);
        }
    }
}

/// A coordinate of a gear: its name, and its index if known.
fn coordinate<'a>(
    written: Option<&'a LoopPlace>,
    here: &str,
    known: &Known,
    shape: &mut Shape,
) -> (Option<&'a str>, Option<usize>) {
    match written {
        Some(LoopPlace::Name(name)) => (Some(name), known.coordinate(name, here, shape)),
        found => {
            if shape.is_readable(here) {
                let wrong = match found {
                    Some(_) => "a place on a link, but a gear ties coordinates",
                    None => "missing, but a gear ties two coordinates",
                };
                let names = known.coordinates.as_deref().unwrap_or_default();
                let right = match names.first() {
                    None => "expected the name of a coordinate".to_owned(),
                    Some(_) => expected_name("", &texts(names), "coordinate"),
                };
                shape.refuse(here, wrong, right);
            }
            (None, None)
        }
    }
}

/// An end; `None` after reporting a problem.
fn end(written: Option<&LoopPlace>, here: &str, known: &Known, shape: &mut Shape) -> Option<LoopEnd> {
    match written {
        None => Some(LoopEnd::in_world([0.0; 3])),
        Some(LoopPlace::Name(name)) => known.link(name, here, shape).map(LoopEnd::on),
        Some(LoopPlace::End(WrittenEnd { link, at, position, orientation })) => {
            let link = match link {
                None => None,
                Some(name) => Some(known.link(name, &format!("{here}.link"), shape)?),
            };
            Some(LoopEnd { link, at: *at, position: *position, orientation: *orientation })
        }
    }
}
