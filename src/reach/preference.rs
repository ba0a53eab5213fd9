//! Which of all shapes that reach the targets: the one with the least of a quadratic form.
//!
//! `min |D (x - w)|^2 / 2` under `R(x) = 0` and bounds, by multipliers (Hestenes 1969; Powell 1969): least squares of
//! `r (R + y)` and `D (x - w)`, one after the other, with `y <- y + R` in between and r growing until R vanishes.

use std::f64::consts::TAU;

use super::misfit::Misfit;
use crate::error::{Interrupted, InvalidInput};
use crate::linalg::{Matrix, norm, symmetric_eigen};
use crate::robot::RobotModel;
use crate::roots::System;
use crate::roots::least_squares::{Bounds, Counters, End, LeastSquares, Options, solve};

/// The weight r^2 of the targets at first, its growth after rounds in which more than the part `SLOW` of R is left, and
/// its largest value, at which a double has digits left for what is preferred (Nocedal and Wright 2006, section 17.4).
const FIRST_WEIGHT: f64 = 1e2;
const GROWTH: f64 = 10.0;
const SLOW: f64 = 0.03;
const LARGEST_WEIGHT: f64 = 1e10;

/// Rounds after which multipliers that do not settle never will: at the edge of what can be reached there are none.
const MAX_ROUNDS: usize = 30;

/// So many times the steps of a start may a round take: where little is preferred the way is long and flat.
const STEPS: usize = 10;

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

/// The quadratic form, in scaled coordinates.
pub(super) struct Form {
    root: Matrix,
    wanted: Vec<f64>,
}

impl Form {
    /// The form of a preference, if it has one. Refuses one that prefers nothing.
    pub(super) fn of(
        preference: &Preference,
        model: &mut RobotModel,
        q0: &[f64],
        sizes: &[f64],
    ) -> Result<Option<Self>, InvalidInput> {
        let n = sizes.len();
        let scaled = |q: &[f64]| q.iter().zip(sizes).map(|(q, size)| q / size).collect();
        Ok(match preference {
            Preference::Any => None,
            Preference::Start => Some(Self { root: Matrix::identity(n, n), wanted: scaled(q0) }),
            Preference::Weights(weights) => {
                let roots = (0..n).map(|k| weights[k].sqrt() * sizes[k]);
                let largest = roots.clone().fold(0.0, f64::max);
                let roots: Vec<f64> = roots.map(|root| root / largest).collect();
                let root = Matrix::from_fn(n, n, |i, j| if i == j { roots[i] } else { 0.0 });
                Some(Self { root, wanted: scaled(q0) })
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
                Some(Self { root, wanted: scaled(&wanted) })
            }
        })
    }

    /// From a shape that reaches to the one that is preferred nearby; whether it came there.
    pub(super) fn settle(
        &self,
        misfit: &mut Misfit<'_, '_>,
        x: &mut [f64],
        bounds: &Bounds,
        options: &Options,
        counters: &mut Counters,
    ) -> Result<bool, Interrupted> {
        let equations = misfit.equations();
        let mut here = x.to_vec();
        self.unwind(misfit.rotation_vectors(), &mut here);
        let mut augmented =
            Augmented { form: self, misfit, multipliers: vec![0.0; equations], weight: FIRST_WEIGHT.sqrt() };
        let mut residual = vec![0.0; equations];
        let mut before = f64::INFINITY;
        for _ in 0..MAX_ROUNDS {
            let search = Options {
                tolerance: 0.0,
                terms: augmented.weight,
                max_iter: STEPS * options.max_iter,
                second_order: true,
            };
            let found = solve(&mut augmented, &mut here, bounds, &search)?;
            *counters += found.counters;
            if !matches!(found.end, End::Minimum | End::Root) {
                break;
            }
            augmented.misfit.residual(&here, &mut residual)?;
            let left = norm(&residual);
            if left <= options.tolerance {
                x.copy_from_slice(&here);
                return Ok(true);
            }
            let growth = if left > SLOW * before { GROWTH.sqrt() } else { 1.0 };
            before = left;
            let weight = (augmented.weight * growth).min(LARGEST_WEIGHT.sqrt());
            let ratio = (augmented.weight / weight).powi(2);
            for (multiplier, residual) in augmented.multipliers.iter_mut().zip(&residual) {
                *multiplier = (*multiplier + residual) * ratio;
            }
            augmented.weight = weight;
        }
        Ok(false)
    }

    /// Takes of the two rotation vectors of a rotation the one nearer to what is wanted.
    fn unwind(&self, rotation_vectors: &[usize], x: &mut [f64]) {
        for &first in rotation_vectors {
            let own = first..first + 3;
            let length = norm(&x[own.clone()]);
            let distance =
                |factor: f64| -> f64 { own.clone().map(|i| (factor * x[i] - self.wanted[i]).powi(2)).sum() };
            let other = 1.0 - TAU / length;
            if length > 0.0 && distance(other) < distance(1.0) {
                x[own].iter_mut().for_each(|x| *x *= other);
            }
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

/// `r (R + y)` and `D (x - w)`.
struct Augmented<'a, 'b, 'c> {
    form: &'a Form,
    misfit: &'a mut Misfit<'b, 'c>,
    multipliers: Vec<f64>,
    weight: f64,
}

impl System for Augmented<'_, '_, '_> {
    fn unknowns(&self) -> usize {
        self.misfit.unknowns()
    }

    fn equations(&self) -> usize {
        self.multipliers.len() + self.misfit.unknowns()
    }

    fn residual(&mut self, x: &[f64], residual: &mut [f64]) -> Result<(), Interrupted> {
        let (of_targets, of_form) = residual.split_at_mut(self.multipliers.len());
        self.misfit.residual(x, of_targets)?;
        for (residual, multiplier) in of_targets.iter_mut().zip(&self.multipliers) {
            *residual = self.weight * (*residual + multiplier);
        }
        of_form.fill(0.0);
        for (k, column) in self.form.root.column_iter().enumerate() {
            let difference = x[k] - self.form.wanted[k];
            of_form.iter_mut().zip(column.iter()).for_each(|(sum, entry)| *sum += entry * difference);
        }
        Ok(())
    }

    fn jacobian(&mut self, x: &[f64], jacobian: &mut Matrix) -> Result<(), Interrupted> {
        let (m, n) = (self.multipliers.len(), x.len());
        let mut of_targets = Matrix::zeros(m, n);
        self.misfit.jacobian(x, &mut of_targets)?;
        jacobian.rows_mut(0, m).copy_from(&(of_targets * self.weight));
        jacobian.rows_mut(m, n).copy_from(&self.form.root);
        Ok(())
    }
}

impl LeastSquares for Augmented<'_, '_, '_> {}
