//! Intervals of a curve in which a gap is negative, and points at which it is not smooth.

use crate::robot::plan::contact::{MOST_CHANGES, MOST_INTERVALS};

/// Steps of regula falsi, and of the search for the lowest place.
const MOST_STEPS: usize = 60;

/// A place where another part of a solid becomes the nearest one is known to that part of what is divided there.
const NARROW: f64 = 1e-10;

/// Places closer than that part of the way between two samples are one.
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

    pub(super) fn as_slice(&self) -> &[[f64; 2]] {
        &self.own[..self.number]
    }
}

/// Where between two places something changes, in ascending order; what comes back between two of a few samples is not seen.
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
            while after - before > NARROW * (to - from) {
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

/// Where between 0 and 1 a gap is negative, by its values and slopes: it is nearly a cubic, which has up to two places where it
/// turns.
pub(super) fn touched(ends: [(f64, f64); 2], gap: impl Fn(f64) -> (f64, f64)) -> Intervals {
    let (turns, number) = turning_points(ends);
    let [(start, _), (end, _)] = ends;
    let mut places = [(0.0, start), (1.0, end), (1.0, end), (1.0, end)];
    for i in 0..number {
        let before = if i > 0 { turns[i - 1].0 } else { 0.0 };
        let after = if i + 1 < number { turns[i + 1].0 } else { 1.0 };
        let (x, curvature) = turns[i];
        let sign = curvature.signum();
        let turned = |x: f64| {
            let (value, slope) = gap(x);
            (sign * value, sign * slope)
        };
        let (x, value) = lowest(turned, [before, after], x, curvature.abs());
        places[i + 1] = (x, sign * value);
    }
    let mut found = Intervals::default();
    let mut begin = (start < 0.0).then_some(0.0);
    for pair in places[..number + 2].windows(2) {
        let [(a, at_a), (b, at_b)] = [pair[0], pair[1]];
        if (at_a < 0.0) == (at_b < 0.0) {
            continue;
        }
        let x = zero(|x| gap(x).0, [a, b], [at_a, at_b]);
        match begin.take() {
            Some(begin) => found.push([begin, x]),
            None => begin = Some(x),
        }
    }
    if let Some(begin) = begin {
        found.push([begin, 1.0]);
    }
    found
}

/// Where the cubic through values and slopes at 0 and 1 turns between them, in ascending order, with its curvature there.
fn turning_points([(start, start_slope), (end, end_slope)]: [(f64, f64); 2]) -> ([(f64, f64); 2], usize) {
    let rise = end - start;
    // Of the slope: `a + 2 b x + 3 c x^2`.
    let (a, b, c) =
        (start_slope, 3.0 * rise - 2.0 * start_slope - end_slope, start_slope + end_slope - 2.0 * rise);
    let (mut turns, mut number) = ([(0.0, 0.0); 2], 0);
    let square = b * b - 3.0 * a * c;
    // What is not seen from one end is not finite.
    if !square.is_finite() || square <= 0.0 {
        return (turns, number);
    }
    // The root that does not cancel, and the other one by their product (Press et al. 2007, section 5.6).
    let sum = -(b + square.sqrt().copysign(b));
    let mut roots = [sum / (3.0 * c), a / sum];
    if roots[1] < roots[0] {
        roots.swap(0, 1);
    }
    for x in roots {
        let curvature = 2.0 * b + 6.0 * c * x;
        if x > 0.0 && x < 1.0 && curvature != 0.0 {
            turns[number] = (x, curvature);
            number += 1;
        }
    }
    (turns, number)
}

/// Where a function is negative between two places, or as low as it gets: Newton's method for its slope, with the secant's
/// curvature from the first step on, or halving.
fn lowest(
    f: impl Fn(f64) -> (f64, f64),
    [mut from, mut to]: [f64; 2],
    mut x: f64,
    mut curvature: f64,
) -> (f64, f64) {
    /// It gets no lower than zero where a parabola falls by less than that part of the value.
    const CERTAIN: f64 = 0.25;
    let mut value = f64::INFINITY;
    let mut last: Option<(f64, f64)> = None;
    for step in 0..MOST_STEPS {
        let (here, slope) = f(x);
        value = here;
        if let Some((before, slope_before)) = last {
            curvature = (slope - slope_before) / (x - before);
        }
        let falls = 0.5 * slope * slope / curvature;
        if value < 0.0 || (curvature > 0.0 && falls <= CERTAIN * value) || to - from <= SAME_PLACE {
            break;
        }
        last = Some((x, slope));
        if slope < 0.0 {
            from = x;
        } else {
            to = x;
        }
        let next = x - slope / curvature;
        // Beside a kink only halving comes nearer.
        let is_between = curvature > 0.0 && next > from && next < to && step % 3 != 2;
        x = if is_between { next } else { 0.5 * (from + to) };
    }
    (x, value)
}

/// A zero between two places with values of different signs: regula falsi, Illinois variant (Dowell and Jarratt 1971).
fn zero(f: impl Fn(f64) -> f64, [mut a, mut b]: [f64; 2], [mut at_a, mut at_b]: [f64; 2]) -> f64 {
    let mut side = 0;
    for _ in 0..MOST_STEPS {
        if !(at_a.is_finite() && at_b.is_finite()) {
            // What is not seen from one end: halve.
            let middle = 0.5 * (a + b);
            let at = f(middle);
            if (at < 0.0) == (at_a < 0.0) {
                (a, at_a) = (middle, at);
            } else {
                (b, at_b) = (middle, at);
            }
            if (b - a).abs() <= SAME_PLACE {
                break;
            }
            continue;
        }
        let x = (a * at_b - b * at_a) / (at_b - at_a);
        let at = f(x);
        if at == 0.0 || (b - a).abs() <= SAME_PLACE {
            return x;
        }
        if (at < 0.0) == (at_a < 0.0) {
            if (x - a).abs() <= SAME_PLACE {
                return x;
            }
            (a, at_a) = (x, at);
            if side == -1 {
                at_b *= 0.5;
            }
            side = -1;
        } else {
            if (x - b).abs() <= SAME_PLACE {
                return x;
            }
            (b, at_b) = (x, at);
            if side == 1 {
                at_a *= 0.5;
            }
            side = 1;
        }
    }
    if at_a.abs() < at_b.abs() { a } else { b }
}
