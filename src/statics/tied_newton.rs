//! Newton's method for equilibria with constraints: of shape and multipliers together, `tau(q) + G^T lambda = 0` and
//! `g(q) = 0`. Springs that hardly give would turn rounding of the shape into forces that hide the way.

use super::{Monitor, Options};
use crate::error::Interrupted;
use crate::linalg::Matrix;
use crate::model::Model;
use crate::roots;

/// The equations, in numbers without unit: coordinates over their typical sizes, forces over the largest one of the model's
/// stiffness, gaps over what a typical motion changes in them.
struct Equilibrium<'a, 'b> {
    model: &'a mut dyn Model,
    monitor: Monitor<'b>,
    sizes: Vec<f64>,
    energy: f64,
    /// Of every constraint.
    gaps: Vec<f64>,
    q: Vec<f64>,
    multipliers: Vec<f64>,
    rest: Vec<f64>,
    tangent: Matrix,
    gap_jacobian: Matrix,
}

impl Equilibrium<'_, '_> {
    fn set(&mut self, x: &[f64]) -> Result<(), Interrupted> {
        (self.monitor)()?;
        let (of_shape, of_multipliers) = x.split_at(self.q.len());
        for ((q, x), size) in self.q.iter_mut().zip(of_shape).zip(&self.sizes) {
            *q = x * size;
        }
        for ((multiplier, x), gap) in self.multipliers.iter_mut().zip(of_multipliers).zip(&self.gaps) {
            *multiplier = x * self.energy / gap;
        }
        self.model.set_multipliers(&self.multipliers);
        Ok(())
    }
}

impl roots::System for Equilibrium<'_, '_> {
    fn unknowns(&self) -> usize {
        self.q.len() + self.gaps.len()
    }

    fn residual(&mut self, x: &[f64], residual: &mut [f64]) -> Result<(), Interrupted> {
        self.set(x)?;
        let (tau, gaps) = residual.split_at_mut(self.q.len());
        self.model.inverse_dynamics(&self.q, &self.rest, &self.rest, tau);
        self.model.gaps(&self.q, gaps);
        tau.iter_mut().zip(&self.sizes).for_each(|(tau, size)| *tau *= size / self.energy);
        gaps.iter_mut().zip(&self.gaps).for_each(|(gap, size)| *gap /= size);
        Ok(())
    }

    fn jacobian(&mut self, x: &[f64], jacobian: &mut Matrix) -> Result<(), Interrupted> {
        self.set(x)?;
        let n = self.q.len();
        let Self { model, q, rest, tangent, gap_jacobian, sizes, gaps, energy, .. } = self;
        model.weighted_tangent(q, rest, rest, [1.0, 0.0, 0.0], tangent);
        model.gap_jacobian(q, gap_jacobian);
        jacobian.fill(0.0);
        for k in 0..n {
            for j in 0..n {
                jacobian[(j, k)] = tangent[(j, k)] * sizes[j] * sizes[k] / *energy;
            }
            for (i, gap) in gaps.iter().enumerate() {
                let entry = gap_jacobian[(i, k)] * sizes[k] / gap;
                jacobian[(n + i, k)] = entry;
                jacobian[(k, n + i)] = entry;
            }
        }
        Ok(())
    }
}

/// Moves a shape to the nearest equilibrium, as far as the method comes. Allocates.
pub(super) fn approach(
    model: &mut dyn Model,
    q: &mut [f64],
    options: &Options,
    monitor: Monitor<'_>,
) -> Result<(), Interrupted> {
    let (n, m) = (q.len(), model.constraints());
    let (mut sizes, rest) = (vec![0.0; n], vec![0.0; n]);
    model.typical_coordinates(&mut sizes);
    let (mut tangent, mut gap_jacobian) = (Matrix::zeros(n, n), Matrix::zeros(m, n));
    model.set_multipliers(&vec![0.0; m]);
    model.weighted_tangent(q, &rest, &rest, [1.0, 0.0, 0.0], &mut tangent);
    model.gap_jacobian(q, &mut gap_jacobian);
    let or_one = |x: f64| if x > 0.0 && x.is_finite() { x } else { 1.0 };
    let energy = or_one((0..n).map(|k| (tangent[(k, k)] * sizes[k] * sizes[k]).abs()).fold(0.0, f64::max));
    let gap =
        |i: usize| or_one((0..n).map(|k| (gap_jacobian[(i, k)] * sizes[k]).powi(2)).sum::<f64>().sqrt());
    let gaps: Vec<f64> = (0..m).map(gap).collect();
    let search = roots::Options {
        method: roots::Method::TrustRegion,
        residual_tolerance: 0.0,
        step_tolerance: roots::StepTolerance { absolute: options.tol / (n as f64).sqrt(), relative: 0.0 },
        max_iter: options.max_iter,
        ..roots::Options::default()
    };
    let mut x: Vec<f64> = q.iter().zip(&sizes).map(|(q, size)| q / size).collect();
    x.resize(n + m, 0.0);
    let multipliers = vec![0.0; m];
    let mut system = Equilibrium {
        model,
        monitor,
        sizes,
        energy,
        gaps,
        q: q.to_vec(),
        multipliers,
        rest,
        tangent,
        gap_jacobian,
    };
    let found = roots::Newton::new(n + m, n + m).solve(&mut system, &mut x, &search);
    system.model.set_multipliers(&vec![0.0; m]);
    found?;
    for ((q, x), size) in q.iter_mut().zip(&x).zip(&system.sizes) {
        *q = x * size;
    }
    Ok(())
}
