//! The moving body to which each place of a robot belongs: welds, and parts of rods without modes, are merged with their parents.

use super::link::Link;
use crate::description::joint::Joint;

/// The body that carries a place.
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

/// The bodies that carry the bases of all links, found in one pass.
pub(super) struct Carriers<'a> {
    links: &'a [Link],
    bases: Vec<Carrier>,
}

impl<'a> Carriers<'a> {
    /// For these links, parents before their children, on a base with a prescribed motion or at rest.
    pub(super) fn of(links: &'a [Link], base_moves: bool) -> Self {
        let ground = if base_moves { Carrier::MovingBase } else { Carrier::World };
        let mut carriers = Self { links, bases: Vec::with_capacity(links.len()) };
        for (index, link) in links.iter().enumerate() {
            let parent = match (&link.joint, link.parent) {
                (Joint::Weld, None) => Some(ground),
                // A parent that does not precede its child is rejected elsewhere.
                (Joint::Weld, Some(parent)) => carriers.at(parent, link.at),
                _ => None,
            };
            carriers.bases.push(parent.unwrap_or(Carrier::Link { index, at: 0.0 }));
        }
        carriers
    }

    /// The body that carries a place on a link; `at` as in [`Link::at`]. `None` for a link that does not exist.
    pub(super) fn at(&self, index: usize, at: Option<f64>) -> Option<Carrier> {
        let base = *self.bases.get(index)?;
        let link = &self.links[index];
        let at = rigid_from(link, at.unwrap_or(link.length()));
        Some(if at > 0.0 { Carrier::Link { index, at } } else { base })
    }
}

/// Start, in metres, of the rigid part of a rod that ends at a place.
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
