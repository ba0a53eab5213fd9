//! Intervals of a curve in which a gap is negative, and points at which it is not smooth.

use crate::robot::effects::contact::plan::{MOST_CHANGES, MOST_INTERVALS};
use crate::robot::effects::contact::shapes::bracket;

/// Maximum number of places between two hints at which the gap is evaluated to find its signs.
const MOST_STEPS: usize = 60;

/// Smallest distance of an intermediate place from both ends, as a fraction of the interval.
const BESIDE_ENDS: f64 = 0.02;

/// If the gap is infinite at one end, intervals shorter than this fraction of the distance of two samples are not divided.
const SHORTEST_HIDDEN_INTERVAL: f64 = 1e-3;

/// Accuracy of a place at which another feature of a solid becomes the nearest one, as a fraction of the divided interval.
const PLACE_TOLERANCE: f64 = 1e-10;

/// Places closer than this fraction of the distance of two samples count as one.
pub(super) const SAME_PLACE: f64 = 1e-13;

/// Parts of a curve in which a gap is negative, in ascending order.
#[derive(Clone, Copy, Default)]
pub(super) struct Intervals {
    own: [[f64; 2]; MOST_INTERVALS],
    number: usize,
}

impl Intervals {
    fn push(&mut self, interval: [f64; 2]) {
        self.own[self.number] = interval;
        self.number += 1;
    }

    /// Removes the last interval if there is no room for more, and returns its start.
    fn pop_last(&mut self) -> Option<f64> {
        if self.number < MOST_INTERVALS {
            return None;
        }
        self.number -= 1;
        Some(self.own[self.number][0])
    }

    pub(super) fn as_slice(&self) -> &[[f64; 2]] {
        &self.own[..self.number]
    }
}

/// Places between two others at which the nearest feature changes, in ascending order; a change and its reversal between two samples are
/// missed.
pub(super) fn changes(
    feature: impl Fn(f64) -> [usize; 3],
    [from, to]: [f64; 2],
) -> [Option<f64>; MOST_CHANGES] {
    const SAMPLES: usize = 4;
    let mut found = [None; MOST_CHANGES];
    let mut number = 0;
    let (mut begin, mut at_begin) = (from, feature(from));
    for sample in 1..=SAMPLES {
        let end = if sample == SAMPLES { to } else { from + (to - from) * sample as f64 / SAMPLES as f64 };
        let at_end = feature(end);
        while at_begin != at_end && number < MOST_CHANGES {
            let (mut before, mut after, mut at_after) = (begin, end, at_end);
            while after - before > PLACE_TOLERANCE * (to - from) {
                let middle = 0.5 * (before + after);
                let at = feature(middle);
                if at == at_begin {
                    before = middle;
                } else {
                    (after, at_after) = (middle, at);
                }
            }
            found[number] = Some(after);
            number += 1;
            (begin, at_begin) = (after, at_after);
        }
        (begin, at_begin) = (end, at_end);
    }
    found
}

/// A gap as a function on [0, 1] whose second derivative is at least `-bend` between hints: with `bend x^2 / 2` added, it is convex.
///
/// The distance of a point from a convex solid is convex; along a curve its second derivative is at least minus that of the curve, and
/// lower by the curvature of the surface if that is not convex. Between two places such a gap lies above the two parabolas through
/// their values and slopes (cutting planes: Kelley 1960), and below the parabola through both values, so that overlaps can be excluded.
pub(super) struct Gap<F, B> {
    /// Value and slope at a place.
    pub(super) at: F,
    /// The bound near a place. It may change at hints only.
    pub(super) bend: B,
    /// Overlaps up to this size do not count.
    pub(super) negligible: f64,
}

/// A place with its gap and the slope of the gap.
#[derive(Clone, Copy)]
struct Place {
    x: f64,
    value: f64,
    slope: f64,
    is_touched: bool,
}

impl Place {
    fn new(x: f64, (value, slope): (f64, f64)) -> Self {
        Self { x, value, slope, is_touched: value < 0.0 }
    }
}

/// State of the search for intervals of negative gap.
struct Search {
    found: Intervals,
    /// Start of the interval that has not ended yet.
    begin: Option<f64>,
    /// Remaining number of evaluations.
    left: usize,
}

impl<F: Fn(f64) -> (f64, f64), B: Fn(f64) -> f64> Gap<F, B> {
    /// Intervals of negative gap, from values and slopes at 0 and 1. `hints` are places in ascending order at which the gap, the
    /// smallest of several ones, may be low although its values at the ends do not show it.
    pub(super) fn touched(&self, ends: [(f64, f64); 2], hints: &[f64]) -> Intervals {
        let [start, end] = [Place::new(0.0, ends[0]), Place::new(1.0, ends[1])];
        let begin = start.is_touched.then_some(0.0);
        let mut search = Search { found: Intervals::default(), begin, left: MOST_STEPS };
        let mut before = start;
        for &x in hints {
            let here = Place::new(x, (self.at)(x));
            self.divide(before, here, &mut search);
            (before, search.left) = (here, MOST_STEPS);
        }
        self.divide(before, end, &mut search);
        if let Some(begin) = search.begin {
            search.found.push([begin, 1.0]);
        }
        search.found
    }

    /// Finds where the sign changes between two places.
    fn divide(&self, a: Place, b: Place, search: &mut Search) {
        if b.x - a.x <= SAME_PLACE {
            return if a.is_touched != b.is_touched {
                search.change(b.x);
            };
        }
        if a.is_touched == b.is_touched {
            if let Some(x) = self.place_between(a, b, search) {
                let here = Place::new(x, (self.at)(x));
                self.divide(a, here, search);
                self.divide(here, b, search);
            }
            return;
        }
        let zero = self.zero(a, b);
        let side = |is_touched| Place { is_touched, ..zero };
        self.divide(a, side(a.is_touched), search);
        search.change(zero.x);
        self.divide(side(b.is_touched), b, search);
    }

    /// Next place to evaluate between two places of the same sign, if the sign may change between them. Where it probably does is first:
    /// bounds alone take hundreds of places where a rod lies along a wall that bends as it does. What they leave open after
    /// [`MOST_STEPS`] is decided by the cubic.
    fn place_between(&self, a: Place, b: Place, search: &mut Search) -> Option<f64> {
        let bound = if a.is_touched { self.opens_at(a, b) } else { self.closes_at(a, b) }?;
        let likely = turning_point(a, b, self.negligible);
        let is_left = search.left > 0;
        search.left = search.left.saturating_sub(1);
        likely.or(is_left.then_some(bound))
    }

    /// Next place to evaluate between two places of positive gap: where both lower bounds intersect, if they are negative there.
    fn closes_at(&self, a: Place, b: Place) -> Option<f64> {
        let (h, bend) = (b.x - a.x, (self.bend)(0.5 * (a.x + b.x)));
        if !(a.value.is_finite() && b.value.is_finite()) {
            // The gap is infinite at one end: the bound of the other one extends there.
            let towards = if a.value.is_finite() { a.slope } else { -b.slope };
            let lowest = a.value.min(b.value) + (towards - 0.5 * bend * h) * h;
            return (lowest < -self.negligible && h > SHORTEST_HIDDEN_INTERVAL).then_some(a.x + 0.5 * h);
        }
        let growth = b.slope - a.slope + bend * h;
        if growth <= 0.0 {
            return None;
        }
        let t = ((a.value - b.value + (b.slope + 0.5 * bend * h) * h) / growth).clamp(0.0, h);
        let lowest = a.value + (a.slope - 0.5 * bend * t) * t;
        (lowest < -self.negligible).then_some(a.x + inside(t, h))
    }

    /// Next place to evaluate between two places of negative gap: where the upper bound is highest, if it is positive there.
    fn opens_at(&self, a: Place, b: Place) -> Option<f64> {
        let (h, bend) = (b.x - a.x, (self.bend)(0.5 * (a.x + b.x)));
        if bend <= 0.0 {
            return None;
        }
        let rise = (b.value - a.value) / h;
        let t = (0.5 * h + rise / bend).clamp(0.0, h);
        let highest = a.value + rise * t + 0.5 * bend * t * (h - t);
        (highest > self.negligible).then_some(a.x + inside(t, h))
    }

    /// Zero of the gap between two places of different signs, by Newton's method from that of the cubic through both.
    fn zero(&self, a: Place, b: Place) -> Place {
        let (way, sign) = (b.x - a.x, if a.is_touched { 1.0 } else { -1.0 });
        let last = std::cell::Cell::new(0.0);
        let rising = |t: f64| {
            let (value, slope) = (self.at)(a.x + way * t);
            last.set(slope);
            (sign * value, sign * slope * way)
        };
        let t = bracket::root(guess([a, b]), rising);
        Place { x: a.x + way * t, value: 0.0, slope: last.get(), is_touched: false }
    }
}

/// The place between two places of the same sign at which the cubic through their values and slopes is farthest on the other side, by more
/// than a negligible gap.
fn turning_point(a: Place, b: Place, negligible: f64) -> Option<f64> {
    let (way, rise) = (b.x - a.x, b.value - a.value);
    if !rise.is_finite() {
        return None;
    }
    let sign = if a.is_touched { -1.0 } else { 1.0 };
    let [start, end] = [a.slope * way, b.slope * way];
    let (bend, growth) = (3.0 * rise - 2.0 * start - end, start + end - 2.0 * rise);
    // Its slope is start + 2 bend t + 3 growth t^2; at the turning point that is a minimum of the sign times the cubic, it grows.
    let root = (bend * bend - 3.0 * growth * start).sqrt();
    let t = -start / (bend + sign * root);
    let value = a.value + (start + (bend + growth * t) * t) * t;
    (t > 0.0 && t < 1.0 && sign * value < -negligible).then(|| a.x + inside(t * way, way))
}

/// Fraction of the way between two places of different signs at which the cubic through their values and slopes vanishes; the middle where
/// the gap is infinite.
fn guess([a, b]: [Place; 2]) -> f64 {
    let (way, rise) = (b.x - a.x, b.value - a.value);
    if !rise.is_finite() || rise == 0.0 {
        return 0.5;
    }
    let sign = rise.signum();
    let [start, end] = [a.slope * way, b.slope * way];
    let (bend, growth) = (3.0 * rise - 2.0 * start - end, start + end - 2.0 * rise);
    bracket::root(-a.value / rise, |t| {
        let value = a.value + (start + (bend + growth * t) * t) * t;
        (sign * value, sign * (start + (2.0 * bend + 3.0 * growth * t) * t))
    })
}

impl Search {
    /// Notes a change of sign at a place. Excess intervals are merged with the last one: positive gaps in it have no force.
    fn change(&mut self, x: f64) {
        match self.begin.take() {
            Some(begin) => self.found.push([begin, x]),
            None => self.begin = Some(self.found.pop_last().unwrap_or(x)),
        }
    }
}

/// A place strictly between 0 and h.
fn inside(t: f64, h: f64) -> f64 {
    t.clamp(BESIDE_ENDS * h, (1.0 - BESIDE_ENDS) * h)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::cell::Cell;

    /// A gap and its slope at a place.
    type WithSlope<'a> = &'a dyn Fn(f64) -> (f64, f64);

    /// Overlaps of parabolas, steep and flat ones and of a sphere, are found to rounding, with few evaluations of the gap.
    #[test]
    fn zeros_of_gaps_are_found_within_a_few_evaluations() {
        let evaluations = Cell::new(0);
        let mut most = 0;
        for i in 0..200 {
            let (middle, depth) = (0.3 + 0.002 * f64::from(i), 10.0_f64.powf(-0.03 * f64::from(i)));
            let parabola = |x: f64| ((x - middle).powi(2) - 0.04 * depth, 2.0 * (x - middle));
            let sphere = |x: f64| {
                let length = (x - middle).hypot(0.1);
                (length - 0.1 - 0.02 * depth, (x - middle) / length)
            };
            let half = (0.1 + 0.02 * depth).powi(2) - 0.01;
            let of_both: [(WithSlope<'_>, f64); 2] =
                [(&parabola, (0.04 * depth).sqrt()), (&sphere, half.sqrt())];
            for (gap, half) in of_both {
                evaluations.set(0);
                let at = |x| {
                    evaluations.set(evaluations.get() + 1);
                    gap(x)
                };
                let found =
                    Gap { at, bend: |_| 0.0, negligible: 1e-12 }.touched([gap(0.0), gap(1.0)], &[middle]);
                let [[from, to]] = found.as_slice() else { panic!("{i}: not one interval") };
                let error = (from - middle + half).abs().max((to - middle - half).abs());
                assert!(error < 1e-13, "{i}: {from} {to}, not {middle} -+ {half}");
                most = most.max(evaluations.get());
            }
        }
        // Of the middle and of both zeros.
        assert!(most <= 13, "{most}");
    }

    /// Gaps with corners, as over edges of boxes, and those that are infinite beyond a place.
    #[test]
    fn zeros_beside_corners_and_infinite_gaps_are_found() {
        let edge = |x: f64| if x < 0.4 { (0.3 - x, -1.0) } else { (0.02 * (x - 0.4) - 0.1, 0.02) };
        let hidden = |x: f64| if x < 0.25 { (f64::INFINITY, 0.0) } else { (0.1 - x * x, -2.0 * x) };
        let found = |gap: WithSlope<'_>| {
            Gap { at: gap, bend: |_| 2.0, negligible: 1e-12 }.touched([gap(0.0), gap(1.0)], &[]).as_slice()[0]
        };
        let [[from, _], [later, to]] = [found(&edge), found(&hidden)];
        assert!((from - 0.3).abs() < 1e-13 && (later - 0.1_f64.sqrt()).abs() < 1e-13 && to == 1.0);
    }

    /// A rod lies along a wall that bends as it does: the bound adds both bends, of which next to nothing is left.
    #[test]
    fn shallow_intervals_are_found_however_pessimistic_the_bound() {
        for (i, sign) in [1.0, -1.0].into_iter().enumerate() {
            for middle in [0.11, 0.47, 0.8] {
                for half in [0.3, 0.03, 0.003] {
                    let gap = |x: f64| {
                        let from = x - middle;
                        let steep = 1e-5 * (1.0 + 0.3 * from);
                        let slope = steep * 2.0 * from + 0.3e-5 * (from * from - half * half);
                        (sign * steep * (from * from - half * half), sign * slope)
                    };
                    let found =
                        Gap { at: gap, bend: |_| 5e-3, negligible: 1e-13 }.touched([gap(0.0), gap(1.0)], &[]);
                    let inner = [(middle - half).max(0.0), (middle + half).min(1.0)];
                    let outer = [[0.0, inner[0]], [inner[1], 1.0]].into_iter().filter(|[from, to]| to > from);
                    let expected: Vec<[f64; 2]> = if sign > 0.0 { vec![inner] } else { outer.collect() };
                    let found = found.as_slice();
                    assert_eq!(found.len(), expected.len(), "{i} {middle} {half}: {found:?}");
                    for (found, expected) in found.iter().flatten().zip(expected.iter().flatten()) {
                        assert!((found - expected).abs() < 1e-9, "{i} {middle} {half}: {found} {expected}");
                    }
                }
            }
        }
    }
}
