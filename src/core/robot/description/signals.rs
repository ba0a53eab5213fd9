//! Prescribed forces and commands, as functions of time or inputs.

use crate::description::signal::{Signal, Timed};
use crate::robot::effects::actuator::Actuator;

/// The signal of a force or a command of a robot, with its place in the description.
#[derive(Clone, Copy, Debug)]
pub struct PlacedSignal<'a> {
    /// List and index of the part to which it belongs, if not to the robot itself.
    owner: Option<(&'static str, usize)>,
    key: &'static str,
    pub signal: SignalOf<'a>,
    /// The actuator that it commands.
    pub(super) commands: Option<&'a Actuator>,
}

/// The signal of a force or a command.
#[derive(Clone, Copy, Debug)]
pub enum SignalOf<'a> {
    /// A number, such as the command of an actuator.
    Number(&'a Signal<1>),
    /// A vector, such as a force.
    Vector(&'a Signal<3>),
}

impl<'a> PlacedSignal<'a> {
    pub(super) fn command(i: usize, key: &'static str, signal: &'a Signal<1>, of: &'a Actuator) -> Self {
        let signal = SignalOf::Number(signal);
        Self { owner: Some(("actuators", i)), key, signal, commands: Some(of) }
    }

    pub(super) fn vector(
        owner: Option<(&'static str, usize)>,
        key: &'static str,
        signal: &'a Signal<3>,
    ) -> Self {
        Self { owner, key, signal: SignalOf::Vector(signal), commands: None }
    }

    /// Its place in the description.
    pub(super) fn place(&self) -> String {
        let key = self.key;
        self.owner.map_or_else(|| key.to_owned(), |(list, i)| format!("{list}[{i}].{key}"))
    }

    pub(super) fn timed(self) -> &'a dyn Timed {
        match self.signal {
            SignalOf::Number(signal) => signal,
            SignalOf::Vector(signal) => signal,
        }
    }
}
