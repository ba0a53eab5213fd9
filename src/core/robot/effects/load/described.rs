//! Loads as users describe them: on links with these names, where scenes do not say it by their place.

use super::{Extent, Frame};
use crate::description::schema::{Described, LinkName, Reader};
use crate::description::signal::Signal;

/// A force and a moment on a rod, at a point or distributed along a part of it.
#[derive(Clone, Debug, PartialEq, Described)]
#[part(brief, some_of = &["force", "moment"], check = Load::fits, example = include_str!("example.txt"))]
pub struct Load {
    /// Force; per metre of the unstretched rod if distributed. One that varies in time is a table of times and values,
    /// interpolated linearly and held constant outside, a harmonic, or in Python a function of the time in seconds that
    /// returns three numbers.
    #[part(unit = "newtons", default)]
    pub force: Signal<3>,
    /// Moment; per metre if distributed. Takes the same forms as `force`.
    #[part(unit = "newton metres", default)]
    pub moment: Signal<3>,
    /// Arc length of the unstretched rod where the load acts; by default the tip.
    #[part(arc_length)]
    pub at: Option<f64>,
    /// Arc lengths between which the load is distributed uniformly; instead of acting at a point.
    #[part(arc_length)]
    pub along: Option<[f64; 2]>,
    /// Axes of `force` and `moment`: those of the world for a load of constant direction (a dead load), or of the body for a
    /// load that rotates with its section (a follower load).
    #[part(default = Frame::World)]
    pub frame: Frame,
    /// Link of a `Robot` on which the load acts; optional if there is only one. `at` and `along` refer to its rod.
    #[part(by_place)]
    pub link: Option<LinkName>,
}

impl Load {
    fn fits(&self, reader: &mut Reader) {
        reader.check_exclusive(["at", "along"], &self.at, &self.along);
        self.along.iter().for_each(|along| reader.check_interval("along[1]", *along));
    }

    /// The load of a robot on a link with this index.
    pub fn resolved(&self, link: usize) -> super::Load {
        let extent = match (self.at, self.along) {
            (Some(x), _) => Extent::At(x),
            (None, Some(ends)) => Extent::Along(ends),
            (None, None) => Extent::Tip,
        };
        let (force, moment) = (self.force.clone(), self.moment.clone());
        super::Load { link, extent, frame: self.frame, force, moment }
    }
}

impl super::Load {
    /// The description of this load.
    pub fn described(&self, link: Option<LinkName>) -> Load {
        let (at, along) = match self.extent {
            Extent::Tip => (None, None),
            Extent::At(x) => (Some(x), None),
            Extent::Along(ends) => (None, Some(ends)),
        };
        Load { force: self.force.clone(), moment: self.moment.clone(), at, along, frame: self.frame, link }
    }
}
