//! Contacts: their forces, and where surfaces touch.

use numpy::PyArray1;
use pyo3::prelude::*;
use pyo3::types::PyList;

use super::super::callback::or_raised;
use super::super::contact::contact_index;
use super::super::convert;
use super::super::model::time_of_state;
use super::class::PyRobot;
use super::states::{At, flat};
use crate::model::InTime as _;
use crate::numerics::lie::Vector;
use crate::robot::ReportedTouch;

/// Resultant wrench of a contact on its first surface.
pub(super) fn forces<'py>(
    robot: &PyRobot,
    [q, qd]: [&Bound<'py, PyAny>; 2],
    name: Option<&str>,
    t: Option<&Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyAny>> {
    let i = contact_index(robot.description(), name)?;
    let states = [Some((q, "q")), Some((qd, "qd")), None];
    robot.of_states(robot.model()?, states, At::time(t), "contact_forces", &[6], &mut |model, [q, qd, _]| {
        flat(model.contact_wrench(q, qd, i))
    })
}

/// Places where surfaces touch in a state.
pub(super) fn touches<'py>(
    robot: &PyRobot,
    py: Python<'py>,
    q: &Bound<'py, PyAny>,
    qd: Option<&Bound<'py, PyAny>>,
    t: Option<f64>,
) -> PyResult<Bound<'py, PyList>> {
    let n = robot.description().coordinates();
    let q = convert::finite_vector_of(q, n, "q")?;
    let qd = qd.map_or_else(|| Ok(vec![0.0; n]), |qd| convert::finite_vector_of(qd, n, "qd"))?;
    let time = time_of_state(t, robot.description().is_moved())?;
    let mut model = robot.model()?;
    or_raised(model.set_time(time))?;
    let class = py.import("lissom.model.contacts")?.getattr("Touch")?;
    let touch = |touch: ReportedTouch| {
        let vector = |v: Vector<f64>| PyArray1::from_slice(py, &v.to_array());
        let ReportedTouch {
            contact,
            position,
            normal,
            force,
            overlap,
            share: _,
            sliding,
            along,
            is_at_edge: _,
        } = touch;
        let name = robot.description().contacts[contact].name.as_str();
        let [on_first, on_second] = along;
        class.call1((
            name,
            vector(position),
            vector(normal),
            vector(force),
            overlap,
            vector(sliding),
            (on_first, on_second),
        ))
    };
    PyList::new(py, model.touches(&q, &qd).into_iter().map(touch).collect::<PyResult<Vec<_>>>()?)
}
