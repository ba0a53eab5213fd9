//! Initial value problems `y' = f(t, y)`, `y(t0) = y0`: embedded Runge-Kutta pairs of Dormand and Prince, orders
//! 5(4) and 8(5,3), and the implicit Radau IIA method of order 5, all with adaptive steps and dense output.
//!
//! [`solve`] integrates over an interval and collects the trajectory; [`Stepper`] integrates step by step.
//!
//! ```
//! use lissom::error::Interrupted;
//! use lissom::ode::{Options, Output, FirstOrderSystem, solve};
//!
//! struct Decay;
//! impl FirstOrderSystem for Decay {
//!     fn n(&self) -> usize {
//!         1
//!     }
//!     fn rhs(&mut self, _t: f64, y: &[f64], dydt: &mut [f64]) -> Result<(), Interrupted> {
//!         dydt[0] = -y[0];
//!         Ok(())
//!     }
//! }
//!
//! let options = Options { rtol: 1e-9.into(), atol: 1e-12.into(), ..Options::default() };
//! let output = Output::at([0.0, 0.5, 1.0]);
//! let solution = solve(&mut Decay, (0.0, 1.0), &[1.0], &options, &output, &mut [], &mut |_| Ok(()))?;
//! assert!(solution.status.is_success(), "{}", solution.message);
//! assert!((solution.state(2)[0] - (-1.0f64).exp()).abs() < 1e-9);
//! # Ok::<(), lissom::error::InvalidInput>(())
//! ```

mod controller;
mod dense;
mod differences;
mod dormand_prince_5;
mod dormand_prince_8;
mod events;
mod explicit;
mod first_order;
pub(crate) mod initial_step;
pub(crate) mod norm;
mod options;
mod pair;
mod pairs;
mod radau;
pub(crate) mod radau_iia;
mod solution;
mod state;
mod status;
mod stepper;
mod stiffness;

pub use dense::{DenseOutput, DenseParts};
pub use differences::Sparsity;
pub use events::{Direction, Event, EventFunction};
pub use first_order::FirstOrder;
pub(crate) use options::Tolerances;
pub use options::{Controller, Method, Options, Output, Tolerance};
pub(crate) use pairs::stability_limit;
pub use pairs::{Tableau, tableau};
pub use solution::{Occurrences, Solution, solve};
pub use state::Counters;
pub use status::Status;
pub use stepper::Stepper;

use crate::error::Interrupted;
use crate::integrators::Reason;
use crate::numerics::linalg::Matrix;

/// The right-hand side of `y' = f(t, y)`.
pub trait FirstOrderSystem {
    /// Number of equations.
    fn n(&self) -> usize;

    /// `dydt <- f(t, y)`. Must set every entry. Non-finite values are allowed: the step is repeated with a
    /// smaller size, and if this does not help the integration ends with a status that says so.
    fn rhs(&mut self, t: f64, y: &[f64], dydt: &mut [f64]) -> Result<(), Interrupted>;

    /// `f` for several states at one time, one per column, for Jacobians by differences. By default evaluates
    /// one state after the other.
    fn rhs_columns(&mut self, t: f64, y: &Matrix, dydt: &mut Matrix) -> Result<(), Interrupted> {
        for (y, mut dydt) in y.column_iter().zip(dydt.column_iter_mut()) {
            self.rhs(t, y.as_slice(), dydt.as_mut_slice())?;
        }
        Ok(())
    }

    /// Latest end of a step from `t` that cannot miss a feature of the excitation. Default: infinite. Not
    /// used backward in time.
    fn horizon(&self, _t: f64) -> f64 {
        f64::INFINITY
    }

    /// Why a step between two times, states and derivatives is refused: it missed an effect that its error estimate does not show, or, if
    /// that `is_judged`, cannot be correct. Such a step is repeated with half the size. Default: none is.
    fn refusal(
        &mut self,
        _t: [f64; 2],
        _y: [&[f64]; 2],
        _dydt: [&[f64]; 2],
        _is_judged: bool,
    ) -> Result<Option<Reason>, Interrupted> {
        Ok(None)
    }

    /// Rewrites a state and its derivative in coordinates away from their singularities, if necessary. Called
    /// between accepted steps. Returns whether anything changed.
    fn wrap(&mut self, _y: &mut [f64], _dydt: &mut [f64]) -> bool {
        false
    }

    /// Source of the Jacobian df/dy, which only implicit methods need.
    fn jacobian_kind(&self) -> JacobianKind {
        JacobianKind::Differenced
    }

    /// `jacobian <- df/dy` (n x n), called if [`Self::jacobian_kind`] is not `Differenced`. The default is
    /// NaN, which ends the integration with [`Status::NonFiniteJacobian`].
    fn jacobian(&mut self, _t: f64, _y: &[f64], jacobian: &mut Matrix) -> Result<(), Interrupted> {
        jacobian.fill(f64::NAN);
        Ok(())
    }
}

/// Source of the Jacobian of a right-hand side.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum JacobianKind {
    /// Forward differences with adaptive increments.
    #[default]
    Differenced,
    /// Provided by the system.
    Supplied,
    /// Provided by the system, constant in time and state.
    Constant,
}
