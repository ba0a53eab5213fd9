//! Supports as users describe them: of links with these names, where scenes do not say it by their place.

use crate::description::schema::{Described, LinkName, PerAxis, Reader};

/// Springs and dampers between a section of a rod and a fixed pose in the world, its anchor.
///
/// For small angles the rotational springs are linear; a rotation by any angle about a single axis of the anchor gives the
/// moment ``rotational_stiffness * sin(angle)``. ``rotational_stiffness=(0, k, k)`` holds the direction of the rod and leaves
/// its twist free, through any number of turns.
#[derive(Clone, Debug, PartialEq, Described)]
#[part(brief, check = Support::fits, example = include_str!("example.txt"))]
pub struct Support {
    /// Stiffness along the axes of the anchor; one number applies to all three.
    #[part(unit = "N/m", non_negative, default = PerAxis([0.0; 3]))]
    pub stiffness: PerAxis<3>,
    /// Stiffness about the axes of the anchor.
    #[part(unit = "N m/rad", non_negative, default = PerAxis([0.0; 3]))]
    pub rotational_stiffness: PerAxis<3>,
    /// Viscous damping along the axes of the anchor.
    #[part(unit = "N s/m", non_negative, default = PerAxis([0.0; 3]))]
    pub damping: PerAxis<3>,
    /// Viscous damping about the axes of the anchor.
    #[part(unit = "N m s/rad", non_negative, default = PerAxis([0.0; 3]))]
    pub rotational_damping: PerAxis<3>,
    /// Arc length of the supported section on the unstretched rod; by default the tip.
    #[part(arc_length)]
    pub at: Option<f64>,
    /// Position of the anchor in the world; by default that of the section when all coordinates are zero and the base is at its
    /// initial position, without base motion.
    #[part(unit = "metres")]
    pub position: Option<[f64; 3]>,
    /// Orientation of the anchor: unit quaternion (w, x, y, z) that maps its axes to world axes; by default that of the section
    /// at this shape, with the x axis along the rod.
    pub orientation: Option<[f64; 4]>,
    /// Supported link of a `Robot`; optional if there is only one. `at` is an arc length of its rod.
    #[part(by_place)]
    pub link: Option<LinkName>,
}

impl Support {
    fn fits(&self, reader: &mut Reader) {
        self.orientation.iter().for_each(|orientation| reader.check_orientation(orientation));
    }

    /// The support of a robot, of the link with this index.
    pub fn resolved(&self, link: usize) -> super::Support {
        super::Support {
            link,
            at: self.at,
            stiffness: self.stiffness.0,
            rotational_stiffness: self.rotational_stiffness.0,
            damping: self.damping.0,
            rotational_damping: self.rotational_damping.0,
            position: self.position,
            orientation: self.orientation,
        }
    }
}

impl super::Support {
    /// The description of this support.
    pub fn described(&self, link: Option<LinkName>) -> Support {
        Support {
            stiffness: PerAxis(self.stiffness),
            rotational_stiffness: PerAxis(self.rotational_stiffness),
            damping: PerAxis(self.damping),
            rotational_damping: PerAxis(self.rotational_damping),
            at: self.at,
            position: self.position,
            orientation: self.orientation,
            link,
        }
    }
}
