//! Links of a robot from their tables.

use super::described::{key_of, read_with, right};
use super::document::{Document, General, Import, Jacobian};
use super::imports::{Imported, Imports, Request};
use super::lists::{self, Keys};
use super::parts;
use super::shape::{Shape, report};
use super::written::Written;
use crate::description::body::Body;
use crate::description::joint as joints;
use crate::description::joint::JointForces;
use crate::description::schema::Value;
use crate::error::Checker;
use crate::robot::Robot;
use crate::robot::described::{Link, LinkRod};

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
    let right = "a URDF file, seen from the folder of the scene";
    let content = shape.content([&written.urdf, right], "import.urdf", imports)?;
    shape.taken(imports.links(&request, &content), "import.urdf", right)
}

/// The robot from the tables of its links, which follow the imported ones, and its initial coordinates and
/// velocities.
pub(super) fn robot(
    document: &Document,
    imported: Option<&Imported>,
    shape: &mut Shape,
) -> Option<(Robot, [Vec<f64>; 2])> {
    let before = imported.map_or(0, |imported| imported.links.len());
    // Unknown names may be those of links that could not be imported.
    let are_incomplete = document.import.is_some() && imported.is_none();
    let links = links(document, imported, shape);
    let mut keys = Keys::default();
    let described = lists::robot(document, links, before, &mut keys, shape);
    check_jacobian(document, shape);
    let key = |place: &str| keys.of(place).unwrap_or_else(|| key_in_file(&key_of_link(place, before)));
    let (robot, places) = lists::resolved(shape, key, |reader| described.resolved(are_incomplete, reader));
    for (i, link) in robot.links.iter().enumerate() {
        if let Some(driven) = &link.driven {
            let here = key_of_link(&format!("links[{i}].joint.motion"), before);
            parts::check_span(driven.span(), &here, &document.simulation, shape);
        }
    }
    let key = |place: &str| keys.of_model(place, &places).unwrap_or_else(|| key(place));
    if are_incomplete {
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
        let given = if key == "q0" { &written.below.q0 } else { &written.below.v0 };
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

/// The imported links, and those of the scene.
fn links(document: &Document, imported: Option<&Imported>, shape: &mut Shape) -> Vec<Link> {
    let imported = imported.map_or(&[][..], |imported| &imported.links);
    let written = document.link.iter().enumerate();
    let of_scene = written.map(|(i, written)| link(&written.described, &format!("link[{i}]"), shape));
    imported.iter().cloned().chain(of_scene).collect()
}

/// The link written at `here`; after reporting problems one that is like it as far as it could be read, so that the rest can
/// be checked.
fn link(written: &Written<Link>, here: &str, shape: &mut Shape) -> Link {
    let (table, segments) = (written.value(), parts::of_link(written));
    let mut wrong = Vec::new();
    let found = read_with(written, here, shape, |place| {
        wrong.push(format!("{here}.{}", owner(&place)));
        in_file(place, segments)
    });
    if let Some(found) = found {
        return found;
    }
    shape.replaced.extend(wrong);
    let segment = |table| right(table).unwrap_or_else(|| parts::stand_in(table));
    let rod = LinkRod { segment: segments.iter().map(segment).collect() };
    let usual = Link::new(String::new());
    Link {
        name: key_of::<Link, _>(table, "name").unwrap_or(usual.name),
        rod: Some(rod).filter(|rod| !rod.segment.is_empty()),
        // A body that cannot be read still is mass that a joint moves.
        body: key_of::<Link, _>(table, "body")
            .or_else(|| table.get("body").map(|_| Body::point(1.0).described(None))),
        joint: key_of::<Link, _>(table, "joint").unwrap_or_else(|| stand_in(table).described()),
        parent: key_of::<Link, _>(table, "parent"),
        at: key_of::<Link, _>(table, "at"),
        position: key_of::<Link, _>(table, "position").unwrap_or(usual.position),
        orientation: key_of::<Link, _>(table, "orientation").unwrap_or(usual.orientation),
    }
}

/// The part of a link to which a place belongs: a segment, or the value of a key.
fn owner(place: &str) -> &str {
    let end = match place.starts_with("rod.segment[") {
        true => place.find(']').map(|end| end + 1),
        false => place.find(['.', '[']),
    };
    &place[..end.unwrap_or(place.len())]
}

/// The place in the file of a place in a link with these segments.
fn in_file(place: String, segments: &[Value]) -> String {
    let in_segment = place.strip_prefix("rod.segment[").and_then(|rest| rest.split_once("]."));
    let Some((i, rest)) = in_segment else { return place };
    let segment = i.parse::<usize>().ok().and_then(|i| segments.get(i));
    segment.map_or_else(
        || place.clone(),
        |segment| format!("rod.segment[{i}].{}", parts::in_section(segment, rest.to_owned())),
    )
}

/// A valid joint of the type in the table of its link, so that the rest can be checked.
fn stand_in(link: &Value) -> joints::Joint {
    let (axis, axes) = ([1.0, 0.0, 0.0], [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
    let forces = JointForces::default();
    match link.get("joint").and_then(|joint| joint.get("type")?.text()) {
        Some("revolute") => joints::Joint::Revolute { axis, forces },
        Some("prismatic") => joints::Joint::Prismatic { axis, forces },
        Some("screw") => joints::Joint::Screw { axis, lead: 1.0, forces },
        Some("cylindrical") => joints::Joint::Cylindrical { axis },
        Some("universal") => joints::Joint::Universal { axes },
        Some("planar") => joints::Joint::Planar { normal: axis },
        Some("spherical") => joints::Joint::Spherical,
        Some("free") => joints::Joint::Free,
        _ => joints::Joint::Weld,
    }
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
fn key_in_file(place: &str) -> String {
    match place {
        "links" => "link".to_owned(),
        _ if General::has(place) => format!("scene.{place}"),
        _ => place.replace(".rod[", ".rod.segment["),
    }
}

/// Reports a Jacobian option that does not support closed loops.
fn check_jacobian(document: &Document, shape: &mut Shape) {
    if document.r#loop.is_empty() {
        return;
    }
    if document.simulation.jac != Jacobian::Analytic && shape.is_readable("simulation.jac") {
        let right = "expected \"analytic\" (the default): that of the constraints is exact";
        shape.refuse("simulation.jac", "differences do not see closed loops", right);
    }
}
