//! Reports about contacts: places, forces, and whether steps resolve them.

use std::f64::consts::PI;

use crate::model::{Parting, REACHED};
use crate::numerics::lie::{Cross, Symmetric, Twist, Vector};
use crate::robot::effects::contact::narrow_phase;
use crate::robot::effects::contact::plan::{Body, Side};
use crate::robot::effects::contact::shapes::touch::{ContactPoint, Law};
use crate::robot::effects::contact::state::{ContactState, Standing, Touch};
use crate::robot::plan::Plan;
use crate::robot::state::Workspace;
use crate::robot::turning::Turning;

/// Impacts of up to that many radians of `omega h`, squared, a step are resolved: they take three steps or more, and the first
/// one takes no more than that part of the speed.
const UNRESOLVED: f64 = 1.5;
const MOST_LOST: f64 = 0.7;

/// Impacts of more than that many radians a step, squared, take less than ten steps: with fewer a ball loses two hundredths of its
/// energy, or more.
const COARSE: f64 = (PI / 10.0) * (PI / 10.0);

/// Surfaces that come nearer, or part, in a step by less than this part of their overlap rest on each other.
const AT_REST: f64 = 1e-2;

/// A contact whose surfaces overlap by more than the radius of one, and by how much.
pub(crate) fn deep_penetration<G: Turning>(plan: &Plan<G>, work: &Workspace<G>) -> Option<(usize, f64)> {
    let is_sunk = |touch: &&Touch| {
        let (first, [_, second]) = (touch.contact_point.thickness, touch.contact_point.radii);
        let smallest = if second > 0.0 { first.min(second) } else { first };
        touch.contact_point.overlap > smallest
    };
    if let Some(touch) = work.effects.contact.touches.iter().find(is_sunk) {
        return Some((plan.effects.contacts.pairs[touch.pair].contact, touch.contact_point.overlap));
    }
    // Bodies that are in each other up to their middles need not touch with a corner or an edge.
    plan.effects.contacts.pairs.iter().find_map(|pair| {
        let [Side::Body(body), Side::Solid(solid)] = pair.sides else { return None };
        let Body { first_corner, corners, thickness, .. } = &plan.effects.contacts.bodies[body];
        let mut middle = Vector::zero();
        for &corner in &work.effects.contact.corners[*first_corner..][..corners.len()] {
            middle += corner * (corners.len() as f64).recip();
        }
        let depth = -narrow_phase::placed(plan, &work.effects.contact.poses, solid).distance(middle).value;
        (depth > 0.0).then_some((pair.contact, thickness + depth))
    })
}

/// The pairs that touch, and overlap everywhere by so little that they only just do. `length` is that of the robot.
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

/// Takes down how fast the surfaces that touch approach each other, the motion up to date.
pub(crate) fn note_rates<G: Turning>(work: &mut Workspace<G>) {
    let ContactState { touches, rates, .. } = &mut work.effects.contact;
    rates.clear();
    rates.extend(touches.iter().map(|touch| touch.contact_force.rate));
}

/// Whether a step of size `h` is too long for how surfaces meet, or push each other apart, the motion at its end up to date; cached are
/// the rates of their distances with the velocities at its beginning.
///
/// Surfaces that have met within the step, which two rates tell, must not have lost much of their speed. All have a stiffness
/// over the mass that their overlap d and the acceleration a with which it opens tell of, `omega^2 = a / d`; their
/// impact takes `pi / omega`.
pub(crate) fn is_jolted<G: Turning>(plan: &Plan<G>, work: &Workspace<G>, h: f64) -> bool {
    let touches = work.effects.contact.touches.iter().zip(&work.effects.contact.rates);
    touches.enumerate().any(|(t, (touch, &before))| {
        let (overlap, after) = (touch.contact_point.overlap, touch.contact_force.rate);
        let has_met = overlap + 0.5 * h * (before + after) < 0.0;
        has_met && after - before > MOST_LOST * before.abs()
            || h * h * opening(plan, work, t)
                > UNRESOLVED * overlap * touch.contact_force.stiffening().max(1.0)
    })
}

/// Whether surfaces that touch, the motion up to date, approach each other, or part, in a step of size `h` by more than those that rest.
pub(crate) fn may_part<G: Turning>(work: &Workspace<G>, h: f64) -> bool {
    let moves = |touch: &Touch| h * touch.contact_force.rate.abs() > AT_REST * touch.contact_point.overlap;
    work.effects.contact.touches.iter().any(moves)
}

/// Takes down with which accelerations surfaces that touch open without contact forces, the motion up to date.
pub(crate) fn note_openings<G: Turning>(plan: &Plan<G>, work: &mut Workspace<G>) {
    let mut openings = std::mem::take(&mut work.effects.contact.openings);
    openings.clear();
    openings.extend((0..work.effects.contact.touches.len()).map(|t| opening(plan, work, t)));
    work.effects.contact.stiffnesses.clear();
    work.effects.contact.stiffnesses.resize(openings.len(), (0.0, false));
    work.effects.contact.openings = openings;
}

/// Takes down how stiff the places where this pair touches, or all pairs, are over the mass that takes part, if they are stiffer than known so
/// far. The motion is up to date, with the forces of this pair alone, or of all; noted are the openings without any.
pub(crate) fn note_stiffnesses<G: Turning>(plan: &Plan<G>, work: &mut Workspace<G>, pair: Option<usize>) {
    let mut stiffnesses = std::mem::take(&mut work.effects.contact.stiffnesses);
    let ContactState { touches, openings, .. } = &work.effects.contact;
    let noted = stiffnesses.iter_mut().zip(openings);
    for (t, (touch, (stiffness, unpushed))) in touches.iter().zip(noted).enumerate() {
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

/// Pairs that touch where others do, too, and whose impacts would take ten steps of size `h`, or more, by the stiffness known so far.
pub(crate) fn between_others<G: Turning>(work: &Workspace<G>, h: f64) -> Vec<usize> {
    let ContactState { touches, stiffnesses, .. } = &work.effects.contact;
    if touches.iter().all(|touch| touch.pair == touches[0].pair) {
        return Vec::new();
    }
    let fine = touches.iter().zip(stiffnesses).filter(|(_, stiffness)| h * h * stiffness.0 <= COARSE);
    let mut pairs: Vec<usize> = fine.map(|(touch, _)| touch.pair).collect();
    pairs.dedup();
    pairs
}

/// How surfaces part again, of those whose impacts take less than ten steps of size `h`. The motion at the end of a step is up to
/// date; cached are the rates of their distances at its beginning, the time `since` ago, the
/// accelerations with which they open without contact forces, and their stiffness over the mass that takes part: of a pair between others that of the
/// pair alone.
///
/// A pair alone obeys `d'' = a - omega^2 d` in its overlap d, if a presses it together: it leaves with the speed u of
/// `u^2 = d'^2 + (omega^2 d - 2 a) d`, and comes back after `2 u / a`. That is told by what takes part, in any frame. Where rods bend, `by_weight`,
/// a is that of the weight: what a compressed rod does to its end lasts no longer than its waves.
pub(crate) fn parting<G: Turning>(
    plan: &Plan<G>,
    work: &Workspace<G>,
    since: f64,
    h: f64,
    by_weight: bool,
) -> Parting {
    let contact = &work.effects.contact;
    let cached = contact.rates.iter().zip(contact.openings.iter().zip(&contact.stiffnesses));
    let mut found = Parting::default();
    for (touch, (&before, (&unpushed, &(stiffness, is_held)))) in contact.touches.iter().zip(cached) {
        let overlap = touch.contact_point.overlap;
        let is_coarse = h * h * stiffness > COARSE;
        let contact_force = if by_weight { pressing_weight(plan, work, touch) } else { -unpushed };
        let began = (overlap + 0.5 * since * (before + touch.contact_force.rate)).max(0.0);
        // What is stored between others may be held by these.
        let stored = if is_held { 0.0 } else { (stiffness * began - 2.0 * contact_force) * began };
        let square = before * before + stored;
        if !is_coarse || square <= 0.0 || before > 0.0 && began == 0.0 {
            continue;
        }
        let speed = square.sqrt();
        let leaving = speed * rebound(touch.contact_point.law.dissipation * speed);
        if leaving * h > REACHED * plan.effects.contacts.pairs[touch.pair].thickness {
            let (flight, impact) = (2.0 * leaving / (contact_force.max(0.0) * h), PI / stiffness.sqrt());
            found = found.and(Parting { flight, impact, speed: leaving });
        }
    }
    found
}

/// The acceleration with which the weight alone presses the surfaces of a touch together.
fn pressing_weight<G: Turning>(plan: &Plan<G>, work: &Workspace<G>, touch: &Touch) -> f64 {
    let falls = |side: &Standing| match *side {
        Standing::Still => false,
        Standing::On(fixture) => plan.effects.contacts.fixtures[fixture].point.is_some(),
        Standing::Along { .. } => true,
    };
    let [first, second] = touch.sides.each_ref().map(|side| f64::from(u8::from(falls(side))));
    let gravity = G::in_space(plan.frame, work.surroundings.gravity);
    touch.contact_point.normal.dot(gravity) * (second - first)
}

/// The acceleration with which the surfaces of a touch open.
fn opening<G: Turning>(plan: &Plan<G>, work: &Workspace<G>, t: usize) -> f64 {
    let [first, second] = [0, 1].map(|side| acceleration(plan, work, t, side));
    work.effects.contact.touches[t].contact_point.normal.dot(first - second)
}

/// The hardest of the impacts in a step.
pub(crate) struct Hardest {
    /// The contact, by its place among those of the robot.
    pub(crate) contact: usize,
    /// Speed of the rebound over that of the approach.
    pub(crate) rebound: f64,
    /// Size of steps that resolve it, in seconds.
    pub(crate) longest: f64,
}

/// The impact of the surfaces that have approached each other fastest; its motion and rates are as for [`resolution`].
pub(crate) fn hardest_impact<G: Turning>(plan: &Plan<G>, work: &Workspace<G>) -> Option<Hardest> {
    /// Steps of an impact, which takes `pi / omega`: they give back more than nine tenths of its energy.
    const STEPS: f64 = 20.0;
    let touches = work.effects.contact.touches.iter().zip(&work.effects.contact.rates).enumerate();
    let (t, (touch, &before)) = touches.clone().min_by(|(_, (_, a)), (_, (_, b))| a.total_cmp(b))?;
    if before >= 0.0 {
        return None;
    }
    let square = |t: usize, touch: &Touch| {
        let opening = opening(plan, work, t);
        (opening > 0.0).then(|| touch.contact_point.overlap * touch.contact_force.stiffening() / opening)
    };
    // Those that are stopped between others need not open.
    let is_stopped = touch.contact_force.rate - before > MOST_LOST * before.abs();
    let of_others = || touches.filter_map(|(t, (touch, _))| square(t, touch)).reduce(f64::min);
    let square = square(t, touch).or_else(|| if is_stopped { of_others() } else { None })?;
    let Law { dissipation, .. } = touch.contact_point.law;
    Some(Hardest {
        contact: plan.effects.contacts.pairs[touch.pair].contact,
        rebound: rebound(-dissipation * before),
        longest: PI / STEPS * square.sqrt(),
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

/// How the centre of a side of a touch accelerates, in the frame of the plan (see `kernel::acceleration`).
fn acceleration<G: Turning>(plan: &Plan<G>, work: &Workspace<G>, t: usize, side: usize) -> Vector<f64> {
    let touch = &work.effects.contact.touches[t];
    let (velocity, acceleration) = match touch.sides[side] {
        Standing::Still => return Vector::zero(),
        Standing::On(fixture) => {
            // The frame is inertial: what rests in the world is not accelerated in it.
            let Some(point) = plan.effects.contacts.fixtures[fixture].point else { return Vector::zero() };
            (work.points[point].velocity, work.points[point].acceleration)
        }
        Standing::Along { curve, .. } => {
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

/// A place where two surfaces touch, as a robot tells it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ReportedTouch {
    /// The contact, by its place among those of the robot.
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
    /// Arc lengths of the rods of both surfaces, metres; of what is no rod there is none.
    pub along: [Option<f64>; 2],
    /// Whether an edge or corner of the other surface touches, not a face.
    pub is_at_edge: bool,
}

/// A normal that turns this much while the place of the touch moves by the radius, in radians, is that of an edge: of a sharp one it
/// turns by more than one, on a face by nothing.
const TURNS_AT_EDGE: f64 = 0.5;

/// Whether a side of a pair is a box or mesh that touches with an edge or corner.
fn is_at_edge<G: Turning>(plan: &Plan<G>, side: &Side, contact_point: &ContactPoint) -> bool {
    let &Side::Solid(solid) = side else { return false };
    let has_faces = plan.effects.contacts.solids[solid].solid.has_faces();
    let Symmetric { xx, yy, zz, .. } = contact_point.curvature;
    has_faces && (xx + yy + zz) * contact_point.radii[0] > TURNS_AT_EDGE
}

/// The touches that have been found, as a robot tells them: in its own order of surfaces, in the world.
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
            Standing::Along { curve, x } => {
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
