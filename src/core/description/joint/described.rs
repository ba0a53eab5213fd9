//! Joints as users describe them: what they mimic and what moves them belongs to them.

use super::{FRICTION_VELOCITY, JointForces, check_axes, check_axis};
use crate::description::schema::{Described, LinkName, Reader};
use crate::description::signal::Drive;
use crate::description::world::described::BaseMotion;
use crate::description::world::smooth::check_smooth;
use crate::error::{Checker, Number};

/// A rigid connection.
#[derive(Clone, Debug, PartialEq, Described)]
#[part(base = "Joint", tag = "weld", tag_key = "type", family = "a joint")]
pub struct Weld {}

/// A joint coordinate that follows another one, as in gears or coupled fingers.
///
/// The coordinate is ``multiplier * other + offset``, as in URDF's `mimic`.
#[derive(Clone, Debug, PartialEq, Described)]
#[part(example = include_str!("mimic_example.txt"))]
pub struct Mimic {
    /// Link whose joint is followed. That joint is revolute, prismatic or a screw, anywhere in the robot; it may itself mimic a third
    /// joint or have a prescribed motion.
    pub link: LinkName,
    /// Ratio of this coordinate to the other one, in radians or metres per radian or metre.
    #[part(default = 1.0)]
    pub multiplier: f64,
    /// Value of this coordinate when the other one is zero, in radians or metres.
    #[part(default = 0.0)]
    pub offset: f64,
}

/// A joint with one coordinate, which can have a spring, damping, friction, stops and an armature; with the units of its
/// coordinate and its forces.
macro_rules! with_forces {
    ($(#[$meta:meta])* $Joint:ident: $coordinate:literal, $velocity:literal, $stiffness:literal, $damping:literal, $force:literal,
     $dissipation:literal, $armature:literal $(; $(#[$size_meta:meta])* $size:ident)?) => {
        #[derive(Clone, Debug, PartialEq, Described)]
        $(#[$meta])*
        pub struct $Joint {
            /// Direction of the axis in the joint frame. Its length does not matter.
            pub axis: [f64; 3],
            $($(#[$size_meta])* pub $size: f64,)?
            /// Stiffness of a spring on the coordinate.
            #[part(unit = $stiffness, non_negative, default = 0.0)]
            pub stiffness: f64,
            /// Coordinate at which the spring is unloaded.
            #[part(unit = $coordinate, default = 0.0)]
            pub rest: f64,
            /// Viscous damping.
            #[part(unit = $damping, non_negative, default = 0.0)]
            pub damping: f64,
            /// Dry friction. At the velocity v, ``friction * v / sqrt(v**2 + friction_velocity**2)`` opposes the motion.
            #[part(unit = $force, non_negative, default = 0.0)]
            pub friction: f64,
            /// Velocity below which dry friction is smoothed. A sticking joint creeps more slowly than this.
            #[part(unit = $velocity, positive, default = FRICTION_VELOCITY)]
            pub friction_velocity: f64,
            /// Lowest and highest value of the coordinate, of which one may be infinite. Stiff springs act beyond them.
            #[part(unit = $coordinate, unbounded)]
            pub limits: Option<[f64; 2]>,
            /// Stiffness of the stops; required with `limits`.
            #[part(unit = $stiffness, non_negative, default = 0.0)]
            pub limit_stiffness: f64,
            /// Dissipation of the stops. At x beyond a limit they resist with
            /// ``limit_stiffness * x * max(0, 1 + limit_dissipation * dx/dt)`` (Hunt and Crossley 1975).
            #[part(unit = $dissipation, non_negative, default = 0.0)]
            pub limit_dissipation: f64,
            /// Inertia added to this coordinate only, such as that of a geared rotor.
            #[part(unit = $armature, non_negative, default = 0.0)]
            pub armature: f64,
            /// Prescribed coordinate as a function of time (`BaseMotion` lists the forms). The joint then adds no coordinate
            /// to the robot, and its drive does work on the robot.
            #[part(unit = $coordinate)]
            pub motion: Option<Drive<1>>,
            /// Makes the coordinate follow that of another joint; the joint then adds no coordinate either. Spring, damping,
            /// limits and armature act on this joint's own motion.
            pub mimic: Option<Mimic>,
        }

        impl $Joint {
            fn fits(&self, reader: &mut Reader) {
                check_direction(reader, "axis", self.axis);
                match self.limits {
                    Some([lower, upper]) => {
                        let found = format_args!("({}, {})", Number(lower), Number(upper)).to_string();
                        let is_range = lower < upper || lower.is_nan() || upper.is_nan();
                        reader.require(is_range, "limits", found, "two numbers, the first one the smaller");
                        let expected = concat!("a finite number > 0 (", $stiffness, "): limits are stiff springs");
                        reader.require(self.limit_stiffness != 0.0, "limit_stiffness", "0", expected);
                    }
                    None => {
                        let expected = "two numbers: there is a limit_stiffness";
                        reader.require(self.limit_stiffness == 0.0, "limits", "none", expected);
                    }
                }
                reader.check_exclusive(["motion", "mimic"], &self.motion, &self.mimic);
                if let Some(Drive(motion)) = &self.motion {
                    let mut check = Checker::new();
                    check_smooth(motion, &mut check, "motion");
                    reader.nested(check);
                }
            }

            /// Its axis and the forces on its coordinate.
            fn parts(&self) -> ([f64; 3], JointForces) {
                let forces = JointForces {
                    stiffness: self.stiffness,
                    rest: self.rest,
                    damping: self.damping,
                    friction: self.friction,
                    friction_velocity: self.friction_velocity,
                    limits: self.limits,
                    limit_stiffness: self.limit_stiffness,
                    limit_dissipation: self.limit_dissipation,
                    armature: self.armature,
                };
                (self.axis, forces)
            }

            fn of(axis: [f64; 3], $($size: f64,)? forces: &JointForces) -> Self {
                Self {
                    axis,
                    $($size,)?
                    stiffness: forces.stiffness,
                    rest: forces.rest,
                    damping: forces.damping,
                    friction: forces.friction,
                    friction_velocity: forces.friction_velocity,
                    limits: forces.limits,
                    limit_stiffness: forces.limit_stiffness,
                    limit_dissipation: forces.limit_dissipation,
                    armature: forces.armature,
                    motion: None,
                    mimic: None,
                }
            }
        }
    };
}

with_forces! {
    /// A hinge: the link rotates about an axis. The coordinate `angle` is in radians.
    #[part(base = "Joint", tag = "revolute", tag_key = "type", family = "a joint", check = Revolute::fits)]
    Revolute: "radians", "radians per second", "newton metres per radian", "newton metre seconds per radian", "newton metres",
    "seconds per radian", "kg m^2"
}

with_forces! {
    /// A slider: the link translates along an axis. The coordinate `displacement` is in metres.
    #[part(base = "Joint", tag = "prismatic", tag_key = "type", family = "a joint", check = Prismatic::fits)]
    Prismatic: "metres", "metres per second", "newtons per metre", "newton seconds per metre", "newtons",
    "seconds per metre", "kilograms"
}

with_forces! {
    /// A screw: the link rotates about an axis and translates along it in proportion, as a nut does on a spindle. The coordinate
    /// `angle` is in radians.
    #[part(base = "Joint", tag = "screw", tag_key = "type", family = "a joint", check = Screw::fits)]
    Screw: "radians", "radians per second", "newton metres per radian", "newton metre seconds per radian", "newton metres",
    "seconds per radian", "kg m^2";
    /// Translation along the axis in one revolution; negative for a left-handed thread.
    #[part(unit = "metres")]
    lead
}

/// Reports a direction that is none; numbers that are not finite are reported by themselves.
fn check_direction(reader: &mut Reader, key: &str, direction: [f64; 3]) {
    if direction.iter().all(|x| x.is_finite()) {
        let mut check = Checker::new();
        check_axis(&mut check, &direction, key);
        reader.nested(check);
    }
}

/// A cylindrical joint: the link slides along an axis and rotates about it.
///
/// The coordinates are `displacement`, in metres, and `angle`, in radians.
#[derive(Clone, Debug, PartialEq, Described)]
#[part(base = "Joint", tag = "cylindrical", tag_key = "type", family = "a joint", check = Cylindrical::fits)]
pub struct Cylindrical {
    /// Direction of the axis in the joint frame. Its length does not matter.
    pub axis: [f64; 3],
}

impl Cylindrical {
    fn fits(&self, reader: &mut Reader) {
        check_direction(reader, "axis", self.axis);
    }
}

/// A universal joint: the link rotates about one axis, then about a second one that the first one carries.
///
/// The coordinates `angle[0]` and `angle[1]` are in radians.
#[derive(Clone, Debug, PartialEq, Described)]
#[part(base = "Joint", tag = "universal", tag_key = "type", family = "a joint", check = Universal::fits)]
pub struct Universal {
    /// Direction of the first axis in the joint frame when both angles are zero. Its length does not matter.
    pub axis1: [f64; 3],
    /// Direction of the second axis, not parallel to the first one. Its length does not matter.
    pub axis2: [f64; 3],
}

impl Universal {
    fn fits(&self, reader: &mut Reader) {
        if [self.axis1, self.axis2].as_flattened().iter().all(|x| x.is_finite()) {
            let mut check = Checker::new();
            check_axes(&mut check, &self.axis1, &self.axis2);
            reader.nested(check);
        }
    }
}

/// A planar joint: the link translates in a plane and rotates about its normal.
///
/// The coordinates are `displacement[0]` and `displacement[1]`, in metres, and `angle`, in radians. The first displacement is
/// along the x axis of the joint frame, projected onto the plane (along y if the normal is along x); the second one is along
/// the cross product of the normal and that direction.
#[derive(Clone, Debug, PartialEq, Described)]
#[part(base = "Joint", tag = "planar", tag_key = "type", family = "a joint", check = Planar::fits)]
pub struct Planar {
    /// Normal of the plane in the joint frame. Its length does not matter.
    pub normal: [f64; 3],
}

impl Planar {
    fn fits(&self, reader: &mut Reader) {
        check_direction(reader, "normal", self.normal);
    }
}

/// A ball joint: the link rotates about a point.
///
/// The coordinates `rotation_x`, `rotation_y`, `rotation_z` are the rotation vector in radians; results keep its length at
/// most pi. Their velocities are its time derivatives, not the angular velocity.
#[derive(Clone, Debug, PartialEq, Described)]
#[part(base = "Joint", tag = "spherical", tag_key = "type", family = "a joint")]
pub struct Spherical {}

/// Six degrees of freedom: coordinates `x`, `y`, `z` (metres) and a rotation vector as in `Spherical`.
#[derive(Clone, Debug, PartialEq, Described)]
#[part(base = "Joint", tag = "free", tag_key = "type", family = "a joint")]
pub struct Free {
    /// Prescribed motion of the base of the link, in the axes of the joint frame. The joint then adds no coordinate to the
    /// robot, and its drive does work on the robot.
    pub motion: Option<BaseMotion>,
}

/// A joint between a link and its parent.
#[derive(Clone, Debug, PartialEq, Described)]
pub enum Joint {
    /// No motion.
    Weld(Weld),
    /// Turns about an axis.
    Revolute(Revolute),
    /// Moves along an axis.
    Prismatic(Prismatic),
    /// Turns about an axis and moves along it in proportion.
    Screw(Screw),
    /// Moves along an axis and turns about it.
    Cylindrical(Cylindrical),
    /// Turns about two axes, one after the other.
    Universal(Universal),
    /// Moves across a normal and turns about it.
    Planar(Planar),
    /// Turns about a point.
    Spherical(Spherical),
    /// Moves freely.
    Free(Free),
}

impl Joint {
    /// The joint of a robot, without what drives it.
    pub fn resolved(&self) -> super::Joint {
        match self {
            Self::Weld(_) => super::Joint::Weld,
            Self::Revolute(joint) => {
                let (axis, forces) = joint.parts();
                super::Joint::Revolute { axis, forces }
            }
            Self::Prismatic(joint) => {
                let (axis, forces) = joint.parts();
                super::Joint::Prismatic { axis, forces }
            }
            Self::Screw(joint) => {
                let (axis, forces) = joint.parts();
                super::Joint::Screw { axis, lead: joint.lead, forces }
            }
            Self::Cylindrical(Cylindrical { axis }) => super::Joint::Cylindrical { axis: *axis },
            Self::Universal(Universal { axis1, axis2 }) => super::Joint::Universal { axes: [*axis1, *axis2] },
            Self::Planar(Planar { normal }) => super::Joint::Planar { normal: *normal },
            Self::Spherical(_) => super::Joint::Spherical,
            Self::Free(_) => super::Joint::Free,
        }
    }

    /// The prescribed motion of its coordinate, and what it mimics.
    pub fn of_coordinate(&self) -> (Option<&Drive<1>>, Option<&Mimic>) {
        match self {
            Self::Revolute(Revolute { motion, mimic, .. })
            | Self::Prismatic(Prismatic { motion, mimic, .. })
            | Self::Screw(Screw { motion, mimic, .. }) => (motion.as_ref(), mimic.as_ref()),
            _ => (None, None),
        }
    }
}

impl Joint {
    /// Prescribes its coordinate, or lets it mimic another one, if it has one.
    pub fn drive(&mut self, by: Option<Drive<1>>, other: Option<Mimic>) {
        if let Self::Revolute(Revolute { motion, mimic, .. })
        | Self::Prismatic(Prismatic { motion, mimic, .. })
        | Self::Screw(Screw { motion, mimic, .. }) = self
        {
            (*motion, *mimic) = (by, other);
        }
    }
}

impl super::Joint {
    /// The description of this joint, which nothing drives.
    pub fn described(&self) -> Joint {
        match self {
            Self::Weld => Weld {}.into(),
            Self::Revolute { axis, forces } => Revolute::of(*axis, forces).into(),
            Self::Prismatic { axis, forces } => Prismatic::of(*axis, forces).into(),
            Self::Screw { axis, lead, forces } => Screw::of(*axis, *lead, forces).into(),
            Self::Cylindrical { axis } => Cylindrical { axis: *axis }.into(),
            Self::Universal { axes: [axis1, axis2] } => Universal { axis1: *axis1, axis2: *axis2 }.into(),
            Self::Planar { normal } => Planar { normal: *normal }.into(),
            Self::Spherical => Spherical {}.into(),
            Self::Free => Free { motion: None }.into(),
        }
    }
}
