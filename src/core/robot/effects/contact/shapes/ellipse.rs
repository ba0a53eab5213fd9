//! Point of an elliptic section nearest to another surface.

use super::distance::Distance;
use super::obstacle::Placed;
use crate::numerics::lie::Vector;

/// Maximum number of Newton steps, maximum length of a step in radians, and maximum number of halvings of a
/// step.
const MOST_STEPS: usize = 30;
const LONGEST_STEP: f64 = 0.5;
const MOST_HALVINGS: usize = 20;

/// The iteration ends when the slope of the distance is below this fraction of the semi-axes per radian.
const SLOPE_TOLERANCE: f64 = 1e-13;

/// Motion of the contact point along the edge of a section: `along (of_turn . turn + of_shift . shift)` for a
/// rotation of the section and a displacement of the material at the contact point.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Rolling {
    pub(crate) along: Vector<f64>,
    pub(crate) of_turn: Vector<f64>,
    pub(crate) of_shift: Vector<f64>,
}

/// The point of an edge nearest to a solid, its distance, and its motion along the edge.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Nearest {
    pub(crate) place: Vector<f64>,
    pub(crate) distance: Distance,
    pub(crate) rolling: Rolling,
}

/// Nearest point of the ellipse about a centre with these semi-axes, which are perpendicular to each other.
pub(crate) fn nearest(solid: &Placed<'_>, centre: Vector<f64>, semi_axes: [Vector<f64>; 2]) -> Nearest {
    nearest_to(|place| solid.distance(place), centre, semi_axes)
}

/// The same for a distance function.
pub(crate) fn nearest_to(
    to_surface: impl Fn(Vector<f64>) -> Distance,
    centre: Vector<f64>,
    [a, b]: [Vector<f64>; 2],
) -> Nearest {
    let beside = |angle: f64| {
        let (sine, cosine) = angle.sin_cos();
        [a * cosine + b * sine, b * cosine - a * sine]
    };
    // Nearest to a plane perpendicular to the direction from the centre.
    let normal = to_surface(centre).normal;
    let mut angle = (-normal.dot(b)).atan2(-normal.dot(a));
    let [mut own, mut slope] = beside(angle);
    let mut distance = to_surface(centre + own);
    let size = a.dot(a).max(b.dot(b)).sqrt();
    let bend = |own: Vector<f64>, slope: Vector<f64>, distance: &Distance| {
        slope.dot(distance.curvature.times(slope)) - distance.normal.dot(own)
    };
    for _ in 0..MOST_STEPS {
        let rise = distance.normal.dot(slope);
        if rise.abs() <= SLOPE_TOLERANCE * size {
            break;
        }
        let bend = bend(own, slope, &distance);
        let step = if bend > 0.0 { -rise / bend } else { -rise.signum() * LONGEST_STEP };
        let mut step = step.clamp(-LONGEST_STEP, LONGEST_STEP);
        let mut is_nearer = false;
        for _ in 0..MOST_HALVINGS {
            let [next, next_slope] = beside(angle + step);
            let there = to_surface(centre + next);
            // Close to the minimum, values are equal to rounding: compare slopes.
            is_nearer = there.value < distance.value
                || (there.value <= distance.value + SLOPE_TOLERANCE * size
                    && there.normal.dot(next_slope).abs() < rise.abs());
            if is_nearer {
                angle += step;
                (own, slope, distance) = (next, next_slope, there);
                break;
            }
            step *= 0.5;
        }
        if !is_nearer {
            break;
        }
    }
    let bend = bend(own, slope, &distance);
    let over = if bend > SLOPE_TOLERANCE * size { -bend.recip() } else { 0.0 };
    let rolling = Rolling {
        along: slope,
        of_turn: slope.cross(distance.normal) * over,
        of_shift: distance.curvature.times(slope) * over,
    };
    Nearest { place: centre + own, distance, rolling }
}

#[cfg(test)]
mod tests {
    use super::super::obstacle::Solid;
    use super::*;
    use crate::numerics::lie::Quaternion;
    use proptest::prelude::*;

    proptest! {
        /// The point is as near as the nearest of many, and moves as predicted.
        #[test]
        fn nearest_places_are_nearest(
            omega in (-1.0..1.0, -1.0..1.0, -1.0..1.0),
            way in (-1.0..1.0, -1.0..1.0, 0.2..1.0),
            (y, z) in (0.02..0.2, 0.02..0.2),
        ) {
            let v = |(x, y, z)| Vector::new(x, y, z);
            let turned = |omega| {
                let axes = Quaternion::exp(omega).rotation();
                [axes.y * y, axes.z * z]
            };
            let unturned = Quaternion::from_array([1.0, 0.0, 0.0, 0.0]).rotation();
            let solids = [
                Solid::HalfSpace { point: v((0.0, 0.0, 0.1)), normal: v((0.0, 0.6, 0.8)) },
                Solid::Ball { centre: Vector::zero(), radius: 0.1 },
                Solid::Cuboid { centre: Vector::zero(), axes: unturned, half_extents: v((0.1, 0.05, 0.1)), radius: 0.0 },
            ];
            let (omega, centre) = (v(omega), v(way));
            let semi = turned(omega);
            for solid in &solids {
                let solid = Placed { solid, pose: None };
                let found = nearest(&solid, centre, semi);
                let tried = (0..720).map(|k| {
                    let (s, c) = (f64::from(k) * 0.5_f64.to_radians()).sin_cos();
                    solid.distance(centre + semi[0] * c + semi[1] * s).value
                });
                let tried = tried.fold(f64::INFINITY, f64::min);
                let value = found.distance.value;
                prop_assert!(value <= tried + 1e-9 && tried <= value + 1e-4, "{solid:?} {value} {tried}");
            }
            // On a ball, where the distance has no kinks.
            let solid = Solid::Ball { centre: Vector::zero(), radius: 0.1 };
            let solid = Placed { solid: &solid, pose: None };
            let here = nearest(&solid, centre, semi);
            let Rolling { along, of_turn, of_shift } = here.rolling;
            // Skip ellipses that look like circles from the ball.
            let is_clear = along.dot(here.distance.curvature.times(along)) - here.distance.normal.dot(here.place - centre)
                > 1e-2 * y.max(z);
            let h = 1e-6;
            for axis in [v((1.0, 0.0, 0.0)), v((0.0, 1.0, 0.0)), v((0.0, 0.0, 1.0))] {
                for (turn, shift) in [(axis, Vector::zero()), (Vector::zero(), axis)] {
                    let at = |h: f64| {
                        let small = Quaternion::exp(turn * h).rotation();
                        nearest(&solid, centre + shift * h, semi.map(|s| small.apply(s)))
                    };
                    let [ahead, behind] = [at(h), at(-h)];
                    let moved = turn.cross(here.place - centre) + shift;
                    let slide = along * (of_turn.dot(turn) + of_shift.dot(moved));
                    let change = (ahead.place - behind.place) * (0.5 / h) - moved - slide;
                    if is_clear {
                        prop_assert!(change.dot(change).sqrt() < 1e-4, "{change:?}");
                    }
                    let rate = (ahead.distance.value - behind.distance.value) * (0.5 / h);
                    prop_assert!((rate - here.distance.normal.dot(moved)).abs() < 1e-6);
                }
            }
        }
    }
}
