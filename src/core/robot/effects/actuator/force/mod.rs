//! Actuators: forces that act on lengths. A force F on a length l(q) has the generalised forces `F dl/dq`,
//! with the derivative `F d2l/dq2 + dl/dq (dF/dq)^T`.

mod friction;
pub(crate) mod law;
pub(crate) mod line;
mod routing_segment;

use self::law::Potential;
use crate::model::Energy;
use crate::numerics::lie::Sweep;
use crate::robot::algebra::inertia::Gyroscope;
use crate::robot::effects::actuator::plan::{ActuatorPlan, Law};
use crate::robot::effects::actuator::state::{ActuationState, ActuationTangent, Force};
use crate::robot::effects::kinds::{
    CoordinateForce, DeadPointWrench, Dissipation, NoPointResponse, NoPointWrench, NoVelocityDependence,
    NotAlongRods, StoredEnergy, Supply,
};
use crate::robot::plan::Plan;
use crate::robot::plan::point::Point;
use crate::robot::state::Workspace;
use crate::robot::state::point::PointState;
use crate::robot::state::tangent::{Tangent, TangentWorkspace, Weights};
use crate::robot::turning::Turning;

/// The actuators of a plan.
pub(crate) struct Actuators;

/// Computes lengths, their gradients and rates, and forces.
struct Measure<'a, G: Turning> {
    plan: &'a Plan<G>,
    state: &'a mut ActuationState<G::Pack>,
    q: &'a [f64],
    qd: &'a [f64],
}

impl<G: Turning> Sweep for Measure<'_, G> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Self { plan, state, q, qd } = self;
        let n = plan.n;
        let actuation = &plan.effects.actuation;
        for (i, actuator) in actuation.actuators.iter().enumerate() {
            let gradient = &mut state.gradients[i * n..][..n];
            gradient.fill(0.0);
            state.lengths[i] = actuator.length_at_zero;
            for &(k, of_k) in &actuator.gradient {
                gradient[k] += of_k;
                state.lengths[i] += of_k * q[k];
            }
        }
        let (mut slope, mut node) = (0, 0);
        for routing_segment in &actuation.routing_segments {
            routing_segment::fields(routing_segment, q, &mut state.field);
            let slopes = routing_segment.components.len() * routing_segment.packs;
            for guide in &routing_segment.guides {
                state.lengths[guide.actuator] += routing_segment::measure(
                    routing_segment,
                    guide,
                    &state.field,
                    &mut state.slopes[slope..][..slopes],
                    &mut state.inverse_norms[node..][..routing_segment.packs],
                    &mut state.gradients[guide.actuator * n..][..n],
                );
                slope += slopes;
                node += routing_segment.packs;
            }
        }
        for (i, actuator) in actuation.actuators.iter().enumerate() {
            let gradient = &state.gradients[i * n..][..n];
            state.rates[i] = actuator.reaches.iter().map(|&k| gradient[k] * qd[k]).sum();
        }
    }
}

/// Generalised forces of a unit force of an actuator, without straight parts.
#[inline(always)]
fn distribution<'a, G: Turning>(plan: &Plan<G>, state: &'a ActuationState<G::Pack>, i: usize) -> &'a [f64] {
    let rows = match plan.effects.actuation.actuators[i].friction {
        Some(_) => &state.distributions,
        None => &state.gradients,
    };
    &rows[i * plan.n..][..plan.n]
}

/// Computes tensions along tendons, and the power dissipated per unit force.
fn distribute<G: Turning>(plan: &Plan<G>, state: &mut ActuationState<G::Pack>, q: &[f64], qd: &[f64]) {
    for (i, actuator) in plan.effects.actuation.actuators.iter().enumerate() {
        let Some(friction) = &actuator.friction else {
            state.work_rates[i] = state.rates[i];
            continue;
        };
        state.slidings[i] = friction::sliding(friction, state.slidings[i].commanded, state.rates[i]);
        friction::measure(&plan.effects.actuation, state, i, friction, q);
        let along: f64 = distribution(plan, state, i).iter().zip(qd).map(|(force, rate)| force * rate).sum();
        let lines = plan.effects.actuation.lines_of(i).map(|l| &state.lines[l]);
        state.work_rates[i] = along + lines.map(|line| line.ratio * line.rate).sum::<f64>();
    }
}

/// Adds the straight parts, whose motion is known, to the gradient of an actuator's length.
fn complete<G: Turning>(
    plan: &Plan<G>,
    state: &ActuationState<G::Pack>,
    memory: &mut ActuationTangent<G::Pack>,
    i: usize,
) {
    let n = plan.n;
    memory.gradient.copy_from_slice(&state.gradients[i * n..][..n]);
    for l in plan.effects.actuation.lines_of(i) {
        for (entry, moved) in memory.gradient.iter_mut().zip(&memory.moved[l * n..][..n]) {
            *entry += state.lines[l].direction.dot(*moved);
        }
    }
}

/// Complete gradient of an actuator's length, with the motion of its straight parts up to date.
pub(crate) fn gradient<'a, G: Turning>(
    plan: &Plan<G>,
    work: &Workspace<G>,
    memory: &'a mut ActuationTangent<G::Pack>,
    i: usize,
) -> &'a [f64] {
    complete(plan, &work.effects.actuation, memory, i);
    &memory.gradient
}

/// The same with the length of the relative displacement of its ends as the contribution of each straight part.
pub(crate) fn reach<G: Turning>(
    plan: &Plan<G>,
    work: &Workspace<G>,
    memory: &ActuationTangent<G::Pack>,
    i: usize,
    k: usize,
) -> f64 {
    let lines = plan.effects.actuation.lines_of(i);
    let moved = lines.map(|l| memory.moved[l * plan.n + k]).map(|moved| moved.dot(moved).sqrt());
    work.effects.actuation.gradients[i * plan.n + k].abs() + moved.sum::<f64>()
}

/// Second time derivative of an actuator's length, with the motion, including that of straight parts, up to
/// date.
pub(crate) fn acceleration<G: Turning>(
    plan: &Plan<G>,
    work: &Workspace<G>,
    memory: &mut ActuationTangent<G::Pack>,
    i: usize,
) -> f64 {
    let [_, qd, qdd] = [0, 1, 2].map(|part| &work.motion_of[part * plan.n..][..plan.n]);
    find_gradient_rate_of_routing_segments(plan, &work.effects.actuation, memory, i, qd);
    let along = |of: &[f64], by: &[f64]| of.iter().zip(by).map(|(of, by)| of * by).sum::<f64>();
    let gradient = &work.effects.actuation.gradients[i * plan.n..][..plan.n];
    let lines = plan.effects.actuation.lines_of(i);
    along(gradient, qdd)
        + along(&memory.gradient_rate, qd)
        + lines.map(|l| line::acceleration(plan, work, l)).sum::<f64>()
}

/// Adds the derivatives of the generalised forces.
struct Stiffen<'a, 'b, G: Turning> {
    plan: &'a Plan<G>,
    state: &'a ActuationState<G::Pack>,
    memory: &'a mut ActuationTangent<G::Pack>,
    q: &'a [f64],
    qd: &'a [f64],
    weights: Weights,
    tangent: &'a mut Tangent<'b>,
}

impl<G: Turning> Sweep for Stiffen<'_, '_, G> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Self { plan, state, memory, q, qd, weights, tangent } = self;
        stiffen_routing_segments(plan, state, memory, weights, tangent);
        for (i, actuator) in plan.effects.actuation.actuators.iter().enumerate() {
            let force = state.forces[i];
            let has_stiffness = force.of_length != 0.0 || force.of_rate != 0.0;
            if has_stiffness || actuator.friction.is_some() {
                complete(plan, state, memory, i);
                match weights.q != 0.0 && (force.of_rate != 0.0 || state.slidings[i].of_rate != 0.0) {
                    true => find_gradient_rate(plan, state, memory, i, qd),
                    false => memory.gradient_rate.fill(0.0),
                }
            }
            let (block, stride, first) = match actuator.piece {
                Some(s) => {
                    let piece = &plan.pieces[s];
                    let (block, stride) = tangent.block(s, piece);
                    (block, stride, piece.first)
                }
                None => match tangent {
                    Tangent::Dense(matrix) => {
                        let n = matrix.nrows();
                        (matrix.as_mut_slice(), n, 0)
                    }
                    // Robots with actuators that couple pieces use the dense solver.
                    Tangent::Tree(_) => continue,
                },
            };
            let mut add = |row: usize, column: usize, value: f64| {
                block[(column - first) * stride + (row - first)] += value;
            };
            let factor = weights.q * force.value;
            let mut of_sliding = 0.0;
            if actuator.friction.is_some() {
                friction::stiffen(&plan.effects.actuation, state, memory, i, q, factor, &mut add);
                of_sliding = force.value * state.slidings[i].of_rate;
            } else if has_stiffness {
                memory.distribution.copy_from_slice(&memory.gradient);
            }
            if has_stiffness || of_sliding != 0.0 {
                for &k in &actuator.reaches {
                    let of_rate = weights.q * memory.gradient_rate[k] + weights.v * memory.gradient[k];
                    let of_force = weights.q * force.of_length * memory.gradient[k] + force.of_rate * of_rate;
                    for &j in &actuator.reaches {
                        add(
                            j,
                            k,
                            memory.distribution[j] * of_force + memory.of_sliding[j] * of_sliding * of_rate,
                        );
                    }
                }
            }
            for l in plan.effects.actuation.lines_of(i) {
                let state = &state.lines[l];
                let moved = &memory.moved[l * plan.n..][..plan.n];
                let factor = factor * state.ratio * state.inverse_length;
                for &k in &actuator.reaches {
                    let across = moved[k] - state.direction * state.direction.dot(moved[k]);
                    for &j in &actuator.reaches {
                        add(j, k, factor * moved[j].dot(across));
                    }
                }
            }
        }
    }
}

/// Adds the derivatives due to the curvature of the lengths of embedded parts.
#[inline(always)]
fn stiffen_routing_segments<G: Turning>(
    plan: &Plan<G>,
    state: &ActuationState<G::Pack>,
    memory: &mut ActuationTangent<G::Pack>,
    weights: Weights,
    tangent: &mut Tangent<'_>,
) {
    let (mut slope, mut node) = (0, 0);
    for routing_segment in &plan.effects.actuation.routing_segments {
        let (slopes, pairs) = (
            routing_segment.components.len() * routing_segment.packs,
            routing_segment.components.len() * (routing_segment.components.len() + 1) / 2
                * routing_segment.packs,
        );
        let stiffness = &mut memory.stiffness[..pairs];
        stiffness.fill(crate::numerics::lie::Scalar::splat(0.0));
        for guide in &routing_segment.guides {
            let factor = weights.q * state.forces[guide.actuator].value;
            if factor != 0.0 {
                routing_segment::stiffen(
                    routing_segment,
                    guide,
                    &state.slopes[slope..][..slopes],
                    &state.inverse_norms[node..][..routing_segment.packs],
                    &state.ratios[node..][..routing_segment.packs],
                    factor,
                    stiffness,
                );
            }
            slope += slopes;
            node += routing_segment.packs;
        }
        let piece = &plan.pieces[routing_segment.piece];
        let (block, stride) = tangent.block(routing_segment.piece, piece);
        routing_segment::add_stiffness(routing_segment, stiffness, piece.first, block, stride);
    }
}

/// Rate of the gradient of an actuator's length, `d2l/dq2 qd`.
#[inline(always)]
fn find_gradient_rate<G: Turning>(
    plan: &Plan<G>,
    state: &ActuationState<G::Pack>,
    memory: &mut ActuationTangent<G::Pack>,
    actuator: usize,
    qd: &[f64],
) {
    find_gradient_rate_of_routing_segments(plan, state, memory, actuator, qd);
    for l in plan.effects.actuation.lines_of(actuator) {
        let of_line = &memory.rate_gradients[l * plan.n..][..plan.n];
        for (rate, of_line) in memory.gradient_rate.iter_mut().zip(of_line) {
            *rate += of_line;
        }
    }
}

/// The same for its embedded parts only.
fn find_gradient_rate_of_routing_segments<G: Turning>(
    plan: &Plan<G>,
    state: &ActuationState<G::Pack>,
    memory: &mut ActuationTangent<G::Pack>,
    actuator: usize,
    qd: &[f64],
) {
    memory.gradient_rate.fill(0.0);
    let (mut slope, mut node) = (0, 0);
    for routing_segment in &plan.effects.actuation.routing_segments {
        let slopes = routing_segment.components.len() * routing_segment.packs;
        for guide in &routing_segment.guides {
            if guide.actuator == actuator {
                routing_segment::fields(routing_segment, qd, &mut memory.field);
                // Memory of the same size that is not in use here.
                let densities = &mut memory.stiffness[..slopes];
                routing_segment::slope_rates(
                    routing_segment,
                    guide,
                    &state.slopes[slope..][..slopes],
                    &state.inverse_norms[node..][..routing_segment.packs],
                    &memory.field,
                    densities,
                );
                routing_segment::project(routing_segment, densities, &mut memory.gradient_rate);
            }
            slope += slopes;
            node += routing_segment.packs;
        }
    }
}

/// Adds the derivatives of the generalised forces with respect to the inputs, n x m, with the motion of
/// straight parts up to date.
pub(crate) fn add_input_tangent<G: Turning>(
    plan: &Plan<G>,
    work: &Workspace<G>,
    memory: &mut ActuationTangent<G::Pack>,
    q: &[f64],
    mut add: impl FnMut(usize, usize, f64),
) {
    let state = &work.effects.actuation;
    for (i, actuator) in plan.effects.actuation.actuators.iter().enumerate() {
        let sliding = actuator.friction.as_ref().and_then(|friction| friction.sliding.as_ref()?.input());
        if actuator.command.input().is_none() && sliding.is_none() {
            continue;
        }
        if actuator.friction.is_some() {
            friction::stiffen(&plan.effects.actuation, state, memory, i, q, 0.0, |_, _, _| {});
        } else {
            complete(plan, state, memory, i);
            memory.distribution.copy_from_slice(&memory.gradient);
        }
        let force = &state.forces[i];
        for &k in &actuator.reaches {
            if let Some(input) = actuator.command.input() {
                add(k, input, force.of_command * memory.distribution[k]);
            }
            if let Some(input) = sliding {
                add(k, input, force.value * memory.of_sliding[k] * state.slidings[i].of_command);
            }
        }
    }
}

impl<G: Turning> DeadPointWrench<G> for Actuators {
    #[inline(always)]
    fn dead_at(
        plan: &Plan<G>,
        work: &Workspace<G>,
        point: &Point<G>,
        _: &PointState<G>,
        sum: &mut Gyroscope<G, f64>,
    ) {
        for (wrench, position) in line::dead_at(plan, work, &point.effects.pulled) {
            sum.add(Gyroscope::of_dead_load(wrench, position));
        }
    }
}

impl<G: Turning> CoordinateForce<G> for Actuators {
    fn acts(plan: &Plan<G>) -> bool {
        !plan.effects.actuation.actuators.is_empty()
    }

    #[inline(always)]
    fn prepare(plan: &Plan<G>, work: &mut Workspace<G>, q: &[f64], qd: &[f64]) {
        if !plan.effects.actuation.actuators.is_empty() {
            let state = &mut work.effects.actuation;
            plan.instructions.run_outlined::<G::Pack, _>(Measure { plan, state, q, qd });
            line::measure(plan, work, q);
            let (state, multipliers) = (&mut work.effects.actuation, &work.effects.loops.multipliers);
            for (i, actuator) in plan.effects.actuation.actuators.iter().enumerate() {
                let command = match actuator.law {
                    Law::Inextensible { place } => multipliers[plan.effects.loops.first_length() + place],
                    _ => state.commands[i],
                };
                state.forces[i] = match state.fixed_tensions[i] {
                    Some(value) => Force { value, ..Force::default() },
                    None => law::force(actuator.law, state.lengths[i], state.rates[i], command),
                };
            }
            distribute(plan, state, q, qd);
            line::pull(plan, work);
        }
    }

    #[inline(always)]
    fn push(plan: &Plan<G>, work: &Workspace<G>, tau: &mut [f64]) {
        for (i, actuator) in plan.effects.actuation.actuators.iter().enumerate() {
            let force = work.effects.actuation.forces[i].value;
            let distribution = distribution(plan, &work.effects.actuation, i);
            for &k in &actuator.reaches {
                tau[k] += force * distribution[k];
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
        if !plan.effects.actuation.actuators.is_empty() {
            let (state, memory) = (&work.effects.actuation, &mut memory.effects.actuation);
            let (q, qd) = (&work.motion_of[..plan.n], &work.motion_of[plan.n..2 * plan.n]);
            let sweep = Stiffen { plan, state, memory, q, qd, weights, tangent };
            plan.instructions.run_outlined::<G::Pack, _>(sweep);
        }
    }

    fn couples_pieces(plan: &Plan<G>) -> bool {
        plan.effects.actuation.couples_pieces()
    }
}

impl<G: Turning> StoredEnergy<G> for Actuators {
    fn add_energy(plan: &Plan<G>, work: &Workspace<G>, energy: &mut Energy) {
        let state = &work.effects.actuation;
        for (i, actuator) in plan.effects.actuation.actuators.iter().enumerate() {
            if actuator.has_potential {
                match law::potential(actuator.law, state.lengths[i], state.commands[i]) {
                    Some(Potential::Load(load)) => energy.loads += load,
                    Some(Potential::Spring(elastic)) => energy.elastic += elastic,
                    None => {}
                }
            }
        }
    }
}

impl<G: Turning> Dissipation<G> for Actuators {
    fn dissipates(plan: &Plan<G>) -> bool {
        plan.effects
            .actuation
            .actuators
            .iter()
            .any(|actuator| actuator.has_potential && law::dissipates(actuator.law))
    }

    fn dissipated_power(plan: &Plan<G>, work: &Workspace<G>) -> f64 {
        let state = &work.effects.actuation;
        let power = |(i, actuator): (usize, &ActuatorPlan)| {
            if !actuator.has_potential || !law::dissipates(actuator.law) {
                return 0.0;
            }
            let spring = law::conservative(actuator.law, state.lengths[i], state.commands[i]);
            (state.forces[i].value - spring) * state.rates[i]
        };
        plan.effects.actuation.actuators.iter().enumerate().map(power).sum()
    }
}

impl<G: Turning> Supply<G> for Actuators {
    fn drives(plan: &Plan<G>) -> bool {
        !plan.effects.actuation.actuators.iter().all(|actuator| actuator.has_potential)
    }

    fn supplied_power(plan: &Plan<G>, work: &Workspace<G>) -> f64 {
        let state = &work.effects.actuation;
        let power = |(i, actuator): (usize, &ActuatorPlan)| {
            if actuator.has_potential { 0.0 } else { -state.forces[i].value * state.work_rates[i] }
        };
        plan.effects.actuation.actuators.iter().enumerate().map(power).sum()
    }
}

impl NotAlongRods for Actuators {}
impl NoPointWrench for Actuators {}
impl NoPointResponse for Actuators {}
impl NoVelocityDependence for Actuators {}
