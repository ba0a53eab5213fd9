//! Detection of surfaces that pass through each other between two shapes, although they are apart in both.
//!
//! Places move along straight lines between the shapes. The part of a rod between two samples sweeps a
//! bilinear patch, which lies in the convex hull of its corners: if their bounding ball is clear of an
//! obstacle, so is the patch; otherwise the patch is halved. Two moving parts are checked by conservative
//! advancement (Mirtich 1996): within a time that follows from their distance and their speeds they cannot
//! meet.
//!
//! A moving solid is considered in its own axes. While these rotate by the rotation vector a and a place
//! relative to their origin moves from d to d + e, the place follows a curve in these axes whose second
//! derivative is at most `a^2 |d| + 2 a |e|`. The path is divided until its pieces are almost straight; their
//! remaining curvature counts as depth. If the rotation is so large that the axes do not determine it, the
//! solid counts as having passed through everything within its reach.

use crate::model::Radius;
use crate::numerics::lie::{Quaternion, Rotation, Vector};
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

/// Surfaces count as having passed through each other if they overlap on the path by more than this part of a radius.
const TUNNELLING_OVERLAP: f64 = 0.5;

/// Surfaces count as having touched on the path if they overlap by more than [`TUNNELLING_OVERLAP`] of this part of a radius.
const TOUCHING_FRACTION: f64 = 0.04;

/// Paths and patches shorter than this part of the radius cannot contain such an overlap unseen.
const SHORT_PATH: f64 = 0.2;

/// Largest deviation of a piece of a path from its chord, as a part of the radius, and the maximum number of pieces.
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
    let Cached { of, places, bounds, centres, corners, poses, .. } = &mut contact.cached;
    of.clear();
    of.extend_from_slice(&work.kinematics_of);
    places.clear();
    places.extend(contact.samples.iter().map(|[place, _]| *place));
    bounds.clone_from(&contact.bounds);
    centres.clone_from(&contact.centres);
    corners.clone_from(&contact.corners);
    poses.clone_from(&contact.poses);
}

/// Computes how far the curves have moved since the stored shape.
fn measure_displacements<G: Turning>(plan: &Plan<G>, work: &mut Workspace<G>) {
    let ContactState { cached: Cached { places, moved, .. }, samples, .. } = &mut work.effects.contact;
    moved.clear();
    moved.extend(plan.effects.contacts.curves.iter().map(|curve| {
        let own = curve.first_sample..curve.first_sample + curve.samples.len();
        let paths = places[own.clone()].iter().zip(&samples[own]);
        paths.map(|(before, [now, _])| distance(*before, *now)).fold(0.0, f64::max)
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
                    Patch::beside(part.paths, there).is_deep_in(
                        &solid,
                        part.thin,
                        measure.of(part.thin, other),
                    )
                })
            })
        }
        [Side::Rod(curves), Side::Solid(solid)] => {
            if let Some(moving) = paths.moving(*solid) {
                return moving.solid.can_be_passed()
                    && curves.clone().any(|c| {
                        paths.parts(c).any(|part| moving.is_overlapped_deeply(part.paths, part.thin, measure))
                    });
            }
            let solid = &plan.effects.contacts.solids[*solid].solid;
            curves.clone().any(|c| {
                let (centre, radius) = paths.bound(c);
                solid.can_be_passed()
                    && solid.distance(centre).value <= radius
                    && paths.parts(c).any(|part| {
                        Patch(part.paths).is_deep_in(solid, part.thin, measure.beside(part.thin, solid))
                    })
            })
        }
        [Side::Ball(ball), second] => {
            let (path, radius) = (paths.of_ball(*ball), plan.effects.contacts.balls[*ball].radius);
            match second {
                Side::Ball(other) => {
                    let (there, other) = (paths.of_ball(*other), plan.effects.contacts.balls[*other].radius);
                    let solid = Solid::Ball { centre: Vector::zero(), radius: other };
                    Patch::beside([path; 2], there).is_deep_in(&solid, radius, measure.of(radius, other))
                }
                Side::Solid(solid) => {
                    if let Some(moving) = paths.moving(*solid) {
                        return moving.solid.can_be_passed()
                            && moving.is_overlapped_deeply([path; 2], radius, measure);
                    }
                    let solid = &plan.effects.contacts.solids[*solid].solid;
                    solid.can_be_passed()
                        && Patch([path; 2]).is_deep_in(solid, radius, measure.beside(radius, solid))
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
    let have_crossed = plan.effects.contacts.pairs.iter().any(|pair| {
        let [Side::Rod(rod), Side::Rod(other)] = &pair.sides else { return false };
        near.clear();
        broad_phase::gather(&plan.effects.contacts, pair, [rod, other], &state.cached.branches, &mut near);
        near.iter().any(|&[c, o]| {
            for curve in [c, o] {
                detection::compute_slopes_and_bounds(plan, &work.slope, &mut state, curve);
            }
            let paths = Paths { plan, q: &work.kinematics_of, contact: &state, measure };
            paths.swept(c).may_overlap(&paths.swept(o)) && paths.have_crossed(pair, c, o)
        })
    });
    state.near = near;
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

/// A part of a curve between two samples, with the paths of its ends.
struct Part {
    paths: [Path; 2],
    radius: f64,
    /// Its smallest half extent: a surface that passes through it comes closer than this.
    thin: f64,
    arc: f64,
    length: f64,
}

impl Part {
    /// A ball around the volume that it sweeps.
    fn bound(&self) -> (Vector<f64>, f64) {
        let (centre, radius) = Patch(self.paths).bound();
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
        let is_deep = |paths: [Path; 2]| match &moving {
            Some(moving) => moving.goes_deep(paths, radius, measure),
            None => Patch(paths).is_deep_in(fixed, radius, measure),
        };
        if moving.is_none() {
            let [before, now] = path(0);
            let nearest = fixed.distance(now).value.min(fixed.distance(before).value);
            if nearest > radius + body.size + fastest {
                return false;
            }
        }
        body.edges.iter().any(|ends| is_deep(ends.map(path)))
            || (body.edges.is_empty() && (0..body.corners.len()).any(|k| is_deep([path(k); 2])))
    }

    fn parts(&self, c: usize) -> impl Iterator<Item = Part> + '_ {
        let curve = &self.plan.effects.contacts.curves[c];
        let seen = curve.first_sample..curve.first_sample + curve.samples.len();
        let places = &self.contact.cached.places[seen.clone()];
        let samples = &self.contact.samples[seen];
        curve.samples.windows(2).enumerate().map(move |(i, ends)| Part {
            paths: [i, i + 1].map(|i| [places[i], samples[i][0]]),
            radius: 0.5 * (ends[0].radius + ends[1].radius),
            thin: ends.iter().map(|end| 0.5 * end.half_extents[0].min(end.half_extents[1])).sum(),
            arc: curve.start + ends[0].x * curve.length,
            length: (ends[1].x - ends[0].x) * curve.length,
        })
    }

    /// Whether parts of two curves that may be close to each other have passed through each other.
    fn have_crossed(&self, pair: &Pair, c: usize, o: usize) -> bool {
        self.parts(c).any(|part| {
            let (centre, radius) = part.bound();
            self.parts(o).any(|other| {
                // Pairs of a rod with itself appear in both orders: one suffices.
                let is_far =
                    pair.neighbourhood == 0.0 || other.arc > part.arc + part.length + pair.neighbourhood;
                let (there, of_other) = other.bound();
                is_far
                    && distance(centre, there) <= radius + of_other
                    && have_crossed(&part, &other, self.measure)
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

    /// Whether a rod or a ball of this radius on these paths comes deeper into it than at the start, by the depth of `measure`.
    fn is_overlapped_deeply(&self, paths: [Path; 2], radius: f64, measure: Radius) -> bool {
        self.goes_deep(paths, radius, measure.beside(radius, self.solid))
    }

    /// Whether it comes deeper than half of `measure` and deeper than at the start.
    fn goes_deep(&self, paths: [Path; 2], radius: f64, measure: f64) -> bool {
        let [before, now] = &self.poses;
        let mut bend: f64 = 0.0;
        let angle = self.turn.dot(self.turn).sqrt();
        for [from, to] in paths {
            let [from, to] = [from - before.position, to - now.position];
            let away = from.dot(from).max(to.dot(to)).sqrt();
            bend = bend.max(angle * (angle * away + 2.0 * distance(from, to)));
        }
        if self.most_turn > LARGEST_TURN {
            // It may have been in any orientation.
            let beside = |[from, to]: Path| [from - before.position, to - now.position];
            let (centre, around) = Patch(paths.map(beside)).bound();
            return measure > 0.0 && centre.dot(centre).sqrt() < self.solid.reach() + radius + around;
        }
        // A curve deviates from its chord by at most an eighth of its second derivative.
        bend /= 8.0;
        let whole = Patch(paths.map(|path| [self.local_position(path, 0.0), self.local_position(path, 1.0)]));
        let (centre, around) = whole.bound();
        if measure <= 0.0 || self.solid.distance(centre).value >= radius + around + bend {
            return false;
        }
        let pieces = ((bend / (LARGEST_DEVIATION * measure)).sqrt().ceil() as usize).clamp(1, MOST_PIECES);
        let left = bend / (pieces * pieces) as f64;
        let deep = radius - TUNNELLING_OVERLAP * measure + left;
        let [path, _] = whole.extents();
        if path + 2.0 * bend <= SHORT_PATH * measure {
            return false;
        }
        let Some(deep) = deeper(whole.begins(self.solid), deep) else { return false };
        (0..pieces).any(|i| {
            let [from, to] = [i, i + 1].map(|i| i as f64 / pieces as f64);
            let piece =
                Patch(paths.map(|path| [self.local_position(path, from), self.local_position(path, to)]));
            piece.comes_nearer(self.solid, deep, SHORT_PATH * measure)
        })
    }
}

/// Smallest allowed distance along a path that starts at this distance. A path that starts deeper already may cover half of the distance
/// to the middle; `None` if it starts beyond the middle.
fn deeper(start: f64, deep: f64) -> Option<f64> {
    if start >= deep {
        Some(deep)
    } else if start > 0.0 {
        Some(TUNNELLING_OVERLAP * start)
    } else {
        None
    }
}

/// The bilinear patch between two paths, in space or relative to a moving surface.
struct Patch([Path; 2]);

impl Patch {
    /// Two paths relative to a third one.
    fn beside(paths: [Path; 2], there: Path) -> Self {
        Self(paths.map(|path| [path[0] - there[0], path[1] - there[1]]))
    }

    /// A bounding ball.
    fn bound(&self) -> (Vector<f64>, f64) {
        let [[a, b], [c, d]] = self.0;
        let centre = (a + b + c + d) * 0.25;
        (centre, [a, b, c, d].into_iter().map(|corner| distance(centre, corner)).fold(0.0, f64::max))
    }

    /// Its extents along the paths, and across.
    fn extents(&self) -> [f64; 2] {
        let [[a, b], [c, d]] = self.0;
        [distance(a, b).max(distance(c, d)), distance(a, c).max(distance(b, d))]
    }

    /// Whether a rod or a ball of this radius that moves along it comes deeper into a solid than half of `measure` and than at the start.
    fn is_deep_in(&self, solid: &Solid, radius: f64, measure: f64) -> bool {
        let [path, _] = self.extents();
        if measure <= 0.0 || path <= SHORT_PATH * measure {
            return false;
        }
        deeper(self.begins(solid), radius - TUNNELLING_OVERLAP * measure)
            .is_some_and(|deep| self.comes_nearer(solid, deep, SHORT_PATH * measure))
    }

    /// Distance from a solid at the start.
    fn begins(&self, solid: &Solid) -> f64 {
        let [[a, _], [c, _]] = self.0;
        let places = [a, (a + c) * 0.5, c].into_iter();
        places.map(|place| solid.distance(place).value).fold(f64::INFINITY, f64::min)
    }

    /// Whether it comes closer to a solid than `deep`, divided into patches of this size.
    fn comes_nearer(&self, solid: &Solid, deep: f64, size: f64) -> bool {
        let (centre, radius) = self.bound();
        let value = solid.distance(centre).value;
        if value >= deep + radius {
            return false;
        }
        if value < deep {
            return true;
        }
        radius > size && self.halves().iter().any(|half| half.comes_nearer(solid, deep, size))
    }

    fn halves(&self) -> [Self; 2] {
        let [[a, b], [c, d]] = self.0;
        let [along, across] = self.extents();
        if along > across {
            let [ab, cd] = [(a + b) * 0.5, (c + d) * 0.5];
            [Self([[a, ab], [c, cd]]), Self([[ab, b], [cd, d]])]
        } else {
            let [ac, bd] = [(a + c) * 0.5, (b + d) * 0.5];
            [Self([[a, b], [ac, bd]]), Self([[ac, bd], [c, d]])]
        }
    }
}

/// Whether two parts of rods come closer to each other on their paths than allowed ([`deeper`]).
fn have_crossed(part: &Part, other: &Part, measure: Radius) -> bool {
    let measure = measure.of(part.thin, other.thin);
    let moved = |path: Path| path[1] - path[0];
    let mut fastest: f64 = 0.0;
    for path in part.paths {
        for there in other.paths {
            fastest = fastest.max(distance(moved(path), moved(there)));
        }
    }
    let shallow = SHORT_PATH * measure;
    if measure <= 0.0 || fastest <= shallow {
        return false;
    }
    let at = |paths: [Path; 2], x: f64| paths.map(|[from, to]| from + (to - from) * x);
    let between = |x: f64| distance_of_segments(at(part.paths, x), at(other.paths, x));
    let start = between(0.0);
    let Some(deep) = deeper(start, part.thin + other.thin - TUNNELLING_OVERLAP * measure) else {
        return false;
    };
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
    use proptest::prelude::*;

    fn vector() -> impl Strategy<Value = Vector<f64>> {
        (-1.0..1.0, -1.0..1.0, -1.0..1.0).prop_map(|(x, y, z)| Vector::new(x, y, z))
    }

    fn path() -> impl Strategy<Value = Path> {
        (vector(), vector()).prop_map(|(a, b)| [a, b])
    }

    fn on(paths: [Path; 2], s: f64, x: f64) -> Vector<f64> {
        let [a, b] = paths.map(|[from, to]| from + (to - from) * x);
        a + (b - a) * s
    }

    /// The smallest of a function at places between 0 and 1.
    fn least(number: usize, f: impl Fn(f64) -> f64) -> f64 {
        (0..=number).map(|i| f(i as f64 / number as f64)).fold(f64::INFINITY, f64::min)
    }

    proptest! {
        #[test]
        fn segments_are_as_near_as_their_nearest_places(a in path(), b in path()) {
            let found = distance_of_segments(a, b);
            let tried = least(60, |x| {
                let place = a[0] + (a[1] - a[0]) * x;
                least(60, |y| distance(place, b[0] + (b[1] - b[0]) * y))
            });
            prop_assert!(found <= tried + 1e-12 && tried <= found + 0.06, "{found} {tried}");
        }

        #[test]
        fn patches_that_go_through_a_ball_are_seen(paths in (path(), path()), centre in vector(), radius in 0.01..0.2) {
            let (paths, solid) = ([paths.0, paths.1], Solid::Ball { centre, radius });
            let thick = 0.05;
            let smallest = Radius::Smaller.of(thick, radius);
            let overlap = |s: f64, x: f64| thick - solid.distance(on(paths, s, x)).value;
            let deepest = -least(200, |x| least(200, |s| -overlap(s, x)));
            let at_start = -least(200, |s| -overlap(s, 0.0));
            let found = Patch(paths).is_deep_in(&solid, thick, smallest);
            if at_start < TUNNELLING_OVERLAP * smallest && deepest > (TUNNELLING_OVERLAP + 2.0 * SHORT_PATH) * smallest {
                prop_assert!(found);
            }
            if deepest < (TUNNELLING_OVERLAP - 0.3) * smallest - 0.02 {
                prop_assert!(!found);
            }
        }

        #[test]
        fn rods_that_cross_are_seen(a in (path(), path()), b in (path(), path())) {
            let part = |paths: (Path, Path)| Part { paths: [paths.0, paths.1], radius: 0.05, thin: 0.05, arc: 0.0, length: 1.0 };
            let (a, b) = (part(a), part(b));
            let nearest = |x: f64| {
                let at = |part: &Part| part.paths.map(|[from, to]| from + (to - from) * x);
                distance_of_segments(at(&a), at(&b))
            };
            let deep = 2.0 * 0.05 - TUNNELLING_OVERLAP * 0.05;
            let found = have_crossed(&a, &b, Radius::Smaller);
            if nearest(0.0) > deep && least(2000, nearest) < deep - 2.0 * SHORT_PATH * 0.05 {
                prop_assert!(found);
            }
            if least(2000, nearest) > deep + 0.01 {
                prop_assert!(!found);
            }
        }
    }
}
