//! Distances from convex polyhedra and from polyhedra rounded by a radius.

use super::distance::{Distance, SHORTEST, between};
use crate::numerics::lie::{Symmetric, Vector};

/// Faces whose normals differ by less than this sine count as one.
const FLAT: f64 = 1e-9;

/// Mean of points.
fn middle(points: &[Vector<f64>]) -> Vector<f64> {
    let mut middle = Vector::zero();
    for &point in points {
        middle = middle.add_scaled(point, 1.0 / points.len() as f64);
    }
    middle
}

/// All points within a radius of a convex body with triangular faces.
#[derive(Clone, Debug)]
pub(crate) struct ConvexMesh {
    faces: Vec<Face>,
    radius: f64,
    /// A ball around it.
    around: (Vector<f64>, f64),
}

#[derive(Clone, Debug)]
struct Face {
    corners: [Vector<f64>; 3],
    /// Indices of the corners.
    places: [usize; 3],
    /// Outward unit normal, and its product with the corners.
    normal: Vector<f64>,
    offset: f64,
}

/// The feature of a triangle nearest to a point: the triangle itself, the edge from a corner to the next one,
/// or a corner.
#[derive(Clone, Copy)]
pub(super) enum Feature {
    Inside,
    Edge(usize),
    Corner(usize),
}

/// The feature of a body nearest to a point, and the position of the point relative to it.
struct Nearest {
    face: usize,
    feature: Feature,
    /// Distance above a face, or from an edge or a corner; negative inside.
    length: f64,
    way: Vector<f64>,
}

impl ConvexMesh {
    /// Takes points in convex position, and non-degenerate faces with their corners in any order.
    pub(crate) fn new(points: &[Vector<f64>], faces: &[[usize; 3]], radius: f64) -> Self {
        let middle = middle(points);
        let face = |&places: &[usize; 3]| {
            let corners = places.map(|c| points[c]);
            let [a, b, c] = corners;
            let across = (b - a).cross(c - a);
            let side = if across.dot(a - middle) < 0.0 { -1.0 } else { 1.0 };
            let normal = across * (side / across.dot(across).sqrt());
            Face { corners, places, normal, offset: normal.dot(a) }
        };
        let size = points.iter().map(|&point| between(point, middle)).fold(0.0, f64::max);
        Self { faces: faces.iter().map(face).collect(), radius, around: (middle, size + radius) }
    }

    /// Whether a point is certainly farther from it than `reach`.
    pub(crate) fn is_certainly_beyond(&self, point: Vector<f64>, reach: f64) -> bool {
        between(point, self.around.0) > self.around.1 + reach.max(0.0)
    }

    /// Largest distance of its points from the origin.
    pub(crate) fn reach(&self) -> f64 {
        let corners = self.faces.iter().flat_map(|face| face.corners);
        corners.map(|corner| corner.dot(corner).sqrt()).fold(0.0, f64::max) + self.radius
    }

    /// Depth of the mean of its points below the surface.
    pub(crate) fn thickness(&self, points: &[Vector<f64>]) -> f64 {
        -self.distance(middle(points)).value
    }

    /// Depth of the mean of the corners of its faces below the surface.
    pub(crate) fn depth(&self) -> f64 {
        let corners = self.faces.iter().flat_map(|face| face.corners);
        let sum = corners.fold(Vector::zero(), |sum, corner| sum + corner);
        -self.distance(sum * (3.0 * self.faces.len() as f64).recip()).value
    }

    /// Edges as pairs of points, without those between coplanar faces.
    pub(crate) fn edges(&self) -> Vec<[usize; 2]> {
        let mut sides: Vec<([usize; 2], Vector<f64>)> = Vec::new();
        for face in &self.faces {
            for k in 0..3 {
                let (p, q) = (face.places[k], face.places[(k + 1) % 3]);
                sides.push(([p.min(q), p.max(q)], face.normal));
            }
        }
        sides.sort_by_key(|&(edge, _)| edge);
        let bent = sides.chunks_exact(2).filter(|both| {
            let across = both[0].1.cross(both[1].1);
            across.dot(across).sqrt() > FLAT
        });
        bent.map(|both| both[0].0).collect()
    }

    /// Points after all faces have moved inwards by a distance; a least-squares fit for points where more
    /// than three faces meet.
    pub(crate) fn inset(&self, points: &[Vector<f64>], by: f64) -> Vec<Vector<f64>> {
        let moved = |(p, &point): (usize, &Vector<f64>)| {
            let (mut squares, mut sum) = (Symmetric::diagonal(0.0), Vector::zero());
            let own = || self.faces.iter().filter(move |face| face.places.contains(&p));
            for face in own() {
                squares += Symmetric::square(face.normal);
                sum += face.normal;
            }
            let [a, b, c] = (squares + Symmetric::diagonal(FLAT * own().count() as f64)).rows();
            let [bc, ca, ab] = [b.cross(c), c.cross(a), a.cross(b)];
            let [x, y, z] = sum.to_array();
            point - (bc * x + ca * y + ab * z) * (by / a.dot(bc))
        };
        points.iter().enumerate().map(moved).collect()
    }

    /// The feature nearest to a point: the nearest face inside; the nearest face, edge or corner outside.
    fn nearest(&self, point: Vector<f64>) -> Nearest {
        let mut highest = (f64::NEG_INFINITY, 0);
        let mut best: Option<Nearest> = None;
        for (f, face) in self.faces.iter().enumerate() {
            let above = face.normal.dot(point) - face.offset;
            if above > highest.0 {
                highest = (above, f);
            }
            // For points behind a face another one is nearer.
            if above <= 0.0 || best.as_ref().is_some_and(|best| above >= best.length) {
                continue;
            }
            let (place, feature) = nearest_on(&face.corners, point);
            let way = point - place;
            // Above a side that divides a flat face is above the face.
            let across = way.cross(face.normal);
            let is_above = across.dot(across) <= FLAT * FLAT * way.dot(way);
            let feature = if is_above { Feature::Inside } else { feature };
            let length = if let Feature::Inside = feature { above } else { way.dot(way).sqrt() };
            if best.as_ref().is_none_or(|best| length < best.length) {
                best = Some(Nearest { face: f, feature, length, way });
            }
        }
        let (length, face) = highest;
        let inside = Nearest { face, feature: Feature::Inside, length, way: Vector::zero() };
        best.filter(|best| best.length > SHORTEST).unwrap_or(inside)
    }

    /// Distance of a point from the body.
    pub(crate) fn distance(&self, point: Vector<f64>) -> Distance {
        let Nearest { face, feature, length, way } = self.nearest(point);
        let Face { corners, normal, .. } = &self.faces[face];
        let along = match feature {
            Feature::Inside => {
                let curvature = Symmetric::diagonal(0.0);
                return Distance { value: length - self.radius, normal: *normal, curvature };
            }
            Feature::Edge(from) => {
                let along = corners[(from + 1) % 3] - corners[from];
                Some((along * along.dot(along).sqrt().recip(), 1.0))
            }
            Feature::Corner(_) => None,
        };
        Distance::from_curve(way, self.radius, along)
    }

    /// The feature nearest to a point, as indices of points: a face, an edge or a corner.
    pub(crate) fn feature(&self, point: Vector<f64>) -> [usize; 3] {
        let Nearest { face, feature, .. } = self.nearest(point);
        let places = self.faces[face].places;
        match feature {
            Feature::Inside => places,
            Feature::Edge(from) => {
                let (p, q) = (places[from], places[(from + 1) % 3]);
                [p.min(q), p.max(q), usize::MAX]
            }
            Feature::Corner(corner) => [places[corner], usize::MAX, usize::MAX],
        }
    }
}

/// Point of a triangle nearest to a point (Ericson 2005, section 5.1.5).
pub(super) fn nearest_on(&[a, b, c]: &[Vector<f64>; 3], point: Vector<f64>) -> (Vector<f64>, Feature) {
    let (ab, ac, ap) = (b - a, c - a, point - a);
    let (d1, d2) = (ab.dot(ap), ac.dot(ap));
    if d1 <= 0.0 && d2 <= 0.0 {
        return (a, Feature::Corner(0));
    }
    let bp = point - b;
    let (d3, d4) = (ab.dot(bp), ac.dot(bp));
    if d3 >= 0.0 && d4 <= d3 {
        return (b, Feature::Corner(1));
    }
    let vc = d1 * d4 - d3 * d2;
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        return (a.add_scaled(ab, d1 / (d1 - d3)), Feature::Edge(0));
    }
    let cp = point - c;
    let (d5, d6) = (ab.dot(cp), ac.dot(cp));
    if d6 >= 0.0 && d5 <= d6 {
        return (c, Feature::Corner(2));
    }
    let vb = d5 * d2 - d1 * d6;
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        return (a.add_scaled(ac, d2 / (d2 - d6)), Feature::Edge(2));
    }
    let va = d3 * d6 - d5 * d4;
    if va <= 0.0 && d4 >= d3 && d5 >= d6 {
        let x = (d4 - d3) / ((d4 - d3) + (d5 - d6));
        return (b.add_scaled(c - b, x), Feature::Edge(1));
    }
    let over = (va + vb + vc).recip();
    (a + ab * (vb * over) + ac * (vc * over), Feature::Inside)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn v(x: f64, y: f64, z: f64) -> Vector<f64> {
        Vector::new(x, y, z)
    }

    proptest! {
        /// The distance of a tetrahedron is the smallest distance of many of its points.
        #[test]
        fn distances_are_those_of_the_nearest_place(
            (p, q, r, s) in ((-1.0..0.0, -1.0..0.0), (0.2..1.0, -1.0..0.0), (-0.5..0.5, 0.2..1.0), (-0.3..0.3, -0.3..0.3)),
            (x, y, z) in (-2.0..2.0, -2.0..2.0, -2.0..2.0),
        ) {
            let points = [v(p.0, p.1, 0.0), v(q.0, q.1, 0.0), v(r.0, r.1, 0.0), v(s.0, s.1, 1.0)];
            let mesh = ConvexMesh::new(&points, &[[0, 1, 2], [0, 3, 1], [1, 3, 2], [2, 3, 0]], 0.1);
            let point = v(x, y, z);
            let found = mesh.distance(point);
            let mut tried = f64::INFINITY;
            for face in &mesh.faces {
                let [a, b, c] = face.corners;
                for i in 0..=60 {
                    for j in 0..=60 - i {
                        let place = a + (b - a) * (f64::from(i) / 60.0) + (c - a) * (f64::from(j) / 60.0);
                        tried = tried.min((point - place).dot(point - place).sqrt());
                    }
                }
            }
            let wanted = (found.value + 0.1).abs();
            prop_assert!(wanted <= tried + 1e-12 && tried <= wanted + 0.04, "{wanted} {tried}");
            let behind = points.iter().all(|_| mesh.faces.iter().all(|f| f.normal.dot(point) <= f.offset));
            prop_assert!(behind == (found.value + 0.1 <= 0.0));
        }
    }
}
