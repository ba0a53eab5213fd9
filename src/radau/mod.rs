//! The Radau IIA method of order 5 for second-order equations of motion `r(t, q, v, a) = 0`, with adaptive steps and
//! dense output: L-stable, for stiff models whose motion is smooth.
//!
//! The unknowns of a step of size h are the accelerations `a_i` at its three stages, where the equations of motion hold:
//!
//! ```text
//! v_i = v0 + h sum_j A_ij a_j,    q_i = q0 + c_i h v0 + h^2 sum_j (A^2)_ij a_j,    r(t + c_i h, q_i, v_i, a_i) = 0
//! ```
//!
//! This is the method for systems of first order (Hairer and Wanner 1996, section IV.8) applied to (q, v), to the
//! last digit, but neither the mass matrix is inverted nor are there 2n equations: with the eigenvalues mu of the
//! inverse of A, a simplified Newton iteration takes one real and one complex system of n equations with the matrices
//!
//! ```text
//! dr/da + (h / mu) dr/dv + (h / mu)^2 dr/dq
//! ```
//!
//! whose three parts are the exact tangents of a model, kept while the iteration converges fast. The last stage is
//! the end of the step, so that its accelerations begin the next one.

mod options;
mod solution;
mod stages;
mod stepper;
mod systems;

pub use options::Options;
pub use solution::solve;
pub use stepper::Stepper;

pub(crate) use solution::check_memory;
