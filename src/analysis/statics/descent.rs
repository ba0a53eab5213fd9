//! Descent from any shape to a nearby stable equilibrium, under loads that need not have a potential.
//!
//! Newton's method in a trust region (Levenberg 1944; Conn, Gould and Toint 2000, chapter 6). Energies are
//! not used, because some loads have none: the work of the generalised forces along a step, by the
//! trapezoidal rule, replaces them.

use super::equations::{Equations, Linear, State, Step};
use super::tunnelling::Passage;
use crate::error::Interrupted;
use crate::model::InvalidShape;
use crate::numerics::linalg::symmetric_part;
use crate::numerics::linalg::{Cholesky, Lu, dot, norm};

/// Initial radius, in scaled coordinates: half a radian of the whole rod.
const FIRST_RADIUS: f64 = 0.5;

/// Largest radius.
const LARGEST_RADIUS: f64 = 4.0;

/// A step is accepted if its work is at least this fraction of the quadratic model's prediction.
const ACCEPTED_RATIO: f64 = 1e-3;

/// Below `POOR_RATIO` the radius shrinks to a quarter of the step, above `GOOD_RATIO` it may double (Conn, Gould and
/// Toint 2000, section 6.1).
const POOR_RATIO: f64 = 0.25;
const GOOD_RATIO: f64 = 0.75;

/// Multiples of the normalised stiffness added to the tangent, so that steps descend and stay within the region:
/// first shift, and ratio of successive shifts.
const FIRST_SHIFT: f64 = 1e-3;
const SHIFT_FACTOR: f64 = 4.0;

/// Above this shift steps have no effect.
const LARGEST_SHIFT: f64 = 1e12;

/// Steps shorter than this are accepted without comparing their work, which is at the level of rounding.
const ROUNDING_STEP: f64 = 1e-6;

/// Smallest radius at the start of an iteration: well above [`ROUNDING_STEP`], so that one rejected step does not end the descent.
const SMALLEST_RADIUS: f64 = 1e3 * ROUNDING_STEP;

/// If surfaces begin to touch within such a step, the tangent changes along it; then only steps shorter by
/// this factor are at the level of rounding.
const ROUNDING_FACTOR_AT_KINKS: f64 = 1e-3;

/// Maximum number of iterations that make a trial's springs consistent with their forces; each one about doubles the number of
/// correct digits. The same limit applies at the start, which may be far from consistent.
const MAX_SPRING_ITERATIONS: usize = 8;
const MAX_FIRST_SPRING_ITERATIONS: usize = 50;

/// Result of a descent.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Descent {
    /// Equilibrium; with the scaled norms of the last step and of the residual before it.
    Converged { step_norm: f64, residual_norm: f64 },
    /// The limit of iterations was reached.
    IterationLimit,
    /// No step, however short, decreases the energy.
    Stalled,
    /// The descent leads to invalid shapes.
    Invalid(InvalidShape),
    /// Forces are not finite at the start.
    NonFinite,
}

/// Newton steps with a shifted tangent.
struct Shifted {
    cholesky: Cholesky,
    lu: Lu,
    /// The last step.
    x: Vec<f64>,
}

impl Shifted {
    fn new(n: usize) -> Self {
        Self { cholesky: Cholesky::new(n), lu: Lu::new(n), x: vec![0.0; n] }
    }

    /// The step and its length for the smallest shift, starting from `shift`, for which the symmetric part is
    /// positive definite and the step is no longer than `radius`; `None` if no shift is sufficient.
    fn step(&mut self, linear: &Linear, shift: &mut f64, radius: f64) -> Option<(Step, f64)> {
        loop {
            let mut shifted = linear.tangent.clone();
            for i in 0..self.x.len() {
                shifted[(i, i)] += *shift;
            }
            if self.cholesky.factorise(&symmetric_part(&shifted)).is_ok()
                && self.lu.factorise(&shifted).is_ok()
            {
                for (x, residual) in self.x.iter_mut().zip(&linear.residual) {
                    *x = -residual;
                }
                self.lu.solve(&mut self.x);
                let step = linear.step(&self.x, 0.0);
                let length = norm(&step.scaled);
                if length <= radius {
                    return Some((step, length));
                }
            }
            *shift = (SHIFT_FACTOR * *shift).max(FIRST_SHIFT);
            if *shift > LARGEST_SHIFT {
                return None;
            }
        }
    }
}

/// Moves `state` downhill at its load factor until equilibrium.
///
/// A step updates the forces of the springs to first order, and restores a shape consistent with these forces
/// before the step is judged. Stiff springs thus do not limit the length of steps.
pub(super) fn descend(
    equations: &mut Equations<'_>,
    state: &mut State,
    tolerance: f64,
    max_iter: usize,
) -> Result<Descent, Interrupted> {
    if !state.forces.is_empty() {
        state.forces.fill(0.0);
        equations.restore(state, MAX_FIRST_SPRING_ITERATIONS);
        *state = equations.state(std::mem::take(&mut state.q), state.load_factor)?;
    }
    let mut shifted = Shifted::new(equations.n());
    let (mut radius, mut shift) = (FIRST_RADIUS, 0.0);
    let mut here = equations.downhill(state)?;
    for _ in 0..max_iter {
        equations.counters.iterations += 1;
        let Some(linear) = equations.linearise(state)? else { return Ok(Descent::NonFinite) };
        shift = if shift > FIRST_SHIFT { shift / (SHIFT_FACTOR * SHIFT_FACTOR) } else { 0.0 };
        let mut invalid_shape = None;
        loop {
            let Some((step, length)) = shifted.step(&linear, &mut shift, radius) else {
                return Ok(invalid_shape.map_or(Descent::Stalled, Descent::Invalid));
            };
            let mut trial = state.clone();
            linear.advance(&mut trial, &step, &equations.sizes);
            let residual_norm = linear.residual_norm;
            if length * (1.0 + shift) <= tolerance {
                *state = trial;
                return Ok(Descent::Converged { step_norm: length, residual_norm });
            }
            equations.restore(&mut trial, MAX_SPRING_ITERATIONS);
            let there = equations.downhill(&trial)?;
            let work = here.work(&there, &trial.since(state, &equations.sizes));
            // Half of R.x + x.K x with (K + shift) x = -R.
            let predicted = 0.5 * (dot(&linear.residual, &shifted.x) - shift * dot(&shifted.x, &shifted.x));
            let inverted = equations
                .invalid_shape(&trial.q)
                .filter(|invalid_shape| matches!(invalid_shape, InvalidShape::Inverted { .. }));
            let passage = if work.is_finite() && inverted.is_none() {
                equations.passage([&state.q, &trial.q], length)
            } else {
                Passage::Free
            };
            let is_sound = work.is_finite() && inverted.is_none() && passage == Passage::Free;
            let ratio = if is_sound { work / predicted } else { 0.0 };
            if ratio < POOR_RATIO {
                radius = 0.25 * length;
            } else if ratio > GOOD_RATIO && length > 0.5 * radius {
                radius = (2.0 * radius).min(LARGEST_RADIUS);
            }
            let is_better = there.residual_norm < here.residual_norm && is_sound;
            if ratio > ACCEPTED_RATIO || length <= ROUNDING_STEP && is_better {
                *state = trial;
                here = there;
                break;
            }
            invalid_shape = inverted.or(passage.invalid_shape());
            if length
                <= if equations.has_contact() {
                    ROUNDING_FACTOR_AT_KINKS * ROUNDING_STEP
                } else {
                    ROUNDING_STEP
                }
            {
                // The remaining residual is rounding.
                return Ok(if length <= tolerance.sqrt() && shift <= 1.0 && invalid_shape.is_none() {
                    Descent::Converged { step_norm: length, residual_norm }
                } else {
                    invalid_shape.map_or(Descent::Stalled, Descent::Invalid)
                });
            }
        }
        radius = radius.max(SMALLEST_RADIUS);
    }
    Ok(Descent::IterationLimit)
}
