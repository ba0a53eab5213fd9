//! Derivatives of runs of Radau IIA.
//!
//! The three stages have the accelerations `a_i`, velocities `v_i = v + h sum_j A_ij a_j` and coordinates
//! `q_i = q + c_i h v + h^2 sum_j (A^2)_ij a_j`. A step solves `r(q_i, v_i, a_i) = 0` (see [`crate::integrators::radau`]),
//! so that
//!
//! ```text
//! sum_j (delta_ij M_i + h A_ij D_i + h^2 (A^2)_ij K_i) da_j = -(K_i (dq + c_i h dv) + D_i dv + dr_i/dp dp)
//! ```

use super::equations::{Equations, Linearised};
use super::{Failure, Monitor, Parameters, StateDerivatives, Together, Trajectory};
use crate::integrators::ode::radau_iia::{A, A_SQUARED, C, STAGES};
use crate::model::Model;
use crate::numerics::linalg::{Lu, Matrix, Singular, norm_inf};

/// Maximum number of Newton corrections to recompute stages; the stages of a run are known to converge.
const MOST_CORRECTIONS: usize = 8;

/// After corrections below this fraction of the accelerations, stages are exact to rounding, because
/// convergence is quadratic.
const SMALL_CORRECTION: f64 = 1e-9;

/// A correction that is not smaller than this fraction of the previous one is rounding.
const LEAST_PROGRESS: f64 = 0.5;

/// The equations of the three stages of a step.
struct Stages<'a, M: ?Sized> {
    equations: Equations<'a, M>,
    n: usize,
    at: [Linearised; STAGES],
    /// Accelerations and residuals of all stages.
    a: Vec<f64>,
    residual: Vec<f64>,
    /// Weighted tangent of a stage, and the matrix of all stages.
    block: Matrix,
    matrix: Matrix,
    lu: Lu,
}

impl<'a, M: Model + ?Sized> Stages<'a, M> {
    fn new(model: &'a mut M, trajectory: &Trajectory<'a>) -> Self {
        let n = model.facts().n;
        Self {
            n,
            at: std::array::from_fn(|_| Linearised::new(n)),
            a: vec![0.0; STAGES * n],
            residual: vec![0.0; STAGES * n],
            block: Matrix::zeros(n, n),
            matrix: Matrix::zeros(STAGES * n, STAGES * n),
            lu: Lu::new(STAGES * n),
            equations: Equations::new(model, trajectory.intervals),
        }
    }

    /// Computes the stages of the step to this state, and factorises their equations.
    fn find(&mut self, trajectory: &Trajectory<'_>, step: usize) -> Result<(), Failure> {
        self.guess(trajectory, step);
        let mut last = f64::INFINITY;
        for _ in 0..MOST_CORRECTIONS {
            self.linearise(trajectory, step)?;
            self.factorise(step)?;
            self.lu.solve(&mut self.residual);
            let correction = norm_inf(&self.residual);
            if !correction.is_finite() {
                return Err(Failure::Singular(step));
            }
            if correction <= SMALL_CORRECTION * norm_inf(&self.a) || correction > LEAST_PROGRESS * last {
                break;
            }
            last = correction;
            self.a.iter_mut().zip(&self.residual).for_each(|(a, change)| *a -= change);
        }
        Ok(())
    }

    /// Initial guess of the stages: linear interpolation between the accelerations at both ends.
    fn guess(&mut self, trajectory: &Trajectory<'_>, step: usize) {
        let n = self.n;
        let (_, [_, _, start]) = trajectory.state(step - 1, n);
        let (_, [_, _, end]) = trajectory.state(step, n);
        for (c, a) in C.into_iter().zip(self.a.chunks_exact_mut(n.max(1))) {
            for i in 0..n {
                a[i] = start[i] + c * (end[i] - start[i]);
            }
        }
    }

    /// Evaluates the residual and the tangents of all stages, and the matrix of their equations.
    fn linearise(&mut self, trajectory: &Trajectory<'_>, step: usize) -> Result<(), Failure> {
        let n = self.n;
        let (t, [q, v, _]) = trajectory.state(step - 1, n);
        let h = trajectory.t[step] - t;
        for (i, at) in self.at.iter_mut().enumerate() {
            at.t = if i + 1 == STAGES { trajectory.t[step] } else { t + C[i] * h };
            for k in 0..n {
                let a: [f64; STAGES] = std::array::from_fn(|j| self.a[j * n + k]);
                let sum = |row: &[f64; STAGES]| row[0] * a[0] + row[1] * a[1] + row[2] * a[2];
                at.q[k] = q[k] + h * (C[i] * v[k] + h * sum(&A_SQUARED[i]));
                at.v[k] = v[k] + h * sum(&A[i]);
                at.a[k] = a[i];
            }
            self.equations.residual(at, &mut self.residual[i * n..(i + 1) * n])?;
            let own = [h * h * A_SQUARED[i][i], h * A[i][i], 1.0];
            self.equations.linearise(at, own, &mut self.block)?;
            for j in 0..STAGES {
                let mut place = self.matrix.view_mut((i * n, j * n), (n, n));
                if i == j {
                    place.copy_from(&self.block);
                } else {
                    let (of_damping, of_stiffness) = (h * A[i][j], h * h * A_SQUARED[i][j]);
                    let tangents = at.damping.iter().zip(at.stiffness.iter());
                    for (entry, (damping, stiffness)) in place.iter_mut().zip(tangents) {
                        *entry = of_damping * damping + of_stiffness * stiffness;
                    }
                }
            }
        }
        Ok(())
    }

    fn factorise(&mut self, step: usize) -> Result<(), Failure> {
        self.lu.factorise(&self.matrix).map_err(|Singular| Failure::Singular(step))
    }
}

/// Derivatives of coordinates and velocities of all states with respect to all parameters.
pub(super) fn forward<M: Model + ?Sized, F: Model + ?Sized>(
    model: &mut M,
    trajectory: &Trajectory<'_>,
    parameters: &mut Parameters<'_, F>,
    monitor: &mut Monitor<'_>,
) -> Result<StateDerivatives, Failure> {
    let (n, p) = (model.facts().n, parameters.of.len());
    let mut stages = Stages::new(model, trajectory);
    let (mut q, mut v) = (parameters.dq0.clone(), parameters.dv0.clone());
    let mut at_stage = q.clone();
    let mut change = Matrix::zeros(n, p);
    let mut da = Matrix::zeros(STAGES * n, p);
    let mut kept = StateDerivatives::new(trajectory.t.len() * n * p);
    stages.equations.hold(0, parameters.of);
    kept.add([&q, &v]);
    for step in 1..trajectory.t.len() {
        let h = trajectory.t[step] - trajectory.t[step - 1];
        stages.find(trajectory, step)?;
        for (i, at) in stages.at.iter().enumerate() {
            at_stage.copy_from(&q);
            at_stage.zip_apply(&v, |q, v| *q += C[i] * h * v);
            stages.equations.change(at, [&at_stage, &v], parameters.of, &mut change)?;
            da.rows_mut(i * n, n).copy_from(&change);
        }
        if !da.is_empty() {
            da.as_mut_slice().chunks_exact_mut(STAGES * n).for_each(|column| stages.lu.solve(column));
        }
        q.zip_apply(&v, |q, v| *q += h * v);
        for j in 0..STAGES {
            let da = da.rows(j * n, n);
            q.zip_apply(&da, |q, da| *q += h * h * A_SQUARED[STAGES - 1][j] * da);
            v.zip_apply(&da, |v, da| *v += h * A[STAGES - 1][j] * da);
        }
        if let Some(interval) = trajectory.interval_from(step) {
            stages.equations.hold(interval, parameters.of);
        }
        monitor()?;
        kept.add([&q, &v]);
    }
    Ok(kept)
}

/// Gradient with respect to all parameters.
pub(super) fn adjoint<M: Model + ?Sized, F: Model + ?Sized>(
    model: &mut M,
    trajectory: &Trajectory<'_>,
    weights: [&[f64]; 2],
    parameters: &mut Parameters<'_, F>,
    together: &mut Together,
    monitor: &mut Monitor<'_>,
) -> Result<Vec<f64>, Failure> {
    let n = model.facts().n;
    let mut gradient = vec![0.0; parameters.of.len()];
    let mut stages = Stages::new(model, trajectory);
    // Adjoint variables: derivatives of the function with respect to q and v of the current state.
    let [mut on_q, mut on_v] = [0; 2].map(|_| vec![0.0; n]);
    let [mut from_q, mut from_v] = [0; 2].map(|_| vec![0.0; n]);
    let mut lambda = vec![0.0; STAGES * n];
    stages.equations.hold(trajectory.last_interval(), parameters.of);
    for step in (0..trajectory.t.len()).rev() {
        for i in 0..n {
            on_q[i] += weights[0][step * n + i];
            on_v[i] += weights[1][step * n + i];
        }
        if step == 0 {
            break;
        }
        if let Some(interval) = trajectory.interval_from(step) {
            stages.equations.hold(interval - 1, parameters.of);
        }
        let h = trajectory.t[step] - trajectory.t[step - 1];
        stages.find(trajectory, step)?;
        stages.matrix.transpose_mut();
        stages.factorise(step)?;
        for (j, lambda) in lambda.chunks_exact_mut(n.max(1)).enumerate() {
            for i in 0..n {
                lambda[i] = -h * (h * A_SQUARED[STAGES - 1][j] * on_q[i] + A[STAGES - 1][j] * on_v[i]);
            }
        }
        stages.lu.solve(&mut lambda);
        for i in 0..n {
            on_v[i] += h * on_q[i];
        }
        for (i, (at, lambda)) in stages.at.iter().zip(lambda.chunks_exact(n.max(1))).enumerate() {
            stages.equations.gather(at, lambda, parameters.of, &mut gradient, together)?;
            from_q.fill(0.0);
            from_v.fill(0.0);
            at.add_transposed(lambda, [&mut from_q, &mut from_v]);
            for k in 0..n {
                on_q[k] += from_q[k];
                on_v[k] += from_v[k] + C[i] * h * from_q[k];
            }
        }
        monitor()?;
    }
    parameters.add_starts([&on_q, &on_v], &mut gradient);
    Ok(gradient)
}
