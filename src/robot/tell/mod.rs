//! What is computed for a robot, and what it costs.

pub(crate) mod cost;
mod explanation;

pub use cost::Multiplications;
pub use explanation::Explanation;
