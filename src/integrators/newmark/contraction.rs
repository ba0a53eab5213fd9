//! Convergence rate of Newton's method with an old Jacobian.

use crate::numerics::tape::Tape;

/// Safety factor of predicted rates.
const SAFETY_FACTOR: f64 = 2.0;

/// Fastest decrease of the factor between distance and rate from one measurement to the next: it depends on the direction of the motion.
const FASTEST_DECREASE: f64 = 0.9;

/// Maximum number of successive steps that rely on a prediction before the rate is measured again.
const STEPS_WITHOUT_MEASUREMENT: u32 = 16;

/// Smallest rate that is predicted or trusted: below, errors of a differenced Jacobian and rounding dominate.
const SMALLEST_RATE: f64 = 1e-6;

/// Measurements of the contraction rate. The rate is proportional to the distance of the state from the one where the Jacobian was
/// evaluated; iterations measure the factor (the Lipschitz constant of Newton-Kantorovich theory; Deuflhard 2011, section 2.1). A
/// wrong Jacobian shows as a factor that is too large to predict convergence.
#[derive(Clone, Copy, Debug)]
pub(super) struct Contraction {
    /// Upper bound of the factor, which decides whether an iteration has converged.
    cautious: f64,
    /// The factor measured last, which decides whether an iteration is worth trying.
    hopeful: f64,
    unmeasured_steps: u32,
}

impl Contraction {
    /// No measurements: every rate must be measured.
    pub(super) fn unknown() -> Self {
        Self { cautious: f64::INFINITY, hopeful: 0.0, unmeasured_steps: 0 }
    }

    /// Upper bound of the rate at a distance, to end an iteration; infinite if the rate must be measured.
    pub(super) fn bound(&self, distance: f64) -> f64 {
        if self.cautious.is_infinite() || self.unmeasured_steps >= STEPS_WITHOUT_MEASUREMENT {
            return f64::INFINITY;
        }
        (SAFETY_FACTOR * self.cautious * distance).max(SMALLEST_RATE)
    }

    /// The expected rate at a distance.
    pub(super) fn expect(&self, distance: f64) -> f64 {
        (self.hopeful * distance).max(SMALLEST_RATE)
    }

    /// Updates the factors by a rate measured at a distance. A rate that may be due to rounding is only an upper bound.
    pub(super) fn measured(&mut self, rate: f64, distance: f64, is_bound: bool) {
        self.unmeasured_steps = 0;
        if is_bound || rate <= SMALLEST_RATE {
            let upper = rate.max(SMALLEST_RATE) / distance;
            self.cautious = self.cautious.min(upper);
            self.hopeful = self.hopeful.min(upper);
        } else {
            self.hopeful = rate / distance;
            let memory = if self.cautious.is_finite() { FASTEST_DECREASE * self.cautious } else { 0.0 };
            self.cautious = self.hopeful.max(memory);
        }
    }

    /// Requires a new measurement: the system has changed in a way that the distance does not show.
    pub(super) fn doubt(&mut self) {
        self.unmeasured_steps = STEPS_WITHOUT_MEASUREMENT;
    }

    /// Writes or reads the measurements.
    pub(super) fn serialise(&mut self, tape: &mut Tape<'_>) {
        tape.number(&mut self.cautious);
        tape.number(&mut self.hopeful);
        tape.small_count(&mut self.unmeasured_steps);
    }

    /// Counts a step without a measurement.
    pub(super) fn not_measured(&mut self) {
        self.unmeasured_steps += 1;
    }
}
