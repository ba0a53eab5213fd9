//! Explanations and costs of a robot.

pub(crate) mod cost;
pub(crate) mod explanation;
pub(crate) mod text;

pub use cost::Multiplications;
pub use explanation::Explanation;
