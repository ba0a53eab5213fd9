//! Distances from the wall of a tube with open ends, from inside and from outside.
//!
//! With the distance `rho` of a point from the centre line, the bore of radius R and the thickness w of the wall, the wall
//! is where `max(R - rho, rho - R - w) <= 0` between the planes across both ends of the centre line. Beyond an end, the
//! distance is that from the flat end of the wall, or from its rim. It is differentiable outside of the wall (but in the middle of
//! the bore, and where two places of the centre line are equally near), and its second derivatives jump in the planes of the ends.

use super::centre_line::{CentreLine, Nearest};
use super::distance::{Distance, SHORTEST, between};
use crate::numerics::lie::{Symmetric, Vector};

/// Smallest factor of the motion of the nearest place: where the centre line bends about a point in the wall, that motion is unbounded.
const LEAST_STRETCH: f64 = 0.05;

/// A tube with open ends.
#[derive(Clone, Debug)]
pub(crate) struct Tube {
    line: CentreLine,
    /// Radius of the bore.
    radius: f64,
    /// Thickness of the wall.
    wall: f64,
    /// Both ends of the centre line, with the direction out of each.
    ends: [[Vector<f64>; 2]; 2],
    most_bent: f64,
}

/// Where a point is relative to a tube.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Location {
    /// Nearer to the bore than to the outside, between the planes across the ends.
    Inside,
    Outside,
    /// Beyond an end.
    Beyond(usize),
}

impl Tube {
    /// The tube around the centre line through points.
    pub(crate) fn new(points: &[Vector<f64>], radius: f64, wall: f64) -> Self {
        let line = CentreLine::new(points);
        let (ends, most_bent) = (line.ends(), line.most_bent());
        Self { line, radius, wall, ends, most_bent }
    }

    /// Radius of the bore.
    pub(crate) fn radius(&self) -> f64 {
        self.radius
    }

    /// Largest possible depth in the wall: for rings, the ends may be nearer than the sides.
    pub(crate) fn deepest(&self) -> f64 {
        0.5 * self.wall.min(self.line.length())
    }

    /// Largest curvature of the centre line, per metre.
    pub(crate) fn most_bent(&self) -> f64 {
        self.most_bent
    }

    /// Largest distance of its points from the origin.
    pub(crate) fn reach(&self) -> f64 {
        self.line.reach() + self.radius + self.wall
    }

    /// Whether a point is certainly farther from it than `reach`.
    pub(crate) fn is_certainly_beyond(&self, point: Vector<f64>, reach: f64) -> bool {
        let (centre, radius) = self.line.ball();
        between(point, centre) > radius + self.radius + self.wall + reach.max(0.0)
    }

    /// Distance from a wall without ends, for the way from the nearest place of the centre line, its direction, and one minus the
    /// product of way and curvature.
    fn side(&self, way: Vector<f64>, along: Vector<f64>, stretch: f64) -> Distance {
        let along = Some((along, stretch.max(LEAST_STRETCH)));
        if way.dot(way).sqrt() > self.radius + 0.5 * self.wall {
            return Distance::from_curve(way, self.radius + self.wall, along);
        }
        let Distance { value, normal, curvature } = Distance::from_curve(way, self.radius, along);
        Distance { value: -value, normal: -normal, curvature: curvature * -1.0 }
    }

    /// Distance of a point from the wall.
    pub(crate) fn distance(&self, point: Vector<f64>) -> Distance {
        let Nearest { way, along, bend, from, beyond } = self.line.nearest(point);
        if let Some(end) = beyond {
            return self.beyond(way, self.ends[end][1]);
        }
        let side = self.side(way, along, 1.0 - way.dot(bend));
        if side.value >= 0.0 {
            return side;
        }
        // Within the wall: near an end, its plane may be nearer than the sides.
        let to_ends = [from, self.line.length() - from];
        let mut nearest = side;
        for ([end, outward], _) in
            self.ends.into_iter().zip(to_ends).filter(|(_, to_end)| *to_end < self.wall)
        {
            let value = outward.dot(point - end);
            if value > nearest.value {
                nearest = Distance { value, normal: outward, curvature: Symmetric::diagonal(0.0) };
            }
        }
        nearest
    }

    /// Distance of a point beyond an end, for the way from there and the direction out of the tube.
    fn beyond(&self, way: Vector<f64>, outward: Vector<f64>) -> Distance {
        let height = outward.dot(way);
        let side = self.side(way - outward * height, outward, 1.0);
        if side.value <= 0.0 {
            return Distance { value: height, normal: outward, curvature: Symmetric::diagonal(0.0) };
        }
        let value = height.hypot(side.value);
        if value <= SHORTEST {
            return side;
        }
        // From the rim: a circle.
        let normal = (side.normal * side.value + outward * height) * value.recip();
        let squares = Symmetric::square(side.normal) + Symmetric::square(outward) - Symmetric::square(normal);
        Distance { value, normal, curvature: (squares + side.curvature * side.value) * value.recip() }
    }

    /// The feature nearest to a point: sides or an end, and bore, wall or outside.
    pub(crate) fn feature(&self, point: Vector<f64>) -> [usize; 3] {
        let Nearest { way, along, beyond, .. } = self.line.nearest(point);
        let across = way - along * along.dot(way);
        let distance = across.dot(across).sqrt();
        let ring = usize::from(distance > self.radius) + usize::from(distance > self.radius + self.wall);
        match beyond {
            None => [0, ring / 2, 0],
            Some(end) => [1 + end, ring, 0],
        }
    }

    /// Where a point is.
    pub(crate) fn location(&self, point: Vector<f64>) -> Location {
        let Nearest { way, beyond, .. } = self.line.nearest(point);
        let is_outside = way.dot(way).sqrt() > self.radius + 0.5 * self.wall;
        beyond.map_or(if is_outside { Location::Outside } else { Location::Inside }, Location::Beyond)
    }

    /// Height of a point above the plane across an end.
    pub(crate) fn height(&self, end: usize, point: Vector<f64>) -> f64 {
        let [place, outward] = self.ends[end];
        outward.dot(point - place)
    }

    /// Direction out of an end.
    pub(crate) fn outward(&self, end: usize) -> Vector<f64> {
        self.ends[end][1]
    }

    /// The component of a velocity at a point across the centre line; the whole velocity beyond the ends.
    pub(crate) fn across(&self, point: Vector<f64>, velocity: Vector<f64>) -> Vector<f64> {
        let Nearest { along, beyond, .. } = self.line.nearest(point);
        if beyond.is_some() { velocity } else { velocity - along * along.dot(velocity) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn v(x: f64, y: f64, z: f64) -> Vector<f64> {
        Vector::new(x, y, z)
    }

    fn size(v: Vector<f64>) -> f64 {
        v.dot(v).sqrt()
    }

    /// A vessel with bends to all sides.
    fn vessel() -> Tube {
        let points = [
            v(0.0, 0.0, 0.0),
            v(0.1, 0.02, 0.0),
            v(0.2, -0.02, 0.03),
            v(0.3, 0.03, 0.05),
            v(0.4, 0.0, -0.02),
            v(0.5, 0.01, 0.0),
        ];
        Tube::new(&points, 0.02, 0.015)
    }

    /// Distance from many places of the surface of the wall: both sides, and both flat ends.
    fn tried(tube: &Tube, point: Vector<f64>) -> f64 {
        let places = tube.line.places(20);
        let mut least = f64::INFINITY;
        for (k, &centre) in places.iter().enumerate() {
            let (before, after) = (places[k.saturating_sub(1)], places[(k + 1).min(places.len() - 1)]);
            let along = (after - before) * size(after - before).recip();
            let first = along.cross(v(0.0, 0.0, 1.0));
            let first = first * size(first).recip();
            let second = along.cross(first);
            let is_end = k == 0 || k + 1 == places.len();
            for angle in 0..60 {
                let angle = f64::from(angle) * std::f64::consts::TAU / 60.0;
                let outward = first * angle.cos() + second * angle.sin();
                for share in 0..=10 {
                    if is_end || share == 0 || share == 10 {
                        let radius = tube.radius + tube.wall * f64::from(share) / 10.0;
                        least = least.min(size(centre + outward * radius - point));
                    }
                }
            }
        }
        least
    }

    #[test]
    fn a_straight_tube_has_the_distances_of_its_formula() {
        let tube = Tube::new(&[v(0.0, 0.0, 0.0), v(1.0, 0.0, 0.0)], 0.3, 0.2);
        for (point, wanted) in [
            (v(0.5, 0.1, 0.0), 0.2),
            (v(0.5, 0.0, 0.0), 0.3),
            (v(0.5, 0.0, -0.38), -0.08),
            (v(0.5, 0.0, 0.45), -0.05),
            (v(0.5, 0.0, 0.6), 0.1),
            (v(0.99, 0.4, 0.0), -0.01),
            (v(1.1, 0.4, 0.0), 0.1),
            (v(1.3, 0.0, 0.7), 0.2_f64.hypot(0.3)),
            (v(-0.3, 0.0, 0.1), 0.2_f64.hypot(0.3)),
        ] {
            assert!((tube.distance(point).value - wanted).abs() < 1e-15, "{point:?}");
        }
    }

    #[test]
    fn rings_of_points_are_as_tight_as_their_circle() {
        // Second derivatives of a cubic spline through points at a distance h are off by h^2, most at its ends (de Boor 1978).
        for (number, spacing) in [(30, 0.1_f64), (60, 0.05)] {
            let on_circle = |k: i32| {
                let angle = spacing * f64::from(k);
                v(0.2 * angle.cos(), 0.2 * angle.sin(), 0.0)
            };
            let points: Vec<_> = (0..=number).map(on_circle).collect();
            let tightest = CentreLine::new(&points).tightest();
            assert!((tightest.radius - 0.2).abs() < 0.2 * spacing.powi(2), "{tightest:?}");
        }
        // Two legs at a distance of 0.1, whose bend is wider than half of that.
        let legs =
            [v(0.0, 0.0, 0.0), v(0.5, 0.0, 0.0), v(0.6, 0.25, 0.0), v(0.5, 0.1, 0.2), v(0.0, 0.1, 0.0)];
        assert!(CentreLine::new(&legs).tightest().radius < 0.051);
        let straight = CentreLine::new(&[v(0.0, 0.0, 0.0), v(0.5, 0.3, 0.0)]).tightest();
        assert!(straight.radius > 1e9, "{straight:?}");
    }

    proptest! {
        /// Distances outside of the wall are those from its nearest place, and change as they say.
        #[test]
        fn distances_are_those_of_the_nearest_place(
            k in 0.0..0.999,
            (angle, share) in (0.0..6.3, 0.02..1.6),
            beyond in 0.0..0.03_f64,
        ) {
            let tube = vessel();
            let places = tube.line.places(20);
            let i = (k * (places.len() - 1) as f64) as usize;
            let along = (places[i + 1] - places[i]) * size(places[i + 1] - places[i]).recip();
            let first = along.cross(v(0.0, 0.0, 1.0));
            let first = first * size(first).recip();
            let outward = first * f64::cos(angle) + along.cross(first) * f64::sin(angle);
            let on = if i == 0 { -beyond } else if i + 2 == places.len() { beyond } else { 0.0 };
            let point = places[i] + along * on + outward * (share * (tube.radius + tube.wall));
            let found = tube.distance(point);
            prop_assert!((found.normal.dot(found.normal) - 1.0).abs() < 1e-12);
            let wanted = tried(&tube, point);
            if found.value > 0.0 {
                prop_assert!(found.value <= wanted + 1e-12 && wanted <= found.value + 1.2e-3, "{found:?} {wanted}");
            } else {
                prop_assert!(wanted <= -found.value + 1.5e-3, "{found:?} {wanted}");
            }
            let h = 1e-7;
            let feature = tube.feature(point);
            for axis in [v(1.0, 0.0, 0.0), v(0.0, 1.0, 0.0), v(0.0, 0.0, 1.0)] {
                let [ahead, behind] = [h, -h].map(|h| tube.distance(point + axis * h));
                let slope = (ahead.value - behind.value) / (2.0 * h);
                if found.value > 0.0 {
                    prop_assert!((slope - found.normal.dot(axis)).abs() < 1e-5, "{slope} {found:?}");
                }
                let is_one = [h, -h].iter().all(|&h| tube.feature(point + axis * h) == feature);
                if found.value > 0.0 && is_one {
                    let change = (ahead.normal - behind.normal) * (0.5 / h) - found.curvature.times(axis);
                    prop_assert!(size(change) < 1e-2, "{change:?} {found:?}");
                }
            }
        }
    }
}
