//! How a piece is joined to others.

use std::ops::Range;

use super::space::Space;

/// Stations at which a piece begins and ends. The frame is station zero.
#[derive(Clone, Debug)]
pub(crate) struct Joined<G: Space> {
    /// Station at its beginning.
    pub(crate) begin: usize,
    /// Station at its end.
    pub(crate) end: usize,
    /// Weld of its first station to another station, if they differ.
    pub(crate) weld: Option<Weld<G>>,
    /// Index of the place that carries it in [`Plan::carrying`](super::Plan::carrying); `None` is the frame.
    pub(crate) hangs_at: Option<usize>,
    /// Whether a joint or a weld starts at its end.
    pub(crate) ends_at_joint: bool,
    /// Whether pieces with nodes follow its end, which need the orientation there.
    pub(crate) is_followed_by_nodes: bool,
    /// Coordinates of the pieces that carry it, and of those that it carries, merged into ranges.
    pub(crate) ancestors: Vec<Relatives>,
    pub(crate) descendants: Vec<Relatives>,
}

/// Coordinates of pieces that carry a piece, or that it carries.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Relatives {
    pub(crate) coordinates: Range<usize>,
    /// Index of the place inside the piece at which the next one is attached; `None` is its end.
    pub(crate) attached: Option<usize>,
}

/// A station welded to another one.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Weld<G: Space> {
    /// The other station.
    pub(crate) to: usize,
    /// Relative orientation and position, in the axes of the other station.
    pub(crate) orientation: G::Orientation,
    pub(crate) rotation: G::Rotation<f64>,
    pub(crate) position: G::Vector<f64>,
    /// Whether the orientations differ.
    pub(crate) turns: bool,
}

impl<G: Space> Joined<G> {
    /// A piece between two stations without a weld.
    pub(crate) fn between(begin: usize, end: usize) -> Self {
        Self {
            begin,
            end,
            weld: None,
            hangs_at: None,
            ends_at_joint: false,
            is_followed_by_nodes: false,
            ancestors: Vec::new(),
            descendants: Vec::new(),
        }
    }

    /// The station that carries the piece.
    #[inline(always)]
    pub(crate) fn carrier(&self) -> usize {
        self.weld.as_ref().map_or(self.begin, |weld| weld.to)
    }
}
