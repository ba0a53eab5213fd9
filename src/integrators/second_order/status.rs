//! Status and cost of an integration.

use crate::error::Interrupted;
use crate::numerics::tape::Tape;

/// Reason why the accelerations of a step could not be computed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Failure {
    /// Newton's method did not converge, even with a fresh Jacobian in every iteration.
    NotConverged,
    /// The Jacobian is singular.
    SingularJacobian,
    /// The residual or the Jacobian is NaN or infinite.
    NonFinite,
    /// Surfaces would pass through each other.
    PassedThrough,
}

/// Whether equations of motion were solved, if nothing interrupted that.
pub(crate) type Solved = Result<Result<(), Failure>, Interrupted>;

/// Reason why an integration ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Status {
    /// The end of the interval was reached.
    Finished,
    /// No accelerations at the start could be computed.
    NoInitialAcceleration(Failure),
    /// The equations of motion of a fixed step could not be solved.
    StepFailed(Failure),
    /// The tolerances, or equations that could not be solved, require a step smaller than allowed.
    StepTooSmall,
    /// A vibration has grown because steps exceed the limit of stability of the method.
    Unstable,
    /// The limit of steps was reached.
    TooManySteps,
    /// The equations of motion or the monitor requested a stop.
    Interrupted,
}

impl Status {
    /// True if the end of the interval was reached.
    pub fn is_success(self) -> bool {
        self == Self::Finished
    }

    /// The status as one word, such as `newton_not_converged`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Finished => "finished",
            Self::NoInitialAcceleration(_) => "no_initial_acceleration",
            Self::StepFailed(Failure::NotConverged) => "newton_not_converged",
            Self::StepFailed(Failure::SingularJacobian) => "singular_jacobian",
            Self::StepFailed(Failure::NonFinite) => "non_finite",
            Self::StepFailed(Failure::PassedThrough) => "passed_through",
            Self::StepTooSmall => "step_too_small",
            Self::Unstable => "unstable",
            Self::TooManySteps => "too_many_steps",
            Self::Interrupted => "interrupted",
        }
    }
}

/// The cost of an integration.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counters {
    /// Accepted steps.
    pub steps: usize,
    /// Rejected steps, because of their error estimate.
    pub rejected: usize,
    /// Steps that were shortened because their equations could not be solved.
    pub unsolved: usize,
    /// Newton iterations, in all steps and for the initial acceleration.
    pub newton_iterations: usize,
    /// Residual evaluations, without those for Jacobians by differences.
    pub nfev: usize,
    /// Residual evaluations for Jacobians by differences.
    pub nfev_jacobian: usize,
    /// Jacobians evaluated.
    pub njev: usize,
    /// Factorisations.
    pub nlu: usize,
    /// Steps for which a Jacobian kept from an earlier step did not converge, so that a fresh one was needed.
    pub reuse_failures: usize,
    /// Steps that needed a fresh Jacobian in every iteration.
    pub full_newton: usize,
}

impl Counters {
    /// All of them.
    pub(crate) fn serialise(&mut self, tape: &mut Tape<'_>) {
        let Self {
            steps,
            rejected,
            unsolved,
            newton_iterations,
            nfev,
            nfev_jacobian,
            njev,
            nlu,
            reuse_failures,
            full_newton,
        } = self;
        let of_steps = [steps, rejected, unsolved, reuse_failures, full_newton];
        for count in of_steps.into_iter().chain([newton_iterations, nfev, nfev_jacobian, njev, nlu]) {
            tape.count(count);
        }
    }
}
