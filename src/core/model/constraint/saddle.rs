//! Linear systems with constraints, `[S, G^T; G, 0]`.

use super::parts::Parts;
use super::{Independent, inverse_length};
use crate::model::{SingularMass, Static};
use crate::numerics::linalg::{Lu, Matrix, Singular, thin_svd};

/// Diagonal entries below this part of the largest one are rounding: coordinates without inertia that only constraints hold.
const NEGLIGIBLE_INERTIA: f64 = 1e-14;

/// A tangent S and constraints G with the factors of both together, and memory for repeated use.
#[derive(Clone, Debug)]
pub struct Saddle {
    /// n x n.
    pub tangent: Matrix,
    /// m x n.
    pub constraints: Matrix,
    independent: Independent,
    parts: Parts,
    systems: Vec<PartialSystem>,
}

/// The equations of a part, with their factors.
#[derive(Clone, Debug)]
struct PartialSystem {
    /// Its unknowns among those of all, coordinates first.
    unknowns: Vec<usize>,
    bordered: Matrix,
    lu: Lu,
    right: Vec<f64>,
}

impl PartialSystem {
    fn new(unknowns: Vec<usize>) -> Self {
        let size = unknowns.len();
        Self { bordered: Matrix::zeros(size, size), lu: Lu::new(size), right: vec![0.0; size], unknowns }
    }

    fn factorise(
        &mut self,
        tangent: &Matrix,
        constraints: &Matrix,
        independent: &Independent,
    ) -> Result<(), Singular> {
        let Self { unknowns, bordered, lu, .. } = self;
        let n = tangent.nrows();
        let entry = |i: usize, j: usize| match (i.checked_sub(n), j.checked_sub(n)) {
            (None, None) => tangent[(i, j)],
            (Some(row), None) if independent.is_independent(row) => constraints[(row, j)],
            (None, Some(row)) if independent.is_independent(row) => constraints[(row, i)],
            (Some(row), Some(_)) if i == j && !independent.is_independent(row) => 1.0,
            _ => 0.0,
        };
        for (to, &j) in unknowns.iter().enumerate() {
            for (value, &i) in bordered.column_mut(to).iter_mut().zip(unknowns.iter()) {
                *value = entry(i, j);
            }
        }
        lu.factorise(bordered)
    }

    fn solve(&mut self, b: &mut [f64]) {
        for (value, &k) in self.right.iter_mut().zip(&self.unknowns) {
            *value = b[k];
        }
        self.lu.solve(&mut self.right);
        for (value, &k) in self.right.iter().zip(&self.unknowns) {
            b[k] = *value;
        }
    }
}

impl Saddle {
    /// The system of n coordinates and m constraints, all zero.
    pub fn new(n: usize, m: usize) -> Self {
        Self {
            tangent: Matrix::zeros(n, n),
            constraints: Matrix::zeros(m, n),
            independent: Independent::new(m, n),
            parts: Parts::new(n + m),
            systems: vec![PartialSystem::new((0..n + m).collect())],
        }
    }

    /// Factorises them, without the rows that others determine, each part that nothing couples to others by itself. Cost:
    /// 2/3 (n + m)^3 flops of each. Allocates where the parts are other ones than before.
    pub fn factorise(&mut self) -> Result<(), Singular> {
        let Self { tangent, constraints, independent, parts, systems } = self;
        if parts.find(tangent, constraints) {
            let of = |part: usize| (0..parts.of.len()).filter(|&k| parts.of[k] == part).collect();
            *systems = (0..parts.count).map(|part| PartialSystem::new(of(part))).collect();
        }
        let largest = (0..tangent.nrows()).map(|k| tangent[(k, k)].abs()).fold(f64::MIN_POSITIVE, f64::max);
        let scale = |k: usize| {
            Some(tangent[(k, k)].abs()).filter(|x| *x > NEGLIGIBLE_INERTIA * largest).unwrap_or(largest)
        };
        independent.find(constraints, |k| scale(k).sqrt().recip(), &parts.of[tangent.nrows()..]);
        if let [PartialSystem { bordered, lu, .. }] = systems.as_mut_slice() {
            border(tangent, constraints, independent, bordered);
            return lu.factorise(bordered);
        }
        systems.iter_mut().try_for_each(|system| system.factorise(tangent, constraints, independent))
    }

    /// Writes the bordered matrix of another tangent, with the independent rows of the last factorisation.
    pub fn border(&self, tangent: &Matrix, bordered: &mut Matrix) {
        border(tangent, &self.constraints, &self.independent, bordered);
    }

    /// Number of independent constraints at the last factorisation.
    pub fn rank(&self) -> usize {
        self.independent.rank()
    }

    /// Sets the multipliers of dependent rows to zero.
    pub fn drop_dependent(&self, multipliers: &mut [f64]) {
        for (i, multiplier) in multipliers.iter_mut().enumerate() {
            if !self.independent.is_independent(i) {
                *multiplier = 0.0;
            }
        }
    }

    /// By how much a change of coordinates by their `sizes` changes the gap of a row; zero if it was dependent at the last factorisation.
    pub fn reach(&self, row: usize, sizes: &[f64]) -> f64 {
        if !self.independent.is_independent(row) {
            return 0.0;
        }
        sizes
            .iter()
            .enumerate()
            .map(|(k, size)| (self.constraints[(row, k)] * size).powi(2))
            .sum::<f64>()
            .sqrt()
    }

    /// The largest remaining gap of rows that were dependent at the last factorisation, after `change` is subtracted from the
    /// coordinates, in units of `sizes`.
    pub fn left_open(&self, gaps: &[f64], change: &[f64], sizes: &[f64]) -> f64 {
        let mut largest = 0.0_f64;
        for (i, gap) in gaps.iter().enumerate().filter(|(i, _)| !self.independent.is_independent(*i)) {
            let closed = (0..self.tangent.nrows()).map(|k| self.constraints[(i, k)] * change[k]).sum::<f64>();
            let left = ((gap - closed) / sizes[i]).abs();
            largest = if left <= largest { largest } else { left };
        }
        largest
    }

    /// Solves with the factors, in place. Multipliers of dependent rows are zero.
    pub fn solve(&mut self, b: &mut [f64]) {
        self.drop_dependent(&mut b[self.tangent.nrows()..]);
        match self.systems.as_mut_slice() {
            [all] => all.lu.solve(b),
            parts => parts.iter_mut().for_each(|part| part.solve(b)),
        }
    }
}

/// Writes `[S, G^T; G, 0]` with the independent rows of G, and a one on the diagonal for each dependent row.
fn border(tangent: &Matrix, constraints: &Matrix, independent: &Independent, bordered: &mut Matrix) {
    let n = tangent.nrows();
    bordered.fill(0.0);
    for k in 0..n {
        for j in 0..n {
            bordered[(j, k)] = tangent[(j, k)];
        }
        for i in 0..constraints.nrows() {
            if independent.is_independent(i) {
                bordered[(n + i, k)] = constraints[(i, k)];
                bordered[(k, n + i)] = constraints[(i, k)];
            }
        }
    }
    for i in (0..constraints.nrows()).filter(|&i| !independent.is_independent(i)) {
        bordered[(n + i, n + i)] = 1.0;
    }
}

/// Singular values below this part of the largest one count as zero; constraints are of length one there.
const SINGULAR: f64 = 1e-8;

/// `[M, G^T; G, 0]` with a positive definite mass, solved with the smallest multipliers where rows are redundant.
pub(crate) struct MassSaddle {
    /// L of the mass.
    lower: Matrix,
    /// Singular value decomposition of `L^-1 G^T`, whose columns are scaled to length one.
    left: Matrix,
    values: Vec<f64>,
    right: Matrix,
    /// One over the lengths of these columns; zero for constraints that nothing moves.
    inverse_lengths: Vec<f64>,
    gap_jacobian: Matrix,
}

impl MassSaddle {
    /// For a shape of a model. Allocates.
    pub(crate) fn new<M: Static + ?Sized>(model: &mut M, q: &[f64]) -> Result<Self, SingularMass> {
        let n = q.len();
        let mut mass = Matrix::zeros(n, n);
        model.mass_matrix(q, &mut mass);
        Self::with(model, q, &mass)
    }

    /// With any positive definite metric for the mass.
    pub(crate) fn with<M: Static + ?Sized>(
        model: &mut M,
        q: &[f64],
        metric: &Matrix,
    ) -> Result<Self, SingularMass> {
        let (n, m) = (q.len(), model.facts().constraints());
        let mut gap_jacobian = Matrix::zeros(m, n);
        model.gap_jacobian(q, &mut gap_jacobian);
        let lower = metric.clone().cholesky().ok_or(SingularMass)?.l();
        let mut half = gap_jacobian.transpose();
        lower.solve_lower_triangular_mut(&mut half);
        let lengths: Vec<f64> = half.column_iter().map(|column| column.norm()).collect();
        let largest = lengths.iter().copied().fold(0.0, f64::max);
        let inverse_lengths: Vec<f64> =
            lengths.into_iter().map(|length| inverse_length(length, largest)).collect();
        for (mut column, factor) in half.column_iter_mut().zip(&inverse_lengths) {
            column *= *factor;
        }
        let (mut left, values, right) = thin_svd(&half).ok_or(SingularMass)?;
        // In terms of coordinates: L^-T U.
        lower.tr_solve_lower_triangular_mut(&mut left);
        Ok(Self { lower, left, values, right, inverse_lengths, gap_jacobian })
    }

    /// Number of independent constraints.
    pub(crate) fn rank(&self) -> usize {
        let largest = self.values.first().copied().unwrap_or(0.0);
        self.values.iter().filter(|&&value| value > SINGULAR * largest && value > 0.0).count()
    }

    /// The smallest singular value that does not count as zero, over the largest one.
    pub(crate) fn margin(&self) -> f64 {
        match self.rank() {
            0 => 1.0,
            rank => self.values[rank - 1] / self.values[0],
        }
    }

    /// Length of the shortest row of the constraint Jacobian over that of the longest, in the metric of the mass: zero where bars
    /// are in line.
    pub(crate) fn least_motion(&self) -> f64 {
        let moved = || self.inverse_lengths.iter().filter(|&&factor| factor > 0.0);
        let [least, most] =
            [moved().copied().fold(0.0, f64::max), moved().copied().fold(f64::INFINITY, f64::min)];
        if least > 0.0 { most / least } else { 1.0 }
    }

    /// The smallest change x of coordinates with `G x = gaps` in the sense of least squares, and `lambda` with
    /// `M x + G^T lambda = 0`.
    pub(crate) fn closing(&self, gaps: &[f64]) -> (Vec<f64>, Vec<f64>) {
        let (n, m) = (self.left.nrows(), gaps.len());
        let scaled: Vec<f64> =
            gaps.iter().zip(&self.inverse_lengths).map(|(gap, factor)| gap * factor).collect();
        let (mut x, mut multipliers) = (vec![0.0; n], vec![0.0; m]);
        for k in 0..self.rank() {
            let part = (0..m).map(|i| self.right[(i, k)] * scaled[i]).sum::<f64>() / self.values[k];
            for (j, x) in x.iter_mut().enumerate() {
                *x += self.left[(j, k)] * part;
            }
            for (i, multiplier) in multipliers.iter_mut().enumerate() {
                *multiplier -= self.right[(i, k)] * part / self.values[k];
            }
        }
        multipliers
            .iter_mut()
            .zip(&self.inverse_lengths)
            .for_each(|(multiplier, factor)| *multiplier *= factor);
        (x, multipliers)
    }

    /// Accelerations and multipliers with `M a + G^T lambda = force` and `G a = gap_accelerations`.
    pub(crate) fn solve(&mut self, force: &[f64], gap_accelerations: &[f64]) -> (Vec<f64>, Vec<f64>) {
        let mut free = Matrix::from_column_slice(force.len(), 1, force);
        self.lower.solve_lower_triangular_mut(&mut free);
        self.lower.tr_solve_lower_triangular_mut(&mut free);
        let missing: Vec<f64> = gap_accelerations
            .iter()
            .enumerate()
            .map(|(i, wanted)| {
                wanted - (0..free.len()).map(|k| self.gap_jacobian[(i, k)] * free[k]).sum::<f64>()
            })
            .collect();
        let (change, multipliers) = self.closing(&missing);
        let accelerations = free.iter().zip(change).map(|(a, change)| a + change).collect();
        (accelerations, multipliers)
    }
}

/// The accelerations and the multipliers of a model with constraints. Allocates.
pub fn accelerations<M: Static + ?Sized>(
    model: &mut M,
    q: &[f64],
    v: &[f64],
    a: &mut [f64],
    multipliers: &mut [f64],
) -> Result<(), SingularMass> {
    accelerations_by(&mut MassSaddle::new(model, q)?, model, [q, v], a, multipliers);
    Ok(())
}

/// The same by the saddle of the shape.
pub(super) fn accelerations_by<M: Static + ?Sized>(
    saddle: &mut MassSaddle,
    model: &mut M,
    [q, v]: [&[f64]; 2],
    a: &mut [f64],
    multipliers: &mut [f64],
) {
    a.fill(0.0);
    multipliers.fill(0.0);
    model.set_multipliers(multipliers);
    let (mut force, mut wanted) = (vec![0.0; q.len()], vec![0.0; multipliers.len()]);
    model.inverse_dynamics(q, v, a, &mut force);
    model.gap_accelerations(q, v, a, &mut wanted);
    force.iter_mut().chain(&mut wanted).for_each(|x| *x = -*x);
    let (found, lambda) = saddle.solve(&force, &wanted);
    a.copy_from_slice(&found);
    multipliers.copy_from_slice(&lambda);
}

/// Multipliers of a motion: the smallest ones with `tau + G^T lambda = 0`, in the metric of the mass, or of typical coordinates if
/// some have no inertia. Allocates.
pub fn multipliers<M: Static + ?Sized>(
    model: &mut M,
    [q, v, a]: [&[f64]; 3],
    multipliers: &mut [f64],
) -> Result<(), SingularMass> {
    multipliers.fill(0.0);
    model.set_multipliers(multipliers);
    let mut force = vec![0.0; q.len()];
    model.inverse_dynamics(q, v, a, &mut force);
    force.iter_mut().for_each(|x| *x = -*x);
    let zeros = vec![0.0; multipliers.len()];
    let mut saddle = match MassSaddle::new(model, q) {
        Ok(saddle) => saddle,
        Err(SingularMass) => {
            let sizes = model.facts().typical_coordinates.iter();
            let metric = Matrix::from_diagonal(&sizes.map(|size| size.powi(-2)).collect::<Vec<_>>().into());
            MassSaddle::with(model, q, &metric)?
        }
    };
    let (_, lambda) = saddle.solve(&force, &zeros);
    multipliers.copy_from_slice(&lambda);
    Ok(())
}
