//! Commands of loads and actuators.

use crate::description::signal::{Signal, StepContext};
use crate::error::Interrupted;
use crate::robot::description::Inputs;

/// N numbers given as functions of time or as inputs.
#[derive(Clone, Debug)]
pub(crate) enum Command<const N: usize> {
    InTime(Signal<N>),
    /// Inputs starting at this index.
    Input(usize),
}

impl<const N: usize> Command<N> {
    pub(crate) fn new(signal: &Signal<N>, inputs: &Inputs) -> Self {
        match signal.input() {
            Some(input) => Self::Input(inputs.place(input)),
            None => Self::InTime(signal.clone()),
        }
    }

    /// Value at a time with these inputs. Only a function can fail.
    pub(crate) fn at(
        &self,
        t: f64,
        step_context: StepContext,
        inputs: &[f64],
    ) -> Result<[f64; N], Interrupted> {
        match self {
            Self::InTime(signal) => signal.value_in_step(t, step_context),
            &Self::Input(first) => Ok(std::array::from_fn(|i| inputs[first + i])),
        }
    }

    /// First two time derivatives with constant inputs. Only a function can fail.
    pub(crate) fn rates(&self, t: f64, step_context: StepContext) -> Result<[[f64; N]; 2], Interrupted> {
        match self {
            Self::InTime(signal) => signal.rates(t, step_context),
            Self::Input(_) => Ok([[0.0; N]; 2]),
        }
    }

    /// Index among the inputs.
    pub(crate) fn input(&self) -> Option<usize> {
        if let &Self::Input(first) = self { Some(first) } else { None }
    }

    /// Whether the command depends on time explicitly.
    pub(crate) fn varies_in_time(&self) -> bool {
        matches!(self, Self::InTime(signal) if signal.varies_in_time())
    }
}
