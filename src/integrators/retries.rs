//! Why steps are attempted again.

use super::second_order::Failure;

/// Why an attempt did not make its step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reason {
    /// Newton's method did not converge.
    NotConverged,
    /// The Jacobian was singular.
    Singular,
    /// A number was NaN or infinite.
    NonFinite,
    /// The error estimate exceeded the tolerance.
    Error,
    /// The step was too long for an impact.
    Impact,
    /// A contact or a stop acted between the ends of the step only.
    Missed,
    /// The end of the step was invalid, such as surfaces that penetrate each other deeply.
    InvalidEnd,
    /// Surfaces would have passed through each other.
    PassedThrough,
    /// The step added energy.
    EnergyGain,
    /// A tendon became slack or taut within the step.
    Event,
    /// The steps before had to be made in parts, so that this one was not attempted as a whole.
    InParts,
    /// Newton's method converged only with a fresh Jacobian in every iteration, in the first attempt.
    SlowConvergence,
}

impl Reason {
    /// As one word.
    pub fn name(self) -> &'static str {
        match self {
            Self::NotConverged => "not_converged",
            Self::Singular => "singular",
            Self::NonFinite => "non_finite",
            Self::Error => "error",
            Self::Impact => "impact",
            Self::Missed => "missed",
            Self::InvalidEnd => "invalid_end",
            Self::PassedThrough => "passed_through",
            Self::EnergyGain => "energy_gain",
            Self::Event => "event",
            Self::InParts => "in_parts",
            Self::SlowConvergence => "slow_convergence",
        }
    }
}

impl From<Failure> for Reason {
    fn from(failure: Failure) -> Self {
        match failure {
            Failure::NotConverged => Self::NotConverged,
            Failure::SingularJacobian => Self::Singular,
            Failure::NonFinite => Self::NonFinite,
            Failure::PassedThrough => Self::PassedThrough,
        }
    }
}

/// The attempts of one step.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Retries {
    /// Attempts, of the step and of its parts.
    pub(crate) attempts: usize,
    /// How often its shortest part was halved.
    pub(crate) halvings: usize,
    /// Why the first attempt that failed did.
    pub(crate) reason: Option<Reason>,
}

impl Retries {
    /// An attempt begins.
    pub(crate) fn attempt(&mut self) {
        self.attempts += 1;
    }

    /// The last attempt did not make its step.
    pub(crate) fn fail(&mut self, reason: impl Into<Reason>) {
        self.reason.get_or_insert(reason.into());
    }

    /// Attempts since the last call.
    pub(crate) fn take(&mut self) -> Self {
        std::mem::take(self)
    }
}
