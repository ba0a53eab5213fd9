//! What came of a search.

use std::fmt;

/// How a search ended. Only the first three are successes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Status {
    /// The scaled residual fell below its tolerance.
    ConvergedResidual,
    /// The Newton step fell below its tolerance (or below rounding) and the residual is as small as that step explains.
    ConvergedStep,
    /// The start was a root within the tolerance; nothing was done.
    AlreadyRoot,
    /// The gradient of `|R|^2` is zero but R is not: no step can be expected to help.
    StationaryPoint,
    /// The Jacobian is so close to singular that no finite step exists.
    SingularJacobian,
    /// The limit of iterations was reached.
    IterationLimit,
    /// The iterates ran away.
    Diverged,
    /// Steps are too small to change x, but the residual is not small.
    Stalled,
    /// R is NaN or infinite at the start, or where the step led.
    NonFiniteResidual,
    /// The Jacobian has a NaN or infinite entry.
    NonFiniteJacobian,
}

impl Status {
    /// True when x is a root within the tolerances.
    pub fn is_success(self) -> bool {
        matches!(self, Self::ConvergedResidual | Self::ConvergedStep | Self::AlreadyRoot)
    }

    /// A stable name in lower case, such as `converged_residual`.
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
            Self::NonFiniteResidual => "non_finite_residual",
            Self::NonFiniteJacobian => "non_finite_jacobian",
        }
    }

    /// What happened, and what to change when it was no success.
    pub fn message(self) -> &'static str {
        match self {
            Self::ConvergedResidual => "The residual is below its tolerance.",
            Self::ConvergedStep => {
                "The Newton step is below its tolerance, and the residual is as small as such a step explains."
            }
            Self::AlreadyRoot => "The start is a root within the tolerance; no step was taken.",
            Self::StationaryPoint => {
                "Stopped at a stationary point of |R| that is not a root: the Jacobian sees no direction in which R \
                 decreases. Start somewhere else; if that ends here too, there may be no root nearby."
            }
            Self::SingularJacobian => {
                "The Jacobian is singular to working precision and no finite step exists. Start somewhere else, check \
                 the Jacobian, or look for an unknown that no equation depends on."
            }
            Self::IterationLimit => {
                "The limit of iterations was reached. If the residual was still falling, allow more; if not, start \
                 closer to the root or use a globalised method."
            }
            Self::Diverged => {
                "The iterates ran away and the residual did not fall. Start closer to the root or use a globalised \
                 method."
            }
            Self::Stalled => {
                "The steps are below the rounding of x, yet the residual is not small. Check the Jacobian against \
                 differences, and whether R is continuous here; if R cannot be computed any better, loosen its \
                 tolerance or give its scale."
            }
            Self::NonFiniteResidual => {
                "The residual is NaN or infinite. If that is so at the start, start inside the domain of R; otherwise \
                 a step left the domain: start closer to the root or use a globalised method, which shortens such steps."
            }
            Self::NonFiniteJacobian => {
                "The Jacobian has a NaN or infinite entry. Start away from the edge of the domain of R, or check the \
                 Jacobian."
            }
        }
    }
}

impl fmt::Display for Status {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.message())
    }
}

/// What came of a search.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Outcome {
    /// How it ended.
    pub status: Status,
    /// Steps taken.
    pub iterations: usize,
    /// Evaluations of R, those for differences included.
    pub residual_evaluations: usize,
    /// Of these, the ones that difference Jacobians took.
    pub difference_evaluations: usize,
    /// Jacobians evaluated, analytic or by differences.
    pub jacobian_evaluations: usize,
    /// Factorisations.
    pub factorisations: usize,
    /// `||R / f_scale||_2` at the x that was returned.
    pub residual_norm: f64,
    /// `||dx / x_scale||_2` of the last step; NaN when none was taken.
    pub step_norm: f64,
}
