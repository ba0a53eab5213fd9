//! Closed loops, compiled: constraints `g(q) = 0` between two frames, row by row.

use crate::model::Holder;
use crate::robot::algebra::tie::{Frame, Row};

/// The closed loops of a plan.
#[derive(Clone, Debug)]
pub(crate) struct Loops<P> {
    /// Between two places, with their rows in a row.
    pub(crate) ties: Vec<TiePlan<P>>,
    /// Between two coordinates, behind these.
    pub(crate) gears: Vec<Gear>,
    /// Tendons that do not stretch, by their places among the actuators; behind these. They hold one way only: their gaps
    /// are not above zero.
    pub(crate) lengths: Vec<usize>,
    /// Number of rows of all together.
    pub(crate) rows: usize,
    /// What each row is of.
    pub(crate) held_by: Vec<Holder>,
}

impl<P> Loops<P> {
    pub(crate) fn none() -> Self {
        Self { ties: Vec::new(), gears: Vec::new(), lengths: Vec::new(), rows: 0, held_by: Vec::new() }
    }

    /// The first row of a tendon.
    pub(crate) fn first_length(&self) -> usize {
        self.rows - self.lengths.len()
    }

    /// The first row of a gear.
    pub(crate) fn first_gear(&self) -> usize {
        self.first_length() - self.gears.len()
    }
}

/// A loop between two places.
#[derive(Clone, Debug)]
pub(crate) struct TiePlan<P> {
    /// Its place among all ties.
    pub(crate) number: usize,
    pub(crate) ends: [TieEnd<P>; 2],
    pub(crate) rows: Vec<Row>,
    /// The first of its rows among all.
    pub(crate) first: usize,
    /// The coordinates that move any of its ends, in ascending order.
    pub(crate) reaches: Vec<usize>,
}

/// An end of a loop.
#[derive(Clone, Debug)]
pub(crate) struct TieEnd<P> {
    /// Its frame: beside the section or body in the axes there; in the world, in the frame of the base at rest.
    pub(crate) frame: Frame,
    /// The point of the plan that it is on, and the pieces that move that, each with the weights of the integral up to it;
    /// none in the world.
    pub(crate) on: Option<On<P>>,
}

#[derive(Clone, Debug)]
pub(crate) struct On<P> {
    pub(crate) point: usize,
    pub(crate) moved_by: Vec<(usize, Vec<P>)>,
}

/// A coordinate that is a multiple of another one plus an offset, by their places among all.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Gear {
    pub(crate) coordinates: [usize; 2],
    pub(crate) ratio: f64,
    pub(crate) offset: f64,
}
