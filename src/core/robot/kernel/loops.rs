//! Gaps of closed loops and inextensible tendons, and their derivatives.

use crate::numerics::lie::{Sweep, Twist, Vector};
use crate::numerics::linalg::Matrix;
use crate::robot::algebra::tie::{Frame, Motion};
use crate::robot::effects::actuator::force as actuation;
use crate::robot::effects::actuator::state::ActuationTangent;
use crate::robot::effects::loops::force::{constraint_wrench, frames};
use crate::robot::effects::loops::plan::TiePlan;
use crate::robot::effects::loops::state::LoopTangent;
use crate::robot::plan::Plan;
use crate::robot::state::Workspace;
use crate::robot::turning::{Turning, columns};

/// Writes g(q, t), with the kinematics up to date, and also the motion if there are inextensible tendons.
pub(crate) fn values<G: Turning>(plan: &Plan<G>, work: &Workspace<G>, q: &[f64], values: &mut [f64]) {
    for tie in &plan.effects.loops.ties {
        let frames = frames(plan, work, tie);
        for (value, row) in values[tie.first..].iter_mut().zip(&tie.rows) {
            *value = row.value(&frames);
        }
    }
    of_gears(plan, values, |[first, second], ratio, offset| q[first] - ratio * q[second] - offset);
    let state = &work.effects.actuation;
    of_lengths(plan, work, values, |i| state.lengths[i] - state.commands[i]);
}

/// 1 minus the cosine of the angle between directions that a tie aligns, if the angle exceeds a right angle, beyond which gaps of
/// angles fall again; with the kinematics up to date.
pub(crate) fn turned_away<G: Turning>(
    plan: &Plan<G>,
    work: &Workspace<G>,
    tie: &TiePlan<G::Pack>,
) -> Option<f64> {
    let [first, second] = frames(plan, work, tie);
    let cosines = tie.shared.iter().map(|&shared| first.axes.apply(shared).dot(second.axes.apply(shared)));
    cosines.reduce(f64::min).filter(|cosine| *cosine < 0.0).map(|cosine| 1.0 - cosine)
}

/// Zero for slack tendons.
fn of_lengths<G: Turning>(
    plan: &Plan<G>,
    work: &Workspace<G>,
    values: &mut [f64],
    of: impl Fn(usize) -> f64,
) {
    let of_tendons = plan.effects.loops.lengths.iter().zip(&work.effects.loops.slack);
    for (value, (&i, &is_slack)) in values[plan.effects.loops.first_length()..].iter_mut().zip(of_tendons) {
        *value = if is_slack { 0.0 } else { of(i) };
    }
}

fn of_gears<G: Turning>(plan: &Plan<G>, values: &mut [f64], of: impl Fn([usize; 2], f64, f64) -> f64) {
    let first = plan.effects.loops.first_gear();
    for (value, gear) in values[first..].iter_mut().zip(&plan.effects.loops.gears) {
        *value = of(gear.coordinates, gear.ratio, gear.offset);
    }
}

/// Velocities of the ends of a tie, with the motion up to date, in the frame that follows the base with the
/// velocity of its point. In this frame the world moves without acceleration.
fn velocities<G: Turning>(
    plan: &Plan<G>,
    work: &Workspace<G>,
    tie: &TiePlan<G::Pack>,
    frames: &[Frame; 2],
) -> [Motion; 2] {
    std::array::from_fn(|e| {
        let Some(on) = &tie.ends[e].on else {
            return [Vector::zero(), work.effects.loops.world_ends[tie.number][e].velocity];
        };
        at(plan, work.points[on.point].velocity, frames[e].position)
    })
}

/// Angular part of a twist, and the velocity of the body's point at a position.
#[inline(always)]
fn at<G: Turning>(plan: &Plan<G>, twist: Twist<G, f64>, position: Vector<f64>) -> Motion {
    let angular = G::axial_in_space(plan.frame, twist.angular);
    [angular, G::in_space(plan.frame, twist.linear) + angular.cross(position)]
}

/// Moment about the second end of a tie, and force there, in the equations of motion, with the kinematics up
/// to date.
pub(crate) fn wrench<G: Turning>(
    plan: &Plan<G>,
    work: &Workspace<G>,
    tie: usize,
    multipliers: &[f64],
) -> Motion {
    let tie = &plan.effects.loops.ties[tie];
    constraint_wrench(tie, &frames(plan, work, tie), multipliers)
}

/// Writes dg/dt, with the motion up to date.
pub(crate) fn rates<G: Turning>(plan: &Plan<G>, work: &Workspace<G>, rates: &mut [f64]) {
    for tie in &plan.effects.loops.ties {
        let frames = frames(plan, work, tie);
        let velocities = velocities(plan, work, tie, &frames);
        for (rate, row) in rates[tie.first..].iter_mut().zip(&tie.rows) {
            *rate = row.rate(&frames, &velocities);
        }
    }
    let qd = &work.motion_of[plan.n..2 * plan.n];
    of_gears(plan, rates, |[first, second], ratio, _| qd[first] - ratio * qd[second]);
    let state = &work.effects.actuation;
    of_lengths(plan, work, rates, |i| state.rates[i] - state.command_rates[i][0]);
}

/// Writes d2g/dt2, with the motion and the motion of straight tendon parts up to date. Points of bodies
/// accelerate by `a + w' x p + w x (v + w x p)` (see `acceleration`).
pub(crate) fn accelerations<G: Turning>(
    plan: &Plan<G>,
    work: &Workspace<G>,
    memory: &mut ActuationTangent<G::Pack>,
    values: &mut [f64],
) {
    let gravity = G::in_space(plan.frame, work.surroundings.gravity);
    for tie in &plan.effects.loops.ties {
        let frames = frames(plan, work, tie);
        let velocities = velocities(plan, work, tie, &frames);
        let accelerations: [Motion; 2] = std::array::from_fn(|e| {
            let Some(on) = &tie.ends[e].on else { return [Vector::zero(); 2] };
            let [angular, linear] = at(plan, work.points[on.point].acceleration, frames[e].position);
            let [turning, velocity] = velocities[e];
            [angular, linear + gravity + turning.cross(velocity)]
        });
        for (value, row) in values[tie.first..].iter_mut().zip(&tie.rows) {
            *value = row.acceleration(&frames, &velocities, &accelerations);
        }
    }
    let qdd = &work.motion_of[2 * plan.n..];
    of_gears(plan, values, |[first, second], ratio, _| qdd[first] - ratio * qdd[second]);
    let of_tendons = plan.effects.loops.lengths.iter().zip(&work.effects.loops.slack);
    for (row, (&i, &is_slack)) in of_tendons.enumerate() {
        values[plan.effects.loops.first_length() + row] = match is_slack {
            true => 0.0,
            false => {
                actuation::acceleration(plan, work, memory, i) - work.effects.actuation.command_rates[i][1]
            }
        };
    }
}

/// Computes the motion of the ends of all ties with the coordinates, with the kinematics up to date, if
/// necessary.
pub(crate) fn find<G: Turning>(plan: &Plan<G>, work: &Workspace<G>, memory: &mut LoopTangent) {
    if !plan.effects.loops.ties.is_empty() && memory.moved_of != work.kinematics_of {
        memory.moved_of.copy_from_slice(&work.kinematics_of);
        plan.instructions.run_outlined::<G::Pack, _>(Find { plan, work, moved: &mut memory.moved });
    }
}

struct Find<'a, G: Turning> {
    plan: &'a Plan<G>,
    work: &'a Workspace<G>,
    moved: &'a mut [[Motion; 2]],
}

impl<G: Turning> Sweep for Find<'_, G> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Self { plan, work, moved } = self;
        moved.fill([[Vector::zero(); 2]; 2]);
        for (tie, moved) in plan.effects.loops.ties.iter().zip(moved.chunks_exact_mut(plan.n.max(1))) {
            let frames = frames(plan, work, tie);
            for (e, end) in tie.ends.iter().enumerate() {
                let Some(on) = &end.on else { continue };
                columns::visit(plan, work, columns::each(&on.moved_by), |k, [psi, _]| {
                    moved[k][e] = at(plan, psi, frames[e].position);
                });
            }
        }
    }
}

/// Writes G = dg/dq, rows x n, with the kinematics and the motion of the ends of ties up to date; for
/// inextensible tendons also the motion, and the motion of their straight parts.
pub(crate) fn jacobian<G: Turning>(
    plan: &Plan<G>,
    work: &Workspace<G>,
    memory: &LoopTangent,
    of_actuators: &mut ActuationTangent<G::Pack>,
    jacobian: &mut Matrix,
) {
    jacobian.fill(0.0);
    for (i, tie) in plan.effects.loops.ties.iter().enumerate() {
        let frames = frames(plan, work, tie);
        let moved = &memory.moved[i * plan.n..][..plan.n];
        for (r, row) in tie.rows.iter().enumerate() {
            for &k in &tie.reaches {
                jacobian[(tie.first + r, k)] = row.rate(&frames, &moved[k]);
            }
        }
    }
    let first = plan.effects.loops.first_gear();
    for (r, gear) in plan.effects.loops.gears.iter().enumerate() {
        jacobian[(first + r, gear.coordinates[0])] = 1.0;
        jacobian[(first + r, gear.coordinates[1])] = -gear.ratio;
    }
    let of_tendons = plan.effects.loops.lengths.iter().zip(&work.effects.loops.slack);
    for (row, (&i, &is_slack)) in of_tendons.enumerate() {
        if !is_slack {
            let gradient = actuation::gradient(plan, work, of_actuators, i);
            for (k, &of_k) in gradient.iter().enumerate() {
                jacobian[(plan.effects.loops.first_length() + row, k)] = of_k;
            }
        }
    }
}
