//! Stiffness, damping and the matrix of a step, factorised.

use crate::error::Interrupted;
use crate::linalg::{Lu, Matrix, Singular};
use crate::model::Model;

/// The tangents of a model at one state.
pub(super) struct Tangents {
    pub(super) stiffness: Matrix,
    pub(super) damping: Matrix,
    step: Matrix,
    lu: Lu,
}

impl Tangents {
    pub(super) fn new(n: usize) -> Self {
        let [stiffness, damping, step] = [0; 3].map(|_| Matrix::zeros(n, n));
        Self { stiffness, damping, step, lu: Lu::new(n) }
    }

    /// Those at a time and a state, and their sum with these weights.
    pub(super) fn evaluate<M: Model + ?Sized>(
        &mut self,
        model: &mut M,
        t: f64,
        [q, v, a]: [&[f64]; 3],
        weights: [f64; 3],
    ) -> Result<(), Interrupted> {
        model.set_time(t)?;
        model.weighted_tangent(q, v, a, [1.0, 0.0, 0.0], &mut self.stiffness);
        model.weighted_tangent(q, v, a, [0.0, 1.0, 0.0], &mut self.damping);
        model.weighted_tangent(q, v, a, weights, &mut self.step);
        Ok(())
    }

    /// Factorises the weighted sum, or its transpose.
    pub(super) fn factorise(&mut self, is_transposed: bool) -> Result<(), Singular> {
        if is_transposed {
            for i in 0..self.step.nrows() {
                for j in 0..i {
                    self.step.swap((i, j), (j, i));
                }
            }
        }
        self.lu.factorise(&self.step)
    }

    pub(super) fn solve(&mut self, b: &mut [f64]) {
        self.lu.solve(b);
    }
}
