//! How far points are from surfaces, and how that changes as they move.

use crate::lie::{Symmetric, Vector};

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
pub(crate) const SHORTEST: f64 = 1e-14;

impl Distance {
    /// From a ball whose centre is seen along `way`.
    pub(crate) fn from_centre(way: Vector<f64>, radius: f64) -> Self {
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
