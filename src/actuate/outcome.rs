//! The result of a search for inputs.

use super::equilibria::Lost;
use crate::model::Flaw;
use crate::reach::Error;
use crate::robot::{Pose, Robot};
use crate::roots::least_squares::{Counters, End};
use crate::stability::{Stability, Verdict};
use crate::statics;

/// How a search ended.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Status {
    /// All targets are reached, by the least inputs nearby.
    Reached,
    /// All targets are reached, but the search for the least inputs that do so did not end.
    NotSettled,
    /// Inputs of which no small change brings the links nearer, by first and second derivatives.
    Nearest,
    /// The same with inputs at their limits, without which there would be nearer ones.
    AtLimits,
    /// The way to the targets ends where there is no equilibrium near the present one any more.
    EquilibriumLost,
    /// There is no equilibrium at the inputs at which the search begins.
    NoStart,
    /// The limit of iterations was reached.
    IterationLimit,
    /// No step, however short, brings the links nearer.
    Stalled,
}

impl Status {
    pub(super) fn of(end: End, is_held: bool, lost: Option<Lost>) -> Self {
        match end {
            End::Root => Self::Reached,
            // No longer step was possible, and shorter ones gain nothing.
            End::Minimum if lost.is_some() => Self::EquilibriumLost,
            End::Minimum if is_held => Self::AtLimits,
            End::Minimum => Self::Nearest,
            End::IterationLimit => Self::IterationLimit,
            End::Stalled | End::NonFinite if lost.is_some() => Self::EquilibriumLost,
            End::Stalled => Self::Stalled,
            // A stiffness that is zero has no derivative.
            End::NonFinite => Self::EquilibriumLost,
        }
    }

    /// True when what was asked for was found.
    pub fn is_success(self) -> bool {
        self == Self::Reached
    }

    /// A stable name in lower case.
    pub fn name(self) -> &'static str {
        match self {
            Self::Reached => "reached",
            Self::NotSettled => "not_settled",
            Self::Nearest => "nearest",
            Self::AtLimits => "at_limits",
            Self::EquilibriumLost => "equilibrium_lost",
            Self::NoStart => "no_start",
            Self::IterationLimit => "iteration_limit",
            Self::Stalled => "stalled",
        }
    }
}

/// Inputs, and how near the shape that belongs to them brings the links.
#[derive(Clone, Debug)]
pub struct Found {
    /// All inputs, shape (m,): those that come nearest, where none reach.
    pub u: Vec<f64>,
    /// The equilibrium that belongs to them, shape (n,).
    pub q: Vec<f64>,
    /// How the search ended.
    pub status: Status,
    /// The same in words, with numbers, and what to change.
    pub message: String,
    /// What is left of every target.
    pub errors: Vec<Error>,
    /// Where their sections and bodies are.
    pub poses: Vec<Pose>,
    /// The entries of u that their limits hold back.
    pub held: Vec<usize>,
    /// What small disturbances of the equilibrium do; `None` where that is unknown.
    pub verdict: Option<Verdict>,
    /// What the search took: steps, residuals and Jacobians.
    pub counters: Counters,
    /// Equilibria that it looked for.
    pub equilibria: usize,
}

/// What happened, in words; `slack` are tendons whose lengths were to be found.
pub(super) fn message(
    status: Status,
    robot: &Robot,
    errors: impl Iterator<Item = (usize, Error)>,
    held: &[usize],
    lost: Option<Lost>,
    slack: &[String],
    verdict: Option<Verdict>,
) -> String {
    let stable = match verdict.map(|verdict| verdict.stability) {
        Some(Stability::Divergence | Stability::Flutter) => {
            " The equilibrium is unstable: it does not stay there by itself."
        }
        _ => "",
    };
    let said = match status {
        Status::Reached => return format!("All targets are reached.{stable}"),
        Status::NotSettled => {
            return format!(
                "All targets are reached, but the search for the smallest such inputs did not converge. At the edge \
                 of the workspace there is nothing to choose.{stable}"
            );
        }
        Status::Nearest => "The targets cannot be reached from here: no small change of the inputs brings the links \
                            nearer. Other initial inputs `u` may find a better place, if there is any."
            .to_owned(),
        Status::AtLimits => {
            let names = robot.inputs().names();
            let held: Vec<String> = held.iter().map(|&k| format!("'{}'", names[k])).collect();
            format!(
                "The targets cannot be reached within the limits: no small change of the inputs brings the links \
                 nearer. {} held back.",
                are(&held)
            )
        }
        Status::EquilibriumLost => {
            let why = match lost {
                Some(Lost::Limit) | None => "beyond these inputs it buckles or snaps to another shape",
                Some(Lost::Way(statics::Status::Flawed(Flaw::Inverted { .. }))) => {
                    "beyond these inputs a rod would be turned inside out"
                }
                Some(Lost::Way(statics::Status::Flawed(Flaw::Unresolved { .. }))) => {
                    "beyond these inputs a rod turns too much for its quadrature `nodes`"
                }
                Some(Lost::Way(_)) => {
                    "beyond these inputs its equilibria cannot be followed: it buckles or snaps there, or nearly so"
                }
            };
            format!("The search ended before the targets: {why}. Start from other inputs `u`.")
        }
        Status::NoStart => {
            "There is no equilibrium at the initial inputs. Give other ones as `u`, or a shape `q0` near their \
             equilibrium."
                .to_owned()
        }
        Status::IterationLimit => {
            "The limit of iterations was reached. Allow more `max_iter`, or start from other inputs `u`.".to_owned()
        }
        Status::Stalled => "No step, however short, brings the links nearer, although the derivatives predict it. \
                            Start from other inputs `u`."
            .to_owned(),
    };
    let left = errors.map(|(link, error)| {
        let Error { position, orientation } = error;
        format!("'{}' is off by {position:.3e} m and {orientation:.3e} rad", robot.links[link].name)
    });
    let left = left.collect::<Vec<_>>().join(", ");
    let slack = match slack {
        [] => String::new(),
        names => {
            let quoted: Vec<String> = names.iter().map(|name| format!("'{name}'")).collect();
            format!(
                " {} slack there: a small change of its length does nothing. Begin with shorter lengths `u`.",
                are(&quoted)
            )
        }
    };
    format!("{said} Remaining error: {left}.{slack}{stable}")
}

/// "'a' is", "'a' and 'b' are".
fn are(names: &[String]) -> String {
    match names.split_last() {
        Some((last, [])) => format!("{last} is"),
        Some((last, others)) => format!("{} and {last} are", others.join(", ")),
        None => "nothing is".to_owned(),
    }
}
