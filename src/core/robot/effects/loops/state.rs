//! State of closed loops.

use crate::numerics::lie::{Rotation, Vector};
use crate::robot::algebra::tie::{Frame, Motion};
use crate::robot::effects::loops::plan::Loops;

/// An end of a loop in the world, relative to the base.
#[derive(Clone, Copy, Debug)]
pub(crate) struct WorldEnd {
    pub(crate) frame: Frame,
    /// Velocity of its origin; its axes do not rotate.
    pub(crate) velocity: Vector<f64>,
}

impl WorldEnd {
    pub(crate) fn at_rest(frame: Frame) -> Self {
        Self { frame, velocity: Vector::zero() }
    }
}

/// State of closed loops.
#[derive(Clone, Debug)]
pub(crate) struct LoopState {
    /// For each tie, the frames of its ends, in space and the frame of the plan.
    pub(crate) frames: Vec<[Frame; 2]>,
    /// For each tie, its ends in the world; unused for other ends.
    pub(crate) world_ends: Vec<[WorldEnd; 2]>,
    /// Multipliers in `tau + G^T multipliers = 0`.
    pub(crate) multipliers: Vec<f64>,
    /// Which inextensible tendons are slack, and hence inactive.
    pub(crate) slack: Vec<bool>,
    /// Memory for the gaps.
    pub(crate) gaps: Vec<f64>,
}

impl LoopState {
    pub(crate) fn new<P>(loops: &Loops<P>) -> Self {
        let frame = Frame { position: Vector::zero(), axes: Rotation::identity() };
        Self {
            frames: vec![[frame; 2]; loops.ties.len()],
            world_ends: (loops.ties.iter())
                .map(|tie| tie.ends.each_ref().map(|end| WorldEnd::at_rest(end.frame)))
                .collect(),
            multipliers: vec![0.0; loops.rows],
            slack: vec![false; loops.lengths.len()],
            gaps: vec![0.0; loops.rows],
        }
    }
}

/// Memory for the derivatives of closed loops.
#[derive(Clone, Debug)]
pub(crate) struct LoopTangent {
    /// Displacements of the ends of all ties per unit coordinate, n entries each.
    pub(crate) moved: Vec<[Motion; 2]>,
    /// Coordinates for which `moved` is valid; initially none.
    pub(crate) moved_of: Vec<f64>,
    /// The same for the current tie, component by component: rotations and translations of the first end,
    /// then of the second.
    pub(crate) components: [Vec<f64>; COMPONENTS],
}

/// Three rotations and three translations, for both ends.
pub(crate) const COMPONENTS: usize = 12;

impl LoopTangent {
    pub(crate) fn new<P>(loops: &Loops<P>, n: usize) -> Self {
        let of_tie = if loops.ties.is_empty() { 0 } else { n };
        Self {
            moved: vec![[[Vector::zero(); 2]; 2]; loops.ties.len() * n],
            // NaN differs from all coordinates.
            moved_of: vec![f64::NAN; of_tie],
            components: std::array::from_fn(|_| vec![0.0; of_tie]),
        }
    }
}
