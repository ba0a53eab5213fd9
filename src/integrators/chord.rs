//! The chord method, Newton's method with a constant Jacobian: contraction rates of its corrections, and convergence tests.

/// Newton iterations before the step is reduced; SciPy's number (RADAU5: 7).
pub(crate) const NEWTON_ITERATIONS: usize = 6;
/// The iteration error is kept this much below the tolerances (RADAU5: FNEWT)...
const NEWTON_TOLERANCE: f64 = 0.03;
/// ...but not below this many rounding units over the relative tolerance (RADAU5).
const NEWTON_TOLERANCE_IN_ROUNDING_UNITS: f64 = 10.0;
/// The Jacobian is kept if Newton's method converges at least this fast (RADAU5: THET)...
const FAST_RATE: f64 = 1e-3;
/// ...or within this number of iterations (SciPy).
const FEW_ITERATIONS: usize = 2;
/// Two corrections in a row below this part of the tolerance end the iteration, whatever their ratio: even at a rate of
/// 0.97 the remaining error is below the tolerance.
const NEGLIGIBLE: f64 = 0.03;
/// With a higher rate, an iteration is not worth its cost.
pub(crate) const SLOWEST_RATE: f64 = 0.5;

/// The remaining error after an increment of this size (Hairer and Wanner 1996, section IV.8).
pub(crate) fn remaining_error(size: f64, rate: f64) -> f64 {
    if rate < 1.0 { size * rate / (1.0 - rate) } else { f64::INFINITY }
}

/// Number of iterations, including that of this increment, until the remaining error is below 1; infinite if that is not worth
/// trying.
pub(crate) fn iterations_needed(left: f64, rate: f64) -> f64 {
    let mut error = left;
    if !error.is_finite() || rate > SLOWEST_RATE {
        return f64::INFINITY;
    }
    let mut iterations = 1.0;
    while error > 1.0 {
        error *= rate;
        iterations += 1.0;
    }
    iterations
}

/// A Newton iteration that converged.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Converged {
    pub(crate) iterations: usize,
    pub(crate) rate: f64,
}

impl Converged {
    /// Whether the next step should start with a new Jacobian.
    pub(crate) fn wants_jacobian(&self) -> bool {
        self.iterations > FEW_ITERATIONS && self.rate > FAST_RATE
    }
}

/// Decision after an iteration.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Verdict {
    /// The iteration does not converge: reduce the step.
    Diverges,
    /// Apply the correction and continue.
    GoOn,
    /// Apply the correction; the remaining error is below the tolerance.
    Converged(Converged),
}

/// Convergence of the simplified Newton iteration of a step, judged by its corrections.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Iteration {
    tolerance: f64,
    count: usize,
    previous_norm: Option<f64>,
}

impl Iteration {
    /// Allowed error of the iteration relative to the tolerances, if the smallest relative tolerance is
    /// `rtol`.
    pub(crate) fn tolerance(rtol: f64) -> f64 {
        let rounding = NEWTON_TOLERANCE_IN_ROUNDING_UNITS * f64::EPSILON / rtol;
        rounding.max(NEWTON_TOLERANCE.min(rtol.sqrt()))
    }

    pub(crate) fn new(tolerance: f64) -> Self {
        Self { tolerance, count: 0, previous_norm: None }
    }

    /// Judges a correction of this size relative to the tolerances.
    pub(crate) fn judge(&mut self, norm: f64) -> Verdict {
        self.count += 1;
        let previous = self.previous_norm.replace(norm);
        // Both corrections are rounding, which does not contract.
        if previous.is_some_and(|previous| previous.max(norm) <= NEGLIGIBLE * self.tolerance) {
            return Verdict::Converged(Converged { iterations: self.count, rate: 0.0 });
        }
        let rate = previous.map(|previous| norm / previous);
        if let Some(rate) = rate {
            // Error that the remaining iterations can achieve (Hairer and Wanner 1996, eq. IV.8.11).
            let left = (NEWTON_ITERATIONS - self.count) as i32;
            let hopeless = rate.powi(left) * remaining_error(norm, rate) > self.tolerance;
            if rate >= 1.0 || rate.is_nan() || hopeless {
                return Verdict::Diverges;
            }
        }
        let rate = rate.unwrap_or(f64::INFINITY);
        if norm == 0.0 || remaining_error(norm, rate) < self.tolerance {
            return Verdict::Converged(Converged { iterations: self.count, rate });
        }
        if self.count < NEWTON_ITERATIONS { Verdict::GoOn } else { Verdict::Diverges }
    }
}
