//! What is known of closed loops in a state.

use crate::lie::{Rotation, Vector};
use crate::robot::algebra::tie::{Frame, Motion};
use crate::robot::plan::loops::Loops;

/// What is known of closed loops.
#[derive(Clone, Debug)]
pub(crate) struct LoopState {
    /// Per tie, the frames of its ends, in space and the frame of the plan.
    pub(crate) frames: Vec<[Frame; 2]>,
    /// What the rows answer: `tau + G^T multipliers = 0`.
    pub(crate) multipliers: Vec<f64>,
    /// Memory for how far they are from being held.
    pub(crate) gaps: Vec<f64>,
}

impl LoopState {
    pub(crate) fn new<P>(loops: &Loops<P>) -> Self {
        let frame = Frame { position: Vector::zero(), axes: Rotation::identity() };
        Self {
            frames: vec![[frame; 2]; loops.ties.len()],
            multipliers: vec![0.0; loops.rows],
            gaps: vec![0.0; loops.rows],
        }
    }
}

/// How the ends of all ties move with the coordinates, n entries each.
#[derive(Clone, Debug)]
pub(crate) struct LoopTangent {
    pub(crate) moved: Vec<[Motion; 2]>,
}

impl LoopTangent {
    pub(crate) fn new<P>(loops: &Loops<P>, n: usize) -> Self {
        Self { moved: vec![[[Vector::zero(); 2]; 2]; loops.ties.len() * n] }
    }
}
