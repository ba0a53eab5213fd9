//! The size of the next step of the explicit methods, from the error estimates of the last ones.

use super::options::Controller;
use crate::tape::Tape;

/// Aims at that fraction of the step size which would just do (SciPy; Hairer, Norsett and Wanner 1993, section II.4).
const SAFETY: f64 = 0.9;
/// A step is at least that times the size of the one before (ibid.).
const SMALLEST_FACTOR: f64 = 0.2;
/// A step is at most that times the size of the one before (ibid.).
const LARGEST_FACTOR: f64 = 10.0;
/// Exponent of the previous error in the proportional-integral controller (code DOPRI5).
const BETA: f64 = 0.04;
/// The exponent of the last error is that much of beta below the elementary controller's (code DOPRI5).
const BETA_SHARE: f64 = 0.75;
/// An unusually small error must not shrink the next factor; first value and lower bound of the previous error
/// (code DOPRI5).
const SMALLEST_PREVIOUS_ERROR: f64 = 1e-4;

/// Memory of the controller. Errors are relative to the tolerance: a step is accepted below 1.
#[derive(Clone, Debug)]
pub(super) struct StepControl {
    alpha: f64,
    beta: f64,
    previous_error: f64,
}

impl StepControl {
    /// For a method whose error estimate is `O(h^(error_order + 1))`.
    pub(super) fn new(controller: Controller, error_order: f64) -> Self {
        let elementary = 1.0 / (error_order + 1.0);
        let beta = match controller {
            Controller::Integral => 0.0,
            Controller::ProportionalIntegral => BETA,
        };
        Self { alpha: elementary - BETA_SHARE * beta, beta, previous_error: SMALLEST_PREVIOUS_ERROR }
    }

    /// Its memory.
    pub(super) fn carry(&mut self, tape: &mut Tape<'_>) {
        tape.number(&mut self.previous_error);
    }

    /// Factor of the step size after an accepted step; no growth right after a rejection.
    pub(super) fn after_acceptance(&mut self, error: f64, was_rejected: bool) -> f64 {
        let mut factor = SAFETY * error.powf(-self.alpha);
        if self.beta > 0.0 {
            factor *= self.previous_error.powf(self.beta);
            self.previous_error = error.max(SMALLEST_PREVIOUS_ERROR);
        }
        // Without a lower bound in the elementary controller: at error < 1 it is SAFETY.
        let factor = factor.min(LARGEST_FACTOR);
        if was_rejected { factor.min(1.0) } else { factor }
    }

    /// Factor of the step size after a rejected step, whose error may be NaN.
    pub(super) fn after_rejection(&self, error: f64) -> f64 {
        (SAFETY * error.powf(-self.alpha)).max(SMALLEST_FACTOR)
    }
}
