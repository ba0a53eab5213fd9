//! Newton's method for equilibria with constraints, on shape and multipliers together: `tau(q) + G^T lambda =
//! 0` and `g(q) = 0`. With stiff springs instead, rounding of the shape would cause large forces and spoil
//! convergence.

use super::{Counters, Equilibrium, Halted, Monitor, Options, Path, Reached, Status, Verdict, outcome};
use crate::constraint::Independent;
use crate::error::Interrupted;
use crate::linalg::{Matrix, norm, symmetric_eigenvalues, symmetric_part};
use crate::model::{Model, rotation_vectors};
use crate::natural::{self, Natural, scaled};
use crate::roots;
use crate::stability::{self, is_symmetric};

/// The equations in dimensionless form: coordinates over their typical sizes, forces over the largest one of
/// the model's stiffness, gaps over their change by a typical motion.
struct Equations<'a, 'b> {
    model: &'a mut dyn Model,
    monitor: Monitor<'b>,
    sizes: Vec<f64>,
    energy: f64,
    /// Gaps of all constraints.
    gaps: Vec<f64>,
    q: Vec<f64>,
    multipliers: Vec<f64>,
    rest: Vec<f64>,
    tangent: Matrix,
    gap_jacobian: Matrix,
}

impl Equations<'_, '_> {
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

impl roots::System for Equations<'_, '_> {
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

/// Result of the iteration.
pub(super) struct Approached {
    pub(super) q: Vec<f64>,
    multipliers: Vec<f64>,
    outcome: roots::Outcome,
    /// `|s R|` in joules.
    residual_norm: f64,
    tangents: usize,
}

/// Approaches the equilibrium nearest to a shape. Allocates.
pub(super) fn approach(
    model: &mut dyn Model,
    q0: &[f64],
    options: &Options,
    monitor: Monitor<'_>,
) -> Result<Approached, Halted> {
    let (n, m) = (q0.len(), model.constraints());
    let (mut sizes, rest) = (vec![0.0; n], vec![0.0; n]);
    model.typical_coordinates(&mut sizes);
    let (mut tangent, mut gap_jacobian) = (Matrix::zeros(n, n), Matrix::zeros(m, n));
    model.set_multipliers(&vec![0.0; m]);
    model.weighted_tangent(q0, &rest, &rest, [1.0, 0.0, 0.0], &mut tangent);
    model.gap_jacobian(q0, &mut gap_jacobian);
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
    let mut x: Vec<f64> = q0.iter().zip(&sizes).map(|(q, size)| q / size).collect();
    x.resize(n + m, 0.0);
    let multipliers = vec![0.0; m];
    let mut system = Equations {
        model,
        monitor,
        sizes,
        energy,
        gaps,
        q: q0.to_vec(),
        multipliers,
        rest,
        tangent,
        gap_jacobian,
    };
    let outcome = roots::Newton::new(n + m, n + m).solve(&mut system, &mut x, &search);
    let mut residual = vec![0.0; n + m];
    let evaluated = roots::System::residual(&mut system, &x, &mut residual);
    system.model.set_multipliers(&vec![0.0; m]);
    let outcome = outcome.map_err(|unfinished| {
        let outcome = unfinished.into_inner();
        let (iterations, forces) = (outcome.iterations, outcome.residual_evaluations);
        let counters = Counters { iterations, forces, tangents: outcome.jacobian_evaluations };
        let q = x.iter().zip(&system.sizes).map(|(x, size)| x * size).collect();
        Halted::with(Reached { q, load_factor: 1.0, path: Path::default(), counters })
    })?;
    evaluated?;
    let residual_norm = norm(&residual[..n]) * system.energy;
    let tangents = outcome.jacobian_evaluations + 1;
    Ok(Approached { q: system.q, multipliers: system.multipliers, outcome, residual_norm, tangents })
}

impl Approached {
    /// The equilibrium, if the method converged, loops are closed, the shape is valid and the stiffness alone
    /// decides stability; otherwise `None`. Allocates.
    pub(super) fn judged(&self, model: &mut dyn Model) -> Option<Equilibrium> {
        let is_plain = model.springs() == 0 && !model.has_velocity_forces() && !model.has_contact();
        let is_right = is_plain
            && self.outcome.status.is_success()
            && model.open_loop(&self.q).is_none()
            && model.flaw(&self.q).is_none();
        if !is_right {
            return None;
        }
        let (verdict, lowest) = verdict(model, &self.q, &self.multipliers)?;
        let (mut q, mut rest) = (self.q.clone(), vec![0.0; self.q.len()]);
        rotation_vectors::wrap(model.rotation_vectors(), &mut q, &mut rest, &mut []);
        let (status, path) = (Status::Converged, Path::default());
        Some(Equilibrium {
            message: outcome::message(status, 1.0, Some(verdict), &path),
            q,
            load_factor: 1.0,
            status,
            residual_norm: self.residual_norm,
            step_norm: if self.outcome.iterations == 0 { 0.0 } else { self.outcome.step_norm },
            verdict: Some(verdict),
            lowest,
            path,
            counters: Counters {
                iterations: self.outcome.iterations,
                forces: self.outcome.residual_evaluations + 1,
                tangents: self.tangents + 1,
            },
        })
    }
}

/// Stability against disturbances that satisfy the constraints, and the smallest eigenvalue of the
/// constrained stiffness: of `P K P + (1 - P)` in natural coordinates, where P projects onto the null space
/// of the constraints. `None` if the stiffness is not symmetric or not finite.
fn verdict(model: &mut dyn Model, q: &[f64], multipliers: &[f64]) -> Option<(Verdict, f64)> {
    let (n, m) = (q.len(), multipliers.len());
    let (mut sizes, rest) = (vec![0.0; n], vec![0.0; n]);
    model.typical_coordinates(&mut sizes);
    let [mut tangent, mut elastic] = [Matrix::zeros(n, n), Matrix::zeros(n, n)];
    let mut gap_jacobian = Matrix::zeros(m, n);
    model.elastic_tangent(q, &mut elastic);
    model.gap_jacobian(q, &mut gap_jacobian);
    model.set_multipliers(multipliers);
    model.weighted_tangent(q, &rest, &rest, [1.0, 0.0, 0.0], &mut tangent);
    model.set_multipliers(&vec![0.0; m]);
    if !tangent.iter().chain(&elastic).all(|x| x.is_finite()) {
        return None;
    }
    let [tangent, elastic] = [tangent, elastic].map(|a| scaled(a, &sizes));
    let natural = Natural::new(&elastic, None, || natural::reference(&elastic, &tangent, 0.0))?;
    let stiffness = natural.tangent(&tangent, None);
    if !is_symmetric(&stiffness) {
        return None;
    }
    let mut rows = gap_jacobian;
    for (mut column, size) in rows.column_iter_mut().zip(&sizes) {
        column *= *size;
    }
    let rows = rows * natural.basis();
    let mut independent = Independent::new(m, n);
    independent.find(&rows, |_| 1.0);
    let chosen: Vec<usize> = (0..m).filter(|&row| independent.is_independent(row)).collect();
    let held = rows.select_rows(&chosen).transpose().qr().q();
    let free = Matrix::identity(n, n) - &held * held.transpose();
    let restricted = &free * symmetric_part(&stiffness) * &free + &held * held.transpose();
    let lowest = symmetric_eigenvalues(&symmetric_part(&restricted))?.first().copied().unwrap_or(1.0);
    let verdict = stability::of_stiffness(lowest, n, stability::largest(&restricted))?;
    Some((verdict, lowest))
}
