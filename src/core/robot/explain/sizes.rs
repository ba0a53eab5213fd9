//! Widths of rods for questions about them.

use crate::description::rod::Segment;

/// Parts of a segment between the places where its section is looked at.
pub(super) const PLACES: u32 = 16;

/// The largest half extent of a segment's section.
pub(super) fn half_width(segment: &Segment) -> f64 {
    let at = |i| f64::from(i) / f64::from(PLACES);
    (0..=PLACES).flat_map(|i| segment.section.half_extents(at(i))).fold(0.0, f64::max)
}
