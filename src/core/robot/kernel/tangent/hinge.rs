//! Tangent of joints with one coordinate: columns without nodes.

use super::scope::Scope;
use crate::numerics::lie::{Scalar, Sweep};
use crate::robot::effects::joint_forces;
use crate::robot::kernel::hinge;
use crate::robot::plan::hinge::Hinge;
use crate::robot::state::tangent::{Coordinate, Rest, TangentWorkspace};
use crate::robot::turning::Turning;

/// Runs [`Scope::without_nodes`] as a separate call, because few robots need it.
pub(super) struct WithoutNodes<'a, G: Turning> {
    pub(super) scope: &'a Scope<'a, G>,
    pub(super) memory: &'a mut TangentWorkspace<G>,
    pub(super) rest: &'a Rest<G>,
    pub(super) is_carried: bool,
    pub(super) block: &'a mut [f64],
}

impl<G: Turning> Sweep for WithoutNodes<'_, G> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Self { scope, memory, rest, is_carried, block } = self;
        scope.without_nodes(memory, rest, is_carried, block);
    }
}

impl<G: Turning> Scope<'_, G> {
    /// Column, row and diagonal entry of a piece without nodes: a hinge, unless the piece is rigid.
    #[inline(always)]
    fn without_nodes(
        &self,
        memory: &mut TangentWorkspace<G>,
        rest: &Rest<G>,
        is_carried: bool,
        block: &mut [f64],
    ) {
        let &Self { piece, weights, work, .. } = self;
        let Some(hinge) = &piece.hinge else { return };
        let k = piece.first;
        if weights.is_mass_only {
            let shape = work.hinges[hinge.index];
            let mut coordinate = self.coordinate_of_mass(rest, shape);
            coordinate.before = coordinate.end;
            memory.coordinates[k] = coordinate;
        } else {
            self.column_of_hinge(memory, rest, hinge);
            if is_carried {
                self.row(memory, rest, k);
            }
        }
        let Coordinate { shape, end, .. } = memory.coordinates[k];
        block[0] = shape.dot(end);
        if let Some(forces) = &hinge.forces {
            // A mass matrix contains only the armature, whatever motion was computed last.
            let n = self.plan.n;
            let state =
                if weights.is_mass_only { [0.0; 2] } else { [work.motion_of[k], work.motion_of[n + k]] };
            block[0] += joint_forces::tangent(forces, state, [weights.q, weights.v, weights.a]);
        }
    }

    #[inline(always)]
    fn column_of_hinge(&self, memory: &mut TangentWorkspace<G>, rest: &Rest<G>, hinge: &Hinge<G>) {
        let &Self { piece, weights, work, .. } = self;
        let (shapes, load) = hinge::shapes(piece, hinge, work);
        let mut coordinate = self.coordinate(memory, rest, piece.first, shapes);
        coordinate.before = coordinate.end.add_scaled(load, f64::splat(-weights.q));
        memory.coordinates[piece.first] = coordinate;
    }
}
