//! Step-size control of the explicit methods, from the error estimates of the last steps.

use super::options::Controller;
use crate::numerics::tape::Tape;

/// Safety factor of the predicted step size (SciPy; Hairer, Norsett and Wanner 1993, section II.4).
const SAFETY: f64 = 0.9;
/// Smallest ratio of successive step sizes (ibid.).
const SMALLEST_FACTOR: f64 = 0.2;
/// Largest ratio of successive step sizes (ibid.).
const LARGEST_FACTOR: f64 = 10.0;
/// Exponent of the previous error in the proportional-integral controller (code DOPRI5).
const BETA: f64 = 0.04;
/// Fraction of beta subtracted from the elementary controller's exponent of the last error (code DOPRI5).
const BETA_SHARE: f64 = 0.75;
/// Initial value and lower bound of the previous error: an unusually small error must not shrink the next
/// step (code DOPRI5).
const SMALLEST_PREVIOUS_ERROR: f64 = 1e-4;

/// State of the controller. Errors are relative to the tolerance: a step is accepted below 1.
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

    /// Serialises the state.
    pub(super) fn serialise(&mut self, tape: &mut Tape<'_>) {
        tape.number(&mut self.previous_error);
    }

    /// Factor of the step size after an accepted step; no growth right after a rejection.
    pub(super) fn after_acceptance(&mut self, error: f64, was_rejected: bool) -> f64 {
        let mut factor = SAFETY * error.powf(-self.alpha);
        if self.beta > 0.0 {
            factor *= self.previous_error.powf(self.beta);
            self.previous_error = error.max(SMALLEST_PREVIOUS_ERROR);
        }
        // The elementary controller needs no lower bound: for error < 1 the factor is at least SAFETY.
        let factor = factor.min(LARGEST_FACTOR);
        if was_rejected { factor.min(1.0) } else { factor }
    }

    /// Factor of the step size after a rejected step, whose error may be NaN.
    pub(super) fn after_rejection(&self, error: f64) -> f64 {
        (SAFETY * error.powf(-self.alpha)).max(SMALLEST_FACTOR)
    }
}
