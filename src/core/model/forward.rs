//! Accelerations by a solve with the mass matrix.

use crate::numerics::linalg::{Cholesky, Matrix, TreeLu, TreeMatrix};

/// The mass matrix is not positive definite (or not finite), so that accelerations do not exist.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SingularMass;

impl std::fmt::Display for SingularMass {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("the mass matrix is not positive definite, or not finite: no acceleration exists")
    }
}

impl std::error::Error for SingularMass {}

/// Zero matrices with the sparsity structure of a chain.
#[derive(Clone, Debug)]
pub struct Tree {
    /// Structure for [`super::Dynamics::tree_tangent`].
    pub tangent: TreeMatrix,
    /// Structure for [`super::Dynamics::tree_mass_matrix`].
    pub mass: TreeMatrix,
}

/// Memory for [`super::Dynamics::forward_dynamics`].
#[derive(Clone, Debug)]
pub struct ForwardScratch {
    pub(super) bias: Vec<f64>,
    pub(super) mass: Mass,
}

/// The mass matrix and its factors.
#[derive(Clone, Debug)]
#[allow(clippy::large_enum_variant, reason = "there is one, and it is not moved")]
pub(super) enum Mass {
    Dense { matrix: Matrix, cholesky: Cholesky },
    Tree { matrix: TreeMatrix, lu: TreeLu },
}

impl ForwardScratch {
    /// Scratch for a model of `n` coordinates with dense matrices.
    pub fn new(n: usize) -> Self {
        let mass = Mass::Dense { matrix: Matrix::zeros(n, n), cholesky: Cholesky::new(n) };
        Self { bias: vec![0.0; n], mass }
    }

    /// Forces without accelerations and the mass matrix, if that is dense, for [`Self::solve`].
    pub(crate) fn dense(&mut self) -> Option<(&mut [f64], &mut Matrix)> {
        match &mut self.mass {
            Mass::Dense { matrix, .. } => Some((&mut self.bias, matrix)),
            Mass::Tree { .. } => None,
        }
    }

    /// Solves `M qdd = -bias` for both as they are in memory.
    pub(crate) fn solve(&mut self, qdd: &mut [f64]) -> Result<(), SingularMass> {
        for (acceleration, bias) in qdd.iter_mut().zip(&self.bias) {
            *acceleration = -*bias;
        }
        match &mut self.mass {
            Mass::Dense { matrix, cholesky } => {
                cholesky.factorise(matrix).map_err(|_| SingularMass)?;
                cholesky.solve(qdd);
            }
            Mass::Tree { matrix, lu } => {
                lu.factorise(matrix).map_err(|_| SingularMass)?;
                lu.solve(qdd);
            }
        }
        Ok(())
    }
}
