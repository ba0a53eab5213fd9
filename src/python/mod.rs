//! The Python extension module `lissom._lissom`: conversions only, no numerics.
//!
//! `convert` converts Python values to slices and back, `callback` carries exceptions and Ctrl-C through the
//! core; every other file binds the module of the core with the same name.

#![allow(missing_docs, reason = "docstrings of this module are written for Python's help()")]

mod actuate;
mod actuation;
mod arguments;
mod background;
mod balance;
mod callback;
mod choice;
mod compiled;
mod contact;
mod continuation;
mod convert;
mod curve;
mod ensemble;
mod equilibrium_path;
mod errors;
mod hard_steps;
mod imports;
mod inputs;
mod loops;
mod machine;
mod model;
mod modes;
mod motion;
mod newmark;
mod ode;
mod overlap;
mod part;
mod pendulum;
mod profile;
mod reach;
mod record;
mod remarks;
mod robot;
mod rod;
mod roots;
mod rows;
mod scene;
mod search;
mod section;
mod segment;
mod sensitivity;
mod signal;
mod simulate;
mod space_error;
mod statics;
mod stepping;
mod words;

use pyo3::exceptions::PyImportError;
use pyo3::prelude::*;

#[pymodule]
#[doc(hidden)]
pub mod _lissom {
    use super::*;

    #[pymodule_export]
    use super::actuate::{PyActuateResult, actuate};
    #[pymodule_export]
    use super::arguments::finite_array;
    #[pymodule_export]
    use super::balance::PyBalance;
    #[pymodule_export]
    use super::choice::choose_modes;
    #[pymodule_export]
    use super::contact::centre_line;
    #[pymodule_export]
    use super::continuation::{PyContinuationResult, continuation};
    #[pymodule_export]
    use super::convert::of_python::{as_flag, as_number, as_text, as_whole};
    #[pymodule_export]
    use super::curve::PyCurveResult;
    #[pymodule_export]
    use super::ensemble::{PyEnsembleResult, simulate_many};
    #[pymodule_export]
    use super::equilibrium_path::{PyCriticalPoint, PyEquilibriumPath};
    #[pymodule_export]
    use super::errors::{AccuracyWarning, ConvergenceError, LissomError};
    #[pymodule_export]
    use super::hard_steps::PyHardSteps;
    #[pymodule_export]
    use super::machine::machine;
    #[pymodule_export]
    use super::model::{PyEnergy, PyModel};
    #[pymodule_export]
    use super::modes::{PyModesResult, modes};
    #[pymodule_export]
    use super::motion::{PyMotionResult, PyStatistics};
    #[pymodule_export]
    use super::newmark::newmark;
    #[pymodule_export]
    use super::ode::{PyDenseOutput, PyDop853, PyOdeResult, PyOdeSolver, PyRadau, PyRk45, solve_ivp};
    #[pymodule_export]
    use super::overlap::PyOverlap;
    #[pymodule_export]
    use super::part::{_stub_of_methods, _stub_of_models, _stub_of_parts, PyPart};
    #[pymodule_export]
    use super::pendulum::PySpringPendulum;
    #[pymodule_export]
    use super::profile::PyProfile;
    #[pymodule_export]
    use super::reach::{PyReachResult, check_target};
    #[pymodule_export]
    use super::robot::PyRobot;
    #[pymodule_export]
    use super::rod::PyRod;
    #[pymodule_export]
    use super::roots::{PyJacobianCheck, PyRootResult, check_jacobian_of, jacobian, root};

    #[pymodule_export]
    use super::model::{check_model, measured_places, scales_of};
    #[pymodule_export]
    use super::rows::inputs_by_name;
    #[pymodule_export]
    use super::scene::{PyScene, PySceneProblem, PySimulationSettings, SceneError};
    #[pymodule_export]
    use super::section::PySection;
    #[pymodule_export]
    use super::segment::PySegment;
    #[pymodule_export]
    use super::sensitivity::{has_free_lengths, has_one_sided_forces, has_separate_sections, sensitivities};
    #[pymodule_export]
    use super::signal::{PyHarmonic, PyInput};
    #[pymodule_export]
    use super::simulate::simulate;
    #[pymodule_export]
    use super::space_error::PySpaceError;
    #[pymodule_export]
    use super::statics::{PyStaticsResult, statics};
    #[pymodule_export]
    use super::stepping::{PySimulation, PySimulations};
    #[pymodule_export]
    use super::words::{did_you_mean_in_python, meant_in_python, unexpected_in_python};

    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        if !crate::numerics::lie::Instructions::of_machine().are_compiled() {
            return Err(PyImportError::new_err(
                "lissom was built for machines with AVX2 and FMA, which this one has not: install it here by \"pip \
                 install .\", which builds it for all machines",
            ));
        }
        part::add_classes(module)?;
        robot::describe_class(module.py())?;
        rod::describe_class(module.py())?;
        module.add("__version__", env!("CARGO_PKG_VERSION"))?;
        // Benchmarks refuse to run with a debug build.
        module.add("build_profile", if cfg!(debug_assertions) { "debug" } else { "release" })
    }
}
