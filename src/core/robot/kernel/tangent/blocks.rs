//! Entries of the tangent: the block of one piece, and blocks between different pieces.

use super::scope::Scope;
use crate::numerics::lie::{Lanes, Scalar, Twist, VectorSpace, Wrench};
use crate::numerics::linalg::Matrix;
use crate::robot::plan::Plan;
use crate::robot::plan::joined::Relatives;
use crate::robot::state::tangent::{TangentWorkspace, Weights};
use crate::robot::turning::Turning;

/// Number of rows that are multiplied with a column at a time, so that the column is loaded only once.
const ROWS: usize = 4;

impl<G: Turning> Scope<'_, G> {
    /// Block of the piece: `Psi_j . H_end + int Psi_j . source`. For a mass matrix only the upper triangle is
    /// computed.
    #[inline(always)]
    pub(super) fn own_block(&self, memory: &TangentWorkspace<G>, block: &mut [f64], stride: usize) {
        let &Self { piece, weights, .. } = self;
        let (n, packs) = (piece.n, piece.packs);
        let own = &memory.coordinates[piece.first..][..n];
        for (k, column) in own.iter().enumerate() {
            let source = &memory.source[k * packs..][..packs];
            let rows = if weights.is_mass_only { k + 1 } else { n };
            let entries = &mut block[k * stride..][..rows];
            let mut psi = memory.psi.chunks_exact(ROWS * packs);
            let mut groups = entries.chunks_exact_mut(ROWS);
            for (entries, psi) in (&mut groups).zip(&mut psi) {
                entries.copy_from_slice(&products::<G, ROWS>(psi, source));
            }
            let first = rows / ROWS * ROWS;
            for (entry, psi) in
                groups.into_remainder().iter_mut().zip(memory.psi[first * packs..].chunks_exact(packs))
            {
                [*entry] = products::<G, 1>(psi, source);
            }
            for (entry, row) in entries.iter_mut().zip(own) {
                *entry += row.shape.dot(column.end);
            }
            if self.has_points {
                for (j, entry) in entries.iter_mut().enumerate() {
                    *entry += memory.points.entry(piece, j, k);
                }
            }
        }
        if weights.is_mass_only {
            for k in 0..n {
                for j in 0..k {
                    block[j * stride + k] = block[k * stride + j];
                }
            }
        }
    }
}

/// `int Psi_j . source` of several rows, whose Psi are stored consecutively.
#[inline(always)]
pub(in crate::robot::kernel) fn products<G: Turning, const ROWS: usize>(
    psi: &[Twist<G, G::Pack>],
    source: &[Wrench<G, G::Pack>],
) -> [f64; ROWS] {
    // Slices of equal length avoid bounds checks below.
    let packs = source.len();
    let rows: [_; ROWS] = std::array::from_fn(|row| &psi[row * packs..][..packs]);
    let mut sums = [G::Pack::splat(0.0); ROWS];
    for (pack, source) in source.iter().enumerate() {
        for (sum, psi) in sums.iter_mut().zip(&rows) {
            *sum = psi[pack].dot_add(*source, *sum);
        }
    }
    sums.map(Lanes::sum)
}

/// Blocks between different pieces.
#[inline(always)]
pub(super) fn others<G: Turning>(
    plan: &Plan<G>,
    memory: &TangentWorkspace<G>,
    weights: Weights,
    tangent: &mut Matrix,
) {
    for piece in &plan.pieces {
        let joined = &piece.joined;
        for k in piece.coordinates() {
            let column = &memory.coordinates[k];
            let mut entries = tangent.column_mut(k);
            let entries = entries.as_mut_slice();
            for Relatives { coordinates, attached } in &joined.ancestors {
                let rows = memory.relative_to(*attached, coordinates.clone());
                for (entry, row) in entries[coordinates.clone()].iter_mut().zip(rows) {
                    *entry = row.shape.dot(column.before);
                }
            }
            if weights.is_mass_only {
                for j in joined.ancestors.iter().flat_map(|relatives| relatives.coordinates.clone()) {
                    tangent[(k, j)] = tangent[(j, k)];
                }
                continue;
            }
            for Relatives { coordinates, attached } in &joined.descendants {
                let column = &memory.relative_to(*attached, k..k + 1)[0];
                let rows = &memory.coordinates[coordinates.clone()];
                for (entry, row) in entries[coordinates.clone()].iter_mut().zip(rows) {
                    *entry =
                        column.z.dot(row.row_z) + column.y.dot(row.row_y) + column.turn.dot(row.row_turn);
                }
            }
            if plan.has_responses {
                for Relatives { coordinates, attached } in &joined.descendants {
                    let column = memory.shift_relative_to(*attached, k);
                    let rows = &memory.shifts[coordinates.clone()];
                    for (entry, row) in entries[coordinates.clone()].iter_mut().zip(rows) {
                        *entry += column.y.dot(row.row_y) + column.displacement.dot(row.row_displacement);
                    }
                }
            }
        }
    }
}
