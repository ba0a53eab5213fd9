//! Commands of loads and actuators.

use crate::error::Interrupted;
use crate::robot::description::Inputs;
use crate::signal::Signal;

/// N numbers that are known in time or set from outside.
#[derive(Clone, Debug)]
pub(crate) enum Command<const N: usize> {
    InTime(Signal<N>),
    /// From this entry of the inputs on.
    Input(usize),
}

impl<const N: usize> Command<N> {
    pub(crate) fn new(signal: &Signal<N>, inputs: &Inputs) -> Self {
        match signal.input() {
            Some(input) => Self::Input(inputs.place(input)),
            None => Self::InTime(signal.clone()),
        }
    }

    /// The value at a time, with these inputs. Only a function can fail.
    pub(crate) fn at(&self, t: f64, inputs: &[f64]) -> Result<[f64; N], Interrupted> {
        match self {
            Self::InTime(signal) => signal.at(t),
            &Self::Input(first) => Ok(std::array::from_fn(|i| inputs[first + i])),
        }
    }

    /// Its first two derivatives in time; inputs are held. Only a function can fail.
    pub(crate) fn rates(&self, t: f64) -> Result<[[f64; N]; 2], Interrupted> {
        match self {
            Self::InTime(signal) => signal.rates(t),
            Self::Input(_) => Ok([[0.0; N]; 2]),
        }
    }

    /// Where it stands among the inputs.
    pub(crate) fn input(&self) -> Option<usize> {
        if let &Self::Input(first) = self { Some(first) } else { None }
    }

    /// Whether it depends on time by itself.
    pub(crate) fn varies_in_time(&self) -> bool {
        matches!(self, Self::InTime(signal) if signal.varies_in_time())
    }
}
