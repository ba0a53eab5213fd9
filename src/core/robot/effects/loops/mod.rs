//! Closed loops as robots hold them, with indices of links: a joint between two places, a constant distance, or a constant
//! ratio of coordinates. [`described`] is what users describe.
//!
//! ```
//! use lissom::joint::Joint;
//! use lissom::loops::{Loop, LoopEnd, Tie};
//!
//! let ends = [LoopEnd::on(1), LoopEnd::in_world([0.3, 0.0, 0.0])];
//! let pin = Loop { name: "pin".into(), tie: Tie::Joint { ends, joint: Joint::Spherical } };
//! assert_eq!(pin.tie.rows(), 3);
//! ```

pub(crate) mod compile;
pub mod described;
pub(crate) mod explain;
pub(crate) mod force;
pub(crate) mod plan;
pub(crate) mod state;

use crate::description::joint::Joint;

/// A frame at which a loop is closed.
#[derive(Clone, Debug, PartialEq)]
pub struct LoopEnd {
    /// Index of the link in the robot; `None` is the world.
    pub link: Option<usize>,
    /// Arc length from the base of the link's rod, in metres; `None` is the tip, or the base of a rigid link.
    pub at: Option<f64>,
    /// Position of the frame relative to the section or body, in its axes, or in the world; metres.
    pub position: [f64; 3],
    /// Orientation of the frame in the same axes: quaternion (w, x, y, z).
    pub orientation: [f64; 4],
}

impl LoopEnd {
    /// The tip of a link's rod, or the base of a rigid link.
    pub fn on(link: usize) -> Self {
        Self { link: Some(link), at: None, position: [0.0; 3], orientation: [1.0, 0.0, 0.0, 0.0] }
    }

    /// A point in the world.
    pub fn in_world(position: [f64; 3]) -> Self {
        Self { link: None, at: None, position, orientation: [1.0, 0.0, 0.0, 0.0] }
    }
}

/// The constraint of a loop.
#[derive(Clone, Debug, PartialEq)]
pub enum Tie {
    /// The second end moves relative to the first one as in this joint, whose axes are given in the frames of
    /// the ends.
    Joint {
        /// Both ends.
        ends: [LoopEnd; 2],
        /// The joint; neither `Free` nor `Screw`, and without forces.
        joint: Joint,
    },
    /// Both ends keep this distance, in metres.
    Distance {
        /// Both ends.
        ends: [LoopEnd; 2],
        /// The distance; > 0.
        length: f64,
    },
    /// One coordinate is `ratio` times another one plus `offset`.
    Coordinates {
        /// Indices in the robot of the dependent coordinate and of the other one.
        coordinates: [usize; 2],
        /// The ratio; not zero.
        ratio: f64,
        /// The offset, in the unit of the dependent coordinate.
        offset: f64,
    },
}

impl Tie {
    /// Number of scalar constraints.
    pub fn rows(&self) -> usize {
        match self {
            Self::Joint { joint, .. } => rows(joint),
            Self::Distance { .. } | Self::Coordinates { .. } => 1,
        }
    }

    /// Both ends; `None` for a ratio of coordinates.
    pub fn ends(&self) -> Option<&[LoopEnd; 2]> {
        match self {
            Self::Joint { ends, .. } | Self::Distance { ends, .. } => Some(ends),
            Self::Coordinates { .. } => None,
        }
    }
}

/// Number of relative motions, out of six, that a joint prevents.
fn rows(joint: &Joint) -> usize {
    6 - joint.coordinates().len()
}

/// A closed loop.
#[derive(Clone, Debug, PartialEq)]
pub struct Loop {
    /// Its name in messages.
    pub name: String,
    /// The constraint.
    pub tie: Tie,
}
