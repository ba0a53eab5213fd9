//! Links of a robot from their tables.

use std::collections::HashMap;

use super::actuators::actuators;
use super::contacts::{contacts, key_of_contact};
use super::described::{Written, key_of_item, read, read_all};
use super::document::{Document, Import, Link};
use super::imports::{Imported, Imports, Refusal, Request};
use super::loops;
use super::parts;
use super::shape::{Shape, report};
use crate::body::{self, described::Body};
use crate::description::{LISTED, LinkName, expected_name, quoted};
use crate::error::Checker;
use crate::joint::{self as joints, JointForces, described::Joint};
use crate::robot::{self, Driven, Named, Robot};

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
    // Loads, supports and further bodies are tables of their links: collect their keys in the file.
    let (mut loads, mut load_keys) = (Vec::new(), Vec::new());
    let (mut supports, mut support_keys) = (Vec::new(), Vec::new());
    let (mut bodies, mut body_keys) = (Vec::new(), Vec::new());
    for (i, link) in written.iter().enumerate() {
        let (of_link, keys) = read_all(&link.load, &format!("link[{i}].load"), shape);
        loads.extend(of_link.iter().map(|load| load.resolved(before + i)));
        load_keys.extend(keys);
        let (of_link, keys) = read_all(&link.fixed_body, &format!("link[{i}].fixed_body"), shape);
        bodies.extend(of_link.iter().map(|body| body.resolved(before + i)));
        body_keys.extend(keys);
        let (of_link, keys) = read_all(&link.support, &format!("link[{i}].support"), shape);
        supports.extend(of_link.iter().map(|support| support.resolved(before + i)));
        support_keys.extend(keys);
    }
    let moving = document.base_motion.as_ref();
    let robot = Robot {
        base_motion: moving
            .map(|written| parts::base_motion(written, "base_motion", &document.simulation, shape)),
        loads,
        bodies,
        supports,
        fluid: document.fluid.as_ref().and_then(|fluid| read(fluid, "fluid", shape)),
        ..Robot::new(links)
    };
    let mut robot = Robot { gravity: document.scene.gravity.unwrap_or(robot.gravity), ..robot };
    let named = Named::incomplete(&robot, names.are_incomplete);
    let (actuators, actuator_keys) = actuators(document, &named, shape);
    robot.actuators = actuators;
    let (closed, loop_keys) = loops::loops(document, &robot, names.are_incomplete, shape);
    robot.loops = closed;
    loops::check_jacobian(document, shape);
    let (touching, contact_places) =
        contacts(document, &Named::incomplete(&robot, names.are_incomplete), shape);
    robot.contacts = touching;
    let key = |place: &str| {
        let known = key_of_contact(place, &document.contact, &contact_places);
        let lists: [(_, &[_]); 5] = [
            ("loads", &load_keys),
            ("bodies", &body_keys),
            ("supports", &support_keys),
            ("actuators", &actuator_keys),
            ("loops", &loop_keys),
        ];
        let known = known.or_else(|| key_of_item(place, &lists));
        known.unwrap_or_else(|| key_of(&key_of_link(place, before)))
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
    let joint = written.joint.as_ref();
    let joint = joint.map(|written| joint_of(document, names, written, &format!("{here}.joint"), shape));
    let (joint, driven) = joint.unwrap_or((joints::Joint::Weld, None));
    robot::Link {
        parent,
        // Without a known parent, the place on it cannot be checked.
        at: written.at.filter(|_| parent.is_some() || written.parent.is_none()),
        position: written.position,
        orientation: written.orientation,
        joint,
        driven,
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

/// A valid joint of this type, so that the rest can be checked.
fn stand_in(kind: Option<&str>) -> joints::Joint {
    let (axis, axes) = ([1.0, 0.0, 0.0], [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
    let forces = JointForces::default();
    match kind {
        Some("revolute") => joints::Joint::Revolute { axis, forces },
        Some("prismatic") => joints::Joint::Prismatic { axis, forces },
        Some("cylindrical") => joints::Joint::Cylindrical { axis },
        Some("universal") => joints::Joint::Universal { axes },
        Some("planar") => joints::Joint::Planar { normal: axis },
        Some("spherical") => joints::Joint::Spherical,
        Some("free") => joints::Joint::Free,
        _ => joints::Joint::Weld,
    }
}

/// The joint written at `here` and what drives it; a valid stand-in after reporting a problem.
fn joint_of(
    document: &Document,
    names: &Names<'_>,
    written: &Written<Joint>,
    here: &str,
    shape: &mut Shape,
) -> (joints::Joint, Option<Driven>) {
    let Some(joint) = read(written, here, shape) else {
        shape.replaced.insert(here.to_owned());
        return (stand_in(written.text("type")), None);
    };
    let driven = match Driven::of(&joint) {
        Some((Driven::Mimic { multiplier, offset, .. }, Some(LinkName(link)))) => {
            let found = names.place(link);
            if found.is_none() && !names.are_incomplete {
                let right = expected_name(link, &names.all, "link");
                shape.refuse(&format!("{here}.mimic.link"), format!("no link is called \"{link}\""), right);
            }
            found.map(|link| Driven::Mimic { link, multiplier, offset })
        }
        Some((driven, _)) => {
            parts::check_span(driven.span(), &format!("{here}.motion"), &document.simulation, shape);
            Some(driven)
        }
        None => None,
    };
    (joint.resolved(), driven)
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
fn key_of(place: &str) -> String {
    match place {
        "links" => "link".to_owned(),
        _ if place.starts_with("gravity") => format!("scene.{place}"),
        _ => place.replace(".rod[", ".rod.segment["),
    }
}
