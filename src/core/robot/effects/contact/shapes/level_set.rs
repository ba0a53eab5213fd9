//! Distances from the surface on which a tricubic spline is zero.
//!
//! The spline passes through signed distances from a shape, but is not a distance itself: its gradient is not of unit length, and close
//! to edges and to places that are equally far from several parts of the shape, it is smoother than one. The surface on which it is zero is smooth. Contact takes the
//! exact distance from that surface, whose gradient is a unit vector, so that forces have an energy. Nearest places y of a point x solve
//! `phi(y) = 0` and `x - y = lambda grad phi(y)` by Newton's method. Cells that the surface crosses are leaves of a tree of boxes, by which the
//! global minimum is found.

use super::distance::Distance;
use super::tricubic::{Local, Tricubic};
use crate::numerics::lie::{Symmetric, Vector};

/// Maximum number of Newton steps, far more than a start in the cell of a nearest place takes.
const MOST_STEPS: usize = 30;

/// The iteration ends with steps below this part of the spacing, after which the error is its square.
const SAME_PLACE: f64 = 1e-8;

/// Longest step, relative to the spacing: polynomials change between cells.
const LONGEST_STEP: f64 = 1.0;

/// Smallest slope of a spline through distances at which its surface has a normal.
const LEAST_SLOPE: f64 = 1e-3;

/// A place whose distance differs from the spline's value by less than this part of the spacing is the nearest one: the value is close to
/// the distance wherever no other place is about equally near, and that place would be nearer by no more.
const CERTAIN: f64 = 1e-3;

/// A candidate must be nearer by this fraction to be examined.
const NEARER: f64 = 1e-9;

/// Smallest determinant over the product of diagonal entries at which second derivatives count as positive definite; otherwise they are
/// replaced by those of a plane.
const DEFINITE: f64 = 1e-6;

/// A point counts as nearest up to this fraction of the radius of curvature, on the concave side: beyond, several places are nearest.
const LEAST_STRETCH: f64 = 0.01;

/// Number of zeros between neighbouring values at which slopes are looked at.
const LOOKED_AT: usize = 500;

/// Halvings of the interval between the values to such a zero.
const HALVINGS_TO_ZERO: usize = 12;

/// Values whose typical slope is within these bounds count as distances; others are scaled to a typical slope of one, so that sizes and
/// units of functions with the same zeros do not matter.
const SLOPES_OF_DISTANCES: [f64; 2] = [0.5, 2.0];

/// Where the border of the grid is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Rim {
    /// Outside of the shape, as all that is beyond.
    Outside,
    /// Within the shape, which surrounds a hollow.
    Inside,
    /// The surface crosses it, and continues as the spline does.
    Crossed,
}

/// The surface on which a spline is zero.
#[derive(Clone, Debug)]
pub(crate) struct LevelSet {
    field: Tricubic,
    rim: Rim,
    /// Cells that the surface crosses, with boxes around them: a branch is followed by its first half.
    nodes: Vec<Node>,
    /// Largest depth of a value.
    depth: f64,
    hollowness: f64,
    /// Bounds of the spline's slope, and of its mixed second and third derivatives.
    bounds: [f64; 3],
}

#[derive(Clone, Copy, Debug)]
struct Node {
    low: Vector<f64>,
    high: Vector<f64>,
    kind: Kind,
}

#[derive(Clone, Copy, Debug)]
enum Kind {
    /// With the index of the second half.
    Branch(usize),
    Cell(Slab),
}

/// The part of a cell that may contain the surface.
#[derive(Clone, Copy, Debug)]
struct Slab {
    centre: Vector<f64>,
    normal: Vector<f64>,
    /// Heights over the centre along the normal, and radius across it.
    heights: [f64; 2],
    radius: f64,
}

/// A place on the surface that is nearest to a point.
#[derive(Clone, Copy, Debug)]
struct Foot {
    place: Vector<f64>,
    local: Local,
    distance: f64,
}

impl LevelSet {
    /// The surface of a spline through values, at least two along each axis and with different signs, of which the third axis varies
    /// fastest.
    pub(crate) fn new(values: &[f64], shape: [usize; 3], spacing: [f64; 3]) -> Self {
        let mut field = Tricubic::new(values, shape, spacing);
        let rim = rim_of(values, shape);
        let slope = typical_slope(&field, values);
        let [least, most] = SLOPES_OF_DISTANCES;
        let scale = if slope > 0.0 && !(least..=most).contains(&slope) { slope.recip() } else { 1.0 };
        if scale != 1.0 {
            field.scale(scale);
        }
        let depth = scale * values.iter().fold(0.0_f64, |depth, value| depth.max(-value));
        let mut cells = Vec::new();
        let [rows, columns, layers] = shape.map(|n| n - 1);
        for i in 0..rows {
            for j in 0..columns {
                cells.extend((0..layers).filter_map(|k| crossed(&field, [i, j, k])));
            }
        }
        let bounds = field.bounds();
        let mut found = Self { field, rim, nodes: Vec::new(), depth, hollowness: 0.0, bounds };
        if !cells.is_empty() {
            enclose(&mut cells, &mut found.nodes);
        }
        found.hollowness = found.most_hollow();
        found
    }

    /// Half the thickness at its thickest place, by the values; infinite if the shape goes on beyond the grid.
    pub(crate) fn depth(&self) -> f64 {
        if self.rim == Rim::Outside { self.depth } else { f64::INFINITY }
    }

    /// Largest concave curvature at places in all cells, per metre.
    pub(crate) fn hollowness(&self) -> f64 {
        self.hollowness
    }

    /// Corners of a box around the shape; `None` if it goes on beyond the grid.
    pub(crate) fn extent(&self) -> Option<[Vector<f64>; 2]> {
        let first = self.nodes.first().filter(|_| self.rim == Rim::Outside)?;
        Some([first.low, first.high])
    }

    /// Distance between the surface and a place that should lie on it, by the value and slope there.
    pub(crate) fn error_at(&self, place: Vector<f64>) -> f64 {
        let Local { value, gradient, .. } = self.field.at(place);
        value.abs() / gradient.dot(gradient).sqrt().max(LEAST_SLOPE)
    }

    fn smallest_spacing(&self) -> f64 {
        self.field.spacing.into_iter().fold(f64::INFINITY, f64::min)
    }

    fn most_hollow(&self) -> f64 {
        let curvatures = self.nodes.iter().filter_map(|node| {
            let Kind::Cell(slab) = node.kind else { return None };
            let foot = self.descend(slab.centre, slab.centre)?;
            let within = within(foot.place, node);
            Some(if within { -foot.bends()[0] } else { 0.0 })
        });
        curvatures.fold(0.0, f64::max)
    }

    /// The place on the surface nearest to a point, by Newton's method from a start.
    fn descend(&self, point: Vector<f64>, mut place: Vector<f64>) -> Option<Foot> {
        let size = self.smallest_spacing();
        for _ in 0..MOST_STEPS {
            let local = self.field.at(place);
            let slope = local.gradient.dot(local.gradient).sqrt();
            if slope < LEAST_SLOPE || slope.is_nan() {
                return None;
            }
            let normal = local.gradient * slope.recip();
            let way = point - place;
            let multiplier = way.dot(normal) / slope;
            let along = normal * (-local.value / slope);
            let tangents = tangents(normal);
            let [a, b] = tangents;
            let [bend_a, bend_b] = tangents.map(|tangent| local.bend.times(tangent));
            let full = [
                1.0 + multiplier * a.dot(bend_a),
                multiplier * a.dot(bend_b),
                1.0 + multiplier * b.dot(bend_b),
            ];
            let is_definite =
                full[0] > 0.0 && full[0] * full[2] - full[1] * full[1] > DEFINITE * full[0] * full[2];
            let ([p, q, r], rest) = match is_definite {
                true => (full, way - local.bend.times(along) * multiplier),
                false => ([1.0, 0.0, 1.0], way),
            };
            let [first, second] = [a.dot(rest), b.dot(rest)];
            let determinant = p * r - q * q;
            let step = along
                + a * ((r * first - q * second) / determinant)
                + b * ((p * second - q * first) / determinant);
            let length = step.dot(step).sqrt();
            let most = LONGEST_STEP * size;
            place += step * if length > most { most / length } else { 1.0 };
            if length <= SAME_PLACE * size {
                return self.foot(point, place);
            }
        }
        None
    }

    /// A place that is nearest up to the square of the last step; `None` beyond the border, if the surface does not go on there.
    fn foot(&self, point: Vector<f64>, place: Vector<f64>) -> Option<Foot> {
        if self.rim != Rim::Crossed && !self.field.contains(place) {
            return None;
        }
        let local = self.field.at(place);
        let slope = local.gradient.dot(local.gradient).sqrt();
        // The value left is a part of the distance.
        let distance = (point - place).dot(local.gradient) / slope + local.value / slope;
        distance.is_finite().then_some(Foot { place, local, distance })
    }

    /// The nearest place of the whole surface.
    fn nearest(&self, point: Vector<f64>) -> Option<Foot> {
        let mut best: Option<Foot> = None;
        if self.rim == Rim::Crossed || self.field.contains(point) {
            let Local { value, gradient, .. } = self.field.at(point);
            let square = gradient.dot(gradient).max(LEAST_SLOPE * LEAST_SLOPE);
            best = self.descend(point, point - gradient * (value / square));
            if let Some(foot) = best
                && (foot.distance - value).abs() <= CERTAIN * self.smallest_spacing()
            {
                return best;
            }
        }
        if !self.nodes.is_empty() {
            self.search(point, 0, &mut best);
        }
        best
    }

    fn search(&self, point: Vector<f64>, node: usize, best: &mut Option<Foot>) {
        let limit = best.map_or(f64::INFINITY, |foot| foot.distance.abs() * (1.0 - NEARER));
        if self.nodes[node].bound(point) >= limit {
            return;
        }
        match self.nodes[node].kind {
            Kind::Cell(slab) => {
                if let Some(foot) = self.descend(point, slab.nearest(point))
                    && foot.distance.abs() < limit
                {
                    *best = Some(foot);
                }
            }
            Kind::Branch(second) => {
                let mut halves = [node + 1, second];
                let [first, other] = halves.map(|half| self.nodes[half].bound(point));
                if other < first {
                    halves.reverse();
                }
                halves.into_iter().for_each(|half| self.search(point, half, best));
            }
        }
    }

    /// Distance of a point.
    pub(crate) fn distance(&self, point: Vector<f64>) -> Distance {
        match self.nearest(point) {
            Some(foot) => foot.seen(),
            // Without a nearest place: the estimate by value and slope.
            None => {
                let Local { value, gradient, .. } = self.field.at(point);
                let slope = gradient.dot(gradient).sqrt();
                let is_sloped = slope > LEAST_SLOPE;
                let normal = if is_sloped { gradient * slope.recip() } else { Vector::new(0.0, 0.0, 1.0) };
                let value = value / slope.max(LEAST_SLOPE);
                Distance { value, normal, curvature: Symmetric::diagonal(0.0) }
            }
        }
    }

    /// Whether a point is outside and certainly farther from the surface than `reach`.
    pub(crate) fn is_certainly_beyond(&self, point: Vector<f64>, reach: f64) -> bool {
        let (reach, is_within) = (reach.max(0.0), self.field.contains(point));
        if self.rim == Rim::Crossed {
            let beyond = point
                .to_array()
                .into_iter()
                .enumerate()
                .map(|(axis, x)| (reach - x).max(x + reach - self.field.length(axis)).max(0.0));
            let beyond = beyond.fold(0.0, f64::max);
            if beyond > 0.0 {
                // Each component of the slope changes with mixed derivatives along the two other axes.
                let [slope, mixed, triple] = self.bounds;
                let steepest = slope + 3.0_f64.sqrt() * beyond * (2.0 * mixed + triple * beyond);
                return self.field.at(point).value > steepest * reach;
            }
        }
        if !is_within && self.rim == Rim::Inside {
            return false;
        }
        let Some(first) = self.nodes.first() else { return false };
        if self.rim == Rim::Outside && first.bound(point) > reach {
            return true;
        }
        (!is_within || self.field.at(point).value > 0.0) && self.is_beyond(point, reach, 0)
    }

    /// Whether all cells of a node are farther from a point than `reach`.
    fn is_beyond(&self, point: Vector<f64>, reach: f64, node: usize) -> bool {
        self.nodes[node].bound(point) > reach
            || match self.nodes[node].kind {
                Kind::Cell(_) => false,
                Kind::Branch(second) => {
                    self.is_beyond(point, reach, node + 1) && self.is_beyond(point, reach, second)
                }
            }
    }
}

impl Foot {
    /// The second fundamental form in two tangents: both principal curvatures and a rotation of the tangents to them. The smaller one is first.
    fn principal(&self) -> ([f64; 2], [Vector<f64>; 2]) {
        let Local { gradient, bend, .. } = self.local;
        let slope = gradient.dot(gradient).sqrt();
        let [a, b] = tangents(gradient * slope.recip());
        let [of_a, of_b] = [a, b].map(|tangent| bend.times(tangent) * slope.recip());
        let [p, q, r] = [a.dot(of_a), a.dot(of_b), b.dot(of_b)];
        let (mean, half) = (0.5 * (p + r), 0.5 * (p - r));
        let size = half.hypot(q);
        // The direction of the larger curvature, at half the angle of (half, q).
        let angle = 0.5 * q.atan2(half);
        let (sine, cosine) = angle.sin_cos();
        let large = a * cosine + b * sine;
        let small = b * cosine - a * sine;
        ([mean - size, mean + size], [small, large])
    }

    /// The principal curvatures, positive where the shape is convex.
    fn bends(&self) -> [f64; 2] {
        self.principal().0
    }

    /// The distance of the point: its second derivative has the eigenvalues `k / (1 + d k)`.
    fn seen(&self) -> Distance {
        let slope = self.local.gradient.dot(self.local.gradient).sqrt();
        let (bends, directions) = self.principal();
        let mut curvature = Symmetric::diagonal(0.0);
        for (bend, direction) in bends.into_iter().zip(directions) {
            let stretch = (1.0 + self.distance * bend).max(LEAST_STRETCH);
            curvature += Symmetric::square(direction) * (bend / stretch);
        }
        Distance { value: self.distance, normal: self.local.gradient * slope.recip(), curvature }
    }
}

impl Node {
    /// Lower bound of the distance of a point.
    fn bound(&self, point: Vector<f64>) -> f64 {
        let [low, high, at] = [self.low, self.high, point].map(Vector::to_array);
        let way = (0..3).map(|i| (low[i] - at[i]).max(at[i] - high[i]).max(0.0));
        let of_box = way.map(|x| x * x).sum::<f64>().sqrt();
        match &self.kind {
            Kind::Branch(_) => of_box,
            Kind::Cell(slab) => of_box.max(slab.bound(point)),
        }
    }
}

impl Slab {
    /// Height of a point over the centre, and its way across the normal.
    fn beside(&self, point: Vector<f64>) -> (f64, Vector<f64>) {
        let way = point - self.centre;
        let height = way.dot(self.normal);
        (height, way - self.normal * height)
    }

    fn bound(&self, point: Vector<f64>) -> f64 {
        let (height, across) = self.beside(point);
        let [low, high] = self.heights;
        let over = (low - height).max(height - high).max(0.0);
        let beside = (across.dot(across).sqrt() - self.radius).max(0.0);
        over.hypot(beside)
    }

    /// The place in its middle that is nearest to a point.
    fn nearest(&self, point: Vector<f64>) -> Vector<f64> {
        let (_, across) = self.beside(point);
        let length = across.dot(across).sqrt();
        let share = if length > self.radius { self.radius / length } else { 1.0 };
        self.centre + across * share + self.normal * (0.5 * (self.heights[0] + self.heights[1]))
    }
}

fn rim_of(values: &[f64], [rows, columns, layers]: [usize; 3]) -> Rim {
    let [mut has_inside, mut has_outside] = [false; 2];
    for (n, &value) in values.iter().enumerate() {
        let place = [n / (columns * layers), n / layers % columns, n % layers];
        let ends = [rows, columns, layers];
        if (0..3).any(|axis| place[axis] == 0 || place[axis] + 1 == ends[axis]) {
            (has_inside, has_outside) = (has_inside || value <= 0.0, has_outside || value > 0.0);
        }
    }
    match [has_inside, has_outside] {
        [true, true] => Rim::Crossed,
        [true, false] => Rim::Inside,
        _ => Rim::Outside,
    }
}

/// The cell as a leaf, if the surface may cross it.
fn crossed(field: &Tricubic, cell: [usize; 3]) -> Option<Node> {
    let coefficients = field.bernstein_of_cell(cell);
    let all = coefficients.iter().flatten().flatten();
    let [least, most] =
        all.fold([f64::INFINITY, f64::NEG_INFINITY], |[least, most], &c| [least.min(c), most.max(c)]);
    if least > 0.0 || most < 0.0 {
        return None;
    }
    let spacing = Vector::from(field.spacing);
    let low = Vector::from(std::array::from_fn(|axis| cell[axis] as f64 * field.spacing[axis]));
    let centre = low + spacing * 0.5;
    let gradient = field.at(centre).gradient;
    let slope = gradient.dot(gradient).sqrt();
    let radius = 0.5 * spacing.dot(spacing).sqrt();
    let mut slab = Slab { centre, normal: Vector::new(0.0, 0.0, 1.0), heights: [-radius, radius], radius };
    if slope > LEAST_SLOPE {
        // The rest of the spline beside its tangent, of which the same coefficients are bounds.
        let mut rest = [f64::INFINITY, f64::NEG_INFINITY];
        for (a, plane) in coefficients.iter().enumerate() {
            for (b, line) in plane.iter().enumerate() {
                for (c, coefficient) in line.iter().enumerate() {
                    let thirds = [a, b, c].map(|k| k as f64 / 3.0 - 0.5);
                    let beside: f64 =
                        (0..3).map(|i| thirds[i] * field.spacing[i] * gradient.to_array()[i]).sum();
                    rest = [rest[0].min(coefficient - beside), rest[1].max(coefficient - beside)];
                }
            }
        }
        slab.normal = gradient * slope.recip();
        slab.heights = [(-rest[1] / slope).max(-radius), (-rest[0] / slope).min(radius)];
        if slab.heights[0] > slab.heights[1] {
            return None;
        }
    }
    Some(Node { low, high: low + spacing, kind: Kind::Cell(slab) })
}

/// Builds the tree over cells, divided in the middle along the longest axis.
fn enclose(cells: &mut [Node], nodes: &mut Vec<Node>) {
    if let [cell] = cells {
        nodes.push(*cell);
        return;
    }
    let corner = |of: fn(f64, f64) -> f64, start: f64, end: fn(&Node) -> Vector<f64>| {
        cells.iter().fold([start; 3], |corner, cell| {
            let end = end(cell).to_array();
            std::array::from_fn(|i| of(corner[i], end[i]))
        })
    };
    let low = corner(f64::min, f64::INFINITY, |cell| cell.low);
    let high = corner(f64::max, f64::NEG_INFINITY, |cell| cell.high);
    let size = |axis: usize| high[axis] - low[axis];
    let axis = (1..3).fold(0, |best, axis| if size(axis) > size(best) { axis } else { best });
    let half = cells.len() / 2;
    cells.select_nth_unstable_by(half, |a, b| a.low.to_array()[axis].total_cmp(&b.low.to_array()[axis]));
    let place = nodes.len();
    nodes.push(Node { low: Vector::from(low), high: Vector::from(high), kind: Kind::Branch(0) });
    let (first, second) = cells.split_at_mut(half);
    enclose(first, nodes);
    nodes[place].kind = Kind::Branch(nodes.len());
    enclose(second, nodes);
}

/// Median of the slope at zeros between neighbouring values.
fn typical_slope(field: &Tricubic, values: &[f64]) -> f64 {
    let [rows, columns, layers] = field.shape;
    let strides = [columns * layers, layers, 1];
    let place = |n: usize| [n / strides[0], n / layers % columns, n % layers];
    let ends = |n: usize| {
        let at = place(n);
        (0..3).filter(move |&axis| at[axis] + 1 < [rows, columns, layers][axis])
    };
    let is_crossed = |n: usize, axis: usize| (values[n] < 0.0) != (values[n + strides[axis]] < 0.0);
    let pairs: Vec<(usize, usize)> = (0..values.len())
        .flat_map(|n| ends(n).filter(move |&axis| is_crossed(n, axis)).map(move |axis| (n, axis)))
        .collect();
    let mut slopes = Vec::new();
    for &(n, axis) in pairs.iter().step_by(pairs.len() / LOOKED_AT + 1) {
        let start = Vector::from(std::array::from_fn(|i| place(n)[i] as f64 * field.spacing[i]));
        let mut along = [0.0; 3];
        along[axis] = field.spacing[axis];
        let at = |share: f64| field.at(start + Vector::from(along) * share);
        let [mut low, mut high] = [0.0, 1.0];
        for _ in 0..HALVINGS_TO_ZERO {
            let middle = 0.5 * (low + high);
            if (at(middle).value < 0.0) == (values[n] < 0.0) {
                low = middle;
            } else {
                high = middle;
            }
        }
        let gradient = at(0.5 * (low + high)).gradient;
        slopes.push(gradient.dot(gradient).sqrt());
    }
    slopes.sort_unstable_by(f64::total_cmp);
    slopes.get(slopes.len() / 2).copied().unwrap_or(0.0)
}

fn within(place: Vector<f64>, node: &Node) -> bool {
    let [low, high, at] = [node.low, node.high, place].map(Vector::to_array);
    (0..3).all(|i| (low[i]..=high[i]).contains(&at[i]))
}

/// Two unit vectors across a normal and each other (Duff et al. 2017, "Building an orthonormal basis, revisited").
fn tangents(normal: Vector<f64>) -> [Vector<f64>; 2] {
    let Vector { x, y, z } = normal;
    let sign = 1.0_f64.copysign(z);
    let a = -1.0 / (sign + z);
    let b = x * y * a;
    [Vector::new(1.0 + sign * x * x * a, sign * b, -sign * x), Vector::new(b, sign + y * y * a, -y)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// The surface through distances over a cube around the origin with sides of 2 m, and its corner.
    fn sampled(f: impl Fn(Vector<f64>) -> f64, number: usize) -> (LevelSet, Vector<f64>) {
        let spacing = 2.0 / (number - 1) as f64;
        let corner = Vector::new(-1.0, -1.0, -1.0);
        let value = |n: usize| {
            let place = [n / (number * number), n / number % number, n % number];
            f(corner + Vector::from(place.map(|i| i as f64)) * spacing)
        };
        let values: Vec<_> = (0..number.pow(3)).map(value).collect();
        (LevelSet::new(&values, [number; 3], [spacing; 3]), corner)
    }

    fn sphere(at: Vector<f64>) -> f64 {
        at.dot(at).sqrt() - 0.55
    }

    fn torus(at: Vector<f64>) -> f64 {
        (at.x.hypot(at.y) - 0.5).hypot(at.z) - 0.25
    }

    fn cube(at: Vector<f64>) -> f64 {
        let beyond = at.to_array().map(|x| x.abs() - 0.5);
        let outside = beyond.map(|x| x.max(0.0)).into_iter().map(|x| x * x).sum::<f64>().sqrt();
        outside + beyond.into_iter().fold(f64::NEG_INFINITY, f64::max).min(0.0)
    }

    /// Points in the cube that are spread evenly (the additive recurrence of the plastic number's analogue in space; Roberts 2018).
    fn spread(number: usize) -> impl Iterator<Item = Vector<f64>> {
        let share = |n: usize, ratio: f64| 1.9 * (n as f64 * ratio).fract() - 0.95;
        (1..=number).map(move |n| {
            let [x, y, z] = [0.819_172_513_4, 0.671_043_606_7, 0.549_700_477_9].map(|ratio| share(n, ratio));
            Vector::new(x, y, z)
        })
    }

    /// Largest differences of distance, normal, and curvature times length from those of a function, at points not far from its surface.
    fn errors(f: fn(Vector<f64>) -> f64, number: usize, is_tried: fn(Vector<f64>) -> bool) -> [f64; 3] {
        let (surface, corner) = sampled(f, number);
        let axes = [Vector::new(1.0, 0.0, 0.0), Vector::new(0.0, 1.0, 0.0), Vector::new(0.0, 0.0, 1.0)];
        let (h, mut most) = (1e-4, [0.0_f64; 3]);
        for point in spread(3000).filter(|&point| is_tried(point)) {
            let found = surface.distance(point - corner);
            most[0] = most[0].max((found.value - f(point)).abs());
            for (axis, row) in axes.into_iter().zip(found.curvature.rows()) {
                let slope = (f(point + axis * h) - f(point - axis * h)) / (2.0 * h);
                most[1] = most[1].max((slope - found.normal.dot(axis)).abs());
                let bend = (f(point + axis * h) - 2.0 * f(point) + f(point - axis * h)) / (h * h);
                most[2] = most[2].max((bend - row.dot(axis)).abs());
            }
        }
        most
    }

    /// Errors of smooth shapes fall with the fourth power of the spacing, of normals with the third one, of curvatures with the second.
    #[test]
    fn smooth_shapes_are_met_to_the_fourth_order() {
        let is_near = |point: Vector<f64>| sphere(point).abs() < 0.15;
        let is_beside = |point: Vector<f64>| torus(point).abs() < 0.1;
        for (f, is_tried) in [(sphere as fn(_) -> _, is_near as fn(_) -> _), (torus, is_beside)] {
            let [coarse, fine] = [33, 65].map(|number| errors(f, number, is_tried));
            let orders: Vec<_> = coarse.iter().zip(fine).map(|(a, b)| (a / b).log2()).collect();
            assert!(fine[0] < 1e-5 && fine[1] < 1e-3);
            assert!(orders[0] > 3.5 && orders[1] > 2.5 && orders[2] > 1.5, "{orders:?}");
        }
    }

    /// A cube has exact faces, and edges rounded by a part of the spacing.
    #[test]
    fn edges_are_rounded_by_less_than_a_cell() {
        for number in [21, 41] {
            let spacing = 2.0 / (number - 1) as f64;
            let (surface, corner) = sampled(cube, number);
            let mut most = [0.0_f64; 2];
            for point in spread(4000).filter(|&point| cube(point).abs() < 0.1) {
                let error = (surface.distance(point - corner).value - cube(point)).abs() / spacing;
                let across = point.to_array().map(|x| 0.5 - x.abs());
                let is_face = across.into_iter().filter(|&x| x > 6.0 * spacing).count() == 2;
                most[usize::from(is_face)] = most[usize::from(is_face)].max(error);
            }
            assert!(most[0] > 0.05 && most[0] < 0.5 && most[1] < 1e-3, "{most:?}");
        }
    }

    /// Far away, also beyond the grid, distances are those of the nearest place, and a bound without them says so.
    #[test]
    fn distances_are_global_and_bounded() {
        let (surface, corner) = sampled(torus, 33);
        for point in spread(300).map(|point| point * 4.0).chain([Vector::new(1e-3, 2e-3, 0.0)]) {
            let found = surface.distance(point - corner).value;
            // On the axis of the ring all its places are equally near.
            assert!((found - torus(point)).abs() < 1e-3, "{point:?} {found} {}", torus(point));
            for reach in [0.0, 0.1, 0.5, 2.0] {
                let is_beyond = surface.is_certainly_beyond(point - corner, reach);
                assert!(!is_beyond || found > reach);
                assert!(is_beyond || found < reach + 0.1, "{point:?} {reach} {found}");
            }
        }
    }

    /// A plane that crosses the grid is one beyond it as well; of a shape around a hollow all beyond is inside.
    #[test]
    fn surfaces_go_on_as_their_borders_say() {
        let normal = Vector::new(0.6, 0.0, 0.8);
        let (plane, corner) = sampled(|at| Vector::new(0.6, 0.0, 0.8).dot(at) - 0.1, 9);
        for point in spread(200).map(|point| point * 5.0) {
            let Distance { value, normal: found, curvature } = plane.distance(point - corner);
            assert!((value - (normal.dot(point) - 0.1)).abs() < 1e-12, "{point:?} {value}");
            assert!((found - normal).dot(found - normal).sqrt() < 1e-12);
            assert!(curvature.rows().iter().all(|row| row.dot(*row).sqrt() < 1e-10));
            for reach in [0.1, 1.0] {
                assert!(!plane.is_certainly_beyond(point - corner, reach) || value > reach);
            }
        }
        assert_eq!(plane.depth(), f64::INFINITY);
        let (hollow, corner) = sampled(|at| -sphere(at), 33);
        for point in [Vector::new(0.0, 0.1, 0.3), Vector::new(0.9, 0.0, 0.2), Vector::new(3.0, 1.0, 0.0)] {
            assert!((hollow.distance(point - corner).value + sphere(point)).abs() < 1e-4);
        }
        assert!(!hollow.is_certainly_beyond(Vector::new(9.0, 0.0, 0.0), 0.0));
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]
        /// Distances of bumpy shapes are those of the nearest of many places, and agree with their derivatives.
        #[test]
        fn distances_are_those_of_the_nearest_place(
            bumps in proptest::collection::vec(-0.12..0.12, 125),
            (x, y, z) in (-1.2..1.2, -1.2..1.2, -1.2..1.2),
        ) {
            let number = 9;
            let bump = |at: Vector<f64>| {
                let [i, j, k] = at.to_array().map(|x| ((x + 1.0) * 2.0).round() as usize);
                bumps[(i * 5 + j) * 5 + k]
            };
            let (surface, corner) = sampled(|at| sphere(at) + bump(at), number);
            let point = Vector::new(x, y, z) - corner;
            let found = surface.distance(point);
            prop_assert!((found.normal.dot(found.normal) - 1.0).abs() < 1e-12);
            // Zeros along lines of a fine grid.
            let (mut tried, lines) = (f64::INFINITY, 32);
            for n in 0..lines * lines {
                let [a, b] = [n / lines, n % lines].map(|k| (k as f64 + 0.5) * 2.0 / lines as f64);
                for axis in 0..3 {
                    let at = |c: f64| {
                        let mut place = [a, b, c];
                        place.rotate_right(axis);
                        Vector::from(place)
                    };
                    let value = |c: f64| surface.field.at(at(c)).value;
                    let mut last = value(0.0);
                    for k in 1..=lines {
                        let c = k as f64 * 2.0 / lines as f64;
                        let next = value(c);
                        if last * next < 0.0 {
                            let zero = c - next / (next - last) * 2.0 / lines as f64;
                            let way = at(zero) - point;
                            tried = tried.min(way.dot(way).sqrt());
                        }
                        last = next;
                    }
                }
            }
            prop_assert!(found.value.abs() <= tried + 2e-3, "{} {tried}", found.value);
            let is_inside = surface.field.contains(point) && surface.field.at(point).value < 0.0;
            prop_assert!((found.value < 0.0) == is_inside);
            for reach in [0.0, 0.1, 0.5] {
                prop_assert!(!surface.is_certainly_beyond(point, reach) || found.value > reach);
            }
            let h = 1e-6;
            for axis in [Vector::new(1.0, 0.0, 0.0), Vector::new(0.0, 1.0, 0.0), Vector::new(0.0, 0.0, 1.0)] {
                let [ahead, behind] = [h, -h].map(|h| surface.distance(point + axis * h));
                let change = ahead.normal - behind.normal;
                // Where two places are (almost) equally near, the normal jumps or rotates fast.
                if change.dot(change).sqrt() < 1e-4 {
                    let slope = (ahead.value - behind.value) / (2.0 * h);
                    prop_assert!((slope - found.normal.dot(axis)).abs() < 1e-6, "{slope} {found:?}");
                    let change = change * (0.5 / h) - found.curvature.times(axis);
                    prop_assert!(change.dot(change).sqrt() < 5e-3, "{change:?} {found:?}");
                }
            }
        }
    }
}
