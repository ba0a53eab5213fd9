//! Wrenches within a robot during a motion, and its momentum.

use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyString;

use super::class::PyRobot;
use super::states::{At, flat};
use crate::python::errors::OrRaise as _;

/// A state, and the name of a link or loop, which may precede the state or follow it as a keyword argument.
pub(super) fn named_state<'a, 'py>(
    method: &str,
    argument: &str,
    [q, qd, qdd]: [&'a Bound<'py, PyAny>; 3],
    last: Option<&'a Bound<'py, PyAny>>,
    name: Option<&'a str>,
) -> PyResult<([&'a Bound<'py, PyAny>; 3], Option<&'a str>)> {
    let refused = |found: &str| {
        let calls = format!("{method}({argument}, q, qd, qdd) or {method}(q, qd, qdd, {argument}=...)");
        Err(PyTypeError::new_err(format!("{argument}: got {found}, expected {calls}")))
    };
    match (q.cast::<PyString>(), last) {
        (Ok(_), Some(_)) if name.is_some() => refused("two names"),
        (Ok(first), Some(last)) => Ok(([qd, qdd, last], Some(first.to_str()?))),
        (Ok(_), None) => refused("a name and two arrays"),
        (Err(_), Some(_)) => refused("a fourth argument behind the state"),
        (Err(_), None) => Ok(([q, qd, qdd], name)),
    }
}

/// Moment and force that a link receives through its joint.
pub(super) fn joint<'py>(
    robot: &PyRobot,
    [q, qd, qdd]: [&Bound<'py, PyAny>; 3],
    link: Option<&str>,
    at: At<'_, 'py>,
) -> PyResult<Bound<'py, PyAny>> {
    let link = robot.description().link_named(link, "link").or_raise()?;
    let states = [Some((q, "q")), Some((qd, "qd")), Some((qdd, "qdd"))];
    robot.of_states(robot.spatial()?, states, at, "joint_wrench", &[6], &mut |model, [q, qd, qdd]| {
        flat(model.joint_wrench(q, qd, qdd, link))
    })
}

/// Moment and force that the base exerts on the robot.
pub(super) fn base<'py>(
    robot: &PyRobot,
    [q, qd, qdd]: [&Bound<'py, PyAny>; 3],
    at: At<'_, 'py>,
) -> PyResult<Bound<'py, PyAny>> {
    let states = [Some((q, "q")), Some((qd, "qd")), Some((qdd, "qdd"))];
    robot.of_states(robot.spatial()?, states, at, "base_wrench", &[6], &mut |model, [q, qd, qdd]| {
        flat(model.base_wrench(q, qd, qdd))
    })
}

/// Internal moments and forces in sections of a rod.
pub(super) fn internal<'py>(
    robot: &PyRobot,
    [q, qd, qdd]: [&Bound<'py, PyAny>; 3],
    x: Option<&Bound<'py, PyAny>>,
    link: Option<&str>,
    by: &str,
    at: At<'_, 'py>,
) -> PyResult<Bound<'py, PyAny>> {
    let is_balanced = match by {
        "balance" => true,
        "material" => false,
        _ => {
            let message = format!("by: got {by:?}, expected \"balance\" or \"material\"");
            return Err(PyValueError::new_err(message));
        }
    };
    // The spatial model, because the wrench that keeps a planar robot in its plane also passes through
    // sections.
    let model = robot.spatial()?;
    let (sections, shape) = robot.sections(&model, x, link)?;
    let states = [Some((q, "q")), Some((qd, "qd")), Some((qdd, "qdd"))];
    robot.of_states(model, states, at, "internal_wrench", &shape, &mut |model, [q, qd, qdd]| {
        let wrenches: Vec<_> = match is_balanced {
            true => model.internal_wrenches_at(q, qd, qdd, &sections),
            false => sections.iter().map(|section| model.material_wrench_at(q, qd, section)).collect(),
        };
        wrenches.into_iter().flat_map(flat).collect()
    })
}

/// Centre of mass of all rods and bodies.
pub(super) fn centre_of_mass<'py>(
    robot: &PyRobot,
    q: &Bound<'py, PyAny>,
    t: Option<&Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyAny>> {
    let zeros = vec![0.0; robot.description().coordinates()];
    robot.of_states(
        robot.spatial()?,
        [Some((q, "q")), None, None],
        At::time(t),
        "centre_of_mass",
        &[3],
        &mut |model, [q, ..]| {
            let momentum = model.momentum(q, &zeros);
            (momentum.first_moment * (1.0 / momentum.mass)).to_array().to_vec()
        },
    )
}

/// Linear and angular momentum of all rods and bodies.
pub(super) fn momentum<'py>(
    robot: &PyRobot,
    [q, qd]: [&Bound<'py, PyAny>; 2],
    t: Option<&Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyAny>> {
    robot.of_states(
        robot.spatial()?,
        [Some((q, "q")), Some((qd, "qd")), None],
        At::time(t),
        "momentum",
        &[6],
        &mut |model, [q, qd, _]| {
            let momentum = model.momentum(q, qd);
            flat([momentum.angular, momentum.linear])
        },
    )
}
