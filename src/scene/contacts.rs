//! Contacts from their tables.

use super::document::{
    self, ContactFriction, ContactPlace, ContactSurface as Written, Document, ObstacleKind, Spacing,
};
use super::loops::{expected_name, place};
use super::shape::Shape;
use crate::contact::{Contact, Obstacle, Surface};
use crate::robot::{Robot, number_default_names};

/// Stand-ins for missing values, so that the rest can be checked.
const PLACE_STAND_IN: [f64; 3] = [0.0; 3];
const OTHER_PLACE_STAND_IN: [f64; 3] = [1.0, 0.0, 0.0];
const EXTENTS_STAND_IN: [f64; 3] = [1.0; 3];
const STAND_IN: f64 = 1.0;
const MESH_STAND_IN: ([[f64; 3]; 4], [[usize; 3]; 4]) = (
    [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
    [[0, 1, 2], [0, 1, 3], [0, 2, 3], [1, 2, 3]],
);

/// Default half space: everything below the ground, as in Python.
const GROUND: [[f64; 3]; 2] = [[0.0; 3], [0.0, 0.0, 1.0]];

const UNTURNED: [f64; 4] = [1.0, 0.0, 0.0, 0.0];

/// Contacts of a scene with their indices in the file. Omits contacts on unknown links.
pub(super) fn contacts(
    document: &Document,
    robot: &Robot,
    are_incomplete: bool,
    shape: &mut Shape,
) -> (Vec<Contact>, Vec<usize>) {
    let links: Vec<String> = robot.links.iter().map(|link| link.name.clone()).collect();
    let known = Known { links, are_incomplete };
    let mut found = Vec::new();
    for (i, written) in document.contact.iter().enumerate() {
        found.extend(one(written, &format!("contact[{i}]"), &known, shape).map(|contact| (contact, i)));
    }
    let is_default = |i: usize| document.contact[i].name.is_none();
    number_default_names(found.iter_mut().map(|(contact, i)| (&mut contact.name, is_default(*i))));
    found.into_iter().unzip()
}

/// Key in the file for a place in the contacts of a robot, which have these indices in the file.
pub(super) fn key_of_contact(place: &str, written: &[document::Contact], places: &[usize]) -> Option<String> {
    let (i, rest) = place.strip_prefix("contacts[")?.split_once(']')?;
    let i = *places.get(i.parse::<usize>().ok()?)?;
    let contact = written.get(i)?;
    let is_each = matches!(contact.friction, ContactFriction::Each(_));
    let rest = match rest {
        ".name" if contact.name.is_none() => "",
        ".friction.forward" if is_each => ".friction[0]",
        ".friction.backward" if is_each => ".friction[1]",
        ".friction.sideways" if is_each => ".friction[2]",
        rest if rest.starts_with(".friction.") => ".friction",
        rest => rest,
    };
    Some(format!("contact[{i}]{rest}"))
}

/// The model to which surfaces belong.
struct Known {
    links: Vec<String>,
    /// Whether there are further links that could not be read.
    are_incomplete: bool,
}

impl Known {
    /// The link with this name; `None` after reporting a problem.
    fn link(&self, name: &str, key: &str, shape: &mut Shape) -> Option<usize> {
        let found = place(&self.links, name);
        if found.is_none() && !self.are_incomplete && shape.is_readable(key) {
            let wrong = format!("no link is called \"{name}\"");
            shape.refuse(key, wrong, expected_name(name, &self.links, "link"));
        }
        found
    }
}

fn one(written: &document::Contact, here: &str, known: &Known, shape: &mut Shape) -> Option<Contact> {
    let [a, b] = [("a", &written.a), ("b", &written.b)]
        .map(|(key, written)| surface(written, &format!("{here}.{key}"), known, shape));
    if ["a", "b"].iter().any(|key| !shape.is_readable(&format!("{here}.{key}"))) {
        return None;
    }
    let surfaces = [a?, b?];
    let name = written.name.clone().unwrap_or_else(|| {
        let [a, b] = surfaces.each_ref().map(|surface| word(surface, &known.links));
        format!("{a} on {b}")
    });
    let plain = Contact::between(&name, surfaces);
    let key = format!("{here}.stiffness");
    let mut stiffness = written.stiffness;
    if stiffness.is_none() && !plain.is_spread() && shape.is_readable(&key) {
        let right = "add stiffness in N/m: only rods have one of their own, that of their material";
        shape.refuse(here, "stiffness is missing", right);
        shape.replaced.insert(key);
    }
    if !plain.is_spread() {
        stiffness = stiffness.or(Some(STAND_IN));
    }
    Some(Contact {
        stiffness,
        dissipation: written.dissipation.unwrap_or(plain.dissipation),
        friction: written.friction.numbers(),
        slip_velocity: written.slip_velocity.unwrap_or(plain.slip_velocity),
        patch_radius: written.patch_radius.unwrap_or(plain.patch_radius),
        ..plain
    })
}

/// Name of a surface within the name of a contact, as in Python.
fn word<'a>(surface: &Surface, links: &'a [String]) -> &'a str {
    match surface {
        Surface::Rod { link } | Surface::Ball { link, .. } | Surface::Solid { link, .. } => &links[*link],
        Surface::Obstacle(Obstacle::HalfSpace { .. }) => "halfspace",
        Surface::Obstacle(Obstacle::Sphere { .. }) => "sphere",
        Surface::Obstacle(Obstacle::Capsule { .. }) => "capsule",
        Surface::Obstacle(Obstacle::Cuboid { .. }) => "box",
        Surface::Obstacle(Obstacle::HeightField { .. }) => "heightfield",
        Surface::Obstacle(Obstacle::ConvexMesh { .. }) => "convexmesh",
    }
}

/// A surface; `None` after reporting a problem with its link.
fn surface(written: &ContactPlace, here: &str, known: &Known, shape: &mut Shape) -> Option<Surface> {
    let written = match written {
        ContactPlace::Name(name) => {
            return known.link(name, here, shape).map(|link| Surface::Rod { link });
        }
        ContactPlace::Surface(written) => written,
    };
    check_keys(written, here, shape);
    let radius = written.radius.unwrap_or(STAND_IN);
    let centre = written.centre.unwrap_or(PLACE_STAND_IN);
    let obstacle = match written.kind {
        None => {
            let link = known.link(written.link.as_deref()?, &format!("{here}.link"), shape)?;
            let position = written.position.unwrap_or_default();
            return Some(Surface::Ball { link, at: written.at, position, radius });
        }
        Some(ObstacleKind::HalfSpace) => {
            let [point, normal] = GROUND;
            Obstacle::HalfSpace {
                point: written.point.unwrap_or(point),
                normal: written.normal.unwrap_or(normal),
            }
        }
        Some(ObstacleKind::Sphere) => Obstacle::Sphere { centre, radius },
        Some(ObstacleKind::Capsule) => {
            let [start, end] = [(written.start, PLACE_STAND_IN), (written.end, OTHER_PLACE_STAND_IN)]
                .map(|(place, stand_in)| place.unwrap_or(stand_in));
            Obstacle::Capsule { ends: [start, end], radius }
        }
        Some(ObstacleKind::Box) => Obstacle::Cuboid {
            centre,
            half_extents: written.half_extents.unwrap_or(EXTENTS_STAND_IN),
            orientation: written.orientation.unwrap_or(UNTURNED),
        },
        Some(ObstacleKind::HeightField) => height_field(written, here, shape),
        Some(ObstacleKind::ConvexMesh) => {
            let (points, faces) = match (&written.points, &written.faces) {
                (Some(points), Some(faces)) => (points.clone(), faces.clone()),
                _ => (MESH_STAND_IN.0.to_vec(), MESH_STAND_IN.1.to_vec()),
            };
            Obstacle::ConvexMesh { points, faces, radius: written.radius.unwrap_or_default() }
        }
    };
    let Some(name) = &written.link else { return Some(Surface::Obstacle(obstacle)) };
    let link = known.link(name, &format!("{here}.link"), shape)?;
    Some(Surface::Solid { link, at: written.at, shape: obstacle })
}

/// The height field of a table; a flat one if the heights are invalid.
fn height_field(written: &Written, here: &str, shape: &mut Shape) -> Obstacle {
    let rows = written.heights.as_deref().unwrap_or_default();
    let columns = rows.first().map_or(0, Vec::len);
    let is_grid = rows.len() >= 2 && columns >= 2;
    let uneven = rows.iter().position(|row| row.len() != columns);
    let mut found = (rows.concat(), [rows.len(), columns]);
    if let Some(row) = uneven {
        let wrong = format!("{} numbers", rows[row].len());
        let right = format!("{columns} numbers, as many as in the first row");
        shape.refuse(&format!("{here}.heights[{row}]"), wrong, right);
    } else if !is_grid && written.heights.is_some() {
        let wrong = format!("{} rows of {columns} numbers", rows.len());
        shape.refuse(&format!("{here}.heights"), wrong, "two rows or more, of two numbers or more");
    }
    if uneven.is_some() || !is_grid {
        found = (vec![0.0; 4], [2, 2]);
    }
    let (heights, shape) = found;
    Obstacle::HeightField {
        heights,
        shape,
        spacing: written.spacing.map_or([STAND_IN; 2], Spacing::numbers),
        corner: written.corner.unwrap_or_default(),
        orientation: written.orientation.unwrap_or(UNTURNED),
    }
}

/// Reports unknown keys of a surface, and missing ones.
fn check_keys(written: &Written, here: &str, shape: &mut Shape) {
    if !shape.is_readable(&format!("{here}.kind")) {
        return;
    }
    // Required keys, then optional ones.
    let (needed, other): (&[&str], &[&str]) = match written.kind {
        None => (&["link", "radius"], &["at", "position"]),
        Some(ObstacleKind::HalfSpace) => (&[], &["point", "normal"]),
        Some(ObstacleKind::Sphere) => (&["centre", "radius"], &[]),
        Some(ObstacleKind::Capsule) => (&["start", "end", "radius"], &[]),
        Some(ObstacleKind::Box) => (&["centre", "half_extents"], &["orientation"]),
        Some(ObstacleKind::HeightField) => (&["heights", "spacing"], &["corner", "orientation"]),
        Some(ObstacleKind::ConvexMesh) => (&["points", "faces"], &["radius"]),
    };
    let what = match written.kind {
        None => "a ball on a link".to_owned(),
        Some(kind) if written.link.is_some() => format!("a shape of kind \"{}\" on a link", kind.name()),
        Some(kind) => format!("an obstacle of kind \"{}\"", kind.name()),
    };
    // Every kind may be on a link.
    let of_links: &[&str] = match (written.kind, &written.link) {
        (None, _) => &[],
        (Some(_), Some(_)) => &["link", "at"],
        (Some(_), None) => &["link"],
    };
    let given = [
        ("link", written.link.is_some()),
        ("at", written.at.is_some()),
        ("position", written.position.is_some()),
        ("radius", written.radius.is_some()),
        ("point", written.point.is_some()),
        ("normal", written.normal.is_some()),
        ("centre", written.centre.is_some()),
        ("start", written.start.is_some()),
        ("end", written.end.is_some()),
        ("half_extents", written.half_extents.is_some()),
        ("orientation", written.orientation.is_some()),
        ("heights", written.heights.is_some()),
        ("spacing", written.spacing.is_some()),
        ("corner", written.corner.is_some()),
        ("points", written.points.is_some()),
        ("faces", written.faces.is_some()),
    ];
    if written.kind.is_none() && written.link.is_none() && shape.is_readable(&format!("{here}.link")) {
        let right = "add link, the link that a ball is on, or kind: \"half_space\", \"sphere\", \"capsule\", \"box\", \"height_field\" or \"convex_mesh\"";
        shape.refuse(here, "neither link nor kind", right);
        shape.replaced.insert(format!("{here}.link"));
        return;
    }
    for (key, is_given) in given {
        let place = format!("{here}.{key}");
        let is_needed = needed.contains(&key);
        let is_other = other.contains(&key) || of_links.contains(&key);
        if is_given && !is_needed && !is_other {
            let taken: Vec<&str> = needed.iter().chain(other).chain(of_links).copied().collect();
            let right = format!("remove it: it takes {}", taken.join(", "));
            shape.refuse(&place, format!("{what} does not take it"), right);
        } else if !is_given && is_needed && shape.is_readable(&place) {
            let right = match key {
                "radius" => "add radius in metres".to_owned(),
                "half_extents" => "add half_extents, half the lengths of its edges in metres".to_owned(),
                "heights" => {
                    "add heights, rows of numbers in metres: those of a row follow each other along y"
                        .to_owned()
                }
                "spacing" => "add spacing, the distance of neighbouring heights in metres".to_owned(),
                "points" => "add points, the corners of the body in metres".to_owned(),
                "faces" => "add faces, triangles by the places of their corners in points, from 0".to_owned(),
                _ => format!("add {key}, three numbers in metres"),
            };
            shape.refuse(here, format!("{key} is missing"), right);
            shape.replaced.insert(place);
        }
    }
}
