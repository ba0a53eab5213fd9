//! Actuators: forces on lengths. A force F on a length l(q) has the generalised forces `F dl/dq`, and their derivative is
//! `F d2l/dq2 + dl/dq (dF/dq)^T`.

pub(crate) mod law;
mod sleeve;

use self::law::Potential;
use super::Effect;
use crate::lie::Sweep;
use crate::model::Energy;
use crate::robot::plan::Plan;
use crate::robot::plan::actuation::ActuatorPlan;
use crate::robot::state::Workspace;
use crate::robot::state::actuation::{ActuationState, ActuationTangent};
use crate::robot::state::tangent::{Tangent, TangentWorkspace, Weights};
use crate::robot::turning::Turning;

/// The actuators of a plan.
pub(crate) struct Actuators;

/// Finds lengths, their gradients and rates, and forces.
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
        let actuation = &plan.actuation;
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
        for sleeve in &actuation.sleeves {
            sleeve::fields(sleeve, q, &mut state.field);
            let slopes = sleeve.components.len() * sleeve.packs;
            for thread in &sleeve.threads {
                state.lengths[thread.actuator] += sleeve::measure(
                    sleeve,
                    thread,
                    &state.field,
                    &mut state.slopes[slope..][..slopes],
                    &mut state.inverse_norms[node..][..sleeve.packs],
                    &mut state.gradients[thread.actuator * n..][..n],
                );
                slope += slopes;
                node += sleeve.packs;
            }
        }
        for (i, actuator) in actuation.actuators.iter().enumerate() {
            let gradient = &state.gradients[i * n..][..n];
            state.rates[i] = actuator.reaches.iter().map(|&k| gradient[k] * qd[k]).sum();
            state.forces[i] = law::force(actuator.law, state.lengths[i], state.rates[i], state.commands[i]);
        }
    }
}

/// Adds the derivative of the generalised forces.
struct Stiffen<'a, 'b, G: Turning> {
    plan: &'a Plan<G>,
    state: &'a ActuationState<G::Pack>,
    memory: &'a mut ActuationTangent<G::Pack>,
    qd: &'a [f64],
    weights: Weights,
    tangent: &'a mut Tangent<'b>,
}

impl<G: Turning> Sweep for Stiffen<'_, '_, G> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Self { plan, state, memory, qd, weights, tangent } = self;
        let (mut slope, mut node) = (0, 0);
        for sleeve in &plan.actuation.sleeves {
            let (slopes, pairs) = (
                sleeve.components.len() * sleeve.packs,
                sleeve.components.len() * (sleeve.components.len() + 1) / 2 * sleeve.packs,
            );
            let stiffness = &mut memory.stiffness[..pairs];
            stiffness.fill(crate::lie::Scalar::splat(0.0));
            for thread in &sleeve.threads {
                let factor = weights.q * state.forces[thread.actuator].value;
                if factor != 0.0 {
                    sleeve::stiffen(
                        sleeve,
                        thread,
                        &state.slopes[slope..][..slopes],
                        &state.inverse_norms[node..][..sleeve.packs],
                        factor,
                        stiffness,
                    );
                }
                slope += slopes;
                node += sleeve.packs;
            }
            let piece = &plan.pieces[sleeve.piece];
            let (block, stride) = tangent.block(sleeve.piece, piece);
            sleeve::add_stiffness(sleeve, stiffness, piece.first, block, stride);
        }
        for (i, actuator) in plan.actuation.actuators.iter().enumerate() {
            let force = state.forces[i];
            if force.of_length == 0.0 && force.of_rate == 0.0 {
                continue;
            }
            if weights.q * force.of_rate != 0.0 {
                find_gradient_rate(plan, state, memory, i, qd);
            } else {
                memory.gradient_rate.fill(0.0);
            }
            let gradient = &state.gradients[i * plan.n..][..plan.n];
            let of_both = weights.q * force.of_length + weights.v * force.of_rate;
            let of_change = weights.q * force.of_rate;
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
                    Tangent::Tree(_) => unreachable!("what couples pieces is solved with all entries"),
                },
            };
            for &k in &actuator.reaches {
                let change = of_both * gradient[k] + of_change * memory.gradient_rate[k];
                for &j in &actuator.reaches {
                    block[(k - first) * stride + (j - first)] += gradient[j] * change;
                }
            }
        }
    }
}

/// The rate of the gradient of an actuator's length, `d2l/dq2 qd`.
#[inline(always)]
fn find_gradient_rate<G: Turning>(
    plan: &Plan<G>,
    state: &ActuationState<G::Pack>,
    memory: &mut ActuationTangent<G::Pack>,
    actuator: usize,
    qd: &[f64],
) {
    memory.gradient_rate.fill(0.0);
    let (mut slope, mut node) = (0, 0);
    for sleeve in &plan.actuation.sleeves {
        let slopes = sleeve.components.len() * sleeve.packs;
        for thread in &sleeve.threads {
            if thread.actuator == actuator {
                sleeve::fields(sleeve, qd, &mut memory.field);
                // The stiffness is as large, and free here.
                let densities = &mut memory.stiffness[..slopes];
                sleeve::slope_rates(
                    sleeve,
                    thread,
                    &state.slopes[slope..][..slopes],
                    &state.inverse_norms[node..][..sleeve.packs],
                    &memory.field,
                    densities,
                );
                sleeve::project(sleeve, densities, &mut memory.gradient_rate);
            }
            slope += slopes;
            node += sleeve.packs;
        }
    }
}

/// Adds the derivative of the generalised forces with respect to the inputs, n x m.
pub(crate) fn add_input_tangent<G: Turning>(
    plan: &Plan<G>,
    work: &Workspace<G>,
    add: &mut impl FnMut(usize, usize, f64),
) {
    let state = &work.actuation;
    for (i, actuator) in plan.actuation.actuators.iter().enumerate() {
        if let Some(input) = actuator.command.input() {
            let gradient = &state.gradients[i * plan.n..][..plan.n];
            for &k in &actuator.reaches {
                add(k, input, state.forces[i].of_command * gradient[k]);
            }
        }
    }
}

impl<G: Turning> Effect<G> for Actuators {
    #[inline(always)]
    fn prepare(plan: &Plan<G>, work: &mut Workspace<G>, q: &[f64], qd: &[f64]) {
        if !plan.actuation.actuators.is_empty() {
            let state = &mut work.actuation;
            plan.instructions.run_apart::<G::Pack, _>(Measure { plan, state, q, qd });
        }
    }

    #[inline(always)]
    fn push(plan: &Plan<G>, work: &Workspace<G>, tau: &mut [f64]) {
        for (i, actuator) in plan.actuation.actuators.iter().enumerate() {
            let force = work.actuation.forces[i].value;
            let gradient = &work.actuation.gradients[i * plan.n..][..plan.n];
            for &k in &actuator.reaches {
                tau[k] += force * gradient[k];
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
        if !plan.actuation.actuators.is_empty() {
            let (state, memory) = (&work.actuation, &mut memory.actuation);
            let qd = &work.motion_of[plan.n..2 * plan.n];
            plan.instructions.run_apart::<G::Pack, _>(Stiffen { plan, state, memory, qd, weights, tangent });
        }
    }

    fn dissipates(plan: &Plan<G>) -> bool {
        plan.actuation
            .actuators
            .iter()
            .any(|actuator| actuator.has_potential && law::dissipates(actuator.law))
    }

    fn drives(plan: &Plan<G>) -> bool {
        !plan.actuation.actuators.iter().all(|actuator| actuator.has_potential)
    }

    fn add_energy(plan: &Plan<G>, work: &Workspace<G>, energy: &mut Energy) {
        let state = &work.actuation;
        for (i, actuator) in plan.actuation.actuators.iter().enumerate() {
            if actuator.has_potential {
                match law::potential(actuator.law, state.lengths[i], state.commands[i]) {
                    Some(Potential::Load(load)) => energy.loads += load,
                    Some(Potential::Spring(elastic)) => energy.elastic += elastic,
                    None => {}
                }
            }
        }
    }

    fn dissipated_power(plan: &Plan<G>, work: &Workspace<G>) -> f64 {
        let state = &work.actuation;
        let power = |(i, actuator): (usize, &ActuatorPlan)| {
            if !actuator.has_potential {
                return 0.0;
            }
            let spring = law::conservative(actuator.law, state.lengths[i], state.commands[i]);
            (state.forces[i].value - spring) * state.rates[i]
        };
        plan.actuation.actuators.iter().enumerate().map(power).sum()
    }

    fn supplied_power(plan: &Plan<G>, work: &Workspace<G>) -> f64 {
        let state = &work.actuation;
        let power = |(i, actuator): (usize, &ActuatorPlan)| {
            if actuator.has_potential { 0.0 } else { -state.forces[i].value * state.rates[i] }
        };
        plan.actuation.actuators.iter().enumerate().map(power).sum()
    }
}
