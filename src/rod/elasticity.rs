//! What a rod answers to deformation alone: `K q`.

use super::plan::Plan;
use super::turning::Turning;
use crate::lie::Symmetric;
use crate::linalg::{Matrix, symmetric_eigen};
use crate::springs::Springs;

/// `K q`.
pub(super) fn forces<G: Turning>(plan: &Plan<G>, q: &[f64], tau: &mut [f64]) {
    for component in plan.segments.iter().flat_map(|segment| &segment.components) {
        let own = component.first..component.first + component.modes;
        let own_q = &q[own.clone()];
        for (j, tau) in tau[own].iter_mut().enumerate() {
            *tau = component.elastic_force(j, own_q, own_q, 0.0);
        }
    }
    for coupling in plan.segments.iter().flat_map(|segment| &segment.couplings) {
        coupling.add_elastic_force(q, q, 0.0, tau);
    }
}

/// `K`.
pub(super) fn stiffness<G: Turning>(plan: &Plan<G>, stiffness: &mut Matrix) {
    stiffness.fill(0.0);
    for component in plan.segments.iter().flat_map(|segment| &segment.components) {
        let (first, modes) = (component.first, component.modes);
        stiffness.view_mut((first, first), (modes, modes)).copy_from(&component.stiffness);
    }
    for coupling in plan.segments.iter().flat_map(|segment| &segment.couplings) {
        let [row, column] = coupling.first;
        let (rows, columns) = coupling.stiffness.shape();
        stiffness.view_mut((row, column), (rows, columns)).copy_from(&coupling.stiffness);
        stiffness.view_mut((column, row), (columns, rows)).copy_from(&coupling.stiffness.transpose());
    }
}

/// For every coordinate of curvature a radian over the rod's length, one for the others.
pub(super) fn typical_coordinates<G: Turning>(plan: &Plan<G>, sizes: &mut [f64]) {
    let length: f64 = plan.segments.iter().map(|segment| segment.length).sum();
    for component in plan.segments.iter().flat_map(|segment| &segment.components) {
        let size = if component.index < G::ANGULAR { 1.0 / length } else { 1.0 };
        sizes[component.first..component.first + component.modes].fill(size);
    }
}

/// Writes the stiffness of three forces, of which `first` is the first, as that of springs: its principal values above `firm` by their
/// roots, the others as the rest.
pub(super) fn write_roots(stiffness: &Symmetric<f64>, firm: [f64; 3], first: usize, springs: &mut Springs) {
    let rows = stiffness.rows().map(|row| row.to_array());
    let Some((values, axes)) = symmetric_eigen(&Matrix::from_fn(3, 3, |i, j| rows[i][j])) else { return };
    for (k, value) in values.into_iter().enumerate() {
        let is_firm = value > firm[k];
        for i in 0..3 {
            springs.root[(first + i, first + k)] = if is_firm { axes[(i, k)] * value.sqrt() } else { 0.0 };
            springs.inverse_root[(first + k, first + i)] =
                if is_firm { axes[(i, k)] / value.sqrt() } else { 0.0 };
        }
        for i in 0..3 {
            for j in 0..3 {
                let rest = &mut springs.rest[(first + i, first + j)];
                *rest = if k == 0 { 0.0 } else { *rest };
                if !is_firm {
                    *rest += axes[(i, k)] * value * axes[(j, k)];
                }
            }
        }
    }
}
