//! The narrow phase of contact detection: contact points of a pair of surfaces.
//!
//! A rod has contact forces along its whole overlap with another surface: `int k d ds`. Between two samples
//! of its curve, the zeros of the gap bound the overlapping part, over which Gaussian quadrature is used.
//! Forces thus follow the ends of a contact continuously along the rod, without an influence of the nodes.

use super::bore::{InTube, Pieces, up_to_clearance};
use super::curve::{DIFFERENCE_STEP, Part, Shape, part};
use super::intervals::{Gap, SAME_PLACE, changes};
use crate::numerics::lie::{LANES, Lanes, Scalar, Symmetric, Twist, Vector, VectorSpace};
use crate::robot::effects::contact::plan::{Ball, Body, Curve, Fixed, NODES, Pair, Side, WEIGHTS};
use crate::robot::effects::contact::shapes::distance;
use crate::robot::effects::contact::shapes::distance::Distance;
use crate::robot::effects::contact::shapes::edge;
use crate::robot::effects::contact::shapes::ellipse;
use crate::robot::effects::contact::shapes::ellipse::{Nearest as Rim, Rolling};
use crate::robot::effects::contact::shapes::elliptic_tube;
use crate::robot::effects::contact::shapes::elliptic_tube::Section;
use crate::robot::effects::contact::shapes::obstacle::{Placed, Pose, Solid};
use crate::robot::effects::contact::shapes::slide::{AT_RIGHT_ANGLE, Slide};
use crate::robot::effects::contact::shapes::touch::ContactPoint;
use crate::robot::effects::contact::shapes::tube::Tube;
use crate::robot::effects::contact::state::{Held, Share, SidePlace, Span, Term, Touch};
use crate::robot::plan::Plan;
use crate::robot::state::Workspace;
use crate::robot::turning::Turning;
use std::ops::Range;

/// Overlaps below this fraction of the radius of a rod are ignored; their forces are as small.
const NEGLIGIBLE: f64 = 1e-9;

/// Maximum number of places of a part that are examined because parts of another rod are close, and their smallest distance.
const MOST_HINTS: usize = 8;
const SAME_HINT: f64 = 0.02;

/// A solid at its current pose.
pub(super) fn placed<'a, G: Turning>(plan: &'a Plan<G>, poses: &'a [Pose], solid: usize) -> Placed<'a> {
    let Fixed { on, solid: own } = &plan.effects.contacts.solids[solid];
    Placed { solid: own, pose: on.map(|_| &poses[solid]) }
}

/// Curves of rods that may touch each other.
#[derive(Clone, Copy)]
pub(super) struct Near<'a> {
    pub(super) curves: &'a [[usize; 2]],
    pub(super) of_pairs: &'a [Range<usize>],
}

impl<'a> Near<'a> {
    /// The curves of a pair.
    fn of_pair(&self, p: usize) -> &'a [[usize; 2]] {
        &self.curves[self.of_pairs[p].clone()]
    }
}

/// The curves of the second rod that a curve may touch.
fn others<'a>(near: &'a [[usize; 2]], curve: usize) -> impl Iterator<Item = usize> + use<'a> {
    let first = near.partition_point(|&[c, _]| c < curve);
    near[first..].iter().take_while(move |&&[c, _]| c == curve).map(|&[_, o]| o)
}

/// All surfaces of a state.
pub(super) struct Scene<'a, G: Turning> {
    pub(super) plan: &'a Plan<G>,
    pub(super) work: &'a Workspace<G>,
    pub(super) terms: &'a [Term],
    pub(super) axes: &'a [[Vector<f64>; 2]],
    pub(super) bends: &'a [f64],
    pub(super) samples: &'a [[Vector<f64>; 2]],
    pub(super) spans: &'a [Span],
    pub(super) bounds: &'a [(Vector<f64>, f64)],
    pub(super) chords: &'a [Span],
    pub(super) is_near: &'a [bool],
    pub(super) near: Near<'a>,
    pub(super) centres: &'a [Vector<f64>],
    pub(super) corners: &'a [Vector<f64>],
    pub(super) poses: &'a [Pose],
    /// Largest stiffness of every pair.
    pub(super) stiffest: &'a [f64],
    /// Distance by which the obstacle of every pair is larger.
    pub(super) grown: &'a [f64],
    pub(super) held: Option<&'a [Held]>,
}

/// Destination of the contact points.
pub(super) struct Found<'a, P> {
    pub(super) touches: &'a mut Vec<Touch>,
    pub(super) up_to: &'a mut Vec<P>,
    pub(super) weights: &'a mut [f64],
    pub(super) polynomials: &'a mut [f64],
}

/// The surface that a curve or a ball may touch.
#[derive(Clone, Copy)]
enum Other<'a> {
    Solid {
        solid: Placed<'a>,
        on: SidePlace,
        /// The centre of a ball.
        centre: Option<Vector<f64>>,
        /// Distance by which it is larger.
        grown: f64,
    },
    /// The curves of a rod, without neighbouring places of the same rod.
    Rod { pair: &'a Pair, first: usize, end: usize, near: &'a [[usize; 2]] },
}

impl Other<'_> {
    /// The surface as a tube, in whose bore a curve may be.
    fn tube(&self) -> Option<&Tube> {
        if let Self::Solid { solid, .. } = self { solid.tube() } else { None }
    }
}

/// The part of a surface nearest to a point.
#[derive(Clone, Copy)]
struct Nearest {
    distance: Distance,
    on: SidePlace,
    /// Its centre, where it is known.
    centre: Option<Vector<f64>>,
    /// Distance of its centre from its surface.
    radius: f64,
    /// Whether the normal rotates with it, as for sections that are not round: its centre is then that of the first side.
    is_carried: bool,
}

/// A place of the first side that may touch, and its share of the stiffness.
struct FirstPlace {
    on: SidePlace,
    centre: Vector<f64>,
    radius: f64,
    thickness: f64,
    rolling: Option<Rolling>,
    weight: f64,
    axis: Vector<f64>,
    share: Option<Share>,
}

/// The part of a rod's surface nearest to a point, whose nearest place on the axis is known.
fn nearest_at(curve: usize, part: &Part<'_>, x: f64, point: Vector<f64>) -> Nearest {
    let [position, slope, bend] = part.at(x);
    let way = point - position;
    let radius = part.radius(x);
    let on = SidePlace::Along { curve, x: part.from + part.part * x };
    if let Some(semi_axes) = part.semi_axes(x) {
        let square = slope.dot(slope);
        let along = slope * square.max(f64::MIN_POSITIVE).sqrt().recip();
        let is_inside = slope.dot(way).abs() <= AT_RIGHT_ANGLE * (square * way.dot(way)).sqrt();
        let section = Section { centre: position, along, semi_axes };
        let continuation = is_inside.then(|| part.continuation(x));
        let distance = elliptic_tube::distance(point, &section, continuation.as_ref());
        return Nearest { distance, on, centre: None, radius: smaller(semi_axes), is_carried: true };
    }
    // The surface is curved about the axis, unless the place is an end.
    let slide = Slide::new(way, [slope, bend], part.widening());
    let turning = slide.map(|slide| (slide.across, slide.stretch));
    let distance = Distance::from_curve(way, radius, turning);
    Nearest { distance, on, centre: None, radius, is_carried: false }
}

/// Angular velocity and velocity of a side of a contact point, with the integration weights of its nodes up to there.
#[inline(always)]
pub(super) fn motion<G: Turning>(
    plan: &Plan<G>,
    work: &Workspace<G>,
    on: SidePlace,
    centre: Vector<f64>,
    weights: &[G::Pack],
) -> [Vector<f64>; 2] {
    let twist = match on {
        SidePlace::Along { curve, .. } => {
            let piece = &plan.pieces[plan.effects.contacts.curves[curve].piece];
            let mut change = Twist::zero();
            for (&weight, &rate) in weights[..piece.packs].iter().zip(&work.rate[piece.node_packs()]) {
                change += rate * weight;
            }
            work.stations[piece.joined.begin].velocity + change.sum()
        }
        SidePlace::On(fixture) => match plan.effects.contacts.fixtures[fixture].point {
            Some(point) => work.points[point].velocity,
            // The world moves with minus the velocity of the frame.
            None => Twist { angular: VectorSpace::zero(), linear: -work.surroundings.velocity },
        },
        SidePlace::AtRest => return [Vector::zero(); 2],
    };
    let angular = G::axial_in_space(plan.frame, twist.angular);
    [angular, G::in_space(plan.frame, twist.linear) + angular.cross(centre)]
}

/// Length of the smaller of two semi-axes.
fn smaller(semi_axes: [Vector<f64>; 2]) -> f64 {
    semi_axes.map(|axis| axis.dot(axis)).into_iter().fold(f64::INFINITY, f64::min).sqrt()
}

impl<'a, G: Turning> Scene<'a, G> {
    /// A part of a curve.
    #[inline(always)]
    fn part(&self, c: usize, index: usize) -> Part<'_> {
        let curve = &self.plan.effects.contacts.curves[c];
        let seen = &self.samples[curve.first_sample..][..curve.samples.len()];
        part(curve, index, Shape::new(curve, self.terms, self.axes), self.bends[c], seen)
    }

    /// Bounding volumes of the parts of a curve.
    fn spans(&self, c: usize) -> &[Span] {
        let curve = &self.plan.effects.contacts.curves[c];
        &self.spans[curve.first_sample..][..curve.samples.len() - 1]
    }

    /// Adds the contact points of a pair.
    pub(super) fn add_points_of_pair(&self, p: usize, pair: &Pair, found: &mut Found<'_, G::Pack>) {
        let round;
        let grown = self.grown[p];
        let other = match &pair.sides[1] {
            Side::Solid(solid) => {
                let on = SidePlace::of(self.plan.effects.contacts.solids[*solid].on);
                Other::Solid { solid: placed(self.plan, self.poses, *solid), on, centre: None, grown }
            }
            Side::Ball(ball) => {
                let Ball { on, radius, .. } = self.plan.effects.contacts.balls[*ball];
                let centre = self.centres[*ball];
                round = Solid::Ball { centre, radius };
                let solid = Placed { solid: &round, pose: None };
                Other::Solid { solid, on: SidePlace::of(on), centre: Some(centre), grown }
            }
            Side::Rod(curves) => {
                Other::Rod { pair, first: curves.start, end: curves.end, near: self.near.of_pair(p) }
            }
            Side::Body(_) => return,
        };
        match &pair.sides[0] {
            Side::Ball(ball) => {
                let Ball { on, radius, thickness, .. } = self.plan.effects.contacts.balls[*ball];
                let centre = self.centres[*ball];
                if let Other::Solid { solid, grown, .. } = &other
                    && solid.is_certainly_beyond(centre, radius + grown)
                {
                    return;
                }
                if let Some(nearest) = self.nearest(&other, centre, None) {
                    let first = FirstPlace {
                        on: SidePlace::of(on),
                        centre,
                        radius,
                        thickness,
                        rolling: None,
                        weight: 1.0,
                        axis: Vector::zero(),
                        share: None,
                    };
                    self.add_contact_point(p, &first, &nearest, found);
                }
            }
            Side::Rod(curves) => {
                for c in curves.clone().filter(|&c| self.may_meet(c, &other)) {
                    let mut seen = None;
                    for index in 0..self.spans(c).len() {
                        if self.part_may_meet(c, index, &other) {
                            self.add_points_along(p, c, &self.part(c, index), &other, &mut seen, found);
                        }
                    }
                }
            }
            Side::Body(body) => {
                if let Other::Solid { solid, on, .. } = other {
                    self.add_points_of_body(p, &self.plan.effects.contacts.bodies[*body], &solid, on, found);
                }
            }
            Side::Solid(_) => {}
        }
    }

    /// Adds the contact points of the corners and edges of a body.
    #[inline(never)]
    fn add_points_of_body(
        &self,
        p: usize,
        body: &Body,
        solid: &Placed<'_>,
        on: SidePlace,
        found: &mut Found<'_, G::Pack>,
    ) {
        let corners = &self.corners[body.first_corner..][..body.corners.len()];
        let Body { radius, thickness, .. } = *body;
        let mut add_contact_point = |centre, distance, rolling| {
            let side_place = SidePlace::of(body.on);
            let axis = Vector::zero();
            let share = None;
            let first =
                FirstPlace { on: side_place, centre, radius, thickness, rolling, weight: 1.0, axis, share };
            let is_carried = matches!(on, SidePlace::On(_));
            self.add_contact_point(
                p,
                &first,
                &Nearest { distance, on, centre: None, radius: 0.0, is_carried },
                found,
            );
        };
        if solid.is_beyond(corners[0], radius + body.size) {
            return;
        }
        for &corner in corners {
            add_contact_point(corner, solid.distance(corner), None);
        }
        for &ends in &body.edges {
            if let Some(edge::Nearest { place, distance, rolling }) =
                edge::nearest(solid, ends.map(|end| corners[end]), radius)
            {
                add_contact_point(place, distance, rolling);
            }
        }
    }

    /// Whether a curve can be close to the other surface.
    fn may_meet(&self, c: usize, other: &Other<'_>) -> bool {
        match *other {
            Other::Rod { near, .. } => others(near, c).next().is_some(),
            Other::Solid { solid, grown, .. } => {
                let (centre, radius) = self.bounds[c];
                self.is_near[c] && !solid.is_beyond(centre, radius + grown)
            }
        }
    }

    /// Whether a part of a curve can be close to the other surface.
    fn part_may_meet(&self, c: usize, index: usize, other: &Other<'_>) -> bool {
        let Other::Rod { pair, near, .. } = *other else { return true };
        self.near_parts(c, index, pair, near).next().is_some()
    }

    /// Bounding volumes of the parts of another rod that can be close to a part of a curve.
    fn near_parts<'n>(
        &'n self,
        c: usize,
        index: usize,
        pair: &Pair,
        near: &'n [[usize; 2]],
    ) -> impl Iterator<Item = &'n Span> {
        let (spans, chords, neighbourhood) = (self.spans, self.chords, pair.neighbourhood);
        let curves = &self.plan.effects.contacts.curves;
        let span = &spans[curves[c].first_sample + index];
        let [from, to] = curves[c].arcs(index);
        others(near, c).filter(move |&o| span.may_overlap(&chords[o])).flat_map(move |o| {
            let curve = &curves[o];
            let parts = spans[curve.first_sample..][..curve.samples.len() - 1].iter().enumerate();
            parts.filter_map(move |(i, there)| {
                let [begin, end] = curve.arcs(i);
                let is_neighbour =
                    neighbourhood > 0.0 && begin < to + neighbourhood && end > from - neighbourhood;
                (!is_neighbour && span.may_overlap(there)).then_some(there)
            })
        })
    }

    /// Adds the contact points of a part of a curve. `seen` is the nearest part of the other surface to an end, with the index of the end.
    fn add_points_along(
        &self,
        p: usize,
        c: usize,
        part: &Part<'_>,
        other: &Other<'_>,
        seen: &mut Option<(usize, Option<Nearest>)>,
        found: &mut Found<'_, G::Pack>,
    ) {
        if part.half_extents.is_some() {
            self.add_points_along_ellipses(p, c, part, other, found);
            return;
        }
        let widening = part.widening();
        let nearest =
            |x: f64, place: Vector<f64>| self.nearest(other, place, Some(part.arc + part.length * x));
        let gap_to = |x: f64, slope: Vector<f64>, nearest: Option<Nearest>| {
            nearest.map_or(
                (f64::INFINITY, 0.0),
                |Nearest { distance: Distance { value, normal, .. }, .. }| {
                    (value - part.radius(x), normal.dot(slope) - widening)
                },
            )
        };
        let [[start, start_slope], [end, end_slope]] = part.ends;
        let at_start = match seen.take() {
            Some((index, seen)) if index + 1 == part.index => seen,
            _ => nearest(0.0, start),
        };
        let at_end = nearest(1.0, end);
        *seen = Some((part.index, at_end));
        let ends = [gap_to(0.0, start_slope, at_start), gap_to(1.0, end_slope, at_end)];
        if ends[0].0 + ends[1].0 >= part.reach() {
            return;
        }
        let bend = self.bend_of(other, c, part);
        let in_tube = self.in_tube(other, part, bend);
        let bore = in_tube.and_then(|_| other.tube()).map(Tube::radius);
        let within = |x: f64, seen| match bore {
            Some(bore) => up_to_clearance(seen, bore - part.radius(x), widening),
            None => seen,
        };
        let ends = [within(0.0, ends[0]), within(1.0, ends[1])];
        let gap = |x: f64| {
            let [position, slope, _] = part.at(x);
            within(x, gap_to(x, slope, nearest(x, position)))
        };
        let negligible = NEGLIGIBLE * part.radii[0].max(part.radii[1]);
        let pieces = in_tube.unwrap_or_else(|| Pieces::one(part.bend + bend));
        let gap = Gap { at: gap, bend: |x| pieces.bend(x), negligible };
        let mut hints = [0.0; MOST_HINTS];
        let hints = if in_tube.is_some() { pieces.cuts() } else { self.hints(c, part, other, &mut hints) };
        for &interval in gap.touched(ends, hints).as_slice() {
            self.add_points_by_features(p, c, part, interval, other, found);
        }
    }

    /// Adds the contact points of a part of a curve whose sections are not round.
    #[inline(never)]
    fn add_points_along_ellipses(
        &self,
        p: usize,
        c: usize,
        part: &Part<'_>,
        other: &Other<'_>,
        found: &mut Found<'_, G::Pack>,
    ) {
        let thickest = part.radii[0].max(part.radii[1]);
        // From the centres of the sections, with their largest radius.
        let [[start, _], [end, _]] = part.ends;
        let [start, end] = [(0.0, start), (1.0, end)]
            .map(|(x, place)| self.distance(other, part, x, place).value - thickest);
        if start + end >= part.reach() {
            return;
        }
        let value = |x: f64| {
            let semi = part.semi_axes(x).unwrap_or_default();
            self.rim(other, part, x, part.at(x)[0], semi).distance.value
        };
        // Sections rotate along the rod: the slope is a difference of neighbours.
        let gap = |x: f64| {
            let [before, after] = [(x - DIFFERENCE_STEP).max(0.0), (x + DIFFERENCE_STEP).min(1.0)];
            (value(x), (value(after) - value(before)) / (after - before))
        };
        let ends = [gap(0.0), gap(1.0)];
        let bend = part.bend + part.turn() + self.bend_of(other, c, part);
        let gap = Gap { at: gap, bend: |_| bend, negligible: NEGLIGIBLE * thickest };
        let mut hints = [0.0; MOST_HINTS];
        for &interval in gap.touched(ends, self.hints(c, part, other, &mut hints)).as_slice() {
            self.add_points_by_features(p, c, part, interval, other, found);
        }
    }

    /// Contribution of a non-convex other surface to the bound of the negative second derivative of the gap, at distances up to half
    /// of its radius of curvature.
    fn bend_of(&self, other: &Other<'_>, c: usize, part: &Part<'_>) -> f64 {
        let curvature = match *other {
            Other::Solid { solid, .. } => solid.solid.hollowness(),
            Other::Rod { near, .. } => others(near, c)
                .map(|o| self.bends[o] / self.plan.effects.contacts.curves[o].length.powi(2))
                .fold(0.0, f64::max),
        };
        let [[_, a], [_, b]] = part.ends;
        2.0 * curvature * a.dot(a).max(b.dot(b))
    }

    /// The pieces of a part in the bore of a tube, beside which the gap bends by no more than that of the part and this.
    fn in_tube(&self, other: &Other<'_>, part: &Part<'_>, bend: f64) -> Option<Pieces> {
        let &Other::Solid { solid, .. } = other else { return None };
        other.tube().and_then(|tube| InTube { part, solid, tube, bend: part.bend + bend }.pieces())
    }

    /// Places at which a part of a curve may come close to another rod although the gaps at its ends do not show it: for each close part
    /// of that rod, the place nearest to its chord.
    fn hints<'b>(
        &self,
        c: usize,
        part: &Part<'_>,
        other: &Other<'_>,
        hints: &'b mut [f64; MOST_HINTS],
    ) -> &'b [f64] {
        let Other::Rod { pair, near, .. } = *other else { return &[] };
        let span = &self.spans(c)[part.index];
        let mut number = 0;
        for there in self.near_parts(c, part.index, pair, near) {
            let x = span.nearest_to(there);
            let is_known = hints[..number].iter().any(|known| (known - x).abs() < SAME_HINT);
            if x > SAME_HINT && x < 1.0 - SAME_HINT && !is_known && number < MOST_HINTS {
                hints[number] = x;
                number += 1;
            }
        }
        hints[..number].sort_unstable_by(f64::total_cmp);
        &hints[..number]
    }

    /// Adds the contact points between two places of a part of a curve, divided where another feature of a solid becomes the nearest one:
    /// there the gap is not smooth.
    fn add_points_by_features(
        &self,
        p: usize,
        c: usize,
        part: &Part<'_>,
        [from, to]: [f64; 2],
        other: &Other<'_>,
        found: &mut Found<'_, G::Pack>,
    ) {
        let Other::Solid { solid, .. } = other else {
            return self.add_points_between(p, c, part, [from, to], other, found);
        };
        if !solid.solid.has_features() {
            return self.add_points_between(p, c, part, [from, to], other, found);
        }
        let feature = |x: f64| {
            let centre = part.at(x)[0];
            let semi = part.semi_axes(x);
            solid.feature(semi.map_or(centre, |semi| ellipse::nearest(solid, centre, semi).place))
        };
        let mut begin = from;
        for place in changes(feature, [from, to]).into_iter().flatten() {
            self.add_points_between(p, c, part, [begin, place], other, found);
            begin = place;
        }
        self.add_points_between(p, c, part, [begin, to], other, found);
    }

    /// Adds the contact points between two places of a part of a curve.
    fn add_points_between(
        &self,
        p: usize,
        c: usize,
        part: &Part<'_>,
        [from, to]: [f64; 2],
        other: &Other<'_>,
        found: &mut Found<'_, G::Pack>,
    ) {
        let is_whole = from == 0.0 && to == 1.0;
        for (i, (node, weight)) in NODES.into_iter().zip(WEIGHTS).enumerate() {
            let x = from + (to - from) * node;
            let at = part.from + part.part * x;
            let on = SidePlace::Along { curve: c, x: at };
            let length = (to - from) * part.length;
            let (weight, share) = (weight * length, Some(Share { node: i, length }));
            let axis = self.axis(p, c, part, x, found);
            let known = is_whole.then(|| &self.plan.effects.contacts.curves[c].whole[part.index][i][..]);
            let centre = self.reach((c, at), known, found, 0);
            let arc = part.arc + part.length * x;
            if let Some(semi) = part.semi_axes(x) {
                let Rim { place, distance, rolling } = self.rim(other, part, x, centre, semi);
                let Some(nearest) = self.nearest(other, place, Some(arc)) else { continue };
                let thickness = smaller(semi);
                let rolling = Some(rolling);
                let first =
                    FirstPlace { on, centre: place, radius: 0.0, thickness, rolling, weight, axis, share };
                self.add_contact_point(p, &first, &Nearest { distance, ..nearest }, found);
                continue;
            }
            if let Some(nearest) = self.nearest(other, centre, Some(arc)) {
                let radius = part.radius(x);
                let first =
                    FirstPlace { on, centre, radius, thickness: radius, rolling: None, weight, axis, share };
                self.add_contact_point(p, &first, &nearest, found);
            }
        }
    }

    /// Distance of the other surface from a point at a place of a part; infinite if there are only neighbours.
    fn distance(&self, other: &Other<'_>, part: &Part<'_>, x: f64, point: Vector<f64>) -> Distance {
        let nowhere =
            Distance { value: f64::INFINITY, normal: Vector::zero(), curvature: Symmetric::diagonal(0.0) };
        self.nearest(other, point, Some(part.arc + part.length * x))
            .map_or(nowhere, |nearest| nearest.distance)
    }

    /// The point of a section's edge, with this centre and these semi-axes, that is nearest to the other surface.
    fn rim(
        &self,
        other: &Other<'_>,
        part: &Part<'_>,
        x: f64,
        centre: Vector<f64>,
        semi: [Vector<f64>; 2],
    ) -> Rim {
        match other {
            Other::Solid { solid, grown, .. } => {
                let rim = ellipse::nearest(solid, centre, semi);
                Rim { distance: rim.distance.beyond(*grown), ..rim }
            }
            Other::Rod { .. } => {
                ellipse::nearest_to(|place| self.distance(other, part, x, place), centre, semi)
            }
        }
    }

    /// The direction of the rod at a place, if friction depends on it.
    fn axis(
        &self,
        p: usize,
        c: usize,
        part: &Part<'_>,
        x: f64,
        found: &mut Found<'_, G::Pack>,
    ) -> Vector<f64> {
        if self.plan.effects.contacts.pairs[p].law.is_even() {
            return Vector::zero();
        }
        let curve = &self.plan.effects.contacts.curves[c];
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

    /// The part of the other surface nearest to a point, which is at this arc length of its own rod.
    fn nearest(&self, other: &Other<'_>, point: Vector<f64>, arc: Option<f64>) -> Option<Nearest> {
        match other {
            Other::Solid { solid, on, centre, grown } => {
                let distance = solid.distance(point).beyond(*grown);
                let is_carried = matches!(on, SidePlace::On(_)) && centre.is_none();
                Some(Nearest { distance, on: *on, centre: *centre, radius: solid.round(), is_carried })
            }
            Other::Rod { pair, first, end, .. } => {
                let arc = if pair.neighbourhood > 0.0 { arc } else { None };
                let but = arc.map(|arc| (arc, pair.neighbourhood));
                let (curve, part, x) = self.nearest_on_rod(*first..*end, point, but)?;
                Some(nearest_at(curve, &part, x, point))
            }
        }
    }

    /// The nearest place of the curves of a rod, without neighbours: its curve, part, and fraction of the part.
    fn nearest_on_rod(
        &self,
        curves: Range<usize>,
        point: Vector<f64>,
        but: Option<(f64, f64)>,
    ) -> Option<(usize, Part<'_>, f64)> {
        let is_neighbour = |c: usize, index: usize| {
            but.is_some_and(|(arc, near)| {
                let [begin, end] = self.plan.effects.contacts.curves[c].arcs(index);
                begin < arc + near && end > arc - near
            })
        };
        // Starts with the part of the lowest bound, which excludes most others, often all: the next bound tells.
        let mut hope = (f64::INFINITY, curves.start, 0);
        let mut next = f64::INFINITY;
        let around = |c: usize| {
            let (centre, radius) = self.bounds[c];
            distance::between(point, centre) - radius
        };
        for c in curves.clone().filter(|&c| self.is_near[c]) {
            let least = around(c);
            if least >= hope.0 {
                next = next.min(least);
                continue;
            }
            for (index, span) in self.spans(c).iter().enumerate() {
                let least = span.distance(point);
                if least < next && !is_neighbour(c, index) {
                    if least < hope.0 {
                        (next, hope) = (hope.0, (least, c, index));
                    } else {
                        next = least;
                    }
                }
            }
        }
        if hope.0 == f64::INFINITY {
            return None;
        }
        let look = |c: usize, index: usize| {
            let part = self.part(c, index);
            let x = part.nearest_to(point);
            (distance::between(point, part.at(x)[0]) - part.radius(x), c, index, x)
        };
        let (_, c, index) = hope;
        let mut best = look(c, index);
        if next < best.0 {
            for o in curves.clone().filter(|&o| self.is_near[o]) {
                if around(o) >= best.0 {
                    continue;
                }
                for (i, span) in self.spans(o).iter().enumerate() {
                    if (o, i) != (c, index) && span.distance(point) < best.0 && !is_neighbour(o, i) {
                        let other = look(o, i);
                        if other.0 < best.0 {
                            best = other;
                        }
                    }
                }
            }
        }
        let (_, curve, index, x) = best;
        let part = self.part(curve, index);
        // The nearest place may be an end of the searched parts, beyond which there are neighbours.
        let (arc, is_end) = (part.arc + part.length * x, x == 0.0 || x == 1.0);
        let adjoins = |o: usize, i: usize| {
            let beyond = self.plan.effects.contacts.curves[o].arcs(i)[if x == 0.0 { 1 } else { 0 }];
            (arc - beyond).abs() <= SAME_PLACE * part.length.max(arc) && is_neighbour(o, i)
        };
        if is_end && but.is_some() && curves.clone().any(|o| (0..self.spans(o).len()).any(|i| adjoins(o, i)))
        {
            return None;
        }
        Some((curve, part, x))
    }

    /// A place of a curve, in space and the frame of the plan. Writes the weights of the nodes, unless they are known, to the memory of
    /// the next contact point.
    fn reach(
        &self,
        (curve, x): (usize, f64),
        known: Option<&[G::Pack]>,
        found: &mut Found<'_, G::Pack>,
        side: usize,
    ) -> Vector<f64> {
        let curve: &Curve<G::Pack> = &self.plan.effects.contacts.curves[curve];
        let piece = &self.plan.pieces[curve.piece];
        let stride = self.plan.effects.contacts.packs;
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

    /// Adds a contact point if the surfaces overlap; the weights of its first side are in the memory of the next contact point.
    fn add_contact_point(
        &self,
        p: usize,
        first: &FirstPlace,
        nearest: &Nearest,
        found: &mut Found<'_, G::Pack>,
    ) {
        let pair = &self.plan.effects.contacts.pairs[p];
        let &FirstPlace { on, centre, radius, thickness, rolling, weight, axis, share } = first;
        let overlap = radius - nearest.distance.value;
        if overlap <= 0.0 || found.touches.len() == self.plan.effects.contacts.capacity {
            return;
        }
        let sides = [on, nearest.on];
        let is_carried = nearest.is_carried;
        let of_other = match (nearest.on, nearest.centre) {
            (SidePlace::Along { curve, x }, _) => {
                let middle = self.reach((curve, x), None, found, 1);
                if is_carried { centre } else { middle }
            }
            (SidePlace::AtRest, _) => Vector::zero(),
            (SidePlace::On(_), Some(of_other)) => of_other,
            (SidePlace::On(_), None) => centre,
        };
        let centres = [centre, of_other];
        let stride = self.plan.effects.contacts.packs;
        let up_to = &found.up_to[2 * found.touches.len() * stride..][..2 * stride];
        let motions = [0, 1].map(|s| {
            let weights = &up_to[s * stride..][..stride];
            motion(self.plan, self.work, sides[s], centres[s], weights)
        });
        // Contacts of a rod with itself are found twice, from both sides.
        let weight = if pair.neighbourhood > 0.0 { 0.5 * weight } else { weight };
        let Distance { normal, curvature, .. } = nearest.distance;
        let radii = [radius, nearest.radius];
        let contact_point = ContactPoint {
            law: pair.law_at(on, self.stiffest[p], &self.plan.effects.contacts.curves),
            weight,
            overlap,
            normal,
            curvature,
            radii,
            is_carried,
            rolling,
            thickness,
            motions,
            axis,
            held: self.held.and_then(|held| Held::at(held, p, on, weight)),
        };
        let contact_force = contact_point.contact_force();
        found.touches.push(Touch { pair: p, sides, centres, share, contact_point, contact_force });
        // Memory of the next one.
        let needed = 2 * (found.touches.len() + 1) * stride;
        if found.up_to.len() < needed {
            found.up_to.resize(2 * needed, G::Pack::splat(0.0));
        }
    }
}
