//! Signed distances from closed surfaces of triangles.
//!
//! A tree of boxes finds the nearest triangle. The sign is that of the angle-weighted normal of the face, edge or corner that is nearest
//! (Baerentzen and Aanaes 2005, "Signed distance computation using the angle weighted pseudonormal").

use std::collections::BTreeMap;

use super::convex_mesh::{Feature, nearest_on};
use crate::numerics::lie::Vector;

/// Maximum number of triangles in a leaf of the tree.
const LEAF: usize = 4;

/// Coordinates of a point within a triangle may be as negative as this for an edge to count as passing through it: rounding.
const WITHIN: f64 = 1e-9;

/// A closed surface of triangles, each anticlockwise seen from outside.
#[derive(Clone, Debug)]
pub(crate) struct Triangles {
    triangles: Vec<Triangle>,
    nodes: Vec<Node>,
}

#[derive(Clone, Debug)]
struct Triangle {
    corners: [Vector<f64>; 3],
    places: [usize; 3],
    normal: Vector<f64>,
    /// Normals of edges, from each corner to the next one, and of corners, in the same order; not of unit length.
    of_edges: [Vector<f64>; 3],
    of_corners: [Vector<f64>; 3],
}

#[derive(Clone, Copy, Debug)]
struct Node {
    low: [f64; 3],
    high: [f64; 3],
    kind: Kind,
}

#[derive(Clone, Copy, Debug)]
enum Kind {
    /// With the index of the second half; the first one follows the node.
    Branch(usize),
    /// Triangles from one to before another one.
    Leaf(usize, usize),
}

/// A grid of values, the third axis varying fastest.
#[derive(Clone, Debug)]
pub(crate) struct Sampled {
    pub(crate) values: Vec<f64>,
    pub(crate) shape: [usize; 3],
    /// Position of the first value.
    pub(crate) corner: Vector<f64>,
}

impl Triangles {
    /// Takes faces with an area, each edge of which belongs to another face in the opposite direction.
    pub(crate) fn new(points: &[Vector<f64>], faces: &[[usize; 3]]) -> Self {
        let mut of_edges: BTreeMap<[usize; 2], Vector<f64>> = BTreeMap::new();
        let mut of_corners = vec![Vector::zero(); points.len()];
        let normals: Vec<_> = faces.iter().map(|face| unit(across(points, face))).collect();
        for (face, &normal) in faces.iter().zip(&normals) {
            for k in 0..3 {
                let [p, q, r] = [0, 1, 2].map(|i| face[(k + i) % 3]);
                *of_edges.entry([p.min(q), p.max(q)]).or_insert_with(Vector::zero) += normal;
                let [to_next, to_last] = [points[q] - points[p], points[r] - points[p]];
                let across = to_next.cross(to_last);
                let angle = across.dot(across).sqrt().atan2(to_next.dot(to_last));
                of_corners[p] += normal * angle;
            }
        }
        let triangle = |(&places, normal): (&[usize; 3], Vector<f64>)| Triangle {
            corners: places.map(|p| points[p]),
            places,
            normal,
            of_edges: std::array::from_fn(|k| {
                let (p, q) = (places[k], places[(k + 1) % 3]);
                of_edges[&[p.min(q), p.max(q)]]
            }),
            of_corners: places.map(|p| of_corners[p]),
        };
        let mut triangles: Vec<_> = faces.iter().zip(normals).map(triangle).collect();
        let mut nodes = Vec::new();
        let number = triangles.len();
        enclose(&mut triangles, 0..number, &mut nodes);
        Self { triangles, nodes }
    }

    /// Corners of the box around it.
    pub(crate) fn extent(&self) -> [[f64; 3]; 2] {
        [self.nodes[0].low, self.nodes[0].high]
    }

    /// Signed distance of a point that is not farther than `most`.
    pub(crate) fn distance(&self, point: Vector<f64>, most: f64) -> f64 {
        let mut best = (most * most, f64::INFINITY);
        self.search(point, 0, &mut best);
        best.1
    }

    /// Looks for a nearer place: the square of its distance, and the distance with its sign.
    fn search(&self, point: Vector<f64>, node: usize, best: &mut (f64, f64)) {
        match self.nodes[node].kind {
            Kind::Leaf(first, end) => {
                for triangle in &self.triangles[first..end] {
                    let (place, feature) = nearest_on(&triangle.corners, point);
                    let way = point - place;
                    let square = way.dot(way);
                    if square <= best.0 {
                        let normal = match feature {
                            Feature::Inside => triangle.normal,
                            Feature::Edge(k) => triangle.of_edges[k],
                            Feature::Corner(k) => triangle.of_corners[k],
                        };
                        *best = (square, square.sqrt().copysign(way.dot(normal)));
                    }
                }
            }
            Kind::Branch(second) => {
                let mut halves = [node + 1, second].map(|half| (self.nodes[half].bound(point), half));
                halves.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
                for (bound, half) in halves {
                    if bound <= best.0 {
                        self.search(point, half, best);
                    }
                }
            }
        }
    }

    /// Signed distances on a grid around it, with a margin of some spacings on all sides.
    pub(crate) fn sample(&self, spacing: f64, margin: usize) -> Sampled {
        let [low, high] = self.extent();
        let shape = std::array::from_fn(|axis| {
            ((high[axis] - low[axis]) / spacing).ceil().max(1.0) as usize + 1 + 2 * margin
        });
        // What the last cell has too much is shared by both sides.
        let corner: [f64; 3] =
            std::array::from_fn(|axis| 0.5 * (low[axis] + high[axis] - (shape[axis] - 1) as f64 * spacing));
        let corner = Vector::from(corner);
        let mut values = Vec::with_capacity(shape.iter().product());
        for i in 0..shape[0] {
            for j in 0..shape[1] {
                // Distances change by no more than the way.
                let mut most = f64::INFINITY;
                for k in 0..shape[2] {
                    let beside = Vector::new(i as f64, j as f64, k as f64) * spacing;
                    let value = self.distance(corner + beside, most);
                    values.push(value);
                    most = (value.abs() + spacing) * (1.0 + WITHIN);
                }
            }
        }
        Sampled { values, shape, corner }
    }

    /// An edge that passes through a triangle with none of its ends, and where: its ends, the triangle's corners, and the place.
    pub(crate) fn intersection(
        &self,
        points: &[Vector<f64>],
    ) -> Option<([usize; 2], [usize; 3], Vector<f64>)> {
        self.triangles.iter().find_map(|triangle| {
            (0..3).find_map(|k| {
                let edge = [triangle.places[k], triangle.places[(k + 1) % 3]];
                // Each edge once.
                if edge[0] > edge[1] {
                    return None;
                }
                let ends = edge.map(|p| points[p]);
                let (other, place) = self.passed(0, edge, ends)?;
                Some((edge, self.triangles[other].places, place))
            })
        })
    }

    fn passed(&self, node: usize, edge: [usize; 2], ends: [Vector<f64>; 2]) -> Option<(usize, Vector<f64>)> {
        let Node { low, high, kind } = self.nodes[node];
        let [start, end] = ends.map(Vector::to_array);
        if (0..3).any(|i| start[i].max(end[i]) < low[i] || start[i].min(end[i]) > high[i]) {
            return None;
        }
        match kind {
            Kind::Branch(second) => {
                self.passed(node + 1, edge, ends).or_else(|| self.passed(second, edge, ends))
            }
            Kind::Leaf(first, last) => (first..last).find_map(|t| {
                let Triangle { corners, places, .. } = &self.triangles[t];
                if places.iter().any(|place| edge.contains(place)) {
                    return None;
                }
                crossing(ends, corners).map(|place| (t, place))
            }),
        }
    }
}

/// Where a segment passes through a triangle; none for a segment in its plane (Moeller and Trumbore 1997).
fn crossing([start, end]: [Vector<f64>; 2], &[a, b, c]: &[Vector<f64>; 3]) -> Option<Vector<f64>> {
    let (along, ab, ac) = (end - start, b - a, c - a);
    let across = along.cross(ac);
    let determinant = ab.dot(across);
    let scale = ab.cross(ac).dot(ab.cross(ac)).sqrt() * along.dot(along).sqrt();
    if determinant.abs() <= WITHIN * scale {
        return None;
    }
    let way = start - a;
    let u = way.dot(across) / determinant;
    let normal = way.cross(ab);
    let v = along.dot(normal) / determinant;
    let x = ac.dot(normal) / determinant;
    let is_within = u >= -WITHIN && v >= -WITHIN && u + v <= 1.0 + WITHIN;
    (is_within && (-WITHIN..=1.0 + WITHIN).contains(&x)).then(|| start + along * x)
}

/// Twice the area of a face along its normal.
pub(crate) fn across(points: &[Vector<f64>], &[a, b, c]: &[usize; 3]) -> Vector<f64> {
    (points[b] - points[a]).cross(points[c] - points[a])
}

fn unit(v: Vector<f64>) -> Vector<f64> {
    v * v.dot(v).sqrt().recip()
}

impl Node {
    /// Square of the distance of a point from the box.
    fn bound(&self, point: Vector<f64>) -> f64 {
        let at = point.to_array();
        (0..3).map(|i| (self.low[i] - at[i]).max(at[i] - self.high[i]).max(0.0).powi(2)).sum()
    }
}

/// Builds the tree over some triangles, divided in the middle along the longest axis.
fn enclose(triangles: &mut [Triangle], range: std::ops::Range<usize>, nodes: &mut Vec<Node>) {
    let part = &mut triangles[range.clone()];
    let corners = || part.iter().flat_map(|triangle| triangle.corners.map(Vector::to_array));
    let low = corners().fold([f64::INFINITY; 3], |low, at| std::array::from_fn(|i| low[i].min(at[i])));
    let high = corners().fold([f64::NEG_INFINITY; 3], |high, at| std::array::from_fn(|i| high[i].max(at[i])));
    let place = nodes.len();
    nodes.push(Node { low, high, kind: Kind::Leaf(range.start, range.end) });
    if part.len() <= LEAF {
        return;
    }
    let size = |axis: usize| high[axis] - low[axis];
    let axis = (1..3).fold(0, |best, axis| if size(axis) > size(best) { axis } else { best });
    let middle = |triangle: &Triangle| triangle.corners.iter().map(|at| at.to_array()[axis]).sum::<f64>();
    let half = part.len() / 2;
    part.select_nth_unstable_by(half, |a, b| middle(a).total_cmp(&middle(b)));
    enclose(triangles, range.start..range.start + half, nodes);
    nodes[place].kind = Kind::Branch(nodes.len());
    enclose(triangles, range.start + half..range.end, nodes);
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// A prism over an outline of six corners with a notch.
    fn notched() -> (Vec<Vector<f64>>, Vec<[usize; 3]>) {
        let outline = [[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [1.0, 1.0], [1.0, 2.0], [0.0, 2.0]];
        let points =
            [0.0, 0.7].into_iter().flat_map(|z| outline.map(|[x, y]| Vector::new(x, y, z))).collect();
        let caps = [[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 5]];
        let mut faces: Vec<[usize; 3]> = caps.iter().map(|&[a, b, c]| [a, c, b]).collect();
        faces.extend(caps.map(|cap| cap.map(|p| p + 6)));
        for p in 0..6 {
            let q = (p + 1) % 6;
            faces.extend([[p, q, q + 6], [p, q + 6, p + 6]]);
        }
        (points, faces)
    }

    /// Distance of the same prism from its outline: inside the union of two rectangles.
    fn expected([x, y, z]: [f64; 3]) -> f64 {
        let of_box = |[x, y]: [f64; 2], [width, height]: [f64; 2]| {
            let beyond = [(-x).max(x - width), (-y).max(y - height)];
            let outside = beyond[0].max(0.0).hypot(beyond[1].max(0.0));
            outside + beyond[0].max(beyond[1]).min(0.0)
        };
        let [first, second] = [[2.0, 1.0], [1.0, 2.0]].map(|size| of_box([x, y], size));
        let flat = if first.max(second) < 0.0 {
            // Within both, the notch is nearest at its corner.
            let notch = (1.0 - x).hypot(1.0 - y);
            -x.min(y).min(notch)
        } else {
            first.min(second)
        };
        let across = (-z).max(z - 0.7);
        flat.max(0.0).hypot(across.max(0.0)) + flat.max(across).min(0.0)
    }

    proptest! {
        #[test]
        fn distances_of_a_notched_prism(x in -1.0..3.0, y in -1.0..3.0, z in -1.0..1.7) {
            let (points, faces) = notched();
            let prism = Triangles::new(&points, &faces);
            prop_assert!(prism.intersection(&points).is_none());
            let found = prism.distance(Vector::new(x, y, z), f64::INFINITY);
            prop_assert!((found - expected([x, y, z])).abs() < 1e-12, "{found} {}", expected([x, y, z]));
        }
    }

    #[test]
    fn values_on_a_grid_are_distances() {
        let (points, faces) = notched();
        let Sampled { values, shape, corner } = Triangles::new(&points, &faces).sample(0.15, 2);
        assert_eq!(shape, [19, 19, 10]);
        for (n, value) in values.into_iter().enumerate() {
            let place = [n / (shape[1] * shape[2]), n / shape[2] % shape[1], n % shape[2]].map(|i| i as f64);
            let at = corner + Vector::from(place) * 0.15;
            assert!((value - expected(at.to_array())).abs() < 1e-12, "{at:?} {value}");
        }
    }
}
