//! Newton's method for equilibria with constraints, on shape and multipliers together: `tau(q) + G^T lambda =
//! 0` and `g(q) = 0`. With stiff springs instead, rounding of the shape would cause large forces and spoil
//! convergence.

use super::{
    Counters, Equilibrium, Found, InterruptedSearch, Monitor, Options, Path, Reached, State, Status, Verdict,
    outcome, search, tied,
};
use crate::analysis::small_motions::small_motions;
use crate::analysis::stability;
use crate::error::Interrupted;
use crate::model::constraint::forget_unmoved;
use crate::model::{Static, rotation_vectors};
use crate::numerics::linalg::{Matrix, norm};
use crate::numerics::roots;

/// Forces that balance to this part are in equilibrium to rounding.
const ROUNDING_OF_FORCES: f64 = 1e-10;

/// The equations in dimensionless form: coordinates over their typical sizes, forces over the largest one of
/// the model's stiffness, gaps over their change by a typical motion.
struct Equations<'a, 'b> {
    model: &'a mut dyn Static,
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

impl roots::NonlinearSystem for Equations<'_, '_> {
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
        forget_unmoved(gap_jacobian, sizes, &model.facts().gap_sizes);
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
pub(super) struct NewtonResult {
    pub(super) q: Vec<f64>,
    multipliers: Vec<f64>,
    outcome: roots::Outcome,
    has_converged: bool,
    /// `|s R|` in joules.
    residual_norm: f64,
    tangents: usize,
}

/// Approaches the equilibrium nearest to a shape. Allocates.
pub(super) fn approach(
    model: &mut dyn Static,
    q0: &[f64],
    options: &Options,
    monitor: Monitor<'_>,
) -> Result<NewtonResult, InterruptedSearch> {
    let (n, m) = (q0.len(), model.facts().constraints());
    let (mut sizes, rest) = (vec![0.0; n], vec![0.0; n]);
    model.sizes(q0, &mut sizes);
    let (mut tangent, mut gap_jacobian) = (Matrix::zeros(n, n), Matrix::zeros(m, n));
    model.set_multipliers(&vec![0.0; m]);
    model.weighted_tangent(q0, &rest, &rest, [1.0, 0.0, 0.0], &mut tangent);
    model.gap_jacobian(q0, &mut gap_jacobian);
    forget_unmoved(&mut gap_jacobian, &sizes, &model.facts().gap_sizes);
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
    let evaluated = roots::NonlinearSystem::residual(&mut system, &x, &mut residual);
    system.model.set_multipliers(&vec![0.0; m]);
    let outcome = outcome.map_err(|unfinished| {
        let outcome = unfinished.into_inner();
        let (iterations, forces) = (outcome.iterations, outcome.residual_evaluations);
        let counters = Counters { iterations, forces, tangents: outcome.jacobian_evaluations };
        let q = x.iter().zip(&system.sizes).map(|(x, size)| x * size).collect();
        InterruptedSearch::with(Reached { q, load_factor: 1.0, path: Path::default(), counters })
    })?;
    evaluated?;
    let residual_norm = norm(&residual[..n]) * system.energy;
    let tangents = outcome.jacobian_evaluations + 1;
    let Equations { model, q, multipliers, monitor, .. } = system;
    // Within rounding of the solution, the method may report a failure although it has converged.
    let has_converged =
        outcome.status.is_success() || search::error_of_balance(model, &q, monitor)? <= ROUNDING_OF_FORCES;
    Ok(NewtonResult { q, multipliers, outcome, has_converged, residual_norm, tangents })
}

impl From<NewtonResult> for Found {
    fn from(approached: NewtonResult) -> Self {
        let NewtonResult { q, outcome, has_converged, residual_norm, multipliers, .. } = approached;
        let status = if has_converged { Status::Converged } else { Status::Newton(outcome.status) };
        let state = State { q, load_factor: 1.0, forces: Vec::new() };
        let multipliers = Some(multipliers);
        Self { multipliers, ..Self::new(status, state, outcome.step_norm, residual_norm) }
    }
}

impl NewtonResult {
    pub(super) fn counters(&self) -> Counters {
        Counters {
            iterations: self.outcome.iterations,
            forces: self.outcome.residual_evaluations + 1,
            tangents: self.tangents + 1,
        }
    }

    /// The equilibrium, if the method converged, loops are closed, the shape is valid and the stiffness alone
    /// decides stability; otherwise `None`. Allocates.
    pub(super) fn judged(&self, model: &mut dyn Static, options: &Options) -> Option<Equilibrium> {
        let is_plain =
            model.facts().springs == 0 && !model.facts().has_velocity_forces && !model.facts().has_contact;
        let is_right = is_plain
            && self.has_converged
            && model.open_loop(&self.q).is_none()
            && model.invalid_shape(&self.q).is_none();
        if !is_right {
            return None;
        }
        let (verdict, lowest) = verdict(model, &self.q, &self.multipliers, options)?;
        let (mut q, mut rest) = (self.q.clone(), vec![0.0; self.q.len()]);
        rotation_vectors::wrap(&model.facts().rotation_vectors, &mut q, &mut rest, &mut []);
        let (status, path) = (Status::Converged, Path::default());
        Some(Equilibrium {
            message: outcome::message(model, status, 1.0, options.stability, verdict, &path),
            q,
            load_factor: 1.0,
            status,
            residual_norm: self.residual_norm,
            step_norm: if self.outcome.iterations == 0 { 0.0 } else { self.outcome.step_norm },
            verdict,
            lowest,
            path,
            deepest: None,
            counters: self.counters(),
        })
    }
}

/// Stability against disturbances that satisfy the constraints, if requested, and the smallest eigenvalue of the constrained
/// stiffness in normalised coordinates: one where nothing can move. `None` if loads have no potential or a number is not finite.
fn verdict(
    model: &mut dyn Static,
    q: &[f64],
    multipliers: &[f64],
    options: &Options,
) -> Option<(Option<Verdict>, f64)> {
    let mut sizes = vec![0.0; q.len()];
    model.sizes(q, &mut sizes);
    let motions = small_motions(model, q, &sizes, 1.0, multipliers)?;
    if !motions.has_potential() {
        return None;
    }
    let lowest = tied::lowest(&motions)?;
    let verdict = if options.stability { Some(stability::verdict(&motions)?) } else { None };
    Some((verdict, lowest))
}
