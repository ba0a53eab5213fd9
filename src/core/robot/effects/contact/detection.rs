//! Contact detection: positions of surfaces, pairs that are close to each other, and contact points.

use super::bounds::{around_ends, ball_around_ends, stretch_of};
use super::curve::{self, expand};
use super::narrow_phase::{Found, Near, Scene, motion, placed};
use crate::numerics::lie::{LANES, Lanes, Rotation, Sweep, Vector};
use crate::robot::effects::contact::plan::{Body, Curve, Fixed, Pair, Side};
use crate::robot::effects::contact::shapes::distance;
use crate::robot::effects::contact::shapes::obstacle::Pose;
use crate::robot::effects::contact::state::{ContactState, Span};
use crate::robot::effects::contact::{broad_phase, clearance};
use crate::robot::plan::Plan;
use crate::robot::state::Workspace;
use crate::robot::turning::Turning;

/// Finds all contact points of a state whose motion is up to date: in the shape in which they were found last, only their forces change.
pub(crate) fn find<G: Turning>(plan: &Plan<G>, work: &mut Workspace<G>) {
    let mut state = std::mem::take(&mut work.effects.contact);
    if is_clear(plan, &state, &work.kinematics_of) {
        state.know_apart(&work.kinematics_of);
    } else if is_known(plan, &state, &work.kinematics_of) {
        plan.instructions.run_outlined::<G::Pack, _>(Move { plan, work, state: &mut state });
    } else {
        plan.instructions.run_outlined::<G::Pack, _>(Find { plan, work, state: &mut state });
        state.know(&work.kinematics_of);
    }
    state.has_touched |= !state.touches.is_empty();
    work.effects.contact = state;
}

/// Whether the contact points in memory are those of a shape. A moving base takes obstacles to other places in the frame of the plan.
pub(crate) fn is_known<G: Turning>(plan: &Plan<G>, state: &ContactState<G::Pack>, q: &[f64]) -> bool {
    plan.world.motion.is_none() && state.is_known_in(q)
}

/// Whether nothing is near in a shape, by its coordinates alone: it need not be that of the kinematics.
pub(crate) fn is_clear<G: Turning>(plan: &Plan<G>, state: &ContactState<G::Pack>, q: &[f64]) -> bool {
    plan.world.motion.is_none() && clearance::covers(&state.clearance, &plan.effects.contacts, q)
}

/// Computes the positions of samples of curves, with their slopes, balls, bodies and solids in a shape, without contact points.
pub(crate) fn update_positions<G: Turning>(plan: &Plan<G>, work: &mut Workspace<G>) {
    let mut state = std::mem::take(&mut work.effects.contact);
    compute_positions(plan, work, &mut state);
    for curve in &plan.effects.contacts.curves {
        compute_slopes(plan, curve, &work.slope, &mut state.samples);
    }
    // Queries of bodies see their corners in the shape of the contact points.
    if !plan.effects.contacts.bodies.is_empty() && !state.is_known_in(&work.kinematics_of) {
        state.forget();
    }
    work.effects.contact = state;
}

/// The same, and which curves may touch anything.
pub(crate) fn update_candidates<G: Turning>(plan: &Plan<G>, work: &mut Workspace<G>) {
    let mut state = std::mem::take(&mut work.effects.contact);
    if is_clear(plan, &state, &work.kinematics_of) {
        state.mark_apart();
    } else if !are_all_far(plan, work, &mut state) {
        detect(plan, work, &mut state);
    }
    if !state.is_known_in(&work.kinematics_of) {
        state.forget();
    }
    work.effects.contact = state;
}

/// Computes the positions of all surfaces, and which curves may touch anything.
#[inline(always)]
fn detect<G: Turning>(plan: &Plan<G>, work: &Workspace<G>, state: &mut ContactState<G::Pack>) {
    compute_positions(plan, work, state);
    find_near(plan, work, state);
    mark_candidates(plan, work, state);
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
        state.touches.clear();
        if are_all_far(plan, work, state) {
            return;
        }
        detect(plan, work, state);
        expand(plan, work, state);
        let ContactState {
            terms,
            axes,
            bends,
            samples,
            spans,
            bounds,
            chords,
            is_near,
            near,
            near_of,
            centres,
            corners,
            poses,
            touches,
            stiffest,
            grown,
            held,
            up_to,
            weights,
            polynomials,
            ..
        } = state;
        let near = Near { curves: near, of_pairs: near_of };
        let scene = Scene {
            plan,
            work,
            terms,
            axes,
            bends,
            samples,
            spans,
            bounds,
            chords,
            is_near,
            near,
            centres,
            corners,
            poses,
            stiffest,
            grown,
            held: held.as_deref(),
        };
        let mut found = Found { touches, up_to, weights, polynomials };
        for (p, pair) in plan.effects.contacts.pairs.iter().enumerate() {
            scene.add_points_of_pair(p, pair, &mut found);
        }
    }
}

/// Takes the contact points along with another motion of the same shape.
struct Move<'a, G: Turning> {
    plan: &'a Plan<G>,
    work: &'a Workspace<G>,
    state: &'a mut ContactState<G::Pack>,
}

impl<G: Turning> Sweep for Move<'_, G> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Self { plan, work, state: ContactState { touches, up_to, .. } } = self;
        let stride = plan.effects.contacts.packs;
        for (t, touch) in touches.iter_mut().enumerate() {
            for s in 0..2 {
                let weights = &up_to[(2 * t + s) * stride..][..stride];
                touch.contact_point.motions[s] =
                    motion(plan, work, touch.sides[s], touch.centres[s], weights);
            }
            touch.contact_force = touch.contact_point.contact_force();
        }
    }
}

/// Whether rods are all that may touch, solids at rest are all that they may touch, and the balls around the ends of their curves reach
/// none of these: nothing is near then, and no samples are needed.
#[inline(always)]
fn are_all_far<G: Turning>(plan: &Plan<G>, work: &Workspace<G>, state: &mut ContactState<G::Pack>) -> bool {
    let contacts = &plan.effects.contacts;
    let mut gap = f64::INFINITY;
    let are_far = contacts.pairs.iter().zip(&state.grown).all(|(pair, grown)| {
        let [Side::Rod(curves), Side::Solid(solid)] = &pair.sides else { return false };
        let Fixed { on, solid } = &contacts.solids[*solid];
        on.is_none()
            && curves.clone().all(|c| {
                let curve = &contacts.curves[c];
                let (centre, radius) = ball_around_ends(plan, work, curve);
                gap = gap.min(solid.gap(centre, radius + grown));
                gap > 0.0
            })
    });
    if are_far {
        state.mark_apart();
        if gap.is_finite() && plan.world.motion.is_none() {
            clearance::store(&mut state.clearance, plan, work, gap);
        }
    }
    are_far
}

/// Where the samples of all curves are, bounds of these, centres of all balls, corners of all bodies, and axes of all solids.
#[inline(always)]
fn compute_positions<G: Turning>(plan: &Plan<G>, work: &Workspace<G>, state: &mut ContactState<G::Pack>) {
    state.is_seen.fill(false);
    for (curve, bound) in plan.effects.contacts.curves.iter().zip(&mut state.bounds) {
        let piece = &plan.pieces[curve.piece];
        let own = &mut state.samples[curve.first_sample..][..curve.samples.len()];
        let last = own.len() - 1;
        for (nodes, node) in own[1..last].chunks_mut(LANES).zip(piece.node_packs()) {
            for (lane, [position, _]) in nodes.iter_mut().enumerate() {
                *position = in_lane::<G>(plan.frame, &work.position[node], lane);
            }
        }
        for (i, station) in [(0, piece.joined.begin), (last, piece.joined.end)] {
            own[i][0] = G::in_space(plan.frame, work.stations[station].position);
        }
        let centre = own[own.len() / 2][0];
        let away =
            own.iter().map(|[position, _]| *position - centre).map(|way| way.dot(way)).fold(0.0, f64::max);
        let stretched = stretch_of(plan, work, curve);
        let around_samples = (centre, away.sqrt() + stretched * curve.largest_gap + curve.thickest);
        let around_ends = around_ends(plan, work, curve, stretched);
        *bound = if around_ends.1 < around_samples.1 { around_ends } else { around_samples };
    }
    for (ball, centre) in plan.effects.contacts.balls.iter().zip(&mut state.centres) {
        let Some(fixture) = ball.on else {
            *centre = ball.centre;
            continue;
        };
        let Some(point) = plan.effects.contacts.fixtures[fixture].point else {
            *centre = pose_of(plan, work, None).place(ball.centre);
            continue;
        };
        let point = &work.points[point];
        let beside = G::rotate(&point.rotation, G::vector_of(plan.frame, ball.centre));
        *centre = G::in_space(plan.frame, point.position + beside);
    }
    for body in &plan.effects.contacts.bodies {
        let pose = body.on.map_or_else(Pose::unmoved, |fixture| {
            pose_of(plan, work, plan.effects.contacts.fixtures[fixture].point)
        });
        let corners = &mut state.corners[body.first_corner..][..body.corners.len()];
        for (corner, own) in corners.iter_mut().zip(&body.corners) {
            *corner = pose.place(*own);
        }
    }
    for (fixed, pose) in plan.effects.contacts.solids.iter().zip(&mut state.poses) {
        if let Some(fixture) = fixed.on {
            *pose = pose_of(plan, work, plan.effects.contacts.fixtures[fixture].point);
        }
    }
}

/// Pose of the axes of a point; without a point, of the frame at rest, relative to the moving base.
fn pose_of<G: Turning>(plan: &Plan<G>, work: &Workspace<G>, point: Option<usize>) -> Pose {
    if let Some(point) = point {
        let point = &work.points[point];
        return Pose {
            rotation: G::rotation_in_space(plan.frame, &point.rotation),
            position: G::in_space(plan.frame, point.position),
        };
    }
    let (base, at_rest) = (&work.surroundings.base, &plan.world.base);
    let seen = |axis| base.rotation.apply_transposed(at_rest.rotation.axis(axis));
    let [position, _] = base.point_in_frame(Vector::zero(), at_rest);
    Pose { rotation: Rotation { x: seen(0), y: seen(1), z: seen(2) }, position }
}

/// One of the vectors that a pack holds, in space.
#[inline(always)]
fn in_lane<G: Turning>(frame: G::Frame, vectors: &G::Vector<G::Pack>, lane: usize) -> Vector<f64> {
    G::in_space(frame, G::map_vector(vectors, |pack: &G::Pack| pack.lane(lane)))
}

/// Computes the slopes of a curve at its samples, at its ends those at the adjacent nodes.
fn compute_slopes<G: Turning>(
    plan: &Plan<G>,
    curve: &Curve<G::Pack>,
    slopes: &[G::Vector<G::Pack>],
    samples: &mut [[Vector<f64>; 2]],
) {
    let piece = &plan.pieces[curve.piece];
    let own = &mut samples[curve.first_sample..][..curve.samples.len()];
    let last = own.len() - 1;
    for (nodes, node) in own[1..last].chunks_mut(LANES).zip(piece.node_packs()) {
        for (lane, [_, slope]) in nodes.iter_mut().enumerate() {
            *slope = in_lane::<G>(plan.frame, &slopes[node], lane) * curve.length;
        }
    }
    own[0][1] = own[1][1];
    own[last][1] = own[last - 1][1];
}

/// Computes the slopes of a curve at its samples, and the bounding volumes of its parts, once per state.
pub(super) fn compute_slopes_and_bounds<G: Turning>(
    plan: &Plan<G>,
    slopes: &[G::Vector<G::Pack>],
    state: &mut ContactState<G::Pack>,
    c: usize,
) {
    if std::mem::replace(&mut state.is_seen[c], true) {
        return;
    }
    let curve = &plan.effects.contacts.curves[c];
    compute_slopes(plan, curve, slopes, &mut state.samples);
    let own = &state.samples[curve.first_sample..][..curve.samples.len()];
    let last = own.len() - 1;
    let ends = [own[0][0], own[last][0]];
    let aside = own.iter().map(|[position, _]| distance::to_segment(*position, ends)).fold(0.0, f64::max);
    let spans = &mut state.spans[curve.first_sample..][..last];
    let mut widest: f64 = 0.0;
    for ((span, seen), samples) in spans.iter_mut().zip(own.windows(2)).zip(curve.samples.windows(2)) {
        let part = samples[1].x - samples[0].x;
        let ends = [0, 1].map(|i| [seen[i][0], seen[i][1] * part]);
        *span = curve::span(ends, samples[0].radius.max(samples[1].radius));
        widest = widest.max(span.width());
    }
    state.chords[c] = Span::new(ends, aside + widest);
}

/// Finds the curves of rods that may touch each other.
fn find_near<G: Turning>(plan: &Plan<G>, work: &Workspace<G>, state: &mut ContactState<G::Pack>) {
    let (mut near, mut near_of) = (std::mem::take(&mut state.near), std::mem::take(&mut state.near_of));
    broad_phase::enclose(&plan.effects.contacts, &state.bounds, &mut state.branches);
    near.clear();
    for (pair, of_pair) in plan.effects.contacts.pairs.iter().zip(&mut near_of) {
        let first = near.len();
        if let [Side::Rod(rod), Side::Rod(other)] = &pair.sides {
            let contacts = &plan.effects.contacts;
            broad_phase::gather(contacts, pair, [rod, other], &state.branches, &mut near);
            let mut kept = first;
            for i in first..near.len() {
                let [c, o] = near[i];
                compute_slopes_and_bounds(plan, &work.slope, state, c);
                compute_slopes_and_bounds(plan, &work.slope, state, o);
                let is_near = state.chords[c].may_overlap(&state.chords[o])
                    && (pair.neighbourhood == 0.0 || parts_are_near(plan, state, [c, o], pair.neighbourhood));
                if is_near {
                    near[kept] = [c, o];
                    kept += 1;
                }
            }
            near.truncate(kept);
            if rod == other {
                for i in first..kept {
                    let [c, o] = near[i];
                    if c != o {
                        near.push([o, c]);
                    }
                }
            }
            near[first..].sort_unstable();
        }
        *of_pair = first..near.len();
    }
    (state.near, state.near_of) = (near, near_of);
}

/// Whether parts of two curves of a rod that are not neighbours come within their radius of each other. The chords of adjacent curves
/// always meet.
fn parts_are_near<G: Turning>(
    plan: &Plan<G>,
    state: &ContactState<G::Pack>,
    [c, o]: [usize; 2],
    neighbourhood: f64,
) -> bool {
    let parts = |c: usize| {
        let curve = &plan.effects.contacts.curves[c];
        let spans = &state.spans[curve.first_sample..][..curve.samples.len() - 1];
        let radius = |index: usize| curve.samples[index].radius.max(curve.samples[index + 1].radius);
        spans.iter().enumerate().map(move |(index, span)| (span, curve.arcs(index), radius(index)))
    };
    parts(c).any(|(span, [from, to], radius)| {
        let around = span.widened(radius);
        around.may_overlap(&state.chords[o])
            && parts(o).any(|(other, [begin, end], _)| {
                !(begin < to + neighbourhood && end > from - neighbourhood) && around.may_overlap(other)
            })
    })
}

/// Marks the curves that may touch anything.
fn mark_candidates<G: Turning>(plan: &Plan<G>, work: &Workspace<G>, state: &mut ContactState<G::Pack>) {
    let ContactState { bounds, is_near, near, centres, poses, grown, .. } = state;
    is_near.fill(false);
    for &[c, o] in &*near {
        is_near[c] = true;
        is_near[o] = true;
    }
    for (pair, grown) in plan.effects.contacts.pairs.iter().zip(&*grown) {
        let Side::Rod(curves) = &pair.sides[0] else { continue };
        for c in curves.clone() {
            let (centre, radius) = (bounds[c].0, bounds[c].1 + grown);
            match &pair.sides[1] {
                Side::Solid(solid) => {
                    is_near[c] |= !placed(plan, poses, *solid).is_beyond(centre, radius);
                }
                Side::Ball(ball) => {
                    let reach = radius + plan.effects.contacts.balls[*ball].radius;
                    is_near[c] |= distance::between(centre, centres[*ball]) <= reach;
                }
                Side::Rod(_) | Side::Body(_) => {}
            }
        }
    }
    state.is_rigid_near = plan.effects.contacts.pairs.iter().any(|pair| is_rigid_near(plan, state, pair));
    for c in 0..state.is_near.len() {
        if state.is_near[c] {
            compute_slopes_and_bounds(plan, &work.slope, state, c);
        }
    }
}

/// Whether a pair's ball or body is close to the other side: within its own size, so that no increment of a step leads past.
fn is_rigid_near<G: Turning>(plan: &Plan<G>, state: &ContactState<G::Pack>, pair: &Pair) -> bool {
    let ContactState { bounds, centres, corners, poses, .. } = state;
    let contacts = &plan.effects.contacts;
    let around_ball = |ball: usize| (centres[ball], 2.0 * contacts.balls[ball].radius);
    let (centre, reach) = match &pair.sides[0] {
        Side::Ball(ball) => around_ball(*ball),
        Side::Body(body) => {
            let Body { first_corner, radius, size, .. } = contacts.bodies[*body];
            (corners[first_corner], 2.0 * (radius + size))
        }
        Side::Rod(_) | Side::Solid(_) => return false,
    };
    let is_in_reach =
        |(other, radius): (Vector<f64>, f64)| distance::between(centre, other) <= reach + radius;
    match &pair.sides[1] {
        Side::Solid(solid) => !placed(plan, poses, *solid).is_beyond(centre, reach),
        Side::Ball(ball) => is_in_reach(around_ball(*ball)),
        Side::Rod(curves) => bounds[curves.clone()].iter().copied().any(is_in_reach),
        Side::Body(_) => true,
    }
}
