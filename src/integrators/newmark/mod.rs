//! The Newmark family for second-order equations of motion `r(t, q, v, a) = 0`: Newmark's method, HHT-alpha and
//! generalised-alpha, with steps of fixed or adaptive size.
//!
//! The unknowns of a step are the accelerations at its end. Displacements and velocities there are affine in
//! them ([`Scheme::weights`]), so that all members of the family share one implementation. The equations of a
//! step are solved by Newton's method with a Jacobian that is kept from step to step while it converges. A
//! step whose equations could not be solved is never accepted: adaptive steps are shortened, and with fixed
//! steps the integration ends with a status that says why.
//!
//! [`solve`] integrates over an interval and collects the motion; [`Stepper`] integrates step by step.
//!
//! ```
//! use lissom::newmark::{Options, solve};
//! use lissom::pendulum::SpringPendulum;
//!
//! let mut pendulum = SpringPendulum::new(1.0, 1.0, 10.0, 9.81)?;
//! let (q0, v0) = ([-0.7, 0.5], [0.0, 0.0]);
//! let options = Options::new(1e-3);
//! let motion =
//!     solve(&mut pendulum, (0.0, 1.0), &q0, &v0, &options, None, &mut |_, _| Ok(()))?;
//! assert!(motion.status.is_success(), "{}", motion.message);
//! assert_eq!(motion.t.len(), 1001);
//! # Ok::<(), lissom::error::InvalidInput>(())
//! ```

mod alternation;
mod contraction;
mod corrector;
mod error_estimate;
mod jacobian;
mod linear_system;
mod numbers;
mod options;
mod scheme;
mod search;
mod solution;
mod stepper;
mod trial;

pub(crate) use options::{ATOL, RTOL};
pub use options::{Impacts, Options, Predictor, StepSize};
pub use scheme::{METHODS, Parameters, Scheme};
pub use solution::solve;
pub use stepper::Stepper;

pub(crate) use linear_system::LinearSystem;
pub(crate) use scheme::{FIRST_STAGE, SLOWED, Step, memory};
pub(crate) use stepper::Lengths;
