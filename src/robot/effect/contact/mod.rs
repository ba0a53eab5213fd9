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
use crate::lie::{Sweep, Twist, Vector, Wrench};
use crate::linalg::Matrix;
use crate::model::Energy;
use crate::robot::algebra::tie::Motion;
use crate::robot::plan::Plan;
use crate::robot::plan::contact::Side;
use crate::robot::plan::piece::PiecePlan;
use crate::robot::state::Workspace;
use crate::robot::state::contact::{ContactTangent, Standing, Touch};
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
        <Self as Effect<G>>::dissipates(plan) && may_touch(plan, work)
    }

    fn add_energy(_: &Plan<G>, work: &Workspace<G>, energy: &mut Energy) {
        let touches = work.contact.touches.iter();
        energy.elastic += touches.map(|touch| touch.meeting.energy(&touch.pressing)).sum::<f64>();
    }

    fn dissipated_power(_: &Plan<G>, work: &Workspace<G>) -> f64 {
        work.contact.touches.iter().map(|touch| touch.pressing.dissipated_power()).sum()
    }
}

/// Whether surfaces may touch in the shape that was looked at last; what is rigid always may.
pub(crate) fn may_touch<G: Turning>(plan: &Plan<G>, work: &Workspace<G>) -> bool {
    let is_rigid = |side: &Side| matches!(side, Side::Ball(_) | Side::Body(_));
    let has_rigid = || plan.contacts.pairs.iter().any(|pair| is_rigid(&pair.sides[0]));
    work.contact.is_near.contains(&true) || has_rigid()
}

/// Adds the derivative of the forces of a touch. Cost: 12 products an entry, 6 against what is fixed in the world.
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
        let ContactTangent { moved, faster, components, followed } = memory;
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
        let n = plan.n;
        // A side that is fixed in the world answers nothing.
        let halves = if touch.sides[1] == Standing::Still { 2 } else { 4 };
        for k in reaches() {
            let [first, second] = moved[k];
            for (half, motion) in
                [first[0], first[1], second[0], second[1]].into_iter().take(halves).enumerate()
            {
                for (c, x) in motion.to_array().into_iter().enumerate() {
                    components[3 * half + c][k] = x;
                }
            }
        }
        let wrenches = touch.meeting.wrenches(&touch.pressing);
        let rubbing = followed.now[t].linearised;
        for k in reaches() {
            let displaced = moved[k].map(|motion| motion.map(|v| v * weights.q));
            let rates: [Motion; 2] = std::array::from_fn(|s| {
                std::array::from_fn(|m| moved[k][s][m] * weights.v + faster[k][s][m] * weights.q)
            });
            let change = touch.meeting.change(&touch.pressing, rubbing, displaced, rates);
            let answer = |s: usize, m: usize| -(change[s][m] + wrenches[s][m].cross(displaced[s][0]));
            let answers = [answer(0, 0), answer(0, 1), answer(1, 0), answer(1, 1)];
            let column = &mut matrix.as_mut_slice()[k * n..][..n];
            for (half, answer) in answers.into_iter().take(halves).enumerate() {
                let [x, y, z] = answer.to_array();
                for run in &pair.reaches {
                    let [of_x, of_y, of_z] = [0, 1, 2].map(|c| &components[3 * half + c][run.clone()]);
                    let entries = column[run.clone()].iter_mut();
                    for (((entry, of_x), of_y), of_z) in entries.zip(of_x).zip(of_y).zip(of_z) {
                        *entry += of_x * x + of_y * y + of_z * z;
                    }
                }
            }
        }
    }
}
