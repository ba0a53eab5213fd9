//! Solvers of initial value problems, independent of rods.

pub(crate) mod attempts;
mod chord;
pub mod newmark;
pub mod ode;
pub mod radau;
pub mod second_order;
