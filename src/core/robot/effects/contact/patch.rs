//! Surfaces that lines sweep while every place of them moves straight from its position in one shape to that in another.
//!
//! A line is a Bézier curve: a place, an edge, or the part of a rod between two samples. Line and patch lie in the convex hulls of their
//! control points (Farin 2002, section 4.3), and halves of them have control points of their own (de Casteljau): where a ball around these is
//! not clear of an obstacle, the patch is halved.

use crate::numerics::lie::Vector;
use crate::robot::effects::contact::shapes::distance::between as distance;
use crate::robot::effects::contact::shapes::obstacle::Solid;

/// Surfaces count as having passed through each other if they overlap on the path by more than this part of a radius.
pub(super) const TUNNELLING_OVERLAP: f64 = 0.5;

/// Paths and patches shorter than this part of the radius cannot contain such an overlap unseen.
pub(super) const SHORT_PATH: f64 = 0.2;

/// Control points of a Bézier curve: of a place one, of a straight line two, of the part of a rod four.
pub(super) type Line<const N: usize> = [Vector<f64>; N];

/// The cubic through two places with these derivatives.
pub(super) fn cubic([[p, a], [q, b]]: [[Vector<f64>; 2]; 2]) -> Line<4> {
    [p, p + a * (1.0 / 3.0), q - b * (1.0 / 3.0), q]
}

/// Both halves of a line (de Casteljau).
fn halves<const N: usize>(line: Line<N>) -> [Line<N>; 2] {
    let (mut first, mut second, mut points) = (line, line, line);
    for round in 1..N {
        for i in 0..N - round {
            points[i] = (points[i] + points[i + 1]) * 0.5;
        }
        first[round] = points[0];
        second[N - 1 - round] = points[N - 1 - round];
    }
    [first, second]
}

/// Smallest allowed distance along a path that starts at this distance. A path that starts deeper already may cover half of the distance
/// to the surface, from inside to the middle of the solid, which is at a distance of zero or less; `None` if it starts beyond the middle.
pub(super) fn deeper(start: f64, deep: f64, middle: f64) -> Option<f64> {
    if start >= deep {
        Some(deep)
    } else if start > 0.0 {
        Some(TUNNELLING_OVERLAP * start)
    } else if start > middle {
        Some(middle + TUNNELLING_OVERLAP * (start - middle))
    } else {
        None
    }
}

/// Whether a line comes deeper into a solid than `deep`, a distance from its surface, and than at the start ([`deeper`]), if `comes_nearer` says
/// whether it comes nearer than a distance. Places closer to each other than `size` are not distinguished.
pub(super) fn goes_deeper<const N: usize>(
    solid: &Solid,
    start: Line<N>,
    deep: f64,
    size: f64,
    comes_nearer: impl Fn(f64) -> bool,
) -> bool {
    if !comes_nearer(deep) {
        return false;
    }
    let start = Patch([start; 2]);
    if !start.comes_nearer(solid, deep, size) {
        return true;
    }
    deeper(start.least_distance(solid, f64::INFINITY, size), deep, -solid.depth()).is_some_and(comes_nearer)
}

/// The patch between a line at the start and at the end, in space or relative to a moving surface.
#[derive(Clone, Copy, Debug)]
pub(super) struct Patch<const N: usize>(pub(super) [Line<N>; 2]);

impl<const N: usize> Patch<N> {
    /// The same relative to a place that moves, too.
    pub(super) fn beside(self, there: [Vector<f64>; 2]) -> Self {
        let [before, now] = self.0;
        Self([before.map(|place| place - there[0]), now.map(|place| place - there[1])])
    }

    /// A bounding ball.
    pub(super) fn bound(&self) -> (Vector<f64>, f64) {
        let points = || self.0.iter().flatten().copied();
        let centre = points().fold(Vector::zero(), |sum, point| sum + point) * (0.5 / N as f64);
        (centre, points().map(|point| distance(centre, point)).fold(0.0, f64::max))
    }

    /// Its extents along the paths, and across.
    pub(super) fn extents(&self) -> [f64; 2] {
        let [before, now] = &self.0;
        let along = before.iter().zip(now).map(|(from, to)| distance(*from, *to));
        let across = self.0.iter().flat_map(|line| line.iter().map(|point| distance(line[0], *point)));
        [along.fold(0.0, f64::max), across.fold(0.0, f64::max)]
    }

    /// Whether a rod or a ball of this radius that moves along it comes deeper into a solid than half of `measure` and than at the start.
    pub(super) fn is_deep_in(&self, solid: &Solid, radius: f64, measure: f64) -> bool {
        let size = SHORT_PATH * measure;
        let [path, _] = self.extents();
        measure > 0.0
            && path > size
            && goes_deeper(solid, self.0[0], radius - TUNNELLING_OVERLAP * measure, size, |deep| {
                self.comes_nearer(solid, deep, size)
            })
    }

    /// Whether it comes closer to a solid than `deep`, divided into patches of this size.
    pub(super) fn comes_nearer(&self, solid: &Solid, deep: f64, size: f64) -> bool {
        let (centre, radius) = self.bound();
        if solid.is_certainly_beyond(centre, deep + radius) {
            return false;
        }
        let value = solid.distance(centre).value;
        if value >= deep + radius {
            return false;
        }
        if value < deep {
            return true;
        }
        radius > size && self.halves().iter().any(|half| half.comes_nearer(solid, deep, size))
    }

    /// Its distance from a solid but for `size`, or a distance that is known, if that is not larger.
    fn least_distance(&self, solid: &Solid, known: f64, size: f64) -> f64 {
        let (centre, radius) = self.bound();
        let value = solid.distance(centre).value;
        let known = known.min(value);
        if radius <= size || value - radius >= known - size {
            return known;
        }
        self.halves().iter().fold(known, |known, half| half.least_distance(solid, known, size))
    }

    fn halves(&self) -> [Self; 2] {
        let [along, across] = self.extents();
        if along <= across {
            return self.parts();
        }
        let [before, now] = self.0;
        let middle: Line<N> = std::array::from_fn(|i| (before[i] + now[i]) * 0.5);
        [Self([before, middle]), Self([middle, now])]
    }

    /// Both halves across the paths.
    pub(super) fn parts(&self) -> [Self; 2] {
        let [before, now] = self.0.map(halves);
        [0, 1].map(|half| Self([before[half], now[half]]))
    }

    /// The chords of the lines.
    pub(super) fn chords(&self) -> [Line<2>; 2] {
        self.0.map(|line| [line[0], line[N - 1]])
    }
}

impl Patch<4> {
    /// Upper bound of the distances of its lines from their chords: an eighth of the largest second derivative, which is six times the second
    /// difference of control points.
    pub(super) fn bow(&self) -> f64 {
        let second = |line: &Line<4>, i: usize| line[i] - line[i + 1] * 2.0 + line[i + 2];
        let bends = self.0.iter().flat_map(|line| [0, 1].map(|i| second(line, i)));
        0.75 * bends.map(|bend| bend.dot(bend)).fold(0.0, f64::max).sqrt()
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use proptest::prelude::*;

    fn line() -> impl Strategy<Value = Line<4>> {
        prop::array::uniform12(-1.0..1.0).prop_map(|x: [f64; 12]| {
            std::array::from_fn(|i| Vector::new(x[3 * i], x[3 * i + 1], x[3 * i + 2]))
        })
    }

    pub(in super::super) fn patch() -> impl Strategy<Value = Patch<4>> {
        (line(), line()).prop_map(|(before, now)| Patch([before, now]))
    }

    /// The place of a line at a fraction of its path, by Bernstein's polynomials.
    pub(in super::super) fn place(patch: &Patch<4>, s: f64, x: f64) -> Vector<f64> {
        let [before, now] = patch.0.map(|[a, b, c, d]| {
            let r = 1.0 - s;
            a * (r * r * r) + b * (3.0 * r * r * s) + c * (3.0 * r * s * s) + d * (s * s * s)
        });
        before + (now - before) * x
    }

    /// The smallest of a function at places between 0 and 1.
    pub(in super::super) fn least(number: usize, f: impl Fn(f64) -> f64) -> f64 {
        (0..=number).map(|i| f(i as f64 / number as f64)).fold(f64::INFINITY, f64::min)
    }

    proptest! {
        #[test]
        fn halves_are_the_line(patch in patch(), s in 0.0..1.0, x in 0.0..1.0) {
            let [first, second] = patch.parts();
            for (half, at) in [(first, 0.5 * s), (second, 0.5 + 0.5 * s)] {
                prop_assert!(distance(place(&half, s, x), place(&patch, at, x)) < 1e-14);
            }
            let (centre, radius) = patch.bound();
            prop_assert!(distance(place(&patch, s, x), centre) <= radius + 1e-14);
        }

        #[test]
        fn cubics_have_their_ends_and_deviate_from_chords_by_no_more_than_their_bow(
            ends in prop::array::uniform4((-1.0..1.0, -1.0..1.0, -1.0..1.0)), s in 0.0..1.0,
        ) {
            let [p, a, q, b] = ends.map(|(x, y, z)| Vector::new(x, y, z));
            let patch = Patch([cubic([[p, a], [q, b]]); 2]);
            let h = 1e-6;
            for (from, to, expected) in [(0.0, h, a), (1.0 - h, 1.0, b)] {
                let slope = (place(&patch, to, 0.0) - place(&patch, from, 0.0)) * (1.0 / h);
                prop_assert!(distance(slope, expected) < 1e-4);
            }
            let away = distance(place(&patch, s, 0.0), p + (q - p) * s);
            prop_assert!(away <= patch.bow() + 1e-14, "{away}");
        }

        #[test]
        fn patches_that_go_through_a_ball_are_seen(patch in patch(), centre in prop::array::uniform3(-1.0..1.0), radius in 0.01..0.2) {
            let [x, y, z] = centre;
            let solid = Solid::Ball { centre: Vector::new(x, y, z), radius };
            let thick: f64 = 0.05;
            let smallest = thick.min(radius);
            let overlap = |s: f64, x: f64| thick - solid.distance(place(&patch, s, x)).value;
            let deepest = -least(200, |x| least(200, |s| -overlap(s, x)));
            let at_start = -least(200, |s| -overlap(s, 0.0));
            let found = patch.is_deep_in(&solid, thick, smallest);
            if at_start < TUNNELLING_OVERLAP * smallest && deepest > (TUNNELLING_OVERLAP + 2.0 * SHORT_PATH) * smallest {
                prop_assert!(found);
            }
            if deepest < (TUNNELLING_OVERLAP - 0.3) * smallest - 0.04 {
                prop_assert!(!found);
            }
        }
    }
}
