//! Compiled closed loops: constraints `g(q) = 0` between two frames, row by row.

use crate::model::Constraint;
use crate::numerics::lie::Vector;
use crate::robot::algebra::tie::{Frame, Row};

/// Closed loops of a plan.
#[derive(Clone, Debug, Default)]
pub(crate) struct Loops<P> {
    /// Loops between two places, with consecutive rows.
    pub(crate) ties: Vec<TiePlan<P>>,
    /// Loops between two coordinates, whose rows follow those of ties.
    pub(crate) gears: Vec<Gear>,
    /// Inextensible tendons, by their indices among the actuators; their rows follow. They are one-sided:
    /// gaps are not positive.
    pub(crate) lengths: Vec<usize>,
    /// Total number of rows.
    pub(crate) rows: usize,
    /// The constraint to which each row belongs.
    pub(crate) constraints: Vec<Constraint>,
}

impl<P> Loops<P> {
    /// Index of the first row of tendons.
    pub(crate) fn first_length(&self) -> usize {
        self.rows - self.lengths.len()
    }

    /// Index of the first row of gears.
    pub(crate) fn first_gear(&self) -> usize {
        self.first_length() - self.gears.len()
    }

    /// Whether the gap of a row is a length.
    pub(crate) fn is_length(&self, row: usize) -> bool {
        let of_tie = self.ties.iter().find_map(|tie| tie.rows.get(row.checked_sub(tie.first)?));
        match of_tie {
            Some(of_tie) => !matches!(of_tie, Row::Angle { .. }),
            None => row >= self.first_length(),
        }
    }
}

/// A loop between two places.
#[derive(Clone, Debug)]
pub(crate) struct TiePlan<P> {
    /// Index among all ties.
    pub(crate) number: usize,
    pub(crate) ends: [TieEnd<P>; 2],
    pub(crate) rows: Vec<Row>,
    /// Directions that both frames share. Differences of cosines also vanish where they are opposite.
    pub(crate) shared: Vec<Vector<f64>>,
    /// Index of its first row.
    pub(crate) first: usize,
    /// Coordinates that move either end, in ascending order.
    pub(crate) reaches: Vec<usize>,
}

/// An end of a loop.
#[derive(Clone, Debug)]
pub(crate) struct TieEnd<P> {
    /// Frame of the end: relative to the section or body, in its axes; in the world, in the frame of the base
    /// at rest.
    pub(crate) frame: Frame,
    /// Point of the plan that carries the end, and the pieces that move this point, each with the weights of
    /// the integral up to it; `None` in the world.
    pub(crate) on: Option<On<P>>,
}

#[derive(Clone, Debug)]
pub(crate) struct On<P> {
    pub(crate) point: usize,
    pub(crate) moved_by: Vec<(usize, Vec<P>)>,
}

/// A coordinate that is a multiple of another one plus an offset, by their indices among all.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Gear {
    pub(crate) coordinates: [usize; 2],
    pub(crate) ratio: f64,
    pub(crate) offset: f64,
}
