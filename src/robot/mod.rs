//! Robots ready to be moved.
//!
//! `description` is what a robot is, in plain data; `plan` is the same compiled for computing, by `compile`. The
//! sweeps read the plan and work in a `state`: the `kernel` has the recursions along the rod (where it is, what
//! forces a motion needs, how these change with the motion), an `effect` is what acts on it. `tell` says what is
//! computed, and what it costs.

mod algebra;
mod choice;
mod compile;
mod description;
mod driven;
mod effect;
mod kernel;
mod model;
mod plan;
mod state;
mod sweeps;
mod tell;
#[cfg(test)]
mod tests;
mod turning;

pub use choice::{Kernel, Solve};
pub use description::{Driven, Inputs, Link, MAX_COORDINATES, Robot, Rod};
pub(crate) use description::{Origin, origin};
pub use kernel::kinematics::Pose;
pub use kernel::momentum::Momentum;
pub use model::RobotModel;
pub use plan::point::Place;
pub use tell::{Explanation, Multiplications};
