//! Motion of the straight parts of tendons with the coordinates.

use crate::numerics::lie::Vector;
use crate::robot::effects::actuator::force::line;
use crate::robot::effects::actuator::plan::End;
use crate::robot::effects::actuator::state::ActuationTangent;
use crate::robot::plan::Plan;
use crate::robot::state::Workspace;
use crate::robot::turning::{Turning, columns};

/// Computes the relative displacements of the ends of all straight parts per unit coordinate, and the
/// derivatives of their length rates, with the motion up to date.
pub(crate) fn find<G: Turning>(plan: &Plan<G>, work: &Workspace<G>, memory: &mut ActuationTangent<G::Pack>) {
    let n = plan.n;
    memory.moved.fill(Vector::zero());
    memory.rate_gradients.fill(0.0);
    memory.exits_turned.fill([Vector::zero(); 2]);
    for (i, straight) in plan.effects.actuation.lines.iter().enumerate() {
        let moved = &mut memory.moved[i * n..][..n];
        let rate_gradient = &mut memory.rate_gradients[i * n..][..n];
        for (e, end) in straight.ends.iter().enumerate() {
            let End::On { moved_by, .. } = end else { continue };
            columns::visit(plan, work, columns::each(moved_by), |k, column| {
                let (way, of_rate) = line::changes(plan, work, i, e, column);
                moved[k] += way;
                rate_gradient[k] += of_rate;
                if straight.guide_exits[e].is_some() {
                    memory.exits_turned[i * n + k][e] += line::turns_at_exits(plan, work, [i, e], column[0]);
                }
            });
        }
        if straight.guide_exits.iter().any(Option::is_some) {
            line::add_bending_at_exits(plan, work, i, &mut memory.exits_turned[i * n..][..n]);
        }
    }
}
