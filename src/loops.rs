//! Closed loops as plain data: a joint between two places, a constant distance, or a constant ratio of
//! coordinates.
//!
//! ```
//! use lissom::joint::Joint;
//! use lissom::loops::{Loop, LoopEnd, Tie};
//!
//! let ends = [LoopEnd::on(1), LoopEnd::in_world([0.3, 0.0, 0.0])];
//! let pin = Loop { name: "pin".into(), tie: Tie::Joint { ends, joint: Joint::Spherical } };
//! assert_eq!(pin.tie.rows(), 3);
//! ```

use crate::error::{Checker, InvalidInput, Number};
use crate::joint::Joint;
use crate::lie::QUATERNION_TOLERANCE;
use crate::load::check_place;

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

    fn check(&self, check: &mut Checker, place: &str, length: impl Fn(usize) -> Option<f64>) {
        let at = format!("{place}.at");
        match self.link {
            None => {
                let expected = "none: the world has no arc length";
                check.require(self.at.is_none(), &at, self.at.unwrap_or(0.0), expected);
            }
            Some(link) => match (length(link), self.at) {
                (None, _) => {
                    check.require(false, &format!("{place}.link"), link, "a link of the robot");
                }
                (Some(length), Some(x)) if length > 0.0 => {
                    check_place(check, x, &at, length);
                }
                (Some(_), Some(x)) => {
                    check.require(false, &at, Number(x), "none: the link has no rod");
                }
                (Some(_), None) => {}
            },
        }
        check.finite(&self.position, &format!("{place}.position"));
        let orientation = format!("{place}.orientation");
        if check.finite(&self.orientation, &orientation) {
            let norm = self.orientation.iter().map(|x| x * x).sum::<f64>().sqrt();
            check.require(
                (norm - 1.0).abs() <= QUATERNION_TOLERANCE,
                &orientation,
                format_args!("a quaternion of norm {norm}"),
                "a quaternion (w, x, y, z) of norm 1",
            );
        }
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
        /// The joint; not `Free`, and without forces.
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

impl Loop {
    /// Reports every problem of the loop on a robot with this number of coordinates whose links have these
    /// lengths (zero for rigid links, `None` for indices without a link).
    pub fn validate(
        &self,
        length: impl Fn(usize) -> Option<f64>,
        coordinates: usize,
    ) -> Result<(), InvalidInput> {
        let mut check = Checker::new();
        check.require(!self.name.is_empty(), "name", "''", "a name");
        if let Some(ends) = self.tie.ends() {
            for (end, place) in ends.iter().zip(["a", "b"]) {
                end.check(&mut check, place, &length);
            }
            let [a, b] = ends;
            let is_something = a.link != b.link || a.link.is_some_and(|_| a.at != b.at);
            let found = if a.link.is_none() { "two points of the world" } else { "one and the same section" };
            check.require(is_something, "b", found, "a place that can move beside the first one");
        }
        match &self.tie {
            Tie::Joint { joint, .. } => {
                check.nested("kind", joint.validate());
                let expected = "a joint that forbids a motion";
                check.require(*joint != Joint::Free, "kind", "a free joint", expected);
                let is_bare = joint.forces().is_none_or(crate::joint::JointForces::are_absent);
                let expected =
                    "none in the joint of a loop; a joint of a link can have them, and a motor or a load";
                check.require(is_bare, "kind", "springs, dampers or stops", expected);
            }
            Tie::Distance { length, .. } => {
                check.positive(*length, "kind.length", "metres; ends that coincide are a spherical joint");
            }
            Tie::Coordinates { coordinates: tied, ratio, offset } => {
                for (i, &k) in tied.iter().enumerate() {
                    let expected = format!("a coordinate, 0 to {}", coordinates.saturating_sub(1));
                    check.require(k < coordinates, &format!("kind.coordinates[{i}]"), k, &expected);
                }
                let expected = "two different ones";
                check.require(tied[0] != tied[1], "kind.coordinates", "one coordinate twice", expected);
                let expected = "a finite number other than zero";
                check.require(ratio.is_finite() && *ratio != 0.0, "kind.ratio", Number(*ratio), expected);
                check.finite(&[*offset], "kind.offset");
            }
        }
        check.finish()
    }
}
