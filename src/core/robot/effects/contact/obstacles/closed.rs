//! Checks that triangles are the closed surface of a body, and their orientation.

use std::collections::{BTreeMap, VecDeque};

use super::given_triangles;
use crate::error::Checker;
use crate::numerics::lie::Vector;
use crate::robot::effects::contact::shapes::triangles::{Triangles, across};

/// Maximum number of points: more would be a mistake in the input rather than a shape that robots touch.
const MOST_POINTS: usize = 500_000;

/// Smallest height of a face over its longest edge: normals of flatter ones would be rounding.
const SLENDER: f64 = 1e-10;

/// Faces at an edge: index, and whether they run along it from the smaller index to the larger one.
type Edges = BTreeMap<[usize; 2], Vec<(usize, bool)>>;

/// Faces with their corners anticlockwise seen from outside; reports all problems and returns `None` if they do not enclose a body.
pub(super) fn oriented(
    check: &mut Checker,
    points: &[[f64; 3]],
    faces: &[[usize; 3]],
) -> Option<Vec<[usize; 3]>> {
    let mut is_right = given_triangles::are_valid(check, (points, MOST_POINTS), (faces, None));
    if !is_right {
        return None;
    }
    let points: Vec<_> = points.iter().map(|&point| Vector::from(point)).collect();
    for (f, face) in faces.iter().enumerate() {
        let [a, b, c] = face.map(|p| points[p]);
        let longest = [b - a, c - b, a - c].map(|side| side.dot(side)).into_iter().fold(0.0, f64::max);
        let across = across(&points, face);
        let has_area = across.dot(across).sqrt() > SLENDER * longest;
        is_right &=
            check.require(has_area, &format!("faces[{f}]"), "corners on one line", "a triangle with an area");
    }
    let edges = edges_of(faces);
    if let Some(([a, b], of_edge)) = edges.iter().find(|(_, faces)| faces.len() != 2) {
        let [from, to] = [*a, *b].map(|p| place(points[p]));
        let open = edges.values().filter(|faces| faces.len() != 2).count();
        let found = format!(
            "{} with the edge between points {a} and {b}, from {from} to {to} m ({open} such edges)",
            if of_edge.len() == 1 { "1 face".to_owned() } else { format!("{} faces", of_edge.len()) }
        );
        let expected = "two faces with every edge: a closed surface; merge equal points, which files of single triangles list again for each of them";
        check.require(false, "faces", found, expected);
        return None;
    }
    is_right.then(|| outwards(check, &points, faces, &edges)).flatten()
}

fn edges_of(faces: &[[usize; 3]]) -> Edges {
    let mut edges = Edges::new();
    for (f, face) in faces.iter().enumerate() {
        for k in 0..3 {
            let (a, b) = (face[k], face[(k + 1) % 3]);
            edges.entry([a.min(b), a.max(b)]).or_default().push((f, a < b));
        }
    }
    edges
}

/// Faces anticlockwise seen from outside. If faces at all edges run in opposite directions, all are turned or none; otherwise each
/// connected part is a body of its own.
fn outwards(
    check: &mut Checker,
    points: &[Vector<f64>],
    faces: &[[usize; 3]],
    edges: &Edges,
) -> Option<Vec<[usize; 3]>> {
    let is_even = edges.values().all(|faces| faces[0].1 != faces[1].1);
    let mut turned = faces.to_vec();
    let parts =
        if is_even { vec![(0..faces.len()).collect()] } else { align(check, points, &mut turned, edges)? };
    for part in parts {
        let volume: f64 = part.iter().map(|&f: &usize| six_volumes(points, &turned[f])).sum();
        if volume < 0.0 {
            part.iter().for_each(|&f| turned[f].swap(1, 2));
        }
    }
    let found = Triangles::new(points, &turned).intersection(points);
    if let Some(([a, b], [p, q, r], at)) = found {
        let found = format!(
            "the edge between points {a} and {b}, which passes through the face ({p}, {q}, {r}) at {} m",
            place(at)
        );
        check.require(false, "faces", found, "a surface that does not intersect itself");
        return None;
    }
    Some(turned)
}

/// Turns faces so that those at each edge run in opposite directions, and lists the connected parts.
fn align(
    check: &mut Checker,
    points: &[Vector<f64>],
    faces: &mut [[usize; 3]],
    edges: &Edges,
) -> Option<Vec<Vec<usize>>> {
    // Whether each face is turned, once it is known.
    let mut is_turned: Vec<Option<bool>> = vec![None; faces.len()];
    let mut parts = Vec::new();
    for first in 0..faces.len() {
        if is_turned[first].is_some() {
            continue;
        }
        is_turned[first] = Some(false);
        let (mut part, mut waiting) = (Vec::new(), VecDeque::from([first]));
        while let Some(f) = waiting.pop_front() {
            part.push(f);
            for k in 0..3 {
                let (a, b) = (faces[f][k], faces[f][(k + 1) % 3]);
                let of_edge = &edges[&[a.min(b), a.max(b)]];
                let [own, (other, way)] =
                    if of_edge[0].0 == f { [of_edge[0], of_edge[1]] } else { [of_edge[1], of_edge[0]] };
                let wanted = (own.1 == way) != (is_turned[f] == Some(true));
                match is_turned[other] {
                    None => {
                        is_turned[other] = Some(wanted);
                        waiting.push_back(other);
                    }
                    Some(known) if known != wanted => {
                        let found = format!(
                            "a surface with one side, seen at the edge from {} to {} m",
                            place(points[a]),
                            place(points[b])
                        );
                        check.require(false, "faces", found, "one with an inside and an outside");
                        return None;
                    }
                    Some(_) => {}
                }
            }
        }
        parts.push(part);
    }
    for (face, _) in faces.iter_mut().zip(&is_turned).filter(|(_, turned)| **turned == Some(true)) {
        face.swap(1, 2);
    }
    Some(parts)
}

/// Six times the volume of the tetrahedron between a face and the origin.
fn six_volumes(points: &[Vector<f64>], &[a, b, c]: &[usize; 3]) -> f64 {
    points[a].dot(points[b].cross(points[c]))
}

/// A place in messages.
pub(super) fn place(point: Vector<f64>) -> String {
    let [x, y, z] = point.to_array();
    format!("({x:.4}, {y:.4}, {z:.4})")
}

#[cfg(test)]
mod tests {
    use super::*;

    const POINTS: [[f64; 3]; 4] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    const FACES: [[usize; 3]; 4] = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];

    fn wrong(points: &[[f64; 3]], faces: &[[usize; 3]]) -> String {
        let mut check = Checker::new();
        let found = oriented(&mut check, points, faces);
        let message = check.finish().map_or_else(|error| error.to_string(), |()| String::new());
        assert_eq!(found.is_some(), message.is_empty());
        message
    }

    #[test]
    fn faces_are_turned_outwards() {
        let expected = FACES.map(|face| face.map(|p| POINTS[p]));
        for turned in 0..16 {
            let faces: Vec<_> = FACES
                .iter()
                .enumerate()
                .map(|(f, &[a, b, c])| if turned >> f & 1 == 0 { [a, b, c] } else { [a, c, b] })
                .collect();
            let found = oriented(&mut Checker::new(), &POINTS, &faces).expect("a closed surface");
            for (face, expected) in found.iter().zip(expected) {
                let face = face.map(|p| POINTS[p]);
                assert!(
                    (0..3).any(|k| [0, 1, 2].map(|i| face[(i + k) % 3]) == expected),
                    "{face:?} {expected:?}"
                );
            }
        }
    }

    #[test]
    fn what_is_no_closed_surface_is_refused() {
        assert_eq!(wrong(&POINTS, &FACES), "");
        let open = wrong(&POINTS, &[FACES[0], FACES[1], FACES[2], FACES[0]]);
        assert!(
            open.contains("edge between points 0 and 1") && open.contains("(0.0000, 0.0000, 0.0000)"),
            "{open}"
        );
        // A second tetrahedron, whose tip is within the first one.
        let inside = [[0.2, 0.2, 0.2], [2.0, 0.2, 0.2], [2.0, 1.0, 0.2], [2.0, 0.2, 1.0]];
        let points: Vec<_> = POINTS.into_iter().chain(inside).collect();
        let faces: Vec<_> = FACES.into_iter().chain(FACES.map(|face| face.map(|p| p + 4))).collect();
        let crossed = wrong(&points, &faces);
        assert!(crossed.contains("passes through the face"), "{crossed}");
        // Apart, both are one body of two parts.
        let apart: Vec<_> = points
            .iter()
            .enumerate()
            .map(|(p, &[x, y, z])| if p < 4 { [x, y, z] } else { [x + 2.0, y, z] })
            .collect();
        assert_eq!(wrong(&apart, &faces), "");
    }
}
