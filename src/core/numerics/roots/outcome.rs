//! Result of a search.

use std::fmt;

use crate::error::Rounded;

/// Status of a search. Only the first three are successes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Status {
    /// The scaled residual fell below its tolerance.
    ConvergedResidual,
    /// The Newton step is below its tolerance (or below rounding), and the residual is consistent with a step
    /// of that size.
    ConvergedStep,
    /// The start was a root within the tolerance.
    AlreadyRoot,
    /// The gradient of `|R|^2` is zero but R is not: no step is expected to help.
    StationaryPoint,
    /// The Jacobian is so close to singular that no finite step exists.
    SingularJacobian,
    /// The limit of iterations was reached.
    IterationLimit,
    /// The iterates diverged.
    Diverged,
    /// Steps are too small to change x, but the residual is not small.
    Stalled,
    /// No shortening of the Newton step reduced the residual enough.
    LineSearchFailed,
    /// The radius of the trust region fell below its limit.
    TrustRegionCollapsed,
    /// Several consecutive steps had the maximum length.
    LongestSteps,
    /// R is NaN or infinite at the start, or after a step.
    NonFiniteResidual,
    /// The Jacobian has a NaN or infinite entry.
    NonFiniteJacobian,
    /// The system asked to stop.
    Interrupted,
}

impl Status {
    /// True if x is a root within the tolerances.
    pub fn is_success(self) -> bool {
        matches!(self, Self::ConvergedResidual | Self::ConvergedStep | Self::AlreadyRoot)
    }

    /// Stable name in lower case, such as `converged_residual`.
    pub fn name(self) -> &'static str {
        match self {
            Self::ConvergedResidual => "converged_residual",
            Self::ConvergedStep => "converged_step",
            Self::AlreadyRoot => "already_root",
            Self::StationaryPoint => "stationary_point",
            Self::SingularJacobian => "singular_jacobian",
            Self::IterationLimit => "iteration_limit",
            Self::Diverged => "diverged",
            Self::Stalled => "stalled",
            Self::LineSearchFailed => "line_search_failed",
            Self::TrustRegionCollapsed => "trust_region_collapsed",
            Self::LongestSteps => "longest_steps",
            Self::NonFiniteResidual => "non_finite_residual",
            Self::NonFiniteJacobian => "non_finite_jacobian",
            Self::Interrupted => "interrupted",
        }
    }

    /// Description, with advice unless the search succeeded.
    pub fn message(self) -> &'static str {
        match self {
            Self::ConvergedResidual => "The residual is below its tolerance.",
            Self::ConvergedStep => {
                "The Newton step is below its tolerance, and the residual is as small as such a step \
                 explains."
            }
            Self::AlreadyRoot => "The start is a root within the tolerance; no step was taken.",
            Self::StationaryPoint => {
                "Stopped at a stationary point of |R| that is not a root: to first order, R decreases in no \
                 direction. Start somewhere else; if that fails too, there may be no root nearby. If the \
                 Jacobian comes from finite differences, check the scale of x."
            }
            Self::SingularJacobian => {
                "The Jacobian is singular to working precision and no finite step exists. Start somewhere \
                 else, check the Jacobian, or look for an unknown that no equation depends on."
            }
            Self::IterationLimit => {
                "The limit of iterations was reached. If the residual was still decreasing, allow more (`max_iter`); if \
                 not, start closer to the root, or take a method that shortens steps: `method=\"trust_region\"` or \
                 \"line_search\"."
            }
            Self::Diverged => {
                "The iterates diverged and the residual did not decrease. Start closer to the root, or take a method that \
                 shortens steps: `method=\"trust_region\"` or \"line_search\"."
            }
            Self::Stalled => {
                "The steps are below the rounding of x, yet the residual is not small. Check the Jacobian \
                 against differences, and whether R is continuous here; if R cannot be computed any better, \
                 loosen its tolerance or give its scale."
            }
            Self::LineSearchFailed => {
                "The line search failed: the residual does not decrease along the Newton step, however short. \
                 Check the Jacobian against differences, start somewhere else, or take `method=\"trust_region\"`."
            }
            Self::TrustRegionCollapsed => {
                "The trust region shrank to nothing without a better point. Check the Jacobian against \
                 differences, and whether R is smooth here; if R cannot be computed any better, loosen its \
                 tolerance or give its scale."
            }
            Self::LongestSteps => {
                "Five steps in a row had the maximum length: the residual may decrease towards a limit \
                 without a root. Start somewhere else, give the scale of x, or allow longer steps."
            }
            Self::NonFiniteResidual => {
                "The residual is NaN or infinite. If that is so at the start, start inside the domain of R; \
                 otherwise a step left the domain: start closer to the root, or take a method that shortens such \
                 steps: `method=\"trust_region\"` or \"line_search\"."
            }
            Self::NonFiniteJacobian => {
                "The Jacobian has a NaN or infinite entry. Start away from the edge of the domain of R, or \
                 check the Jacobian."
            }
            Self::Interrupted => "The search was interrupted; this is the best iterate until then.",
        }
    }
}

impl fmt::Display for Status {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.message())
    }
}

/// Result of a search.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Outcome {
    /// Status.
    pub status: Status,
    /// Number of steps.
    pub iterations: usize,
    /// Evaluations of R, including those for Jacobians by differences.
    pub residual_evaluations: usize,
    /// Evaluations of R for Jacobians by differences.
    pub difference_evaluations: usize,
    /// Jacobians evaluated, analytic or by differences.
    pub jacobian_evaluations: usize,
    /// Factorisations.
    pub factorisations: usize,
    /// `||R / f_scale||_2` at the returned x.
    pub residual_norm: f64,
    /// `||dx / x_scale||_2` of the last step; NaN without a step.
    pub step_norm: f64,
    /// Estimated multiplicity of the root if convergence was linear, as at multiple roots; `None` otherwise.
    pub multiplicity: Option<usize>,
    /// Whether the last Newton steps became no shorter although the residual fell below its tolerance: x may run off to where R tends to
    /// zero without a root, as `exp(-x)` does.
    pub runs_off: bool,
    /// After how many steps the iterates repeat, if they do: a cycle, in which Newton's method stays for ever.
    pub cycle: Option<usize>,
}

impl Outcome {
    /// Why x may be no root although the residual is below its tolerance.
    pub fn doubt(&self) -> Option<String> {
        self.runs_off.then(|| {
            format!(
                "The last steps became no shorter (the last one {:.1e}) while the residual fell slowly: it may tend to zero far away, without \
                 a root. Look at x, and take a smaller `tol` or the scale of the residual.",
                self.step_norm
            )
        })
    }

    /// Description with numbers, and with advice unless the search succeeded.
    pub fn message(&self) -> String {
        let Self { status, iterations, residual_norm, .. } = self;
        let steps = if *iterations == 1 { "step" } else { "steps" };
        let said = match self.cycle.filter(|_| *status == Status::IterationLimit) {
            Some(period) => format!(
                "The limit of iterations was reached: the iterates go round in a cycle of {period} steps, and more of them do not \
                 help. Start somewhere else, or take a method that shortens steps: `method=\"trust_region\"` or \"line_search\"."
            ),
            None => status.to_string(),
        };
        let mut message =
            format!("{said} Residual norm {} after {iterations} {steps}.", Rounded(*residual_norm));
        if let Some(multiplicity) = self.multiplicity {
            message += &format!(
                " Convergence was linear, as at a root of multiplicity {multiplicity}: the error of x is \
                 about the residual to the power 1/{multiplicity}, and acceleration saves steps."
            );
        }
        if let Some(doubt) = self.doubt() {
            message = format!("{message} {doubt}");
        }
        message
    }
}
