//! How to search.

use super::Derivative;
use crate::error::{Checker, InvalidInput};

/// Bound of `||R / f_scale||_2`: the lab's rule.
pub(super) const RESIDUAL_TOLERANCE: f64 = 1e-6;

/// The lab's limit.
pub(super) const MAX_ITERATIONS: usize = 1000;

/// What keeps the search on the way when a full Newton step would not.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Method {
    /// Nothing: full steps, as in the textbook and in the lab.
    Newton,
    /// Backtracking along the Newton step until `|R|^2` falls enough (Armijo).
    LineSearch,
    /// Powell's dogleg between the steepest descent and the Newton step, inside a region that grows with
    /// success.
    TrustRegion,
}

/// How long a factorised Jacobian is kept. A kept one serves as long as each step with it reduces the
/// residual to at most [`Options::chord_rate`] times its value (chord steps: Hairer and Wanner 1996, section
/// IV.8); after a step that does worse it is evaluated anew, and a step that reduces nothing is taken back
/// first.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reuse {
    /// A fresh Jacobian at every iteration.
    Never,
    /// Kept from iteration to iteration of one solve.
    WithinSolve,
    /// Kept from one solve to the next as well: for time stepping, where neighbouring systems have almost the
    /// same Jacobian. See [`Newton::forget_jacobian`](super::Newton::forget_jacobian).
    AcrossSolves,
}

/// The step rule: `sqrt(mean((dx / (absolute + relative |x|))^2)) <= 1`. Both zero (the default) switches it
/// off.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StepTolerance {
    /// In units of x, for variables near zero.
    pub absolute: f64,
    /// Without unit.
    pub relative: f64,
}

/// How to search. `Options::default()` is the lab's method.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Options {
    /// Globalisation; full Newton steps by default.
    pub method: Method,
    /// Where the Jacobian comes from; analytic by default.
    pub derivative: Derivative,
    /// Stop with success when `||R / f_scale||_2` is at most this; 1e-6 by default.
    pub residual_tolerance: f64,
    /// Stop with success when a Newton step is that small and the residual confirms it; off by default.
    pub step_tolerance: StepTolerance,
    /// Largest number of steps; 1000 by default.
    pub max_iter: usize,
    /// How long a Jacobian is kept; never by default.
    pub reuse: Reuse,
    /// Largest residual reduction factor per step with which a kept Jacobian stays in use, in (0, 1); 0.25 by
    /// default: three such steps gain almost two digits, for less than the price of a Jacobian by
    /// differences.
    pub chord_rate: f64,
    /// Longest step, as `||dx / x_scale||_2`. By default the line search allows 1000 times the scaled start
    /// (at least 1000), the other methods any.
    pub longest_step: Option<f64>,
    /// Lengthen the steps where they show a multiple root; off by default. A longer step is kept only if it
    /// reduces the residual to a quarter, else it costs one evaluation.
    pub accelerate: bool,
    /// Keep every iterate in [`Newton::history`](super::Newton::history); off by default.
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
    /// Refuses values that make no sense, all at once.
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
