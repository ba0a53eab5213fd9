//! Elastic and damping forces of a rod: `K q + D qd`, with energy and dissipation.

use crate::model::springs::Springs;
use crate::numerics::lie::Symmetric;
use crate::numerics::linalg::{Matrix, symmetric_eigen};
use crate::robot::effects::joint_forces;
use crate::robot::plan::Plan;
use crate::robot::plan::piece::PiecePlan;
use crate::robot::turning::Turning;

/// `K q`, and forces of the springs and stops of joints.
pub(crate) fn forces<G: Turning>(plan: &Plan<G>, q: &[f64], tau: &mut [f64]) {
    for component in plan.pieces.iter().flat_map(|piece| &piece.components) {
        let own = component.first..component.first + component.modes;
        let own_q = &q[own.clone()];
        for (j, tau) in tau[own].iter_mut().enumerate() {
            *tau = component.elastic_force(j, own_q, own_q, 0.0);
        }
    }
    for coupling in plan.pieces.iter().flat_map(|piece| &piece.couplings) {
        coupling.add_elastic_force(q, q, 0.0, tau);
    }
    for piece in plan.pieces.iter().filter(|piece| piece.hinge.is_some()) {
        tau[piece.first] = 0.0;
    }
    for (k, forces) in joint_forces::all(plan) {
        tau[k] = joint_forces::at_rest(forces, q[k]);
    }
}

/// Derivative of [`forces`]: `K`, and the stiffness of joints on the diagonal.
pub(crate) fn stiffness<G: Turning>(plan: &Plan<G>, q: &[f64], stiffness: &mut Matrix) {
    stiffness.fill(0.0);
    for component in plan.pieces.iter().flat_map(|piece| &piece.components) {
        let (first, modes) = (component.first, component.modes);
        stiffness.view_mut((first, first), (modes, modes)).copy_from(&component.stiffness);
    }
    for coupling in plan.pieces.iter().flat_map(|piece| &piece.couplings) {
        let [row, column] = coupling.first;
        let (rows, columns) = coupling.stiffness.shape();
        stiffness.view_mut((row, column), (rows, columns)).copy_from(&coupling.stiffness);
        stiffness.view_mut((column, row), (columns, rows)).copy_from(&coupling.stiffness.transpose());
    }
    for (k, forces) in joint_forces::all(plan) {
        stiffness[(k, k)] = joint_forces::stiffness(forces, q[k]);
    }
}

/// Adds `w_q K + w_v D` to the block of a piece.
#[inline(always)]
pub(crate) fn add_to_tangent<G: Turning>(
    piece: &PiecePlan<G>,
    [w_q, w_v]: [f64; 2],
    block: &mut [f64],
    stride: usize,
) {
    let factor = w_q + w_v * piece.retardation_time;
    if factor == 0.0 {
        return;
    }
    for component in &piece.components {
        let first = component.first - piece.first;
        for k in 0..component.modes {
            let entries = &mut block[(first + k) * stride + first..][..component.modes];
            for (j, entry) in entries.iter_mut().enumerate() {
                *entry += factor * component.stiffness[(j, k)];
            }
        }
    }
    for coupling in &piece.couplings {
        let [rows, columns] = coupling.coordinates();
        for (j, row) in rows.map(|row| row - piece.first).enumerate() {
            for (k, column) in columns.clone().map(|column| column - piece.first).enumerate() {
                let stiffness = factor * coupling.stiffness[(j, k)];
                block[column * stride + row] += stiffness;
                block[row * stride + column] += stiffness;
            }
        }
    }
}

/// Elastic energy of the material, `q K q / 2`.
pub(crate) fn energy<G: Turning>(plan: &Plan<G>, q: &[f64]) -> f64 {
    0.5 * quadratic_form(plan, q, |_| 1.0)
}

/// Power of Kelvin-Voigt damping, `qd D qd`.
pub(crate) fn power_of_damping<G: Turning>(plan: &Plan<G>, qd: &[f64]) -> f64 {
    quadratic_form(plan, qd, |retardation_time| retardation_time)
}

/// `sum_pieces factor(mu) x K x`.
fn quadratic_form<G: Turning>(plan: &Plan<G>, x: &[f64], factor: impl Fn(f64) -> f64) -> f64 {
    let mut total = 0.0;
    for piece in &plan.pieces {
        let factor = factor(piece.retardation_time);
        for component in &piece.components {
            let x = &x[component.first..component.first + component.modes];
            for j in 0..component.modes {
                for k in 0..component.modes {
                    total += factor * x[j] * component.stiffness[(j, k)] * x[k];
                }
            }
        }
        for coupling in &piece.couplings {
            let [rows, columns] = coupling.coordinates();
            for (j, row) in rows.enumerate() {
                for (k, column) in columns.clone().enumerate() {
                    total += 2.0 * factor * x[row] * coupling.stiffness[(j, k)] * x[column];
                }
            }
        }
    }
    total
}

/// Typical sizes: for coordinates of curvature one radian over the total length of all rods, for
/// displacements the length of the robot, and one for other coordinates.
pub(crate) fn typical_coordinates<G: Turning>(plan: &Plan<G>, reach: f64, sizes: &mut [f64]) {
    for piece in plan.pieces.iter().filter(|piece| piece.is_joint) {
        let shifts = piece.hinge.as_ref().is_some_and(|hinge| !hinge.turns);
        sizes[piece.coordinates()].fill(if shifts { reach } else { 1.0 });
    }
    let rods = plan.pieces.iter().filter(|piece| !piece.is_joint);
    let length: f64 = rods.clone().map(|piece| piece.length).sum();
    for component in rods.flat_map(|piece| &piece.components) {
        let size = if component.index < G::ANGULAR { 1.0 / length } else { 1.0 };
        sizes[component.first..component.first + component.modes].fill(size);
    }
}

/// Whether each coordinate turns something; others only shift, such as those of sliders, stretches and shears.
pub(crate) fn turns<G: Turning>(plan: &Plan<G>) -> Vec<bool> {
    let mut turns = vec![false; plan.n];
    for piece in &plan.pieces {
        if piece.is_joint {
            turns[piece.coordinates()].fill(piece.hinge.as_ref().is_none_or(|hinge| hinge.turns));
            continue;
        }
        for component in piece.components.iter().filter(|component| component.index < G::ANGULAR) {
            turns[component.first..component.first + component.modes].fill(true);
        }
    }
    turns
}

/// Writes the stiffness of the three forces starting at index `first` as springs: principal values above
/// `firm` by their square roots, the others as the rest.
pub(crate) fn write_roots(stiffness: &Symmetric<f64>, firm: [f64; 3], first: usize, springs: &mut Springs) {
    let rows = stiffness.rows().map(|row| row.to_array());
    let Some((values, axes)) = symmetric_eigen(&Matrix::from_fn(3, 3, |i, j| rows[i][j])) else { return };
    for (k, value) in values.into_iter().enumerate() {
        let is_far_from_singular = value > firm[k];
        for i in 0..3 {
            springs.root[(first + i, first + k)] =
                if is_far_from_singular { axes[(i, k)] * value.sqrt() } else { 0.0 };
            springs.inverse_root[(first + k, first + i)] =
                if is_far_from_singular { axes[(i, k)] / value.sqrt() } else { 0.0 };
        }
        for i in 0..3 {
            for j in 0..3 {
                let rest = &mut springs.rest[(first + i, first + j)];
                *rest = if k == 0 { 0.0 } else { *rest };
                if !is_far_from_singular {
                    *rest += axes[(i, k)] * value * axes[(j, k)];
                }
            }
        }
    }
}
