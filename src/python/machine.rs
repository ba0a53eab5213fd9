//! The instruction set and the number of processors of this machine.

use pyo3::prelude::*;

use crate::lie::Instructions;
use crate::parallel;

/// The instructions that the sweeps along rods use on this machine, and how many processors there are for this process.
#[pyfunction]
pub(crate) fn machine() -> (&'static str, usize) {
    (Instructions::of_machine().name(), parallel::processors())
}
