//! The instruction set and the number of processors of this machine.

use pyo3::prelude::*;

use crate::numerics::lie::Instructions;
use crate::numerics::parallel;

/// The instruction set used by the sweeps on this machine, and the number of processors available to this
/// process.
#[pyfunction]
pub(crate) fn machine() -> (&'static str, usize) {
    (Instructions::of_machine().name(), parallel::processors())
}
