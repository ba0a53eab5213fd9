//! Status of an integration.

/// Reason why an integration ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Status {
    /// The end of the interval was reached.
    Finished,
    /// A terminal event occurred the specified number of times.
    Event,
    /// The limit of steps was reached.
    TooManySteps,
    /// The tolerances require a step smaller than allowed, or smaller than the spacing of floating-point
    /// numbers.
    StepTooSmall,
    /// The right-hand side or the state is NaN or infinite for any step size.
    NonFinite,
    /// The Jacobian of an implicit method is NaN or infinite, for any step size.
    NonFiniteJacobian,
    /// The right-hand side, an event or the monitor requested a stop.
    Interrupted,
}

impl Status {
    /// True if the end of the interval or a terminal event was reached.
    pub fn is_success(self) -> bool {
        matches!(self, Self::Finished | Self::Event)
    }

    /// The status as one word, such as `too_many_steps`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Finished => "finished",
            Self::Event => "event",
            Self::TooManySteps => "too_many_steps",
            Self::StepTooSmall => "step_too_small",
            Self::NonFinite => "non_finite",
            Self::NonFiniteJacobian => "non_finite_jacobian",
            Self::Interrupted => "interrupted",
        }
    }
}
