//! Letting go: from any shape to a stable equilibrium nearby, downhill in potential energy.
//!
//! Newton's method in a trust region (Levenberg 1944; Conn, Gould and Toint 2000, chapter 6). Energies are never asked for, as
//! some loads have none: the work of the generalised forces along a step, by the trapezoidal rule, takes their place.

use super::corrector::State;
use super::equations::Equations;
use crate::error::Interrupted;
use crate::linalg::{Cholesky, Lu, Matrix, dot, norm};

/// First radius, in scaled coordinates: half a radian of the whole rod.
const FIRST_RADIUS: f64 = 0.5;

/// Largest radius.
const LARGEST_RADIUS: f64 = 4.0;

/// A step is taken when it gives this part of the work that its quadratic model promises.
const TAKEN: f64 = 1e-3;

/// Below this part the radius shrinks to a quarter of the step, beyond the other one it may double (Conn, Gould and Toint
/// 2000, section 6.1).
const POOR: f64 = 0.25;
const GOOD: f64 = 0.75;

/// Multiples of the reference stiffness that are added to make steps descend and stay in the region: the first one, the
/// factor to the next one.
const FIRST_SHIFT: f64 = 1e-3;
const SHIFT_FACTOR: f64 = 4.0;

/// With a larger shift than that nothing moves.
const LARGEST_SHIFT: f64 = 1e12;

/// Steps as short as that are taken without looking at their work, which is rounding then.
const TRUSTED: f64 = 1e-6;

/// How a descent ended.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Descent {
    /// At an equilibrium; the scaled norm of the last step, and of the residual before it.
    Converged { step_norm: f64, residual_norm: f64 },
    /// The limit of iterations was reached.
    IterationLimit,
    /// No step, however short, goes downhill.
    Stalled,
    /// Forces are not finite at the start.
    NonFinite,
}

/// Moves `state` downhill at its load factor until it is in equilibrium.
pub(super) fn descend(
    equations: &mut Equations<'_>,
    state: &mut State,
    tolerance: f64,
    max_iterations: usize,
) -> Result<Descent, Interrupted> {
    let n = equations.n();
    let (mut residual, mut load, mut step) = (vec![0.0; n], vec![0.0; n], vec![0.0; n]);
    let mut trial_residual = residual.clone();
    let mut trial = state.clone();
    let mut tangent = Matrix::zeros(n, n);
    let mut shifted = tangent.clone();
    let (mut cholesky, mut lu) = (Cholesky::new(n), Lu::new(n));
    let (mut radius, mut shift) = (FIRST_RADIUS, 0.0);
    equations.residual(&state.q, state.load_factor, &mut residual, &mut load)?;
    for _ in 0..max_iterations {
        equations.tangent(&state.q, state.load_factor, &mut tangent);
        equations.counters.iterations += 1;
        if !norm(&residual).is_finite() || !tangent.iter().all(|x| x.is_finite()) {
            return Ok(Descent::NonFinite);
        }
        let stiffness = equations.reference_stiffness(&tangent);
        shift = if shift > FIRST_SHIFT { shift / (SHIFT_FACTOR * SHIFT_FACTOR) } else { 0.0 };
        let mut taken = false;
        while !taken {
            // A shift for which the symmetric part is positive definite and the step stays in the region.
            let length = loop {
                shifted.copy_from(&tangent);
                for i in 0..n {
                    shifted[(i, i)] += shift * stiffness[i];
                }
                let symmetric = Matrix::from_fn(n, n, |i, j| 0.5 * (shifted[(i, j)] + shifted[(j, i)]));
                if cholesky.factorise(&symmetric).is_ok() && lu.factorise(&shifted).is_ok() {
                    for (step, residual) in step.iter_mut().zip(&residual) {
                        *step = -residual;
                    }
                    lu.solve(&mut step);
                    let length = norm(&step);
                    if length <= radius {
                        break length;
                    }
                }
                shift = (SHIFT_FACTOR * shift).max(FIRST_SHIFT);
                if shift > LARGEST_SHIFT {
                    return Ok(Descent::Stalled);
                }
            };
            trial.q.copy_from_slice(&state.q);
            for i in 0..n {
                trial.q[i] += step[i] * equations.sizes[i];
            }
            let residual_norm = norm(&residual);
            if length * (1.0 + shift) <= tolerance {
                state.q.copy_from_slice(&trial.q);
                return Ok(Descent::Converged { step_norm: length, residual_norm });
            }
            equations.residual(&trial.q, trial.load_factor, &mut trial_residual, &mut load)?;
            let before = dot(&residual, &step);
            let work = 0.5 * (before + dot(&trial_residual, &step));
            // Half of R.s + s.K s with (K + shift D) s = -R.
            let shifted_work: f64 = (0..n).map(|i| shift * stiffness[i] * step[i] * step[i]).sum();
            let promised = 0.5 * (before - shifted_work);
            let ratio = if work.is_finite() { work / promised } else { 0.0 };
            if ratio < POOR {
                radius = 0.25 * length;
            } else if ratio > GOOD && length > 0.5 * radius {
                radius = (2.0 * radius).min(LARGEST_RADIUS);
            }
            let is_better = norm(&trial_residual) < residual_norm;
            taken = ratio > TAKEN || length <= TRUSTED && is_better;
            if !taken && length <= TRUSTED {
                // What is left is rounding.
                return Ok(if length <= tolerance.sqrt() && shift <= 1.0 {
                    Descent::Converged { step_norm: length, residual_norm }
                } else {
                    Descent::Stalled
                });
            }
        }
        state.q.copy_from_slice(&trial.q);
        std::mem::swap(&mut residual, &mut trial_residual);
        radius = radius.max(1e3 * TRUSTED);
    }
    Ok(Descent::IterationLimit)
}
