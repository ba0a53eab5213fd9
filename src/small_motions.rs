//! Small motions about a state at rest, `M x'' + D x' + K x = 0`, and their eigenvalues.

use crate::constraint::inverse_length;
use crate::linalg::{Complex, Matrix, eigenvalues, full_svd};
use crate::model::Model;
use crate::natural::{self, Natural, scaled};

/// Stiffness and damping count as symmetric if no entry differs from its transpose by more than this fraction
/// of the largest entry, in scaled coordinates.
const SYMMETRIC: f64 = 1e-6;

/// Eigenvalues whose real part is smaller than this fraction of their magnitude do not count as growing.
pub(crate) const GROWING: f64 = 1e-9;

/// If rates differ by more than this factor, slow eigenvalues come from the inverse problem.
const WIDE: f64 = 1e3;

/// Constraints with a singular value below this fraction of the largest one count as redundant.
const DEPENDENT: f64 = 1e-8;

/// Matrices of small motions, in natural coordinates x of the shape: `q / s = W x` with the typical sizes s.
pub(crate) struct SmallMotions {
    pub(crate) mass: Matrix,
    pub(crate) damping: Matrix,
    pub(crate) stiffness: Matrix,
    /// W.
    pub(crate) basis: Matrix,
    pub(crate) sizes: Vec<f64>,
}

impl SmallMotions {
    pub(crate) fn n(&self) -> usize {
        self.mass.nrows()
    }

    /// Small motions that satisfy constraints with these derivatives in scaled coordinates: projection onto
    /// their null space, found by singular values.
    pub(crate) fn within(&self, constraints: &Matrix) -> Option<Self> {
        let mut natural = constraints * &self.basis;
        let longest = natural.row_iter().map(|row| row.norm()).fold(0.0, f64::max);
        for mut row in natural.row_iter_mut() {
            row *= inverse_length(row.norm(), longest);
        }
        let (_, values, right) = full_svd(&natural)?;
        let largest = values.first().copied().unwrap_or(0.0);
        let rank = values.iter().filter(|&&value| value > DEPENDENT * largest).count();
        let free = right.columns(rank, right.ncols() - rank).into_owned();
        let within = |a: &Matrix| free.tr_mul(&(a * &free));
        Some(Self {
            mass: within(&self.mass),
            damping: within(&self.damping),
            stiffness: within(&self.stiffness),
            basis: &self.basis * &free,
            sizes: self.sizes.clone(),
        })
    }

    /// All eigenvalues of the motion.
    pub(crate) fn eigenvalues(&self) -> Option<Vec<Complex>> {
        let lower = self.mass.clone().cholesky()?.l();
        let fast = state_matrix(&reduced(&self.stiffness, &lower)?, &reduced(&self.damping, &lower)?);
        let slow = self.inverse().and_then(|inverse| eigenvalues(&inverse));
        Some(merged_values(slow, eigenvalues(&fast)?))
    }

    /// State matrix whose eigenvalues are the inverses of the motion's eigenvalues: slow ones are large
    /// there, and hence accurate.
    pub(crate) fn inverse(&self) -> Option<Matrix> {
        let factors = self.stiffness.clone().lu();
        Some(state_matrix(&factors.solve(&self.mass)?, &factors.solve(&self.damping)?))
    }
}

/// Small motions of a model about rest at `q`; `None` if a number is not finite.
pub(crate) fn small_motions(model: &mut dyn Model, q: &[f64], sizes: &[f64]) -> Option<SmallMotions> {
    let n = q.len();
    let rest = vec![0.0; n];
    let material = natural::material(model, q, sizes);
    let held = natural::linearised(model, q, sizes);
    let tangent = |model: &mut dyn Model, weights| {
        let mut tangent = Matrix::zeros(n, n);
        model.weighted_tangent(q, &rest, &rest, weights, &mut tangent);
        scaled(tangent, sizes)
    };
    let natural = |stiffness: &Matrix| {
        Natural::new(&material, held.as_ref(), || natural::reference(&material, stiffness, 0.0))
    };
    let (stiffness, natural) = match &held {
        None => {
            let stiffness = tangent(model, [1.0, 0.0, 0.0]);
            let natural = natural(&stiffness)?;
            (natural.tangent(&stiffness, None), natural)
        }
        Some(own) => {
            let natural = natural(&material)?;
            let mut at_own = vec![0.0; n];
            model.hold_springs(Some(&own.forces));
            model.inverse_dynamics(q, &rest, &rest, &mut at_own);
            at_own.iter_mut().zip(sizes).for_each(|(tau, size)| *tau *= size);
            model.hold_springs(Some(&natural.settled(own, &natural.forces(&at_own))));
            let stiffness = tangent(model, [1.0, 0.0, 0.0]);
            model.hold_springs(None);
            (natural.tangent(&stiffness, held.as_ref()), natural)
        }
    };
    let damping = natural.matrix(&tangent(model, [0.0, 1.0, 0.0]));
    let mut mass = Matrix::zeros(n, n);
    model.mass_matrix(q, &mut mass);
    let mass = natural.matrix(&scaled(mass, sizes));
    Some(SmallMotions { mass, damping, stiffness, basis: natural.basis(), sizes: sizes.to_vec() })
}

/// Compares each entry with the diagonal entries of its row and column.
pub(crate) fn is_symmetric(a: &Matrix) -> bool {
    let n = a.nrows();
    let size = |i: usize| a.row(i).iter().fold(0.0_f64, |m, x| m.max(x.abs()));
    let sizes: Vec<f64> = (0..n).map(size).collect();
    (0..n).all(|j| (0..j).all(|i| (a[(i, j)] - a[(j, i)]).abs() <= SYMMETRIC * (sizes[i] * sizes[j]).sqrt()))
}

/// Symmetric `L^-1 A L^-T`.
pub(crate) fn reduced(a: &Matrix, lower: &Matrix) -> Option<Matrix> {
    let mut half = a.clone();
    lower.solve_lower_triangular_mut(&mut half).then_some(())?;
    let mut whole = half.transpose();
    lower.solve_lower_triangular_mut(&mut whole).then_some(whole.transpose())
}

/// `[0 u; -K/u -D]` for `y'' + D y' + K y = 0`. Velocities are divided by a typical rate u to balance both
/// halves.
pub(crate) fn state_matrix(stiffness: &Matrix, damping: &Matrix) -> Matrix {
    let n = stiffness.nrows();
    let mut state = Matrix::zeros(2 * n, 2 * n);
    let unit = stiffness.norm().sqrt().sqrt().max(f64::MIN_POSITIVE);
    for i in 0..n {
        state[(i, n + i)] = unit;
        for j in 0..n {
            state[(n + i, j)] = -stiffness[(i, j)] / unit;
            state[(n + i, n + j)] = -damping[(i, j)];
        }
    }
    state
}

/// Combines eigenvalues of the inverse problem, in which slow ones are accurate, with those of the problem
/// itself, in which fast ones are: absolute errors are rounding times the largest eigenvalue. The split is at
/// the widest gap in the middle of the range.
pub(crate) fn merged<T>(inverse: Option<Vec<(Complex, T)>>, own: Vec<(Complex, T)>) -> Vec<(Complex, T)> {
    let Some(inverse) = inverse else { return own };
    let slow: Vec<_> = inverse.into_iter().map(|(value, x)| (value.inv(), x)).collect();
    let mut rates: Vec<f64> = slow.iter().map(|(value, _)| value.norm()).collect();
    rates.sort_by(f64::total_cmp);
    let fastest = own.iter().map(|(value, _)| value.norm()).fold(0.0, f64::max);
    let slowest = rates.first().copied().unwrap_or(0.0);
    let range = fastest / slowest;
    if !(range > WIDE && range.is_finite()) {
        return own;
    }
    let is_middle = |rate: f64| (0.25..0.75).contains(&((rate / slowest).ln() / range.ln()));
    let gap = |pair: &&[f64]| pair[1] / pair[0];
    let between = |pair: &[f64]| (pair[0] * pair[1]).sqrt();
    let widest =
        rates.windows(2).filter(|pair| is_middle(between(pair))).max_by(|a, b| gap(a).total_cmp(&gap(b)));
    let border = widest.map_or_else(|| (slowest * fastest).sqrt(), between);
    let slow: Vec<_> = slow.into_iter().filter(|(value, _)| value.norm() <= border).collect();
    // Rounding of the fastest may exceed the border.
    let mut fast = own;
    fast.sort_by(|(a, _), (b, _)| b.norm().total_cmp(&a.norm()));
    fast.truncate(fast.len().saturating_sub(slow.len()));
    slow.into_iter().chain(fast).collect()
}

/// [`merged`] without vectors.
pub(crate) fn merged_values(inverse: Option<Vec<Complex>>, own: Vec<Complex>) -> Vec<Complex> {
    let bare = |values: Vec<Complex>| values.into_iter().map(|value| (value, ())).collect();
    merged(inverse.map(bare), bare(own)).into_iter().map(|(value, ())| value).collect()
}
