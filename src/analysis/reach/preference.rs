//! Preferred shape among those that reach the targets: the minimum of a quadratic form.

use std::f64::consts::TAU;

use crate::error::InvalidInput;
use crate::numerics::linalg::{Matrix, norm, symmetric_eigen};
use crate::numerics::roots::least_squares::Form;
use crate::robot::RobotModel;

/// Preference among the shapes that reach the targets.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum Preference {
    /// No preference: the shape that the search finds, near its start.
    #[default]
    Any,
    /// The shape closest to the start, in coordinates divided by their typical sizes.
    Start,
    /// The shape closest to the start, with these weights of the squared coordinate differences.
    Weights(Vec<f64>),
    /// The shape with the least elastic energy of rods and joint springs, without supports.
    Energy,
}

/// Quadratic form of a preference in scaled coordinates; `None` without a preference. Rejects a form that is
/// zero.
pub(super) fn form_of(
    preference: &Preference,
    model: &mut RobotModel,
    q0: &[f64],
    sizes: &[f64],
) -> Result<Option<Form>, InvalidInput> {
    let n = sizes.len();
    let scaled = |q: &[f64]| q.iter().zip(sizes).map(|(q, size)| q / size).collect();
    Ok(match preference {
        Preference::Any => None,
        Preference::Start => Some(Form { root: Matrix::identity(n, n), wanted: scaled(q0) }),
        Preference::Weights(weights) => {
            let roots = (0..n).map(|k| weights[k].sqrt() * sizes[k]);
            let largest = roots.clone().fold(0.0, f64::max);
            let roots: Vec<f64> = roots.map(|root| root / largest).collect();
            let root = Matrix::from_fn(n, n, |i, j| if i == j { roots[i] } else { 0.0 });
            Some(Form { root, wanted: scaled(q0) })
        }
        Preference::Energy => {
            let wanted = at_rest(model);
            let mut stiffness = Matrix::zeros(n, n);
            model.stiffness(&wanted, &mut stiffness);
            let stiffness = Matrix::from_fn(n, n, |i, j| sizes[i] * stiffness[(i, j)] * sizes[j]);
            let (values, vectors) =
                symmetric_eigen(&stiffness).unwrap_or_else(|| (Vec::new(), Matrix::zeros(0, 0)));
            let largest = values.last().copied().unwrap_or(0.0);
            if largest <= 0.0 {
                let expected = "something elastic: rods with modes, or joints with a stiffness";
                return Err(InvalidInput::new("prefer", "\"energy\"", expected));
            }
            let root = |k: usize| (values[k].max(0.0) / largest).sqrt();
            let root = Matrix::from_fn(n, n, |k, i| root(k) * vectors[(i, k)]);
            Some(Form { root, wanted: scaled(&wanted) })
        }
    })
}

/// Replaces a rotation vector by the equivalent one with the smaller value of the form.
pub(super) fn shortest_equivalent(form: &Form, rotation_vectors: &[usize], x: &mut [f64]) {
    for &first in rotation_vectors {
        let own = first..first + 3;
        let length = norm(&x[own.clone()]);
        let distance =
            |factor: f64| -> f64 { own.clone().map(|i| (factor * x[i] - form.wanted[i]).powi(2)).sum() };
        let other = 1.0 - TAU / length;
        if length > 0.0 && distance(other) < distance(1.0) {
            x[own].iter_mut().for_each(|x| *x *= other);
        }
    }
}

/// Coordinates at which rods and joint springs are relaxed; for coordinates beyond a stop, the stop.
fn at_rest(model: &RobotModel) -> Vec<f64> {
    let robot = model.description();
    let mut q = vec![0.0; robot.coordinates()];
    for (i, link) in robot.links.iter().enumerate() {
        if let Some(forces) = link.joint.forces()
            && link.driven.is_none()
        {
            let [lower, upper] = forces.limits.unwrap_or([f64::NEG_INFINITY, f64::INFINITY]);
            q[robot.coordinates_of(i).start] = forces.rest.clamp(lower, upper);
        }
    }
    q
}
