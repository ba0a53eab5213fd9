//! Centre lines of rods as curves between samples, with their nearest points to other surfaces.
//!
//! The slope of a curve is the polynomial through its values at the nodes. Chebyshev coefficients of the
//! position, the slope and the second derivative are computed once per shape; evaluating a place then costs
//! one recurrence without divisions.

use crate::numerics::lie::{Lanes, Scalar, Vector, VectorSpace};
use crate::robot::effects::contact::plan::Curve;
use crate::robot::effects::contact::shapes::elliptic_tube::Continuation;
use crate::robot::effects::contact::shapes::{bracket, distance};
use crate::robot::effects::contact::state::{ContactState, Span, Term};
use crate::robot::plan::Plan;
use crate::robot::state::Workspace;
use crate::robot::turning::Turning;

/// Safety factor of bounds: between two samples a curve is at most this much longer than its slopes there say, and deviates from its
/// chord at most this much more than a cubic, unless the rod turns by far more than a radian in between.
pub(super) const LONGER: f64 = 1.2;

/// Step of differences along sections that are not round, as a fraction of the distance of two samples.
pub(super) const DIFFERENCE_STEP: f64 = 1e-5;

/// Bound of the deviation of a curve from that cubic, as a fraction of its length.
const ROUGHNESS: f64 = 0.02;

/// Steps of Newton's method for the nearest point of the cubic, from which the search on the curve starts.
const CUBIC_STEPS: usize = 3;

/// Computes the Chebyshev coefficients of the curves that may be in contact.
#[inline(always)]
pub(super) fn expand<G: Turning>(plan: &Plan<G>, work: &Workspace<G>, state: &mut ContactState<G::Pack>) {
    let ContactState { terms, axes, bends, samples, is_near, .. } = state;
    let curves = plan.effects.contacts.curves.iter().zip(bends).zip(&*is_near);
    for ((curve, bend), _) in curves.filter(|(_, is_near)| **is_near) {
        let piece = &plan.pieces[curve.piece];
        let slopes = &work.slope[piece.node_packs()];
        let terms = &mut terms[curve.first_term..][..curve.terms()];
        let degrees = curve.expansion.len() / curve.polynomials();
        let mut begin = G::in_space(plan.frame, work.stations[piece.joined.begin].position);
        let mut from = 0.0;
        *bend = 0.0;
        let ends = curve.integral.breaks().iter().copied().chain([1.0]);
        let parts = terms.chunks_exact_mut(degrees + 1).zip(curve.expansion.chunks_exact(degrees));
        for ((terms, expansion), to) in parts.zip(ends) {
            for (term, weights) in terms.iter_mut().zip(expansion) {
                let mut sum = G::Vector::<G::Pack>::zero();
                for (&slope, &weight) in slopes.iter().zip(weights) {
                    sum += slope * weight;
                }
                let sum = G::map_vector(&sum, |pack: &G::Pack| pack.sum());
                term.slope = G::in_space(plan.frame, sum) * curve.length;
            }
            terms[degrees].slope = Vector::zero();
            begin = complete(terms, begin, to - from);
            // Chebyshev polynomials are no larger than one.
            *bend = bend.max(terms.iter().map(|term| term.bend.dot(term.bend).sqrt()).sum());
            from = to;
        }
        if !curve.is_round {
            expand_axes(plan, work, curve, axes);
        }
        let shape = Shape { terms, axes: &[], breaks: curve.integral.breaks() };
        let last = curve.samples.len() - 1;
        let samples = &mut samples[curve.first_sample..][..=last];
        for (i, x) in [(0, 0.0), (last, 1.0)] {
            let [position, slope, _] = shape.at(x);
            samples[i] = [position, slope];
        }
    }
}

/// Computes position and second derivative of the terms of a polynomial from its slopes, its start and its fraction of the curve;
/// returns its end. (Mason and Handscomb 2003, equations 2.43 and 2.49.)
fn complete(terms: &mut [Term], begin: Vector<f64>, part: f64) -> Vector<f64> {
    let slope = |terms: &[Term], k: usize| terms.get(k).map_or(Vector::zero(), |term| term.slope);
    for k in (0..terms.len()).rev() {
        let above = terms.get(k + 2).map_or(Vector::zero(), |term| term.bend);
        terms[k].bend = above + slope(terms, k + 1) * (4.0 * (k + 1) as f64 / part);
    }
    terms[0].bend = terms[0].bend * 0.5;
    let (mut at_begin, mut at_end) = (Vector::zero(), Vector::zero());
    let mut sign = -1.0;
    for k in 1..terms.len() {
        let below = slope(terms, k - 1) * if k == 1 { 2.0 } else { 1.0 };
        let position = (below - slope(terms, k + 1)) * (part / (4 * k) as f64);
        terms[k].position = position;
        at_begin = at_begin.add_scaled(position, sign);
        at_end += position;
        sign = -sign;
    }
    terms[0].position = begin - at_begin;
    terms[0].position + at_end
}

/// Axes of the sections of a curve that is not round.
fn expand_axes<G: Turning>(
    plan: &Plan<G>,
    work: &Workspace<G>,
    curve: &Curve<G::Pack>,
    axes: &mut [[Vector<f64>; 2]],
) {
    let rotations = &work.rotation[plan.pieces[curve.piece].node_packs()];
    let axes = &mut axes[curve.first_coefficient..][..curve.expansion.len()];
    let units = [Vector::new(0.0, 1.0, 0.0), Vector::new(0.0, 0.0, 1.0)].map(|axis| {
        let axis = G::vector_of(plan.frame, axis);
        G::map_vector(&axis, |&x| G::Pack::splat(x))
    });
    for (axes, weights) in axes.iter_mut().zip(&curve.expansion) {
        for (axis, unit) in axes.iter_mut().zip(units) {
            let mut sum = G::Vector::<G::Pack>::zero();
            for (rotation, &weight) in rotations.iter().zip(weights) {
                sum += G::rotate(rotation, unit) * weight;
            }
            *axis = G::in_space(plan.frame, G::map_vector(&sum, |pack: &G::Pack| pack.sum()));
        }
    }
}

/// The shape of a curve as Chebyshev coefficients.
#[derive(Clone, Copy)]
pub(super) struct Shape<'a> {
    terms: &'a [Term],
    /// Coefficients of the axes of its sections, if it is not round.
    axes: &'a [[Vector<f64>; 2]],
    breaks: &'a [f64],
}

impl<'a> Shape<'a> {
    pub(super) fn new<P>(curve: &'a Curve<P>, terms: &'a [Term], axes: &'a [[Vector<f64>; 2]]) -> Self {
        Self {
            terms: &terms[curve.first_term..][..curve.terms()],
            axes: if curve.is_round {
                &[]
            } else {
                &axes[curve.first_coefficient..][..curve.expansion.len()]
            },
            breaks: curve.integral.breaks(),
        }
    }

    /// Index of the polynomial at a fraction of the length, and the argument of its Chebyshev polynomials.
    #[inline(always)]
    fn locate(&self, x: f64) -> (usize, f64) {
        if self.breaks.is_empty() {
            return (0, 2.0 * x - 1.0);
        }
        let here = self.breaks.partition_point(|&place| place <= x);
        let from = if here > 0 { self.breaks[here - 1] } else { 0.0 };
        let to = self.breaks.get(here).copied().unwrap_or(1.0);
        (here, 2.0 * (x - from) / (to - from) - 1.0)
    }

    /// Position, and its first and second derivatives, at a fraction of the length.
    #[inline(always)]
    pub(super) fn at(&self, x: f64) -> [Vector<f64>; 3] {
        let (here, t) = self.locate(x);
        let number = self.terms.len() / (self.breaks.len() + 1);
        let terms = &self.terms[here * number..][..number];
        let (mut position, mut slope, mut bend) = (terms[0].position, terms[0].slope, terms[0].bend);
        let (mut before, mut value) = (1.0, t);
        for term in &terms[1..] {
            position = position.add_scaled(term.position, value);
            slope = slope.add_scaled(term.slope, value);
            bend = bend.add_scaled(term.bend, value);
            (before, value) = (value, 2.0 * t * value - before);
        }
        [position, slope, bend]
    }

    /// Axes of the section at a fraction of the length: perpendicular unit vectors.
    fn axes_at(&self, x: f64) -> [Vector<f64>; 2] {
        let (here, t) = self.locate(x);
        let number = self.axes.len() / (self.breaks.len() + 1);
        let own = &self.axes[here * number..][..number];
        let mut axes = own[0];
        let (mut before, mut value) = (1.0, t);
        for coefficients in &own[1..] {
            for (axis, &coefficient) in axes.iter_mut().zip(coefficients) {
                *axis = axis.add_scaled(coefficient, value);
            }
            (before, value) = (value, 2.0 * t * value - before);
        }
        let [y, z] = axes;
        let y = y * y.dot(y).sqrt().recip();
        let z = z - y * y.dot(z);
        [y, z * z.dot(z).sqrt().recip()]
    }
}

/// The part of a curve between two samples.
#[derive(Clone, Copy)]
pub(super) struct Part<'a> {
    shape: Shape<'a>,
    /// Among the parts of its curve.
    pub(super) index: usize,
    /// Start and length as fractions of the curve.
    pub(super) from: f64,
    pub(super) part: f64,
    /// Arc length of the rod at its start, and its length.
    pub(super) arc: f64,
    pub(super) length: f64,
    pub(super) ends: [[Vector<f64>; 2]; 2],
    pub(super) radii: [f64; 2],
    /// Upper bound of its second derivative.
    pub(super) bend: f64,
    /// Half extents of the sections at both ends, if they are not round.
    pub(super) half_extents: Option<[[f64; 2]; 2]>,
}

/// A part of a curve, from the samples of its ends.
#[inline(always)]
pub(super) fn part<'a, P>(
    curve: &Curve<P>,
    index: usize,
    shape: Shape<'a>,
    bend: f64,
    seen: &[[Vector<f64>; 2]],
) -> Part<'a> {
    let samples = [&curve.samples[index], &curve.samples[index + 1]];
    let (from, part) = (samples[0].x, samples[1].x - samples[0].x);
    Part {
        shape,
        index,
        from,
        part,
        arc: curve.start + from * curve.length,
        length: part * curve.length,
        ends: [index, index + 1].map(|i| [seen[i][0], seen[i][1] * part]),
        radii: samples.map(|sample| sample.radius),
        bend: bend * part * part,
        half_extents: (!curve.is_round).then(|| samples.map(|sample| sample.half_extents)),
    }
}

/// The cubic through positions and slopes of both ends: its second derivative at the start, and the change of that.
fn cubic([[p, a], [q, b]]: [[Vector<f64>; 2]; 2]) -> [Vector<f64>; 2] {
    let way = q - p;
    [(way * 3.0 - a * 2.0 - b) * 2.0, (a + b - way * 2.0) * 6.0]
}

/// Bounding volume of a part with these ends and this largest radius: a cubic deviates from its chord by at most an eighth of its largest
/// second derivative.
pub(super) fn span(ends: [[Vector<f64>; 2]; 2], thickest: f64) -> Span {
    let [[p, a], [q, b]] = ends;
    let [start, growth] = cubic(ends);
    let end = start + growth;
    let bend = start.dot(start).max(end.dot(end)).sqrt();
    let length = a.dot(a).max(b.dot(b)).sqrt();
    Span::new([p, q], thickest + LONGER * bend / 8.0 + ROUGHNESS * length)
}

impl Part<'_> {
    /// The semi-axes of the section at a fraction of the part, if it is not round.
    pub(super) fn semi_axes(&self, x: f64) -> Option<[Vector<f64>; 2]> {
        let [begin, end] = self.half_extents?;
        let axes = self.shape.axes_at(self.from + self.part * x);
        Some([0, 1].map(|i| axes[i] * (begin[i] + (end[i] - begin[i]) * x)))
    }

    /// The continuation of a tube with these sections at a fraction of the part.
    pub(super) fn continuation(&self, x: f64) -> Continuation {
        let [_, slope, bend] = self.at(x);
        let square = slope.dot(slope).max(f64::MIN_POSITIVE);
        // Towards the middle, so that it is within the part.
        let next = if x < 0.5 { x + DIFFERENCE_STEP } else { x - DIFFERENCE_STEP };
        let across = bend - slope * (slope.dot(bend) / square);
        Continuation {
            bend: across * square.recip(),
            beyond: self.semi_axes(next).unwrap_or_default(),
            step: (next - x) * square.sqrt(),
        }
    }

    /// Position at a fraction of the part, with first and second derivatives with respect to the fraction.
    #[inline(always)]
    pub(super) fn at(&self, x: f64) -> [Vector<f64>; 3] {
        let [position, slope, bend] = self.shape.at(self.from + self.part * x);
        [position, slope * self.part, bend * (self.part * self.part)]
    }

    pub(super) fn radius(&self, x: f64) -> f64 {
        self.radii[0] + self.widening() * x
    }

    /// Derivative of the radius with respect to the fraction of the part.
    pub(super) fn widening(&self) -> f64 {
        self.radii[1] - self.radii[0]
    }

    /// Bound of the second derivative of the edges of its sections due to their rotation: the largest half extent times the square of
    /// the angle.
    pub(super) fn turn(&self) -> f64 {
        let (Some([y, z]), Some([y_end, z_end])) = (self.semi_axes(0.0), self.semi_axes(1.0)) else {
            return 0.0;
        };
        let squared = |a: Vector<f64>, b: Vector<f64>| {
            let cosine = a.dot(b) / (a.dot(a) * b.dot(b)).sqrt();
            2.0 * (1.0 - cosine)
        };
        self.radii[0].max(self.radii[1]) * (squared(y, y_end) + squared(z, z_end))
    }

    /// Upper bound of its length and of the change of its radius.
    pub(super) fn reach(&self) -> f64 {
        let [[_, a], [_, b]] = self.ends;
        LONGER * a.dot(a).max(b.dot(b)).sqrt() + (self.radii[1] - self.radii[0]).abs()
    }

    /// Slope along the curve of the distance of a point from the surface, times its distance from the axis: zero at the nearest
    /// point. `way` leads from the point to the curve. The surface is that of the union of balls about the curve, so that forces are
    /// gradients of the overlap also where it tapers.
    fn rise(&self, way: Vector<f64>, slope: Vector<f64>) -> f64 {
        let widening = self.widening();
        let rise = way.dot(slope);
        if widening == 0.0 { rise } else { rise - widening * way.dot(way).sqrt() }
    }

    /// Derivative of [`Self::rise`] along the curve.
    fn rise_change(&self, [way, slope, bend]: [Vector<f64>; 3]) -> f64 {
        let widening = self.widening();
        let change = slope.dot(slope) + way.dot(bend);
        if widening == 0.0 { change } else { change - widening * way.dot(slope) / way.dot(way).sqrt() }
    }

    /// The place nearest to a point, by Newton's method within a bracket, from the nearest place of the cubic.
    pub(super) fn nearest_to(&self, point: Vector<f64>) -> f64 {
        let [[p, a], [q, b]] = self.ends;
        let [start, end] = [self.rise(p - point, a), self.rise(q - point, b)];
        if start >= 0.0 && end >= 0.0 {
            return 0.0;
        }
        if start <= 0.0 && end <= 0.0 {
            return 1.0;
        }
        if start > 0.0 {
            // Furthest inside: one of the ends.
            let [to_start, to_end] =
                [0, 1].map(|i| distance::between(point, self.ends[i][0]) - self.radii[i]);
            return if to_start <= to_end { 0.0 } else { 1.0 };
        }
        let mut x = start / (start - end);
        let [bend, growth] = cubic(self.ends);
        for _ in 0..CUBIC_STEPS {
            let way = p + (a + (bend * 0.5 + growth * (x / 6.0)) * x) * x - point;
            let slope = a + (bend + growth * (0.5 * x)) * x;
            let change = self.rise_change([way, slope, bend + growth * x]);
            let next = x - self.rise(way, slope) / change;
            if !(change > 0.0 && next > 0.0 && next < 1.0) {
                break;
            }
            x = next;
        }
        bracket::root(x, |x| {
            let [position, slope, bend] = self.at(x);
            let way = position - point;
            (self.rise(way, slope), self.rise_change([way, slope, bend]))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The Chebyshev coefficients of a polynomial of degree 3 in each axis, and that polynomial with its derivatives.
    fn curve() -> (Vec<Term>, impl Fn(f64) -> [Vector<f64>; 3]) {
        let slope = [Vector::new(0.4, 0.1, -0.2), Vector::new(0.1, 0.3, 0.0), Vector::new(-0.05, 0.02, 0.1)];
        let zero = Term { position: Vector::zero(), slope: Vector::zero(), bend: Vector::zero() };
        let mut terms: Vec<_> = slope.iter().map(|&slope| Term { slope, ..zero }).chain([zero]).collect();
        let begin = Vector::new(0.3, -0.1, 0.2);
        complete(&mut terms, begin, 1.0);
        let exact = move |x: f64| {
            let t = 2.0 * x - 1.0;
            let [c, d, e] = slope;
            // Half of the integrals of 1, t and 2 t^2 - 1 from -1.
            let position =
                c * (t + 1.0) + d * ((t * t - 1.0) / 2.0) + e * ((2.0 * t * t * t + 2.0) / 3.0 - (t + 1.0));
            [begin + position * 0.5, c + d * t + e * (2.0 * t * t - 1.0), (d + e * (4.0 * t)) * 2.0]
        };
        (terms, exact)
    }

    #[test]
    fn coefficients_give_position_and_derivatives() {
        let (terms, exact) = curve();
        let shape = Shape { terms: &terms, axes: &[], breaks: &[] };
        for x in [0.0, 0.2, 0.7, 1.0] {
            for (found, expected) in shape.at(x).into_iter().zip(exact(x)) {
                assert!(distance::between(found, expected) < 1e-15, "{x} {found:?} {expected:?}");
            }
        }
    }

    /// All of a curve, with a radius.
    fn whole(shape: Shape<'_>, ends: [[Vector<f64>; 2]; 2]) -> Part<'_> {
        let (radii, bend, half_extents) = ([0.1; 2], 1.0, None);
        Part { shape, index: 0, from: 0.0, part: 1.0, arc: 0.0, length: 1.0, ends, radii, bend, half_extents }
    }

    /// Where the cubic through the ends is the curve, Newton's method starts at the nearest place: its increments are rounding,
    /// and may lead out of its bounds.
    #[test]
    fn nearest_places_of_cubics_do_not_depend_on_rounding() {
        let (terms, exact) = curve();
        let shape = Shape { terms: &terms, axes: &[], breaks: &[] };
        let ends = [0.0, 1.0].map(|x| {
            let [position, slope, _] = exact(x);
            [position, slope]
        });
        let part = whole(shape, ends);
        for i in 0..2000 {
            let x = 0.05 + 0.9 * f64::from(i) / 1999.0;
            let [position, slope, _] = exact(x);
            let across = slope.cross(Vector::new(0.3, -0.5, 0.8));
            let found = part.nearest_to(position + across * 0.3);
            assert!((found - x).abs() < 1e-13, "{i}: {x} {found}");
        }
    }

    #[test]
    fn nearest_places_are_seen_at_a_right_angle_and_spans_hold_all() {
        let (terms, exact) = curve();
        let shape = Shape { terms: &terms, axes: &[], breaks: &[] };
        let ends = [0.0, 1.0].map(|x| {
            let [position, slope, _] = exact(x);
            [position, slope]
        });
        let part = whole(shape, ends);
        let span = span(part.ends, 0.1);
        for i in 0..40 {
            let angle = 0.7 * f64::from(i);
            let point = exact(f64::from(i) / 39.0)[0] + Vector::new(angle.cos(), angle.sin(), 0.3) * 0.1;
            let x = part.nearest_to(point);
            let [position, slope, _] = part.at(x);
            let is_end = x == 0.0 || x == 1.0;
            assert!(is_end || (point - position).dot(slope).abs() < 1e-14, "{i}");
            let least = (0..=1000)
                .map(|k| distance::between(point, part.at(f64::from(k) / 1000.0)[0]))
                .fold(f64::INFINITY, f64::min);
            assert!(distance::between(point, position) <= least + 1e-12, "{i}");
            assert!(span.distance(point) <= least - 0.1, "{i}");
        }
    }
}
