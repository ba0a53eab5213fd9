//! Distances of points from what can be touched, and how they change as the points move.

use crate::lie::{Rotation, Symmetric, Vector};

/// What can be touched, in space and the frame of the plan.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Solid {
    HalfSpace {
        point: Vector<f64>,
        normal: Vector<f64>,
    },
    /// Points at most that far from a centre, or from the line between two ends.
    Ball {
        centre: Vector<f64>,
        radius: f64,
    },
    Capsule {
        ends: [Vector<f64>; 2],
        radius: f64,
    },
    Cuboid {
        centre: Vector<f64>,
        axes: Rotation<f64>,
        half_extents: Vector<f64>,
    },
}

/// How far a point is from a surface: negative inside.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Distance {
    pub(crate) value: f64,
    /// Its gradient, a unit vector away from the surface.
    pub(crate) normal: Vector<f64>,
    /// Its second derivative.
    pub(crate) curvature: Symmetric<f64>,
}

/// Points that are nearer to a centre or an edge are not seen in any direction: metres.
const SHORTEST: f64 = 1e-14;

impl Distance {
    /// From a ball whose centre is seen along `way`.
    fn from_centre(way: Vector<f64>, radius: f64) -> Self {
        Self::from_curve(way, radius, None)
    }

    /// From a tube around a curve, of which the nearest place is seen along `way`: with the direction of the curve there, and
    /// one less the way times its curvature; from a ball at its end without.
    pub(crate) fn from_curve(way: Vector<f64>, radius: f64, along: Option<(Vector<f64>, f64)>) -> Self {
        let length = way.dot(way).sqrt();
        let inverse = if length > SHORTEST { length.recip() } else { 0.0 };
        // A point in the middle is pushed somewhere: up.
        let normal = if length > SHORTEST { way * inverse } else { Vector::new(0.0, 0.0, 1.0) };
        let mut curvature = Symmetric::diagonal(1.0) - Symmetric::square(normal);
        // The nearest place follows.
        if let Some((along, stretch)) = along {
            curvature = curvature - Symmetric::square(along) * stretch.recip();
        }
        Self { value: length - radius, normal, curvature: curvature * inverse }
    }
}

impl Solid {
    /// How far a point is from it.
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
            Self::Cuboid { centre, axes, half_extents } => {
                let beside = axes.apply_transposed(point - *centre).to_array();
                cuboid(beside, half_extents.to_array(), axes)
            }
        }
    }
}

/// The distance of a point beside the centre of a box with these axes: from its nearest face inside; from the nearest
/// face, edge or corner outside.
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lie::Quaternion;

    /// Gradient and second derivative of all distances against differences.
    #[test]
    fn distances_change_as_they_say() {
        let turned = Quaternion::from_array([0.8, 0.36, -0.48, 0.0]).rotation();
        let v = |x, y, z| Vector::new(x, y, z);
        let solids = [
            Solid::HalfSpace { point: v(0.1, 0.2, 0.3), normal: v(0.6, 0.0, 0.8) },
            Solid::Ball { centre: v(0.1, 0.0, -0.2), radius: 0.3 },
            Solid::Capsule { ends: [v(0.0, 0.0, 0.0), v(0.5, 0.1, 0.0)], radius: 0.1 },
            Solid::Cuboid { centre: v(0.0, 0.1, 0.0), axes: turned, half_extents: v(0.2, 0.3, 0.1) },
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
        for solid in solids {
            for point in points {
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
    }
}
