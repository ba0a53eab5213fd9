//! Motion along a tube's axis of the place that is nearest to a point.
//!
//! A tube is the union of the balls with radii r about the places y of its axis. Nearest to a point x is the ball for which `|w| - r`
//! is smallest, with `w = x - y`: there `w . y' = -|w| r'`, with derivatives along a fraction of the axis. By differentiation, that place
//! slides by
//!
//! ```text
//! (|y'|^2 - w . y'' - r'^2) dxi = (y' + r' n) . (dx - dy) + w . dy',   n = w / |w|
//! ```
//!
//! for a displacement dx of the point and a change of the axis by dy and of its slope by dy' at a fixed fraction.

use super::distance::SHORTEST;
use crate::numerics::lie::Vector;

/// A place lies inside a part of the axis, and is not its end, if the residual of the condition above, a cosine, is smaller than this.
pub(crate) const AT_RIGHT_ANGLE: f64 = 1e-6;

/// Beyond the centre of curvature of the axis no place is nearest: the distance from it is limited to at least this part of the radius of
/// curvature.
const LEAST_STRETCH: f64 = 0.1;

/// A nearest place that is not an end.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Slide {
    /// `(y' + r' n) / |y'|`: perpendicular to the normal.
    pub(crate) across: Vector<f64>,
    /// The factor of dxi over `|y'|^2`.
    pub(crate) stretch: f64,
    /// dxi for unit displacements of the point, and for unit rotations of the axis about the place.
    pub(crate) of_way: Vector<f64>,
    pub(crate) of_turn: Vector<f64>,
    /// dxi for unit changes of the slope.
    pub(crate) of_slope: Vector<f64>,
}

impl Slide {
    /// From the vector `way` from the nearest place to the point, slope and second derivative of the axis, and the slope of the
    /// radius; `None` at an end.
    pub(crate) fn new(way: Vector<f64>, [slope, bend]: [Vector<f64>; 2], widening: f64) -> Option<Self> {
        let square = slope.dot(slope).max(f64::MIN_POSITIVE);
        let length = way.dot(way).sqrt();
        if (slope.dot(way) + widening * length).abs() > AT_RIGHT_ANGLE * square.sqrt() * length {
            return None;
        }
        let stretch = (1.0 - (way.dot(bend) + widening * widening) / square).max(LEAST_STRETCH);
        let tilt = if length > SHORTEST { widening / length } else { 0.0 };
        let across = slope + way * tilt;
        let inverse = (square * stretch).recip();
        Some(Self {
            across: across * square.sqrt().recip(),
            stretch,
            of_way: across * inverse,
            of_turn: slope.cross(way) * inverse,
            of_slope: way * inverse,
        })
    }
}
