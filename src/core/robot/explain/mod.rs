//! Explanations and costs of a robot.

pub(crate) mod cost;
mod distances;
pub(crate) mod explanation;
mod overload;
mod sizes;
pub(crate) mod text;
mod units;

pub use cost::Multiplications;
pub use explanation::Explanation;
pub(crate) use overload::overloads;
