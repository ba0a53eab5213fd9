//! Closed loops and inextensible tendons: their gaps, their forces, and which of their constraints are redundant.

use pyo3::prelude::*;
use pyo3::types::PyDict;

use super::super::convert;
use super::super::loops::loop_index;
use super::class::PyRobot;
use super::states::At;
use crate::model::Tied as _;
use crate::robot::RobotModel;
use crate::robot::effects::actuator::Actuator;
use crate::robot::effects::loops::Tie;

/// Number of redundant constraints of each loop at a shape.
pub(super) fn redundant<'py>(
    robot: &PyRobot,
    py: Python<'py>,
    q: &Bound<'py, PyAny>,
) -> PyResult<Bound<'py, PyDict>> {
    let q = convert::finite_vector_of(q, robot.description().coordinates(), "q")?;
    let redundant = robot.model()?.redundant_constraints(&q);
    let found = PyDict::new(py);
    let of_loops = robot.description().loops.iter().map(|closed| closed.name.as_str());
    let names = of_loops.chain(robot.description().inextensible_tendons().map(Actuator::name));
    for (name, number) in names.zip(redundant) {
        if number > 0 {
            found.set_item(name, number)?;
        }
    }
    Ok(found)
}

/// Constraint forces of a closed loop.
pub(super) fn forces<'py>(
    robot: &PyRobot,
    [q, qd, qdd]: [&Bound<'py, PyAny>; 3],
    name: Option<&str>,
    at: At<'_, 'py>,
) -> PyResult<Bound<'py, PyAny>> {
    let i = loop_index(robot.description(), name)?;
    let states = [Some((q, "q")), Some((qd, "qd")), Some((qdd, "qdd"))];
    let forces = |model: &mut RobotModel, [q, qd, qdd]: [&[f64]; 3]| {
        model.loop_forces(q, qd, qdd).map_or([f64::NAN; 6], |forces| forces[i])
    };
    if matches!(robot.description().loops[i].tie, Tie::Coordinates { .. }) {
        let mut force = |model: &mut RobotModel, state: [&[f64]; 3]| vec![forces(model, state)[0]];
        return robot.of_states(robot.model()?, states, at, "loop_forces", &[], &mut force);
    }
    robot.of_states(robot.model()?, states, at, "loop_forces", &[6], &mut |model, state| {
        forces(model, state).to_vec()
    })
}

/// Violation of the constraints.
pub(super) fn gaps<'py>(
    robot: &PyRobot,
    q: &Bound<'py, PyAny>,
    t: Option<&Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyAny>> {
    let m = robot.description().constraints();
    // Lengths of tendons are commands, as those of forces.
    let has_tendons = robot.description().inextensible_tendons().next().is_some();
    robot.of_states(
        robot.model()?,
        [Some((q, "q")), None, None],
        if has_tendons { At::forces(t, None) } else { At::time(t) },
        "loop_gaps",
        &[m],
        &mut |model, [q, _, _]| {
            let mut gaps = vec![0.0; m];
            model.gaps(q, &mut gaps);
            gaps
        },
    )
}

/// Closed loops at rest, row by row: the contribution of their forces to the stiffness, and the derivative of the gaps.
pub(super) fn at_rest<'py>(
    robot: &PyRobot,
    q: &Bound<'py, PyAny>,
    at: At<'_, 'py>,
) -> PyResult<Bound<'py, PyAny>> {
    let n = robot.description().coordinates();
    robot.of_states(
        robot.model()?,
        [Some((q, "q")), None, None],
        at,
        "_loops_at_rest",
        &[n + robot.description().constraints(), n],
        &mut |model, [q, _, _]| {
            let parts = model.loops_at_rest(q);
            parts.iter().flat_map(|part| part.transpose().as_slice().to_vec()).collect()
        },
    )
}
