//! What a rod is computed by, and how its linear systems are solved.

use super::description::Rod;
use crate::lie::{Plane, Quaternion};
use crate::rod::{STRAIGHT, piece};

/// What a rod is computed by.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kernel {
    /// Rotations about one axis: a rod whose modes and reference strains stay in one plane.
    Planar,
    /// Any rod.
    Spatial,
}

impl Kernel {
    /// The plane that a rod cannot leave, if there is one: that of the modes, unless the base may leave it. Loads out
    /// of the plane do not move the rod, wherever gravity points.
    pub(crate) fn plane(rod: &Rod) -> Option<Plane> {
        let stays_in = |plane: &Plane| {
            let is_inside = |strain: usize| match strain {
                0..3 => strain == plane.normal,
                _ => plane.axes.contains(&(strain - 3)),
            };
            rod.segments.iter().all(|segment| {
                (0..STRAIGHT.len()).filter(|&strain| !is_inside(strain)).all(|strain| {
                    segment.modes[strain] == 0
                        && segment.reference_strain.is_entry_constant(strain) == Some(STRAIGHT[strain])
                })
            })
        };
        let base = Quaternion::from_array(rod.base_orientation).rotation();
        let base_stays_in = |plane: &Plane| {
            rod.base_motion.as_ref().is_none_or(|motion| motion.stays_across(base.axis(plane.normal)))
        };
        [Plane::ABOUT_Y, Plane::ABOUT_Z].into_iter().filter(stays_in).find(base_stays_in)
    }
}

/// How a rod's linear systems, of the Newton iteration and of the forward dynamics, are solved.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Solve {
    /// With all entries of the matrix; cost n^3.
    Dense,
    /// By sweeps along the segments ([`crate::linalg::ChainLu`]); cost linear in their number.
    Chain,
}

impl Solve {
    /// The cheaper one for a rod.
    pub(crate) fn cheapest(rod: &Rod) -> Self {
        let segments: usize = rod.segments.iter().map(piece::number).sum();
        let is_long = segments >= SEGMENTS_OF_A_CHAIN && rod.coordinates() >= COORDINATES_OF_A_CHAIN;
        if is_long { Self::Chain } else { Self::Dense }
    }
}

/// From that many coordinates and segments on a chain's solve is cheaper. Instructions of residual, tangent,
/// factorisation and solve as a chain, relative to the dense ones (callgrind, x86-64, 2026), for segments of so many
/// coordinates:
///
/// | coordinates a segment | relative instructions at so many segments (coordinates) |
/// |---|---|
/// | 1, planar | 1.03 at 8 (8), 1.00 at 12 (12), 0.97 at 16 (16) |
/// | 2, planar | 1.02 at 4 (8), 0.98 at 6 (12), 0.94 at 8 (16), 0.86 at 12 (24) |
/// | 2, spatial | 1.04 at 6 (12), 1.02 at 8 (16), 0.98 at 10 (20) |
/// | 4, spatial | 1.05 at 3 (12), 1.02 at 4 (16), 0.98 at 5 (20), 0.97 at 6 (24) |
/// | 6, spatial | 1.05 at 2 (12), 0.99 at 3 (18), 0.98 at 4 (24) |
/// | 12, spatial | 1.00 at 2 (24) |
/// | 18, spatial | 0.99 at 2 (36), 0.94 at 3 (54) |
pub(crate) const COORDINATES_OF_A_CHAIN: usize = 20;

pub(crate) const SEGMENTS_OF_A_CHAIN: usize = 3;
