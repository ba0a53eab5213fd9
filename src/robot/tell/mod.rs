//! Explanations and costs of a robot.

mod actuators;
mod contacts;
pub(crate) mod cost;
pub(crate) mod cost_of_actuators;
pub(crate) mod cost_of_loops;
mod explanation;
pub(crate) mod loops;
mod text;

pub use cost::Multiplications;
pub use explanation::Explanation;
