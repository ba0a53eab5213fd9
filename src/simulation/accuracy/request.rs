//! The requested accuracy.

use crate::error::{Checker, InvalidInput, Number};

/// Range of the requested accuracy. Rounding errors of a run are about a hundredth of the smallest one;
/// beyond the largest one the estimate is meaningless.
const SMALLEST_RTOL: f64 = 1e-11;
const LARGEST_RTOL: f64 = 0.1;

/// Default accuracy.
pub const DEFAULT_RTOL: f64 = 1e-4;

/// Default limit of steps per run: some minutes of work, so that every request terminates.
pub const DEFAULT_MAX_STEPS: usize = 1_000_000;

/// A requested accuracy.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Request {
    /// Largest error of the tip, relative to the length of the model; in [1e-11, 0.1].
    pub rtol: f64,
    /// Interval of the output times if none are given.
    pub dt: f64,
    /// Largest number of accepted steps of each of the runs.
    pub max_steps: usize,
    /// Largest step of all runs, in seconds, for loads that act at unknown times. Default: infinite.
    pub max_step: f64,
    /// Whether the error by the numbers of modes and nodes counts.
    pub space_error: bool,
}

impl Request {
    /// A request with the default limit of steps.
    pub fn new(rtol: f64, dt: f64) -> Self {
        Self { rtol, dt, max_steps: DEFAULT_MAX_STEPS, max_step: f64::INFINITY, space_error: true }
    }

    /// Rejects accuracies outside the valid range.
    pub fn validate(&self) -> Result<(), InvalidInput> {
        let mut checker = Checker::new();
        let range = SMALLEST_RTOL..=LARGEST_RTOL;
        let expected = "a number in [1e-11, 0.1]: the error of the tip relative to the model's length";
        checker.require(range.contains(&self.rtol), "rtol", Number(self.rtol), expected);
        checker.require(self.max_step > 0.0, "max_step", Number(self.max_step), "a number > 0");
        checker.finish()
    }
}
