//! Distance of a point from a tube with elliptic sections.
//!
//! A section is perpendicular to the tube's axis at the axis' nearest point. The distance is that from the
//! section's ellipse. As the point moves along the tube, sections rotate and taper; the gradient includes
//! this change.

use super::distance::Distance;
use crate::numerics::lie::{Symmetric, Vector};

/// Maximum number of Newton steps for the nearest point of an ellipse. The iteration converges monotonically,
/// and finally quadratically.
const MOST_STEPS: usize = 60;

/// Steps below this fraction of the root are rounding.
const ROUNDING: f64 = 1e-15;

/// A section of a tube: its centre, the direction of the axis, and its semi-axes, which are perpendicular to
/// the axis and to each other.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Section {
    pub(crate) centre: Vector<f64>,
    pub(crate) along: Vector<f64>,
    pub(crate) semi_axes: [Vector<f64>; 2],
}

/// Continuation of a tube at a section that is not its end.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Continuation {
    /// Second derivative of the axis with respect to arc length.
    pub(crate) bend: Vector<f64>,
    /// Semi-axes of the section at this distance along the axis.
    pub(crate) beyond: [Vector<f64>; 2],
    pub(crate) step: f64,
}

/// Signed distance of a point from an ellipse about the origin in its plane, its gradient, and the curvature
/// of the ellipse at the nearest point.
#[derive(Clone, Copy, Debug)]
struct FromEllipse {
    value: f64,
    normal: [f64; 2],
    curvature: f64,
}

/// Distance of a point with these coordinates along the semi-axes.
///
/// With the nearest point `(a^2 u / (t + a^2), b^2 v / (t + b^2))` the equation of the ellipse becomes an
/// equation for t with a convex, decreasing function (Eberly 2013, "Distance from a point to an ellipse",
/// section 2.2).
fn from_ellipse([a, b]: [f64; 2], [u, v]: [f64; 2]) -> FromEllipse {
    if a < b {
        let FromEllipse { value, normal: [y, x], curvature } = from_ellipse([b, a], [v, u]);
        return FromEllipse { value, normal: [x, y], curvature };
    }
    let (x, y) = (u.abs(), v.abs());
    let (square_a, square_b) = (a * a, b * b);
    let is_on_axis = y <= f64::EPSILON * b;
    let [cosine, sine] = if is_on_axis && a * x < square_a - square_b {
        // On the long axis between the centres of curvature of its ends, two points are equally near.
        let cosine = a * x / (square_a - square_b);
        [cosine, (1.0 - cosine * cosine).max(0.0).sqrt()]
    } else {
        let mut t = (b * y - square_b).max(a * x - square_a);
        for _ in 0..MOST_STEPS {
            let (p, q) = (a * x / (t + square_a), b * y / (t + square_b));
            let excess = p * p + q * q - 1.0;
            let slope = p * p / (t + square_a) + q * q / (t + square_b);
            let step = 0.5 * excess / slope;
            if step.is_nan() || step <= ROUNDING * square_b {
                break;
            }
            t += step;
        }
        let (p, q) = (a * x / (t + square_a), b * y / (t + square_b));
        let size = p.hypot(q);
        if size > 0.0 { [p / size, q / size] } else { [0.0, 1.0] }
    };
    let (across, over) = (b * cosine, a * sine);
    let size = across.hypot(over);
    let normal = [across / size, over / size];
    let value = (x - a * cosine) * normal[0] + (y - b * sine) * normal[1];
    let curvature = a * b / (size * size * size);
    FromEllipse { value, normal: [normal[0].copysign(u), normal[1].copysign(v)], curvature }
}

/// Distance of a point from a tube with this section at the nearest point of the axis; without a continuation, from
/// a rounded cap at the end.
pub(crate) fn distance(
    point: Vector<f64>,
    section: &Section,
    continuation: Option<&Continuation>,
) -> Distance {
    let Section { centre, along, semi_axes } = *section;
    let way = point - centre;
    let lengths = semi_axes.map(|axis| axis.dot(axis).sqrt());
    let units = [0, 1].map(|i| semi_axes[i] * lengths[i].recip());
    let FromEllipse { value, normal: [x, y], curvature } = from_ellipse(lengths, units.map(|e| e.dot(way)));
    let outwards = units[0] * x + units[1] * y;
    let tangent = units[1] * x - units[0] * y;
    let bent = curvature / (1.0 + curvature * value).max(f64::EPSILON);
    let around = Symmetric::square(tangent) * bent;
    let Some(Continuation { bend, beyond, step }) = continuation else {
        // The cap is rounded with the smaller semi-axis, around an ellipse that is narrower by the same
        // amount.
        let radius = lengths[0].min(lengths[1]);
        let outside = (value + radius).max(0.0);
        let height = along.dot(way);
        let from_rim =
            Distance::from_curve(outwards * outside + along * height, radius, Some((tangent, 1.0)));
        let share = from_rim.normal.dot(outwards);
        return Distance { curvature: from_rim.curvature + around * share, ..from_rim };
    };
    let stretch = (1.0 - way.dot(*bend)).max(0.1);
    // Relative to the fixed point, the next sections are rotated and scaled.
    let there = beyond.map(|axis| axis.dot(axis).sqrt());
    let seen = [0, 1].map(|i| beyond[i].dot(way) / there[i]);
    let slope = (from_ellipse(there, seen).value - value) / (step * stretch);
    let gradient = outwards + along * slope;
    let inverse = gradient.dot(gradient).sqrt().recip();
    let curvature = around - Symmetric::square(along) * (outwards.dot(*bend) / stretch);
    Distance { value: value * inverse, normal: gradient * inverse, curvature }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn v((x, y, z): (f64, f64, f64)) -> Vector<f64> {
        Vector::new(x, y, z)
    }

    proptest! {
        /// No point of the ellipse is nearer, and distances inside are negative.
        #[test]
        fn ellipses_are_as_far_as_their_nearest_places(
            (a, b) in (0.1..2.0, 0.1..2.0),
            (u, v) in (-3.0..3.0, -3.0..3.0),
        ) {
            let found = from_ellipse([a, b], [u, v]);
            let places = (0..20_000).map(|k| {
                let (sine, cosine) = (f64::from(k) * std::f64::consts::TAU / 20_000.0).sin_cos();
                (u - a * cosine).hypot(v - b * sine)
            });
            let nearest = places.fold(f64::INFINITY, f64::min);
            let is_inside = (u / a).powi(2) + (v / b).powi(2) < 1.0;
            let signed = if is_inside { -nearest } else { nearest };
            prop_assert!((found.value - signed).abs() < 1e-3, "{found:?} {signed}");
            // Corners of the polygon lie on the ellipse: they are never nearer.
            prop_assert!(found.value.abs() <= nearest + 1e-12);
        }

        /// Tubes with circular sections agree with tubes of constant radius.
        #[test]
        fn circles(way in (-1.0..1.0, -1.0..1.0, -1.0..1.0), bend in (-0.2..0.2, -0.2..0.2)) {
            let way = v(way);
            prop_assume!(way.dot(way) > 0.01);
            let along = Vector::new(1.0, 0.0, 0.0);
            let semi_axes = [Vector::new(0.0, 0.3, 0.0), Vector::new(0.0, 0.0, 0.3)];
            let section = Section { centre: Vector::zero(), along, semi_axes };
            let at_end = (distance(way, &section, None), Distance::from_curve(way, 0.3, None));
            let beside = Vector::new(0.0, way.y, way.z);
            prop_assume!(beside.dot(beside) > 0.01);
            let bend = Vector::new(0.0, bend.0, bend.1);
            let continuation = Continuation { bend, beyond: semi_axes, step: 1e-3 };
            let seen = Some((along, 1.0 - beside.dot(bend)));
            let inside = (distance(beside, &section, Some(&continuation)), Distance::from_curve(beside, 0.3, seen));
            for (found, known) in [at_end, inside] {
                prop_assert!((found.value - known.value).abs() < 1e-12);
                prop_assert!((found.normal - known.normal).dot(found.normal - known.normal) < 1e-20);
                for (row, known) in found.curvature.rows().into_iter().zip(known.curvature.rows()) {
                    let difference = row - known;
                    prop_assert!(difference.dot(difference) < 1e-18, "{found:?}");
                }
            }
        }

        /// Along a straight twisted and tapered tube, the gradient is that of the value, to first order in
        /// the slope.
        #[test]
        fn gradients_are_those_of_values(
            place in (-0.2..0.2, -1.0..1.0, -1.0..1.0),
            (a, b) in (0.1..0.5, 0.1..0.5),
            twist in -0.3..0.3_f64,
        ) {
            let section = |x: f64| {
                let (sine, cosine) = f64::sin_cos(twist * x);
                let widths = [a * (1.0 + 0.1 * x), b * (1.0 - 0.05 * x)];
                [Vector::new(0.0, cosine, sine) * widths[0], Vector::new(0.0, -sine, cosine) * widths[1]]
            };
            let along = Vector::new(1.0, 0.0, 0.0);
            let at = |point: Vector<f64>| {
                let centre = Vector::new(point.x, 0.0, 0.0);
                let continuation = Continuation { bend: Vector::zero(), beyond: section(point.x + 1e-6), step: 1e-6 };
                distance(point, &Section { centre, along, semi_axes: section(point.x) }, Some(&continuation))
            };
            let point = v(place);
            let here = at(point);
            prop_assume!(here.value > 0.02);
            let h = 1e-6;
            for axis in [(1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)].map(v) {
                let [ahead, behind] = [h, -h].map(|h| at(point + axis * h));
                let rate = (ahead.value - behind.value) * (0.5 / h);
                prop_assert!((rate - here.normal.dot(axis)).abs() < 0.1, "{rate} {here:?}");
                if axis.x == 0.0 && twist.abs() < 1e-3 {
                    let change = (ahead.normal - behind.normal) * (0.5 / h) - here.curvature.times(axis);
                    prop_assert!(change.dot(change).sqrt() < 0.1 / here.value, "{change:?}");
                }
            }
        }

        /// Without twist and taper, distances and curvatures are exact, also at caps.
        #[test]
        fn straight_tubes(place in (-0.5..0.5, -1.0..1.0, -1.0..1.0), (a, b) in (0.1..0.5, 0.1..0.5)) {
            let semi_axes = [Vector::new(0.0, a, 0.0), Vector::new(0.0, 0.0, b)];
            let along = Vector::new(1.0, 0.0, 0.0);
            // The tube ends at zero.
            let at = |point: Vector<f64>| {
                let is_end = point.x > 0.0;
                let centre = Vector::new(point.x.min(0.0), 0.0, 0.0);
                let continuation = Continuation { bend: Vector::zero(), beyond: semi_axes, step: 1e-4 };
                distance(point, &Section { centre, along, semi_axes }, (!is_end).then_some(&continuation))
            };
            let point = v(place);
            let here = at(point);
            prop_assume!(here.value > 0.05 && point.x.abs() > 1e-3);
            let h = 1e-6;
            for axis in [(1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)].map(v) {
                let [ahead, behind] = [h, -h].map(|h| at(point + axis * h));
                let rate = (ahead.value - behind.value) * (0.5 / h);
                prop_assert!((rate - here.normal.dot(axis)).abs() < 1e-6, "{rate} {here:?}");
                let change = (ahead.normal - behind.normal) * (0.5 / h) - here.curvature.times(axis);
                prop_assert!(change.dot(change).sqrt() < 1e-4, "{change:?} {here:?}");
            }
        }
    }
}
