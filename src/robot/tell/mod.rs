//! Explanations and costs of a robot.

mod actuators;
mod contacts;
pub(crate) mod cost;
mod explanation;
pub(crate) mod loops;
mod text;

pub use cost::Multiplications;
pub use explanation::Explanation;
