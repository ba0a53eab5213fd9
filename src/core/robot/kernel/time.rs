//! Evaluation of time-dependent quantities: the base, the world seen from it, and varying loads.

use crate::description::signal::StepContext;
use crate::description::world::base_motion::Base;
use crate::error::Interrupted;
use crate::robot::effects::load::plan as load;
use crate::robot::plan::Plan;
use crate::robot::state::surroundings::Surroundings;
use crate::robot::state::{Workspace, surroundings};
use crate::robot::turning::Turning;

/// Moves a rod without base motion to the pose of another base, at rest.
pub(crate) fn place<G: Turning>(plan: &Plan<G>, work: &mut Workspace<G>, base: &Base) {
    work.motion_is_known = false;
    set_base(plan, work, base.at_rest());
}

fn set_base<G: Turning>(plan: &Plan<G>, work: &mut Workspace<G>, base: Base) {
    work.surroundings = Surroundings::new(&plan.world, plan.frame, base);
    for (anchor, seen) in work.effects.anchors.iter_mut().zip(surroundings::anchors_in_base(plan, &base)) {
        *anchor = seen;
    }
    let world_points = &mut work.effects.actuation.world_points;
    for (point, seen) in world_points.iter_mut().zip(surroundings::points_in_base(plan, &base)) {
        *point = seen;
    }
    for (ends, seen) in work.effects.loops.world_ends.iter_mut().zip(surroundings::ends_in_base(plan, &base))
    {
        *ends = seen;
    }
}

/// Evaluates base and loads at the time `t`. If a function of time fails, no time is set.
pub(crate) fn set<G: Turning>(plan: &Plan<G>, work: &mut Workspace<G>, t: f64) -> Result<(), Interrupted> {
    work.time = f64::NAN;
    work.motion_is_known = false;
    if let Some(motion) = &plan.world.motion {
        move_base(plan, work, motion.at(t, work.step_context)?);
    }
    command(plan, work, t, |_| true)?;
    work.time = t;
    Ok(())
}

fn move_base<G: Turning>(plan: &Plan<G>, work: &mut Workspace<G>, base: Base) {
    set_base(plan, work, base);
    let base = &mut work.stations[0];
    (base.velocity, base.acceleration) = work.surroundings.motion(&plan.world, plan.frame);
}

/// The same with the change of the velocity of the base at this time added to its acceleration. This is not the
/// state at this time, which must be set again.
pub(crate) fn set_in_jump<G: Turning>(
    plan: &Plan<G>,
    work: &mut Workspace<G>,
    t: f64,
) -> Result<(), Interrupted> {
    set(plan, work, t)?;
    work.time = f64::NAN;
    if let Some(motion) = &plan.world.motion {
        let [before, after] =
            [f64::NAN, t].map(|passed| motion.at(t, StepContext { passed, ..StepContext::EXACT }));
        let (before, after) = (before?, after?);
        let acceleration = before.acceleration + (after.velocity - before.velocity);
        let angular_acceleration =
            before.angular_acceleration + (after.angular_velocity - before.angular_velocity);
        move_base(plan, work, Base { acceleration, angular_acceleration, ..before });
    }
    Ok(())
}

/// From now on, functions that jump at `t` have their values after the jump.
pub(crate) fn pass_jump<G: Turning>(work: &mut Workspace<G>, t: f64) {
    (work.step_context.passed, work.time) = (t, f64::NAN);
    work.motion_is_known = false;
}

/// From now on, tables are evaluated for steps of the size `dt`; see [`StepContext`].
pub(crate) fn set_steps<G: Turning>(work: &mut Workspace<G>, dt: f64) {
    work.step_context = StepContext { dt, ..StepContext::EXACT };
    work.time = f64::NAN;
    work.motion_is_known = false;
}

/// From now on, velocities of the base are means over this many seconds; see [`StepContext`].
pub(crate) fn mean_rates_over<G: Turning>(work: &mut Workspace<G>, seconds: f64) {
    (work.step_context.mean_over, work.time) = (seconds, f64::NAN);
}

/// From now on, loads are those of earlier times by `lag` seconds.
pub(crate) fn lag_loads<G: Turning>(work: &mut Workspace<G>, lag: f64) {
    (work.lag, work.time) = (lag, f64::NAN);
}

/// Computes the rates of commanded lengths of inextensible tendons, at the time that is set. If a function of
/// time fails, its rates count as zero; the same failure occurs when the next time is set.
pub(crate) fn find_command_rates<G: Turning>(plan: &Plan<G>, work: &mut Workspace<G>) {
    for &i in &plan.effects.loops.lengths {
        let rates = plan.effects.actuation.actuators[i].command.rates(work.time, work.step_context);
        work.effects.actuation.command_rates[i] = rates.map_or([0.0; 2], |[[rate], [bend]]| [rate, bend]);
    }
}

/// Sets the inputs. Quantities that depend on time are invalid until a time is set again.
pub(crate) fn set_inputs<G: Turning>(plan: &Plan<G>, work: &mut Workspace<G>, inputs: &[f64]) {
    work.inputs.copy_from_slice(inputs);
    work.time = f64::NAN;
    work.motion_is_known = false;
    set_constant_commands(plan, work);
}

/// Sets the constant commands of loads and actuators.
pub(crate) fn set_constant_commands<G: Turning>(plan: &Plan<G>, work: &mut Workspace<G>) {
    let set = command(plan, work, f64::NAN, |varies_in_time| !varies_in_time);
    debug_assert!(set.is_ok(), "only functions of time can fail");
}

/// Sets the commands of loads and actuators at a time: either the varying ones, or the constant ones.
fn command<G: Turning>(
    plan: &Plan<G>,
    work: &mut Workspace<G>,
    t: f64,
    is_meant: impl Fn(bool) -> bool,
) -> Result<(), Interrupted> {
    let loads = plan.effects.loads.iter().zip(&mut work.effects.acting);
    for (load, acting) in loads.filter(|(load, _)| is_meant(load.varies_in_time)) {
        if let Some([force, moment]) = &load.signals {
            let seen = t - work.lag;
            let now = [
                force.at(seen, work.step_context, &work.inputs)?,
                moment.at(seen, work.step_context, &work.inputs)?,
            ];
            *acting = load::wrench(now, load.frame, plan.frame, &work.surroundings.base.rotation);
        }
    }
    let state = &mut work.effects.actuation;
    for (i, actuator) in plan.effects.actuation.actuators.iter().enumerate() {
        if is_meant(actuator.command.varies_in_time()) {
            // The length of an inextensible tendon must not jump.
            let step_context =
                if plan.effects.loops.lengths.contains(&i) { StepContext::EXACT } else { work.step_context };
            [state.commands[i]] = actuator.command.at(t, step_context, &work.inputs)?;
        }
        let sliding = actuator.friction.as_ref().and_then(|friction| friction.sliding.as_ref());
        if let Some(sliding) = sliding.filter(|sliding| is_meant(sliding.varies_in_time())) {
            [state.slidings[i].commanded] = sliding.at(t, work.step_context, &work.inputs)?;
        }
    }
    Ok(())
}
