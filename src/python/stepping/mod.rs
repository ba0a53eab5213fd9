//! Simulations advanced step by step: one, or many at once.

mod memory;
mod simulation;
mod simulations;

pub(super) use simulation::PySimulation;
pub(super) use simulations::PySimulations;
