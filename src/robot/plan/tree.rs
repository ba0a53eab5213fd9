//! How the pieces of a plan hang together: each begins where another one ends, or at the frame.

use std::ops::Range;

use super::space::Space;

/// Where a piece begins and ends. Stations are counted from the frame, which is the first one.
#[derive(Clone, Debug)]
pub(crate) struct Joined<G: Space> {
    /// The station where it begins.
    pub(crate) begin: usize,
    /// The station where it ends.
    pub(crate) end: usize,
    /// What fixes the first station to another one, where it is not that one itself.
    pub(crate) weld: Option<Weld<G>>,
    /// The coordinates of the pieces that carry it, and of those that it carries; neighbours together.
    pub(crate) ancestors: Vec<Range<usize>>,
    pub(crate) descendants: Vec<Range<usize>>,
}

/// A station fixed to another one.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Weld<G: Space> {
    /// The other one.
    pub(crate) to: usize,
    /// How it is turned and where it lies, in the axes of the other one.
    pub(crate) orientation: G::Orientation,
    pub(crate) position: G::Vector<f64>,
}

impl<G: Space> Joined<G> {
    /// Of piece `s` of a chain: it begins where the one before ends.
    pub(crate) fn in_chain(s: usize) -> Self {
        Self { begin: s, end: s + 1, weld: None, ancestors: Vec::new(), descendants: Vec::new() }
    }

    /// The station that carries it.
    #[inline(always)]
    pub(crate) fn carrier(&self) -> usize {
        self.weld.as_ref().map_or(self.begin, |weld| weld.to)
    }
}

/// Adds a range behind others, to the last one where it goes on.
pub(crate) fn extend(ranges: &mut Vec<Range<usize>>, range: Range<usize>) {
    match ranges.last_mut() {
        Some(last) if last.end == range.start => last.end = range.end,
        _ => ranges.push(range),
    }
}
