//! Mixed formulation of stiff springs to the world, which keeps Newton's method well conditioned.
//!
//! A spring of stiffness k makes the forces of a shape k times as sensitive as its displacement. A solver for
//! coordinates alone then follows a narrow curved valley: a step of size s leaves the valley by s^2, where
//! forces are unrelated to those at equilibrium. In the mixed formulation the forces of springs are
//! separate unknowns (Magisano, Leonetti and Garcea 2017, "Advantages of the mixed format in geometrically
//! nonlinear analysis of beams and shells using solid finite elements"). Tangents are evaluated at *fixed*
//! forces, which follow from the last linear solve, so that the step size no longer depends on stiffness.

use crate::model::Static;
use crate::model::springs::Springs;
use crate::numerics::linalg::{Matrix, full_svd, norm};

/// Steps below this size are within the rounding of coordinates and positions, in coordinates divided by
/// their typical sizes.
pub(crate) const DISPLACEMENT_ROUNDING: f64 = 1e-12;

/// Normalised coordinates x with `q = W x`, in which the stiffness of material and springs together is the
/// identity, `W^T (K + J^T G G^T J) W = 1`. Computations in these coordinates are not stiff, however stiff
/// the springs are.
#[derive(Clone, Debug)]
pub(crate) struct Normalised {
    basis: Basis,
    /// `W^T J^T G`, n x m. This matrix times its transpose is the springs' part of the identity.
    springs: Matrix,
}

#[derive(Clone, Debug)]
enum Basis {
    Diagonal(Vec<f64>),
    Full(Matrix),
}

impl Normalised {
    /// Normalised coordinates for a symmetric positive stiffness K of the material, and for springs in the same
    /// coordinates. If K is not positive definite, the diagonal `fallback` replaces it. `None` if a number is
    /// not finite.
    pub(crate) fn new(
        material: &Matrix,
        springs: Option<&Springs>,
        fallback: impl Fn() -> Vec<f64>,
    ) -> Option<Self> {
        let n = material.nrows();
        let is_diagonal = (0..n).all(|j| (0..j).all(|i| material[(i, j)] == 0.0 && material[(j, i)] == 0.0));
        let diagonal = |stiffness: Vec<f64>| {
            let scale: Vec<f64> = stiffness.into_iter().map(|x| 1.0 / x.sqrt()).collect();
            scale.iter().all(|x| x.is_finite()).then_some(scale)
        };
        let is_positive = (0..n).all(|i| material[(i, i)] > 0.0);
        let factor = if is_diagonal || !is_positive { None } else { material.clone().cholesky() };
        let basis = match factor {
            Some(factor) => {
                let mut basis = Matrix::identity(n, n);
                factor.l().tr_solve_lower_triangular_mut(&mut basis).then_some(())?;
                Basis::Full(basis)
            }
            None if is_diagonal && is_positive => {
                Basis::Diagonal(diagonal((0..n).map(|i| material[(i, i)]).collect())?)
            }
            None => Basis::Diagonal(diagonal(fallback())?),
        };
        let of_material = Self { basis, springs: Matrix::zeros(n, 0) };
        match springs {
            Some(springs) => of_material.with_springs(springs),
            None => Some(of_material),
        }
    }

    /// Normalised coordinates of a material with springs, by the singular values of `W^T J^T G`.
    fn with_springs(&self, springs: &Springs) -> Option<Self> {
        let roots = springs.jacobian.transpose() * &springs.root;
        let roots = self.normalised_columns(&roots);
        let (n, m) = roots.shape();
        let (left, values, right) = full_svd(&roots)?;
        let value = |i: usize| values.get(i).copied().unwrap_or(0.0);
        let size = |i: usize| value(i).hypot(1.0);
        let turned = Matrix::from_fn(n, n, |i, j| left[(i, j)] / size(j));
        let basis = match &self.basis {
            Basis::Diagonal(scale) => Matrix::from_fn(n, n, |i, j| scale[i] * turned[(i, j)]),
            Basis::Full(basis) => basis * turned,
        };
        let springs =
            Matrix::from_fn(n, m, |i, j| if i < m.min(n) { value(i) / size(i) * right[(j, i)] } else { 0.0 });
        Some(Self { basis: Basis::Full(basis), springs })
    }

    /// `W^T A`.
    fn normalised_columns(&self, a: &Matrix) -> Matrix {
        match &self.basis {
            Basis::Diagonal(scale) => Matrix::from_fn(a.nrows(), a.ncols(), |i, j| scale[i] * a[(i, j)]),
            Basis::Full(basis) => basis.tr_mul(a),
        }
    }

    /// `W^T A W`.
    pub(crate) fn matrix(&self, a: &Matrix) -> Matrix {
        match &self.basis {
            Basis::Diagonal(scale) => {
                Matrix::from_fn(a.nrows(), a.ncols(), |i, j| scale[i] * a[(i, j)] * scale[j])
            }
            Basis::Full(basis) => basis.tr_mul(&(a * basis)),
        }
    }

    /// `W^T f` for forces f.
    pub(crate) fn forces(&self, forces: &[f64]) -> Vec<f64> {
        match &self.basis {
            Basis::Diagonal(scale) => scale.iter().zip(forces).map(|(scale, force)| scale * force).collect(),
            Basis::Full(basis) => basis
                .column_iter()
                .map(|column| column.iter().zip(forces).map(|(w, f)| w * f).sum())
                .collect(),
        }
    }

    /// `W x` for normalised coordinates x.
    pub(crate) fn coordinates(&self, x: &[f64]) -> Vec<f64> {
        match &self.basis {
            Basis::Diagonal(scale) => scale.iter().zip(x).map(|(scale, x)| scale * x).collect(),
            Basis::Full(basis) => {
                basis.row_iter().map(|row| row.iter().zip(x).map(|(w, x)| w * x).sum()).collect()
            }
        }
    }

    /// W.
    pub(crate) fn basis(&self) -> Matrix {
        match &self.basis {
            Basis::Diagonal(scale) => Matrix::from_diagonal(&scale.clone().into()),
            Basis::Full(basis) => basis.clone(),
        }
    }

    /// Tangent of forces and springs together, from the tangent at fixed forces.
    pub(crate) fn tangent(&self, a: &Matrix, springs: Option<&Springs>) -> Matrix {
        let Some(springs) = springs else { return self.matrix(a) };
        let rest = springs.jacobian.tr_mul(&(&springs.rest * &springs.jacobian));
        self.matrix(&(a + rest)) + &self.springs * self.springs.transpose()
    }

    /// The sum of the magnitudes of all terms of such a tangent, from the magnitudes of those at fixed forces.
    pub(crate) fn magnitudes(&self, a: &Matrix, springs: Option<&Springs>) -> Matrix {
        let Some(springs) = springs else { return self.sizes().matrix(a) };
        let moved = springs.jacobian.abs();
        let rest = moved.tr_mul(&(springs.rest.abs() * &moved));
        self.sizes().matrix(&(a + rest)) + self.springs.abs() * self.springs.abs().transpose()
    }

    /// With the magnitudes of the entries of W.
    fn sizes(&self) -> Self {
        let basis = match &self.basis {
            Basis::Diagonal(scale) => Basis::Diagonal(scale.iter().map(|x| x.abs()).collect()),
            Basis::Full(basis) => Basis::Full(basis.abs()),
        };
        Self { basis, springs: Matrix::zeros(self.springs.nrows(), 0) }
    }

    /// Normalised residual of forces and springs together, from the residual at fixed forces.
    pub(crate) fn residual(&self, residual: &[f64], springs: Option<&Springs>, forces: &[f64]) -> Vec<f64> {
        let Some(springs) = springs else { return self.forces(residual) };
        let [amplitudes, left] = springs.mismatch(forces);
        let n = residual.len();
        let with_left: Vec<f64> = (0..n)
            .map(|j| residual[j] - (0..left.len()).map(|i| springs.jacobian[(i, j)] * left[i]).sum::<f64>())
            .collect();
        let mut residual = self.forces(&with_left);
        for (j, residual) in residual.iter_mut().enumerate() {
            *residual -= (0..amplitudes.len()).map(|i| self.springs[(j, i)] * amplitudes[i]).sum::<f64>();
        }
        residual
    }

    /// Change of the springs' forces with normalised coordinates.
    pub(crate) fn change_of_forces(&self, springs: &Springs, x: &[f64]) -> Vec<f64> {
        let m = springs.forces.len();
        let amplitudes: Vec<f64> =
            (0..m).map(|i| (0..x.len()).map(|j| self.springs[(j, i)] * x[j]).sum()).collect();
        let q = self.coordinates(x);
        let moved: Vec<f64> =
            (0..m).map(|i| (0..q.len()).map(|j| springs.jacobian[(i, j)] * q[j]).sum()).collect();
        (0..m)
            .map(|i| {
                -(0..m)
                    .map(|k| springs.root[(i, k)] * amplitudes[k] + springs.rest[(i, k)] * moved[k])
                    .sum::<f64>()
            })
            .collect()
    }

    /// The smallest step, in normalised coordinates, after which springs carry the fixed forces, to first order.
    pub(crate) fn restoring(&self, springs: &Springs, forces: &[f64]) -> Vec<f64> {
        let [amplitudes, _] = springs.mismatch(forces);
        (0..self.springs.nrows())
            .map(|j| (0..amplitudes.len()).map(|i| self.springs[(j, i)] * amplitudes[i]).sum())
            .collect()
    }
}

impl Normalised {
    /// The springs' forces at equilibrium, given the normalised residual at the forces that follow from
    /// displacements. The displacement of a stiff spring determines its force only up to rounding times
    /// stiffness. If the correction is smaller than the rounding of displacements, the force from equilibrium
    /// is more accurate.
    pub(crate) fn forces_at_equilibrium(&self, springs: &Springs, residual: &[f64]) -> Vec<f64> {
        let (n, m) = self.springs.shape();
        let amplitudes: Vec<f64> =
            (0..m).map(|i| (0..n).map(|j| self.springs[(j, i)] * residual[j]).sum()).collect();
        let step: Vec<f64> =
            (0..n).map(|j| -(0..m).map(|i| self.springs[(j, i)] * amplitudes[i]).sum::<f64>()).collect();
        let mut forces = springs.forces.clone();
        if norm(&self.coordinates(&step)) <= DISPLACEMENT_ROUNDING {
            for (force, change) in forces.iter_mut().zip(self.change_of_forces(springs, &step)) {
                *force += change;
            }
        }
        forces
    }
}

/// Tangent of a model's material, in coordinates divided by `sizes`.
pub(crate) fn material(model: &mut dyn Static, q: &[f64], sizes: &[f64]) -> Matrix {
    let no_forces = vec![0.0; model.facts().springs];
    model.hold_springs(Some(&no_forces));
    let mut tangent = Matrix::zeros(q.len(), q.len());
    model.elastic_tangent(q, &mut tangent);
    model.hold_springs(None);
    scaled(tangent, sizes)
}

/// Reference stiffnesses, all > 0: the elastic ones, and for coordinates without elasticity those of the tangent. A part without any
/// stiffness, such as a body in free fall, gets the norm of `forces`, of which the tangent is the derivative. `parts` are numbers of
/// coordinates of uncoupled parts ([`parts`](crate::model::Facts::parts)), which are treated separately. `groups` has a number for each
/// coordinate, the same for those of parts that constraints couple: stiffnesses that are rounding of that of another part of a group
/// count as none. Empty if nothing couples parts.
pub(crate) fn reference(
    elastic: &Matrix,
    tangent: &Matrix,
    forces: &[f64],
    parts: &[usize],
    groups: &[usize],
) -> Vec<f64> {
    /// Stiffnesses below this fraction of the largest one are rounding errors, such as of a free body on a floor; so
    /// are those below this fraction of the forces.
    const NEGLIGIBLE_STIFFNESS: f64 = 1e-13;
    let n = tangent.nrows();
    let size = |i: usize, j: usize| tangent[(i, j)].abs();
    // A coordinate that is coupled with a stiff one has at least this stiffness if all of the matrix is positive.
    let coupled = |i: usize, j: usize| size(i, j) * (size(i, j) / size(j, j)).min(1.0);
    let own = |i: usize| {
        let others = (0..n).filter(|&j| j != i && size(i, j) > 0.0);
        others.map(|j| coupled(i, j)).fold(size(i, i), f64::max)
    };
    let mut references = Vec::with_capacity(n);
    let whole = [n];
    for &part in if parts.is_empty() { &whole } else { parts } {
        let range = references.len()..references.len() + part;
        let is_coupled = |i: &usize| groups[range.clone()].contains(&groups[*i]);
        let others = (0..groups.len()).filter(is_coupled);
        let of_others = others.map(own).fold(0.0, f64::max);
        let largest = range.clone().map(own).fold(0.0, f64::max);
        let force = norm(&forces[range.clone()]);
        let rounding = NEGLIGIBLE_STIFFNESS * largest.max(force).max(of_others);
        let least = match (largest > rounding, force > 0.0, of_others > 0.0) {
            (true, ..) => largest,
            (false, true, _) => force,
            (false, false, true) => of_others,
            (false, false, false) => 1.0,
        };
        references.extend(range.map(|i| match (elastic[(i, i)], own(i)) {
            (elastic, _) if elastic > 0.0 => elastic,
            (_, own) if own > rounding => own,
            _ => least,
        }));
    }
    references
}

/// A number for each coordinate, the same for those of uncoupled parts that constraints couple in this shape. Empty without constraints.
pub(crate) fn groups(model: &mut dyn Static, q: &[f64]) -> Vec<usize> {
    let (constraints, parts) = (model.facts().constraints(), model.facts().parts.clone());
    if constraints == 0 || parts.is_empty() {
        return Vec::new();
    }
    let mut rows = Matrix::zeros(constraints, q.len());
    model.gap_jacobian(q, &mut rows);
    let mut groups: Vec<usize> =
        parts.iter().enumerate().flat_map(|(part, size)| std::iter::repeat_n(part, *size)).collect();
    for row in rows.row_iter() {
        let joined: Vec<usize> = (0..q.len()).filter(|&k| row[k] != 0.0).map(|k| groups[k]).collect();
        let Some(&first) = joined.iter().min() else { continue };
        groups.iter_mut().filter(|group| joined.contains(group)).for_each(|group| *group = first);
    }
    groups
}

/// Magnitudes of the generalised forces of weight and loads in any direction, times the sizes of coordinates, in joules.
pub(crate) fn work_of_loads(model: &mut dyn Static, q: &[f64], sizes: &[f64]) -> Vec<f64> {
    let [work, _] = work_and_constraint_loads(model, q, sizes);
    work
}

/// The same, and those of the constraint wrenches of joints under these loads.
pub(crate) fn work_and_constraint_loads(model: &mut dyn Static, q: &[f64], sizes: &[f64]) -> [Vec<f64>; 2] {
    let (mut turned, mut constraint_loads) = (Matrix::zeros(q.len(), 3), vec![0.0; q.len()]);
    model.turned_loads(q, &mut turned, &mut constraint_loads);
    let mut work: Vec<f64> = turned.row_iter().zip(sizes).map(|(row, size)| row.abs().sum() * size).collect();
    spread(&model.facts().rotation_vectors, &mut work);
    constraint_loads.iter_mut().zip(sizes).for_each(|(load, size)| *load *= size);
    [work, constraint_loads]
}

/// Magnitudes of the generalised forces of contacts and actuators times the sizes of coordinates, in joules.
pub(crate) fn work_of_interactions(model: &mut dyn Static, q: &[f64], sizes: &[f64]) -> Vec<f64> {
    let mut work = vec![0.0; q.len()];
    model.work_of_interactions(q, &mut work);
    work.iter_mut().zip(sizes).for_each(|(work, size)| *work *= size);
    spread(&model.facts().rotation_vectors, &mut work);
    work
}

/// Gives the three components of a rotation vector the same magnitude, because its axes are not physical axes of the joint.
fn spread(rotation_vectors: &[usize], work: &mut [f64]) {
    for &first in rotation_vectors {
        let most = work[first..first + 3].iter().copied().fold(0.0, f64::max);
        work[first..first + 3].fill(most);
    }
}

/// `S A S` with the sizes on the diagonal of S.
pub(crate) fn scaled(mut a: Matrix, sizes: &[f64]) -> Matrix {
    for k in 0..sizes.len() {
        for j in 0..sizes.len() {
            a[(j, k)] *= sizes[j] * sizes[k];
        }
    }
    a
}

/// Springs of a model in a shape, in coordinates divided by `sizes`; `None` for a model without springs.
pub(crate) fn linearised(model: &mut dyn Static, q: &[f64], sizes: &[f64]) -> Option<Springs> {
    let m = model.facts().springs;
    (m > 0).then(|| {
        let mut springs = Springs::new(m, q.len());
        model.linearise_springs(q, &mut springs);
        springs.scale(sizes);
        springs
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::description::rod::Segment;
    use crate::model::{Dynamics as _, Sprung as _};
    use crate::robot::effects::support::Support;
    use crate::robot::{RobotModel, Rod};

    /// A bent and twisted rod on two supports, one of them stiff.
    fn held_rod(stiffness: f64) -> (RobotModel, Vec<f64>) {
        let segment = Segment { modes: [2, 3, 3, 1, 1, 1], ..Segment::straight(0.7, 0.05, 1e6, 4e5, 1000.0) };
        let supports = vec![
            Support {
                at: Some(0.3),
                stiffness: [5.0, 20.0, 0.0],
                rotational_stiffness: [0.1, 2.0, 0.5],
                ..Support::at_tip()
            },
            Support {
                stiffness: [stiffness; 3],
                rotational_stiffness: [0.0, stiffness, stiffness],
                ..Support::at_tip()
            },
        ];
        let rod = Rod { supports, tip_force: [1.0, 2.0, 3.0], ..Rod::new(vec![segment]) };
        let model = RobotModel::of_rod(&rod).unwrap();
        let q = (0..model.facts().n).map(|i| 0.1 * (1.7 * i as f64).cos()).collect();
        (model, q)
    }

    /// Forces and tangent at fixed forces, combined with the springs, are those of the rod.
    #[test]
    fn held_forces_and_springs_are_the_whole() {
        let (mut model, q) = held_rod(300.0);
        let n = q.len();
        let rest = vec![0.0; n];
        let springs = linearised(&mut model, &q, &vec![1.0; n]).unwrap();
        let whole = |model: &mut RobotModel| {
            let (mut tau, mut tangent) = (vec![0.0; n], Matrix::zeros(n, n));
            model.inverse_dynamics(&q, &rest, &rest, &mut tau);
            model.weighted_tangent(&q, &rest, &rest, [1.0, 0.0, 0.0], &mut tangent);
            (tau, tangent)
        };
        let (tau, tangent) = whole(&mut model);
        model.hold_springs(Some(&springs.forces));
        let (held_tau, held_tangent) = whole(&mut model);
        model.hold_springs(None);
        let size = norm(&tau);
        assert!(tau.iter().zip(&held_tau).all(|(a, b)| (a - b).abs() < 1e-12 * size));
        let stiffness = &springs.root * springs.root.transpose() + &springs.rest;
        let together = held_tangent + springs.jacobian.tr_mul(&(stiffness * &springs.jacobian));
        assert!((&together - &tangent).norm() < 1e-9 * tangent.norm());
        assert_eq!(whole(&mut model).0, tau);
    }

    #[test]
    fn forces_change_as_they_say() {
        let (mut model, q) = held_rod(300.0);
        let n = q.len();
        let at = |model: &mut RobotModel, q: &[f64]| linearised(model, q, &vec![1.0; n]).unwrap();
        let springs = at(&mut model, &q);
        let dq: Vec<f64> = (0..n).map(|i| (0.9 * i as f64).sin()).collect();
        let moved = |h: f64| -> Vec<f64> { q.iter().zip(&dq).map(|(q, dq)| q + h * dq).collect() };
        const H: f64 = 1e-5;
        let (after, before) = (at(&mut model, &moved(H)), at(&mut model, &moved(-H)));
        let changes = springs.changes(&dq);
        // Moments also change by half of their turn; tangents contain this with the held moments.
        for i in (0..changes.len()).filter(|i| i % 6 >= 3) {
            let difference = (after.forces[i] - before.forces[i]) / (2.0 * H);
            assert!(
                (changes[i] - difference).abs() < 1e-6 * norm(&changes),
                "{i}: {} {difference}",
                changes[i]
            );
        }
        let work = (after.energy - before.energy) / (2.0 * H);
        let moved = &springs.jacobian * nalgebra::DVector::from_column_slice(&dq);
        let power: f64 = moved.iter().zip(&springs.forces).map(|(rate, force)| -rate * force).sum();
        assert!((work - power).abs() < 1e-6 * power.abs());
    }

    #[test]
    fn stiffness_is_one_in_normalised_coordinates() {
        for stiffness in [1.0, 1e8, 1e16] {
            let (mut model, q) = held_rod(stiffness);
            let sizes = vec![1.0; q.len()];
            let material = material(&mut model, &q, &sizes);
            let springs = linearised(&mut model, &q, &sizes).unwrap();
            let normalised = Normalised::new(&material, Some(&springs), Vec::new).unwrap();
            let one = normalised.matrix(&material) + &normalised.springs * normalised.springs.transpose();
            assert!((one - Matrix::identity(q.len(), q.len())).norm() < 1e-12);
            let basis = normalised.basis();
            let springs = basis.tr_mul(&springs.jacobian.transpose()) * &springs.root;
            assert!((springs - &normalised.springs).norm() < 1e-6);
        }
    }
}
