//! Queries about contacts: contact points, forces, and whether steps resolve impacts.

use std::f64::consts::PI;

use crate::model::{REACHED, STEPS_OF_AN_IMPACT, Separation};
use crate::numerics::lie::{Cross, Symmetric, Twist, Vector};
use crate::robot::effects::contact::narrow_phase;
use crate::robot::effects::contact::plan::{Body, Side};
use crate::robot::effects::contact::shapes::touch::{ContactPoint, Law};
use crate::robot::effects::contact::state::{ContactState, SidePlace, Touch};
use crate::robot::plan::Plan;
use crate::robot::state::Workspace;
use crate::robot::turning::Turning;

/// Largest `(omega h)^2` at which a step of size h resolves an impact: the impact takes at least three steps.
const RESOLVED_IMPACT: f64 = 1.5;
const MOST_LOST: f64 = 0.7;

/// Above this `(omega h)^2`, an impact takes fewer than ten steps, in which a ball loses at least two hundredths of its energy.
const COARSE_IMPACT: f64 = (PI / 10.0) * (PI / 10.0);

/// Above this product of dissipation and speed, dissipation decides how long an impact takes: less than a tenth of the energy returns.
const STRONG_DISSIPATION: f64 = 3.0;

/// Surfaces rest on each other if their distance changes in a step by less than this part of their overlap.
const AT_REST: f64 = 1e-2;

/// The overlap beyond which surfaces are sunk into each other: a radius.
pub(crate) fn largest_valid_overlap(touch: &Touch) -> f64 {
    let (first, [_, second]) = (touch.contact_point.thickness, touch.contact_point.radii);
    if second > 0.0 { first.min(second) } else { first }
}

/// The contact whose surfaces overlap most of those that overlap by more than a radius, and the overlap.
pub(crate) fn deep_penetration<G: Turning>(plan: &Plan<G>, work: &Workspace<G>) -> Option<(usize, f64)> {
    let is_sunk = |touch: &&Touch| touch.contact_point.overlap > largest_valid_overlap(touch);
    let sunk = work.effects.contact.touches.iter().filter(is_sunk);
    let deepest = sunk.max_by(|a, b| a.contact_point.overlap.total_cmp(&b.contact_point.overlap));
    if let Some(touch) = deepest {
        return Some((plan.effects.contacts.pairs[touch.pair].contact, touch.contact_point.overlap));
    }
    // Bodies that penetrate each other up to their middles need not have contact points at corners or edges.
    plan.effects.contacts.pairs.iter().find_map(|pair| {
        let [Side::Body(body), Side::Solid(solid)] = pair.sides else { return None };
        let Body { first_corner, corners, thickness, .. } = &plan.effects.contacts.bodies[body];
        let mut middle = Vector::zero();
        for &corner in &work.effects.contact.corners[*first_corner..][..corners.len()] {
            middle += corner * (corners.len() as f64).recip();
        }
        let solid = narrow_phase::placed(plan, &work.effects.contact.poses, solid);
        if solid.is_certainly_beyond(middle, 0.0) {
            return None;
        }
        let depth = -solid.distance(middle).value;
        (depth > 0.0).then_some((pair.contact, thickness + depth))
    })
}

/// The pairs of surfaces that only just touch, at all their contact points. `length` is that of the robot.
pub(crate) fn reached<G: Turning>(plan: &Plan<G>, work: &Workspace<G>, length: f64) -> Vec<usize> {
    let size = |vector: Vector<f64>| vector.dot(vector).sqrt();
    let far = length + size(plan.world.base.position);
    let is_just_touched = |touch: &Touch| {
        let [first, second] = touch.centres.map(size);
        let span = far + first + second + touch.contact_point.radii.iter().sum::<f64>();
        touch.contact_point.overlap <= REACHED * span
    };
    let touches = &work.effects.contact.touches;
    let mut pairs: Vec<usize> = touches.iter().map(|touch| touch.pair).collect();
    pairs.dedup();
    pairs.retain(|&p| touches.iter().filter(|touch| touch.pair == p).all(is_just_touched));
    pairs
}

/// Energy of the overlaps.
pub(crate) fn overlap_energy<G: Turning>(work: &Workspace<G>) -> f64 {
    work.effects.contact.touches.iter().map(|touch| touch.contact_point.energy(&touch.contact_force)).sum()
}

/// Stores the rates of the distances at all contact points, with the motion up to date.
pub(crate) fn store_rates<G: Turning>(work: &mut Workspace<G>) {
    let ContactState { touches, rates, .. } = &mut work.effects.contact;
    rates.clear();
    rates.extend(touches.iter().map(|touch| touch.contact_force.rate));
}

/// Whether a step of size `h` is too long to resolve its impacts, with the motion at its end up to date, and the stored rates of
/// distances for the velocities at its start ([`store_rates`]).
///
/// Surfaces that have met within the step, according to both rates, must not have lost much of their speed, nor must those that
/// dissipation slows down (`c v > 1`). For all others, the stiffness over the mass follows from the overlap d and the acceleration a with
/// which they separate, `omega^2 = a / d`; the impact takes `pi / omega`.
pub(crate) fn has_unresolved_impact<G: Turning>(plan: &Plan<G>, work: &Workspace<G>, h: f64) -> bool {
    let touches = work.effects.contact.touches.iter().zip(&work.effects.contact.rates);
    touches.enumerate().any(|(t, (touch, &before))| {
        let (overlap, after) = (touch.contact_point.overlap, touch.contact_force.rate);
        let has_met = overlap + 0.5 * h * (before + after) < 0.0;
        let is_dissipated = -touch.contact_point.law.dissipation * before > 1.0;
        (has_met || is_dissipated) && after - before > MOST_LOST * before.abs()
            || h * h * opening(plan, work, t)
                > RESOLVED_IMPACT * overlap * touch.contact_force.stiffening().max(1.0)
    })
}

/// Whether distances of touching surfaces change in a step of size `h` by more than at rest ([`AT_REST`]), with the motion up to date.
pub(crate) fn may_separate<G: Turning>(work: &Workspace<G>, h: f64) -> bool {
    let moves = |touch: &Touch| h * touch.contact_force.rate.abs() > AT_REST * touch.contact_point.overlap;
    work.effects.contact.touches.iter().any(moves)
}

/// Stores the accelerations with which touching surfaces separate without contact forces. The motion must be up to date.
pub(crate) fn store_openings<G: Turning>(plan: &Plan<G>, work: &mut Workspace<G>) {
    let mut openings = std::mem::take(&mut work.effects.contact.openings);
    openings.clear();
    openings.extend((0..work.effects.contact.touches.len()).map(|t| opening(plan, work, t)));
    work.effects.contact.stiffnesses.clear();
    work.effects.contact.stiffnesses.resize(openings.len(), (0.0, false));
    work.effects.contact.openings = openings;
}

/// Stores the stiffness over the effective mass at the contact points of this pair, or of all pairs, if it is larger than the stored one. The
/// motion must be up to date with the forces of this pair alone, or of all pairs; the stored accelerations are those without contact forces.
pub(crate) fn store_stiffnesses<G: Turning>(plan: &Plan<G>, work: &mut Workspace<G>, pair: Option<usize>) {
    let mut stiffnesses = std::mem::take(&mut work.effects.contact.stiffnesses);
    let ContactState { touches, openings, .. } = &work.effects.contact;
    let stored = stiffnesses.iter_mut().zip(openings);
    for (t, (touch, (stiffness, unpushed))) in touches.iter().zip(stored).enumerate() {
        if pair.is_some_and(|pair| pair != touch.pair) {
            continue;
        }
        let pressed = touch.contact_point.overlap * touch.contact_force.stiffening();
        let found = (opening(plan, work, t) - unpushed) / pressed;
        if found > stiffness.0 {
            *stiffness = (found, pair.is_some());
        }
    }
    work.effects.contact.stiffnesses = stiffnesses;
}

/// Pairs whose impacts take at least ten steps of size `h` according to the stored stiffness, if several pairs touch.
pub(crate) fn between_others<G: Turning>(work: &Workspace<G>, h: f64) -> Vec<usize> {
    let ContactState { touches, stiffnesses, .. } = &work.effects.contact;
    if touches.iter().all(|touch| touch.pair == touches[0].pair) {
        return Vec::new();
    }
    let fine = touches.iter().zip(stiffnesses).filter(|(_, stiffness)| h * h * stiffness.0 <= COARSE_IMPACT);
    let mut pairs: Vec<usize> = fine.map(|(touch, _)| touch.pair).collect();
    pairs.dedup();
    pairs
}

/// How surfaces separate whose impacts take less than ten steps of size `h`. The motion at the end of a step must be up to date. Stored are
/// the rates of distances at its start, the time `since` earlier, the accelerations with which surfaces separate without contact forces,
/// and the stiffness over the effective mass: of a pair between others, that of the pair alone.
///
/// The overlap d of a single pair that an acceleration a presses together obeys `d'' = a - omega^2 d`: the pair separates with the speed
/// u, `u^2 = d'^2 + (omega^2 d - 2 a) d`, and meets again after `2 u / a`. All quantities are relative motions of the pair. For rods,
/// `by_weight`, a is that of the weight alone: the forces of waves along a compressed rod last no longer than these. Dissipation
/// c of more than `STRONG_DISSIPATION / u` takes the speed within `1 / (omega sqrt(c u))`, for which an impact counts as that much stiffer.
pub(crate) fn separation<G: Turning>(
    plan: &Plan<G>,
    work: &Workspace<G>,
    since: f64,
    h: f64,
    by_weight: bool,
) -> Separation {
    let contact = &work.effects.contact;
    let cached = contact.rates.iter().zip(contact.openings.iter().zip(&contact.stiffnesses));
    let mut found = Separation::default();
    for (touch, (&before, (&unpushed, &(stiffness, is_held)))) in contact.touches.iter().zip(cached) {
        let overlap = touch.contact_point.overlap;
        let contact_force = if by_weight { acceleration_by_weight(plan, work, touch) } else { -unpushed };
        let began = (overlap + 0.5 * since * (before + touch.contact_force.rate)).max(0.0);
        // Other surfaces may prevent the release of energy that is stored between several pairs.
        let stored = if is_held { 0.0 } else { (stiffness * began - 2.0 * contact_force) * began };
        let square = before * before + stored;
        let speed = square.max(0.0).sqrt();
        let dissipated = touch.contact_point.law.dissipation * speed;
        let stiffness = if dissipated > STRONG_DISSIPATION { stiffness * dissipated } else { stiffness };
        let is_coarse = h * h * stiffness > COARSE_IMPACT;
        if !is_coarse || speed == 0.0 || before > 0.0 && began == 0.0 {
            continue;
        }
        let leaving = speed * rebound(dissipated);
        if leaving * h > REACHED * plan.effects.contacts.pairs[touch.pair].thickness {
            let (flight, impact) = (2.0 * leaving / (contact_force.max(0.0) * h), PI / stiffness.sqrt());
            found = found.and(Separation { flight, impact, speed: leaving });
        }
    }
    found
}

/// The acceleration with which the weight alone presses the surfaces at a contact point together.
fn acceleration_by_weight<G: Turning>(plan: &Plan<G>, work: &Workspace<G>, touch: &Touch) -> f64 {
    let falls = |side: &SidePlace| match *side {
        SidePlace::AtRest => false,
        SidePlace::On(fixture) => plan.effects.contacts.fixtures[fixture].point.is_some(),
        SidePlace::Along { .. } => true,
    };
    let [first, second] = touch.sides.each_ref().map(|side| f64::from(u8::from(falls(side))));
    let gravity = G::in_space(plan.frame, work.surroundings.gravity);
    touch.contact_point.normal.dot(gravity) * (second - first)
}

/// The acceleration with which the surfaces at a contact point separate.
fn opening<G: Turning>(plan: &Plan<G>, work: &Workspace<G>, t: usize) -> f64 {
    let [first, second] = [0, 1].map(|side| acceleration(plan, work, t, side));
    work.effects.contact.touches[t].contact_point.normal.dot(first - second)
}

/// The hardest of the impacts in a step.
pub(crate) struct FastestImpact {
    /// Index of the contact in the robot.
    pub(crate) contact: usize,
    /// Speed of the rebound over that of the approach.
    pub(crate) rebound: f64,
    /// Size of steps that resolve it, in seconds.
    pub(crate) longest: f64,
}

/// The impact with the highest speed of approach; motion and stored rates are as for [`has_unresolved_impact`].
pub(crate) fn fastest_impact<G: Turning>(plan: &Plan<G>, work: &Workspace<G>) -> Option<FastestImpact> {
    let touches = work.effects.contact.touches.iter().zip(&work.effects.contact.rates).enumerate();
    let (t, (touch, &before)) = touches.clone().min_by(|(_, (_, a)), (_, (_, b))| a.total_cmp(b))?;
    if before >= 0.0 {
        return None;
    }
    let square = |t: usize, touch: &Touch| {
        let opening = opening(plan, work, t);
        (opening > 0.0).then(|| touch.contact_point.overlap * touch.contact_force.stiffening() / opening)
    };
    // Surfaces that are stopped between others need not separate.
    let is_stopped = touch.contact_force.rate - before > MOST_LOST * before.abs();
    let of_others = || touches.filter_map(|(t, (touch, _))| square(t, touch)).reduce(f64::min);
    let square = square(t, touch).or_else(|| if is_stopped { of_others() } else { None })?;
    let Law { dissipation, .. } = touch.contact_point.law;
    Some(FastestImpact {
        contact: plan.effects.contacts.pairs[touch.pair].contact,
        rebound: rebound(-dissipation * before),
        longest: PI / STEPS_OF_AN_IMPACT * square.sqrt(),
    })
}

/// Speed of the rebound over that of the approach, by the product of the latter and the dissipation.
///
/// From `m x'' = -k x (1 + c x')` in the overlap x: `int u / (1 + c u) du` over the speed u is the same before and after (Hunt and
/// Crossley 1975).
fn rebound(approach: f64) -> f64 {
    const HALVINGS: usize = 40;
    if approach <= 0.0 {
        return 1.0;
    }
    let before = approach - approach.ln_1p();
    let (mut slow, mut fast) = (0.0, approach.min(1.0));
    for _ in 0..HALVINGS {
        let middle = 0.5 * (slow + fast);
        if -middle - (-middle).ln_1p() < before {
            slow = middle;
        } else {
            fast = middle;
        }
    }
    slow / approach
}

/// Acceleration of the centre of a side of a contact point, in the frame of the plan (see `kernel::acceleration`).
fn acceleration<G: Turning>(plan: &Plan<G>, work: &Workspace<G>, t: usize, side: usize) -> Vector<f64> {
    let touch = &work.effects.contact.touches[t];
    let (velocity, acceleration) = match touch.sides[side] {
        SidePlace::AtRest => return Vector::zero(),
        SidePlace::On(fixture) => {
            // The frame is inertial: bodies at rest in the world have no acceleration in it.
            let Some(point) = plan.effects.contacts.fixtures[fixture].point else { return Vector::zero() };
            (work.points[point].velocity, work.points[point].acceleration)
        }
        SidePlace::Along { curve, .. } => {
            let piece = &plan.pieces[plan.effects.contacts.curves[curve].piece];
            let begin = &work.stations[piece.joined.begin];
            let reach = work.effects.contact.reach(plan.effects.contacts.packs, t, side);
            let reach = reach.iter().zip(piece.node_packs());
            let (mut velocity, mut acceleration) = (Twist::zero(), Twist::zero());
            for (&weight, node) in reach {
                velocity += work.rate[node] * weight;
                acceleration += work.acceleration_rate[node] * weight;
            }
            (begin.velocity + velocity.sum(), begin.acceleration + acceleration.sum())
        }
    };
    let centre = G::vector_of(plan.frame, touch.centres[side]);
    let of_centre = velocity.linear + velocity.angular.cross(centre);
    let gravity = work.surroundings.gravity;
    let linear = acceleration.linear
        + gravity
        + acceleration.angular.cross(centre)
        + velocity.angular.cross(of_centre);
    G::in_space(plan.frame, linear)
}

/// A contact point in the robot's own order of surfaces, in the world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ReportedTouch {
    /// Index of the contact in the robot.
    pub contact: usize,
    /// On the first surface, metres.
    pub position: Vector<f64>,
    /// From the second surface to the first.
    pub normal: Vector<f64>,
    /// On the first surface, newtons, friction included.
    pub force: Vector<f64>,
    /// Metres.
    pub overlap: f64,
    /// Overlap over the thickness of the thinner surface.
    pub share: f64,
    /// Velocity of the first surface along the second, m/s.
    pub sliding: Vector<f64>,
    /// Arc lengths along both surfaces if they are rods, metres.
    pub along: [Option<f64>; 2],
    /// Whether an edge or corner of the other surface touches, not a face.
    pub is_at_edge: bool,
}

/// Rotation of the normal, in radians per displacement by the radius, from which a contact point counts as on an edge: more than one at a
/// sharp edge, zero on a face.
const TURNS_AT_EDGE: f64 = 0.5;

/// Whether a side of a pair is a box or mesh that touches with an edge or corner.
fn is_at_edge<G: Turning>(plan: &Plan<G>, side: &Side, contact_point: &ContactPoint) -> bool {
    let &Side::Solid(solid) = side else { return false };
    let has_faces = plan.effects.contacts.solids[solid].solid.has_faces();
    let Symmetric { xx, yy, zz, .. } = contact_point.curvature;
    has_faces && (xx + yy + zz) * contact_point.radii[0] > TURNS_AT_EDGE
}

/// The contact points found last, in the robot's own order of surfaces, in the world.
pub(crate) fn reported<G: Turning>(
    plan: &Plan<G>,
    work: &Workspace<G>,
) -> impl Iterator<Item = ReportedTouch> {
    let base = &work.surroundings.base;
    work.effects.contact.touches.iter().map(move |touch| {
        let pair = &plan.effects.contacts.pairs[touch.pair];
        let (first, sign) = if pair.is_turned { (1, -1.0) } else { (0, 1.0) };
        let [[_, force], _] = touch.contact_point.wrenches(&touch.contact_force);
        let turned = |v: Vector<f64>| base.rotation.apply(v);
        let position = touch.centres[first] + touch.contact_point.arms()[first];
        let along = |s: usize| match touch.sides[s] {
            SidePlace::Along { curve, x } => {
                let curve = &plan.effects.contacts.curves[curve];
                Some(curve.start + x * curve.length)
            }
            _ => None,
        };
        ReportedTouch {
            contact: pair.contact,
            position: base.position + turned(position),
            normal: turned(touch.contact_point.normal * sign),
            force: turned(force * sign),
            overlap: touch.contact_point.overlap,
            share: touch.contact_point.overlap / pair.thickness,
            sliding: turned(touch.contact_force.sliding * sign),
            along: [along(first), along(1 - first)],
            is_at_edge: pair.sides.iter().any(|side| is_at_edge(plan, side, &touch.contact_point)),
        }
    })
}
