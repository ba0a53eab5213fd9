//! Tangent of a robot as a tree matrix, for evaluation and solution in linear time.
//!
//! Only a wrench is transmitted from piece to piece towards the base, and towards the tips only Z, the
//! angular part of Y and, with dead loads, the rotation of the material; with springs or a fluid, all
//! components of Y and of the displacement (see `tangent`). In the inertial frame these quantities do not
//! change on the way. Pieces attached inside another piece use the values of its coordinates at that point.

use crate::numerics::lie::{Geometry, Twist, Wrench};
use crate::numerics::linalg::TreeMatrix;
use crate::robot::plan::Plan;
use crate::robot::plan::tree::Carrying;
use crate::robot::state::tangent::TangentWorkspace;
use crate::robot::turning::Turning;

/// Zero matrix with the structure of a tangent.
pub(crate) fn tangent<G: Turning>(plan: &Plan<G>) -> TreeMatrix {
    structured(plan, ranks(plan))
}

/// Zero matrix with the structure of a mass matrix: only accelerations are transmitted to the tips.
pub(crate) fn mass<G: Turning>(plan: &Plan<G>) -> TreeMatrix {
    structured(plan, [G::COMPONENTS; 2])
}

/// Numbers of quantities transmitted towards the base and towards the tips.
pub(crate) fn ranks<G: Turning>(plan: &Plan<G>) -> [usize; 2] {
    let turn = if plan.has_dead_loads { G::ANGULAR } else { 0 };
    let lower = if plan.has_responses { 3 * G::COMPONENTS } else { G::COMPONENTS + G::ANGULAR + turn };
    [G::COMPONENTS, lower]
}

/// One block per piece, and one place per station that carries pieces.
fn structured<G: Turning>(plan: &Plan<G>, ranks: [usize; 2]) -> TreeMatrix {
    let sizes: Vec<_> = plan.pieces.iter().map(|piece| piece.n).collect();
    let hangs_at: Vec<_> = plan.pieces.iter().map(|piece| piece.joined.hangs_at).collect();
    let places: Vec<_> = plan.carrying.iter().map(|place| place.piece).collect();
    TreeMatrix::zeros(&sizes, &hangs_at, &places, ranks)
}

/// Blocks between different pieces, by their generators.
#[inline(always)]
pub(crate) fn generate<G: Turning>(
    plan: &Plan<G>,
    memory: &TangentWorkspace<G>,
    is_mass_only: bool,
    matrix: &mut TreeMatrix,
) {
    let [upper, lower] = matrix.ranks();
    assert!(upper == G::COMPONENTS && lower >= G::COMPONENTS, "the structure of a robot's tangent");
    let TreeMatrix { carried, carrying, .. } = matrix;
    let rows = carried.rows.as_mut_slice().chunks_exact_mut(lower);
    let columns = carried.columns.as_mut_slice().chunks_exact_mut(upper);
    for (k, (coordinate, (row, column))) in memory.coordinates.iter().zip(rows.zip(columns)).enumerate() {
        write_wrench(coordinate.before, column);
        let (row_z, rest) = row.split_at_mut(G::COMPONENTS);
        if is_mass_only {
            // By symmetry, the rows of one half are the columns of the other.
            write_wrench(coordinate.before, row_z);
            rest.fill(0.0);
            continue;
        }
        write_wrench(coordinate.row_z, row_z);
        let linear = memory.shifts.get(k).map(|shift| [shift.row_y, shift.row_displacement]);
        write_rest::<G>([coordinate.row_y, coordinate.row_turn], linear, rest);
    }
    let mut rows = carrying.rows.as_mut_slice().chunks_exact_mut(upper);
    let mut columns = carrying.columns.as_mut_slice().chunks_exact_mut(lower);
    for &Carrying { piece, attached } in &plan.carrying {
        let own = plan.pieces[piece].coordinates();
        let coordinates = memory.relative_to(attached, own.clone());
        for ((k, coordinate), (row, column)) in own.zip(coordinates).zip(rows.by_ref().zip(columns.by_ref()))
        {
            write_twist(coordinate.shape, row);
            let (z, rest) = column.split_at_mut(G::COMPONENTS);
            if is_mass_only {
                write_twist(coordinate.shape, z);
                rest.fill(0.0);
                continue;
            }
            write_twist(coordinate.z, z);
            let shift = plan.has_responses.then(|| memory.shift_relative_to(attached, k));
            let linear = shift.map(|shift| [shift.y, shift.displacement]);
            write_rest::<G>([coordinate.y, coordinate.turn], linear, rest);
        }
    }
}

/// Writes the values for Y and for rotations or displacements as far as they are present: rotations only with
/// dead loads, linear parts only with springs or fluid.
#[inline(always)]
fn write_rest<G: Geometry>(angular: [G::Axial<f64>; 2], linear: Option<[G::Vector<f64>; 2]>, to: &mut [f64]) {
    let (to, to_linear) = to.split_at_mut(to.len().min(2 * G::ANGULAR));
    for (from, to) in angular.into_iter().zip(to.chunks_exact_mut(G::ANGULAR)) {
        write_axial::<G>(from, to);
    }
    let places = to_linear.chunks_exact_mut(G::COMPONENTS - G::ANGULAR);
    for (from, to) in linear.into_iter().flatten().zip(places) {
        write_vector::<G>(from, to);
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
