//! Distances of points from solids, and their derivatives.
//!
//! A moving solid is stored in its own axes: points are transformed to these axes, and distances, normals and
//! curvatures back.

use std::sync::Arc;

use super::convex_mesh::ConvexMesh;
use super::distance::{Distance, SHORTEST};
use super::distance_grid::DistanceGrid;
use super::height_field::HeightField;
use super::tube::Tube;
use crate::numerics::lie::{Geometry as _, Rotation, Spatial, Symmetric, Vector};

/// A solid, in the axes in which it is fixed.
#[derive(Clone, Debug)]
pub(crate) enum Solid {
    HalfSpace {
        point: Vector<f64>,
        normal: Vector<f64>,
    },
    /// Points within a radius of a centre, or of the segment between two ends.
    Ball {
        centre: Vector<f64>,
        radius: f64,
    },
    Capsule {
        ends: [Vector<f64>; 2],
        radius: f64,
    },
    /// Points within a radius of a box with sharp edges.
    Cuboid {
        centre: Vector<f64>,
        axes: Rotation<f64>,
        half_extents: Vector<f64>,
        radius: f64,
    },
    /// A height field, shared between copies of a plan.
    HeightField(Arc<HeightField>),
    /// A rounded convex mesh, shared between copies of a plan.
    ConvexMesh(Arc<ConvexMesh>),
    /// The wall of a tube, shared between copies of a plan.
    Tube(Arc<Tube>),
    /// A shape by distances on a grid, shared between copies of a plan.
    DistanceGrid(Arc<DistanceGrid>),
}

impl Solid {
    /// Distance of a point from the solid.
    pub(crate) fn distance(&self, point: Vector<f64>) -> Distance {
        match self {
            Self::HalfSpace { point: on, normal } => Distance {
                value: normal.dot(point - *on),
                normal: *normal,
                curvature: Symmetric::diagonal(0.0),
            },
            Self::Ball { centre, radius } => Distance::from_centre(point - *centre, *radius),
            Self::Capsule { ends: [start, end], radius } => {
                let way = *end - *start;
                let length = way.dot(way).sqrt();
                let along = way * length.recip();
                let x = along.dot(point - *start);
                if x <= 0.0 {
                    Distance::from_centre(point - *start, *radius)
                } else if x >= length {
                    Distance::from_centre(point - *end, *radius)
                } else {
                    Distance::from_curve(point - (*start + along * x), *radius, Some((along, 1.0)))
                }
            }
            Self::Cuboid { centre, axes, half_extents, radius } => {
                let beside = axes.apply_transposed(point - *centre).to_array();
                let sharp = cuboid(beside, half_extents.to_array(), axes);
                Distance { value: sharp.value - radius, ..sharp }
            }
            Self::HeightField(field) => field.distance(point),
            Self::ConvexMesh(mesh) => mesh.distance(point),
            Self::Tube(tube) => tube.distance(point),
            Self::DistanceGrid(grid) => grid.distance(point),
        }
    }
}

impl Solid {
    /// Whether a point is certainly farther from the solid than `reach`, by a bound that costs less than the distance; never for solids whose
    /// distance costs little.
    pub(crate) fn is_certainly_beyond(&self, point: Vector<f64>, reach: f64) -> bool {
        match self {
            Self::HeightField(field) => field.is_certainly_beyond(point, reach),
            Self::ConvexMesh(mesh) => mesh.is_certainly_beyond(point, reach),
            Self::Tube(tube) => tube.is_certainly_beyond(point, reach),
            Self::DistanceGrid(grid) => grid.is_certainly_beyond(point, reach),
            _ => false,
        }
    }

    /// Whether a point is farther from the solid than `reach`.
    pub(crate) fn is_beyond(&self, point: Vector<f64>, reach: f64) -> bool {
        self.is_certainly_beyond(point, reach) || self.distance(point).value > reach
    }

    /// By how much a point is farther from the solid than `reach`, or less than that; not positive if it is not farther.
    pub(crate) fn gap(&self, point: Vector<f64>, reach: f64) -> f64 {
        /// Largest number of times that a distance is doubled that is certainly not reached.
        const MOST_DOUBLINGS: usize = 20;
        if reach <= 0.0 || !self.is_certainly_beyond(point, reach) {
            return self.distance(point).value - reach;
        }
        let mut certain = reach;
        for _ in 0..MOST_DOUBLINGS {
            if !self.is_certainly_beyond(point, 2.0 * certain) {
                break;
            }
            certain *= 2.0;
        }
        if certain > reach { certain - reach } else { self.distance(point).value - reach }
    }

    /// Largest distance from the origin of its axes.
    pub(crate) fn reach(&self) -> f64 {
        let size = |v: Vector<f64>| v.dot(v).sqrt();
        match self {
            Self::HalfSpace { .. } | Self::HeightField(_) => f64::INFINITY,
            Self::Ball { centre, radius } => size(*centre) + radius,
            Self::Capsule { ends, radius } => ends.iter().map(|end| size(*end)).fold(0.0, f64::max) + radius,
            Self::Cuboid { centre, half_extents, radius, .. } => size(*centre) + size(*half_extents) + radius,
            Self::ConvexMesh(mesh) => mesh.reach(),
            Self::Tube(tube) => tube.reach(),
            Self::DistanceGrid(grid) => grid.reach(),
        }
    }

    /// Depth of its middle below the surface: zero where there is none between two sides.
    pub(crate) fn depth(&self) -> f64 {
        match self {
            Self::HalfSpace { .. } | Self::HeightField(_) => 0.0,
            Self::Ball { radius, .. } | Self::Capsule { radius, .. } => *radius,
            Self::Cuboid { half_extents, radius, .. } => {
                half_extents.to_array().into_iter().fold(f64::INFINITY, f64::min) + radius
            }
            Self::ConvexMesh(mesh) => mesh.depth(),
            Self::Tube(tube) => tube.deepest(),
            Self::DistanceGrid(grid) => grid.depth(),
        }
    }

    /// Upper bound of the concave curvature of its surface, per metre; zero for a convex solid. For a tube, the curvature along it.
    pub(crate) fn hollowness(&self) -> f64 {
        match self {
            Self::HeightField(field) => field.most_bent(),
            Self::Tube(tube) => tube.most_bent(),
            Self::DistanceGrid(grid) => grid.hollowness(),
            _ => 0.0,
        }
    }

    /// Whether second derivatives of the distance jump between features of the solid.
    pub(crate) fn has_features(&self) -> bool {
        matches!(self, Self::Capsule { .. } | Self::Cuboid { .. } | Self::ConvexMesh(_) | Self::Tube(_))
    }

    /// Whether it has flat faces with edges between them.
    pub(crate) fn has_faces(&self) -> bool {
        matches!(self, Self::Cuboid { .. } | Self::ConvexMesh(_))
    }

    /// Whether others can pass through it to another side; not a half-space.
    pub(crate) fn can_be_passed(&self) -> bool {
        !matches!(self, Self::HalfSpace { .. })
    }

    /// The feature nearest to a point, identified by three numbers.
    pub(crate) fn feature(&self, point: Vector<f64>) -> [usize; 3] {
        match self {
            Self::HalfSpace { .. } | Self::Ball { .. } | Self::HeightField(_) | Self::DistanceGrid(_) => {
                [0; 3]
            }
            Self::Capsule { ends: [start, end], .. } => {
                let way = *end - *start;
                let x = way.dot(point - *start);
                [usize::from(x > 0.0), usize::from(x >= way.dot(way)), 0]
            }
            Self::Cuboid { centre, axes, half_extents, .. } => {
                let beside = axes.apply_transposed(point - *centre).to_array();
                let half = half_extents.to_array();
                let side = |i: usize| if beside[i] < 0.0 { 1 } else { 2 };
                let beyond: [f64; 3] = std::array::from_fn(|i| beside[i].abs() - half[i]);
                if beyond.iter().any(|&x| x > 0.0) {
                    return std::array::from_fn(|i| if beyond[i] > 0.0 { side(i) } else { 0 });
                }
                let nearest = (0..3).fold(0, |best, i| if beyond[i] > beyond[best] { i } else { best });
                std::array::from_fn(|i| if i == nearest { side(i) } else { 0 })
            }
            Self::ConvexMesh(mesh) => mesh.feature(point),
            Self::Tube(tube) => tube.feature(point),
        }
    }
}

/// Distance of a point, relative to the centre of a box with these axes: from the nearest face inside; from
/// the nearest face, edge or corner outside.
fn cuboid(point: [f64; 3], half: [f64; 3], axes: &Rotation<f64>) -> Distance {
    let beyond: [f64; 3] = std::array::from_fn(|i| point[i].abs() - half[i]);
    let side = |i: usize| axes.axis(i) * if point[i] < 0.0 { -1.0 } else { 1.0 };
    let outside: [f64; 3] = beyond.map(|x| x.max(0.0));
    let length = outside.iter().map(|x| x * x).sum::<f64>().sqrt();
    if length <= SHORTEST {
        let i = (0..3).fold(0, |best, i| if beyond[i] > beyond[best] { i } else { best });
        return Distance { value: beyond[i], normal: side(i), curvature: Symmetric::diagonal(0.0) };
    }
    let mut normal = Vector::zero();
    let mut curvature = Symmetric::diagonal(0.0);
    for (i, &x) in outside.iter().enumerate() {
        normal = normal.add_scaled(side(i), x / length);
        if x > 0.0 {
            curvature += Symmetric::square(axes.axis(i));
        }
    }
    Distance { value: length, normal, curvature: (curvature - Symmetric::square(normal)) * length.recip() }
}

/// Pose of the axes in which a solid is fixed.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Pose {
    pub(crate) rotation: Rotation<f64>,
    pub(crate) position: Vector<f64>,
}

impl Pose {
    pub(crate) fn unmoved() -> Self {
        Self { rotation: Rotation::identity(), position: Vector::zero() }
    }

    /// Transforms a point from these axes.
    pub(crate) fn place(&self, point: Vector<f64>) -> Vector<f64> {
        self.position + self.rotation.apply(point)
    }

    /// Transforms a point to these axes.
    pub(crate) fn local_position(&self, point: Vector<f64>) -> Vector<f64> {
        self.rotation.apply_transposed(point - self.position)
    }
}

/// A solid at its current pose, in space and the frame of the plan.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Placed<'a> {
    pub(crate) solid: &'a Solid,
    /// Pose of its axes; `None` if they are the axes of the frame.
    pub(crate) pose: Option<&'a Pose>,
}

impl Placed<'_> {
    /// Distance of a point from the solid.
    pub(crate) fn distance(&self, point: Vector<f64>) -> Distance {
        let Some(pose) = self.pose else { return self.solid.distance(point) };
        let Distance { value, normal, curvature } = self.solid.distance(pose.local_position(point));
        Distance {
            value,
            normal: pose.rotation.apply(normal),
            curvature: Spatial::<false>::rotate_second_moment(&pose.rotation, &curvature),
        }
    }

    /// See [`Solid::is_certainly_beyond`].
    pub(crate) fn is_certainly_beyond(&self, point: Vector<f64>, reach: f64) -> bool {
        self.solid.is_certainly_beyond(self.local_position(point), reach)
    }

    /// See [`Solid::is_beyond`].
    pub(crate) fn is_beyond(&self, point: Vector<f64>, reach: f64) -> bool {
        self.solid.is_beyond(self.local_position(point), reach)
    }

    /// See [`Solid::feature`].
    pub(crate) fn feature(&self, point: Vector<f64>) -> [usize; 3] {
        self.solid.feature(self.pose.map_or(point, |pose| pose.local_position(point)))
    }

    /// The tube, in whose bore others may be; `None` for other solids.
    pub(crate) fn tube(&self) -> Option<&Tube> {
        if let Solid::Tube(tube) = self.solid { Some(tube) } else { None }
    }

    /// A point in the axes in which it is fixed.
    pub(crate) fn local_position(&self, point: Vector<f64>) -> Vector<f64> {
        self.pose.map_or(point, |pose| pose.local_position(point))
    }

    /// A direction in these axes.
    pub(crate) fn local_direction(&self, direction: Vector<f64>) -> Vector<f64> {
        self.pose.map_or(direction, |pose| pose.rotation.apply_transposed(direction))
    }

    /// Radius of a body that is round everywhere; zero for others.
    pub(crate) fn round(&self) -> f64 {
        if let Solid::Ball { radius, .. } = self.solid { *radius } else { 0.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numerics::lie::Quaternion;
    use proptest::prelude::*;

    /// Gradients and second derivatives of all distances agree with finite differences.
    #[test]
    fn distances_change_as_they_say() {
        let turned = Quaternion::from_array([0.8, 0.36, -0.48, 0.0]).rotation();
        let v = |x, y, z| Vector::new(x, y, z);
        let solids = [
            Solid::HalfSpace { point: v(0.1, 0.2, 0.3), normal: v(0.6, 0.0, 0.8) },
            Solid::Ball { centre: v(0.1, 0.0, -0.2), radius: 0.3 },
            Solid::Capsule { ends: [v(0.0, 0.0, 0.0), v(0.5, 0.1, 0.0)], radius: 0.1 },
            Solid::Cuboid {
                centre: v(0.0, 0.1, 0.0),
                axes: turned,
                half_extents: v(0.2, 0.3, 0.1),
                radius: 0.02,
            },
        ];
        let points = [
            v(0.3, 0.4, 0.5),
            v(-0.5, 0.1, 0.2),
            v(0.2, 0.05, 0.3),
            v(0.02, 0.12, 0.03),
            v(1.0, -0.7, 0.2),
            v(0.1, -0.6, -0.05),
            v(0.9, 0.3, 0.1),
            v(0.05, 0.3, -0.4),
        ];
        let h = 1e-5;
        let pose = Pose {
            rotation: Quaternion::from_array([0.6, 0.0, 0.64, -0.48]).rotation(),
            position: v(0.2, -0.1, 0.05),
        };
        let places = solids.iter().flat_map(|solid| points.map(|point| (solid, point)));
        for ((solid, point), pose) in places.flat_map(|place| [(place, None), (place, Some(&pose))]) {
            let solid = Placed { solid, pose };
            let Distance { normal, curvature, .. } = solid.distance(point);
            assert!((normal.dot(normal) - 1.0).abs() < 1e-12);
            for axis in [v(1.0, 0.0, 0.0), v(0.0, 1.0, 0.0), v(0.0, 0.0, 1.0)] {
                let [ahead, behind] = [h, -h].map(|h| solid.distance(point + axis * h));
                let slope = (ahead.value - behind.value) / (2.0 * h);
                assert!((slope - normal.dot(axis)).abs() < 1e-9, "{solid:?} {point:?}");
                let change = (ahead.normal - behind.normal) * (0.5 / h) - curvature.times(axis);
                assert!(change.dot(change).sqrt() < 1e-7, "{solid:?} {point:?} {change:?}");
            }
        }
    }

    #[test]
    fn faces_go_inwards_and_flat_ones_have_no_edges() {
        let (mesh, points) = (block(), corners());
        assert_eq!(mesh.edges().len(), 12);
        for (inset, corner) in mesh.inset(&points, 0.01).into_iter().zip(points) {
            for (inset, corner) in inset.to_array().into_iter().zip(corner.to_array()) {
                assert!((inset - (corner - 0.01 * corner.signum())).abs() < 1e-9);
            }
        }
    }

    fn corners() -> Vec<Vector<f64>> {
        (0..8)
            .map(|k| {
                Vector::new(
                    if k & 4 > 0 { 0.2 } else { -0.2 },
                    if k & 2 > 0 { 0.3 } else { -0.3 },
                    if k & 1 > 0 { 0.1 } else { -0.1 },
                )
            })
            .collect()
    }

    fn block() -> ConvexMesh {
        let faces = [
            [0, 1, 3],
            [0, 3, 2],
            [4, 5, 7],
            [4, 7, 6],
            [0, 1, 5],
            [0, 5, 4],
            [2, 3, 7],
            [2, 7, 6],
            [0, 2, 6],
            [0, 6, 4],
            [1, 3, 7],
            [1, 7, 5],
        ];
        ConvexMesh::new(&corners(), &faces, 0.05)
    }

    proptest! {
        /// A block of triangles has the same distances as a box.
        #[test]
        fn blocks_are_boxes((x, y, z) in (-0.5..0.5, -0.5..0.5, -0.5..0.5)) {
            let v = Vector::new;
            let axes = Rotation { x: v(1.0, 0.0, 0.0), y: v(0.0, 1.0, 0.0), z: v(0.0, 0.0, 1.0) };
            let half_extents = v(0.2, 0.3, 0.1);
            let wanted = Solid::Cuboid { centre: Vector::zero(), axes, half_extents, radius: 0.0 };
            let (found, wanted) = (block().distance(v(x, y, z)), wanted.distance(v(x, y, z)));
            prop_assert!((found.value + 0.05 - wanted.value).abs() < 1e-12);
            if wanted.value > 1e-6 {
                let change = found.normal - wanted.normal;
                prop_assert!(change.dot(change).sqrt() < 1e-9);
                for (a, b) in found.curvature.rows().into_iter().zip(wanted.curvature.rows()) {
                    prop_assert!((a - b).dot(a - b).sqrt() < 1e-6 / wanted.value);
                }
            }
        }
    }
}
