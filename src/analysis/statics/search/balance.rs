//! Constraint forces of a shape and its distance from equilibrium: multipliers of loops, tensions, and the backward error of
//! the balance of forces.

use super::problem::{Problem, Shape, add_transposed, scaled, times};
use super::scale::{NEGLIGIBLE_FORCE, Scale};
use crate::model::chart;
use crate::numerics::linalg::{Matrix, bounded_least_squares, norm, thin_svd};

/// Rows depend on others if orthogonalisation leaves less than this part of them.
const REDUNDANT: f64 = 1e-9;

/// A tendon that does not stretch is taut if it lacks less than this part of its span.
const LARGEST_TAUT_SHORTAGE: f64 = 1e-9;

/// Rounding of a length relative to its span.
const ROUNDING_OF_LENGTHS: f64 = 2e-15;

/// Smallest reference for forces, relative to the resistance of the material to a coordinate's size: for shapes with almost no forces.
const UNSTRAINED: f64 = 1e-4;

/// Independent rows: `G p = -g` becomes `V p = -T g` with orthonormal rows `V = T G`.
#[derive(Clone, Debug)]
pub(super) struct IndependentRows {
    pub(super) rows: Matrix,
    pub(super) transform: Matrix,
}

impl IndependentRows {
    pub(super) fn new(rows: &Matrix) -> Self {
        let (m, n) = rows.shape();
        let none = Self { rows: Matrix::zeros(0, n), transform: Matrix::zeros(0, m) };
        if m == 0 {
            return none;
        }
        let lengths: Vec<f64> =
            rows.row_iter().map(|row| if row.norm() > 0.0 { row.norm() } else { 1.0 }).collect();
        let of_length_one = Matrix::from_fn(m, n, |i, j| rows[(i, j)] / lengths[i]);
        let Some((left, values, right)) = thin_svd(&of_length_one) else { return none };
        let largest = values.first().copied().unwrap_or(0.0);
        let rank = values.iter().filter(|&&value| value > REDUNDANT * largest).count();
        Self {
            rows: Matrix::from_fn(rank, n, |i, j| right[(j, i)]),
            transform: Matrix::from_fn(rank, m, |i, k| left[(k, i)] / values[i] / lengths[k]),
        }
    }

    /// The part of a force outside the range of the rows.
    pub(super) fn free(&self, force: &[f64]) -> Vec<f64> {
        let mut left = force.to_vec();
        let along: Vec<f64> = times(&self.rows, force).into_iter().map(|x| -x).collect();
        add_transposed(&self.rows, &along, &mut left);
        left
    }
}

/// The balance of forces in a shape.
pub(super) struct Balance {
    /// Multipliers of the loops.
    pub(super) multipliers: Vec<f64>,
    /// Tensions of tendons, not negative, and amplitudes of springs.
    pub(super) tensions: Vec<f64>,
    /// Residual forces, along coordinates and along steps.
    pub(super) raw_gradient: Vec<f64>,
    pub(super) gradient: Vec<f64>,
    /// Summed magnitudes of all generalised forces along each coordinate, for any direction of the forces.
    pub(super) work: Vec<f64>,
    /// The largest relative change of the forces that would balance them.
    pub(super) error: f64,
}

impl Balance {
    pub(super) fn new(problem: &Problem<'_>, shape: &Shape, scale: &Scale) -> Self {
        let w = &scale.w;
        let constraints = IndependentRows::new(&scaled(&shape.gap_rows, w));
        let tensions = tensions(problem, shape, w, &constraints);
        let mut force = shape.force.clone();
        add_transposed(&shape.rows, &tensions, &mut force);
        let along: Vec<f64> = force.iter().zip(w).map(|(force, w)| force * w).collect();
        let parts: Vec<f64> = times(&constraints.rows, &along).into_iter().map(|x| -x).collect();
        let mut multipliers = vec![0.0; shape.gaps.len()];
        add_transposed(&constraints.transform, &parts, &mut multipliers);
        let raw_gradient = problem.raw_gradient(shape, &multipliers, &tensions);
        let mut gradient = raw_gradient.clone();
        chart::forces(&problem.turns, &shape.q, &mut gradient);
        // A residual along a tendon whose tension follows from its length is rounding of that tension.
        let by_length = problem.tensions(&shape.excess);
        let pulls: Vec<f64> =
            tensions.iter().zip(by_length).map(|(tension, other)| tension.abs().max(other.abs())).collect();
        let work = work(problem, shape, &multipliers, &pulls, scale);
        let error = gradient
            .iter()
            .zip(&work)
            .map(|(force, work)| if *work > 0.0 { force.abs() / work } else { force.abs() })
            .fold(0.0, |most: f64, x| if x <= most { most } else { x });
        Self { multipliers, tensions, raw_gradient, gradient, work, error }
    }
}

/// Tensions from lengths where these are accurate enough; tensions of taut inextensible tendons, and of elastic ones within rounding of their
/// lengths, by least squares of the remaining balance.
fn tensions(problem: &Problem<'_>, shape: &Shape, w: &[f64], constraints: &IndependentRows) -> Vec<f64> {
    let m = shape.excess.len();
    let mut tensions = problem.tensions(&shape.excess);
    if m == 0 {
        return tensions;
    }
    let free = |force: &[f64]| {
        constraints.free(&force.iter().zip(w).map(|(force, w)| force * w).collect::<Vec<_>>())
    };
    let left = |tensions: &[f64]| {
        let mut force = shape.force.clone();
        add_transposed(&shape.rows, tensions, &mut force);
        free(&force)
    };
    let columns = |rows: &[usize], size: &dyn Fn(usize) -> f64| {
        let mut columns = Matrix::zeros(w.len(), rows.len());
        for (k, &row) in rows.iter().enumerate() {
            let column: Vec<f64> = shape.rows.row(row).iter().map(|x| x * size(row)).collect();
            columns.column_mut(k).copy_from_slice(&free(&column));
        }
        columns
    };
    let taut: Vec<usize> = (0..m)
        .filter(|&row| problem.is_rigid(row) && shape.excess[row] > -LARGEST_TAUT_SHORTAGE * shape.spans[row])
        .collect();
    if !taut.is_empty() {
        let missing = left(&tensions);
        let size = norm(&missing);
        if size > 0.0 && size.is_finite() {
            let wanted: Vec<f64> = missing.iter().map(|x| -x / size).collect();
            let bounds = [vec![0.0; taut.len()], vec![f64::INFINITY; taut.len()]];
            let found = bounded_least_squares(&columns(&taut, &|_| 1.0), &wanted, &bounds[0], &bounds[1]);
            taut.iter().zip(found).for_each(|(&row, tension)| tensions[row] = tension * size);
        }
    }
    let rounding = |row: usize| {
        let most = problem.stiffness[row] * ROUNDING_OF_LENGTHS * shape.spans[row];
        if problem.is_one_sided(row) { most.min(tensions[row]) } else { most }
    };
    let stiff: Vec<usize> = (0..m)
        .filter(|&row| !problem.is_rigid(row) && rounding(row) > 10.0 * f64::EPSILON * tensions[row].abs())
        .filter(|&row| rounding(row) > 0.0)
        .collect();
    let missing = left(&tensions);
    let size = norm(&missing);
    if !stiff.is_empty() && size > 0.0 && size.is_finite() {
        // Rounding of elastic tensions changes those of the others.
        let most = stiff.iter().map(|&row| rounding(row)).fold(0.0, f64::max);
        let ranges: Vec<(usize, f64, f64)> = (stiff.iter().map(|&row| (row, rounding(row), -1.0)))
            .chain(taut.iter().map(|&row| (row, most, -tensions[row] / most)))
            .collect();
        let rows: Vec<usize> = ranges.iter().map(|range| range.0).collect();
        let range = |row: usize| ranges.iter().find(|range| range.0 == row).map_or(0.0, |range| range.1);
        let wanted: Vec<f64> = missing.iter().map(|x| -x / size).collect();
        let changes = columns(&rows, &|row| range(row) / size);
        let lower: Vec<f64> = ranges.iter().map(|range| range.2).collect();
        let upper: Vec<f64> =
            (0..rows.len()).map(|k| if k < stiff.len() { 1.0 } else { f64::INFINITY }).collect();
        let found = bounded_least_squares(&changes, &wanted, &lower, &upper);
        let changes: Vec<(usize, f64)> =
            rows.iter().zip(found).map(|(&row, part)| (row, part * range(row))).collect();
        changes.into_iter().for_each(|(row, change)| tensions[row] += change);
    }
    tensions
}

/// Summed magnitudes of the generalised forces: weight and loads in any direction, the material, loops, tendons and springs, and for
/// contacts the largest value along any coordinate of the same part.
fn work(
    problem: &Problem<'_>,
    shape: &Shape,
    multipliers: &[f64],
    tensions: &[f64],
    scale: &Scale,
) -> Vec<f64> {
    let (n, sizes) = (problem.n(), &scale.sizes);
    let mut work: Vec<f64> = (0..n)
        .map(|j| {
            let of_material: f64 = (0..n).map(|k| problem.material[(j, k)].abs() * shape.q[k].abs()).sum();
            let of_loops: f64 =
                multipliers.iter().enumerate().map(|(i, x)| (x * shape.gap_rows[(i, j)]).abs()).sum();
            let of_tendons: f64 =
                tensions.iter().enumerate().map(|(i, x)| (x * shape.reach[(i, j)]).abs()).sum();
            let least = UNSTRAINED * problem.material[(j, j)].abs() * sizes[j];
            (scale.loads[j] + of_material + shape.force[j].abs() + of_loops + of_tendons).max(least)
        })
        .collect();
    let mut first = 0;
    for &part in &problem.parts {
        let range = first..first + part;
        if let Some(forces) = shape.contact_force.get(range.clone()) {
            let most = forces
                .iter()
                .zip(&sizes[range.clone()])
                .map(|(x, size)| (x * size).abs())
                .fold(0.0, f64::max);
            range.clone().for_each(|k| work[k] += most / sizes[k]);
        }
        let most = range.clone().map(|k| work[k] * sizes[k]).fold(0.0, f64::max);
        range.for_each(|k| work[k] = work[k].max(NEGLIGIBLE_FORCE * most / sizes[k]));
        first += part;
    }
    for &k in &problem.turns {
        let most = work[k..k + 3].iter().copied().fold(0.0, f64::max);
        work[k..k + 3].fill(most);
    }
    work
}
