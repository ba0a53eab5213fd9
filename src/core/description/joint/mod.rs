//! Joints between links as robots hold them. [`described`] is what users describe.
//!
//! ```
//! use lissom::joint::{Joint, JointForces};
//!
//! let hinge = Joint::Revolute { axis: [0.0, 1.0, 0.0], forces: JointForces { damping: 1e-3, ..JointForces::default() } };
//! assert_eq!(hinge.coordinates(), ["angle"]);
//! ```

pub mod described;

use std::f64::consts::TAU;

use crate::description::schema::Item as _;
use crate::error::{Checker, InvalidInput};

/// Axes shorter than this are rejected: rounding determines their direction.
const SHORTEST_AXIS: f64 = 1e-9;

/// Smallest angle in radians between the axes of a universal joint. Axes closer than that count as parallel.
const SMALLEST_ANGLE: f64 = 1e-6;

/// A normal of a planar joint that is closer to the x axis than this counts as parallel to x; the first
/// direction then follows y.
const NORMAL_IS_X: f64 = 1e-9;

/// Default velocity, in radians or metres per second, below which dry friction is smoothed.
pub const FRICTION_VELOCITY: f64 = 1e-3;

/// The joints with one coordinate, in messages.
pub(crate) const OF_ONE_COORDINATE: &str = "a revolute, prismatic or screw joint";

/// Kinematics of a joint: the motion of a link relative to its parent.
#[derive(Clone, Debug, PartialEq)]
pub enum Joint {
    /// No motion.
    Weld,
    /// Rotation about an axis: one angle in radians.
    Revolute {
        /// Direction of the axis in the joint's frame, of any length.
        axis: [f64; 3],
        /// Forces on the angle.
        forces: JointForces,
    },
    /// Translation along an axis: one displacement in metres.
    Prismatic {
        /// Direction of the axis in the joint's frame, of any length.
        axis: [f64; 3],
        /// Forces on the displacement.
        forces: JointForces,
    },
    /// Rotation about an axis that drives a translation along it, as of a nut on a spindle: one angle in radians.
    Screw {
        /// Direction of the axis in the joint's frame, of any length.
        axis: [f64; 3],
        /// Translation in one revolution, in metres; negative for a left-handed thread.
        lead: f64,
        /// Forces on the angle.
        forces: JointForces,
    },
    /// Translation along an axis and rotation about it.
    Cylindrical {
        /// Direction of the axis in the joint's frame, of any length.
        axis: [f64; 3],
    },
    /// Rotation about one axis, then about a second one that the first rotation carries along.
    Universal {
        /// Directions of the axes in the joint's frame, of any length, not parallel.
        axes: [[f64; 3]; 2],
    },
    /// Two translations perpendicular to a normal, then a rotation about it. The first direction is the x
    /// axis of the joint's frame minus its component along the normal (the y axis if the normal is along x);
    /// the second one is the cross product of the normal and the first direction.
    Planar {
        /// Direction of the normal in the joint's frame, of any length.
        normal: [f64; 3],
    },
    /// Any rotation: a rotation vector.
    Spherical,
    /// Any motion: a position and a rotation vector.
    Free,
}

/// Forces on the coordinate of a joint with one coordinate: spring, damping, friction, stops and armature.
#[derive(Clone, Debug, PartialEq)]
pub struct JointForces {
    /// Stiffness in N m (per radian) or N/m.
    pub stiffness: f64,
    /// Coordinate at which the spring is relaxed, in radians or metres.
    pub rest: f64,
    /// Viscous damping in N m s or N s/m.
    pub damping: f64,
    /// Dry friction in N m or N, smoothed: `friction v / sqrt(v^2 + friction_velocity^2)`.
    pub friction: f64,
    /// Smoothing velocity of dry friction, in radians or metres per second.
    pub friction_velocity: f64,
    /// Range in which the coordinate moves freely, in radians or metres.
    pub limits: Option<[f64; 2]>,
    /// Stiffness of the stops beyond the limits, in N m (per radian) or N/m.
    pub limit_stiffness: f64,
    /// Dissipation d of the stops in s/rad or s/m (Hunt and Crossley 1975): a coordinate beyond a limit by x
    /// meets the force `limit_stiffness x max(0, 1 + d x')`.
    pub limit_dissipation: f64,
    /// Inertia of parts that only this coordinate moves, such as a rotor behind a gear: kg m^2 or kg.
    pub armature: f64,
}

impl Default for JointForces {
    /// No forces.
    fn default() -> Self {
        Self {
            stiffness: 0.0,
            rest: 0.0,
            damping: 0.0,
            friction: 0.0,
            friction_velocity: FRICTION_VELOCITY,
            limits: None,
            limit_stiffness: 0.0,
            limit_dissipation: 0.0,
            armature: 0.0,
        }
    }
}

impl JointForces {
    /// Whether all forces are absent.
    pub fn are_absent(&self) -> bool {
        let Self { stiffness, damping, friction, limits, armature, .. } = self;
        [stiffness, damping, friction, armature].into_iter().all(|&x| x == 0.0) && limits.is_none()
    }
}

/// Elementary motion of a joint; a joint is a sequence of these.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Motion {
    /// Rotation by an angle about a unit axis.
    About([f64; 3]),
    /// Translation along a unit axis.
    Along([f64; 3]),
    /// Rotation by an angle about a unit axis, with a translation along it by this many metres per radian.
    Screw([f64; 3], f64),
    /// Rotation by a rotation vector.
    AboutAll,
}

impl Motion {
    /// Whether its coordinates are angles.
    pub fn is_turn(self) -> bool {
        !matches!(self, Self::Along(_))
    }
}

impl Joint {
    /// Name in scenes and messages.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Weld => "weld",
            Self::Revolute { .. } => "revolute",
            Self::Prismatic { .. } => "prismatic",
            Self::Screw { .. } => "screw",
            Self::Cylindrical { .. } => "cylindrical",
            Self::Universal { .. } => "universal",
            Self::Planar { .. } => "planar",
            Self::Spherical => "spherical",
            Self::Free => "free",
        }
    }

    /// Names of the coordinates.
    pub fn coordinates(&self) -> &'static [&'static str] {
        match self {
            Self::Weld => &[],
            Self::Revolute { .. } | Self::Screw { .. } => &["angle"],
            Self::Prismatic { .. } => &["displacement"],
            Self::Cylindrical { .. } => &["displacement", "angle"],
            Self::Universal { .. } => &["angle[0]", "angle[1]"],
            Self::Planar { .. } => &["displacement[0]", "displacement[1]", "angle"],
            Self::Spherical => &["rotation_x", "rotation_y", "rotation_z"],
            Self::Free => &["x", "y", "z", "rotation_x", "rotation_y", "rotation_z"],
        }
    }

    /// Elementary motions from the joint's frame to the link. The joint must be valid.
    pub fn motions(&self) -> Vec<Motion> {
        match self {
            Self::Weld => Vec::new(),
            Self::Revolute { axis, .. } => vec![Motion::About(unit(*axis))],
            Self::Prismatic { axis, .. } => vec![Motion::Along(unit(*axis))],
            Self::Screw { axis, lead, .. } => vec![Motion::Screw(unit(*axis), lead / TAU)],
            Self::Cylindrical { axis } => vec![Motion::Along(unit(*axis)), Motion::About(unit(*axis))],
            Self::Universal { axes } => axes.map(|axis| Motion::About(unit(axis))).to_vec(),
            Self::Planar { normal } => {
                let [first, second] = across(unit(*normal));
                vec![Motion::Along(first), Motion::Along(second), Motion::About(unit(*normal))]
            }
            Self::Spherical => vec![Motion::AboutAll],
            Self::Free => {
                let axis = |i: usize| Motion::Along(std::array::from_fn(|j| f64::from(u8::from(i == j))));
                vec![axis(0), axis(1), axis(2), Motion::AboutAll]
            }
        }
    }

    /// Forces on the coordinate, for joints that can have them.
    pub fn forces(&self) -> Option<&JointForces> {
        match self {
            Self::Revolute { forces, .. } | Self::Prismatic { forces, .. } | Self::Screw { forces, .. } => {
                Some(forces)
            }
            _ => None,
        }
    }

    /// [`Joint::forces`], to be changed.
    pub(crate) fn forces_mut(&mut self) -> Option<&mut JointForces> {
        match self {
            Self::Revolute { forces, .. } | Self::Prismatic { forces, .. } | Self::Screw { forces, .. } => {
                Some(forces)
            }
            _ => None,
        }
    }

    /// Reports every problem of this joint.
    pub fn validate(&self) -> Result<(), InvalidInput> {
        self.described().validate()
    }
}

/// Reports axes of a universal joint that have no direction, or are parallel.
fn check_axes(check: &mut Checker, first: &[f64; 3], second: &[f64; 3]) {
    let first_is_fine = check_axis(check, first, "axis1");
    let second_is_fine = check_axis(check, second, "axis2");
    if first_is_fine && second_is_fine {
        let across = norm(cross(unit(*first), unit(*second)));
        let found = format_args!("{second:?}, parallel to axis1");
        check.require(across > SMALLEST_ANGLE, "axis2", found, "an axis across axis1");
    }
}

fn check_axis(check: &mut Checker, axis: &[f64; 3], place: &str) -> bool {
    let expected = "a direction: three finite numbers, not all of them zero";
    check.finite(axis, place)
        && check.require(norm(*axis) > SHORTEST_AXIS, place, format_args!("{axis:?}"), expected)
}

/// Both translation directions of a planar joint, perpendicular to its unit normal.
pub(crate) fn across(normal: [f64; 3]) -> [[f64; 3]; 2] {
    let less = |direction: [f64; 3]| {
        let along: f64 = direction.iter().zip(normal).map(|(a, b)| a * b).sum();
        std::array::from_fn(|i| direction[i] - along * normal[i])
    };
    let x: [f64; 3] = less([1.0, 0.0, 0.0]);
    let first = unit(if norm(x) > NORMAL_IS_X { x } else { less([0.0, 1.0, 0.0]) });
    [first, cross(normal, first)]
}

fn norm(v: [f64; 3]) -> f64 {
    // Divide by the largest entry first, so that squares and quotients do not overflow.
    let largest = v.iter().fold(0.0_f64, |largest, x| largest.max(x.abs()));
    if largest == 0.0 { 0.0 } else { largest * v.iter().map(|x| (x / largest).powi(2)).sum::<f64>().sqrt() }
}

pub(crate) fn unit(v: [f64; 3]) -> [f64; 3] {
    let norm = norm(v);
    v.map(|x| x / norm)
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}
