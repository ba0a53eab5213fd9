//! Driven joints: prescribed as a function of time, or coupled to another joint.

use crate::description::joint::{Joint, OF_ONE_COORDINATE, described};
use crate::description::schema::LinkName;
use crate::description::signal::{Cell, Drive, Jumps, Signal};
use crate::description::world::BaseMotion;
use crate::description::world::smooth;
use crate::description::world::smooth::{check_smooth, span};
use crate::error::{Checker, InvalidInput, Number};

/// Source of the coordinates of a driven joint, which adds no coordinates to the robot.
#[derive(Clone, Debug, PartialEq)]
pub enum Driven {
    /// The coordinate of a revolute, prismatic or screw joint is `multiplier` times another joint's coordinate, plus
    /// `offset`.
    Mimic {
        /// Index of the link with the other joint, before or after this one; that joint may be driven too.
        link: usize,
        /// Radians or metres per radian or metre of the other joint.
        multiplier: f64,
        /// Offset in radians or metres.
        offset: f64,
    },
    /// The coordinate of a revolute, prismatic or screw joint is a function of time, in radians or metres. Tables
    /// without an interpolation are cubic splines.
    Coordinate(Signal<1>),
    /// A free joint has a prescribed motion, in the axes of its frame.
    Base(BaseMotion),
}

impl Driven {
    /// The source of the coordinates of a joint; `None` if there is none, or if the mimicked link is unknown.
    pub(crate) fn of(
        joint: &described::Joint,
        index: impl FnOnce(&LinkName) -> Option<usize>,
    ) -> Option<Self> {
        if let described::Joint::Free(described::Free { motion }) = joint {
            return motion.as_ref().map(|motion| Self::Base(motion.resolved()));
        }
        match joint.of_coordinate() {
            (Some(Drive(motion)), _) => Some(Self::Coordinate(motion.clone())),
            (None, Some(described::Mimic { link, multiplier, offset })) => {
                let (multiplier, offset) = (*multiplier, *offset);
                Some(Self::Mimic { link: index(link)?, multiplier, offset })
            }
            (None, None) => None,
        }
    }

    /// The description of the driven joint, given the names of links.
    pub fn described(&self, joint: &Joint, name: impl Fn(usize) -> LinkName) -> described::Joint {
        let mut joint = joint.described();
        match self {
            Self::Base(motion) => {
                if let described::Joint::Free(free) = &mut joint {
                    free.motion = Some(motion.described());
                }
            }
            Self::Coordinate(signal) => joint.drive(Some(Drive(signal.clone())), None),
            Self::Mimic { link, multiplier, offset } => {
                let (multiplier, offset) = (*multiplier, *offset);
                joint.drive(None, Some(described::Mimic { link: name(*link), multiplier, offset }));
            }
        }
        joint
    }

    /// Whether the source depends on time explicitly.
    pub(crate) fn varies_in_time(&self) -> bool {
        match self {
            Self::Mimic { .. } => false,
            Self::Coordinate(signal) => signal.constant().is_none(),
            Self::Base(motion) => !motion.is_constant(),
        }
    }

    /// Latest end of a step from `t` that cannot miss a feature of the motion ([`Signal::horizon`]).
    pub(crate) fn horizon(&self, t: f64) -> f64 {
        match self {
            Self::Mimic { .. } => f64::INFINITY,
            Self::Coordinate(signal) => smooth::horizon(signal, t),
            Self::Base(motion) => motion.horizon(t),
        }
    }

    /// The next time at which a step of fixed size must end.
    pub(crate) fn corner(&self, cell: Cell) -> Option<f64> {
        match self {
            Self::Mimic { .. } => None,
            Self::Coordinate(signal) => smooth::corner(signal, cell),
            Self::Base(motion) => motion.corner(cell),
        }
    }

    /// The time at which the velocity jumps, if that is `t` up to rounding.
    pub(crate) fn jump_near(&self, t: f64) -> Option<f64> {
        match self {
            Self::Mimic { .. } => None,
            Self::Coordinate(signal) => smooth::jump_near(signal, t),
            Self::Base(motion) => motion.jump_near(t),
        }
    }

    /// Which quantities may jump at some time.
    pub(crate) fn jumps(&self) -> Jumps {
        match self {
            Self::Mimic { .. } => Jumps::Nothing,
            Self::Coordinate(signal) => smooth::jumps(signal),
            Self::Base(motion) => motion.jumps(),
        }
    }

    /// Shortest period in seconds; infinite without oscillations.
    pub(crate) fn period(&self) -> f64 {
        match self {
            Self::Mimic { .. } => f64::INFINITY,
            Self::Coordinate(signal) => signal.period(),
            Self::Base(motion) => motion.period(),
        }
    }

    /// Interval of time on which the source is defined.
    pub fn span(&self) -> [f64; 2] {
        match self {
            Self::Mimic { .. } => [f64::NEG_INFINITY, f64::INFINITY],
            Self::Coordinate(signal) => span(signal),
            Self::Base(motion) => motion.span(),
        }
    }

    /// Reports every problem of the source for this joint, without the robot.
    pub fn validate(&self, joint: &Joint) -> Result<(), InvalidInput> {
        let mut check = Checker::new();
        let found = format!("one of a {} joint", joint.name());
        let has_one = joint.coordinates().len() == 1;
        match self {
            Self::Mimic { .. } => {
                check.require(has_one, "mimic", found, &format!("one of {OF_ONE_COORDINATE}"));
                self.check_numbers(&mut check);
            }
            Self::Coordinate(signal) => {
                let expected = format!("one of {OF_ONE_COORDINATE}; that of a free one is a BaseMotion");
                check.require(has_one, "motion", found, &expected);
                check_smooth(signal, &mut check, "motion");
            }
            Self::Base(motion) => {
                let expected = "one of a free joint; that of others is a number in time";
                check.require(*joint == Joint::Free, "motion", found, expected);
                check.nested("motion", motion.validate());
            }
        }
        check.finish()
    }

    /// Reports invalid numbers of a mimic joint.
    pub(crate) fn check_numbers(&self, check: &mut Checker) {
        if let Self::Mimic { multiplier, offset, .. } = self {
            for (name, value) in [("mimic.multiplier", multiplier), ("mimic.offset", offset)] {
                check.require(value.is_finite(), name, Number(*value), "a finite number");
            }
        }
    }
}
