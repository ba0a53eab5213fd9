//! Detection of surfaces that pass through each other between two shapes, although they are apart in both.
//!
//! Places move along straight lines between the shapes ([`patch`]). The part of a rod between two samples is the cubic through these and
//! its slopes there: over an edge the chord lies inside the bend by many radii of a thin wire. Two moving parts are divided until they are
//! almost straight, and checked by conservative advancement (Mirtich 1996): within a time that follows from their distance and their
//! speeds they cannot meet.
//!
//! A moving solid is considered in its own axes. While these rotate by the rotation vector a and a place
//! relative to their origin moves from d to d + e, the place follows a curve in these axes whose second
//! derivative is at most `a^2 |d| + 2 a |e|`. The path is divided until its pieces are almost straight; their
//! remaining curvature counts as depth. If the rotation is so large that the axes do not determine it, the
//! solid counts as having passed through everything within its reach.

use crate::model::Radius;
use crate::numerics::lie::{Quaternion, Rotation, Vector};
use crate::robot::effects::contact::broad_phase::Ball;
use crate::robot::effects::contact::patch::{
    self, Line, Patch, SHORT_PATH, TUNNELLING_OVERLAP, deeper, goes_deeper,
};
use crate::robot::effects::contact::plan::{Body, Fixed, Pair, Side};
use crate::robot::effects::contact::shapes::distance::{
    between as distance, of_segments as distance_of_segments,
};
use crate::robot::effects::contact::shapes::obstacle::{Placed, Pose, Solid};
use crate::robot::effects::contact::state::{Cached, ContactState, Span};
use crate::robot::effects::contact::{broad_phase, detection};
use crate::robot::plan::Plan;
use crate::robot::state::Workspace;
use crate::robot::turning::Turning;

/// Surfaces count as having touched on the path if they overlap by more than [`TUNNELLING_OVERLAP`] of this part of a radius.
const TOUCHING_FRACTION: f64 = 0.04;

/// Largest deviation of a piece of a path, or of a rod, from its chord, as a part of the radius, and the maximum number of pieces of a path.
const LARGEST_DEVIATION: f64 = 0.05;
const MOST_PIECES: usize = 64;

/// Two poses determine a rotation only below half a revolution: beyond this angle, in radians, a solid counts as having passed through
/// everything within its reach, so that steps are shortened.
const LARGEST_TURN: f64 = 2.0;

/// Whether any pair has a surface with two sides.
pub(crate) fn is_possible<G: Turning>(plan: &Plan<G>) -> bool {
    plan.effects.contacts.pairs.iter().any(|pair| has_two_sides(plan, pair))
}

/// Whether the first side of a pair may be on either side of the second.
pub(crate) fn has_two_sides<G: Turning>(plan: &Plan<G>, pair: &Pair) -> bool {
    match pair.sides[1] {
        Side::Solid(solid) => plan.effects.contacts.solids[solid].solid.can_be_passed(),
        _ => true,
    }
}

/// Stores the positions of surfaces in the shape evaluated last.
pub(crate) fn store_surfaces<G: Turning>(work: &mut Workspace<G>) {
    let contact = &mut work.effects.contact;
    let Cached { of, samples, bounds, centres, corners, poses, is_pending, .. } = &mut contact.cached;
    *is_pending = false;
    of.clear();
    of.extend_from_slice(&work.kinematics_of);
    samples.clone_from(&contact.samples);
    bounds.clone_from(&contact.bounds);
    centres.clone_from(&contact.centres);
    corners.clone_from(&contact.corners);
    poses.clone_from(&contact.poses);
}

/// Computes how far the curves have moved since the stored shape.
fn measure_displacements<G: Turning>(plan: &Plan<G>, work: &mut Workspace<G>) {
    let ContactState { cached: Cached { samples: before, moved, .. }, samples, .. } =
        &mut work.effects.contact;
    moved.clear();
    moved.extend(plan.effects.contacts.curves.iter().map(|curve| {
        let own = curve.first_sample..curve.first_sample + curve.samples.len();
        let paths = before[own.clone()].iter().zip(&samples[own]);
        paths.map(|([before, _], [now, _])| distance(*before, *now)).fold(0.0, f64::max)
    }));
    let ContactState { cached, bounds: now, .. } = &mut work.effects.contact;
    let Cached { bounds, swept, branches, .. } = cached;
    swept.clear();
    swept.extend(bounds.iter().zip(&*now).map(|(&(before, of_before), &(now, of_now))| {
        ((before + now) * 0.5, 0.5 * distance(before, now) + of_before.max(of_now))
    }));
    branches.resize(2 * swept.len(), (Vector::zero(), 0.0));
    broad_phase::enclose(&plan.effects.contacts, swept, branches);
}

/// Whether the surfaces of any pair have passed through each other between the stored shape and the one evaluated last.
pub(crate) fn has_tunnelled<G: Turning>(plan: &Plan<G>, work: &mut Workspace<G>, measure: Radius) -> bool {
    measure_displacements(plan, work);
    if have_rods_crossed(plan, work, measure) {
        return true;
    }
    let paths = Paths { plan, q: &work.kinematics_of, contact: &work.effects.contact, measure };
    plan.effects.contacts.pairs.iter().any(|pair| match &pair.sides {
        [Side::Rod(_), Side::Rod(_)] => false,
        [Side::Rod(curves), Side::Ball(ball)] => {
            let (there, other) = (paths.of_ball(*ball), plan.effects.contacts.balls[*ball].radius);
            let solid = Solid::Ball { centre: Vector::zero(), radius: other };
            curves.clone().any(|c| {
                paths.parts(c).any(|part| {
                    part.patch.beside(there).is_deep_in(&solid, part.thin, measure.of(part.thin, other))
                })
            })
        }
        [Side::Rod(curves), Side::Solid(solid)] => {
            if let Some(moving) = paths.moving(*solid) {
                return moving.solid.can_be_passed()
                    && curves.clone().any(|c| {
                        paths
                            .parts(c)
                            .any(|part| moving.is_overlapped_deeply(&part.patch, part.thin, measure))
                    });
            }
            let solid = &plan.effects.contacts.solids[*solid].solid;
            curves.clone().any(|c| {
                let (centre, radius) = paths.bound(c);
                solid.can_be_passed()
                    && !solid.is_beyond(centre, radius)
                    && paths
                        .parts(c)
                        .any(|part| part.patch.is_deep_in(solid, part.thin, measure.beside(part.thin, solid)))
            })
        }
        [Side::Ball(ball), second] => {
            let (path, radius) = (paths.of_ball(*ball), plan.effects.contacts.balls[*ball].radius);
            let patch = Patch(path.map(|place| [place]));
            match second {
                Side::Ball(other) => {
                    let (there, other) = (paths.of_ball(*other), plan.effects.contacts.balls[*other].radius);
                    let solid = Solid::Ball { centre: Vector::zero(), radius: other };
                    patch.beside(there).is_deep_in(&solid, radius, measure.of(radius, other))
                }
                Side::Solid(solid) => {
                    if let Some(moving) = paths.moving(*solid) {
                        return moving.solid.can_be_passed()
                            && moving.is_overlapped_deeply(&patch, radius, measure);
                    }
                    let solid = &plan.effects.contacts.solids[*solid].solid;
                    solid.can_be_passed() && patch.is_deep_in(solid, radius, measure.beside(radius, solid))
                }
                Side::Rod(_) | Side::Body(_) => unreachable!("what meets solids is the first side"),
            }
        }
        [Side::Body(body), Side::Solid(solid)] => {
            paths.has_body_tunnelled(&plan.effects.contacts.bodies[*body], *solid)
        }
        [Side::Solid(_), _] | [_, Side::Body(_)] | [Side::Body(_), _] => false,
    })
}

/// Whether rods have passed through each other, or through themselves.
fn have_rods_crossed<G: Turning>(plan: &Plan<G>, work: &mut Workspace<G>, measure: Radius) -> bool {
    let mut state = std::mem::take(&mut work.effects.contact);
    let mut near = std::mem::take(&mut state.near);
    let mut swept_parts = std::mem::take(&mut state.cached.swept_parts);
    swept_parts.clear();
    swept_parts.resize(state.samples.len(), None);
    let have_crossed = plan.effects.contacts.pairs.iter().any(|pair| {
        let [Side::Rod(rod), Side::Rod(other)] = &pair.sides else { return false };
        near.clear();
        broad_phase::gather(&plan.effects.contacts, pair, [rod, other], &state.cached.branches, &mut near);
        near.iter().any(|&[c, o]| {
            for curve in [c, o] {
                detection::compute_slopes_and_bounds(plan, &work.slope, &mut state, curve);
            }
            let paths = Paths { plan, q: &work.kinematics_of, contact: &state, measure };
            if !paths.swept(c).may_overlap(&paths.swept(o)) {
                return false;
            }
            for curve in [c, o] {
                paths.sweep_parts(curve, &mut swept_parts);
            }
            paths.have_crossed(pair, [c, o], &swept_parts)
        })
    });
    (state.near, state.cached.swept_parts) = (near, swept_parts);
    work.effects.contact = state;
    have_crossed
}

/// The radius of a sphere or capsule, zero for other solids.
fn round(solid: &Solid) -> f64 {
    Placed { solid, pose: None }.round()
}

impl Radius {
    fn of(self, first: f64, second: f64) -> f64 {
        let smaller = if second > 0.0 { first.min(second) } else { first };
        match self {
            Self::Smaller | Self::Touching => self.part() * smaller,
            Self::Larger => first.max(second),
        }
    }

    /// The reference length for overlaps of a surface with this radius and a solid. For the wall of a tube, only passing its middle
    /// counts: the wall pushes to the nearer side, and chords of rods cut through it in bends.
    fn beside(self, radius: f64, solid: &Solid) -> f64 {
        match (self, solid) {
            (Self::Smaller | Self::Larger, Solid::Tube(tube)) => radius + tube.deepest(),
            _ => self.of(radius, round(solid)),
        }
    }

    /// The part of a radius that counts.
    fn part(self) -> f64 {
        if self == Self::Touching { TOUCHING_FRACTION } else { 1.0 }
    }
}

/// Previous and present position of a place.
type Path = [Vector<f64>; 2];

/// A part of a curve between two samples.
struct Part {
    /// What its centre line sweeps.
    patch: Patch<4>,
    radius: f64,
    /// Its smallest half extent: a surface that passes through it comes closer than this.
    thin: f64,
    arc: f64,
    length: f64,
}

impl Part {
    /// A ball around the volume that it sweeps.
    fn bound(&self) -> (Vector<f64>, f64) {
        let (centre, radius) = self.patch.bound();
        (centre, radius + self.radius)
    }
}

struct Paths<'a, G: Turning> {
    plan: &'a Plan<G>,
    /// Present coordinates.
    q: &'a [f64],
    contact: &'a ContactState<G::Pack>,
    measure: Radius,
}

impl<G: Turning> Paths<'_, G> {
    /// A ball around the volume that a curve sweeps.
    fn bound(&self, curve: usize) -> (Vector<f64>, f64) {
        self.contact.cached.swept[curve]
    }

    /// The volume that a curve sweeps, around its chord.
    fn swept(&self, curve: usize) -> Span {
        self.contact.chords[curve].widened(self.contact.cached.moved[curve])
    }

    fn of_ball(&self, ball: usize) -> Path {
        [self.contact.cached.centres[ball], self.contact.centres[ball]]
    }

    /// A moving solid with its motion; `None` if it is at rest in the frame.
    fn moving(&self, solid: usize) -> Option<Moving<'_>> {
        let Fixed { on, solid: own } = &self.plan.effects.contacts.solids[solid];
        let Self { q, contact, .. } = self;
        on.map(|fixture| {
            let turned_by = &self.plan.effects.contacts.fixtures[fixture].turned_by;
            let change = |k: usize| (q[k] - contact.cached.of[k]).abs();
            let most_turn = turned_by.iter().map(|&(k, rate)| rate * change(k)).sum();
            Moving::new(own, contact.cached.poses[solid], contact.poses[solid], most_turn)
        })
    }

    /// Whether corners or edges of a body have come so deep into a solid that the nearest surface may not be the one they entered by.
    fn has_body_tunnelled(&self, body: &Body, solid: usize) -> bool {
        let own = body.first_corner..body.first_corner + body.corners.len();
        let corners =
            || self.contact.cached.corners[own.clone()].iter().zip(&self.contact.corners[own.clone()]);
        let path = |corner: usize| {
            let k = body.first_corner + corner;
            [self.contact.cached.corners[k], self.contact.corners[k]]
        };
        let (radius, measure) = (body.radius, self.measure.part() * body.measure);
        let fixed = &self.plan.effects.contacts.solids[solid].solid;
        let fastest = corners().map(|(before, now)| distance(*before, *now)).fold(0.0, f64::max);
        let moving = self.moving(solid);
        if moving.is_none() {
            let [before, now] = path(0);
            let reach = radius + body.size + fastest;
            if fixed.is_beyond(now, reach) && fixed.is_beyond(before, reach) {
                return false;
            }
        }
        fn is_deep<const N: usize>(
            patch: &Patch<N>,
            solid: &Solid,
            moving: Option<&Moving<'_>>,
            [radius, measure]: [f64; 2],
        ) -> bool {
            match moving {
                Some(moving) => moving.goes_deep(patch, radius, measure),
                None => patch.is_deep_in(solid, radius, measure),
            }
        }
        let sizes = [radius, measure];
        let edge = |[a, b]: [Path; 2]| Patch([[a[0], b[0]], [a[1], b[1]]]);
        let corner = |path: Path| Patch(path.map(|place| [place]));
        body.edges.iter().any(|ends| is_deep(&edge(ends.map(path)), fixed, moving.as_ref(), sizes))
            || body.edges.is_empty()
                && (0..body.corners.len()).any(|k| is_deep(&corner(path(k)), fixed, moving.as_ref(), sizes))
    }

    fn parts(&self, c: usize) -> impl Iterator<Item = Part> + '_ {
        (0..self.plan.effects.contacts.curves[c].samples.len() - 1).map(move |i| self.part(c, i))
    }

    fn part(&self, c: usize, i: usize) -> Part {
        let curve = &self.plan.effects.contacts.curves[c];
        let seen = curve.first_sample..curve.first_sample + curve.samples.len();
        let shapes = [&self.contact.cached.samples[seen.clone()], &self.contact.samples[seen]];
        let last = curve.samples.len() - 2;
        let ends = [&curve.samples[i], &curve.samples[i + 1]];
        Part {
            patch: Patch(shapes.map(|samples| {
                let part = ends[1].x - ends[0].x;
                let [[p, a], [q, b]] = [i, i + 1].map(|i| [samples[i][0], samples[i][1] * part]);
                // Slopes are known at the nodes: at the ends of a rod those of the parabola through the next one.
                let way = (q - p) * 2.0;
                patch::cubic([
                    [p, if i == 0 { way - b } else { a }],
                    [q, if i == last { way - a } else { b }],
                ])
            })),
            radius: 0.5 * (ends[0].radius + ends[1].radius),
            thin: ends.iter().map(|end| 0.5 * end.half_extents[0].min(end.half_extents[1])).sum(),
            arc: curve.start + ends[0].x * curve.length,
            length: (ends[1].x - ends[0].x) * curve.length,
        }
    }

    /// Computes the balls around the volumes that the parts of a curve sweep, if they are not known.
    fn sweep_parts(&self, c: usize, swept: &mut [Option<Ball>]) {
        let first = self.plan.effects.contacts.curves[c].first_sample;
        if swept[first].is_none() {
            for (swept, part) in swept[first..].iter_mut().zip(self.parts(c)) {
                *swept = Some(part.bound());
            }
        }
    }

    /// Whether parts of two curves that may be close to each other have passed through each other; the balls around what both sweep are known.
    fn have_crossed(&self, pair: &Pair, curves: [usize; 2], swept: &[Option<Ball>]) -> bool {
        let balls = |c: usize| {
            let curve = &self.plan.effects.contacts.curves[c];
            swept[curve.first_sample..][..curve.samples.len() - 1].iter().flatten().enumerate()
        };
        let [c, o] = curves;
        balls(c).any(|(i, &(centre, radius))| {
            balls(o).any(|(j, &(there, of_other))| {
                if distance(centre, there) > radius + of_other {
                    return false;
                }
                let (part, other) = (self.part(c, i), self.part(o, j));
                // Pairs of a rod with itself appear in both orders: one suffices.
                let is_far =
                    pair.neighbourhood == 0.0 || other.arc > part.arc + part.length + pair.neighbourhood;
                is_far && have_crossed(&part, &other, self.measure.of(part.thin, other.thin))
            })
        })
    }
}

/// A solid that moves with constant velocity and angular velocity between two poses.
struct Moving<'a> {
    solid: &'a Solid,
    poses: [Pose; 2],
    /// The rotation vector of its axes, in these axes.
    turn: Vector<f64>,
    /// Upper bound of its rotation in radians, which may exceed that between both poses by whole turns.
    most_turn: f64,
}

impl<'a> Moving<'a> {
    fn new(solid: &'a Solid, before: Pose, now: Pose, most_turn: f64) -> Self {
        let seen = |axis: usize| before.rotation.apply_transposed(now.rotation.axis(axis));
        let Quaternion { w, v } = Quaternion::of_rotation(&Rotation { x: seen(0), y: seen(1), z: seen(2) });
        let sine = v.dot(v).sqrt();
        // The quaternion, of the two of a rotation, with the smaller angle.
        let angle = 2.0 * sine.atan2(w.abs()) * if w < 0.0 { -1.0 } else { 1.0 };
        let turn = if sine > 0.0 { v * (angle / sine) } else { Vector::zero() };
        Self { solid, poses: [before, now], turn, most_turn }
    }

    /// Position in the solid's axes of a place at a fraction of its path.
    fn local_position(&self, [from, to]: Path, x: f64) -> Vector<f64> {
        let [before, now] = &self.poses;
        if x >= 1.0 {
            return now.local_position(to);
        }
        let beside = from + (to - from) * x - (before.position + (now.position - before.position) * x);
        let seen = before.rotation.apply_transposed(beside);
        Quaternion::exp(self.turn * x).rotation().apply_transposed(seen)
    }

    /// The line in the solid's axes at a fraction of its paths.
    fn local_line<const N: usize>(&self, &Patch([before, now]): &Patch<N>, x: f64) -> Line<N> {
        std::array::from_fn(|i| self.local_position([before[i], now[i]], x))
    }

    /// Whether a rod or a ball of this radius that moves along a patch comes deeper into it than at the start, by the depth of `measure`.
    fn is_overlapped_deeply<const N: usize>(&self, patch: &Patch<N>, radius: f64, measure: Radius) -> bool {
        self.goes_deep(patch, radius, measure.beside(radius, self.solid))
    }

    /// Whether it comes deeper than half of `measure` and deeper than at the start.
    fn goes_deep<const N: usize>(&self, patch: &Patch<N>, radius: f64, measure: f64) -> bool {
        let [before, now] = &self.poses;
        let mut bend: f64 = 0.0;
        let angle = self.turn.dot(self.turn).sqrt();
        let beside = Patch([
            patch.0[0].map(|place| place - before.position),
            patch.0[1].map(|place| place - now.position),
        ]);
        for (from, to) in beside.0[0].iter().zip(&beside.0[1]) {
            let away = from.dot(*from).max(to.dot(*to)).sqrt();
            bend = bend.max(angle * (angle * away + 2.0 * distance(*from, *to)));
        }
        if self.most_turn > LARGEST_TURN {
            // It may have been in any orientation.
            let (centre, around) = beside.bound();
            return measure > 0.0 && centre.dot(centre).sqrt() < self.solid.reach() + radius + around;
        }
        // A curve deviates from its chord by at most an eighth of its second derivative.
        bend /= 8.0;
        let whole = Patch([0.0, 1.0].map(|x| self.local_line(patch, x)));
        let (centre, around) = whole.bound();
        let reach = radius + around + bend;
        if measure <= 0.0
            || self.solid.is_certainly_beyond(centre, reach)
            || self.solid.distance(centre).value >= reach
        {
            return false;
        }
        let pieces = ((bend / (LARGEST_DEVIATION * measure)).sqrt().ceil() as usize).clamp(1, MOST_PIECES);
        let left = bend / (pieces * pieces) as f64;
        let (deep, size) = (radius - TUNNELLING_OVERLAP * measure + left, SHORT_PATH * measure);
        let [path, _] = whole.extents();
        let comes_nearer = |deep: f64| {
            (0..pieces).any(|i| {
                let piece = [i, i + 1].map(|i| self.local_line(patch, i as f64 / pieces as f64));
                Patch(piece).comes_nearer(self.solid, deep, size)
            })
        };
        path + 2.0 * bend > size && goes_deeper(self.solid, whole.0[0], deep, size, comes_nearer)
    }
}

/// Whether two parts of rods come closer to each other on their paths than allowed ([`deeper`]).
fn have_crossed(part: &Part, other: &Part, measure: f64) -> bool {
    measure > 0.0 && have_lines_crossed(&part.patch, &other.patch, part.thin + other.thin, measure)
}

/// The same of lines with these radii together.
fn have_lines_crossed(line: &Patch<4>, other: &Patch<4>, radii: f64, measure: f64) -> bool {
    let ((centre, around), (there, around_other)) = (line.bound(), other.bound());
    if distance(centre, there) > around + around_other + radii {
        return false;
    }
    let [bow, of_other] = [line.bow(), other.bow()];
    if bow.max(of_other) <= LARGEST_DEVIATION * measure {
        return have_chords_crossed(line.chords(), other.chords(), radii, measure);
    }
    if bow > of_other {
        line.parts().iter().any(|half| have_lines_crossed(half, other, radii, measure))
    } else {
        other.parts().iter().any(|half| have_lines_crossed(line, half, radii, measure))
    }
}

/// The same of straight lines, given at both ends of their paths.
fn have_chords_crossed(line: [Line<2>; 2], other: [Line<2>; 2], radii: f64, measure: f64) -> bool {
    let moved = |[before, now]: [Line<2>; 2], i: usize| now[i] - before[i];
    let mut fastest: f64 = 0.0;
    for (i, k) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
        fastest = fastest.max(distance(moved(line, i), moved(other, k)));
    }
    let shallow = SHORT_PATH * measure;
    if fastest <= shallow {
        return false;
    }
    let at = |[before, now]: [Line<2>; 2], x: f64| [0, 1].map(|i| before[i] + (now[i] - before[i]) * x);
    let between = |x: f64| distance_of_segments(at(line, x), at(other, x));
    let start = between(0.0);
    let Some(deep) = deeper(start, radii - TUNNELLING_OVERLAP * measure, 0.0) else { return false };
    let mut x = (start - deep + shallow) / fastest;
    while x < 1.0 {
        let left = between(x) - deep;
        if left < 0.0 {
            return true;
        }
        x += (left + shallow) / fastest;
    }
    false
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::robot::effects::contact::patch::tests::{least, patch, place};
    use proptest::prelude::*;

    fn vector() -> impl Strategy<Value = Vector<f64>> {
        (-1.0..1.0, -1.0..1.0, -1.0..1.0).prop_map(|(x, y, z)| Vector::new(x, y, z))
    }

    proptest! {
        #[test]
        fn segments_are_as_near_as_their_nearest_places(a in (vector(), vector()), b in (vector(), vector())) {
            let (a, b) = ([a.0, a.1], [b.0, b.1]);
            let found = distance_of_segments(a, b);
            let tried = least(60, |x| {
                let place = a[0] + (a[1] - a[0]) * x;
                least(60, |y| distance(place, b[0] + (b[1] - b[0]) * y))
            });
            prop_assert!(found <= tried + 1e-12 && tried <= found + 0.06, "{found} {tried}");
        }

        #[test]
        fn rods_that_cross_are_seen(a in patch(), b in patch()) {
            let part = |patch: Patch<4>| Part { patch, radius: 0.05, thin: 0.05, arc: 0.0, length: 1.0 };
            let (a, b) = (part(a), part(b));
            let nearest = |x: f64| least(40, |s| least(40, |r| distance(place(&a.patch, s, x), place(&b.patch, r, x))));
            let deep = 2.0 * 0.05 - TUNNELLING_OVERLAP * 0.05;
            let found = have_crossed(&a, &b, 0.05);
            // Parts of rods that start deep may go deeper by half: they are no example.
            if nearest(0.0) > deep + LARGEST_DEVIATION * 0.05 && least(100, nearest) < deep - 2.0 * (SHORT_PATH + LARGEST_DEVIATION) * 0.05 {
                prop_assert!(found);
            }
            // Places that are tried are a tenth from each other at most.
            if least(100, nearest) > deep + 0.12 {
                prop_assert!(!found);
            }
        }
    }
}
