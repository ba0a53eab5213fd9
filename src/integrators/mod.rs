//! Solvers of initial value problems, independent of rods.

mod attempts;
mod chord;
pub mod newmark;
pub mod ode;
pub mod radau;
pub mod second_order;
