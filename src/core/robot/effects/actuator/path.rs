//! The path of a tendon or a chamber.

use crate::description::rod::Profile;

/// A part of a path embedded in a rod.
#[derive(Clone, Debug, PartialEq)]
pub struct Along {
    /// Index of the link in the robot.
    pub link: usize,
    /// Offsets y and z from the rod's axis in the section, in metres, along the whole rod of the link.
    pub offset: [Profile<1>; 2],
    /// Start and end of the part, as arc lengths of the unstretched rod in metres.
    pub along: [f64; 2],
}

/// A point of a link or of the world on a path.
#[derive(Clone, Debug, PartialEq)]
pub struct Via {
    /// The link; `None` is the world.
    pub link: Option<usize>,
    /// The point in the axes of the section, of the body, or of the world, in metres.
    pub point: [f64; 3],
    /// Arc length of the section of a rod, in metres; `None` is the tip, or the body of a rigid link.
    pub at: Option<f64>,
}

/// A part of a tendon's path. Straight lines connect successive parts.
#[derive(Clone, Debug, PartialEq)]
pub enum Part {
    /// Embedded in a rod.
    Along(Along),
    /// A point of the path.
    Via(Via),
}

impl Part {
    /// The part, if it is embedded.
    pub fn along(&self) -> Option<&Along> {
        if let Self::Along(along) = self { Some(along) } else { None }
    }

    /// The point, if the part is one.
    pub fn via(&self) -> Option<&Via> {
        if let Self::Via(via) = self { Some(via) } else { None }
    }
}
