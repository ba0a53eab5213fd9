//! Error estimate of Zienkiewicz and Xie (1991), corrected where it is blind, and the resulting step size.

use super::{ATOL, Scheme};
use crate::error::Checker;

/// A coefficient of the estimate closer to zero than this does not detect errors.
const SMALLEST_COEFFICIENT: f64 = 0.01;

/// Smallest coefficient of the velocity error, which vanishes for all members of order 2: without it fast oscillations with small
/// displacements could be lost unnoticed (the choice of OrdinaryDiffEq.jl).
const SMALLEST_VELOCITY_COEFFICIENT: f64 = 0.01;

/// Relative changes of accelerations below this are rounding, including that of differenced Jacobians in Newton's method.
const ROUNDING_OF_ACCELERATIONS: f64 = 1e-12;

/// Safety factor of step sizes, and the largest factors by which they change (the usual choices: Hairer, Norsett and Wanner 1993,
/// section II.4).
const SAFETY: f64 = 0.9;
const SMALLEST_FACTOR: f64 = 0.2;
pub(super) const LARGEST_FACTOR: f64 = 5.0;

/// Growth below this factor is not worth a new Jacobian (RADAU5: Hairer and Wanner 1996, section IV.8).
const WORTHWHILE_GROWTH: f64 = 1.2;

/// Coefficients of the estimated local errors, see [`Scheme`].
#[derive(Clone, Copy, Debug)]
pub(super) struct ErrorEstimate {
    displacement: f64,
    velocity: f64,
    /// Coefficients of the deviation of the algorithmic accelerations at the start from those of a smooth motion, and the fraction of the
    /// change of accelerations by which they are ahead in a smooth motion.
    memory: [f64; 2],
    shift: f64,
    /// Order of the estimate in the step size.
    order: f64,
}

/// The two ends of a step.
pub(super) struct Ends<'a> {
    pub(super) q: [&'a [f64]; 2],
    pub(super) v: [&'a [f64]; 2],
    pub(super) a: [&'a [f64]; 2],
    /// Algorithmic accelerations at the start; empty where these are the true ones.
    pub(super) s: &'a [f64],
}

impl ErrorEstimate {
    pub(super) fn new(scheme: &Scheme) -> Self {
        Self {
            displacement: scheme.displacement_error(),
            velocity: scheme.velocity_error().abs().max(SMALLEST_VELOCITY_COEFFICIENT),
            memory: scheme.errors_of_memory(),
            shift: scheme.shift(),
            order: scheme.order() as f64 + 1.0,
        }
    }

    /// Root mean square of the local errors of displacements and velocities in units of the tolerances, [`ATOL`] by default: a step is
    /// good when it is at most 1.
    pub(super) fn error(&self, h: f64, ends: &Ends<'_>, rtol: &[f64], atol: Option<&[f64]>) -> f64 {
        let Ends { q, v, a, s } = ends;
        let n = rtol.len();
        let mut sum = 0.0;
        for i in 0..n {
            let changed = |change: f64| {
                if change.abs() <= ROUNDING_OF_ACCELERATIONS * a[0][i].abs() { 0.0 } else { h * change }
            };
            let change = a[1][i] - a[0][i];
            let memory = if s.is_empty() { 0.0 } else { changed(s[i] - a[0][i] - self.shift * change) };
            let change = changed(change);
            let atol = atol.map_or(ATOL, |atol| atol[i]);
            let tolerance = |x: &[&[f64]; 2]| atol + rtol[i] * x[0][i].abs().max(x[1][i].abs());
            let displacement = h * (self.displacement * change + self.memory[0] * memory);
            let velocity = self.velocity * change.abs() + (self.memory[1] * memory).abs();
            for (error, x) in [(displacement, q), (velocity, v)] {
                // 0 / 0 (no tolerance, no error) is no error.
                let ratio = if error == 0.0 { 0.0 } else { error / tolerance(x) };
                sum += ratio * ratio;
            }
        }
        (sum / (2 * n.max(1)) as f64).sqrt()
    }

    /// Factor by which the step size should change; one for an estimate of exactly zero.
    pub(super) fn factor(&self, error: f64, rejected_before: bool) -> f64 {
        if error == 0.0 {
            return 1.0;
        }
        if !error.is_finite() {
            return SMALLEST_FACTOR;
        }
        let factor = (SAFETY * error.powf(-1.0 / self.order)).clamp(SMALLEST_FACTOR, LARGEST_FACTOR);
        if error > 1.0 {
            factor.min(SAFETY)
        } else if rejected_before || (1.0..WORTHWHILE_GROWTH).contains(&factor) {
            factor.min(1.0)
        } else {
            factor
        }
    }
}

impl Scheme {
    /// Reports a problem if the error estimate of adaptive steps does not detect this scheme's errors.
    pub(super) fn check_error_estimate(&self, checker: &mut Checker) {
        let blind = self.displacement_error().abs() < SMALLEST_COEFFICIENT
            && self.velocity_error().abs() < SMALLEST_COEFFICIENT;
        let expected = format!(
            "a beta at least {SMALLEST_COEFFICIENT} away from {:.4} or a gamma at least {SMALLEST_COEFFICIENT} away from {:.4} for adaptive steps, \
             whose error estimate is blind there; or fixed steps",
            self.beta() - self.displacement_error(),
            self.gamma() - self.velocity_error(),
        );
        let found = format_args!("beta = {}, gamma = {}", self.beta(), self.gamma()).to_string();
        checker.require(!blind, "adaptive", found, &expected);
    }
}
