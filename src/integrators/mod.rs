//! Solvers of initial value problems, independent of rods.

pub mod newmark;
pub mod ode;
pub mod radau;
pub mod second_order;
