//! Time-dependent quantities at an instant: the base, loads and inputs.

use super::Sweeps;
use crate::description::world::base_motion::Base;
use crate::error::Interrupted;
use crate::numerics::lie::{VectorSpace, Wrench};
use crate::robot::kernel::time;
use crate::robot::turning::Turning;

impl<G: Turning> Sweeps<G> {
    /// Evaluates everything that varies in time at this time.
    pub(crate) fn set_time(&mut self, t: f64) -> Result<(), Interrupted> {
        if self.plan.varies_in_time && self.work.time != t {
            time::set(&self.plan, &mut self.work, t)?;
        }
        Ok(())
    }

    /// Sets the time with the change of the velocity of the base added to its acceleration.
    pub(crate) fn set_time_in_jump(&mut self, t: f64) -> Result<(), Interrupted> {
        if self.plan.varies_in_time { time::set_in_jump(&self.plan, &mut self.work, t) } else { Ok(()) }
    }

    /// From now on, tables are evaluated for steps of the size `dt`; see [`StepContext`](crate::description::signal::StepContext).
    pub(crate) fn set_steps(&mut self, dt: f64) {
        time::set_steps(&mut self.work, dt);
    }

    /// From now on, functions that jump at `t` have their values after the jump.
    pub(crate) fn pass_jump(&mut self, t: f64) {
        time::pass_jump(&mut self.work, t);
    }

    /// From now on, velocities of the base are means over this many seconds.
    pub(crate) fn mean_rates_over(&mut self, seconds: f64) {
        if self.plan.world.motion.is_some() {
            time::mean_rates_over(&mut self.work, seconds);
        }
    }

    /// From now on, loads are those of earlier times by `lag` seconds; false if none varies in time.
    pub(crate) fn lag_loads(&mut self, lag: f64) -> bool {
        let vary = self.plan.effects.loads.iter().any(|load| load.varies_in_time);
        if vary {
            time::lag_loads(&mut self.work, lag);
        }
        vary
    }

    /// Appends place, velocity and acceleration of a moving base, direction by direction.
    pub(crate) fn prescribed(&self, to: &mut Vec<[f64; 3]>) {
        if self.plan.world.motion.is_some() {
            to.extend(self.work.surroundings.base.shifts());
        }
    }

    /// Sets the inputs.
    pub(crate) fn set_inputs(&mut self, inputs: &[f64]) {
        if !inputs.is_empty() {
            time::set_inputs(&self.plan, &mut self.work, inputs);
        }
    }

    /// The time that is set, if a load or a command is not finite at this time; NaN if no time could be set.
    pub(crate) fn time_without_loads(&self) -> Option<f64> {
        let is_finite = |wrench: &Wrench<G, f64>| {
            (wrench.force.dot(wrench.force) + wrench.moment.dot(wrench.moment)).is_finite()
        };
        let is_known = self.work.effects.acting.iter().all(is_finite)
            && self.work.effects.actuation.commands.iter().all(|command| command.is_finite());
        (!is_known).then_some(self.work.time)
    }

    /// The base at the time that is set.
    pub(crate) fn base(&self) -> Base {
        self.work.surroundings.base
    }

    /// Sets the pose of a rod's base without base motion.
    pub(crate) fn place_base(&mut self, base: &Base) {
        time::place(&self.plan, &mut self.work, base);
    }
}
