//! How an integration ended.

/// Why an integration ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Status {
    /// The end of the interval was reached.
    Finished,
    /// A terminal event occurred as often as it was allowed to.
    Event,
    /// The step limit was reached first.
    TooManySteps,
    /// The tolerances need a step that is smaller than allowed, or than floating-point numbers can express.
    StepTooSmall,
    /// The right-hand side or the state is NaN or infinite however small the step.
    NonFinite,
    /// An implicit method met a Jacobian that is NaN or infinite, which no smaller step can mend.
    NonFiniteJacobian,
    /// The right-hand side, an event or the monitor asked to stop.
    Interrupted,
}

impl Status {
    /// True when the end of the interval or a terminal event was reached.
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
