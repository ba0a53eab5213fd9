//! How fast Newton's method converges with a Jacobian from elsewhere.

/// Predicted rates are taken that much larger than measured ones say.
const CAUTION: f64 = 2.0;

/// The factor between distance and rate may fall that fast from one measurement to the next, and is taken to grow that
/// fast when it is not measured, so that it is measured again every now and then.
const FALL: f64 = 0.8;
const AGEING: f64 = 1.1;

/// Rates are not predicted below that: the error of a differenced Jacobian.
const SMALLEST_RATE: f64 = 1e-7;

/// With a rate above that an iteration is not worth its price.
const SLOWEST_RATE: f64 = 0.5;

/// What has been learnt about the contraction rate: it grows with the distance of the state from the one where the
/// Jacobian was evaluated, by a factor (the Lipschitz constant of Newton-Kantorovich theory; Deuflhard 2011, section 2.1)
/// that iterations measure. A wrong Jacobian shows as a factor that is too large to predict any convergence.
#[derive(Clone, Copy, Debug)]
pub(super) struct Contraction {
    rate_by_distance: f64,
}

impl Contraction {
    /// Nothing is known: every rate must be measured.
    pub(super) fn unknown() -> Self {
        Self { rate_by_distance: f64::INFINITY }
    }

    /// The rate that is expected at a distance.
    pub(super) fn predict(&self, distance: f64) -> f64 {
        if distance == 0.0 {
            return SMALLEST_RATE;
        }
        (CAUTION * self.rate_by_distance * distance).max(SMALLEST_RATE)
    }

    /// Learns from the rate that was measured at a distance.
    pub(super) fn measured(&mut self, rate: f64, distance: f64) {
        let found = rate / distance;
        if self.rate_by_distance.is_finite() {
            self.rate_by_distance = found.max(FALL * self.rate_by_distance);
        } else if !found.is_nan() {
            self.rate_by_distance = found;
        }
    }

    /// Grows older by a step in which nothing was measured.
    pub(super) fn age(&mut self) {
        self.rate_by_distance *= AGEING;
    }
}

/// The error that remains after an increment of that size (Hairer and Wanner 1996, section IV.8).
pub(super) fn remaining_error(size: f64, rate: f64) -> f64 {
    if rate < 1.0 { size * rate / (1.0 - rate) } else { f64::INFINITY }
}

/// How many iterations it takes, the one of this increment included, until the remaining error is below 1; infinite when
/// that is not worth trying.
pub(super) fn iterations_needed(size: f64, rate: f64) -> f64 {
    let mut error = remaining_error(size, rate);
    if !(rate <= SLOWEST_RATE && error.is_finite()) {
        return f64::INFINITY;
    }
    let mut iterations = 1.0;
    while error > 1.0 {
        error *= rate;
        iterations += 1.0;
    }
    iterations
}
