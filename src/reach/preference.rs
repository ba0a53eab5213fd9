//! The preferred shape among those that reach the targets: the minimum of a quadratic form.

use std::f64::consts::TAU;

use crate::error::InvalidInput;
use crate::linalg::{Matrix, norm, symmetric_eigen};
use crate::robot::RobotModel;
use crate::roots::least_squares::Form;

/// Which of all shapes that reach.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum Preference {
    /// The one that the search comes to, somewhere near its start.
    #[default]
    Any,
    /// The one nearest to the start, by coordinates over their typical sizes.
    Start,
    /// The one nearest to the start, by these weights of the squares of the coordinates.
    Weights(Vec<f64>),
    /// The one with the least elastic energy of rods and springs of joints, supports left out.
    Energy,
}

/// The quadratic form of a preference in scaled coordinates, if it has one. Refuses one that prefers nothing.
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

/// Takes of the two rotation vectors of a rotation the one nearer to what is wanted.
pub(super) fn unwind(form: &Form, rotation_vectors: &[usize], x: &mut [f64]) {
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

/// Where rods and springs of joints are free of force; where stops act, the nearest place where they do not.
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
