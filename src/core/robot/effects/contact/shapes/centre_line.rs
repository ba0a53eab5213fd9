//! The centre line of a tube: a smooth curve through points, and its place nearest to another point.
//!
//! The curve is the cubic spline through the points over the lengths of the chords between them, twice continuously
//! differentiable, with not-a-knot ends (de Boor 1978, chapter IV): through two points a straight line, through three
//! a parabola. Its pieces are divided so that each turns little, and lie in a tree of balls; Newton's method finds the
//! nearest place of those that may hold it.

use super::bracket;
use super::distance::between;
use crate::description::signal::{Spline, Table};
use crate::numerics::lie::Vector;
use std::ops::Range;

/// A part of the curve turns by at most about this many radians, with at most [`MOST_PARTS`] parts between two points.
const TURN: f64 = 0.4;
const MOST_PARTS: f64 = 32.0;

/// Number of places at which the curvature of a part is evaluated.
const SAMPLES: usize = 8;

/// The curve between two places, as a polynomial of a fraction from 0 to 1.
#[derive(Clone, Debug)]
struct Part {
    start: Vector<f64>,
    /// First, second and third derivative at the start.
    slope: Vector<f64>,
    bend: Vector<f64>,
    growth: Vector<f64>,
    /// Length of the curve up to its start, by chords.
    from: f64,
}

/// The place of the curve nearest to a point.
#[derive(Clone, Copy, Debug)]
pub(super) struct Nearest {
    /// Vector from the curve to the point.
    pub(super) way: Vector<f64>,
    /// Unit tangent, and the curvature as a vector, per metre.
    pub(super) along: Vector<f64>,
    pub(super) bend: Vector<f64>,
    /// Length of the curve before this place.
    pub(super) from: f64,
    /// The end beyond whose plane the point is.
    pub(super) beyond: Option<usize>,
}

/// A smooth curve through points.
#[derive(Clone, Debug)]
pub(crate) struct CentreLine {
    parts: Vec<Part>,
    /// Centres and radii of balls around the rows of parts of a binary tree, depth first.
    balls: Vec<(Vector<f64>, f64)>,
    length: f64,
}

/// The tightest place of a curve.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Tightest {
    pub(crate) place: Vector<f64>,
    /// A tube with a smaller radius does not intersect itself; infinite for a straight line.
    pub(crate) radius: f64,
}

impl Part {
    fn end(&self) -> Vector<f64> {
        self.at(1.0)[0]
    }

    /// Position, and its first and second derivatives.
    fn at(&self, x: f64) -> [Vector<f64>; 3] {
        let Self { start, slope, bend, growth, .. } = self;
        let position = *start + (*slope + (*bend * 0.5 + *growth * (x / 6.0)) * x) * x;
        [position, *slope + (*bend + *growth * (0.5 * x)) * x, *bend + *growth * x]
    }

    /// The part from a fraction on, of this width.
    fn cut(&self, from: f64, width: f64) -> Self {
        let [start, slope, bend] = self.at(from);
        Self {
            start,
            slope: slope * width,
            bend: bend * (width * width),
            growth: self.growth * (width * width * width),
            from: 0.0,
        }
    }

    /// A ball around it: a cubic is no further from its chord than an eighth of its largest second derivative.
    fn ball(&self) -> (Vector<f64>, f64) {
        let end = self.end();
        let aside = size(self.bend).max(size(self.bend + self.growth)) / 8.0;
        ((self.start + end) * 0.5, 0.5 * between(self.start, end) + aside)
    }

    /// Place nearest to a point, by Newton's method within a bracket; if there are several local minima, one of them.
    fn nearest_to(&self, point: Vector<f64>) -> f64 {
        let slope_at = |x: f64| {
            let [position, slope, bend] = self.at(x);
            let way = position - point;
            (way.dot(slope), slope.dot(slope) + way.dot(bend))
        };
        let [start, end] = [slope_at(0.0).0, slope_at(1.0).0];
        if start >= 0.0 && end >= 0.0 {
            return 0.0;
        }
        if start <= 0.0 && end <= 0.0 {
            return 1.0;
        }
        if start > 0.0 {
            return if between(point, self.start) <= between(point, self.end()) { 0.0 } else { 1.0 };
        }
        bracket::root(start / (start - end), slope_at)
    }
}

impl CentreLine {
    /// A ball around the curve.
    pub(crate) fn ball(&self) -> (Vector<f64>, f64) {
        self.balls[0]
    }

    /// The curve through two or more points; consecutive points must differ.
    pub(crate) fn new(points: &[Vector<f64>]) -> Self {
        let mut times = vec![0.0];
        for ends in points.windows(2) {
            times.push(times[times.len() - 1] + between(ends[0], ends[1]));
        }
        let values = points.iter().map(|point| point.to_array()).collect();
        let table = Table::new(times.clone(), values).expect("points follow each other at a distance");
        let spline = Spline::new(&table);
        let mut parts = Vec::new();
        let mut length = 0.0;
        for ends in times.windows(2) {
            let h = ends[1] - ends[0];
            let [[start, slope, bend], [_, _, next]] =
                [ends[0], ends[1]].map(|t| spline.motion(t).map(Vector::from));
            let growth = (next - bend) * (h * h);
            let piece = Part { start, slope: slope * h, bend: bend * (h * h), growth, from: 0.0 };
            let turns = size(piece.bend).max(size(piece.bend + growth)) / h;
            let number = (turns / TURN).ceil().clamp(1.0, MOST_PARTS);
            for k in 0..number as usize {
                let part = piece.cut(k as f64 / number, number.recip());
                parts.push(Part { from: length, ..part.clone() });
                length += between(part.start, part.end());
            }
        }
        let mut balls = Vec::with_capacity(2 * parts.len());
        enclose(&parts, &mut balls);
        Self { parts, balls, length }
    }

    /// Length of the curve, by chords.
    pub(super) fn length(&self) -> f64 {
        self.length
    }

    /// Both ends, with the direction out of each.
    pub(super) fn ends(&self) -> [[Vector<f64>; 2]; 2] {
        let (first, last) = (&self.parts[0], &self.parts[self.parts.len() - 1]);
        let [end, slope, _] = last.at(1.0);
        [[first.start, unit(first.slope) * -1.0], [end, unit(slope)]]
    }

    /// Largest distance of its points from the origin.
    pub(super) fn reach(&self) -> f64 {
        let ball_of = |part: &Part| part.ball();
        self.parts.iter().map(ball_of).map(|(centre, radius)| size(centre) + radius).fold(0.0, f64::max)
    }

    /// Places of the curve, `number` of them on each part.
    pub(crate) fn places(&self, number: usize) -> Vec<Vector<f64>> {
        let inner =
            |part: &Part| -> Vec<_> { (0..number).map(|k| part.at(k as f64 / number as f64)[0]).collect() };
        let end = self.parts[self.parts.len() - 1].end();
        self.parts.iter().flat_map(inner).chain([end]).collect()
    }

    /// Largest curvature, per metre.
    pub(super) fn most_bent(&self) -> f64 {
        self.bends().map(|(_, curvature)| curvature).fold(0.0, f64::max)
    }

    /// Places with the curvature there.
    fn bends(&self) -> impl Iterator<Item = (Vector<f64>, f64)> + '_ {
        self.parts.iter().flat_map(|part| {
            (0..=SAMPLES).map(|k| {
                let [position, slope, bend] = part.at(k as f64 / SAMPLES as f64);
                (position, size(slope.cross(bend)) / size(slope).powi(3))
            })
        })
    }

    /// The place that limits the radius of a tube around the curve: where it bends most, or comes closest to itself. Both follow from the
    /// smallest circle through one place that is tangent to the curve at another (global radius of curvature: Gonzalez and Maddocks
    /// 1999).
    pub(crate) fn tightest(&self) -> Tightest {
        let bent = self.bends().map(|(place, curvature)| Tightest { place, radius: curvature.recip() });
        let at = |part: &Part| (part.start, part.slope);
        let [_, [end, outward]] = self.ends();
        let places: Vec<_> = self.parts.iter().map(at).chain([(end, outward)]).collect();
        let touching = places.iter().enumerate().flat_map(|(i, &(place, slope))| {
            places.iter().enumerate().filter(move |(j, _)| *j != i).map(move |(_, &(other, _))| {
                let way = other - place;
                let across = size(way.cross(slope)) / size(slope);
                let radius = if across > 0.0 { 0.5 * way.dot(way) / across } else { f64::INFINITY };
                Tightest { place, radius }
            })
        });
        bent.chain(touching).min_by(|a, b| a.radius.total_cmp(&b.radius)).expect("the curve has places")
    }

    /// The place nearest to a point.
    pub(super) fn nearest(&self, point: Vector<f64>) -> Nearest {
        let mut best = (f64::INFINITY, 0, 0.0);
        self.search_parts(point, 0..self.parts.len(), &self.balls, &mut best);
        let (_, k, x) = best;
        let part = &self.parts[k];
        let [position, slope, bend] = part.at(x);
        let (way, square) = (point - position, slope.dot(slope));
        let along = slope * square.sqrt().recip();
        let above = along.dot(way);
        let beyond = if k == 0 && x == 0.0 && above < 0.0 {
            Some(0)
        } else if k + 1 == self.parts.len() && x == 1.0 && above > 0.0 {
            Some(1)
        } else {
            None
        };
        let bend = (bend - along * along.dot(bend)) * square.recip();
        Nearest { way, along, bend, from: part.from + x * square.sqrt(), beyond }
    }

    /// Searches a row of parts for a nearer place, the nearer half first. `known` is the best so far: distance, part, and fraction of the
    /// part.
    fn search_parts(
        &self,
        point: Vector<f64>,
        row: Range<usize>,
        balls: &[(Vector<f64>, f64)],
        best: &mut (f64, usize, f64),
    ) {
        let least = |(centre, radius): (Vector<f64>, f64)| between(point, centre) - radius;
        if least(balls[0]) >= best.0 {
            return;
        }
        if row.len() == 1 {
            let part = &self.parts[row.start];
            let x = part.nearest_to(point);
            let distance = between(point, part.at(x)[0]);
            if distance < best.0 {
                *best = (distance, row.start, x);
            }
            return;
        }
        let half = row.len() / 2;
        let (first, second) = balls[1..].split_at(2 * half - 1);
        let mut halves = [(row.start..row.start + half, first), (row.start + half..row.end, second)];
        if least(second[0]) < least(first[0]) {
            halves.reverse();
        }
        for (row, balls) in halves {
            self.search_parts(point, row, balls, best);
        }
    }
}

/// Adds the balls of a row of parts, depth first.
fn enclose(parts: &[Part], balls: &mut Vec<(Vector<f64>, f64)>) {
    let own = balls.len();
    let middle = &parts[parts.len() / 2];
    let centre = middle.start;
    let reach = parts
        .iter()
        .map(Part::ball)
        .map(|(there, radius)| between(centre, there) + radius)
        .fold(0.0, f64::max);
    balls.push(if parts.len() == 1 { middle.ball() } else { (centre, reach) });
    if parts.len() > 1 {
        let (first, second) = parts.split_at(parts.len() / 2);
        enclose(first, balls);
        enclose(second, balls);
    }
    debug_assert_eq!(balls.len(), own + 2 * parts.len() - 1);
}

fn size(v: Vector<f64>) -> f64 {
    v.dot(v).sqrt()
}

fn unit(v: Vector<f64>) -> Vector<f64> {
    v * size(v).recip()
}
