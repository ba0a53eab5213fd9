//! Options of a search.

use super::Derivative;
use crate::error::{Checker, InvalidInput};

/// Bound of `||R / f_scale||_2`, as in the lab.
pub(super) const RESIDUAL_TOLERANCE: f64 = 1e-6;

/// Limit of iterations, as in the lab.
pub(super) const MAX_ITERATIONS: usize = 1000;

/// Globalisation of Newton's method.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Method {
    /// None: full steps, as in textbooks and in the lab.
    Newton,
    /// Backtracking along the Newton step until `|R|^2` decreases sufficiently (Armijo).
    LineSearch,
    /// Powell's dogleg between the steepest descent and the Newton step, within a trust region.
    TrustRegion,
}

/// Lifetime of a factorised Jacobian. A kept Jacobian remains in use while each step reduces the residual at
/// least by the factor [`Options::chord_rate`] (chord steps: Hairer and Wanner 1996, section IV.8). After a
/// worse step it is evaluated again; a step without any reduction is undone first.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reuse {
    /// A fresh Jacobian at every iteration.
    Never,
    /// Kept between iterations of one solve.
    WithinSolve,
    /// Also kept between solves: for time stepping, where successive systems have similar Jacobians. See
    /// [`Newton::forget_jacobian`](super::Newton::forget_jacobian).
    AcrossSolves,
}

/// The step rule: `sqrt(mean((dx / (absolute + relative |x|))^2)) <= 1`. Both zero (the default) disable the
/// rule.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StepTolerance {
    /// In units of x, for unknowns near zero.
    pub absolute: f64,
    /// Dimensionless.
    pub relative: f64,
}

/// Options of a search. `Options::default()` is the lab's method.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Options {
    /// Globalisation; full Newton steps by default.
    pub method: Method,
    /// Source of the Jacobian; analytic by default.
    pub derivative: Derivative,
    /// Stop with success when `||R / f_scale||_2` is at most this; 1e-6 by default.
    pub residual_tolerance: f64,
    /// Stop with success when a Newton step meets this tolerance and the residual confirms it; off by
    /// default.
    pub step_tolerance: StepTolerance,
    /// Maximum number of steps; 1000 by default.
    pub max_iter: usize,
    /// Lifetime of a Jacobian; one iteration by default.
    pub reuse: Reuse,
    /// Largest residual reduction factor per step with which a kept Jacobian stays in use, in (0, 1); 0.25 by
    /// default: three such steps gain almost two digits, for less than the cost of a Jacobian by differences.
    pub chord_rate: f64,
    /// Maximum step length, as `||dx / x_scale||_2`. By default 1000 times the scaled start (at least 1000)
    /// for the line search, and unlimited for the other methods.
    pub longest_step: Option<f64>,
    /// Lengthen the steps near a multiple root; off by default. A longer step is kept only if it reduces the
    /// residual to a quarter; otherwise it costs one evaluation.
    pub accelerate: bool,
    /// Store every iterate in [`Newton::history`](super::Newton::history); off by default.
    pub history: bool,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            method: Method::Newton,
            derivative: Derivative::Analytic,
            residual_tolerance: RESIDUAL_TOLERANCE,
            step_tolerance: StepTolerance { absolute: 0.0, relative: 0.0 },
            max_iter: MAX_ITERATIONS,
            reuse: Reuse::Never,
            chord_rate: 0.25,
            longest_step: None,
            accelerate: false,
            history: false,
        }
    }
}

impl Options {
    /// Reports all invalid values at once.
    pub fn check(&self) -> Result<(), InvalidInput> {
        let mut checker = Checker::new();
        checker.non_negative(self.residual_tolerance, "residual_tolerance", "units of the scaled residual");
        checker.non_negative(self.step_tolerance.absolute, "step_tolerance.absolute", "units of x");
        checker.non_negative(self.step_tolerance.relative, "step_tolerance.relative", "no unit");
        let rate = self.chord_rate;
        checker.require(rate > 0.0 && rate < 1.0, "chord_rate", rate, "a number in (0, 1)");
        if let Some(longest) = self.longest_step {
            checker.positive(longest, "longest_step", "scaled units of x");
        }
        checker.finish()
    }
}
