//! The result of a search for inputs.

use super::equilibria::NoEquilibrium;
use crate::analysis::reach::{Error, remaining};
use crate::analysis::stability::{Stability, Verdict};
use crate::analysis::statics;
use crate::model::InvalidShape;
use crate::numerics::roots::least_squares::{Counters, End};
use crate::robot::effects::actuator::{Actuator, Motor, MotorCommand};
use crate::robot::{Pose, Robot};

/// Status of the search.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Status {
    /// All targets are reached, by the smallest inputs nearby.
    Reached,
    /// All targets are reached, but the search for the smallest such inputs did not converge.
    NotSettled,
    /// A local minimum of the errors, by first and second derivatives.
    Nearest,
    /// A local minimum with inputs at their limits; without the limits the errors would decrease.
    AtLimits,
    /// On the path to the targets the equilibrium ceases to exist.
    EquilibriumLost,
    /// No equilibrium was found at the initial inputs.
    NoStart,
    /// The limit of iterations was reached.
    IterationLimit,
    /// No step, however short, reduces the errors.
    Stalled,
    /// The monitor asked to stop.
    Interrupted,
}

impl Status {
    pub(super) fn of(end: End, is_held: bool, no_equilibrium: Option<NoEquilibrium>) -> Self {
        match end {
            End::Root => Self::Reached,
            // Longer steps lose the equilibrium, and shorter ones do not reduce the errors.
            End::Minimum if no_equilibrium.is_some() => Self::EquilibriumLost,
            End::Minimum if is_held => Self::AtLimits,
            End::Minimum => Self::Nearest,
            End::IterationLimit => Self::IterationLimit,
            End::Stalled | End::NonFinite if no_equilibrium.is_some() => Self::EquilibriumLost,
            End::Stalled => Self::Stalled,
            // At zero stiffness the equilibrium has no derivative.
            End::NonFinite => Self::EquilibriumLost,
            End::Interrupted => Self::Interrupted,
        }
    }

    /// True if all targets are reached.
    pub fn is_success(self) -> bool {
        self == Self::Reached
    }

    /// Stable name in lower case.
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
            Self::Interrupted => "interrupted",
        }
    }
}

/// Inputs, the equilibrium at these inputs, and the remaining errors of the targets.
#[derive(Clone, Debug)]
pub struct Found {
    /// All inputs, shape (m,): the best ones found if the targets are not reached.
    pub u: Vec<f64>,
    /// Equilibrium at these inputs, shape (n,).
    pub q: Vec<f64>,
    /// How the search ended.
    pub status: Status,
    /// Status in words, with numbers and advice.
    pub message: String,
    /// Remaining error of each target.
    pub errors: Vec<Error>,
    /// Poses of the targets' sections and bodies.
    pub poses: Vec<Pose>,
    /// Entries of u at limits that prevent smaller errors.
    pub at_limits: Vec<usize>,
    /// Stability of the equilibrium; `None` if unknown.
    pub verdict: Option<Verdict>,
    /// Numbers of steps, residuals and Jacobians.
    pub counters: Counters,
    /// Number of equilibria computed.
    pub equilibria: usize,
}

/// What to do where constant torques hold no posture.
const HELD_BY_TORQUES: &str = " Constant torques hold no raised arm, which falls when disturbed: \
     `robot.inverse_dynamics(q, 0 * q, 0 * q)` has the torques of a posture, such as the `q` of `robot.reach(target)`, for a controller \
     that keeps it there.";

/// Whether inputs set torques of motors, which do not hold joints in their places.
fn is_held_by_torques(robot: &Robot) -> bool {
    let is_torque = |actuator: &Actuator| match actuator {
        Actuator::Motor(Motor { command: MotorCommand::Torque(torque), .. }) => torque.input().is_some(),
        _ => false,
    };
    robot.actuators.iter().any(is_torque)
}

/// Why no equilibrium was found beyond some inputs.
fn reason(no_equilibrium: Option<NoEquilibrium>, robot: &Robot) -> String {
    match no_equilibrium {
        Some(NoEquilibrium::Limit) | None => {
            "beyond these inputs it is unstable, and buckles or snaps to another shape".to_owned()
        }
        Some(NoEquilibrium::Continuation(statics::Status::Invalid(InvalidShape::Inverted { .. }))) => {
            "beyond these inputs a rod would be turned inside out".to_owned()
        }
        Some(NoEquilibrium::Continuation(statics::Status::Invalid(InvalidShape::Unresolved { .. }))) => {
            "beyond these inputs a rod turns too much for its quadrature `nodes`".to_owned()
        }
        Some(NoEquilibrium::Continuation(statics::Status::Invalid(InvalidShape::DeepPenetration {
            contact,
            ..
        }))) => format!(
            "beyond these inputs the surfaces of contact \"{}\" would be sunk into each other: give it more `stiffness`",
            robot.contacts[contact].name
        ),
        Some(NoEquilibrium::Continuation(_)) => {
            "beyond these inputs its equilibria cannot be followed: it becomes unstable, and buckles or snaps there, or nearly so"
                .to_owned()
        }
    }
}

/// Describes the result; `slack` lists slack tendons whose lengths are free.
pub(super) fn message(
    status: Status,
    robot: &Robot,
    errors: impl Iterator<Item = (usize, Error)>,
    at_limits: &[usize],
    no_equilibrium: Option<NoEquilibrium>,
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
            let held: Vec<String> = at_limits.iter().map(|&k| format!("'{}'", names[k])).collect();
            format!(
                "The targets cannot be reached within the limits: no small change of the inputs brings the links \
                 nearer. {} held back.",
                are(&held)
            )
        }
        Status::EquilibriumLost => {
            let why = reason(no_equilibrium, robot);
            let by_torques = if is_held_by_torques(robot) { HELD_BY_TORQUES } else { "" };
            format!("The search ended before the targets: {why}. Start from other inputs `u`.{by_torques}")
        }
        Status::NoStart => {
            "There is no equilibrium at the initial inputs. Give other ones as `u`, or a shape `q0` near their \
             equilibrium."
                .to_owned()
        }
        Status::IterationLimit => {
            "The limit of iterations was reached. Allow more `max_iter`, or start from other inputs `u`.".to_owned()
        }
        Status::Interrupted => "The search was interrupted; these are the best inputs until then.".to_owned(),
        Status::Stalled => "No step, however short, brings the links nearer, although the derivatives predict it. \
                            Start from other inputs `u`."
            .to_owned(),
    };
    let (left, units) = remaining(robot, errors);
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
    format!("{said} Remaining error: {left}.{units}{slack}{stable}")
}

/// "'a' is", "'a' and 'b' are".
fn are(names: &[String]) -> String {
    match names.split_last() {
        Some((last, [])) => format!("{last} is"),
        Some((last, others)) => format!("{} and {last} are", others.join(", ")),
        None => "nothing is".to_owned(),
    }
}
