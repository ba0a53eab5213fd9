//! Controllers of runs.

use crate::error::Interrupted;

/// A controller that sets the inputs of a model at equal intervals; inputs are constant in between.
pub struct Control<'a> {
    /// Interval in seconds; the first call is at the start of the run.
    pub step: f64,
    /// Computes the inputs from time, coordinates and velocities. The caller must ensure that they are
    /// finite.
    pub inputs: &'a mut Inputs<'a>,
}

/// Inputs as a function of time, coordinates and velocities.
pub type Inputs<'a> = dyn FnMut(f64, &[f64], &[f64], &mut [f64]) -> Result<(), Interrupted> + 'a;

impl std::fmt::Debug for Control<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Control").field("step", &self.step).finish_non_exhaustive()
    }
}
