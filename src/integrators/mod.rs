//! Solvers of initial value problems, independent of rods.

pub(crate) mod attempts;
mod chord;
pub mod newmark;
pub mod ode;
pub mod radau;
mod retries;
pub mod second_order;

pub use retries::Reason;
pub(crate) use retries::Retries;
