//! Places on links, and their poses, velocities, accelerations and strains.

use numpy::{IntoPyArray, PyArrayMethods};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use super::super::callback::or_raised;
use super::super::convert;
use super::super::errors::check_finite;
use super::super::model::check_modes;
use super::class::PyRobot;
use super::states::{At, POSES_BETWEEN_SIGNALS, flat};
use crate::description::rod::arc_length::is_on_rod;
use crate::model::InTime as _;
use crate::numerics::linalg::Matrix;
use crate::python::errors::OrRaise as _;
use crate::robot::{Place, RobotModel};

impl PyRobot {
    /// Returns an error if the place is not on the link.
    pub(in crate::python) fn check_place(&self, link: usize, x: Option<f64>) -> PyResult<()> {
        let Some(x) = x else { return Ok(()) };
        let link = &self.description().links[link];
        let length = link.length();
        if !link.rod.is_empty() && is_on_rod(x, length) {
            return Ok(());
        }
        Err(PyValueError::new_err(match link.rod.is_empty() {
            true => format!(
                "X: got {x}, but link '{}' has no rod, on which it would be an arc length: leave it out",
                link.name
            ),
            false => format!("X: got {x}, expected an arc length in [0, {length}] (metres)"),
        }))
    }

    /// Arc lengths on a link, and whether a single number was given; several places add a dimension to the
    /// result.
    fn arc_lengths(
        &self,
        given: Option<&Bound<'_, PyAny>>,
        link: usize,
    ) -> PyResult<(Vec<Option<f64>>, bool)> {
        let (places, is_number) = match given {
            Some(given) => {
                let (places, is_number) = convert::scalar_or_vector(given, "X")?;
                (places.into_iter().map(Some).collect(), is_number)
            }
            None => (vec![None], true),
        };
        places.iter().try_for_each(|&x| self.check_place(link, x))?;
        Ok((places, is_number))
    }

    /// The sections of a link's rod at these arc lengths, and the shape of a result with six numbers for
    /// each.
    pub(super) fn sections(
        &self,
        model: &RobotModel,
        given: Option<&Bound<'_, PyAny>>,
        link: Option<&str>,
    ) -> PyResult<(Vec<Place>, Vec<usize>)> {
        let index = self.description().link_named(link, "link").or_raise()?;
        let (places, is_number) = self.arc_lengths(given, index)?;
        let links = &self.description().links;
        if links[index].rod.is_empty() {
            let rods = links.iter().filter(|link| !link.rod.is_empty());
            let names = rods.map(|link| format!("'{}'", link.name)).collect::<Vec<_>>().join(", ");
            let expected =
                if names.is_empty() { ", but no link has one".to_owned() } else { format!(": {names}") };
            let found = &links[index].name;
            return Err(PyValueError::new_err(format!(
                "link: '{found}' has no rod, expected a link with a rod{expected}"
            )));
        }
        let sections: Vec<_> = places.into_iter().map(|x| model.place_on(index, x)).collect();
        let shape = (!is_number).then_some(sections.len()).into_iter().chain([6]).collect();
        Ok((sections, shape))
    }

    /// A place on the link of this name.
    fn place(&self, link: Option<&str>, x: Option<f64>) -> PyResult<Place> {
        let link = self.description().link_named(link, "link").or_raise()?;
        self.check_place(link, x)?;
        Ok(self.kinematics()?.place_on(link, x))
    }
}

/// Poses of sections or bodies.
pub(super) fn poses<'py>(
    robot: &PyRobot,
    q: &Bound<'py, PyAny>,
    x: Option<&Bound<'py, PyAny>>,
    link: Option<&str>,
    t: Option<&Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyAny>> {
    let py = q.py();
    check_modes(robot.description())?;
    let n = robot.description().coordinates();
    let (states, number_of_states) = convert::finite_rows_of(q, n, "q")?;
    let link = robot.description().link_named(link, "link").or_raise()?;
    let (places, is_number) = robot.arc_lengths(x, link)?;
    let rows = number_of_states.unwrap_or(1);
    let times = robot.times(t, number_of_states, robot.description().is_moved())?;
    let shape: Vec<usize> =
        number_of_states.into_iter().chain((!is_number).then_some(places.len())).chain([4, 4]).collect();
    // Locked without the interpreter, and only for one place or pose at a time: signal handlers may use
    // the same robot.
    let model = || robot.compiled();
    let answer_signals = |done: usize| {
        let is_time = done > 0 && done.is_multiple_of(POSES_BETWEEN_SIGNALS);
        if is_time { Python::attach(|py| py.check_signals()) } else { Ok(()) }
    };
    let poses = py.detach(|| {
        // Callables of time may use the model while it is being evaluated.
        let mut moving = robot.description().is_prescribed().then(|| model().clone());
        let places = places
            .into_iter()
            .enumerate()
            .map(|(i, x)| answer_signals(i).map(|()| model().place_on(link, x)))
            .collect::<PyResult<Vec<Place>>>()?;
        let mut poses = Vec::with_capacity(16 * rows * places.len());
        for row in 0..rows {
            let q = &states[row * n..(row + 1) * n];
            if let Some(moving) = &mut moving {
                or_raised(moving.set_time(times[row % times.len()]))?;
            }
            for place in &places {
                answer_signals(poses.len() / 16)?;
                let pose = match &mut moving {
                    Some(moving) => moving.pose_at(q, place),
                    None => model().pose_at(q, place),
                };
                poses.extend(convert::homogeneous(&pose));
            }
        }
        Ok::<_, PyErr>(poses)
    })?;
    check_finite(&poses, "pose")?;
    Ok(poses.into_pyarray(py).reshape(shape)?.into_any())
}

/// Jacobian of the pose of a section or body.
pub(super) fn jacobian<'py>(
    robot: &PyRobot,
    q: &Bound<'py, PyAny>,
    x: Option<f64>,
    link: Option<&str>,
    t: Option<&Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyAny>> {
    let place = robot.place(link, x)?;
    let n = robot.description().coordinates();
    let mut jacobian = Matrix::zeros(6, n);
    let states = [Some((q, "q")), None, None];
    robot.of_states(robot.model()?, states, At::time(t), "jacobian", &[6, n], &mut |model, [q, ..]| {
        model.jacobian_at(q, &place, &mut jacobian);
        jacobian.transpose().as_slice().to_vec()
    })
}

/// Velocity of a section or body.
pub(super) fn velocity<'py>(
    robot: &PyRobot,
    [q, qd]: [&Bound<'py, PyAny>; 2],
    x: Option<f64>,
    link: Option<&str>,
    t: Option<&Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyAny>> {
    let place = robot.place(link, x)?;
    let states = [Some((q, "q")), Some((qd, "qd")), None];
    robot.of_states(robot.model()?, states, At::time(t), "velocity", &[6], &mut |model, [q, qd, _]| {
        flat(model.velocity_at(q, qd, &place))
    })
}

/// Acceleration of a section or body.
pub(super) fn acceleration<'py>(
    robot: &PyRobot,
    [q, qd, qdd]: [&Bound<'py, PyAny>; 3],
    x: Option<f64>,
    link: Option<&str>,
    t: Option<&Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyAny>> {
    let place = robot.place(link, x)?;
    let states = [Some((q, "q")), Some((qd, "qd")), Some((qdd, "qdd"))];
    robot.of_states(robot.model()?, states, At::time(t), "acceleration", &[6], &mut |model, [q, qd, qdd]| {
        flat(model.acceleration_at(q, qd, qdd, &place))
    })
}

/// Strains of sections of a rod.
pub(super) fn strains<'py>(
    robot: &PyRobot,
    q: &Bound<'py, PyAny>,
    x: Option<&Bound<'py, PyAny>>,
    link: Option<&str>,
) -> PyResult<Bound<'py, PyAny>> {
    let mut model = robot.model()?;
    let (sections, shape) = robot.sections(&model, x, link)?;
    let n = robot.description().coordinates();
    let (states, number) = convert::finite_rows_of(q, n, "q")?;
    let mut strains = Vec::new();
    for row in 0..number.unwrap_or(1) {
        if row > 0 && row.is_multiple_of(POSES_BETWEEN_SIGNALS) {
            q.py().check_signals()?;
        }
        let q = &states[row * n..(row + 1) * n];
        strains.extend(sections.iter().flat_map(|section| model.strain_at(q, section)));
    }
    check_finite(&strains, "strain")?;
    let shape: Vec<usize> = number.into_iter().chain(shape).collect();
    Ok(strains.into_pyarray(q.py()).reshape(shape)?.into_any())
}
