//! Commands, limits and defaults of the entries of u.

use crate::description::signal::Input;
use crate::robot::Robot;
use crate::robot::effects::actuator::{Actuator, Drive, MotorCommand};

/// Quantity that an input commands. All inputs of one kind have the same unit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    Force,
    Moment,
    Tension,
    Length,
    Pressure,
    Torque,
    Position,
    Amount,
    Sliding,
}

/// An entry of u.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Command {
    pub(super) kind: Kind,
    pub(super) limits: [f64; 2],
    /// Value without effect; the default value for lengths and positions.
    pub(super) least: f64,
}

const UNBOUNDED: [f64; 2] = [f64::NEG_INFINITY, f64::INFINITY];
const NOT_NEGATIVE: [f64; 2] = [0.0, f64::INFINITY];

/// One command for each entry of u of a robot.
pub(super) fn commands(robot: &Robot) -> Vec<Command> {
    let inputs = robot.inputs();
    let mut commands =
        vec![Command { kind: Kind::Force, limits: UNBOUNDED, least: 0.0 }; inputs.defaults().len()];
    // In reverse order, so that the first of several commands with the same input name decides.
    let of_loads = robot.loads.iter().flat_map(|load| {
        [(&load.force, Kind::Force), (&load.moment, Kind::Moment)]
            .map(|(signal, kind)| (signal.input().map(|input| place(&inputs, input)), kind, UNBOUNDED))
    });
    let of_actuators = robot.actuators.iter().flat_map(|actuator| {
        let (kind, limits) = match actuator {
            Actuator::Tendon(tendon) => match tendon.drive {
                Drive::Tension(_) => (Kind::Tension, NOT_NEGATIVE),
                Drive::Length { .. } => (Kind::Length, NOT_NEGATIVE),
            },
            Actuator::Chamber(_) => (Kind::Pressure, UNBOUNDED),
            Actuator::Motor(motor) => match motor.command {
                MotorCommand::Torque(_) => (Kind::Torque, motor.limits.unwrap_or(UNBOUNDED)),
                MotorCommand::Position { .. } => (Kind::Position, UNBOUNDED),
            },
            Actuator::ActiveStrain(_) => (Kind::Amount, UNBOUNDED),
        };
        let command = actuator.command().input().map(|input| place(&inputs, input));
        let sliding = actuator.sliding().and_then(|signal| signal.input()).map(|input| place(&inputs, input));
        [(sliding, Kind::Sliding, [-1.0, 1.0]), (command, kind, limits)]
    });
    let all: Vec<_> = of_loads.chain(of_actuators).collect();
    for (entries, kind, limits) in all.into_iter().rev() {
        for entry in entries.into_iter().flatten() {
            let is_set = matches!(kind, Kind::Length | Kind::Position | Kind::Sliding);
            let least = if is_set { inputs.defaults()[entry] } else { 0.0 };
            commands[entry] = Command { kind, limits, least };
        }
    }
    commands
}

fn place<const N: usize>(inputs: &crate::robot::Inputs, input: &Input<N>) -> std::ops::Range<usize> {
    let first = inputs.place(input);
    first..first + N
}
