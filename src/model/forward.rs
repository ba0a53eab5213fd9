//! Accelerations by a solve with the mass matrix.

use super::Dynamics;
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
    /// Structure for [`Dynamics::tree_tangent`].
    pub tangent: TreeMatrix,
    /// Structure for [`Dynamics::tree_mass_matrix`].
    pub mass: TreeMatrix,
}

/// Memory for [`Dynamics::forward_dynamics`].
#[derive(Clone, Debug)]
pub struct ForwardScratch {
    bias: Vec<f64>,
    mass: Mass,
}

/// The mass matrix and its factors.
#[derive(Clone, Debug)]
#[allow(clippy::large_enum_variant, reason = "there is one, and it is not moved")]
enum Mass {
    Dense { matrix: Matrix, cholesky: Cholesky },
    Tree { matrix: TreeMatrix, lu: TreeLu },
}

impl ForwardScratch {
    /// Scratch for a model of `n` coordinates with dense matrices.
    pub fn new(n: usize) -> Self {
        let mass = Mass::Dense { matrix: Matrix::zeros(n, n), cholesky: Cholesky::new(n) };
        Self { bias: vec![0.0; n], mass }
    }

    /// Scratch for `model`.
    pub fn of<M: Dynamics + ?Sized>(model: &M) -> Self {
        match model.tree() {
            Some(Tree { mass, .. }) => {
                let lu = TreeLu::new(&mass);
                Self { bias: vec![0.0; model.facts().n], mass: Mass::Tree { matrix: mass, lu } }
            }
            None => Self::new(model.facts().n),
        }
    }
}

/// [`Dynamics::forward_dynamics`] for models without constraints.
pub(crate) fn solve<M: Dynamics + ?Sized>(
    model: &mut M,
    q: &[f64],
    qd: &[f64],
    qdd: &mut [f64],
    scratch: &mut ForwardScratch,
) -> Result<(), SingularMass> {
    let ForwardScratch { bias, mass } = scratch;
    qdd.fill(0.0);
    model.inverse_dynamics(q, qd, qdd, bias);
    for (acceleration, bias) in qdd.iter_mut().zip(bias) {
        *acceleration = -*bias;
    }
    match mass {
        Mass::Dense { matrix, cholesky } => {
            model.mass_matrix(q, matrix);
            cholesky.factorise(matrix).map_err(|_| SingularMass)?;
            cholesky.solve(qdd);
        }
        Mass::Tree { matrix, lu } => {
            model.tree_mass_matrix(q, matrix);
            lu.factorise(matrix).map_err(|_| SingularMass)?;
            lu.solve(qdd);
        }
    }
    Ok(())
}
