//! Time dependence of models.

use super::Dynamics;
use crate::description::signal::{Cell, Jumps};
use crate::error::Interrupted;
use crate::numerics::linalg::Matrix;

/// Explicit time dependence of a model, through varying loads or a moving base, and its inputs.
pub trait InTime: Dynamics {
    /// Sets the time, in seconds, at which varying loads and a moving base are evaluated. Fails if a
    /// user-defined function of time fails.
    fn set_time(&mut self, t: f64) -> Result<(), Interrupted>;

    /// Sets u. If the model varies in time, the time must be set again before any evaluation.
    fn set_inputs(&mut self, u: &[f64]);

    /// Name of a part of the model that is not finite at the time last set; `None` if all parts are finite.
    fn not_finite(&self) -> Option<String>;

    /// The derivative of `tau` with respect to the inputs, n x m, exact.
    fn input_tangent(&mut self, q: &[f64], qd: &[f64], qdd: &[f64], tangent: &mut Matrix);
}

/// Corners and jumps of the functions of time that drive a model: prescribed motions, loads and commands.
pub trait Excitation: InTime {
    /// Latest end of a step from `t` that cannot miss a feature of the excitation: adaptive methods end a
    /// step there. Infinite without excitation, or if nothing is known about it.
    fn horizon(&self, t: f64) -> f64;

    /// From now on, adaptive methods also end steps at these increasing times, for jumps that functions of time do not declare.
    fn end_steps_at(&mut self, times: &[f64]);

    /// The next time at which a step of fixed size must end, because the excitation has a corner there that the
    /// step would not resolve.
    fn corner(&self, cell: Cell) -> Option<f64>;

    /// From now on, the model moves in steps of the fixed size `dt` in seconds, or of sizes of their own if that is zero. Edges of
    /// tables that are narrower than the rounding of the times of such steps count as jumps.
    fn set_steps(&mut self, dt: f64);

    /// Which quantities prescribed motions, loads and commands may make jump at some time.
    fn jumps(&self) -> Jumps;

    /// The time at which a prescribed velocity or acceleration, a load or a command jumps, if that is `t` up to rounding. Until
    /// [`Self::pass_jump`] is called, evaluations at that time use the values before the jump.
    fn jump_near(&self, t: f64) -> Option<f64>;

    /// Like [`InTime::set_time`], with the change of prescribed velocities at this time added to prescribed
    /// accelerations.
    fn set_time_in_jump(&mut self, t: f64) -> Result<(), Interrupted>;

    /// From now on, functions that jump at this time, up to rounding, have their values after the jump.
    fn pass_jump(&mut self, t: f64);

    /// A motion starts at this time: accelerations of functions that jump here are those after the jump. Tables, whose jumps are
    /// explicit, are still before theirs.
    fn start_at(&mut self, t: f64) {
        if self.jump_near(t).is_none() {
            self.pass_jump(t);
        }
    }

    /// From now on, velocities of prescribed motions are their means over this many seconds up to the time, without accelerations,
    /// like those of coordinates in quasi-static steps; zero selects instantaneous velocities.
    fn mean_rates_over(&mut self, seconds: f64);

    /// From now on, loads are those of earlier times by `lag` seconds, and everything else as before. False if no load varies in
    /// time.
    fn lag_loads(&mut self, lag: f64) -> bool;

    /// Prescribed coordinates that only shift, and prescribed coordinates of single joints, with their first two derivatives at the
    /// time that is set. Appended.
    fn prescribed(&mut self, to: &mut Vec<[f64; 3]>);
}
