//! Point of a straight edge nearest to a solid.
//!
//! An edge that lies flat on a face, or along another edge, has no unique nearest point. Therefore edges are
//! treated as bowed out by a thousandth of their length: with x measured from the middle of an edge of length
//! L, and the distance g from a convex solid, the nearest point minimises `g(x) + c x^2 / 2`, `c = 8 b / L`.
//! This function is strictly convex, so that the point moves smoothly when the edge tilts. Because the
//! overlap is a maximum over x, the force is its gradient without a term from the motion of the point
//! (envelope theorem).

use super::distance::Distance;
use super::ellipse::Rolling;
use super::obstacle::Placed;
use crate::numerics::lie::Vector;

/// Height of the bow in the middle of an edge, relative to its length. The nearest point moves from the
/// middle to the end over a tilt of four times this value.
pub(crate) const BOW: f64 = 1e-3;

/// The search ends with steps below this fraction of the length, or after the maximum number of steps:
/// bisection alone takes 47.
const SMALLEST: f64 = 1e-14;
const MOST_STEPS: usize = 60;

/// The nearest point of an edge, its distance from the solid, and its motion along the edge, which is zero at
/// an end.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Nearest {
    pub(crate) place: Vector<f64>,
    /// Distance including the bow.
    pub(crate) distance: Distance,
    pub(crate) rolling: Option<Rolling>,
}

/// Nearest point of an edge; `None` if the whole edge is certainly farther away than `radius`.
pub(crate) fn nearest(solid: &Placed<'_>, [start, end]: [Vector<f64>; 2], radius: f64) -> Option<Nearest> {
    let way = end - start;
    let length = way.dot(way).sqrt();
    let along = way * length.recip();
    let (middle, half) = ((start + end) * 0.5, 0.5 * length);
    let bow = 8.0 * BOW / length;
    let mut x = 0.0;
    let mut distance = solid.distance(middle);
    if distance.value > radius + half {
        return None;
    }
    let bend = |distance: &Distance| along.dot(distance.curvature.times(along)) + bow;
    let slope = |x: f64, distance: &Distance| distance.normal.dot(along) + bow * x;
    let mut rise = slope(x, &distance);
    let found = |x: f64, distance: Distance, rolling| {
        let value = distance.value + 0.5 * bow * x * x;
        Some(Nearest { place: middle + along * x, distance: Distance { value, ..distance }, rolling })
    };
    // The slope increases with x: its zero lies between that end and the middle, or beyond the end.
    let mut beyond = if rise > 0.0 { -half } else { half };
    let at_end = solid.distance(if rise > 0.0 { start } else { end });
    if rise * slope(beyond, &at_end) > 0.0 {
        return found(beyond, at_end, None);
    }
    let mut last = half;
    for _ in 0..MOST_STEPS {
        if rise == 0.0 {
            break;
        }
        let newton = -rise / bend(&distance);
        let bisection = 0.5 * (beyond - x);
        let is_within = newton.abs() < (beyond - x).abs() && newton.abs() < 0.5 * last;
        let step = if is_within { newton } else { bisection };
        last = step.abs();
        let next = x + step;
        let there = solid.distance(middle + along * next);
        let next_rise = slope(next, &there);
        if next_rise * rise < 0.0 {
            beyond = x;
        }
        (x, distance, rise) = (next, there, next_rise);
        if step.abs() <= SMALLEST * length {
            break;
        }
    }
    let over = -bend(&distance).recip();
    let rolling = Rolling {
        along,
        of_turn: along.cross(distance.normal) * over,
        of_shift: distance.curvature.times(along) * over,
    };
    found(x, distance, Some(rolling))
}

#[cfg(test)]
mod tests {
    use super::super::obstacle::Solid;
    use super::*;
    use crate::numerics::lie::Quaternion;
    use proptest::prelude::*;

    proptest! {
        /// The point is the nearest of many, including the bow, and moves as predicted.
        #[test]
        fn places_are_nearest_and_move_as_they_say(
            omega in (-1.0..1.0, -1.0..1.0, -1.0..1.0),
            middle in (-0.6..0.6, -0.6..0.6, 0.25..0.6),
            half in 0.1..0.8,
        ) {
            let v = |(x, y, z)| Vector::new(x, y, z);
            let rotation = Quaternion::exp(v(omega)).rotation();
            let axes = Quaternion::from_array([1.0, 0.0, 0.0, 0.0]).rotation();
            let half_extents = v((0.3, 0.2, 0.1));
            let solid = Solid::Cuboid { centre: Vector::zero(), axes, half_extents, radius: 0.1 };
            let solid = Placed { solid: &solid, pose: None };
            let ends = [-1.0, 1.0].map(|side| v(middle) + rotation.x * (side * half));
            let bowed = |x: f64| {
                solid.distance(v(middle) + rotation.x * x).value + 2.0 * BOW * x * x / half
            };
            let tried = (-500..=500).map(|k| bowed(half * f64::from(k) / 500.0)).fold(f64::INFINITY, f64::min);
            let Some(here) = nearest(&solid, ends, 0.0) else {
                prop_assert!(tried > -1e-12);
                return Ok(());
            };
            prop_assert!(here.distance.value <= tried + 1e-12 && tried <= here.distance.value + 1e-2 * half);
            let Some(Rolling { along, of_turn, of_shift }) = here.rolling else { return Ok(()) };
            let h = 1e-7;
            for axis in [v((1.0, 0.0, 0.0)), v((0.0, 1.0, 0.0)), v((0.0, 0.0, 1.0))] {
                for (turn, shift) in [(axis, Vector::zero()), (Vector::zero(), axis)] {
                    let at = |h: f64| {
                        let small = Quaternion::exp(turn * h).rotation();
                        let moved = ends.map(|end| here.place + small.apply(end - here.place) + shift * h);
                        nearest(&solid, moved, f64::INFINITY).unwrap()
                    };
                    let [ahead, behind] = [at(h), at(-h)];
                    let rate = (ahead.distance.value - behind.distance.value) * (0.5 / h);
                    let error = (rate - here.distance.normal.dot(shift)).abs();
                    let (forward, back) = (ahead.place - here.place, here.place - behind.place);
                    let is_smooth = (forward - back).dot(forward - back).sqrt() < 1e-3 * h;
                    if is_smooth && here.distance.value > -0.09 {
                        let slide = along * (of_turn.dot(turn) + of_shift.dot(shift));
                        let change = (forward + back) * (0.5 / h) - shift - slide;
                        prop_assert!(change.dot(change).sqrt() < 1e-3 * (1.0 + slide.dot(slide).sqrt()), "{change:?} {slide:?}");
                        prop_assert!(error < 1e-5, "{error}");
                    }
                }
            }
        }
    }

    #[test]
    fn edges_that_lie_flat_touch_in_the_middle_and_at_the_end_when_tilted() {
        let v = Vector::new;
        let solid = Solid::HalfSpace { point: Vector::zero(), normal: v(0.0, 0.0, 1.0) };
        let solid = Placed { solid: &solid, pose: None };
        let at = |tilt: f64| {
            let half = v(0.5 * tilt.cos(), 0.0, 0.5 * tilt.sin());
            nearest(&solid, [v(0.0, 0.0, 0.01) - half, v(0.0, 0.0, 0.01) + half], 0.02).unwrap()
        };
        assert!(at(0.0).place.x == 0.0 && at(0.0).distance.value == 0.01);
        assert!((at(2.0 * BOW).place.x + 0.25).abs() < 1e-5);
        let end = at(5.0 * BOW);
        assert!((end.place.x + 0.5).abs() < 1e-4 && end.rolling.is_none());
    }
}
