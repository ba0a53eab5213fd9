//! The Radau IIA method of order 5 for second-order equations of motion `r(t, q, v, a) = 0`, with adaptive steps and
//! dense output: L-stable, for stiff models whose motion is smooth.
//!
//! The unknowns of a step of size h are the accelerations `a_i` at its three stages, at which the equations
//! of motion hold:
//!
//! ```text
//! v_i = v0 + h sum_j A_ij a_j,    q_i = q0 + c_i h v0 + h^2 sum_j (A^2)_ij a_j,    r(t + c_i h, q_i, v_i, a_i) = 0
//! ```
//!
//! This is the method for systems of first order (Hairer and Wanner 1996, section IV.8) applied to (q, v),
//! with identical results. However, the mass matrix is not inverted, and there are not 2n equations: with the
//! eigenvalues mu of the inverse of A, a simplified Newton iteration solves one real and one complex system
//! of n equations with the matrices
//!
//! ```text
//! dr/da + (h / mu) dr/dv + (h / mu)^2 dr/dq
//! ```
//!
//! whose three parts are the exact tangents of a model, which are kept while the iteration converges fast.
//! The last stage is the end of the step, so that its accelerations are those at the start of the next step.

mod options;
mod solution;
mod stages;
mod stepper;
mod systems;

pub use options::Options;
pub use solution::solve;
pub use stepper::Stepper;

pub(crate) use solution::check_memory;
pub(crate) use stepper::interpolate;
