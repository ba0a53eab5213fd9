//! Convergence rate of Newton's method with an old Jacobian.

use crate::numerics::tape::Tape;

/// Predicted rates are taken that much larger than measured ones say.
const CAUTION: f64 = 2.0;

/// The factor between distance and rate may fall that fast from one measurement to the next: it differs with the
/// direction of the motion.
const FALL: f64 = 0.9;

/// A prediction serves that many steps in a row; then the rate is measured again.
const STEPS_WITHOUT_MEASUREMENT: u32 = 16;

/// Rates are neither predicted nor trusted below that, where errors of a differenced Jacobian and rounding begin.
const SMALLEST_RATE: f64 = 1e-6;

/// What has been learnt about the contraction rate: it grows with the distance of the state from the one where the
/// Jacobian was evaluated, by a factor (the Lipschitz constant of Newton-Kantorovich theory; Deuflhard 2011, section 2.1)
/// that iterations measure. A wrong Jacobian shows as a factor that is too large to predict any convergence.
#[derive(Clone, Copy, Debug)]
pub(super) struct Contraction {
    /// The factor as far as it is known for certain: what ends an iteration relies on it.
    cautious: f64,
    /// The factor that was measured last: what is worth a try follows from it.
    hopeful: f64,
    unmeasured_steps: u32,
}

impl Contraction {
    /// Nothing is known: every rate must be measured.
    pub(super) fn unknown() -> Self {
        Self { cautious: f64::INFINITY, hopeful: 0.0, unmeasured_steps: 0 }
    }

    /// The rate that is certain enough at a distance to end an iteration; infinite when it must be measured.
    pub(super) fn bound(&self, distance: f64) -> f64 {
        if self.cautious.is_infinite() || self.unmeasured_steps >= STEPS_WITHOUT_MEASUREMENT {
            return f64::INFINITY;
        }
        (CAUTION * self.cautious * distance).max(SMALLEST_RATE)
    }

    /// The rate that is to be expected at a distance.
    pub(super) fn expect(&self, distance: f64) -> f64 {
        (self.hopeful * distance).max(SMALLEST_RATE)
    }

    /// Learns from the rate that was measured at a distance. A rate that may owe itself to rounding is no more than an
    /// upper bound.
    pub(super) fn measured(&mut self, rate: f64, distance: f64, is_bound: bool) {
        self.unmeasured_steps = 0;
        if is_bound || rate <= SMALLEST_RATE {
            let upper = rate.max(SMALLEST_RATE) / distance;
            self.cautious = self.cautious.min(upper);
            self.hopeful = self.hopeful.min(upper);
        } else {
            self.hopeful = rate / distance;
            let memory = if self.cautious.is_finite() { FALL * self.cautious } else { 0.0 };
            self.cautious = self.hopeful.max(memory);
        }
    }

    /// The rate must be measured before it is relied on: something has changed that no distance tells of.
    pub(super) fn doubt(&mut self) {
        self.unmeasured_steps = STEPS_WITHOUT_MEASUREMENT;
    }

    /// What has been learnt.
    pub(super) fn serialise(&mut self, tape: &mut Tape<'_>) {
        tape.number(&mut self.cautious);
        tape.number(&mut self.hopeful);
        tape.small_count(&mut self.unmeasured_steps);
    }

    /// Counts a step in which nothing was measured.
    pub(super) fn not_measured(&mut self) {
        self.unmeasured_steps += 1;
    }
}
