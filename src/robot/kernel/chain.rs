//! The tangent of a long rod as the matrix of a chain, which is evaluated and solved with in linear time.
//!
//! All that passes from one piece to others is a wrench towards the base and, towards the tip, Z, the angular part of
//! Y and, where a dead load asks for it, the turn of the material; where there are springs or a fluid, the whole of Y
//! and of the displacement (see `tangent`). In the inertial frame none of them changes on the way.

use crate::lie::{Geometry, Twist, Wrench};
use crate::linalg::ChainMatrix;
use crate::robot::plan::Plan;
use crate::robot::state::tangent::{Coordinate, Shift};
use crate::robot::turning::Turning;

/// The zero matrix of a tangent's structure.
pub(crate) fn tangent<G: Turning>(plan: &Plan<G>) -> ChainMatrix {
    let [upper, lower] = ranks(plan);
    ChainMatrix::zeros(&sizes(plan), upper, lower)
}

/// The zero matrix of a mass matrix's structure: accelerations alone pass to the tip.
pub(crate) fn mass<G: Turning>(plan: &Plan<G>) -> ChainMatrix {
    ChainMatrix::zeros(&sizes(plan), G::COMPONENTS, G::COMPONENTS)
}

/// How many numbers pass towards the base, and how many towards the tip.
pub(crate) fn ranks<G: Turning>(plan: &Plan<G>) -> [usize; 2] {
    let turn = if plan.has_dead_loads { G::ANGULAR } else { 0 };
    let lower = if plan.has_responses { 3 * G::COMPONENTS } else { G::COMPONENTS + G::ANGULAR + turn };
    [G::COMPONENTS, lower]
}

fn sizes<G: Turning>(plan: &Plan<G>) -> Vec<usize> {
    plan.pieces.iter().map(|piece| piece.n).collect()
}

/// The blocks between different pieces, by their generators.
#[inline(always)]
pub(crate) fn generate<G: Geometry>(
    coordinates: &[Coordinate<G>],
    shifts: &[Shift<G>],
    is_mass_only: bool,
    matrix: &mut ChainMatrix,
) {
    let (wrench, rank) = (matrix.upper.rows.nrows(), matrix.lower.rows.nrows());
    assert!(wrench == G::COMPONENTS && rank >= G::COMPONENTS, "the structure of a rod's tangent");
    let ChainMatrix { upper, lower, .. } = matrix;
    let upper = upper
        .rows
        .as_mut_slice()
        .chunks_exact_mut(wrench)
        .zip(upper.columns.as_mut_slice().chunks_exact_mut(wrench));
    let lower = lower
        .rows
        .as_mut_slice()
        .chunks_exact_mut(rank)
        .zip(lower.columns.as_mut_slice().chunks_exact_mut(rank));
    for (k, (coordinate, ((upper_row, upper_column), (lower_row, lower_column)))) in
        coordinates.iter().zip(upper.zip(lower)).enumerate()
    {
        write_twist(coordinate.shape, upper_row);
        write_wrench(coordinate.before, upper_column);
        let (row_z, row) = lower_row.split_at_mut(G::COMPONENTS);
        let (z, column) = lower_column.split_at_mut(G::COMPONENTS);
        if is_mass_only {
            // Symmetric: the rows of one half are the columns of the other.
            write_wrench(coordinate.before, row_z);
            write_twist(coordinate.shape, z);
            row.fill(0.0);
            column.fill(0.0);
            continue;
        }
        write_wrench(coordinate.row_z, row_z);
        write_twist(coordinate.z, z);
        // A rod without dead loads has no place for what is zero there.
        let parts = [(coordinate.row_y, coordinate.y), (coordinate.row_turn, coordinate.turn)];
        let (row, row_linear) = row.split_at_mut(row.len().min(2 * G::ANGULAR));
        let (column, column_linear) = column.split_at_mut(row.len());
        let places = row.chunks_exact_mut(G::ANGULAR).zip(column.chunks_exact_mut(G::ANGULAR));
        for ((from_row, from_column), (row, column)) in parts.into_iter().zip(places) {
            write_axial::<G>(from_row, row);
            write_axial::<G>(from_column, column);
        }
        // Nor does one without springs and fluid.
        let Some(shift) = shifts.get(k) else { continue };
        let parts = [(shift.row_y, shift.y), (shift.row_displacement, shift.displacement)];
        let linear = G::COMPONENTS - G::ANGULAR;
        let places = row_linear.chunks_exact_mut(linear).zip(column_linear.chunks_exact_mut(linear));
        for ((from_row, from_column), (row, column)) in parts.into_iter().zip(places) {
            write_vector::<G>(from_row, row);
            write_vector::<G>(from_column, column);
        }
    }
}

#[inline(always)]
fn write_twist<G: Geometry>(mut twist: Twist<G, f64>, to: &mut [f64]) {
    for (index, entry) in to.iter_mut().enumerate() {
        *entry = *twist.component_mut(index);
    }
}

#[inline(always)]
fn write_wrench<G: Geometry>(mut wrench: Wrench<G, f64>, to: &mut [f64]) {
    for (index, entry) in to.iter_mut().enumerate() {
        *entry = *wrench.component_mut(index);
    }
}

#[inline(always)]
fn write_axial<G: Geometry>(mut axial: G::Axial<f64>, to: &mut [f64]) {
    for (index, entry) in to.iter_mut().enumerate() {
        *entry = *G::axial_component(&mut axial, index);
    }
}

#[inline(always)]
fn write_vector<G: Geometry>(mut vector: G::Vector<f64>, to: &mut [f64]) {
    for (index, entry) in to.iter_mut().enumerate() {
        *entry = *G::vector_component(&mut vector, index);
    }
}
