//! One sweep out for the motion, one sweep back for the forces: `tau = Q + K q + D qd`.
//!
//! In the inertial frame the recursions along the rod are plain integrals (design: section 4):
//! V = int S qd, A = -(0; g) + int [S qdd + ad_V (S qd)], F = F_tip + int (N A - ad_V^T N V), Q_j = int S_j . F.

use super::inertia;
use super::plan::{Plan, SegmentPlan};
use super::turning::Turning;
use super::workspace::Workspace;
use crate::lie::{Cross, Pack, Twist, Wrench, weighted_sum};

/// Twist of a body-frame strain at a place: `Ad_g (angular; linear)`.
#[inline(always)]
fn carried<G: Turning>(
    rotation: &G::Rotation<Pack>,
    position: G::Vector<Pack>,
    strain: Twist<G, Pack>,
    is_extensible: bool,
) -> Twist<G, Pack> {
    let angular = G::rotate_axial(rotation, strain.angular);
    let mut linear = position.cross(angular);
    if is_extensible {
        linear += G::rotate(rotation, strain.linear);
    }
    Twist { angular, linear }
}

/// Motion and internal wrench of a state whose kinematics are up to date, unless they are there already.
#[inline(always)]
pub(super) fn update<G: Turning>(
    plan: &Plan<G>,
    work: &mut Workspace<G>,
    q: &[f64],
    qd: &[f64],
    qdd: &[f64],
) {
    let n = plan.n;
    let known = &mut work.motion_of;
    if known[..n] == *q && known[n..2 * n] == *qd && known[2 * n..] == *qdd {
        return;
    }
    known[..n].copy_from_slice(q);
    known[n..2 * n].copy_from_slice(qd);
    known[2 * n..].copy_from_slice(qdd);
    for (s, segment) in plan.segments.iter().enumerate() {
        sweep_out(plan.frame, segment, s, work, qd, qdd);
    }
    let mut end = tip_wrench(plan, work);
    for segment in plan.segments.iter().rev() {
        end = sweep_back(segment, work, end);
    }
}

#[inline(always)]
fn sweep_out<G: Turning>(
    frame: G::Frame,
    segment: &SegmentPlan<G>,
    s: usize,
    work: &mut Workspace<G>,
    qd: &[f64],
    qdd: &[f64],
) {
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
        let velocity = weighted_sum(base.velocity.splat(), row, &work.rate[nodes.clone()], Twist::broadcast);
        work.velocity[node] = velocity;
        work.acceleration_rate[node] += velocity.bracket(work.rate[node]);
        end.velocity += (work.rate[node] * segment.weights[pack]).sum();
        end.acceleration += (work.acceleration_rate[node] * segment.weights[pack]).sum();
    }
    for pack in 0..segment.packs {
        let node = segment.first_pack + pack;
        let row = segment.row(&segment.from_base, pack);
        let rates = &work.acceleration_rate[nodes.clone()];
        let acceleration = weighted_sum(base.acceleration.splat(), row, rates, Twist::broadcast);
        let inertia = inertia::of_nodes(frame, segment, work, pack);
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
fn tip_wrench<G: Turning>(plan: &Plan<G>, work: &Workspace<G>) -> Wrench<G, f64> {
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
fn sweep_back<G: Turning>(
    segment: &SegmentPlan<G>,
    work: &mut Workspace<G>,
    end: Wrench<G, f64>,
) -> Wrench<G, f64> {
    let nodes = segment.node_packs();
    let mut total = Wrench::zero();
    for pack in 0..segment.packs {
        let node = segment.first_pack + pack;
        let row = segment.row(&segment.to_end, pack);
        work.internal[node] = weighted_sum(end.splat(), row, &work.force[nodes.clone()], Wrench::broadcast);
        total += work.force[node] * segment.weights[pack];
    }
    end + total.sum()
}

/// `tau = Q + K q + D qd` of the state that was last given to [`update`].
#[inline(always)]
pub(super) fn project<G: Turning>(
    plan: &Plan<G>,
    work: &Workspace<G>,
    q: &[f64],
    qd: &[f64],
    tau: &mut [f64],
) {
    for segment in &plan.segments {
        let range = segment.first..segment.first + segment.n;
        tau[range].fill(0.0);
        for pack in 0..segment.packs {
            let node = segment.first_pack + pack;
            let rotation = &work.rotation[node];
            let Wrench { moment, force } = work.internal[node];
            let mut wrench = Wrench::<G, Pack> {
                moment: G::rotate_axial_back(rotation, moment - work.position[node].cross(force)),
                force: G::rotate_back(rotation, force),
            };
            for component in &segment.components {
                let wrench = *wrench.component_mut(component.index);
                for k in 0..component.modes {
                    let product = segment.weighted_basis[k * segment.packs + pack] * wrench;
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
