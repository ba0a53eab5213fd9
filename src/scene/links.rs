//! Links of a robot from their tables.

use std::collections::HashMap;

use super::actuators::actuators;
use super::contacts::{contacts, key_of_contact};
use super::described::{Written, key_of_item, made, read, read_all};
use super::document::{
    Document, Import, Joint, JointKind, JointMotion, Link, Mimic, Segment, Simulation as Settings,
};
use super::imports::{Imported, Imports, Refusal, Request};
use super::loops::{self, key_of_loop};
use super::parts;
use super::shape::{Shape, report};
use crate::body::{self, described::Body};
use crate::description::{Data as _, LISTED, Limits, expected_name, quoted};
use crate::error::Checker;
use crate::joint::{self as joints, JointForces};
use crate::robot::{self, Driven, Named, Robot};
use crate::signal::Keys;
use crate::world::described::BaseMotion;

/// The imported links; `None` after reporting a problem.
pub(super) fn import(written: &Import, imports: &mut dyn Imports, shape: &mut Shape) -> Option<Imported> {
    if !shape.is_readable("import") {
        return None;
    }
    let request = Request {
        file: written.urdf.clone(),
        floating: written.floating,
        limit_stiffness: written.limit_stiffness,
        mend_inertia: written.mend_inertia,
    };
    match imports.read(&request) {
        Ok(imported) => return Some(imported),
        Err(Refusal::Unreadable(why)) => {
            shape.refuse("import.urdf", why, "expected a URDF file, seen from the folder of the scene");
        }
        Err(Refusal::Wrong(problems)) => {
            for problem in problems {
                shape.refuse_file("import.urdf", problem);
            }
        }
    }
    None
}

/// Names of the links of a scene.
struct Names<'a> {
    /// All names in the order of the robot: imported links precede the others.
    all: Vec<&'a str>,
    /// Number of imported links.
    imported: usize,
    /// The first link of each name.
    places: HashMap<&'a str, usize>,
    /// Whether there are further links that could not be read.
    are_incomplete: bool,
}

impl<'a> Names<'a> {
    fn new(document: &'a Document, imported: Option<&'a Imported>) -> Self {
        let of_file = imported.iter().flat_map(|imported| &imported.links);
        let mut all: Vec<_> = of_file.map(|link| link.name.as_str()).collect();
        let imported_links = all.len();
        all.extend(document.link.iter().map(|link| link.name.as_str()));
        let places = all.iter().enumerate().rev().map(|(place, &name)| (name, place)).collect();
        let are_incomplete = document.import.is_some() && imported.is_none();
        Self { all, imported: imported_links, places, are_incomplete }
    }

    fn place(&self, name: &str) -> Option<usize> {
        self.places.get(name).copied()
    }
}

/// The robot from the tables of its links, which follow the imported ones, and its initial coordinates and
/// velocities.
pub(super) fn robot(
    document: &Document,
    imported: Option<&Imported>,
    shape: &mut Shape,
) -> Option<(Robot, [Vec<f64>; 2])> {
    let written = &document.link;
    let names = Names::new(document, imported);
    let before = names.imported;
    let of_file = imported.map_or(&[][..], |imported| &imported.links);
    let mut links = of_file.to_vec();
    for (i, written) in written.iter().enumerate() {
        links.push(link(document, &names, i, written, shape));
    }
    // Loads and supports are tables of their links: collect their keys in the file.
    let (mut loads, mut load_keys) = (Vec::new(), Vec::new());
    let (mut supports, mut support_keys) = (Vec::new(), Vec::new());
    for (i, link) in written.iter().enumerate() {
        let (of_link, keys) = read_all(&link.load, &format!("link[{i}].load"), shape);
        loads.extend(of_link.iter().map(|load| load.resolved(before + i)));
        load_keys.extend(keys);
        let (of_link, keys) = read_all(&link.support, &format!("link[{i}].support"), shape);
        supports.extend(of_link.iter().map(|support| support.resolved(before + i)));
        support_keys.extend(keys);
    }
    let moving = document.base_motion.as_ref();
    let robot = Robot {
        base_motion: moving
            .map(|written| parts::base_motion(written, "base_motion", &document.simulation, shape)),
        loads,
        supports,
        fluid: document.fluid.as_ref().and_then(|fluid| read(fluid, "fluid", shape)),
        ..Robot::new(links)
    };
    let mut robot = Robot { gravity: document.scene.gravity.unwrap_or(robot.gravity), ..robot };
    let named = Named::incomplete(&robot, names.are_incomplete);
    let (actuators, actuator_keys) = actuators(document, &named, shape);
    robot.actuators = actuators;
    let (closed, loop_places) = loops::loops(document, &robot, names.are_incomplete, shape);
    robot.loops = closed;
    loops::check_jacobian(document, shape);
    let (touching, contact_places) =
        contacts(document, &Named::incomplete(&robot, names.are_incomplete), shape);
    robot.contacts = touching;
    let key = |place: &str| {
        let known = key_of_loop(place, &document.r#loop, &loop_places);
        let known = known.or_else(|| key_of_contact(place, &document.contact, &contact_places));
        let lists: [(_, &[_]); 3] =
            [("loads", &load_keys), ("supports", &support_keys), ("actuators", &actuator_keys)];
        let known = known.or_else(|| key_of_item(place, &lists));
        known.unwrap_or_else(|| key_of(&key_of_link(place, before), written))
    };
    if names.are_incomplete {
        // Their connections are unknown; check each link separately.
        for (i, link) in robot.links.iter().enumerate() {
            report(link.validate(), shape, |place| key(&format!("links[{i}].{place}")));
        }
        return None;
    }
    let valid = report(robot.validate(), shape, key).is_some();
    if !valid || !shape.is_readable("link") {
        return None;
    }
    if robot.coordinates() == 0 {
        let right = "give a link a joint, such as joint = { type = \"free\" }, or a rod with modes";
        shape.refuse("link", "no coordinates, so nothing can move", right);
    }
    let state = ["q0", "v0"].map(|key| state(document, &robot, before, key, shape));
    Some((robot, state))
}

/// Initial coordinates or velocities: one table per link, and one for all imported links together.
fn state(document: &Document, robot: &Robot, before: usize, key: &str, shape: &mut Shape) -> Vec<f64> {
    let has_open_modes = !parts::open_modes(document).is_empty();
    let mut state = Vec::with_capacity(robot.coordinates());
    if let Some(import) = &document.import {
        let of_file = Robot::new(robot.links[..before].to_vec());
        let n = of_file.coordinates();
        let given = if key == "q0" { &import.q0 } else { &import.v0 };
        let values = given.clone().unwrap_or_else(|| vec![0.0; n]);
        let mut check = Checker::new();
        let wanted = format!("{n} values: {}", of_file.coordinate_names().join(", "));
        check.require(values.len() == n, key, format_args!("{} values", values.len()), &wanted);
        check.finite(&values, key);
        report(check.finish(), shape, |place| format!("import.{place}"));
        state.extend(values);
    }
    for (i, (written, link)) in document.link.iter().zip(&robot.links[before..]).enumerate() {
        let n = link.coordinates();
        let given = if key == "q0" { &written.q0 } else { &written.v0 };
        let values = given.clone().unwrap_or_else(|| vec![0.0; n]);
        let mut check = Checker::new();
        if !has_open_modes {
            let wanted = format!("{n} values: {}", link.coordinate_names().join(", "));
            check.require(values.len() == n, key, format_args!("{} values", values.len()), &wanted);
        }
        check.finite(&values, key);
        report(check.finish(), shape, |place| format!("link[{i}].{place}"));
        state.extend(values);
    }
    state
}

fn link(document: &Document, names: &Names<'_>, i: usize, written: &Link, shape: &mut Shape) -> robot::Link {
    let here = format!("link[{i}]");
    let place = names.imported + i;
    let parent = written.parent.as_ref().and_then(|name| {
        let found = names.place(name);
        let is_known = found.is_some() || !names.are_incomplete;
        if found.is_none_or(|parent| parent >= place) && is_known {
            let before = &names.all[..place];
            let wrong = match found {
                None => format!("no link is called \"{name}\""),
                Some(parent) if parent == place => "a link cannot carry itself".to_owned(),
                Some(_) => format!("\"{name}\" stands behind the link that it carries"),
            };
            let right = match before.len() {
                0 => "remove it: the first link hangs on the world".to_owned(),
                1..=LISTED => format!("expected one of the links before: {}", quoted(before, ", ")),
                _ => expected_name(name, before, "link"),
            };
            shape.refuse(&format!("{here}.parent"), wrong, right);
        }
        found.filter(|&parent| parent < place)
    });
    let segments = written.rod.iter().flat_map(|rod| &rod.segment).enumerate();
    let rod = segments
        .map(|(j, segment)| parts::segment(segment, &format!("{here}.rod.segment[{j}]"), shape))
        .collect();
    robot::Link {
        parent,
        // Without a known parent, the place on it cannot be checked.
        at: written.at.filter(|_| parent.is_some() || written.parent.is_none()),
        position: written.position,
        orientation: written.orientation,
        joint: written
            .joint
            .as_ref()
            .map_or(joints::Joint::Weld, |written| joint(written, &format!("{here}.joint"), shape)),
        driven: written
            .joint
            .as_ref()
            .and_then(|written| driven(document, names, written, &format!("{here}.joint"), shape)),
        rod,
        body: written.body.as_ref().and_then(|body| body_of(body, &format!("{here}.body"), shape)),
        ..robot::Link::new(&written.name)
    }
}

/// The body of a link, at the place of its table.
fn body_of(written: &Written<Body>, here: &str, shape: &mut Shape) -> Option<body::Body> {
    let body = read(written, here, shape)?;
    if body.at.is_some() {
        let right = "remove it: the body of a link is in the origin of its axes";
        shape.refuse(&format!("{here}.at"), "the body of a link does not take it", right);
    }
    Some(body.resolved(0))
}

/// The joint written at `here`; a valid stand-in after reporting a problem.
fn joint(written: &Joint, here: &str, shape: &mut Shape) -> joints::Joint {
    const STAND_IN: [f64; 3] = [1.0, 0.0, 0.0];
    const OTHER_STAND_IN: [f64; 3] = [0.0, 1.0, 0.0];
    let kind = written.r#type;
    let (directions, has_forces): (&[&str], bool) = match kind {
        JointKind::Weld | JointKind::Spherical | JointKind::Free => (&[], false),
        JointKind::Revolute | JointKind::Prismatic => (&["axis"], true),
        JointKind::Cylindrical => (&["axis"], false),
        JointKind::Universal => (&["axis1", "axis2"], false),
        JointKind::Planar => (&["normal"], false),
    };
    let given = [
        ("axis", written.axis),
        ("axis1", written.axis1),
        ("axis2", written.axis2),
        ("normal", written.normal),
    ];
    for (key, value) in given {
        let place = format!("{here}.{key}");
        let is_wanted = directions.contains(&key);
        if value.is_some() && !is_wanted {
            shape.refuse(&place, format!("a {} joint does not take it", kind.name()), "remove it");
        } else if value.is_none() && is_wanted && shape.is_readable(&place) {
            shape.refuse(
                here,
                format!("{key} is missing"),
                format!("add {key}, a direction such as [0, 1, 0]"),
            );
            shape.replaced.insert(place);
        }
    }
    let numbers = [
        ("stiffness", written.stiffness),
        ("rest", written.rest),
        ("damping", written.damping),
        ("friction", written.friction),
        ("friction_velocity", written.friction_velocity),
        ("limit_stiffness", written.limit_stiffness),
        ("limit_dissipation", written.limit_dissipation),
        ("armature", written.armature),
    ];
    let limits = ("limits", written.limits.map(|[lower, _]| lower));
    for (key, value) in numbers.into_iter().chain([limits]) {
        if value.is_some() && !has_forces {
            let wrong = format!("a {} joint does not take it", kind.name());
            shape.refuse(&format!("{here}.{key}"), wrong, "remove it: revolute and prismatic joints do");
        }
    }
    let default = JointForces::default();
    let [stiffness, rest, damping, friction, friction_velocity, limit_stiffness, limit_dissipation, armature] =
        numbers.map(|(_, value)| value);
    let forces = JointForces {
        stiffness: stiffness.unwrap_or(default.stiffness),
        rest: rest.unwrap_or(default.rest),
        damping: damping.unwrap_or(default.damping),
        friction: friction.unwrap_or(default.friction),
        friction_velocity: friction_velocity.unwrap_or(default.friction_velocity),
        limits: written.limits,
        limit_stiffness: limit_stiffness.unwrap_or(default.limit_stiffness),
        limit_dissipation: limit_dissipation.unwrap_or(default.limit_dissipation),
        armature: armature.unwrap_or(default.armature),
    };
    let axis = written.axis.unwrap_or(STAND_IN);
    match kind {
        JointKind::Weld => joints::Joint::Weld,
        JointKind::Revolute => joints::Joint::Revolute { axis, forces },
        JointKind::Prismatic => joints::Joint::Prismatic { axis, forces },
        JointKind::Cylindrical => joints::Joint::Cylindrical { axis },
        JointKind::Universal => {
            let axes = [written.axis1.unwrap_or(STAND_IN), written.axis2.unwrap_or(OTHER_STAND_IN)];
            joints::Joint::Universal { axes }
        }
        JointKind::Planar => joints::Joint::Planar { normal: written.normal.unwrap_or(STAND_IN) },
        JointKind::Spherical => joints::Joint::Spherical,
        JointKind::Free => joints::Joint::Free,
    }
}

/// Source of a driven joint written at `here`.
fn driven(
    document: &Document,
    names: &Names<'_>,
    written: &Joint,
    here: &str,
    shape: &mut Shape,
) -> Option<Driven> {
    let [motion_key, mimic_key] = ["motion", "mimic"].map(|key| format!("{here}.{key}"));
    let has_one = matches!(written.r#type, JointKind::Revolute | JointKind::Prismatic);
    let is_free = written.r#type == JointKind::Free;
    let kind = written.r#type.name();
    if written.motion.is_some() && !has_one && !is_free {
        let right = "remove it: revolute, prismatic and free joints do";
        shape.refuse(&motion_key, format!("a {kind} joint does not take it"), right);
        return None;
    }
    if written.mimic.is_some() && !has_one {
        let right = "remove it: revolute and prismatic joints do";
        shape.refuse(&mimic_key, format!("a {kind} joint does not take it"), right);
        return None;
    }
    if written.motion.is_some() && written.mimic.is_some() {
        shape.refuse(&mimic_key, "both motion and mimic are given", "keep one of them");
        return None;
    }
    if let Some(Mimic { link, multiplier, offset }) = &written.mimic {
        let found = names.place(link);
        let is_unknown = found.is_none() && !names.are_incomplete;
        if is_unknown && shape.is_readable(&format!("{mimic_key}.link")) {
            let right = expected_name(link, &names.all, "link");
            shape.refuse(&format!("{mimic_key}.link"), format!("no link is called \"{link}\""), right);
        }
        let (multiplier, offset) = (multiplier.unwrap_or(1.0), offset.unwrap_or(0.0));
        return Some(Driven::Mimic { link: found?, multiplier, offset });
    }
    let motion = written.motion.as_ref()?;
    let problems = shape.problems.len();
    let driven = match is_free {
        true => Driven::Base(motion_of_link(motion, &motion_key, &document.simulation, shape)),
        false => motion_of_coordinate(motion, &motion_key, &document.simulation, shape),
    };
    (problems == shape.problems.len()).then_some(driven)
}

/// Prescribed motion of a joint with one coordinate.
fn motion_of_coordinate(written: &JointMotion, here: &str, settings: &Settings, shape: &mut Shape) -> Driven {
    let JointMotion { times, values, interpolation, amplitude, frequency, phase, mean, rate, .. } =
        written.clone();
    let others = [
        ("translation", written.translation.is_some()),
        ("axis", written.axis.is_some()),
        ("angle", written.angle.is_some()),
        ("rotation", written.rotation.is_some()),
    ];
    for (key, _) in others.into_iter().filter(|(_, is_given)| *is_given) {
        let right = "remove it: its coordinate is a number, with times and values or a formula";
        shape.refuse(&format!("{here}.{key}"), "it belongs to the motion of a free joint", right);
    }
    let problems = shape.problems.len();
    let interpolation = interpolation.and_then(|word| read(&word, &format!("{here}.interpolation"), shape));
    let [amplitude, mean, rate] = [amplitude, mean, rate].map(|number| number.map(|x| [x]));
    let values = values.map(|values| values.into_iter().map(|x| [x]).collect());
    let formula = Keys { amplitude, frequency, phase, mean, rate, ..Keys::NONE };
    let keys = Keys { times, values, interpolation, ..formula };
    let driven = Driven::Coordinate(made(here, shape, |reader| keys.signal(reader)).unwrap_or_default());
    if problems == shape.problems.len() {
        parts::check_span(driven.span(), here, settings, shape);
    }
    driven
}

/// Prescribed motion of a link with a free joint.
fn motion_of_link(
    written: &JointMotion,
    here: &str,
    settings: &Settings,
    shape: &mut Shape,
) -> crate::world::BaseMotion {
    let others = [
        ("times", written.times.is_some()),
        ("values", written.values.is_some()),
        ("interpolation", written.interpolation.is_some()),
        ("amplitude", written.amplitude.is_some()),
        ("frequency", written.frequency.is_some()),
        ("phase", written.phase.is_some()),
        ("mean", written.mean.is_some()),
        ("rate", written.rate.is_some()),
    ];
    for (key, _) in others.into_iter().filter(|(_, is_given)| *is_given) {
        let right = "write it in translation, or in angle with an axis";
        shape.refuse(&format!("{here}.{key}"), "a free joint has more than one coordinate", right);
    }
    let problems = shape.problems.len();
    let JointMotion { translation, axis, angle, rotation, .. } = written;
    let place = |key: &str| format!("{here}.{key}");
    let motion = BaseMotion {
        translation: translation
            .as_ref()
            .and_then(|written| read(written, &place("translation"), shape))
            .unwrap_or_default(),
        axis: *axis,
        angle: angle.as_ref().and_then(|written| read(written, &place("angle"), shape)),
        rotation: rotation.as_ref().and_then(|written| read(written, &place("rotation"), shape)),
    };
    if shape.is_readable(here) && problems == shape.problems.len() {
        made(here, shape, |reader| {
            motion.check(&Limits::NONE, reader);
            Some(())
        });
    }
    let motion = motion.resolved();
    if problems == shape.problems.len() {
        parts::check_span(motion.span(), here, settings, shape);
    }
    motion
}

/// Key in the file for a link of a [`Robot`], or for a place in it, if `before` links are imported.
pub(super) fn key_of_link(place: &str, before: usize) -> String {
    let Some((i, rest)) = place.strip_prefix("links[").and_then(|rest| rest.split_once(']')) else {
        return place.to_owned();
    };
    match i.parse::<usize>().ok().map(|i| i.checked_sub(before)) {
        Some(Some(i)) => format!("link[{i}]{rest}"),
        Some(None) => "import".to_owned(),
        None => place.to_owned(),
    }
}

/// Key in the file for any place in a [`Robot`], with links numbered as in the file.
fn key_of(place: &str, written: &[Link]) -> String {
    if place.starts_with("gravity") {
        return format!("scene.{place}");
    }
    let key = place.replace(".rod[", ".rod.segment[");
    if key == "links" {
        return "link".to_owned();
    }
    match key.split_once(".rod.segment[").and_then(|(link, rest)| Some((link, rest.split_once("].")?))) {
        Some((link, (j, of_segment))) => {
            let written = segment_of(written, link, j);
            let of_segment =
                written.map_or(of_segment.to_owned(), |written| parts::segment_key(of_segment, written));
            format!("{link}.rod.segment[{j}].{of_segment}")
        }
        None => key,
    }
}

fn segment_of<'a>(written: &'a [Link], link: &str, segment: &str) -> Option<&'a Segment> {
    let link: usize = link.strip_prefix("link[")?.strip_suffix(']')?.parse().ok()?;
    written.get(link)?.rod.as_ref()?.segment.get(segment.parse::<usize>().ok()?)
}
