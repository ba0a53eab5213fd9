//! One sweep out for the motion, one sweep back for the forces: `tau = Q + K q + D qd`.
//!
//! In the inertial frame the recursions along the rod are plain integrals (design: section 4):
//! V = int S qd, A = -(0; g) + int [S qdd + ad_V (S qd)], F = F_tip + int (N A - ad_V^T N V), Q_j = int S_j . F.

use super::inertia;
use super::kinematics;
use super::plan::{Plan, SegmentPlan};
use super::workspace::Workspace;
use crate::lie::{Pack, Rotation, Twist, Vector, Wrench, weighted_sum};

/// Twist of a body-frame strain at a place: `Ad_g (angular; linear)`.
#[inline(always)]
fn carried(
    rotation: &Rotation<Pack>,
    position: Vector<Pack>,
    strain: [Pack; 6],
    is_extensible: bool,
) -> Twist<Pack> {
    let [a, b, c, d, e, f] = strain;
    let angular = rotation.apply(Vector::new(a, b, c));
    let mut linear = position.cross(angular);
    if is_extensible {
        linear += rotation.apply(Vector::new(d, e, f));
    }
    Twist { angular, linear }
}

/// Kinematics, motion and internal wrench of a state, unless they are there already.
#[inline(always)]
pub(super) fn update(plan: &Plan, work: &mut Workspace, q: &[f64], qd: &[f64], qdd: &[f64]) {
    kinematics::update(plan, work, q);
    let n = plan.n;
    let known = &mut work.motion_of;
    if known[..n] == *q && known[n..2 * n] == *qd && known[2 * n..] == *qdd {
        return;
    }
    known[..n].copy_from_slice(q);
    known[n..2 * n].copy_from_slice(qd);
    known[2 * n..].copy_from_slice(qdd);
    for (s, segment) in plan.segments.iter().enumerate() {
        sweep_out(segment, s, work, qd, qdd);
    }
    let mut end = tip_wrench(plan, work);
    for segment in plan.segments.iter().rev() {
        end = sweep_back(segment, work, end);
    }
}

#[inline(always)]
fn sweep_out(segment: &SegmentPlan, s: usize, work: &mut Workspace, qd: &[f64], qdd: &[f64]) {
    let nodes = segment.node_packs();
    let base = work.stations[s];
    for pack in 0..segment.packs {
        let node = segment.first_pack + pack;
        let place = (&work.rotation[node], work.position[node]);
        work.rate[node] = carried(place.0, place.1, segment.field(qd, pack), segment.is_extensible);
        work.acceleration_rate[node] =
            carried(place.0, place.1, segment.field(qdd, pack), segment.is_extensible);
    }
    let mut end = base;
    for pack in 0..segment.packs {
        let node = segment.first_pack + pack;
        let row = segment.row(&segment.from_base, pack);
        let velocity = weighted_sum(base.velocity.splat(), row, &work.rate[nodes.clone()]);
        work.velocity[node] = velocity;
        work.acceleration_rate[node] += velocity.bracket(work.rate[node]);
        end.velocity += (work.rate[node] * segment.weights[pack]).sum();
        end.acceleration += (work.acceleration_rate[node] * segment.weights[pack]).sum();
    }
    for pack in 0..segment.packs {
        let node = segment.first_pack + pack;
        let row = segment.row(&segment.from_base, pack);
        let acceleration =
            weighted_sum(base.acceleration.splat(), row, &work.acceleration_rate[nodes.clone()]);
        let inertia = inertia::of_nodes(segment, work, pack);
        let velocity = work.velocity[node];
        let momentum = inertia.momentum(velocity);
        work.acceleration[node] = acceleration;
        work.momentum[node] = momentum;
        work.force[node] = inertia.momentum(acceleration) - velocity.bracket_transposed(momentum);
    }
    let next = &mut work.stations[s + 1];
    next.velocity = end.velocity;
    next.acceleration = end.acceleration;
}

/// Wrench that the tip's mass needs, less the dead loads.
#[inline(always)]
fn tip_wrench(plan: &Plan, work: &Workspace) -> Wrench<f64> {
    let mut wrench = Wrench::zero();
    let tip = &work.stations[plan.segments.len()];
    if plan.has_tip_load {
        let moment = tip.position.cross(plan.tip_force) + plan.tip_moment;
        wrench = wrench - Wrench { moment, force: plan.tip_force };
    }
    if plan.tip_mass > 0.0 {
        let inertia = inertia::of_tip(plan, work);
        let momentum = inertia.momentum(tip.velocity);
        wrench += inertia.momentum(tip.acceleration) - tip.velocity.bracket_transposed(momentum);
    }
    wrench
}

/// Internal wrench at the nodes, from that at the segment's end; returns that at its base.
#[inline(always)]
fn sweep_back(segment: &SegmentPlan, work: &mut Workspace, end: Wrench<f64>) -> Wrench<f64> {
    let nodes = segment.node_packs();
    let mut total = Wrench::zero();
    for pack in 0..segment.packs {
        let node = segment.first_pack + pack;
        let row = segment.row(&segment.to_end, pack);
        work.internal[node] = weighted_sum(end.splat(), row, &work.force[nodes.clone()]);
        total += work.force[node] * segment.weights[pack];
    }
    end + total.sum()
}

/// `tau = Q + K q + D qd` of the state that was last given to [`update`].
#[inline(always)]
pub(super) fn project(plan: &Plan, work: &Workspace, q: &[f64], qd: &[f64], tau: &mut [f64]) {
    for segment in &plan.segments {
        let range = segment.first..segment.first + segment.n;
        tau[range].fill(0.0);
        for pack in 0..segment.packs {
            let node = segment.first_pack + pack;
            let rotation = &work.rotation[node];
            let Wrench { moment, force } = work.internal[node];
            let moment = rotation.apply_transposed(moment - work.position[node].cross(force));
            let force = rotation.apply_transposed(force);
            let wrench = [moment.x, moment.y, moment.z, force.x, force.y, force.z];
            for component in &segment.components {
                for k in 0..component.modes {
                    let product = segment.weighted_basis[k * segment.packs + pack] * wrench[component.strain];
                    tau[component.first + k] += product.sum();
                }
            }
        }
        for component in &segment.components {
            let mu = segment.retardation_time;
            for j in 0..component.modes {
                let mut sum = 0.0;
                for k in 0..component.modes {
                    let index = component.first + k;
                    sum += component.stiffness[(j, k)] * (q[index] + mu * qd[index]);
                }
                tau[component.first + j] += sum;
            }
        }
    }
}
