//! Whether steps of searches and paths lead through surfaces.

use super::stiffness_continuation::INSIDE_OVERLAP;
use crate::model::{InvalidShape, Overlap, Radius, Static, chart};

/// Parts of a step in which places are assumed to move straight: for a link that turns by a tenth of a radian, the error is
/// a thousandth of its length.
const LENGTH_OF_PARTS: f64 = 0.1;

/// Maximum number of parts, which bounds the cost of very long steps.
const MAX_PARTS: f64 = 1e4;

/// What surfaces do on a step from one shape to another.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Passage {
    /// They allow it.
    Free,
    /// They pass through each other on the way.
    Tunnelled,
    /// At the end they overlap by more than their thickness, and at the start by less: contacts do not show any more on which side of each
    /// other they are. What starts deeper, such as at the end of a search with softer contacts, has to come out.
    Sunk(Overlap),
}

impl Passage {
    /// Of a step of this length, in sizes of coordinates.
    pub(super) fn between(model: &mut dyn Static, [from, to]: [&[f64]; 2], length: f64) -> Self {
        if !model.facts().has_contact || !length.is_finite() {
            return Self::Free;
        }
        let [before, after] = [from, to].map(|q| model.deepest_overlaps(q)[1]);
        let share = |overlap: Option<Overlap>| overlap.map_or(0.0, |overlap| overlap.share);
        let inside = share(before).max(share(after)).max(INSIDE_OVERLAP);
        let turns = model.facts().rotation_vectors.clone();
        model.store_surfaces(from);
        let step = chart::step_between(&turns, from, to);
        let parts = (length / LENGTH_OF_PARTS).ceil().clamp(1.0, MAX_PARTS) as usize;
        let has_tunnelled = (1..=parts).any(|part| {
            let mut q = from.to_vec();
            let part: Vec<f64> = step.iter().map(|x| x * part as f64 / parts as f64).collect();
            chart::retract(&turns, &mut q, &part);
            // The tunnelling check computes rotations of solids from the coordinates.
            chart::unfold(&turns, from, &mut q);
            model.have_tunnelled(&q, Radius::Smaller) || share(model.deepest_overlaps(&q)[1]) > inside
        });
        match after {
            _ if has_tunnelled => Self::Tunnelled,
            Some(overlap) if overlap.share > INSIDE_OVERLAP && share(before) <= INSIDE_OVERLAP => {
                Self::Sunk(overlap)
            }
            _ => Self::Free,
        }
    }

    /// The problem of the shape to which it leads, if that is sunk.
    pub(super) fn invalid_shape(self) -> Option<InvalidShape> {
        match self {
            Self::Sunk(Overlap { contact, depth, .. }) => {
                Some(InvalidShape::DeepPenetration { contact, overlap: depth })
            }
            Self::Free | Self::Tunnelled => None,
        }
    }
}
