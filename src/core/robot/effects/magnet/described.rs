//! Magnets as users describe them: on links with these names, where scenes do not say it by their place.

use crate::description::schema::{Described, LinkName};

/// A permanent magnet on a link of a `Robot`, small beside its distance from others: a magnetic dipole.
///
/// The uniform `field` of the robot turns it, and magnets of the robot turn, attract and repel each other and the magnetised
/// segments of other links. Magnets of one rod act on each other where the rod between them deforms, and not on its own
/// magnetised segments.
#[derive(Clone, Debug, PartialEq, Described)]
#[part(brief, positional = 1, example = include_str!("example.txt"))]
pub struct Magnet {
    /// Magnetic moment, from its south to its north pole, in the axes of the section or of the link without a rod.
    #[part(unit = "A m^2")]
    pub moment: [f64; 3],
    /// Arc length of its section on the unstretched rod; by default the tip.
    #[part(arc_length)]
    pub at: Option<f64>,
    /// Position in these axes.
    #[part(unit = "metres", default)]
    pub position: [f64; 3],
    /// Link that carries it; optional if there is only one.
    #[part(by_place)]
    pub link: Option<LinkName>,
}

impl Magnet {
    /// The magnet of a robot on a link with this index.
    pub fn resolved(&self, link: usize) -> super::Magnet {
        let Self { at, moment, position, .. } = *self;
        super::Magnet { link, at, moment, position }
    }
}

impl super::Magnet {
    /// The description of this magnet.
    pub fn described(&self, link: Option<LinkName>) -> Magnet {
        let Self { at, moment, position, .. } = *self;
        Magnet { moment, at, position, link }
    }
}
