//! Errors of the target poses as equations in the scaled inputs.

use super::equilibria::Equilibria;
use crate::error::Interrupted;
use crate::linalg::Matrix;
use crate::reach::misfit::Misfit;
use crate::roots::System;
use crate::roots::least_squares::LeastSquares;

/// The targets of a robot in the equilibrium that belongs to its inputs.
pub(super) struct Actuated<'a, 'b> {
    pub(super) equilibria: Equilibria<'a, 'b>,
    /// In coordinates over their typical sizes.
    pub(super) targets: Misfit<'a, 'b>,
    /// All inputs, of which those in `free` change.
    u: Vec<f64>,
    free: Vec<usize>,
    /// Sizes of those.
    sizes: Vec<f64>,
    of_shape: Matrix,
}

impl<'a, 'b> Actuated<'a, 'b> {
    pub(super) fn new(
        equilibria: Equilibria<'a, 'b>,
        targets: Misfit<'a, 'b>,
        u: Vec<f64>,
        free: Vec<usize>,
        sizes: Vec<f64>,
    ) -> Self {
        let of_shape = Matrix::zeros(targets.equations(), targets.unknowns());
        Self { equilibria, targets, u, free, sizes, of_shape }
    }

    /// All inputs, of unknowns.
    pub(super) fn inputs(&mut self, x: &[f64]) -> Vec<f64> {
        for ((&entry, x), size) in self.free.iter().zip(x).zip(&self.sizes) {
            self.u[entry] = x * size;
        }
        self.u.clone()
    }

    fn scaled(&self, q: &[f64]) -> Vec<f64> {
        q.iter().zip(&self.targets.sizes).map(|(q, size)| q / size).collect()
    }
}

impl System for Actuated<'_, '_> {
    fn unknowns(&self) -> usize {
        self.free.len()
    }

    fn equations(&self) -> usize {
        self.targets.equations()
    }

    /// NaN where there is no equilibrium on the way.
    fn residual(&mut self, x: &[f64], residual: &mut [f64]) -> Result<(), Interrupted> {
        let u = self.inputs(x);
        let Some(q) = self.equilibria.at(&u)?.map(<[f64]>::to_vec) else {
            residual.fill(f64::NAN);
            return Ok(());
        };
        let shape = self.scaled(&q);
        self.targets.residual(&shape, residual)
    }

    fn jacobian(&mut self, x: &[f64], jacobian: &mut Matrix) -> Result<(), Interrupted> {
        let u = self.inputs(x);
        // Whoever asks for the derivative at the latest inputs goes on from there.
        self.equilibria.settle_at(&u);
        let q = self.equilibria.at(&u)?.map(<[f64]>::to_vec);
        let change = if q.is_some() { self.equilibria.sensitivity()? } else { None };
        let (Some(q), Some(change)) = (q, change) else {
            jacobian.fill(f64::NAN);
            return Ok(());
        };
        let shape = self.scaled(&q);
        self.targets.jacobian(&shape, &mut self.of_shape)?;
        for (k, (&entry, size)) in self.free.iter().zip(&self.sizes).enumerate() {
            let column = &self.of_shape * change.column(entry) * *size;
            jacobian.column_mut(k).copy_from(&column);
        }
        Ok(())
    }
}

impl LeastSquares for Actuated<'_, '_> {}
