//! The tangent of a robot as the matrix of a tree, which is evaluated and solved with in linear time.
//!
//! All that passes from one piece to others is a wrench towards the base and, towards the tips, Z, the angular part of
//! Y and, where a dead load asks for it, the turn of the material; where there are springs or a fluid, the whole of Y
//! and of the displacement (see `tangent`). In the inertial frame none of them changes on the way. What is attached inside
//! a piece sees its coordinates as they are there.

use crate::lie::{Geometry, Twist, Wrench};
use crate::linalg::TreeMatrix;
use crate::robot::plan::Plan;
use crate::robot::plan::tree::Carrying;
use crate::robot::state::tangent::TangentWorkspace;
use crate::robot::turning::Turning;

/// The zero matrix of a tangent's structure.
pub(crate) fn tangent<G: Turning>(plan: &Plan<G>) -> TreeMatrix {
    structured(plan, ranks(plan))
}

/// The zero matrix of a mass matrix's structure: accelerations alone pass to the tips.
pub(crate) fn mass<G: Turning>(plan: &Plan<G>) -> TreeMatrix {
    structured(plan, [G::COMPONENTS; 2])
}

/// How many numbers pass towards the base, and how many towards the tips.
pub(crate) fn ranks<G: Turning>(plan: &Plan<G>) -> [usize; 2] {
    let turn = if plan.has_dead_loads { G::ANGULAR } else { 0 };
    let lower = if plan.has_responses { 3 * G::COMPONENTS } else { G::COMPONENTS + G::ANGULAR + turn };
    [G::COMPONENTS, lower]
}

/// A block for every piece, and a place for every station that carries pieces.
fn structured<G: Turning>(plan: &Plan<G>, ranks: [usize; 2]) -> TreeMatrix {
    let sizes: Vec<_> = plan.pieces.iter().map(|piece| piece.n).collect();
    let hangs_at: Vec<_> = plan.pieces.iter().map(|piece| piece.joined.hangs_at).collect();
    let places: Vec<_> = plan.carrying.iter().map(|place| place.piece).collect();
    TreeMatrix::zeros(&sizes, &hangs_at, &places, ranks)
}

/// The blocks between different pieces, by their generators.
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
            // Symmetric: the rows of one half are the columns of the other.
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
        let coordinates = memory.seen_from(attached, own.clone());
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
            let shift = plan.has_responses.then(|| memory.shift_seen_from(attached, k));
            let linear = shift.map(|shift| [shift.y, shift.displacement]);
            write_rest::<G>([coordinate.y, coordinate.turn], linear, rest);
        }
    }
}

/// Writes what belongs to Y and to turns or displacements as far as it has a place: without dead loads there is none
/// for turns, and without springs and fluid none for the linear parts.
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
