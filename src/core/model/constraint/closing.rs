//! Closing: moves a shape until constraints hold, with as little elastic energy as possible.
//!
//! Steps are those of Gauss and Newton's method, the smallest ones in normalised coordinates x, `dq_i = w_i x_i` with `w_i = s_i / sqrt(1
//! + k_i / e)`: s_i are the sizes of the coordinates ([`sizes`](crate::model::Elastic::sizes)), `k_i = s_i^2 K_ii` twice the elastic
//! energy of one size, and e is the softest of these among the coordinates that are joined. Bending closes a loop then, not
//! stretching. Masses, times and lengths of other parts have no influence, and units cancel: gaps are compared with the lengths of
//! the joined parts ([`gap_sizes`](crate::model::Facts::gap_sizes)).
//!
//! Each gap counts relative to how fast it can close. Where no motion closes all of them to first order, as on the way to bars that fold
//! back onto each other, these weights would lead in circles, and gaps count relative to their sizes.
//!
//! At some shapes no motion closes a gap to first order, such as at straight lines or where both ends coincide, or only stretching
//! does, by a force beyond the buckling load. The force that would close the gap buckles the shape there: its closed shapes are sought on both sides of the shape, in the
//! direction of the lowest buckling mode of that force, the lowest eigenvector of the second derivative of its work, `sum_i lambda_i
//! grad^2 g_i`.

use crate::model::{Static, chart};
use crate::numerics::linalg::{Matrix, dot, norm, symmetric_eigen, symmetric_part, thin_svd};

/// Gaps below this part of their sizes are rounding.
const ROUNDING: f64 = 1e-13;

/// Up to this part of their sizes, gaps count as closed.
const LARGEST_CLOSED_GAP: f64 = 1e-9;

/// The longest step, in sizes of coordinates.
const LONGEST_STEP: f64 = 0.5;

/// The search makes progress while the largest gap falls by this part within [`PATIENCE`] steps.
const PROGRESS: f64 = 1e-3;
const PATIENCE: usize = 8;

/// Rows, and directions of rows, that are shorter than the largest one by this factor count as zero.
const RANK_TOLERANCE: f64 = 1e-9;

/// Gaps are not closed to first order if more than this part of them is left.
const LEFT_TO_FIRST_ORDER: f64 = 1e-3;

/// A closing force counts as deforming if at least this part of the smallest motion is along elastic coordinates.
const DEFORMING_PART: f64 = 0.5;

/// Stiffness below this part of the largest one counts as zero.
const SOFTEST: f64 = 1e-14;

/// Buckling modes whose eigenvalues differ by less than this part of the largest one are one: then a fixed direction selects.
const SAME_MODE: f64 = 1e-6;

/// Another closed shape is preferred if its energy is lower by this part: mirror images, whose starts agree to 1e-8, count as equal.
const LOWER_ENERGY: f64 = 1e-6;

/// Where nothing else closes, shapes beside the start are tried that differ by this part of normalised sizes.
const OTHER_START: f64 = 0.3;
const OTHER_STARTS: usize = 5;

/// A shape at which a search has ended.
#[derive(Clone, Debug)]
struct Ended {
    q: Vec<f64>,
    /// The largest gap, in gap sizes.
    gap: f64,
}

/// Moves a shape until constraints hold, one-sided ones if they are violated. Of the closed shapes found, takes the one of least
/// energy. Returns the largest remaining gap, in [`gap_sizes`](crate::model::Facts::gap_sizes): not small where constraints conflict
/// or the search stalls. Allocates.
pub fn close<M: Static + ?Sized>(model: &mut M, q: &mut [f64]) -> f64 {
    let gap = find(model, q);
    model.release_open(q, None);
    gap
}

fn find<M: Static + ?Sized>(model: &mut M, q: &mut [f64]) -> f64 {
    let mut gaps = Vec::new();
    let left = violated(model, q, &mut gaps);
    if left <= ROUNDING || !left.is_finite() || q.is_empty() {
        return left;
    }
    let mut start = q.to_vec();
    chart::fold(&model.facts().rotation_vectors, &mut start);
    let mut ended = vec![approach(model, start.clone(), Moves::All)];
    let is_closed = |ended: &[Ended]| ended.iter().any(|ended| ended.gap <= LARGEST_CLOSED_GAP);
    if left > LARGEST_CLOSED_GAP {
        let load = if is_closed(&ended) { Load::BeforeClosed } else { Load::Any };
        ended.extend(on_both_sides(model, &start, load));
        if let Some(turned) = turned(model, &start) {
            ended.extend(on_both_sides(model, &turned, Load::Any));
        }
    }
    if !is_closed(&ended) {
        let stuck = ended[0].q.clone();
        ended.extend(on_both_sides(model, &stuck, Load::Any));
    }
    for attempt in 0..OTHER_STARTS {
        if is_closed(&ended) {
            break;
        }
        let normalised = Normalised::new(model, &start);
        let step = normalised
            .weights
            .iter()
            .enumerate()
            .map(|(k, w)| OTHER_START * w * (1.7 * k as f64 + attempt as f64).cos());
        let mut beside = start.clone();
        chart::retract(&model.facts().rotation_vectors, &mut beside, &step.collect::<Vec<_>>());
        ended.push(approach(model, beside, Moves::All));
    }
    let best = of_least_energy(model, &ended);
    q.copy_from_slice(&best.q);
    best.gap
}

/// Which buckling loads count.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Load {
    Any,
    /// Loads that are reached before an elastic shape is closed, if a motion closes it to first order.
    BeforeClosed,
}

/// Closed shapes found from both sides of a shape, if the closing force buckles it.
fn on_both_sides<M: Static + ?Sized>(model: &mut M, q: &[f64], load: Load) -> Vec<Ended> {
    let Some(step) = buckling(model, q, load) else { return Vec::new() };
    let side = |sign: f64| {
        let mut beside = q.to_vec();
        chart::retract(
            &model.facts().rotation_vectors,
            &mut beside,
            &step.iter().map(|x| sign * x).collect::<Vec<_>>(),
        );
        approach(model, beside, Moves::All)
    };
    [1.0, -1.0].map(side).into()
}

/// The shape as near to closed ones as rigid motions of elastic parts bring it: a slack line points to its other end. `None` without
/// such motions, or if they close it.
fn turned<M: Static + ?Sized>(model: &mut M, q: &[f64]) -> Option<Vec<f64>> {
    let elastic = Normalised::new(model, q).elastic;
    let is_mixed = elastic.iter().any(|part| *part > 0.0) && elastic.contains(&0.0);
    let ended = is_mixed.then(|| approach(model, q.to_vec(), Moves::Rigid))?;
    (ended.gap > LARGEST_CLOSED_GAP).then_some(ended.q)
}

/// The closed shape of least energy, valid ones first; if no shape is closed, the first of all.
fn of_least_energy<'a, M: Static + ?Sized>(model: &mut M, ended: &'a [Ended]) -> &'a Ended {
    let rest = vec![0.0; model.facts().n];
    let mut best: Option<(&Ended, bool, f64)> = None;
    for other in ended.iter().filter(|ended| ended.gap <= LARGEST_CLOSED_GAP) {
        let energy = model.energy(&other.q, &rest);
        let is_valid = model.invalid_shape(&other.q).is_none();
        let size = energy.elastic.abs() + energy.gravitational.abs() + energy.loads.abs();
        let is_better = match best {
            None => true,
            Some((_, was_valid, _)) if was_valid != is_valid => is_valid,
            Some((_, _, least)) => energy.total() < least - LOWER_ENERGY * size,
        };
        if is_better {
            best = Some((other, is_valid, energy.total()));
        }
    }
    best.map_or(&ended[0], |(ended, ..)| ended)
}

/// Which coordinates may move.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Moves {
    All,
    /// Coordinates without stiffness.
    Rigid,
}

/// Gauss and Newton's method from one shape, as long as the gap falls; returns the best shape found.
fn approach<M: Static + ?Sized>(model: &mut M, mut q: Vec<f64>, moves: Moves) -> Ended {
    let mut gaps = Vec::new();
    let mut best = Ended { q: q.clone(), gap: f64::INFINITY };
    let (mut without_progress, mut last, mut is_whole) = (0, f64::INFINITY, false);
    // Shapes that are not resolved, or turned inside out, may seem closed.
    while best.gap == f64::INFINITY || model.invalid_shape(&q).is_none() {
        let gap = violated(model, &q, &mut gaps);
        without_progress = if gap < best.gap * (1.0 - PROGRESS) { 0 } else { without_progress + 1 };
        if gap < best.gap {
            (best.gap, best.q) = (gap, q.clone());
        }
        // Near rounding the gap no longer falls.
        let has_ended = gap <= ROUNDING || (is_whole && gap < LARGEST_CLOSED_GAP && gap > 0.5 * last);
        if has_ended || !gap.is_finite() || without_progress > PATIENCE {
            return best;
        }
        let mut normalised = Normalised::new(model, &q);
        if moves == Moves::Rigid {
            normalised.hold_elastic();
        }
        let Some(step) = normalised.closing(model, &q, &mut gaps) else { return best };
        let sizes: Vec<f64> = step.iter().zip(&normalised.sizes).map(|(step, size)| step / size).collect();
        let size = norm(&sizes);
        if size.is_nan() || size <= f64::EPSILON {
            return best;
        }
        let part = (LONGEST_STEP / size).min(1.0);
        let step: Vec<f64> = step.iter().map(|x| part * x).collect();
        chart::retract(&model.facts().rotation_vectors, &mut q, &step);
        (last, is_whole) = (gap, part == 1.0);
    }
    best
}

/// Gaps over their sizes, after activating the violated one-sided constraints. Returns the largest one.
fn violated<M: Static + ?Sized>(model: &mut M, q: &[f64], gaps: &mut Vec<f64>) -> f64 {
    let m = model.facts().constraints();
    let rest = vec![0.0; q.len()];
    let passed = model.passed(q, &rest);
    if !passed.is_empty() {
        let of_tendons = passed.iter().map(|[by, _]| f64::from(u8::from(*by > 0.0)));
        let active: Vec<f64> = std::iter::repeat_n(1.0, m - passed.len()).chain(of_tendons).collect();
        model.release(&active);
    }
    gaps.resize(m, 0.0);
    model.gaps(q, gaps);
    // Gaps of angles grow on the way back from half a turn.
    let turned = model.away_from_half_turns(gaps);
    gaps.iter_mut().zip(model.facts().gap_sizes.clone()).for_each(|(gap, size)| *gap /= size);
    gaps.iter().fold(turned, |largest: f64, gap| if gap.abs() <= largest { largest } else { gap.abs() })
}

/// Normalised coordinates at a shape.
struct Normalised {
    sizes: Vec<f64>,
    /// `dq = w x`.
    weights: Vec<f64>,
    /// The part of `x_i^2` that is elastic energy, `k_i / (e + k_i)`.
    elastic: Vec<f64>,
}

/// Weights of gaps in sums of squares.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Relative {
    /// One over how fast each gap can close.
    ToRates,
    /// One over their sizes.
    ToSizes,
}

/// Derivatives of gaps with respect to normalised coordinates, as columns of unit length if gaps are relative to rates, by singular
/// values that do not count as zero.
struct Rows {
    /// Factors of gaps over their sizes that make columns of unit length; one for gaps that nothing moves.
    factors: Vec<f64>,
    left: Matrix,
    values: Vec<f64>,
    right: Matrix,
}

impl Rows {
    /// Gaps with the weights of these rows.
    fn scaled(&self, gaps: &[f64]) -> Vec<f64> {
        gaps.iter().zip(&self.factors).map(|(gap, factor)| gap * factor).collect()
    }

    /// The smallest motion that closes these scaled gaps as far as possible, and the remaining gaps.
    fn closing(&self, scaled: &[f64]) -> (Vec<f64>, Vec<f64>) {
        let (mut x, mut left) = (vec![0.0; self.left.nrows()], scaled.to_vec());
        for (k, value) in self.values.iter().enumerate() {
            let part = dot(self.right.column(k).as_slice(), scaled);
            x.iter_mut().zip(&self.left.column(k)).for_each(|(x, of_mode)| *x -= part / value * of_mode);
            left.iter_mut().zip(&self.right.column(k)).for_each(|(left, of_mode)| *left -= part * of_mode);
        }
        (x, left)
    }
}

impl Normalised {
    fn new<M: Static + ?Sized>(model: &mut M, q: &[f64]) -> Self {
        let n = q.len();
        let mut sizes = vec![0.0; n];
        model.sizes(q, &mut sizes);
        let mut stiffness = Matrix::zeros(n, n);
        model.elastic_tangent(q, &mut stiffness);
        chart::hessian(&model.facts().rotation_vectors, q, &vec![0.0; n], &mut stiffness);
        let stiffness: Vec<f64> =
            (0..n).map(|k| (stiffness[(k, k)] * sizes[k] * sizes[k]).max(0.0)).collect();
        let joined = joined(model, q);
        let (mut weights, mut elastic) = (sizes.clone(), vec![0.0; n]);
        for part in 0..n {
            let own = || (0..n).filter(|&k| joined[k] == part);
            let largest = own().map(|k| stiffness[k]).fold(0.0, f64::max);
            let firm = own().map(|k| stiffness[k]).filter(|&k| k > SOFTEST * largest);
            let softest = firm.fold(f64::INFINITY, f64::min);
            for k in own() {
                let stiffness = stiffness[k] / softest;
                weights[k] /= (1.0 + stiffness).sqrt();
                elastic[k] = stiffness / (1.0 + stiffness);
            }
        }
        Self { sizes, weights, elastic }
    }

    /// Lets only those coordinates move that have no stiffness.
    fn hold_elastic(&mut self) {
        self.weights
            .iter_mut()
            .zip(&self.elastic)
            .filter(|(_, part)| **part > 0.0)
            .for_each(|(weight, _)| *weight = 0.0);
    }

    /// Work of weight and loads per unit of normalised coordinates.
    fn loads<M: Static + ?Sized>(&self, model: &mut M, q: &[f64]) -> Vec<f64> {
        let rest = vec![0.0; q.len()];
        let [mut all, mut elastic] = [rest.clone(), rest.clone()];
        model.inverse_dynamics(q, &rest, &rest, &mut all);
        model.elastic_forces(q, &mut elastic);
        (0..q.len()).map(|k| (elastic[k] - all[k]) * self.weights[k]).collect()
    }

    /// Derivatives of gaps over their sizes, m x n, with respect to normalised coordinates and to sizes.
    fn jacobian<M: Static + ?Sized>(&self, model: &mut M, q: &[f64]) -> [Matrix; 2] {
        let mut rows = Matrix::zeros(model.facts().constraints(), q.len());
        model.gap_jacobian(q, &mut rows);
        chart::rows(&model.facts().rotation_vectors, q, &mut rows);
        for (mut row, size) in rows.row_iter_mut().zip(model.facts().gap_sizes.clone()) {
            row /= size;
        }
        [&self.weights, &self.sizes].map(|sizes| {
            let mut scaled = rows.clone();
            scaled.column_iter_mut().zip(sizes).for_each(|(mut column, size)| column *= *size);
            scaled
        })
    }

    fn rows<M: Static + ?Sized>(&self, model: &mut M, q: &[f64], relative: Relative) -> Option<Rows> {
        let [normalised, in_sizes] = self.jacobian(model, q);
        let mut columns = normalised.transpose();
        let factors: Vec<f64> = columns
            .column_iter_mut()
            .zip(in_sizes.row_iter())
            .map(|(mut column, row)| {
                let length = column.norm();
                if row.norm() > RANK_TOLERANCE && length > 0.0 {
                    let factor = if relative == Relative::ToRates { 1.0 / length } else { 1.0 };
                    column *= factor;
                    return factor;
                }
                column.fill(0.0);
                1.0
            })
            .collect();
        let (left, values, right) = thin_svd(&columns)?;
        let largest = values.first().copied().unwrap_or(0.0);
        let rank = values.iter().take_while(|&&value| value > RANK_TOLERANCE * largest).count();
        Some(Rows { factors, left, values: values[..rank].to_vec(), right })
    }

    /// The step that closes gaps to first order. Tendons that it would make too long are activated.
    fn closing<M: Static + ?Sized>(&self, model: &mut M, q: &[f64], gaps: &mut [f64]) -> Option<Vec<f64>> {
        loop {
            let rows = self.rows(model, q, Relative::ToRates)?;
            let scaled = rows.scaled(gaps);
            let (mut x, left) = rows.closing(&scaled);
            if norm(&left) > LEFT_TO_FIRST_ORDER * norm(&scaled) {
                let rows = self.rows(model, q, Relative::ToSizes)?;
                (x, _) = rows.closing(&rows.scaled(gaps));
            }
            let step: Vec<f64> = x.iter().zip(&self.weights).map(|(x, w)| x * w).collect();
            if !self.holds_more(model, q, &step, gaps) {
                return Some(step);
            }
        }
    }

    /// Activates slack tendons that a step would make too long, to first order; whether there are any.
    fn holds_more<M: Static + ?Sized>(
        &self,
        model: &mut M,
        q: &[f64],
        step: &[f64],
        gaps: &mut [f64],
    ) -> bool {
        let active = model.active();
        let passed = model.passed(q, &vec![0.0; q.len()]);
        let first = active.len() - passed.len();
        if active[first..].iter().all(|&is_active| is_active) {
            return false;
        }
        let as_numbers = |active: &[bool]| {
            active.iter().map(|&is_active| f64::from(u8::from(is_active))).collect::<Vec<_>>()
        };
        model.release(&vec![1.0; active.len()]);
        let [_, rows] = self.jacobian(model, q);
        let mut more = active.clone();
        for (i, [by, _]) in passed.iter().enumerate().filter(|(i, _)| !active[first + i]) {
            let change: f64 = (0..q.len()).map(|k| rows[(first + i, k)] * step[k] / self.sizes[k]).sum();
            more[first + i] = by + change > ROUNDING;
        }
        model.release(&as_numbers(&more));
        for (i, [by, _]) in passed.iter().enumerate() {
            gaps[first + i] = if more[first + i] { *by } else { 0.0 };
        }
        more != active
    }
}

/// The lowest buckling mode of the force that would close the gaps of a shape, so large that it closes them by about half; `None`
/// if that force does not buckle it, or does not count.
fn buckling<M: Static + ?Sized>(model: &mut M, q: &[f64], load: Load) -> Option<Vec<f64>> {
    let (n, mut gaps) = (q.len(), Vec::new());
    violated(model, q, &mut gaps);
    let normalised = Normalised::new(model, q);
    let rows = normalised.rows(model, q, Relative::ToRates)?;
    // The part of the gaps that no motion reaches, or else the force of the smallest motion that closes them.
    let scaled = rows.scaled(&gaps);
    let (x, unreached) = rows.closing(&scaled);
    let mut force = vec![0.0; scaled.len()];
    for (k, value) in rows.values.iter().enumerate() {
        let part = dot(rows.right.column(k).as_slice(), &scaled) / (value * value);
        force.iter_mut().zip(&rows.right.column(k)).for_each(|(force, right)| *force += part * right);
    }
    let is_reached = norm(&unreached) <= RANK_TOLERANCE * norm(&scaled);
    if !is_reached {
        force = unreached;
    }
    let deformed: f64 = x.iter().zip(&normalised.elastic).map(|(x, part)| part * x * x).sum();
    let counts_all = load == Load::Any || !is_reached;
    if !counts_all && deformed < DEFORMING_PART * dot(&x, &x) {
        return None;
    }
    let work = dot(&force, &scaled);
    let multipliers: Vec<f64> = force
        .iter()
        .zip(&rows.factors)
        .zip(model.facts().gap_sizes.clone())
        .map(|((x, factor), size)| x * factor / size)
        .collect();
    let mut curvature = second_derivative(model, q, &multipliers);
    for (k, w) in normalised.weights.iter().enumerate() {
        curvature.row_mut(k).scale_mut(*w);
        curvature.column_mut(k).scale_mut(*w);
    }
    let (values, modes) = symmetric_eigen(&symmetric_part(&curvature))?;
    let largest = values.iter().fold(0.0, |largest: f64, value| largest.max(value.abs()));
    let lowest = *values.first()?;
    // In normalised coordinates, energies of one coordinate are one: a lower eigenvalue exceeds the elastic energy.
    let least = if counts_all { RANK_TOLERANCE * largest } else { 1.0 };
    if lowest >= -least || work <= 0.0 {
        return None;
    }
    // Among equal modes and both signs, choose the one on which loads do most work: a slack line sags downwards. Without loads, the one
    // along a fixed direction, so that rounding does not decide.
    let along = |direction: &[f64]| {
        let mut mode = vec![0.0; n];
        for k in (0..n).filter(|&k| values[k] - lowest <= SAME_MODE * largest) {
            let part = dot(modes.column(k).as_slice(), direction);
            mode.iter_mut().zip(modes.column(k).iter()).for_each(|(mode, x)| *mode += part * x);
        }
        mode
    };
    let loads = normalised.loads(model, q);
    let mut mode = along(&loads);
    if norm(&mode) <= RANK_TOLERANCE * norm(&loads) {
        mode = along(&(0..n).map(|i| (1.7 * i as f64).cos()).collect::<Vec<_>>());
    }
    let size = (work / -lowest).sqrt() / norm(&mode);
    let step: Vec<f64> = mode.iter().zip(&normalised.weights).map(|(x, w)| size * x * w).collect();
    let in_sizes: Vec<f64> = step.iter().zip(&normalised.sizes).map(|(step, size)| step / size).collect();
    let part = norm(&in_sizes).max(1.0).recip();
    Some(step.into_iter().map(|x| part * x).collect())
}

/// `sum_i lambda_i grad^2 g_i` along steps: the contribution of multipliers to the tangent.
fn second_derivative<M: Static + ?Sized>(model: &mut M, q: &[f64], multipliers: &[f64]) -> Matrix {
    let n = q.len();
    let (rest, mut without) = (vec![0.0; n], Matrix::zeros(n, n));
    let mut with = without.clone();
    let [mut forces, mut others] = [rest.clone(), rest.clone()];
    for (multipliers, tangent, forces) in
        [(multipliers, &mut with, &mut forces), (&vec![0.0; multipliers.len()], &mut without, &mut others)]
    {
        model.set_multipliers(multipliers);
        model.weighted_tangent(q, &rest, &rest, [1.0, 0.0, 0.0], tangent);
        model.inverse_dynamics(q, &rest, &rest, forces);
    }
    with -= without;
    forces.iter_mut().zip(others).for_each(|(force, other)| *force -= other);
    chart::hessian(&model.facts().rotation_vectors, q, &forces, &mut with);
    with
}

/// For each coordinate, the first coordinate of its part; parts that constraints join count as one.
fn joined<M: Static + ?Sized>(model: &mut M, q: &[f64]) -> Vec<usize> {
    let n = q.len();
    let mut first_of = vec![0; n];
    let mut first = 0;
    for &size in &model.facts().parts {
        first_of[first..first + size].fill(first);
        first += size;
    }
    let mut rows = Matrix::zeros(model.facts().constraints(), n);
    model.gap_jacobian(q, &mut rows);
    for row in rows.row_iter() {
        let mut moved = (0..n).filter(|&k| row[k] != 0.0).map(|k| first_of[k]).collect::<Vec<_>>();
        moved.sort_unstable();
        moved.dedup();
        if let Some((&one, others)) = moved.split_first() {
            first_of.iter_mut().filter(|first| others.contains(first)).for_each(|first| *first = one);
        }
    }
    first_of
}
