//! Checks that points and faces form a convex body.

use std::collections::BTreeMap;

use super::given_triangles;
use crate::error::Checker;

/// Maximum number of points: the cost of every contact point grows with it.
const MOST_POINTS: usize = 2000;

/// Points may protrude from a face by this fraction of the size of the body: rounding.
const FLAT: f64 = 1e-9;

/// Smallest height of a face over its longest edge: normals of flatter ones would be rounding.
const SLENDER: f64 = 1e-7;

fn minus(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|i| a[i] - b[i])
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|i| a[(i + 1) % 3] * b[(i + 2) % 3] - a[(i + 2) % 3] * b[(i + 1) % 3])
}

/// Reports all problems of points and faces.
pub(super) fn check(check: &mut Checker, points: &[[f64; 3]], faces: &[[usize; 3]]) {
    // A closed surface of triangles has no more faces (Euler).
    let most_faces = (2 * points.len()).saturating_sub(4);
    if given_triangles::are_valid(check, (points, MOST_POINTS), (faces, Some(most_faces))) {
        check_shape(check, points, faces);
    }
}

/// Reports faces that are degenerate, or do not enclose a convex body.
fn check_shape(check: &mut Checker, points: &[[f64; 3]], faces: &[[usize; 3]]) {
    let mut times: BTreeMap<[usize; 2], usize> = BTreeMap::new();
    for face in faces {
        for k in 0..3 {
            let (a, b) = (face[k], face[(k + 1) % 3]);
            *times.entry([a.min(b), a.max(b)]).or_default() += 1;
        }
    }
    if let Some(([a, b], times)) = times.iter().find(|(_, times)| **times != 2) {
        let found = format!("{times} with the edge between points {a} and {b}");
        check.require(false, "faces", found, "two faces with every edge: a closed surface");
        return;
    }
    let used: Vec<bool> = (0..points.len()).map(|p| faces.iter().any(|face| face.contains(&p))).collect();
    if let Some(p) = used.iter().position(|is_used| !is_used) {
        check.require(false, &format!("points[{p}]"), "no face with it", "corners of faces alone");
        return;
    }
    let ends = |of: fn(f64, f64) -> f64, start: f64| -> [f64; 3] {
        std::array::from_fn(|i| points.iter().map(|point| point[i]).fold(start, of))
    };
    let extent = minus(ends(f64::max, f64::NEG_INFINITY), ends(f64::min, f64::INFINITY));
    let size = dot(extent, extent).sqrt();
    for (f, &[a, b, c]) in faces.iter().enumerate() {
        let [ab, ac, bc] =
            [minus(points[b], points[a]), minus(points[c], points[a]), minus(points[c], points[b])];
        let across = cross(ab, ac);
        let area = dot(across, across).sqrt();
        let longest = dot(ab, ab).max(dot(ac, ac)).max(dot(bc, bc));
        let place = format!("faces[{f}]");
        // Also rejects NaN.
        if !(area > SLENDER * longest && area.is_finite()) {
            check.require(false, &place, "corners on one line", "a triangle with an area");
            return;
        }
        let above = points.iter().map(|&point| dot(minus(point, points[a]), across) / area);
        let (lowest, highest) = above.fold((0.0_f64, 0.0_f64), |(low, high), x| (low.min(x), high.max(x)));
        if lowest.min(-highest) >= -FLAT * size {
            check.require(false, "points", "all in one plane", "the corners of a body");
            return;
        }
        if lowest < -FLAT * size && highest > FLAT * size {
            let found = format!("points on both sides of it, by {:.3e} and {highest:.3e} m", -lowest);
            check.require(false, &place, found, "all points on one side: a convex body; others are a `Mesh`");
            return;
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::description::schema::Item as _;
    use crate::robot::effects::contact::obstacles::described::ConvexMesh;

    const POINTS: [[f64; 3]; 5] =
        [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.2, 0.2, 0.2]];
    const FACES: [[usize; 3]; 4] = [[0, 1, 2], [0, 1, 3], [3, 2, 0], [1, 2, 3]];

    fn wrong(points: &[[f64; 3]], faces: &[[usize; 3]]) -> String {
        let (points, faces) = (points.to_vec(), faces.to_vec());
        let mesh = ConvexMesh { points, faces, radius: 0.0, link: None, at: None };
        mesh.validate().map_or_else(|error| error.to_string(), |()| String::new())
    }

    #[test]
    fn what_is_no_convex_body_is_refused() {
        assert_eq!(wrong(&POINTS[..4], &FACES), "");
        for (points, faces, expected) in [
            (&POINTS[..3], &FACES[..], "3 points"),
            (&POINTS[..4], &FACES[..3], "3 triangles"),
            (&POINTS[..4], &[[0, 1, 2], [0, 1, 3], [3, 2, 0], [1, 2, 4]], "(1, 2, 4)"),
            (&POINTS[..4], &[[0, 1, 2], [0, 1, 2], [3, 2, 0], [1, 2, 3]], "edge between points"),
            (&POINTS[..], &FACES[..], "no face with it"),
        ] {
            assert!(wrong(points, faces).contains(expected), "{}", wrong(points, faces));
        }
        // One corner of a face is pushed in.
        let hollow = [[0, 1, 2], [0, 1, 3], [3, 2, 0], [1, 2, 4], [2, 3, 4], [3, 1, 4]];
        assert!(wrong(&POINTS, &hollow).contains("both sides"));
        let mut flat = POINTS[..4].to_vec();
        flat[3] = [1.0, 1.0, 0.0];
        assert!(wrong(&flat, &FACES).contains("one plane"));
        // A face from the corners of an edge and a point on that edge.
        let mut slit = POINTS.to_vec();
        slit[4] = [0.5, 0.0, 0.0];
        let faces = [[0, 1, 4], [0, 4, 2], [4, 1, 2], [0, 1, 3], [3, 2, 0], [1, 2, 3]];
        assert!(wrong(&slit, &faces).contains("line"), "{}", wrong(&slit, &faces));
    }
}
