//! Rotations from the curvature: by Magnus steps in space, by sums in the plane.

pub(crate) mod columns;
pub(crate) mod place;
mod planar;
mod spatial;

use crate::description::rod::Gauss;
use crate::description::rod::piece::Piece;
use crate::numerics::lie::Geometry;
use crate::robot::plan::material::Component;
use crate::robot::plan::piece::PiecePlan;
use crate::robot::plan::space::{Passage, Space};

/// A geometry whose rotations can be computed from the curvature.
pub(crate) trait Turning: Space {
    /// Precomputes data for a piece with these nodes and components.
    fn constants(
        piece: &Piece,
        frame: Self::Frame,
        gauss: &Gauss,
        components: &[Component],
    ) -> Self::Constants;

    /// Rotations at the nodes of a piece that begins with `orientation`; returns the rotation at its end.
    fn turn(
        piece: &PiecePlan<Self>,
        q: &[f64],
        orientation: Self::Orientation,
        rotations: &mut [Self::Rotation<Self::Pack>],
    ) -> Self::Orientation;

    /// Precomputes the passage between two places of a piece, given as fractions of its length.
    fn passage(piece: &PiecePlan<Self>, from: f64, to: f64) -> Passage;

    /// Rotation along a passage.
    fn pass(piece: &PiecePlan<Self>, q: &[f64], passage: &Passage) -> Self::Rotation<f64>;
}

/// Largest number of modes of an angular strain.
fn angular_degrees<G: Geometry>(components: &[Component]) -> usize {
    components.iter().filter(|component| component.index < G::ANGULAR).map(|c| c.modes).max().unwrap_or(0)
}

/// Integrals of the basis between two places.
fn integrals_between(piece: &Piece, from: f64, to: f64, degrees: usize) -> Vec<f64> {
    let up_to = |x| {
        let mut values = vec![0.0; degrees];
        piece.basis.integrals(x, &mut values);
        values
    };
    up_to(to).into_iter().zip(up_to(from)).map(|(to, from)| to - from).collect()
}
