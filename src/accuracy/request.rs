//! What is asked for.

use crate::error::{Checker, InvalidInput, Number};

/// What can be asked for: rounding of a run leaves about a hundredth of the first; with the second the estimate would
/// say nothing.
const SMALLEST_RTOL: f64 = 1e-11;
const LARGEST_RTOL: f64 = 0.1;

/// What is asked for where nothing is said.
pub const DEFAULT_RTOL: f64 = 1e-4;

/// Steps of a run where nothing is said about them: some minutes of work, so that no request works without end.
pub const DEFAULT_MAX_STEPS: usize = 1_000_000;

/// What is asked for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Request {
    /// Largest error of the tip, relative to the length of the model; in [1e-11, 0.1].
    pub rtol: f64,
    /// Distance of the output times where none are asked for.
    pub dt: f64,
    /// Largest number of accepted steps of each of the runs.
    pub max_steps: usize,
    /// Largest step of all runs, in seconds: for loads that act at unknown times. Infinite unless said
    /// otherwise.
    pub max_step: f64,
}

impl Request {
    /// With the limit of steps that holds where nothing is said.
    pub fn new(rtol: f64, dt: f64) -> Self {
        Self { rtol, dt, max_steps: DEFAULT_MAX_STEPS, max_step: f64::INFINITY }
    }

    /// Refuses accuracies that cannot be asked for.
    pub fn validate(&self) -> Result<(), InvalidInput> {
        let mut checker = Checker::new();
        let range = SMALLEST_RTOL..=LARGEST_RTOL;
        let expected = "a number in [1e-11, 0.1]: the error of the tip relative to the model's length";
        checker.require(range.contains(&self.rtol), "rtol", Number(self.rtol), expected);
        checker.require(self.max_step > 0.0, "max_step", Number(self.max_step), "a number > 0");
        checker.finish()
    }
}
