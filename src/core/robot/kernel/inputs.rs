//! Derivative of the inverse dynamics with respect to the inputs.
//!
//! The derivatives of actuator forces are known. Loads are linear in their inputs: the generalised forces of
//! a unit load are computed by the usual backward sweep, with no other forces at nodes and points.

use super::{inverse_dynamics, lines};
use crate::numerics::lie::{VectorSpace, Wrench};
use crate::numerics::linalg::Matrix;
use crate::robot::effects;
use crate::robot::effects::actuator::force as actuation;
use crate::robot::effects::actuator::state::{ActuationTangent, Force};
use crate::robot::effects::load::plan as load;
use crate::robot::plan::Plan;
use crate::robot::state::Workspace;
use crate::robot::turning::Turning;

/// Writes the derivative, n x m. The motion must be up to date, and is invalid afterwards.
pub(crate) fn tangent<G: Turning>(
    plan: &Plan<G>,
    work: &mut Workspace<G>,
    memory: &mut ActuationTangent<G::Pack>,
    tangent: &mut Matrix,
) {
    tangent.fill(0.0);
    lines::find(plan, work, memory);
    let q = &work.motion_of[..plan.n];
    actuation::add_input_tangent(plan, work, memory, q, |row, column, value| tangent[(row, column)] += value);
    if plan.effects.loads.iter().all(|load| load.signals.is_none()) {
        return;
    }
    let zeros = vec![0.0; plan.n];
    let (mut tau, mut without) = (zeros.clone(), zeros.clone());
    let acting = work.effects.acting.clone();
    work.motion_is_known = false;
    work.motion_of[2 * plan.n..].fill(0.0);
    work.effects.acting.fill(Wrench::zero());
    work.effects.actuation.forces.fill(Force::default());
    // Forces of joint springs at zero.
    gather(plan, work, &zeros, &mut without);
    for column in 0..work.inputs.len() {
        let mut acts = false;
        for (i, load) in plan.effects.loads.iter().enumerate() {
            let Some(signals) = &load.signals else { continue };
            let unit = signals.each_ref().map(|signal| {
                let entry = signal.input().filter(|&first| (first..first + 3).contains(&column));
                entry.map_or([0.0; 3], |first| {
                    std::array::from_fn(|k| if first + k == column { 1.0 } else { 0.0 })
                })
            });
            work.effects.acting[i] =
                load::wrench(unit, load.frame, plan.frame, &work.surroundings.base.rotation);
            acts |= unit != [[0.0; 3]; 2];
        }
        if acts {
            gather(plan, work, &zeros, &mut tau);
            for (row, (tau, without)) in tau.iter().zip(&without).enumerate() {
                tangent[(row, column)] += tau - without;
            }
        }
    }
    work.effects.acting = acting;
}

/// Generalised forces of the loads alone, plus forces at rest at zero coordinates.
fn gather<G: Turning>(plan: &Plan<G>, work: &mut Workspace<G>, zeros: &[f64], tau: &mut [f64]) {
    work.force.fill(Wrench::zero());
    for piece in &plan.pieces {
        effects::load_along(plan, piece, work);
    }
    for (i, point) in plan.points.iter().enumerate() {
        let mut state = work.points[i];
        state.force = Wrench { moment: VectorSpace::zero(), force: VectorSpace::zero() };
        effects::load_at(plan, work, point, &mut state);
        work.points[i] = state;
    }
    inverse_dynamics::gather(plan, work);
    inverse_dynamics::project(plan, work, zeros, zeros, tau);
}
