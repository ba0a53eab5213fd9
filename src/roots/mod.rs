//! Root finding on R^n: Newton's method and finite-difference Jacobians. Knows nothing of time.

use crate::error::Interrupted;
use crate::linalg::Matrix;

/// `R(x) = 0`, with `R` from R^n to R^m.
pub trait System {
    /// Number of unknowns n.
    fn unknowns(&self) -> usize;

    /// Number of equations m; n unless said otherwise.
    fn equations(&self) -> usize {
        self.unknowns()
    }

    /// `residual <- R(x)`. Non-finite values are allowed and end the search with a status that says so.
    fn residual(&mut self, x: &[f64], residual: &mut [f64]) -> Result<(), Interrupted>;

    /// `jacobian <- dR/dx` at `x` (m x n). Called for [`Derivative::Analytic`] only.
    fn jacobian(&mut self, x: &[f64], jacobian: &mut Matrix) -> Result<(), Interrupted>;
}

/// Where the Jacobian comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Derivative {
    /// The system's own.
    Analytic,
    /// Forward differences: n evaluations, error about the square root of the rounding unit.
    Forward,
    /// Central differences: 2n evaluations, error about its power 2/3.
    Central,
}
