//! Contact forces between overlapping surfaces, at places that depend on the motion.
//!
//! Such a place along a rod is treated like a point (see `kernel::points`): node l carries the share
//! `u_l / w_l` of the wrench. The tangent is computed entirely in [`Effect::stiffen`]: let `W` be the wrench
//! that a side requires about its centre, and y the rotation of the side; then the wrench changes by `dW`
//! and, relative to the material, by `-(m x y; f x y)` as a wrench with a fixed direction.

mod curve;
pub(crate) mod find;
mod follow;
mod intervals;
mod near;
pub(crate) mod passing;
pub(crate) mod told;

use super::Effect;
use crate::lie::{LANES, Lanes, Sweep, Twist, Vector, Wrench};
use crate::linalg::Matrix;
use crate::model::Energy;
use crate::robot::algebra::tie::Motion;
use crate::robot::plan::Plan;
use crate::robot::plan::piece::PiecePlan;
use crate::robot::state::Workspace;
use crate::robot::state::contact::{ContactState, ContactTangent, Standing, Touch};
use crate::robot::state::tangent::{Tangent, TangentWorkspace, Weights};
use crate::robot::turning::{Turning, columns};

/// What touches of a plan.
pub(crate) struct Touching;

/// What the two sides of a touch need against it, about the origin.
fn needs<G: Turning>(plan: &Plan<G>, touch: &Touch) -> [Wrench<G, f64>; 2] {
    let wrenches = touch.meeting.wrenches(&touch.pressing);
    std::array::from_fn(|s| {
        let [moment, force] = wrenches[s];
        let moment = moment + touch.centres[s].cross(force);
        Wrench { moment: G::axial_of(plan.frame, -moment), force: G::vector_of(plan.frame, -force) }
    })
}

/// Adds what the places along a piece where it is touched need to the internal wrench at its nodes; returns their sum.
#[inline(always)]
pub(crate) fn carry<G: Turning>(
    plan: &Plan<G>,
    piece: &PiecePlan<G>,
    work: &mut Workspace<G>,
) -> Wrench<G, f64> {
    let mut sum = Wrench::zero();
    if work.contact.touches.is_empty() {
        return sum;
    }
    let Workspace { contact, internal, .. } = work;
    for (t, touch) in contact.touches.iter().enumerate() {
        for (s, standing) in touch.sides.iter().enumerate() {
            let Standing::Along { curve, .. } = *standing else { continue };
            let curve = &plan.contacts.curves[curve];
            if plan.pieces[curve.piece].first_pack != piece.first_pack {
                continue;
            }
            let need = needs(plan, touch)[s];
            sum += need;
            let need = need.splat();
            let shares = contact.reach(plan.contacts.packs, t, s).iter().zip(&curve.inverse_weights);
            for (internal, (&up_to, &inverse_weight)) in internal[piece.node_packs()].iter_mut().zip(shares) {
                *internal += need * (up_to * inverse_weight);
            }
        }
    }
    sum
}

impl<G: Turning> Effect<G> for Touching {
    #[inline(always)]
    fn prepare(plan: &Plan<G>, work: &mut Workspace<G>, _: &[f64], _: &[f64]) {
        if plan.contacts.pairs.is_empty() {
            return;
        }
        if work.contact.is_left {
            work.contact.touches.clear();
            return;
        }
        find::find(plan, work);
        for touch in &work.contact.touches {
            for (standing, need) in touch.sides.iter().zip(needs(plan, touch)) {
                if let Standing::On(fixture) = *standing
                    && let Some(point) = plan.contacts.fixtures[fixture].point
                {
                    work.points[point].force += need;
                }
            }
        }
    }

    #[inline(always)]
    fn stiffen(
        plan: &Plan<G>,
        work: &Workspace<G>,
        memory: &mut TangentWorkspace<G>,
        weights: Weights,
        tangent: &mut Tangent<'_>,
    ) {
        // What couples branches is solved with all entries.
        let Tangent::Dense(matrix) = tangent else { return };
        if weights.is_mass_only {
            return;
        }
        follow::follow(&work.contact.touches, &mut memory.contact.followed);
        for touch in 0..work.contact.touches.len() {
            let sweep = Stiffen { plan, work, memory: &mut memory.contact, weights, matrix, touch };
            plan.instructions.run_apart::<G::Pack, _>(sweep);
        }
    }

    fn dissipates(plan: &Plan<G>) -> bool {
        plan.contacts.pairs.iter().any(|pair| pair.law.dissipation > 0.0 || pair.law.friction != [0.0; 3])
    }

    fn may_dissipate(plan: &Plan<G>, work: &Workspace<G>) -> bool {
        <Self as Effect<G>>::dissipates(plan) && may_touch(&work.contact)
    }

    fn add_energy(_: &Plan<G>, work: &Workspace<G>, energy: &mut Energy) {
        let touches = work.contact.touches.iter();
        energy.elastic += touches.map(|touch| touch.meeting.energy(&touch.pressing)).sum::<f64>();
    }

    fn dissipated_power(_: &Plan<G>, work: &Workspace<G>) -> f64 {
        work.contact.touches.iter().map(|touch| touch.pressing.dissipated_power()).sum()
    }
}

/// Whether surfaces may touch in the shape that was looked at last.
pub(crate) fn may_touch<P>(contact: &ContactState<P>) -> bool {
    contact.is_rigid_near || contact.is_near.contains(&true)
}

/// Adds the derivative of the forces of a touch. Cost: 6 products for each entry and side that its row moves.
struct Stiffen<'a, G: Turning> {
    plan: &'a Plan<G>,
    work: &'a Workspace<G>,
    memory: &'a mut ContactTangent,
    weights: Weights,
    matrix: &'a mut Matrix,
    touch: usize,
}

/// How a place at the centre of a side moves for a unit rate of a coordinate, and how its motion changes with it, from the
/// twist Psi there and `int ad_V S` (see `line::changes`).
#[inline(always)]
fn changes<G: Turning>(
    plan: &Plan<G>,
    centre: Vector<f64>,
    velocity: Twist<G, f64>,
    [psi, psi_rate]: [Twist<G, f64>; 2],
) -> [Motion; 2] {
    let at = |twist: Twist<G, f64>| {
        let angular = G::axial_in_space(plan.frame, twist.angular);
        [angular, G::in_space(plan.frame, twist.linear) + angular.cross(centre)]
    };
    let moved = at(psi);
    let mut change = at(psi.bracket(velocity) + psi_rate);
    change[1] += G::axial_in_space(plan.frame, velocity.angular).cross(moved[1]);
    [moved, change]
}

impl<G: Turning> Sweep for Stiffen<'_, G> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Self { plan, work, memory, weights, matrix, touch: t } = self;
        let touch = &work.contact.touches[t];
        let pair = &plan.contacts.pairs[touch.pair];
        let ContactTangent { moved, faster, components, answers, followed } = memory;
        let reaches = || pair.reaches.iter().cloned().flatten();
        for k in reaches() {
            moved[k] = [[Vector::zero(); 2]; 2];
            faster[k] = [[Vector::zero(); 2]; 2];
        }
        for (s, standing) in touch.sides.iter().enumerate() {
            let centre = touch.centres[s];
            let mut take = |velocity, k: usize, column| {
                [moved[k][s], faster[k][s]] = changes(plan, centre, velocity, column);
            };
            match *standing {
                Standing::Still => {}
                Standing::On(fixture) => {
                    let fixture = &plan.contacts.fixtures[fixture];
                    let Some(point) = fixture.point else { continue };
                    let velocity = work.points[point].velocity;
                    let moved_by = columns::each(&fixture.moved_by);
                    columns::visit(plan, work, moved_by, |k, column| take(velocity, k, column));
                }
                Standing::Along { curve, .. } => {
                    let curve = &plan.contacts.curves[curve];
                    let piece = &plan.pieces[curve.piece];
                    let reach = &work.contact.reach(plan.contacts.packs, t, s)[..piece.packs];
                    let mut velocity = Twist::zero();
                    for (&weight, &rate) in reach.iter().zip(&work.rate[piece.node_packs()]) {
                        velocity += rate * weight;
                    }
                    let velocity = work.stations[piece.joined.begin].velocity + velocity.sum();
                    let moved_by = columns::each(&curve.moved_by)
                        .map(|(p, weights)| (p, if p == curve.piece { reach } else { weights }));
                    columns::visit(plan, work, moved_by, |k, column| take(velocity, k, column));
                }
            }
        }
        for k in reaches() {
            for (motions, components) in moved[k].iter().zip(components.as_chunks_mut::<6>().0) {
                for (x, component) in six(*motions).into_iter().zip(components) {
                    component[k] = x;
                }
            }
        }
        let wrenches = touch.meeting.wrenches(&touch.pressing);
        let rubbing = followed.now[t].linearised;
        for k in reaches() {
            // Written out: `array::map` and `from_fn` are not always inlined, and took a fifth of the time of a pile.
            let scaled = |[turn, shift]: Motion| [turn * weights.q, shift * weights.q];
            let displaced = [scaled(moved[k][0]), scaled(moved[k][1])];
            let rate = |s: usize| {
                let ([turn, shift], [spin, velocity]) = (moved[k][s], faster[k][s]);
                [turn * weights.v + spin * weights.q, shift * weights.v + velocity * weights.q]
            };
            let rates = [rate(0), rate(1)];
            let change = touch.meeting.change(&touch.pressing, rubbing, displaced, rates);
            let answer = |s: usize, m: usize| -(change[s][m] + wrenches[s][m].cross(displaced[s][0]));
            answers[k] = [six([answer(0, 0), answer(0, 1)]), six([answer(1, 0), answer(1, 1)])];
        }
        let n = plan.n;
        for rows in &pair.reaches {
            for (s, components) in components.as_chunks::<6>().0.iter().enumerate() {
                let components = components.each_ref().map(|component| &component[rows.clone()]);
                // Coordinates that move the other side alone feel nothing of this one, and the world does not answer.
                if components.iter().all(|component| component.iter().all(|x| *x == 0.0)) {
                    continue;
                }
                for k in reaches() {
                    let entries = &mut matrix.as_mut_slice()[k * n..][rows.clone()];
                    add_products::<G::Pack>(entries, components, answers[k][s]);
                }
            }
        }
    }
}

/// The numbers of a turn and a shift.
#[inline(always)]
fn six([turn, shift]: Motion) -> [f64; 6] {
    let ([a, b, c], [d, e, f]) = (turn.to_array(), shift.to_array());
    [a, b, c, d, e, f]
}

/// Adds to each entry the sum of the factors times what belongs to it: those of the turn, then those of the shift.
#[inline(always)]
fn add_products<P: Lanes>(entries: &mut [f64], of: [&[f64]; 6], factors: [f64; 6]) {
    let (packs, rest) = entries.as_chunks_mut::<LANES>();
    for (i, pack) in packs.iter_mut().enumerate() {
        let term = |c: usize| P::from_lanes(of[c].as_chunks::<LANES>().0[i]) * P::splat(factors[c]);
        let mut sum = P::from_lanes(*pack);
        sum += term(0) + term(1) + term(2);
        sum += term(3) + term(4) + term(5);
        for (lane, entry) in pack.iter_mut().enumerate() {
            *entry = sum.lane(lane);
        }
    }
    let first = packs.len() * LANES;
    for (i, entry) in rest.iter_mut().enumerate() {
        let term = |c: usize| of[c][first + i] * factors[c];
        *entry += term(0) + term(1) + term(2);
        *entry += term(3) + term(4) + term(5);
    }
}
