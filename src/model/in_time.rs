//! Time dependence of models.

use crate::error::Interrupted;

/// How a model depends on time by itself: through loads that vary, or a base that is moved. One that does not has
/// nothing to say.
pub trait InTime {
    /// True where something of the model depends on time by itself, so that [`Self::set_time`] has to be called
    /// before anything is evaluated.
    fn varies_in_time(&self) -> bool {
        false
    }

    /// The time, in seconds, at which what depends on it by itself (loads that vary, a base that is moved) is
    /// evaluated from now on. Fails where a function of time that somebody else provides does.
    fn set_time(&mut self, _t: f64) -> Result<(), Interrupted> {
        Ok(())
    }

    /// How many numbers are set from outside: u.
    fn inputs(&self) -> usize {
        0
    }

    /// Their default values.
    fn default_inputs(&self) -> Vec<f64> {
        Vec::new()
    }

    /// From now on these are u. Before anything is evaluated, a time has to be set again where something varies in it.
    fn set_inputs(&mut self, _u: &[f64]) {}

    /// The times, in seconds, between which the model is known; beyond, what depends on time by itself is NaN.
    fn time_span(&self) -> [f64; 2] {
        [f64::NEG_INFINITY, f64::INFINITY]
    }

    /// How far in time a step from `t` may go that cannot pass unseen over something that drives the system: adaptive
    /// methods end a step there. Infinite where nothing does, or nothing is known of it.
    fn horizon(&self, _t: f64) -> f64 {
        f64::INFINITY
    }

    /// The shortest period of what drives the system, in seconds.
    fn shortest_period(&self) -> f64 {
        f64::INFINITY
    }

    /// What of the model is not finite at the time that is set, in words, so that nothing follows from it; `None`
    /// where all is.
    fn not_finite(&self) -> Option<String> {
        None
    }
}
