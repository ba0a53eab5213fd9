//! Status of a run.

use crate::error::Time;
use crate::integrators::ode;
use crate::integrators::second_order;
use crate::model::{InvalidShape, Model, at_least};

/// Reason why a run, or a part of it, ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Status {
    /// Status of the Newmark family or of Radau IIA.
    SecondOrder(second_order::Status),
    /// Status of a first-order method.
    FirstOrder(ode::Status),
    /// The end was reached, but not the requested accuracy.
    AccuracyNotReached,
    /// The motion reached a shape that the quadrature nodes do not resolve.
    Unresolved,
    /// The motion compressed a rod through zero length.
    Inverted,
    /// A tendon pulled two points together, so that its force has no direction.
    Collapsed,
    /// A closed loop opened.
    Open,
    /// Surfaces sank into each other, or passed through each other.
    DeepPenetration,
    /// Closed loops are at a singular position that the method cannot pass.
    Singular,
    /// Inextensible tendons become taut and slack again endlessly.
    Chattering,
    /// Stability would require an unreasonable number of steps of an explicit method.
    Stiff,
    /// The limit of wall-clock time was reached.
    TimeLimit,
}

impl Status {
    /// True if the end of the interval was reached.
    pub fn is_success(self) -> bool {
        match self {
            Self::SecondOrder(status) => status.is_success(),
            Self::FirstOrder(status) => status.is_success(),
            Self::AccuracyNotReached
            | Self::Unresolved
            | Self::Inverted
            | Self::Collapsed
            | Self::Open
            | Self::DeepPenetration
            | Self::Singular
            | Self::Chattering
            | Self::Stiff
            | Self::TimeLimit => false,
        }
    }

    /// True if the run was asked to stop.
    pub fn is_interrupted(self) -> bool {
        matches!(
            self,
            Self::SecondOrder(second_order::Status::Interrupted) | Self::FirstOrder(ode::Status::Interrupted)
        )
    }

    /// The status as one word, such as `finished` or `interrupted`.
    pub fn name(self) -> &'static str {
        match self {
            Self::SecondOrder(status) => status.name(),
            Self::FirstOrder(status) => status.name(),
            Self::AccuracyNotReached => "accuracy_not_reached",
            Self::Unresolved => "unresolved",
            Self::Inverted => "inverted",
            Self::Collapsed => "collapsed",
            Self::Open => "loop_open",
            Self::DeepPenetration => "deep_penetration",
            Self::Singular => "singular_position",
            Self::Chattering => "chattering",
            Self::Stiff => "stiff",
            Self::TimeLimit => "time_limit",
        }
    }
}

/// Reason to end a run although its method could continue.
#[derive(Clone, Debug)]
pub(crate) struct Stop {
    pub(crate) status: Status,
    pub(crate) message: String,
}

impl Stop {
    /// At a start whose mass matrix is singular.
    pub(crate) fn without_mass(t: f64) -> Self {
        let message = format!(
            "The accelerations at t = {} could not be found: the mass matrix is singular, or not finite, at the start. Change the \
             initial state (coordinates of a universal joint, of hinges in a row, or of a pendulum without length may be singular there), or give every \
             coordinate a mass.",
            Time(t),
        );
        let failure = second_order::Failure::SingularJacobian;
        Self { status: Status::SecondOrder(second_order::Status::NoInitialAcceleration(failure)), message }
    }

    /// At a start whose energies overflow.
    pub(crate) fn without_energy(t: f64) -> Self {
        let message = format!(
            "The motion cannot begin at t = {}: energies there are beyond what double precision holds. Check the units of the \
             initial state.",
            Time(t),
        );
        let failure = second_order::Failure::NonFinite;
        Self { status: Status::SecondOrder(second_order::Status::NoInitialAcceleration(failure)), message }
    }

    /// At a singular position, where an explicit method cannot choose between branches.
    pub(crate) fn at_singular_position(t: f64) -> Self {
        let message = format!(
            "Near t = {} the loops pass a singular position, where there are several ways to go on: the last state says \
             nothing about the motion. Take `method=\"generalised_alpha\"`, whose steps go on as the motion did.",
            Time(t),
        );
        Self { status: Status::Singular, message }
    }

    /// The same with inextensible tendons.
    pub(crate) fn at_jump_or_singular_position(t: f64) -> Self {
        let message = format!(
            "Near t = {} the length of a tendon that does not stretch jumps, or constraints pass a singular position, where there \
             are several ways to go on: the last state says nothing about the motion. Change lengths gradually, give the \
             tendon a `stiffness`, or take `method=\"generalised_alpha\"`.",
            Time(t),
        );
        Self { status: Status::Singular, message }
    }

    /// Where a tendon of given length is too long by `by` and no shorter step helps.
    pub(crate) fn where_too_long(t: f64, by: f64) -> Self {
        let message = format!(
            "At t = {} the length of a tendon that does not stretch jumps, by {by:.1e} m away from the length of its path: no finite force \
             moves it there at once. Change lengths gradually, give the tendon a `stiffness`, or take \
             `method=\"generalised_alpha\"`, which follows within a step.",
            Time(t),
        );
        Self { status: Status::Open, message }
    }

    /// Where tendons of given length and closed loops contradict each other.
    pub(crate) fn at_conflict(t: f64) -> Self {
        let message = format!(
            "At t = {} no motion keeps all inextensible tendons at their commanded lengths: these, or these and \
             closed loops, conflict there.",
            Time(t),
        );
        Self { status: Status::Open, message }
    }

    /// Where tendons become taut and slack again endlessly.
    pub(crate) fn at_chatter(t: f64) -> Self {
        let message = format!(
            "Near t = {} tendons that do not stretch become taut and slack again ever faster. Take \
             `method=\"generalised_alpha\"`, which does not resolve it, or give the tendons a `stiffness`.",
            Time(t),
        );
        Self { status: Status::Chattering, message }
    }

    /// At an invalid state; `None` if the state is valid.
    pub(crate) fn where_invalid<M: Model + ?Sized>(model: &mut M, t: f64, q: &[f64]) -> Option<Self> {
        // A non-finite command of a slack tendon makes nothing else NaN.
        if model.facts().is_one_sided
            && let Some(what) = model.not_finite()
        {
            let message =
                format!("Forces and commands must be finite: {what}. The last state is meaningless.");
            return Some(Self { status: Status::FirstOrder(ode::Status::NonFinite), message });
        }
        let invalid_shape =
            model.invalid_shape(q).or_else(|| model.open_loop(q)).or_else(|| model.deep_penetration(q))?;
        let (status, cure) = match invalid_shape {
            InvalidShape::Unresolved { shortage } => (
                Status::Unresolved,
                format!("; if that fails too, give the segment more `nodes`{}", at_least(shortage)),
            ),
            InvalidShape::Collapsed { .. } => (
                Status::Collapsed,
                "; if that fails too, pull less, or keep the points apart with a joint that has `limits`"
                    .to_owned(),
            ),
            InvalidShape::Open { .. } => (
                Status::Open,
                "; if that fails too, the loops conflict there: the mechanism cannot go on, as at the end of its travel"
                    .to_owned(),
            ),
            InvalidShape::DeepPenetration { .. } => (
                Status::DeepPenetration,
                "; if that fails too, give the contact more `stiffness`".to_owned(),
            ),
            InvalidShape::Inverted { .. } => (
                Status::Inverted,
                "; if that fails too, linear elasticity in the stretch does not hold".to_owned(),
            ),
        };
        let message = format!(
            "At t = {} the model {}: the last state says nothing about the motion. Take shorter steps{cure}.",
            Time(t),
            invalid_shape.with_loops(&model.facts().loops),
        );
        Some(Self { status, message })
    }
}
