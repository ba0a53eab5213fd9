//! Where surfaces touch.
//!
//! A rod presses along all of its length where it overlaps with something: `int k d ds`. Between two samples of its curve
//! the part that overlaps is found from the zeros of the gap; the integral over that part is Gaussian. So forces follow the
//! ends of a contact as these move along the rod, and no node is felt.

use crate::lie::{LANES, Lanes, Scalar, Sweep, Twist, Vector, VectorSpace};
use crate::robot::algebra::distance::Distance;
use crate::robot::algebra::ellipse::{self, Nearest as Rim, Rolling};
use crate::robot::algebra::obstacle::Solid;
use crate::robot::algebra::touch::Meeting;
use crate::robot::plan::Plan;
use crate::robot::plan::contact::{Curve, MOST_CHANGES, MOST_INTERVALS, NODES, Pair, Side, WEIGHTS};
use crate::robot::state::Workspace;
use crate::robot::state::contact::{ContactState, Standing, Touch};
use crate::robot::turning::Turning;

/// A curve between two samples is longer than what their slopes say by that factor at most, unless a rod turns by far more
/// than a radian between them.
const LONGER: f64 = 1.2;

/// Steps of regula falsi, and of Newton's method for a nearest place.
const MOST_STEPS: usize = 60;
const MOST_NEWTON_STEPS: usize = 12;

/// A place where another part of a solid becomes the nearest one is known to that part of what is divided there.
const NARROW: f64 = 1e-10;

/// Slopes along sections that are not round are differences over that part of the way between two samples.
const BESIDE: f64 = 1e-5;

/// Places closer than that part of the way between two samples are one.
const SAME_PLACE: f64 = 1e-13;

/// Finds all touches of a state whose motion is up to date.
pub(crate) fn find<G: Turning>(plan: &Plan<G>, work: &mut Workspace<G>) {
    let mut state = std::mem::take(&mut work.contact);
    plan.instructions.run_apart::<G::Pack, _>(Find { plan, work, state: &mut state });
    work.contact = state;
}

/// Finds where surfaces are in a shape, and no touches.
pub(crate) fn see<G: Turning>(plan: &Plan<G>, work: &mut Workspace<G>) {
    let mut state = std::mem::take(&mut work.contact);
    look(plan, work, &mut state);
    work.contact = state;
}

struct Find<'a, G: Turning> {
    plan: &'a Plan<G>,
    work: &'a Workspace<G>,
    state: &'a mut ContactState<G::Pack>,
}

impl<G: Turning> Sweep for Find<'_, G> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Self { plan, work, state } = self;
        look(plan, work, state);
        mark_near(plan, state);
        expand(plan, work, state);
        let ContactState {
            coefficients,
            axes,
            samples,
            bounds,
            is_near,
            centres,
            touches,
            up_to,
            weights,
            polynomials,
            ..
        } = state;
        touches.clear();
        let scene = Scene { plan, work, coefficients, axes, samples, bounds, is_near, centres };
        let mut found = Found { touches, up_to, weights, polynomials };
        for (p, pair) in plan.contacts.pairs.iter().enumerate() {
            scene.meet(p, pair, &mut found);
        }
    }
}

/// Samples and bounds of all curves, and centres of all balls.
#[inline(always)]
fn look<G: Turning>(plan: &Plan<G>, work: &Workspace<G>, state: &mut ContactState<G::Pack>) {
    for (curve, bound) in plan.contacts.curves.iter().zip(&mut state.bounds) {
        let piece = &plan.pieces[curve.piece];
        let own = &mut state.samples[curve.first_sample..][..curve.samples.len()];
        let last = own.len() - 1;
        let ends = [piece.joined.begin, piece.joined.end].map(|station| work.stations[station].position);
        for (i, seen) in own[1..last].iter_mut().enumerate() {
            let (node, lane) = (piece.first_pack + i / LANES, i % LANES);
            let at_node = |v: &G::Vector<G::Pack>| {
                G::in_space(plan.frame, G::map_vector(v, |pack: &G::Pack| pack.lane(lane)))
            };
            *seen = [at_node(&work.position[node]), at_node(&work.slope[node]) * curve.length];
        }
        own[0] = [G::in_space(plan.frame, ends[0]), own[1][1]];
        own[last] = [G::in_space(plan.frame, ends[1]), own[last - 1][1]];
        let (mut fastest, mut away, mut thickest) = (0.0_f64, 0.0_f64, 0.0_f64);
        let centre = own[own.len() / 2][0];
        for ([position, slope], sample) in own.iter().zip(&curve.samples) {
            let way = *position - centre;
            fastest = fastest.max(slope.dot(*slope));
            away = away.max(way.dot(way));
            thickest = thickest.max(sample.radius);
        }
        let between = LONGER * fastest.sqrt() * piece.gauss.largest_gap();
        *bound = (centre, away.sqrt() + between + thickest);
    }
    for (ball, centre) in plan.contacts.balls.iter().zip(&mut state.centres) {
        let point = &work.points[ball.point];
        let beside = G::rotate(&point.rotation, G::vector_of(plan.frame, ball.beside));
        *centre = G::in_space(plan.frame, point.position + beside);
    }
}

/// Marks the curves whose bounds are touched by others.
fn mark_near<G: Turning>(plan: &Plan<G>, state: &mut ContactState<G::Pack>) {
    let ContactState { bounds, is_near, centres, .. } = state;
    is_near.fill(false);
    for pair in &plan.contacts.pairs {
        let Side::Rod(curves) = &pair.sides[0] else { continue };
        for c in curves.clone() {
            let (centre, radius) = bounds[c];
            match &pair.sides[1] {
                Side::Solid(solid) => {
                    is_near[c] |= plan.contacts.solids[*solid].distance(centre).value <= radius;
                }
                Side::Ball(ball) => {
                    let reach = radius + plan.contacts.balls[*ball].radius;
                    is_near[c] |= distance_between(centre, centres[*ball]) <= reach;
                }
                Side::Rod(others) => {
                    for o in others.clone() {
                        let (other, of_other) = bounds[o];
                        let is_met = distance_between(centre, other) <= radius + of_other;
                        is_near[c] |= is_met;
                        is_near[o] |= is_met;
                    }
                }
            }
        }
    }
}

/// Shapes of the curves that may be touched.
#[inline(always)]
fn expand<G: Turning>(plan: &Plan<G>, work: &Workspace<G>, state: &mut ContactState<G::Pack>) {
    let curves = plan.contacts.curves.iter().zip(&state.is_near);
    for (curve, _) in curves.filter(|(_, is_near)| **is_near) {
        let slopes = &work.slope[plan.pieces[curve.piece].node_packs()];
        let coefficients = &mut state.coefficients[curve.first_coefficient..][..curve.expansion.len()];
        for (coefficient, weights) in coefficients.iter_mut().zip(&curve.expansion) {
            let mut sum = G::Vector::<G::Pack>::zero();
            for (&slope, &weight) in slopes.iter().zip(weights) {
                sum += slope * weight;
            }
            let sum = G::map_vector(&sum, |pack: &G::Pack| pack.sum());
            *coefficient = G::in_space(plan.frame, sum) * curve.length;
        }
        if !curve.is_round {
            expand_axes(plan, work, curve, &mut state.axes);
        }
    }
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

/// Where a curve is, by the coefficients of its slope.
#[derive(Clone, Copy)]
struct Shape<'a> {
    begin: Vector<f64>,
    coefficients: &'a [Vector<f64>],
    /// Of the axes of its sections, if it is not round.
    axes: &'a [[Vector<f64>; 2]],
    breaks: &'a [f64],
}

fn shape<'a, G: Turning>(
    plan: &Plan<G>,
    work: &Workspace<G>,
    (coefficients, axes): (&'a [Vector<f64>], &'a [[Vector<f64>; 2]]),
    curve: &'a Curve<G::Pack>,
) -> Shape<'a> {
    let begin = work.stations[plan.pieces[curve.piece].joined.begin].position;
    Shape { begin: G::in_space(plan.frame, begin), coefficients, axes, breaks: curve.integral.breaks() }
}

impl Shape<'_> {
    /// Position, and its derivative, at a fraction of the length: `int P_k = (P_{k+1} - P_{k-1}) / (2 (2k+1))` on [0, 1].
    #[inline(always)]
    fn at(&self, x: f64) -> [Vector<f64>; 2] {
        let degrees = self.coefficients.len() / (self.breaks.len() + 1);
        let mut begin = self.begin;
        let mut from = 0.0;
        let here = self.breaks.partition_point(|&place| place <= x);
        for (own, &to) in self.coefficients.chunks_exact(degrees).zip(&self.breaks[..here]) {
            begin = begin.add_scaled(own[0], to - from);
            from = to;
        }
        let to = self.breaks.get(here).copied().unwrap_or(1.0);
        let own = &self.coefficients[here * degrees..][..degrees];
        let x = (x - from) / (to - from);
        let t = 2.0 * x - 1.0;
        let (mut position, mut slope) = (own[0] * x, own[0]);
        let (mut before, mut value) = (1.0, t);
        for (k, &coefficient) in own.iter().enumerate().skip(1) {
            let degree = k as f64;
            let next = ((2.0 * degree + 1.0) * t * value - degree * before) / (degree + 1.0);
            position = position.add_scaled(coefficient, 0.5 * (next - before) / (2.0 * degree + 1.0));
            slope = slope.add_scaled(coefficient, value);
            (before, value) = (value, next);
        }
        [begin.add_scaled(position, to - from), slope]
    }

    /// Axes of the section at a fraction of the length: unit vectors, across each other.
    fn axes_at(&self, x: f64) -> [Vector<f64>; 2] {
        let degrees = self.axes.len() / (self.breaks.len() + 1);
        let here = self.breaks.partition_point(|&place| place <= x);
        let from = if here > 0 { self.breaks[here - 1] } else { 0.0 };
        let to = self.breaks.get(here).copied().unwrap_or(1.0);
        let own = &self.axes[here * degrees..][..degrees];
        let t = 2.0 * (x - from) / (to - from) - 1.0;
        let mut axes = [Vector::zero(); 2];
        let (mut before, mut value) = (0.0, 1.0);
        for (k, coefficients) in own.iter().enumerate() {
            for (axis, &coefficient) in axes.iter_mut().zip(coefficients) {
                *axis = axis.add_scaled(coefficient, value);
            }
            let degree = k as f64;
            let next = ((2.0 * degree + 1.0) * t * value - degree * before) / (degree + 1.0);
            (before, value) = (value, next);
        }
        let [y, z] = axes;
        let y = y * y.dot(y).sqrt().recip();
        let z = z - y * y.dot(z);
        [y, z * z.dot(z).sqrt().recip()]
    }
}

fn distance_between(a: Vector<f64>, b: Vector<f64>) -> f64 {
    let way = a - b;
    way.dot(way).sqrt()
}

/// What is known of all that may touch.
struct Scene<'a, G: Turning> {
    plan: &'a Plan<G>,
    work: &'a Workspace<G>,
    coefficients: &'a [Vector<f64>],
    axes: &'a [[Vector<f64>; 2]],
    samples: &'a [[Vector<f64>; 2]],
    bounds: &'a [(Vector<f64>, f64)],
    is_near: &'a [bool],
    centres: &'a [Vector<f64>],
}

/// Where touches go.
struct Found<'a, P> {
    touches: &'a mut Vec<Touch>,
    up_to: &'a mut [P],
    weights: &'a mut [f64],
    polynomials: &'a mut [f64],
}

/// What a curve or a ball may meet.
#[derive(Clone, Copy)]
enum Other<'a> {
    Solid(&'a Solid, Standing),
    /// The curves of a rod, but for those places that are neighbours of one of the same rod.
    Rod {
        pair: &'a Pair,
        first: usize,
        end: usize,
    },
}

/// What is nearest to a point.
#[derive(Clone, Copy)]
struct Nearest {
    distance: Distance,
    on: Standing,
    /// From its centre to its surface.
    radius: f64,
}

/// A first side that may touch: where it is, and how much of the stiffness there is.
struct First {
    on: Standing,
    centre: Vector<f64>,
    radius: f64,
    thickness: f64,
    rolling: Option<Rolling>,
    weight: f64,
    axis: Vector<f64>,
}

/// The part of a curve between two samples.
#[derive(Clone, Copy)]
struct Part<'a> {
    shape: Shape<'a>,
    /// Among the parts of its curve.
    index: usize,
    curve: usize,
    /// Fractions of the curve where it begins and how long it is.
    from: f64,
    part: f64,
    /// Arc length of the rod where it begins, and its length.
    arc: f64,
    length: f64,
    ends: [[Vector<f64>; 2]; 2],
    radii: [f64; 2],
    /// Half extents of the sections at both ends, if they are not round.
    half_extents: Option<[[f64; 2]; 2]>,
}

impl Part<'_> {
    /// The semi-axes of the section at a fraction of it, if that is not round.
    fn semi_axes(&self, x: f64) -> Option<[Vector<f64>; 2]> {
        let [begin, end] = self.half_extents?;
        let axes = self.shape.axes_at(self.from + self.part * x);
        Some([0, 1].map(|i| axes[i] * (begin[i] + (end[i] - begin[i]) * x)))
    }

    /// At a fraction of it, position and its derivative along that fraction.
    fn at(&self, x: f64) -> [Vector<f64>; 2] {
        let [position, slope] = self.shape.at(self.from + self.part * x);
        [position, slope * self.part]
    }

    /// The second derivative, as the cubic through positions and slopes of both ends has it.
    fn bend(&self, x: f64) -> Vector<f64> {
        let [[p, a], [q, b]] = self.ends;
        let way = q - p;
        (way * 3.0 - a * 2.0 - b) * 2.0 + (a + b - way * 2.0) * (6.0 * x)
    }

    fn radius(&self, x: f64) -> f64 {
        self.radii[0] + (self.radii[1] - self.radii[0]) * x
    }

    /// Centre and radius of a ball that it lies in.
    fn bound(&self) -> (Vector<f64>, f64) {
        let [[p, _], [q, _]] = self.ends;
        ((p + q) * 0.5, 0.5 * self.reach() + self.radii[0].max(self.radii[1]))
    }

    /// It is not longer than that, and its radius changes by no more.
    fn reach(&self) -> f64 {
        let [[_, a], [_, b]] = self.ends;
        LONGER * a.dot(a).max(b.dot(b)).sqrt() + (self.radii[1] - self.radii[0]).abs()
    }
}

impl<'a, G: Turning> Scene<'a, G> {
    /// The parts of a curve.
    fn parts(&self, c: usize) -> impl Iterator<Item = Part<'_>> + use<'_, 'a, G> {
        let curve = &self.plan.contacts.curves[c];
        let seen = &self.samples[curve.first_sample..][..curve.samples.len()];
        let coefficients = &self.coefficients[curve.first_coefficient..][..curve.expansion.len()];
        let axes =
            if curve.is_round { &[] } else { &self.axes[curve.first_coefficient..][..curve.expansion.len()] };
        let shape = shape(self.plan, self.work, (coefficients, axes), curve);
        curve.samples.windows(2).zip(seen.windows(2)).enumerate().map(move |(index, (samples, seen))| {
            let (from, part) = (samples[0].x, samples[1].x - samples[0].x);
            Part {
                shape,
                index,
                curve: c,
                from,
                part,
                arc: curve.start + from * curve.length,
                length: part * curve.length,
                ends: [[seen[0][0], seen[0][1] * part], [seen[1][0], seen[1][1] * part]],
                radii: [samples[0].radius, samples[1].radius],
                half_extents: (!curve.is_round).then(|| [samples[0].half_extents, samples[1].half_extents]),
            }
        })
    }

    /// Finds where the two of a pair touch.
    fn meet(&self, p: usize, pair: &Pair, found: &mut Found<'_, G::Pack>) {
        let round;
        let other = match &pair.sides[1] {
            Side::Solid(solid) => Other::Solid(&self.plan.contacts.solids[*solid], Standing::Still),
            Side::Ball(ball) => {
                let radius = self.plan.contacts.balls[*ball].radius;
                round = Solid::Ball { centre: self.centres[*ball], radius };
                Other::Solid(&round, Standing::Ball(*ball))
            }
            Side::Rod(curves) => Other::Rod { pair, first: curves.start, end: curves.end },
        };
        match &pair.sides[0] {
            Side::Ball(ball) => {
                let (on, centre) = (Standing::Ball(*ball), self.centres[*ball]);
                if let Some(nearest) = self.nearest(&other, centre, None) {
                    let radius = self.plan.contacts.balls[*ball].radius;
                    let first = First {
                        on,
                        centre,
                        radius,
                        thickness: radius,
                        rolling: None,
                        weight: 1.0,
                        axis: Vector::zero(),
                    };
                    self.press(p, &first, &nearest, found);
                }
            }
            Side::Rod(curves) => {
                for c in curves.clone() {
                    if self.is_near[c] {
                        for part in self.parts(c).filter(|part| self.may_meet(part, &other)) {
                            self.meet_along(p, &part, &other, found);
                        }
                    }
                }
            }
            Side::Solid(_) => {}
        }
    }

    /// Whether a part of a curve can be near the other.
    fn may_meet(&self, part: &Part<'_>, other: &Other<'_>) -> bool {
        let Other::Rod { pair, first, end } = other else { return true };
        let (centre, radius) = part.bound();
        (*first..*end).any(|o| {
            let (middle, of_other) = self.bounds[o];
            distance_between(centre, middle) <= radius + of_other
                && self.parts(o).any(|other| {
                    let is_neighbour = pair.neighbourhood > 0.0
                        && other.arc < part.arc + part.length + pair.neighbourhood
                        && other.arc + other.length > part.arc - pair.neighbourhood;
                    let (middle, of_other) = other.bound();
                    !is_neighbour && distance_between(centre, middle) <= radius + of_other
                })
        })
    }

    /// Adds the touches of a part of a curve.
    fn meet_along(&self, p: usize, part: &Part<'_>, other: &Other<'_>, found: &mut Found<'_, G::Pack>) {
        let gap = |x: f64| {
            let [position, slope] = part.at(x);
            let nearest = self.nearest(other, position, Some(part.arc + part.length * x));
            nearest.map_or((f64::INFINITY, 0.0), |nearest| {
                let widening = part.radii[1] - part.radii[0];
                let Distance { value, normal, .. } = nearest.distance;
                (value - part.radius(x), normal.dot(slope) - widening)
            })
        };
        if let (Some(_), Other::Solid(solid, _)) = (part.half_extents, other) {
            self.meet_along_ellipses(p, part, solid, other, found);
            return;
        }
        let ends = [gap(0.0), gap(1.0)];
        if ends[0].0 + ends[1].0 >= part.reach() {
            return;
        }
        for &interval in touched(ends, gap).as_slice() {
            self.meet_features(p, part, interval, other, found);
        }
    }

    /// Adds the touches of a part of a curve whose sections are not round.
    #[inline(never)]
    fn meet_along_ellipses(
        &self,
        p: usize,
        part: &Part<'_>,
        solid: &Solid,
        other: &Other<'_>,
        found: &mut Found<'_, G::Pack>,
    ) {
        let thickest = part.radii[0].max(part.radii[1]);
        // Seen from the middle of the sections, as thick rods.
        let [start, end] = part.ends.map(|[place, _]| solid.distance(place).value - thickest);
        if start + end >= part.reach() {
            return;
        }
        let value = |x: f64| {
            let semi = part.semi_axes(x).unwrap_or_default();
            ellipse::nearest(solid, part.at(x)[0], semi).distance.value
        };
        // Sections turn along the rod: the slope is that of neighbours.
        let gap = |x: f64| {
            let [before, after] = [(x - BESIDE).max(0.0), (x + BESIDE).min(1.0)];
            (value(x), (value(after) - value(before)) / (after - before))
        };
        for &interval in touched([gap(0.0), gap(1.0)], gap).as_slice() {
            self.meet_features(p, part, interval, other, found);
        }
    }

    /// Adds the touches of what lies between two places of a part of a curve, divided where another part of a solid becomes the
    /// nearest one: there the gap is not smooth.
    fn meet_features(
        &self,
        p: usize,
        part: &Part<'_>,
        [from, to]: [f64; 2],
        other: &Other<'_>,
        found: &mut Found<'_, G::Pack>,
    ) {
        let Other::Solid(solid, Standing::Still) = other else {
            return self.meet_between(p, part, [from, to], other, found);
        };
        if !solid.has_features() {
            return self.meet_between(p, part, [from, to], other, found);
        }
        let feature = |x: f64| {
            let centre = part.at(x)[0];
            let semi = part.semi_axes(x);
            solid.feature(semi.map_or(centre, |semi| ellipse::nearest(solid, centre, semi).place))
        };
        let mut begin = from;
        for place in changes(feature, [from, to]).into_iter().flatten() {
            self.meet_between(p, part, [begin, place], other, found);
            begin = place;
        }
        self.meet_between(p, part, [begin, to], other, found);
    }

    /// Adds the touches of what lies between two places of a part of a curve.
    fn meet_between(
        &self,
        p: usize,
        part: &Part<'_>,
        [from, to]: [f64; 2],
        other: &Other<'_>,
        found: &mut Found<'_, G::Pack>,
    ) {
        let is_whole = from == 0.0 && to == 1.0;
        for (i, (node, weight)) in NODES.into_iter().zip(WEIGHTS).enumerate() {
            let x = from + (to - from) * node;
            let on = Standing::Along { curve: part.curve, x: part.from + part.part * x };
            let weight = weight * (to - from) * part.length;
            let axis = self.axis(p, part, x, found);
            let known = is_whole.then(|| &self.plan.contacts.curves[part.curve].whole[part.index][i][..]);
            let centre = self.reach(on, known, found, 0);
            if let (Some(semi), Other::Solid(solid, on_other)) = (part.semi_axes(x), other) {
                let Rim { place, distance, rolling } = ellipse::nearest(solid, centre, semi);
                let thickness = semi.map(|s| s.dot(s)).into_iter().fold(f64::INFINITY, f64::min).sqrt();
                let rolling = Some(rolling);
                let first = First { on, centre: place, radius: 0.0, thickness, rolling, weight, axis };
                let radius = if let Solid::Ball { radius, .. } = solid { *radius } else { 0.0 };
                self.press(p, &first, &Nearest { distance, on: *on_other, radius }, found);
                continue;
            }
            if let Some(nearest) = self.nearest(other, centre, Some(part.arc + part.length * x)) {
                let radius = part.radius(x);
                let first = First { on, centre, radius, thickness: radius, rolling: None, weight, axis };
                self.press(p, &first, &nearest, found);
            }
        }
    }

    /// The axis of the section at a place, where it matters how that lies.
    fn axis(&self, p: usize, part: &Part<'_>, x: f64, found: &mut Found<'_, G::Pack>) -> Vector<f64> {
        if self.plan.contacts.pairs[p].law.is_even() {
            return Vector::zero();
        }
        let curve = &self.plan.contacts.curves[part.curve];
        let piece = &self.plan.pieces[curve.piece];
        let weights = &mut found.weights[..piece.packs * LANES];
        curve.integral.write_weights_at(part.from + part.part * x, weights, found.polynomials);
        let mut axis = G::Vector::<G::Pack>::zero();
        for (lanes, rotation) in weights.chunks_exact(LANES).zip(&self.work.rotation[piece.node_packs()]) {
            let weight = G::Pack::from_lanes(std::array::from_fn(|lane| lanes[lane]));
            axis += G::rod_axis(self.plan.frame, rotation) * weight;
        }
        let axis = G::in_space(self.plan.frame, G::map_vector(&axis, |pack: &G::Pack| pack.sum()));
        let length = axis.dot(axis).sqrt();
        if length > 0.0 { axis * length.recip() } else { axis }
    }

    /// What of the other is nearest to a point, which is at that arc length of its rod.
    fn nearest(&self, other: &Other<'_>, point: Vector<f64>, arc: Option<f64>) -> Option<Nearest> {
        match other {
            Other::Solid(solid, on) => {
                let radius = if let Solid::Ball { radius, .. } = solid { *radius } else { 0.0 };
                Some(Nearest { distance: solid.distance(point), on: *on, radius })
            }
            Other::Rod { pair, first, end } => {
                let arc = if pair.neighbourhood > 0.0 { arc } else { None };
                self.nearest_on_rod(*first..*end, point, arc.map(|arc| (arc, pair.neighbourhood)))
            }
        }
    }

    /// The nearest place of the curves of a rod, but for neighbours.
    fn nearest_on_rod(
        &self,
        curves: std::ops::Range<usize>,
        point: Vector<f64>,
        but: Option<(f64, f64)>,
    ) -> Option<Nearest> {
        let is_neighbour = |part: &Part<'_>| {
            but.is_some_and(|(arc, near)| part.arc < arc + near && part.arc + part.length > arc - near)
        };
        let mut best: Option<(f64, Part<'_>, f64)> = None;
        // Whether what is nearest is the end of what is looked at, beyond which there are neighbours.
        let mut is_cut = false;
        let mut follows_neighbour = false;
        for c in curves {
            let (centre, radius) = self.bounds[c];
            let nearest = best.map_or(f64::INFINITY, |(nearest, ..)| nearest);
            if distance_between(point, centre) - radius > nearest {
                follows_neighbour = false;
                continue;
            }
            for part in self.parts(c) {
                if is_neighbour(&part) {
                    is_cut |= best.is_some_and(|(_, last, x)| {
                        x == 1.0
                            && (last.arc + last.length - part.arc).abs()
                                <= SAME_PLACE * part.length.max(part.arc)
                    });
                    follows_neighbour = true;
                    continue;
                }
                let [start, end] = [0, 1].map(|e| distance_between(point, part.ends[e][0]) - part.radii[e]);
                let least = 0.5 * (start + end - part.reach());
                if best.is_none_or(|(nearest, ..)| least < nearest) {
                    let x = nearest_on(&part, point);
                    let value = distance_between(point, part.at(x)[0]) - part.radius(x);
                    if best.is_none_or(|(nearest, ..)| value < nearest) {
                        best = Some((value, part, x));
                        is_cut = follows_neighbour && x == 0.0;
                    }
                }
                follows_neighbour = false;
            }
        }
        let (_, part, x) = best.filter(|_| !is_cut)?;
        let [position, slope] = part.at(x);
        let bend = part.bend(x);
        let way = point - position;
        let radius = part.radius(x);
        let on = Standing::Along { curve: part.curve, x: part.from + part.part * x };
        // As seen from the point the surface bends about the axis, unless the place is an end.
        let square = slope.dot(slope);
        let is_inside = slope.dot(way).abs() <= 1e-6 * (square * way.dot(way)).sqrt();
        let stretch = (1.0 - way.dot(bend) / square.max(f64::MIN_POSITIVE)).max(0.1);
        let distance =
            Distance::from_curve(way, radius, is_inside.then_some((slope * square.sqrt().recip(), stretch)));
        Some(Nearest { distance, on, radius })
    }

    /// The centre of a side, in space and the frame of the plan; tells how the nodes reach it, which may be known, in the
    /// memory of the next touch.
    fn reach(
        &self,
        on: Standing,
        known: Option<&[G::Pack]>,
        found: &mut Found<'_, G::Pack>,
        side: usize,
    ) -> Vector<f64> {
        match on {
            Standing::Along { curve, x } => {
                let curve: &Curve<G::Pack> = &self.plan.contacts.curves[curve];
                let piece = &self.plan.pieces[curve.piece];
                let stride = self.plan.contacts.packs;
                let own = &mut found.up_to[(2 * found.touches.len() + side) * stride..][..piece.packs];
                if let Some(known) = known {
                    own.copy_from_slice(known);
                } else {
                    let weights = &mut found.weights[..piece.packs * LANES];
                    curve.integral.write_weights_up_to(x, weights, found.polynomials);
                    for (own, lanes) in own.iter_mut().zip(weights.chunks_exact(LANES)) {
                        *own = G::Pack::from_lanes(std::array::from_fn(|lane| lanes[lane] * curve.length));
                    }
                }
                let mut way = G::Vector::<G::Pack>::zero();
                for (&own, &slope) in own.iter().zip(&self.work.slope[piece.node_packs()]) {
                    way += slope * own;
                }
                let begin = self.work.stations[piece.joined.begin].position;
                let way = G::map_vector(&way, |pack: &G::Pack| pack.sum());
                G::in_space(self.plan.frame, begin + way)
            }
            Standing::Ball(ball) => self.centres[ball],
            Standing::Still => Vector::zero(),
        }
    }

    /// Angular velocity and velocity of a side, whose nodes are told of in the memory of the next touch.
    fn motion(
        &self,
        on: Standing,
        centre: Vector<f64>,
        found: &Found<'_, G::Pack>,
        side: usize,
    ) -> [Vector<f64>; 2] {
        let twist = match on {
            Standing::Along { curve, .. } => {
                let piece = &self.plan.pieces[self.plan.contacts.curves[curve].piece];
                let stride = self.plan.contacts.packs;
                let own = &found.up_to[(2 * found.touches.len() + side) * stride..][..piece.packs];
                let mut change = Twist::zero();
                for (&weight, &rate) in own.iter().zip(&self.work.rate[piece.node_packs()]) {
                    change += rate * weight;
                }
                self.work.stations[piece.joined.begin].velocity + change.sum()
            }
            Standing::Ball(ball) => self.work.points[self.plan.contacts.balls[ball].point].velocity,
            Standing::Still => return [Vector::zero(); 2],
        };
        let angular = G::axial_in_space(self.plan.frame, twist.angular);
        [angular, G::in_space(self.plan.frame, twist.linear) + angular.cross(centre)]
    }

    /// Adds a touch, if there is one; the memory of the next touch knows how its first side is reached.
    fn press(&self, p: usize, first: &First, nearest: &Nearest, found: &mut Found<'_, G::Pack>) {
        let pair = &self.plan.contacts.pairs[p];
        let &First { on, centre, radius, thickness, rolling, weight, axis } = first;
        let overlap = radius - nearest.distance.value;
        if overlap <= 0.0 || found.touches.len() == self.plan.contacts.capacity {
            return;
        }
        let sides = [on, nearest.on];
        let centres = [centre, self.reach(nearest.on, None, found, 1)];
        let motions = [0, 1].map(|s| self.motion(sides[s], centres[s], found, s));
        // What touches itself is met twice, from both sides.
        let weight = if pair.neighbourhood > 0.0 { 0.5 * weight } else { weight };
        let Distance { normal, curvature, .. } = nearest.distance;
        let radii = [radius, nearest.radius];
        let meeting = Meeting {
            law: pair.law,
            weight,
            overlap,
            normal,
            curvature,
            radii,
            rolling,
            thickness,
            motions,
            axis,
        };
        let pressing = meeting.pressing();
        found.touches.push(Touch { pair: p, sides, centres, meeting, pressing });
    }
}

/// Parts of a curve in which a gap is negative, in ascending order.
#[derive(Clone, Copy, Default)]
struct Intervals {
    own: [[f64; 2]; MOST_INTERVALS],
    number: usize,
}

impl Intervals {
    fn push(&mut self, interval: [f64; 2]) {
        self.own[self.number] = interval;
        self.number += 1;
    }

    fn as_slice(&self) -> &[[f64; 2]] {
        &self.own[..self.number]
    }
}

/// Where between two places something changes, in ascending order; what comes back between two of a few samples is not seen.
fn changes(feature: impl Fn(f64) -> [usize; 3], [from, to]: [f64; 2]) -> [Option<f64>; MOST_CHANGES] {
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
fn touched(ends: [(f64, f64); 2], gap: impl Fn(f64) -> (f64, f64)) -> Intervals {
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

/// Where on a part of a curve a point is nearest: Newton's method between bounds.
fn nearest_on(part: &Part<'_>, point: Vector<f64>) -> f64 {
    let slope = |x: f64| {
        let [position, slope] = part.at(x);
        let way = position - point;
        (way.dot(slope), slope.dot(slope) + way.dot(part.bend(x)))
    };
    let [start, end] = [slope(0.0).0, slope(1.0).0];
    let (mut from, mut to) = (0.0, 1.0);
    if start >= 0.0 && end >= 0.0 {
        return 0.0;
    }
    if start <= 0.0 && end <= 0.0 {
        return 1.0;
    }
    if start > 0.0 {
        // Furthest inside: one of the ends.
        let [p, q] = [0, 1].map(|e| distance_between(point, part.ends[e][0]));
        return if p <= q { 0.0 } else { 1.0 };
    }
    let mut x = start / (start - end);
    for _ in 0..MOST_NEWTON_STEPS {
        let (value, change) = slope(x);
        if value < 0.0 {
            from = x;
        } else {
            to = x;
        }
        let next = x - value / change;
        let next = if change > 0.0 && next > from && next < to { next } else { 0.5 * (from + to) };
        if (next - x).abs() <= SAME_PLACE {
            return next;
        }
        x = next;
    }
    x
}
