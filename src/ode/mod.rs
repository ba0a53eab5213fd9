//! Initial value problems `y' = f(t, y)`, `y(t0) = y0`: embedded Runge-Kutta pairs of Dormand and Prince, orders
//! 5(4) and 8(5,3), and the implicit Radau IIA method of order 5, all with adaptive steps and dense output.
//!
//! [`solve`] integrates over an interval and collects the trajectory; [`Stepper`] is the same step by step.
//!
//! ```
//! use lissom::error::Interrupted;
//! use lissom::ode::{Options, Output, System, solve};
//!
//! struct Decay;
//! impl System for Decay {
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

mod bracket;
mod controller;
mod dense;
mod dormand_prince_5;
mod dormand_prince_8;
mod events;
mod explicit;
mod initial_step;
mod options;
mod pair;
mod solution;
mod status;
mod stepper;
mod stiffness;

pub use dense::DenseOutput;
pub use events::{Direction, Event, EventFunction};
pub use options::{Controller, Method, Options, Output, Tolerance};
pub use solution::{Occurrences, Solution, solve};
pub use status::Status;
pub use stepper::{Counters, Stepper};

use crate::error::Interrupted;

/// The right-hand side of `y' = f(t, y)`.
pub trait System {
    /// Number of equations.
    fn n(&self) -> usize;

    /// `dydt <- f(t, y)`, every entry of it. Non-finite values are allowed: the step that met them is tried again
    /// with a smaller size, and when that does not help the integration ends with a status that says so.
    fn rhs(&mut self, t: f64, y: &[f64], dydt: &mut [f64]) -> Result<(), Interrupted>;
}
