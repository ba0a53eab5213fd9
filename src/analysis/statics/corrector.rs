//! Newton's method on the bordered equations. It monitors its contraction, and either stays close to its
//! start or fails. [`crate::numerics::roots`] searches for roots from arbitrary starts.
//!
//! At a bifurcation the bordered equations are singular, possibly with a higher nullity. Newton's step is
//! then dominated by rounding. Nearby it does not contract either, because the tangent is that of the
//! continuous rod and differs slightly from the derivative of the discretised forces. Therefore soft
//! directions, which have no stiffness and in which the forces are in equilibrium, can be fixed.

use super::equations::{Equations, Linear, State, Step};
use super::stability::ORTHOGONAL;
use crate::analysis::normalised::DISPLACEMENT_ROUNDING;
use crate::error::Interrupted;
use crate::numerics::linalg::{Lu, Matrix, full_svd, norm};

/// Iterations with slower contraction do not converge to the nearest solution (Deuflhard 2011, section 2.1).
const SLOWEST_RATE: f64 = 0.5;

/// At the slowest rate a correction takes about 30 iterations to rounding; typical corrections take far
/// fewer.
const MAX_ITERATIONS: usize = 30;

/// Directions with a stiffness below this fraction of the elastic stiffness can be fixed: well above the
/// spurious stiffness from the tangent's discretisation, about 1e-5 for a rod rotated by some radians between
/// stiff supports.
const SOFT_STIFFNESS: f64 = 1e-3;

/// Below this fraction of the elastic stiffness, the path's component in soft directions is rounding.
const ROUNDING_OF_PATHS: f64 = 1e-8;

/// A stiffness below this number of rounding units of the largest one counts as zero.
const ZERO_STIFFNESS: f64 = 100.0;

/// A converged correction.
#[derive(Clone, Copy, Debug)]
pub(super) struct Corrected {
    /// Initial contraction rate; zero if the first step was already at rounding.
    pub(super) rate: f64,
    /// Scaled norm of the last step.
    pub(super) step_norm: f64,
    /// Scaled norm of the residual before that step.
    pub(super) residual_norm: f64,
}

/// Treatment of directions without stiffness in which the forces are in equilibrium to rounding.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Soft {
    Followed,
    Fixed,
}

/// Moves a state to equilibrium within the hyperplane orthogonal to `constraint` (scaled, shape (n + 1,)).
/// `None` if the iteration does not contract; the state is then invalid.
pub(super) fn correct(
    equations: &mut Equations<'_>,
    state: &mut State,
    constraint: &[f64],
    tolerance: f64,
) -> Result<Option<Corrected>, Interrupted> {
    let start = state.clone();
    let corrected = iterate(equations, state, constraint, tolerance, Soft::Followed)?;
    if corrected.is_some() {
        return Ok(corrected);
    }
    let Some(linear) = equations.linearise(&start)? else { return Ok(None) };
    if with_fixed_directions(&linear, constraint, SOFT_STIFFNESS, DISPLACEMENT_ROUNDING).is_none() {
        return Ok(None);
    }
    *state = start;
    iterate(equations, state, constraint, tolerance, Soft::Fixed)
}

/// The same near a critical point: holds the state in directions without stiffness in which it is in
/// equilibrium.
pub(super) fn correct_held(
    equations: &mut Equations<'_>,
    state: &mut State,
    constraint: &[f64],
    tolerance: f64,
) -> Result<Option<Corrected>, Interrupted> {
    iterate(equations, state, constraint, tolerance, Soft::Fixed)
}

fn iterate(
    equations: &mut Equations<'_>,
    state: &mut State,
    constraint: &[f64],
    tolerance: f64,
    soft: Soft,
) -> Result<Option<Corrected>, Interrupted> {
    let (mut first_rate, mut stalls) = (0.0, 0);
    let mut previous = f64::INFINITY;
    for iteration in 0..MAX_ITERATIONS {
        let Some(linear) = equations.linearise(state)? else { return Ok(None) };
        equations.counters.iterations += 1;
        let fix = || with_fixed_directions(&linear, constraint, SOFT_STIFFNESS, DISPLACEMENT_ROUNDING);
        let solved = |mut bordered: Bordered| {
            let right: Vec<f64> = linear.residual.iter().map(|residual| -residual).chain([0.0]).collect();
            let step = bordered.solve(&linear, right);
            let size = norm(&step.scaled);
            (step, size)
        };
        let fixed_first = if soft == Soft::Fixed { fix() } else { None };
        let Some(bordered) = fixed_first.or_else(|| Bordered::new(&linear, &linear.tangent, constraint))
        else {
            return Ok(None);
        };
        let (mut step, mut size) = solved(bordered);
        // Buckled round rods may rotate about their axis: the remaining step is an arbitrary rotation.
        if soft == Soft::Followed
            && iteration > 0
            && size > tolerance.max(SLOWEST_RATE * previous)
            && let Some(bordered) = fix()
        {
            (step, size) = solved(bordered);
        }
        if !size.is_finite() {
            return Ok(None);
        }
        linear.advance(state, &step, &equations.sizes);
        let rate = size / previous;
        if iteration == 1 {
            first_rate = rate;
        }
        // Newton's method has reached the level of rounding when small steps no longer decrease, twice: across
        // a corner of the forces, as at a stop, one step need not be smaller than the one before.
        let is_rounding = rate > SLOWEST_RATE && size.max(previous) <= tolerance.sqrt();
        stalls += usize::from(is_rounding);
        if size <= tolerance || stalls > 1 {
            let residual_norm = linear.residual_norm;
            return Ok(Some(Corrected { rate: first_rate, step_norm: size, residual_norm }));
        }
        if rate > SLOWEST_RATE && iteration > 0 && !is_rounding {
            return Ok(None);
        }
        previous = size;
    }
    Ok(None)
}

/// Direction of the path at a state, with scaled norm one, such that its product with `forward` is positive.
/// Where paths cross, the direction of the path that does not leave along a direction without stiffness.
/// `None` if it is not finite.
pub(super) fn direction(linear: &Linear, forward: &[f64]) -> Option<Step> {
    let n = linear.load.len();
    let fixed = with_fixed_directions(linear, forward, ROUNDING_OF_PATHS, f64::INFINITY);
    let mut bordered = fixed.or_else(|| Bordered::new(linear, &linear.tangent, forward))?;
    let mut right = vec![0.0; n + 1];
    right[n] = 1.0;
    let mut step = bordered.solve(linear, right);
    let size = norm(&step.scaled);
    if !size.is_finite() {
        return None;
    }
    step.scaled.iter_mut().chain(&mut step.forces).for_each(|x| *x /= size);
    Some(step)
}

/// Scaled norm of Newton's step at a fixed load factor. Directions without stiffness and without force, such
/// as those of a free body on a floor, are excluded. `None` if there is a force in such a direction.
pub(super) fn newton_step(linear: &Linear) -> Option<f64> {
    let (left, stiffness, right) = full_svd(&linear.tangent)?;
    let n = linear.residual.len();
    let none = n as f64 * f64::EPSILON * stiffness.first().copied().unwrap_or(0.0);
    let mut x = vec![0.0; n];
    for (k, stiffness) in stiffness.into_iter().enumerate() {
        let force: f64 = left.column(k).iter().zip(&linear.residual).map(|(u, f)| u * f).sum();
        if stiffness > ZERO_STIFFNESS * none {
            x.iter_mut().zip(right.column(k).iter()).for_each(|(x, v)| *x += v * force / stiffness);
        } else if force.abs() > ZERO_STIFFNESS * none {
            return None;
        }
    }
    Some(norm(&linear.step(&x, 0.0).scaled))
}

/// The bordered equations `[K l; c^T]` in normalised coordinates, with the load l and the constraint c
/// normalised.
struct Bordered {
    lu: Lu,
    /// Factor between the normalised load's factor and the load factor.
    load_factor: f64,
}

impl Bordered {
    /// Equations with a tangent K. `None` if they are singular.
    fn new(linear: &Linear, tangent: &Matrix, constraint: &[f64]) -> Option<Self> {
        let n = linear.load.len();
        let size = norm(&linear.load);
        let load_factor = if size.is_normal() { 1.0 / size } else { 1.0 };
        let mut last = linear.normalised.forces(&constraint[..n]);
        last.push(constraint[n] * load_factor);
        let length = norm(&last);
        let mut bordered = Matrix::zeros(n + 1, n + 1);
        bordered.view_mut((0, 0), (n, n)).copy_from(tangent);
        for i in 0..n {
            bordered[(i, n)] = linear.load[i] * load_factor;
        }
        for (i, last) in last.into_iter().enumerate() {
            bordered[(n, i)] = last / length;
        }
        let mut lu = Lu::new(n + 1);
        lu.factorise(&bordered).is_ok().then_some(Self { lu, load_factor })
    }

    fn solve(&mut self, linear: &Linear, mut right: Vec<f64>) -> Step {
        self.lu.solve(&mut right);
        let n = right.len() - 1;
        linear.step(&right[..n], right[n] * self.load_factor)
    }
}

/// The bordered equations with the stiffness of the material in soft directions. Soft directions have less
/// than the fraction `largest` of the elastic stiffness and no load, and their residual would move the
/// material by no more than `rounding`. `None` if there are no such directions.
fn with_fixed_directions(
    linear: &Linear,
    constraint: &[f64],
    largest: f64,
    rounding: f64,
) -> Option<Bordered> {
    if let Some(mut bordered) = Bordered::new(linear, &linear.tangent, constraint)
        && bordered.lu.reciprocal_condition() > largest
    {
        return None;
    }
    let (left, stiffness, right) = full_svd(&linear.tangent)?;
    let along = |k: usize, f: &[f64]| -> f64 { left.column(k).iter().zip(f).map(|(u, f)| u * f).sum() };
    let size = norm(&linear.load);
    let mut tangent = linear.tangent.clone();
    let mut is_any = false;
    for k in (0..stiffness.len()).filter(|k| stiffness[*k] <= largest) {
        let left_out = along(k, &linear.residual);
        let moved: Vec<f64> = right.column(k).iter().map(|v| v * left_out).collect();
        let is_pushed = along(k, &linear.load).abs() > ORTHOGONAL * size;
        if !is_pushed && norm(&linear.normalised.coordinates(&moved)) <= rounding {
            tangent.ger(1.0, &left.column(k), &right.column(k), 1.0);
            is_any = true;
        }
    }
    if is_any { Bordered::new(linear, &tangent, constraint) } else { None }
}
