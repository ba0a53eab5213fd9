//! Errors of the target poses as a function of the scaled inputs.

use super::equilibria::Equilibria;
use crate::analysis::reach::misfit::Misfit;
use crate::error::Interrupted;
use crate::numerics::linalg::Matrix;
use crate::numerics::roots::NonlinearSystem;
use crate::numerics::roots::least_squares::LeastSquares;

/// Targets of a robot at the equilibrium for its inputs.
pub(super) struct Actuated<'a, 'b> {
    pub(super) equilibria: Equilibria<'a, 'b>,
    /// Targets as a function of scaled coordinates.
    pub(super) targets: Misfit<'a, 'b>,
    /// All inputs; entries in `free` are unknowns.
    u: Vec<f64>,
    free: Vec<usize>,
    /// Scales of the free inputs.
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

    /// All inputs for these unknowns.
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

impl NonlinearSystem for Actuated<'_, '_> {
    fn unknowns(&self) -> usize {
        self.free.len()
    }

    fn equations(&self) -> usize {
        self.targets.equations()
    }

    /// NaN if no equilibrium is found.
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
        // The solver requests a Jacobian only at an accepted iterate.
        self.equilibria.move_anchor(&u);
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
