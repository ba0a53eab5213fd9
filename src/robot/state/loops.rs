//! Closed loops in a state.

use crate::lie::{Rotation, Vector};
use crate::robot::algebra::tie::{Frame, Motion};
use crate::robot::plan::loops::Loops;

/// An end of a loop in the world, seen from the base.
#[derive(Clone, Copy, Debug)]
pub(crate) struct WorldEnd {
    pub(crate) frame: Frame,
    /// Of its origin. Its axes do not turn.
    pub(crate) velocity: Vector<f64>,
}

impl WorldEnd {
    pub(crate) fn at_rest(frame: Frame) -> Self {
        Self { frame, velocity: Vector::zero() }
    }
}

/// Closed loops in a state.
#[derive(Clone, Debug)]
pub(crate) struct LoopState {
    /// Per tie, the frames of its ends, in space and the frame of the plan.
    pub(crate) frames: Vec<[Frame; 2]>,
    /// Per tie, its ends that are in the world; of others there is nothing to know.
    pub(crate) world_ends: Vec<[WorldEnd; 2]>,
    /// What the rows answer: `tau + G^T multipliers = 0`.
    pub(crate) multipliers: Vec<f64>,
    /// Which tendons that do not stretch are slack, and hold nothing.
    pub(crate) slack: Vec<bool>,
    /// Memory for how far they are from being held.
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
    /// How the ends of all ties move with the coordinates, n entries each.
    pub(crate) moved: Vec<[Motion; 2]>,
    /// The coordinates for which that is known; of no state at first.
    pub(crate) moved_of: Vec<f64>,
    /// The same of the tie at hand, component by component: turns and shifts of the first end, then of the second.
    pub(crate) components: [Vec<f64>; COMPONENTS],
}

/// Three of a turn and three of a shift, of both ends.
pub(crate) const COMPONENTS: usize = 12;

impl LoopTangent {
    pub(crate) fn new<P>(loops: &Loops<P>, n: usize) -> Self {
        let of_tie = if loops.ties.is_empty() { 0 } else { n };
        Self {
            moved: vec![[[Vector::zero(); 2]; 2]; loops.ties.len() * n],
            // NaN equals nothing.
            moved_of: vec![f64::NAN; of_tie],
            components: std::array::from_fn(|_| vec![0.0; of_tie]),
        }
    }
}
