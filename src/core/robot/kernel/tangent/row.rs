//! Rows of the tangent: factors of a coordinate in the columns of other pieces.

use super::responses;
use super::scope::Scope;
use crate::numerics::lie::{Lanes, VectorSpace, Wrench};
use crate::robot::state::tangent::{Rest, Row, TangentWorkspace};
use crate::robot::turning::Turning;

impl<G: Turning> Scope<'_, G> {
    /// Factors of coordinate `j` in the columns of preceding pieces: the transposes of `N Z + C Y` and of the
    /// dead loads, summed over everything that its S moves.
    #[inline(always)]
    pub(super) fn row(&self, memory: &mut TangentWorkspace<G>, rest: &Rest<G>, j: usize) {
        let &Self { plan, piece, weights, .. } = self;
        let psi = &memory.psi[(j - piece.first) * piece.packs..][..piece.packs];
        let coordinate = &mut memory.coordinates[j];
        let shape = coordinate.shape;
        let mut row_z = Wrench::<G, G::Pack>::zero();
        for (psi, inertia) in psi.iter().zip(&memory.inertia) {
            row_z += inertia.momentum(*psi);
        }
        coordinate.row_z = row_z.sum() + rest.inertia.momentum(shape);
        if self.has_points {
            memory.points.row(piece, weights, j - piece.first, coordinate);
            if plan.has_responses {
                let mut row = Row { coordinate, shift: &mut memory.shifts[j] };
                memory.points.answer(piece, j - piece.first, &mut row);
            }
        }
        let mut row_y = G::Axial::<G::Pack>::zero();
        for (psi, gyroscope) in psi.iter().zip(&memory.gyroscope) {
            row_y += gyroscope.transposed_times(*psi);
        }
        coordinate.row_y +=
            G::map_axial(&row_y, |pack: &G::Pack| pack.sum()) + rest.gyroscope.transposed_times(shape);
        if plan.has_responses {
            let mut row = Row { coordinate, shift: &mut memory.shifts[j] };
            row.answer(&rest.response, shape);
            if self.has_responses {
                let responses = &memory.response[..piece.packs];
                plan.instructions.run_outlined::<G::Pack, _>(responses::AddRow { responses, psi, row });
            }
        }
        if plan.has_dead_loads {
            let coordinate = &mut memory.coordinates[j];
            coordinate.row_turn += rest.dead.transposed_times(shape);
            if self.has_dead {
                for (psi, dead) in psi.iter().zip(&memory.dead) {
                    coordinate.row_turn +=
                        G::map_axial(&dead.transposed_times(*psi), |pack: &G::Pack| pack.sum());
                }
            }
        }
    }
}
