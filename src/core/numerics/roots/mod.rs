//! Root finding on R^n: Newton's method, its globalisations and finite-difference Jacobians. Independent of
//! time integration.
//!
//! A [`NonlinearSystem`] defines the equations, [`Options`] the method, [`Newton`] contains the memory and runs the
//! search, [`Outcome`] is the result. The [`Status`] of an outcome says what happened; only a root is a
//! success.
//!
//! ```
//! use lissom::error::Interrupted;
//! use lissom::linalg::Matrix;
//! use lissom::roots::{Newton, Options, Status, NonlinearSystem};
//!
//! /// x^2 + y^2 = 2, x = y.
//! struct CircleAndLine;
//!
//! impl NonlinearSystem for CircleAndLine {
//!     fn unknowns(&self) -> usize {
//!         2
//!     }
//!     fn residual(&mut self, x: &[f64], residual: &mut [f64]) -> Result<(), Interrupted> {
//!         residual[0] = x[0] * x[0] + x[1] * x[1] - 2.0;
//!         residual[1] = x[0] - x[1];
//!         Ok(())
//!     }
//!     fn jacobian(&mut self, x: &[f64], jacobian: &mut Matrix) -> Result<(), Interrupted> {
//!         jacobian.copy_from_slice(&[2.0 * x[0], 1.0, 2.0 * x[1], -1.0]); // by columns
//!         Ok(())
//!     }
//! }
//!
//! let mut x = [3.0, 1.0];
//! let searched = Newton::new(2, 2).solve(&mut CircleAndLine, &mut x, &Options::default());
//! let outcome = searched.expect("nothing interrupts it");
//! assert_eq!(outcome.status, Status::ConvergedResidual);
//! assert!((x[0] - 1.0).abs() < 1e-6 && (x[1] - 1.0).abs() < 1e-6);
//! ```

#[doc(hidden)]
pub mod bracket;
mod check;
mod convergence;
mod cycle;
mod difference;
pub mod least_squares;
mod line_search;
mod multiplicity;
mod newton;
mod options;
mod outcome;
mod region_search;
mod step;
mod trust_region;

pub use check::{JacobianCheck, check_jacobian};
pub use difference::{CENTRAL_INCREMENT, Differences, FORWARD_INCREMENT};
pub use newton::{Iterate, Newton};
pub use options::{Method, Options, Reuse, StepTolerance};
pub use outcome::{Outcome, Status};

use crate::error::Interrupted;
use crate::numerics::linalg::Matrix;

/// `R(x) = 0`, with `R` from R^n to R^m.
pub trait NonlinearSystem {
    /// Number of unknowns n.
    fn unknowns(&self) -> usize;

    /// Number of equations m. Default: n.
    fn equations(&self) -> usize {
        self.unknowns()
    }

    /// `residual <- R(x)`. Non-finite values are allowed; they end the search with a status that says so.
    fn residual(&mut self, x: &[f64], residual: &mut [f64]) -> Result<(), Interrupted>;

    /// `jacobian <- dR/dx` at `x` (m x n). Called only for [`Derivative::Analytic`].
    fn jacobian(&mut self, x: &[f64], jacobian: &mut Matrix) -> Result<(), Interrupted>;
}

/// Source of the Jacobian.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Derivative {
    /// The system's own Jacobian.
    Analytic,
    /// Forward differences: n evaluations, error about the square root of the rounding unit.
    Forward,
    /// Central differences: 2n evaluations, error about the rounding unit to the power 2/3.
    Central,
}
