//! Time dependence of models.

use crate::error::Interrupted;
use crate::signal::{Cell, Jumps};

/// Explicit time dependence of a model, through varying loads or a moving base. The defaults are for models
/// without time dependence.
pub trait InTime {
    /// Sets the time, in seconds, at which varying loads and a moving base are evaluated. Fails if a
    /// user-defined function of time fails.
    fn set_time(&mut self, _t: f64) -> Result<(), Interrupted> {
        Ok(())
    }

    /// Sets u. If the model varies in time, the time must be set again before any evaluation.
    fn set_inputs(&mut self, _u: &[f64]) {}

    /// Latest end of a step from `t` that cannot miss a feature of the excitation: adaptive methods end a
    /// step there. Infinite without excitation, or if nothing is known about it.
    fn horizon(&self, _t: f64) -> f64 {
        f64::INFINITY
    }

    /// The next time at which a step of fixed size must end, because the excitation has a corner there that the
    /// step would not resolve.
    fn corner(&self, _cell: Cell) -> Option<f64> {
        None
    }

    /// From now on, the model moves in steps of the fixed size `dt` in seconds, or of sizes of their own if that is zero. Edges of
    /// tables that are narrower than the rounding of the times of such steps count as jumps.
    fn set_steps(&mut self, _dt: f64) {}

    /// What prescribed motions, loads and commands may let jump at some time.
    fn jumps(&self) -> Jumps {
        Jumps::Nothing
    }

    /// The time at which a prescribed velocity or acceleration, a load or a command jumps, if that is `t`, but for rounding. Until
    /// [`Self::pass_jump`] is called, models evaluated at that time have those before the jump.
    fn jump_near(&self, _t: f64) -> Option<f64> {
        None
    }

    /// Like [`Self::set_time`], with the change of prescribed velocities at this time added to prescribed
    /// accelerations.
    fn set_time_in_jump(&mut self, t: f64) -> Result<(), Interrupted> {
        self.set_time(t)
    }

    /// From now on, what jumps at this time, but for rounding, is as it is after the jump.
    fn pass_jump(&mut self, _t: f64) {}

    /// Name of a part of the model that is not finite at the time last set; `None` if all parts are finite.
    fn not_finite(&self) -> Option<String> {
        None
    }
}
