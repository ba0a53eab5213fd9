//! Signed distances of points from surfaces, and their derivatives.

use crate::numerics::lie::{Symmetric, Vector};

/// Signed distance of a point from a surface: negative inside.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Distance {
    pub(crate) value: f64,
    /// Gradient: a unit vector away from the surface.
    pub(crate) normal: Vector<f64>,
    /// Second derivative.
    pub(crate) curvature: Symmetric<f64>,
}

/// Points closer than this to a centre or an edge, in metres, have no direction from it.
pub(crate) const SHORTEST: f64 = 1e-14;

impl Distance {
    /// Distance from the surface of a body that is larger by `grown` on all sides.
    pub(crate) fn beyond(self, grown: f64) -> Self {
        Self { value: self.value - grown, ..self }
    }

    /// Distance from a ball whose centre is at `-way` relative to the point.
    pub(crate) fn from_centre(way: Vector<f64>, radius: f64) -> Self {
        Self::from_curve(way, radius, None)
    }

    /// Distance from a tube around a curve, where `way` points from the nearest point of the curve. `along`
    /// contains the direction of the curve there, and one minus the product of way and curvature; without
    /// `along`, distance from a ball at the end.
    pub(crate) fn from_curve(way: Vector<f64>, radius: f64, along: Option<(Vector<f64>, f64)>) -> Self {
        let length = way.dot(way).sqrt();
        let inverse = if length > SHORTEST { length.recip() } else { 0.0 };
        // A point on the axis has no direction: push upwards.
        let normal = if length > SHORTEST { way * inverse } else { Vector::new(0.0, 0.0, 1.0) };
        let mut curvature = Symmetric::diagonal(1.0) - Symmetric::square(normal);
        // The nearest point moves along the curve.
        if let Some((along, stretch)) = along {
            curvature = curvature - Symmetric::square(along) * stretch.recip();
        }
        Self { value: length - radius, normal, curvature: curvature * inverse }
    }
}

/// Distance of two points.
pub(crate) fn between(a: Vector<f64>, b: Vector<f64>) -> f64 {
    let way = a - b;
    way.dot(way).sqrt()
}

/// A quotient clamped to [0, 1]; 0 for 0 / 0.
fn clamped(value: f64, over: f64) -> f64 {
    if over > 0.0 { (value / over).clamp(0.0, 1.0) } else { 0.0 }
}

/// Distance between a point and a segment.
pub(crate) fn to_segment(point: Vector<f64>, [p, end]: [Vector<f64>; 2]) -> f64 {
    let along = end - p;
    let x = clamped((point - p).dot(along), along.dot(along));
    between(point, p + along * x)
}

/// Distance between two segments.
pub(crate) fn of_segments(first: [Vector<f64>; 2], second: [Vector<f64>; 2]) -> f64 {
    let [x, y] = nearest_of_segments(first, second);
    let on = |[from, to]: [Vector<f64>; 2], x: f64| from + (to - from) * x;
    between(on(first, x), on(second, y))
}

/// At which fractions of two segments these are nearest to each other (Ericson 2005, section 5.1.9).
pub(crate) fn nearest_of_segments([p, p_end]: [Vector<f64>; 2], [q, q_end]: [Vector<f64>; 2]) -> [f64; 2] {
    let (along, other, way) = (p_end - p, q_end - q, p - q);
    let (a, e, f) = (along.dot(along), other.dot(other), other.dot(way));
    let (b, c) = (along.dot(other), along.dot(way));
    let determinant = a * e - b * b;
    let x = clamped(b * f - c * e, determinant);
    let y = clamped(b * x + f, e);
    // After clamping, recompute the point on the first segment.
    [clamped(b * y - c, a), y]
}
