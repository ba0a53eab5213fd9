//! Second-order equations of motion, and the common parts of their integrators [`crate::integrators::newmark`] and
//! [`crate::integrators::radau`].
//!
//! ```
//! use lissom::newmark::{Options, solve};
//! use lissom::pendulum::SpringPendulum;
//!
//! let mut pendulum = SpringPendulum::new(1.0, 1.0, 10.0, 9.81)?;
//! let motion = solve(&mut pendulum, (0.0, 0.1), &[-0.7, 0.5], &[0.0; 2], &Options::new(1e-2), None, &mut |_, _| Ok(()))?;
//! assert_eq!(motion.q.len(), motion.t.len() * motion.n);
//! # Ok::<(), lissom::error::InvalidInput>(())
//! ```

mod grid;
mod problem;
pub(crate) mod runaway;
mod solution;
mod status;
mod system;
mod watched;

pub use solution::Solution;
pub use status::{Counters, Failure, Status};
pub use system::SecondOrderSystem;

pub(crate) use grid::{Grid, ROUNDING_OF_STEPS, is_whole, number_of_steps};
pub(crate) use problem::{check_problem, check_start};
pub(crate) use solution::{Steps, check_points, check_times, collect, points_in_memory, steps};
pub(crate) use status::Solved;
pub(crate) use system::{constrained_start, model_at, model_of, set_motion};
pub(crate) use watched::Watched;
