//! Second-order equations of motion, and what their integrators share: [`crate::newmark`] and [`crate::radau`].

mod grid;
mod problem;
mod solution;
mod status;
mod system;

pub use solution::Solution;
pub use status::{Counters, Failure, Status};
pub use system::{FreeMotion, System};

pub(crate) use grid::{Grid, ROUNDING_OF_STEPS, is_whole, number_of_steps};
pub(crate) use problem::{check_problem, check_start};
pub(crate) use solution::{Steps, check_points, check_times, collect, points_in_memory};
