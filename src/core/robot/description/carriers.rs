//! What the places of a robot move with: welds, and parts of rods without modes, add nothing that moves.

use super::link::Link;
use crate::description::joint::Joint;

/// What a place moves with.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Carrier {
    World,
    MovingBase,
    /// The base of a link, at zero, or a section of its rod, in metres.
    Link {
        index: usize,
        at: f64,
    },
}

/// What the bases of all links move with, found in one pass.
pub(super) struct Carriers<'a> {
    links: &'a [Link],
    bases: Vec<Carrier>,
}

impl<'a> Carriers<'a> {
    /// Of these links, parents before their children, on a base that moves as prescribed or not at all.
    pub(super) fn of(links: &'a [Link], base_moves: bool) -> Self {
        let ground = if base_moves { Carrier::MovingBase } else { Carrier::World };
        let mut carriers = Self { links, bases: Vec::with_capacity(links.len()) };
        for (index, link) in links.iter().enumerate() {
            let parent = match (&link.joint, link.parent) {
                (Joint::Weld, None) => Some(ground),
                // A parent that does not precede is refused elsewhere.
                (Joint::Weld, Some(parent)) => carriers.at(parent, link.at),
                _ => None,
            };
            carriers.bases.push(parent.unwrap_or(Carrier::Link { index, at: 0.0 }));
        }
        carriers
    }

    /// What a place on a link moves with; `at` as in [`Link::at`]. `None` for a link that does not exist.
    pub(super) fn at(&self, index: usize, at: Option<f64>) -> Option<Carrier> {
        let base = *self.bases.get(index)?;
        let link = &self.links[index];
        let at = rigid_from(link, at.unwrap_or(link.length()));
        Some(if at > 0.0 { Carrier::Link { index, at } } else { base })
    }
}

/// Where the part of a rod begins that reaches up to a place without deforming, in metres.
fn rigid_from(link: &Link, at: f64) -> f64 {
    let (mut start, mut end) = (0.0, 0.0);
    for segment in link.rod.iter() {
        if at <= end {
            break;
        }
        end += segment.length;
        if segment.modes.iter().any(|&modes| modes > 0) {
            start = at.min(end);
        }
    }
    start
}
