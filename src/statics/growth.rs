//! What grows along a path of equilibria: all loads together, or inputs from one place to another.

use crate::error::{Checker, Interrupted};
use crate::linalg::Matrix;
use crate::model::Model;

/// Inputs that go from one place to another along a path.
#[derive(Clone, Debug, PartialEq)]
pub struct InputPath {
    /// u where the load factor is zero, shape (m,).
    pub from: Vec<f64>,
    /// u where it is one.
    pub to: Vec<f64>,
    /// The time at which the model is, in seconds: where something varies in it, it is set anew with the inputs.
    pub time: f64,
}

impl InputPath {
    pub(super) fn check(&self, check: &mut Checker, m: usize) {
        for (values, place) in [(&self.from, "inputs.from"), (&self.to, "inputs.to")] {
            if check.length(values, m, place) {
                check.finite(values, place);
            }
        }
        let moves = self.from != self.to;
        check.require(moves, "inputs", "inputs that stay what they are", "at least one that changes");
    }
}

/// What the load factor says.
pub(super) enum Growth {
    /// The part of all loads that acts.
    Loads,
    /// How far inputs have come.
    Inputs(Inputs),
}

/// Inputs on their way.
pub(super) struct Inputs {
    from: Vec<f64>,
    change: Vec<f64>,
    time: f64,
    /// Where they are set.
    at: f64,
    /// Derivative of the generalised forces with respect to all inputs.
    tangent: Matrix,
}

impl Growth {
    pub(super) fn of_inputs(path: &InputPath, n: usize) -> Self {
        let InputPath { from, to, time } = path.clone();
        let change = from.iter().zip(&to).map(|(from, to)| to - from).collect();
        let tangent = Matrix::zeros(n, from.len());
        Self::Inputs(Inputs { from, change, time, at: f64::NAN, tangent })
    }

    /// Sets the inputs of a model, unless they are there.
    pub(super) fn set(&mut self, model: &mut dyn Model, load_factor: f64) -> Result<(), Interrupted> {
        let Self::Inputs(inputs) = self else { return Ok(()) };
        if inputs.at != load_factor {
            model.set_inputs(&inputs.at(load_factor));
            model.set_time(inputs.time)?;
            inputs.at = load_factor;
        }
        Ok(())
    }

    /// The inputs at a load factor, where they are what grows.
    pub(super) fn inputs_at(&self, load_factor: f64) -> Option<Vec<f64>> {
        if let Self::Inputs(inputs) = self { Some(inputs.at(load_factor)) } else { None }
    }
}

impl Inputs {
    fn at(&self, load_factor: f64) -> Vec<f64> {
        self.from.iter().zip(&self.change).map(|(from, change)| from + load_factor * change).collect()
    }

    /// The derivative of the generalised forces with respect to the load factor.
    pub(super) fn load(&mut self, model: &mut dyn Model, q: &[f64], rest: &[f64], load: &mut [f64]) {
        model.input_tangent(q, rest, rest, &mut self.tangent);
        load.fill(0.0);
        for (column, change) in self.tangent.column_iter().zip(&self.change).filter(|(_, x)| **x != 0.0) {
            load.iter_mut().zip(column.iter()).for_each(|(load, entry)| *load += entry * change);
        }
    }
}
