//! Newton's method on the bordered equations, watched by its contraction: it either stays close to where it starts or
//! gives up. A search for any root, from anywhere, is the business of [`crate::roots`].
//!
//! At a bifurcation the bordered equations are singular, once or more often. There, Newton's step is rounding divided
//! by almost nothing; and it does not contract close by, as the tangent is that of the continuous rod, from which the
//! discretised forces differ a little. So directions without stiffness, in which the forces are in equilibrium, can
//! be held.

use super::equations::{Equations, Linear, State, Step};
use super::stability::ORTHOGONAL;
use crate::error::Interrupted;
use crate::linalg::{Lu, Matrix, full_svd, norm};
use crate::natural::DISPLACEMENT_ROUNDING;

/// Iterations that contract more slowly are not on their way to the nearest solution (Deuflhard 2011, section 2.1).
const SLOWEST_RATE: f64 = 0.5;

/// At that rate a correction takes about 30 iterations to rounding; one that contracts at all takes far less.
const MAX_ITERATIONS: usize = 30;

/// Directions with less than that part of the elastic stiffness can be held: well above what the tangent's
/// discretisation makes of none, about 1e-5 for a rod that is turned some radians between stiff supports.
const SOFT: f64 = 1e-3;

/// With less than that part of it, the direction of a path in them is rounding.
const LOOSE: f64 = 1e-8;

/// So many rounding units of the largest stiffness count as none.
const WITHOUT: f64 = 100.0;

/// A correction that converged.
#[derive(Clone, Copy, Debug)]
pub(super) struct Corrected {
    /// How fast it contracted at first; zero when there was nothing to see.
    pub(super) rate: f64,
    /// Scaled norm of the last step.
    pub(super) step_norm: f64,
    /// Scaled norm of the residual before that step.
    pub(super) residual_norm: f64,
}

/// What Newton's method does in directions without stiffness in which the forces are in equilibrium to rounding.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Soft {
    Followed,
    Held,
}

/// Moves a state to equilibrium, orthogonally to `constraint` (scaled, shape (n + 1,)). `None` when it does not
/// contract; the state is then of no use.
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
    if held(&linear, constraint, SOFT, DISPLACEMENT_ROUNDING).is_none() {
        return Ok(None);
    }
    *state = start;
    iterate(equations, state, constraint, tolerance, Soft::Held)
}

/// The same near a critical point: a state stays where it is in directions without stiffness in which it is in
/// equilibrium.
pub(super) fn correct_held(
    equations: &mut Equations<'_>,
    state: &mut State,
    constraint: &[f64],
    tolerance: f64,
) -> Result<Option<Corrected>, Interrupted> {
    iterate(equations, state, constraint, tolerance, Soft::Held)
}

fn iterate(
    equations: &mut Equations<'_>,
    state: &mut State,
    constraint: &[f64],
    tolerance: f64,
    soft: Soft,
) -> Result<Option<Corrected>, Interrupted> {
    let mut first_rate = 0.0;
    let mut previous = f64::INFINITY;
    for iteration in 0..MAX_ITERATIONS {
        let Some(linear) = equations.linearise(state)? else { return Ok(None) };
        equations.counters.iterations += 1;
        let hold = || held(&linear, constraint, SOFT, DISPLACEMENT_ROUNDING);
        let solved = |mut bordered: Bordered| {
            let right: Vec<f64> = linear.residual.iter().map(|residual| -residual).chain([0.0]).collect();
            let step = bordered.solve(&linear, right);
            let size = norm(&step.scaled);
            (step, size)
        };
        let held_first = if soft == Soft::Held { hold() } else { None };
        let Some(bordered) = held_first.or_else(|| Bordered::new(&linear, &linear.tangent, constraint))
        else {
            return Ok(None);
        };
        let (mut step, mut size) = solved(bordered);
        // Buckled round rods may turn about their axis: what is left is a step around it that means nothing.
        if soft == Soft::Followed
            && iteration > 0
            && size > tolerance.max(SLOWEST_RATE * previous)
            && let Some(bordered) = hold()
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
        // Newton's method left what is small small: steps that no longer fall are rounding.
        let is_rounding = rate > SLOWEST_RATE && size.max(previous) <= tolerance.sqrt();
        if size <= tolerance || is_rounding {
            let residual_norm = linear.residual_norm;
            return Ok(Some(Corrected { rate: first_rate, step_norm: size, residual_norm }));
        }
        if rate > SLOWEST_RATE && iteration > 0 {
            return Ok(None);
        }
        previous = size;
    }
    Ok(None)
}

/// The direction of the path, of scaled norm one, at a state, such that its product with `forward` is positive. Where
/// paths cross it is that of the one which does not leave along a direction without stiffness. `None` where it is not
/// finite.
pub(super) fn direction(linear: &Linear, forward: &[f64]) -> Option<Step> {
    let n = linear.load.len();
    let held = held(linear, forward, LOOSE, f64::INFINITY);
    let mut bordered = held.or_else(|| Bordered::new(linear, &linear.tangent, forward))?;
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

/// Scaled norm of Newton's step at a fixed load factor. Directions without any stiffness, in which what lies on a floor may be
/// anywhere, take no part in it where there is no force either. `None` where there is.
pub(super) fn newton_step(linear: &Linear) -> Option<f64> {
    let (left, stiffness, right) = full_svd(&linear.tangent)?;
    let n = linear.residual.len();
    let none = n as f64 * f64::EPSILON * stiffness.first().copied().unwrap_or(0.0);
    let mut x = vec![0.0; n];
    for (k, stiffness) in stiffness.into_iter().enumerate() {
        let force: f64 = left.column(k).iter().zip(&linear.residual).map(|(u, f)| u * f).sum();
        if stiffness > WITHOUT * none {
            x.iter_mut().zip(right.column(k).iter()).for_each(|(x, v)| *x += v * force / stiffness);
        } else if force.abs() > WITHOUT * none {
            return None;
        }
    }
    Some(norm(&linear.step(&x, 0.0).scaled))
}

/// The bordered equations `[K l; c^T]` in natural coordinates, with a load l and a constraint c of norm one.
struct Bordered {
    lu: Lu,
    /// What the load factor of such a load has to be multiplied with.
    load_factor: f64,
}

impl Bordered {
    /// With a tangent K. `None` where they are singular.
    fn new(linear: &Linear, tangent: &Matrix, constraint: &[f64]) -> Option<Self> {
        let n = linear.load.len();
        let size = norm(&linear.load);
        let load_factor = if size.is_normal() { 1.0 / size } else { 1.0 };
        let mut last = linear.natural.forces(&constraint[..n]);
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

/// The bordered equations with the stiffness of the material in directions that have less than the part `largest` of
/// it, in which the load does not push, and the residual would not move the material by more than `rounding`. `None`
/// where there are no such directions.
fn held(linear: &Linear, constraint: &[f64], largest: f64, rounding: f64) -> Option<Bordered> {
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
        if !is_pushed && norm(&linear.natural.coordinates(&moved)) <= rounding {
            tangent.ger(1.0, &left.column(k), &right.column(k), 1.0);
            is_any = true;
        }
    }
    if is_any { Bordered::new(linear, &tangent, constraint) } else { None }
}
