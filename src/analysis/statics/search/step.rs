//! A step within a radius: the smallest shift of the second derivative that makes the problem convex and the step short enough, and the
//! retraction onto loops and taut tendons.

use super::balance::IndependentRows;
use super::problem::{Problem, Shape, times};
use super::quadratic::{Linearised, Solution};
use super::scale::Scale;
use crate::error::Interrupted;
use crate::model::chart;
use crate::model::constraint::closing;
use crate::numerics::linalg::{Matrix, dot, norm};

/// Newton steps up to this size, in sizes of coordinates, are taken without regularisation.
const PLAIN_NEWTON_STEP: f64 = 0.1;

/// Steps between these multiples of the radius count as of its length (More and Sorensen 1983, section 4).
const AT_RADIUS: [f64; 2] = [0.75, 1.1];

/// Maximum number of shifts until a step has the length of the radius, after the first short enough step.
const MAX_SHIFTS: usize = 12;

/// First shift, relative to that at which the steepest step has size one.
pub(super) const FIRST_SHIFT: f64 = 1e-3;

/// Smallest first shift, relative to the largest stiffness, well above its rounding.
const SMALLEST_SHIFT: f64 = 1e-12;

/// Shifts whose ratio is smaller count as equal; successive ones differ by at least [`SMALLEST_SHIFT_CHANGE`] and by at most the inverse of
/// [`LARGEST_SHIFT_CUT`].
const SAME_SHIFT: f64 = 1.02;
const SMALLEST_SHIFT_CHANGE: f64 = 1e-3;
const LARGEST_SHIFT_CUT: f64 = 1e-3;

/// Factor of the shift while no shift is known to be sufficient.
const MORE_SHIFT: f64 = 10.0;

/// Damping below this part of the first shift has no effect and is left out.
const NO_DAMPING: f64 = 1e-3;

/// Shifts above this part of the stiffness have no effect.
const LARGEST_SHIFT: f64 = 1e60;

/// Maximum number of corrections that project a step onto constraints.
const MAX_CORRECTIONS: usize = 15;

/// Gaps and elongations, in sizes, up to which constraints are satisfied, and those that rounding may leave.
const SATISFIED_GAP: f64 = 1e-13;
const ROUNDING_GAP: f64 = 1e-9;

/// Largest excess of inextensible tendons, in sizes, at which a step needs no further closing: rounding.
const ROUNDING_EXCESS: f64 = 1e-12;

/// Length of normalised coordinates in a metric.
pub(super) fn length(x: &[f64], metric: &[f64]) -> f64 {
    x.iter().zip(metric).map(|(x, b)| x * x * b).sum::<f64>().sqrt()
}

fn with_diagonal(a: &Matrix, diagonal: &[f64], factor: f64) -> Matrix {
    let mut sum = a.clone();
    diagonal.iter().enumerate().for_each(|(k, x)| sum[(k, k)] += factor * x);
    sum
}

/// The step of least energy within the radius; `None` if no shift gives one.
pub(super) fn within(
    linearised: &Linearised<'_>,
    hessian: &Matrix,
    regularisation: &[f64],
    scale: &Scale,
    radius: f64,
    taut: &[bool],
) -> Option<Solution> {
    let metric = scale.metric(radius);
    let attempt = |hessian: &Matrix| linearised.attempt(hessian, taut);
    if let Some(plain) =
        attempt(hessian).filter(|plain| length(&plain.x, &metric) <= radius.min(PLAIN_NEWTON_STEP))
    {
        return Some(plain);
    }
    let more = radius.max(1.0).powi(-2);
    let regularisation: Vec<f64> = regularisation
        .iter()
        .zip(&scale.turns)
        .map(|(x, turns)| if *turns { *x } else { x * more })
        .collect();
    let regular = with_diagonal(hessian, &regularisation, 1.0);
    if let Some(short) = attempt(&regular).filter(|short| length(&short.x, &metric) <= AT_RADIUS[1] * radius)
    {
        return Some(short);
    }
    let steepest = linearised.steepest(&metric);
    let largest = (0..metric.len()).map(|k| regular[(k, k)].abs()).fold(0.0, f64::max);
    let first = (FIRST_SHIFT * steepest / radius).max(SMALLEST_SHIFT * largest).max(f64::MIN_POSITIVE);
    let (mut shift, mut low, mut high) = (first, 0.0_f64, f64::INFINITY);
    let mut best: Option<(Solution, f64)> = None;
    let mut tries = 0;
    while tries < MAX_SHIFTS || best.is_none() {
        let shifted = with_diagonal(&regular, &metric, shift);
        let mut next = f64::NAN;
        match attempt(&shifted) {
            None => low = low.max(shift),
            Some(found) => {
                let size = length(&found.x, &metric);
                next = shift + change_of_shift(&found, &metric, size, radius);
                if size > AT_RADIUS[1] * radius {
                    low = low.max(shift);
                } else {
                    high = high.min(shift);
                    let is_enough = size >= AT_RADIUS[0] * radius;
                    // Without a force all steps are zero, and the smallest shift gives the direction of least curvature.
                    if best.as_ref().is_none_or(|(_, old)| size >= *old) {
                        best = Some((found, size));
                    }
                    if is_enough {
                        break;
                    }
                }
            }
        }
        let is_largest = shift > LARGEST_SHIFT * largest.max(f64::MIN_POSITIVE);
        if high < SAME_SHIFT * low || is_largest || !shift.is_finite() {
            break;
        }
        if best.is_some() {
            tries += 1;
        }
        let inside =
            next > (1.0 + SMALLEST_SHIFT_CHANGE) * low && next < (1.0 - SMALLEST_SHIFT_CHANGE) * high;
        shift = match (inside, high.is_finite()) {
            (true, _) => next,
            (false, true) => (low.max(LARGEST_SHIFT_CUT * high) * high).sqrt(),
            (false, false) => MORE_SHIFT * shift,
        };
    }
    let (mut solution, size) = best?;
    if size < 0.5 * radius {
        along_least_curvature(linearised, &regular, &metric, radius, size, &mut solution);
    }
    Some(solution)
}

/// The change of the shift by Newton's method for `1 / size - 1 / radius`.
fn change_of_shift(found: &Solution, metric: &[f64], size: f64, radius: f64) -> f64 {
    let weighted: Vec<f64> = found.x.iter().zip(metric).map(|(x, b)| -x * b).collect();
    let (rows, elastic) = (vec![0.0; found.transform.nrows()], vec![0.0; found.elastic.len()]);
    let slope = -dot(&weighted, &found.saddle.solve(&weighted, &rows, &elastic));
    (size / radius - 1.0) * size * size / slope
}

/// Limits of steps, in sizes of coordinates.
#[derive(Clone, Copy)]
pub(super) struct Bounds<'a> {
    pub(super) scale: &'a Scale,
    pub(super) radius: f64,
}

/// The step for a shift of the second derivative, from `damping` on, that makes it convex and the step short enough (Levenberg 1944).
/// Limits soft directions and hardly the stiff ones, for shapes whose stiff contacts change. `None` if no shift is sufficient.
pub(super) fn damped(
    linearised: &Linearised<'_>,
    hessian: &Matrix,
    regularisation: &[f64],
    Bounds { scale, radius }: Bounds<'_>,
    taut: &[bool],
    damping: &mut f64,
) -> Option<Solution> {
    /// Factor between shifts.
    const FACTOR: f64 = 4.0;
    let metric = scale.metric(radius);
    let steepest = linearised.steepest(&metric);
    let regular = with_diagonal(hessian, regularisation, 1.0);
    let largest = (0..metric.len()).map(|k| regular[(k, k)].abs()).fold(0.0, f64::max);
    let first = (FIRST_SHIFT * steepest / radius).max(SMALLEST_SHIFT * largest).max(f64::MIN_POSITIVE);
    if *damping < NO_DAMPING * first {
        *damping = 0.0;
        let plain = linearised.attempt(hessian, taut);
        if let Some(plain) = plain.filter(|plain| length(&plain.x, &metric) <= radius.min(PLAIN_NEWTON_STEP))
        {
            return Some(plain);
        }
    }
    while *damping <= LARGEST_SHIFT * largest.max(f64::MIN_POSITIVE) {
        let shifted = with_diagonal(&regular, &metric, *damping);
        let found = linearised.attempt(&shifted, taut);
        if let Some(found) = found.filter(|found| length(&found.x, &metric) <= radius) {
            return Some(found);
        }
        *damping = (FACTOR * *damping).max(first);
    }
    None
}

/// The hard case: the shift equals minus the lowest curvature, and the step is extended along that direction (More and Sorensen 1983).
fn along_least_curvature(
    linearised: &Linearised<'_>,
    hessian: &Matrix,
    metric: &[f64],
    radius: f64,
    size: f64,
    solution: &mut Solution,
) {
    let Some(mut direction) = solution.saddle.least_curved() else { return };
    let unit = length(&direction, metric);
    let wanted = (radius * radius - size * size).max(0.0).sqrt() / unit;
    direction.iter_mut().for_each(|x| *x *= wanted);
    if dot(&direction, &times(hessian, &direction)) >= 0.0 {
        return;
    }
    let downhill = if dot(linearised.gradient, &direction) <= 0.0 { 1.0 } else { -1.0 };
    for sign in [downhill, -downhill] {
        let x: Vec<f64> = solution.x.iter().zip(&direction).map(|(x, d)| x + sign * d).collect();
        let moved = times(linearised.rows, &x);
        let exceeds =
            |row: usize| linearised.stiffness[row].is_infinite() && linearised.excess[row] + moved[row] > 0.0;
        if !(0..moved.len()).any(exceeds) {
            solution.x = x;
            return;
        }
    }
}

/// Moves a shape by a step and corrects, with the factors of the step, the deviations of loops, taut tendons and stiff springs from their
/// linearisation (second-order correction: Fletcher 1982). `None` if that does not succeed nearby.
pub(super) fn retracted(
    problem: &mut Problem<'_>,
    from: &Shape,
    scale: &Scale,
    linearised: &Linearised<'_>,
    solution: &Solution,
    of_loops: &IndependentRows,
    size: f64,
) -> Result<Option<Shape>, Interrupted> {
    let Solution { x, saddle, rigid, elastic, transform, .. } = solution;
    let n = x.len();
    let moved = |problem: &mut Problem<'_>, q: &[f64], x: &[f64]| {
        let mut q = q.to_vec();
        chart::retract(&problem.turns, &mut q, &scale.coordinates(x));
        problem.shape(q)
    };
    let mut shape = moved(problem, &from.q, x)?;
    if rigid.is_empty() && elastic.is_empty() && of_loops.rows.nrows() == 0 && !problem.has_rigid() {
        return Ok(Some(shape));
    }
    let lengths: Vec<f64> = linearised.rows.row_iter().map(|row| row.norm().max(f64::MIN_POSITIVE)).collect();
    let change = times(linearised.rows, x);
    let aims: Vec<f64> = elastic.iter().map(|&row| linearised.excess[row] + change[row]).collect();
    let none = vec![0.0; n];
    let (mut before, mut stray_before) = (f64::INFINITY, f64::INFINITY);
    let largest =
        |values: &[f64]| values.iter().fold(0.0, |most: f64, x| if x.abs() <= most { most } else { x.abs() });
    let mut miss = f64::INFINITY;
    for _ in 0..MAX_CORRECTIONS {
        let excess = problem.excess_beside(&shape, from);
        let all: Vec<f64> = times(&of_loops.transform, &shape.gaps)
            .into_iter()
            .chain(rigid.iter().map(|&row| excess[row]))
            .collect();
        let gaps = times(transform, &all);
        let off: Vec<f64> = elastic.iter().zip(&aims).map(|(&row, aim)| excess[row] - aim).collect();
        miss = largest(&gaps);
        let strays: Vec<f64> = elastic.iter().zip(&off).map(|(&row, off)| off / lengths[row]).collect();
        let stray = largest(&strays);
        if miss.is_nan() || miss > 2.0 * before + size {
            return Ok(None);
        }
        let is_done = miss.max(stray) < SATISFIED_GAP * size.max(1.0);
        let is_rounding =
            miss < ROUNDING_GAP && miss > 0.5 * before - SATISFIED_GAP && stray > 0.5 * stray_before;
        if is_done || is_rounding {
            break;
        }
        let elongations: Vec<f64> =
            elastic.iter().zip(&off).map(|(&row, off)| linearised.stiffness[row].sqrt() * off).collect();
        let back = saddle.solve(&none, &gaps, &elongations);
        shape = moved(problem, &shape.q, &back)?;
        (before, stray_before) = (miss, stray);
    }
    let exceeded = (0..lengths.len())
        .filter(|&row| problem.is_rigid(row))
        .map(|row| shape.excess[row] / lengths[row])
        .fold(0.0, f64::max);
    let is_closed = miss < ROUNDING_GAP && shape.widest < from.widest + ROUNDING_GAP * size.max(1.0);
    if is_closed && exceeded <= ROUNDING_EXCESS * size.max(1.0) {
        return Ok(Some(shape));
    }
    // Otherwise closes the shape from there, if that ends nearby.
    let mut q = shape.q.clone();
    let gap = closing::close(&mut *problem.model, &mut q);
    let apart = chart::step_between(&problem.turns, &shape.q, &q);
    let apart: Vec<f64> = apart.iter().zip(&scale.sizes).map(|(x, size)| x / size).collect();
    let is_near = norm(&apart) < 2.0 * size + ROUNDING_GAP && gap < ROUNDING_GAP;
    if is_near { Ok(Some(problem.shape(q)?)) } else { Ok(None) }
}
