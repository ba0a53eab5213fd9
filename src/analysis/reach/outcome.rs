//! The result of a search for a shape.

use super::misfit::Error;
use crate::error::Rounded;
use crate::model::{InvalidShape, at_least};
use crate::numerics::roots::least_squares::{Counters, End};
use crate::robot::{Pose, Robot};

/// Status of the search.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Status {
    /// All targets are reached, by the preferred shape if there is a preference.
    Reached,
    /// All targets are reached, but the search for the preferred shape did not converge.
    NotSettled,
    /// A local minimum of the errors, by first and second derivatives.
    Nearest,
    /// A local minimum with coordinates at their limits; without the limits the errors would decrease.
    AtLimits,
    /// The limit of iterations was reached.
    IterationLimit,
    /// No step, however short, reduces the errors.
    Stalled,
    /// The search leads to invalid shapes.
    Invalid(InvalidShape),
    /// The monitor asked to stop.
    Interrupted,
}

impl Status {
    pub(super) fn of(end: End, is_held: bool, invalid_shape: Option<InvalidShape>) -> Self {
        match end {
            End::Root => Self::Reached,
            End::Minimum if is_held => Self::AtLimits,
            End::Minimum => Self::Nearest,
            End::IterationLimit => Self::IterationLimit,
            End::Stalled | End::NonFinite => invalid_shape.map_or(Self::Stalled, Self::Invalid),
            End::Interrupted => Self::Interrupted,
        }
    }

    /// True if all targets are reached by the preferred shape.
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
            Self::IterationLimit => "iteration_limit",
            Self::Stalled => "stalled",
            Self::Invalid(InvalidShape::Unresolved { .. }) => "unresolved",
            Self::Invalid(InvalidShape::Inverted { .. }) => "inverted",
            Self::Invalid(InvalidShape::Collapsed { .. }) => "collapsed",
            Self::Invalid(InvalidShape::Open { .. }) => "loop_open",
            Self::Invalid(InvalidShape::DeepPenetration { .. }) => "deep_penetration",
            Self::Interrupted => "interrupted",
        }
    }
}

/// A shape and the remaining errors of the targets.
#[derive(Clone, Debug, PartialEq)]
pub struct Reached {
    /// Coordinates, with rotation vectors of at most half a turn: of the best shape found if the targets are
    /// not reached.
    pub q: Vec<f64>,
    /// How the search ended.
    pub status: Status,
    /// Status in words, with numbers and advice.
    pub message: String,
    /// Error of each target.
    pub errors: Vec<Error>,
    /// Poses of the targets' sections and bodies.
    pub poses: Vec<Pose>,
    /// Indices of coordinates at limits that prevent smaller errors.
    pub at_limits: Vec<usize>,
    /// Number of starts.
    pub starts: usize,
    /// Total counts of all starts.
    pub counters: Counters,
}

/// Describes the result; `invalid_shape` is the problem of the last invalid shape of the search.
pub(super) fn message(
    status: Status,
    robot: &Robot,
    errors: impl Iterator<Item = (usize, Error)>,
    at_limits: &[usize],
    starts: usize,
    invalid_shape: Option<InvalidShape>,
) -> String {
    let from = if starts == 1 { "one start".to_owned() } else { format!("{starts} starts") };
    let said = match status {
        Status::Reached => return "All targets are reached.".to_owned(),
        Status::NotSettled => {
            let reached = "All targets are reached, but the search for the preferred shape among those that reach \
                           them did not converge";
            return match invalid_shape {
                Some(invalid_shape) => format!("{reached}: it leads to shapes in which a rod {invalid_shape}. Start elsewhere."),
                None => format!(
                    "{reached}. At the edge of the workspace there is nothing to choose: leave `prefer` out; \
                     otherwise start elsewhere."
                ),
            };
        }
        Status::Nearest => format!(
            "The targets are not reached. No small change of this shape brings the links nearer; it is the best \
             one found from {from}. Another q0 or more `restarts` may find a better one, if there is any."
        ),
        Status::AtLimits => {
            let names = robot.coordinate_names();
            let held: Vec<&str> = at_limits.iter().map(|&k| names[k].as_str()).collect();
            format!(
                "The targets are not reached. Within the limits, no small change of this shape brings the links \
                 nearer; it is the best one found from {from}. {} held back.",
                are(&held)
            )
        }
        Status::IterationLimit => {
            "The limit of iterations was reached. Allow more `max_iter`, or start elsewhere.".to_owned()
        }
        Status::Stalled => {
            "No step, however short, brings the links nearer, although the derivatives predict it. Start elsewhere."
                .to_owned()
        }
        Status::Interrupted => format!("The search was interrupted; this is the best shape from {from} until then."),
        Status::Invalid(invalid_shape) => {
            let nodes = match invalid_shape {
                InvalidShape::Unresolved { shortage } => format!(" It needs more `nodes`{}.", at_least(shortage)),
                InvalidShape::Inverted { .. } | InvalidShape::Collapsed { .. } | InvalidShape::Open { .. } | InvalidShape::DeepPenetration { .. } => {
                    String::new()
                }
            };
            format!("The search ended at a shape in which a rod {invalid_shape}.{nodes} Start elsewhere.")
        }
    };
    let (left, units) = remaining(robot, errors);
    format!("{said} Remaining error: {left}.{units}")
}

/// The remaining errors of links in words, and a question about units where they are much larger than the robot.
pub(crate) fn remaining(robot: &Robot, errors: impl Iterator<Item = (usize, Error)>) -> (String, String) {
    let (mut largest, mut listed) = (0.0_f64, Vec::new());
    for (link, Error { position, orientation }) in errors {
        let name = &robot.links[link].name;
        listed.push(is_off(name, position, orientation));
        largest = largest.max(position);
    }
    (listed.join(", "), question_of_units(robot, largest))
}

/// The question about targets that are missed by much more than the size of the robot; empty otherwise.
fn question_of_units(robot: &Robot, error: f64) -> String {
    /// Errors over the length of the robot. Targets in millimetres or centimetres are off by more.
    const FAR: f64 = 10.0;
    let length = robot.length();
    match error > FAR * length {
        true => format!(" The robot is {length:.3} m long: are the targets in metres?"),
        false => String::new(),
    }
}

/// By how much a link misses its target.
fn is_off(link: &str, position: f64, orientation: f64) -> String {
    format!("'{link}' is off by {} m and {} rad", Rounded(position), Rounded(orientation))
}

/// "a is", "a, b and 7 others are".
fn are(names: &[&str]) -> String {
    /// Longer lists would not be read.
    const MAX_LISTED: usize = 5;
    match names {
        [one] => format!("{one} is"),
        _ if names.len() <= MAX_LISTED => {
            let (last, others) = names.split_last().expect("there are some");
            format!("{} and {last} are", others.join(", "))
        }
        _ => format!("{} and {} others are", names[..MAX_LISTED].join(", "), names.len() - MAX_LISTED),
    }
}
