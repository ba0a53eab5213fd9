//! Result of a search for equilibria.

use super::equations::Counters;
use super::path::{CriticalKind, Path};
use crate::analysis::stability::{Stability, Verdict};
use crate::model::{InvalidShape, Overlap, Static, at_least};
use crate::numerics::roots;

/// Status of a search.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Status {
    /// Equilibrium under the full load.
    Converged,
    /// In equilibrium under the full load, after the load path ended early and the model was released there.
    Released,
    /// A continuation reached one of its bounds.
    Finished,
    /// There is no equilibrium close to the start.
    NoStart,
    /// Steps along the path became too small.
    StepTooSmall,
    /// The limit of steps along the path was reached.
    TooManySteps,
    /// The limit of iterations was reached.
    IterationLimit,
    /// No step decreases the energy.
    Stalled,
    /// The energy is unbounded below: the model is not held in some direction.
    Unheld,
    /// Forces or stiffnesses are not finite.
    NonFinite,
    /// The equilibrium, or the next point of the path, is an invalid shape.
    Invalid(InvalidShape),
    /// Newton's method from the start failed.
    Newton(roots::Status),
    /// In equilibrium under the full load, but with a larger error due to the finite number of modes than requested.
    AccuracyNotReached,
    /// The monitor asked to stop.
    Interrupted,
}

impl Status {
    /// True if the requested equilibrium or path was found.
    pub fn is_success(self) -> bool {
        matches!(self, Self::Converged | Self::Released | Self::Finished)
    }

    /// True if the forces are in equilibrium under the full load, whatever the accuracy.
    pub fn is_equilibrium(self) -> bool {
        matches!(self, Self::Converged | Self::Released | Self::AccuracyNotReached)
    }

    /// Stable name in lower case.
    pub fn name(self) -> &'static str {
        match self {
            Self::Converged => "converged",
            Self::Released => "released",
            Self::Finished => "finished",
            Self::NoStart => "no_start",
            Self::StepTooSmall => "step_too_small",
            Self::TooManySteps => "too_many_steps",
            Self::IterationLimit => "iteration_limit",
            Self::Stalled => "stalled",
            Self::Unheld => "unheld",
            Self::NonFinite => "non_finite",
            Self::Invalid(InvalidShape::Unresolved { .. }) => "unresolved",
            Self::Invalid(InvalidShape::Inverted { .. }) => "inverted",
            Self::Invalid(InvalidShape::Collapsed { .. }) => "collapsed",
            Self::Invalid(InvalidShape::Open { .. }) => "loop_open",
            Self::Invalid(InvalidShape::DeepPenetration { .. }) => "deep_penetration",
            Self::Newton(status) => status.name(),
            Self::AccuracyNotReached => "accuracy_not_reached",
            Self::Interrupted => "interrupted",
        }
    }

    /// The message of a rod that is deformed too much, without the cure, which is none where the load is absurd; `None` for other
    /// statuses.
    pub fn without_cure(self, load_factor: f64) -> Option<String> {
        let Self::Invalid(shape) = self else { return None };
        let is_deformed = matches!(shape, InvalidShape::Unresolved { .. } | InvalidShape::Inverted { .. });
        is_deformed.then(|| ended(shape, load_factor))
    }

    /// Advice about quadrature `nodes` is for models with rods.
    fn message(self, load_factor: f64, has_rods: bool) -> String {
        match self {
            Self::Converged => "The forces are in equilibrium.".to_owned(),
            Self::Released => format!(
                "The forces are in equilibrium. The load path ended at load factor {load_factor:.6}, where the model \
                 was released and came to rest; slow loading need not lead to this shape."
            ),
            Self::Finished => "The path was followed to a bound of the load factor.".to_owned(),
            Self::NoStart => format!(
                "There is no equilibrium near `q0` at load factor {load_factor:.6}. Give a better `q0`, such as the `q` of \
                 `statics`."
            ),
            Self::StepTooSmall => format!(
                "The path of equilibria could not be followed beyond load factor {load_factor:.6}; `q` is the last one \
                 found. Two paths may nearly touch there: add a small load that favours one of them, or give a shape `q0` to \
                 release the model from{}.",
                if has_rods { "; or give the rod more quadrature `nodes`" } else { "" }
            ),
            Self::TooManySteps => format!(
                "The limit of steps was reached at load factor {load_factor:.6}; `q` is the last equilibrium found. \
                 Allow more `max_steps`, or give a shape `q0` to release the model from."
            ),
            Self::IterationLimit => "The limit of iterations was reached; `q` is the last shape. If there is any equilibrium, \
                 allow more `max_iter` or start closer to it; under follower loads there may be none that is stable."
                .to_owned(),
            Self::Stalled => format!(
                "No step reduces the energy, but the forces are not in equilibrium; `q` is the last shape. Start from another \
                 shape{}.",
                if has_rods {
                    "; if that fails too, give the rod more quadrature `nodes`: the discretised forces of a sharply bent \
                     rod need not have a potential"
                } else {
                    ""
                }
            ),
            Self::Unheld => "Nothing holds the model: in some direction the loads move it without limit, so that there is no \
                             equilibrium. Hold it by a joint, a support, a tendon or a contact; `q` is the last shape."
                .to_owned(),
            Self::NonFinite => "Forces or stiffnesses are NaN or infinite. Start from a smaller `q0`.".to_owned(),
            Self::Invalid(invalid_shape) => {
                let cure = match invalid_shape {
                    InvalidShape::Unresolved { shortage } => {
                        format!("Give the segment more `nodes`{}", at_least(shortage))
                    }
                    InvalidShape::Inverted { .. } => "The compression exceeds the axial stiffness of the rod, where linear elasticity does \
                                              not hold"
                        .to_owned(),
                    InvalidShape::Open { .. } => {
                        "Start from a `q0` in which the loops are nearly closed; loops that conflict cannot be closed at all"
                            .to_owned()
                    }
                    InvalidShape::DeepPenetration { .. } => {
                        "Start from a `q0` that touches nothing, or give the contact more `stiffness`".to_owned()
                    }
                    InvalidShape::Collapsed { .. } => {
                        "The tendon's force then has no direction: pull less, or keep the points apart with a joint that has `limits`"
                            .to_owned()
                    }
                };
                format!("{} {cure}.", ended(invalid_shape, load_factor))
            }
            Self::Newton(status) => status.message().to_owned(),
            Self::AccuracyNotReached => {
                "The forces are in equilibrium, but the numbers of modes do not give the requested accuracy.".to_owned()
            }
            Self::Interrupted => {
                format!("The search was interrupted at load factor {load_factor:.6}; this is what it had found by then.")
            }
        }
    }
}

fn ended(invalid_shape: InvalidShape, load_factor: f64) -> String {
    format!(
        "The search ended at load factor {load_factor:.6} in an invalid shape: the model {invalid_shape}."
    )
}

/// An equilibrium, or the last state of a failed search.
#[derive(Clone, Debug)]
pub struct Equilibrium {
    /// Coordinates, shape (n,); after a failure those of the last valid state.
    pub q: Vec<f64>,
    /// Load factor of the state.
    pub load_factor: f64,
    /// Status.
    pub status: Status,
    /// Status in words, with advice and notes on the equilibrium.
    pub message: String,
    /// `|s R|` in joules (generalised forces times typical coordinates), before the last step.
    pub residual_norm: f64,
    /// `|dq / s|` of the last Newton step: approximately the error of q.
    pub step_norm: f64,
    /// Stability; `None` if unknown or not requested.
    pub verdict: Option<Verdict>,
    /// Smallest eigenvalue of the (symmetric part of the) tangent stiffness relative to the stiffness of
    /// material and springs: one without load, zero at critical points.
    pub lowest: f64,
    /// The load path; empty if none was followed.
    pub path: Path,
    /// The overlap with the largest share of its surfaces' thickness, if any surfaces touch.
    pub deepest: Option<Overlap>,
    /// Counts of steps, iterations and evaluations.
    pub counters: Counters,
}

impl Equilibrium {
    /// Sets the status of an equilibrium that has not the requested accuracy, and says why. Failures stay as they are.
    pub fn miss_accuracy(&mut self, why: &str) {
        if self.status.is_success() {
            self.status = Status::AccuracyNotReached;
            self.message += &format!(" It has not the requested accuracy. {why}");
        }
    }
}

/// A path of equilibria.
#[derive(Clone, Debug)]
pub struct Continuation {
    /// The path.
    pub path: Path,
    /// Status.
    pub status: Status,
    /// Status in words, with advice.
    pub message: String,
    /// Counts of steps, iterations and evaluations.
    pub counters: Counters,
}

/// Describes the status, the stability (if it was judged) and critical points. `end` is the load factor at the end of the path.
pub(super) fn message(
    model: &dyn Static,
    status: Status,
    end: f64,
    is_judged: bool,
    verdict: Option<Verdict>,
    path: &Path,
) -> String {
    let mut message = status.message(end, model.facts().is_discretised);
    if status == Status::Finished || !status.is_success() {
        if let Some(taut) = model.facts().taut_loops.first().filter(|_| status != Status::Finished) {
            message += &format!(
                " A chain that does not stretch is taut, exactly as long as its ends are apart ({taut}): no finite force holds it \
                 against a load across. Give its rods modes of `stretch`, or a little more length."
            );
        }
        return message;
    }
    match verdict.map(|verdict| verdict.stability) {
        Some(Stability::Stable) => {}
        Some(Stability::Neutral) => {
            message += " In some direction it has no stiffness: it is a critical point, or free to turn.";
        }
        Some(Stability::Divergence) => {
            message += " It is unstable: small disturbances lead away from it.";
            let crossing = path.critical.iter().find(|point| point.kind == CriticalKind::Bifurcation);
            message += &match crossing {
                Some(point) => format!(
                    " The load path crossed a bifurcation at load factor {:.6}: give `q0`, a shape a little off in the \
                     direction found there, to reach the buckled equilibria.",
                    point.load_factor
                ),
                None => {
                    " Give a slightly different shape as `q0`: the model is released from there.".to_owned()
                }
            };
        }
        Some(Stability::Flutter) => {
            message += " It is unstable: small disturbances grow as oscillations (flutter).";
        }
        None if !is_judged => {}
        None => message += " Its stability is unknown: the mass matrix is singular there.",
    }
    if let Some(Verdict { stability, undamped }) = verdict
        && stability != undamped
    {
        let would = match undamped {
            Stability::Stable => "be stable",
            Stability::Neutral => "be neutral",
            Stability::Divergence => "diverge",
            Stability::Flutter => "flutter",
        };
        message += &format!(" Without damping, drag and Coriolis forces it would {would}.");
    }
    message
}
