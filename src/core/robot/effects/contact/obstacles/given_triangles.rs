//! Points and triangles of meshes as they are given.

use crate::error::Checker;

/// Reports what is wrong with the numbers of points and faces, with points, and with the indices of faces; true if nothing is.
pub(super) fn are_valid(
    check: &mut Checker,
    (points, most_points): (&[[f64; 3]], usize),
    (faces, most_faces): (&[[usize; 3]], Option<usize>),
) -> bool {
    let number = points.len();
    let mut is_right = check.require(
        (4..=most_points).contains(&number),
        "points",
        format_args!("{number} points"),
        &format!("the corners of a body: 4 to {most_points} points"),
    );
    for (i, point) in points.iter().enumerate() {
        is_right &= check.finite(point, &format!("points[{i}]"));
    }
    let most =
        most_faces.map_or_else(String::new, |most| format!(", and at most {most} between {number} corners"));
    is_right &= check.require(
        faces.len() >= 4 && most_faces.is_none_or(|most| faces.len() <= most),
        "faces",
        format_args!("{} triangles", faces.len()),
        &format!("the whole surface: 4 triangles or more{most}"),
    );
    for (f, face) in faces.iter().enumerate() {
        let [a, b, c] = *face;
        let are_there = face.iter().all(|&corner| corner < number);
        is_right &= check.require(
            are_there && a != b && b != c && c != a,
            &format!("faces[{f}]"),
            format_args!("({a}, {b}, {c})"),
            &format!("the places of three points among the {number}, the first one 0"),
        );
    }
    is_right
}
