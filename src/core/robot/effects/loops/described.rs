//! Closed loops as users describe them: between places on links with these names, or coordinates.

use super::Tie;
use crate::description::joint::described::{
    Cylindrical, Joint, Planar, Prismatic, Revolute, Spherical, Universal, Weld,
};
use crate::description::schema::{Described, LinkName, Reader};
use crate::error::Number;

/// Name of the world within the names of loops.
const WORLD: &str = "the world";

/// A frame at one end of a loop.
#[derive(Clone, Debug, PartialEq, Described)]
#[part(positional = 4, short, checked_later, called = "an end of a loop", check = LoopEnd::fits)]
pub struct LoopEnd {
    /// Name of the link; by default the world.
    pub link: Option<LinkName>,
    /// Arc length of the link's unstretched rod; by default the tip, or the base of a rigid link.
    #[part(arc_length)]
    pub at: Option<f64>,
    /// Position of the frame relative to the section or body, in its axes, or in the world.
    #[part(unit = "metres", default)]
    pub position: [f64; 3],
    /// Orientation of the frame relative to these axes: unit quaternion (w, x, y, z).
    #[part(default = [1.0, 0.0, 0.0, 0.0])]
    pub orientation: [f64; 4],
}

impl LoopEnd {
    /// The tip or body of a link, or the origin of the world.
    pub fn on(link: Option<LinkName>) -> Self {
        Self { link, at: None, position: [0.0; 3], orientation: [1.0, 0.0, 0.0, 0.0] }
    }

    fn fits(&self, reader: &mut Reader) {
        if let (None, Some(at)) = (&self.link, self.at) {
            reader.require(false, "at", Number(at), "none: the world has no arc length");
        }
        reader.check_orientation(&self.orientation);
    }
}

/// A place at which a loop is closed.
#[derive(Clone, Debug, PartialEq, Described)]
pub enum LoopPlace {
    /// A link, or a coordinate.
    Name(String),
    /// A frame.
    End(LoopEnd),
}

/// A constant distance between two points: a massless rigid bar with ball joints.
#[derive(Clone, Debug, PartialEq, Described)]
#[part(tag = "distance", tag_key = "type", family = "a loop")]
pub struct Distance {
    /// Distance between the ends.
    #[part(unit = "metres", positive)]
    pub length: f64,
}

/// A linear coupling: a coordinate of the robot is ``ratio`` times another one plus ``offset``.
///
/// The ends of such a loop are names of coordinates (see `Robot.coordinates`). Joints can also mimic each other (`Mimic`),
/// which costs less; a gear couples any two coordinates, and its force can be computed.
#[derive(Clone, Debug, PartialEq, Described)]
#[part(tag = "gear", tag_key = "type", family = "a loop", positional = 1, check = Gear::fits)]
pub struct Gear {
    /// Ratio of the first coordinate to the second one, not zero.
    #[part(default = 1.0)]
    pub ratio: f64,
    /// Offset, in the unit of the first coordinate.
    #[part(default = 0.0)]
    pub offset: f64,
}

impl Gear {
    fn fits(&self, reader: &mut Reader) {
        reader.require(self.ratio != 0.0, "ratio", Number(self.ratio), "a finite number other than zero");
    }
}

/// What a loop holds.
#[derive(Clone, Debug, PartialEq, Described)]
pub enum LoopKind {
    /// Both frames are one.
    Weld(Weld),
    /// The second frame turns about an axis.
    Revolute(Revolute),
    /// It moves along an axis.
    Prismatic(Prismatic),
    /// It moves along an axis and turns about it.
    Cylindrical(Cylindrical),
    /// It turns about one axis of each frame.
    Universal(Universal),
    /// It moves across a normal and turns about it.
    Planar(Planar),
    /// It turns about a point.
    Spherical(Spherical),
    /// A constant distance between two points.
    Distance(Distance),
    /// A coordinate follows another one.
    Gear(Gear),
}

impl LoopKind {
    /// The joint, if it is one.
    pub fn joint(&self) -> Option<Joint> {
        Some(match self.clone() {
            Self::Weld(joint) => joint.into(),
            Self::Revolute(joint) => joint.into(),
            Self::Prismatic(joint) => joint.into(),
            Self::Cylindrical(joint) => joint.into(),
            Self::Universal(joint) => joint.into(),
            Self::Planar(joint) => joint.into(),
            Self::Spherical(joint) => joint.into(),
            Self::Distance(_) | Self::Gear(_) => return None,
        })
    }

    /// The kind of a loop with this joint; `None` for a free one, which closes none, and for a screw, whose turns two frames do not
    /// determine.
    fn of(joint: Joint) -> Option<Self> {
        Some(match joint {
            Joint::Weld(joint) => joint.into(),
            Joint::Revolute(joint) => joint.into(),
            Joint::Prismatic(joint) => joint.into(),
            Joint::Cylindrical(joint) => joint.into(),
            Joint::Universal(joint) => joint.into(),
            Joint::Planar(joint) => joint.into(),
            Joint::Spherical(joint) => joint.into(),
            Joint::Screw(_) | Joint::Free(_) => return None,
        })
    }
}

/// A joint that closes a loop, between two links or between a link and the world.
///
/// Every step and every equilibrium satisfies the constraints of the loop to rounding. `Robot.loop_forces` returns the
/// constraint forces.
#[derive(Clone, Debug, PartialEq, Described)]
#[part(positional = 3, complete = Loop::complete, check = Loop::fits, example = include_str!("example.txt"))]
pub struct Loop {
    /// First end: a `LoopEnd`; the name of a link, for its tip or base; or nothing for the origin of the world. In Python also
    /// a tuple ``(link, at, position, orientation)``, whose last entries may be left out, or a dict of them. For a `Gear` the
    /// name of the coordinate that follows the other one.
    #[part(explicit, default = LoopPlace::End(LoopEnd::on(None)))]
    pub a: LoopPlace,
    /// Second end, in the same forms. For a `Gear` the name of the other coordinate.
    #[part(explicit, default = LoopPlace::End(LoopEnd::on(None)))]
    pub b: LoopPlace,
    /// Relative motion that the loop allows the frame of `b` in the frame of `a`: a joint without spring, damping or friction
    /// and neither `Free` nor `Screw`, a constant distance, or a gear.
    pub kind: LoopKind,
    /// Name in messages. By default made of the ends, such as "hand to the world"; robots number equal default names: "hand
    /// to the world 2".
    #[part(default)]
    pub name: String,
}

impl Loop {
    fn places(&self) -> [(&'static str, &LoopPlace); 2] {
        [("a", &self.a), ("b", &self.b)]
    }

    /// The name that it has by default.
    pub fn default_name(&self) -> String {
        let [a, b] = self.places().map(|(_, place)| match place {
            LoopPlace::Name(name) => name.as_str(),
            LoopPlace::End(end) => end.link.as_ref().map_or(WORLD, |LinkName(link)| link),
        });
        format!("{a} to {b}")
    }

    /// Whether its name is the one that it has by default.
    pub fn has_default_name(&self) -> bool {
        self.name == self.default_name()
    }

    /// Names are those of links, but for gears.
    fn complete(&mut self) {
        if !matches!(self.kind, LoopKind::Gear(_)) {
            for place in [&mut self.a, &mut self.b] {
                if let LoopPlace::Name(link) = place {
                    *place = LoopEnd::on(Some(LinkName(std::mem::take(link)))).into();
                }
            }
        }
        if self.name.is_empty() {
            self.name = self.default_name();
        }
    }

    fn fits(&self, reader: &mut Reader) {
        match (&self.a, &self.b) {
            (LoopPlace::End(a), LoopPlace::End(b)) if !matches!(self.kind, LoopKind::Gear(_)) => {
                let is_other =
                    !reader.is_complete() || a.link != b.link || (a.link.is_some() && a.at != b.at);
                let found =
                    if a.link.is_none() { "two points of the world" } else { "one and the same section" };
                reader.require(is_other, "b", found, "a place that can move beside the first one");
            }
            (LoopPlace::Name(a), LoopPlace::Name(b)) => {
                reader.require(a != b, "b", "one coordinate twice", "two different ones");
            }
            _ => {
                for (key, place) in self.places() {
                    let expected = "the name of a coordinate: a gear ties two coordinates";
                    reader.require(matches!(place, LoopPlace::Name(_)), key, "a place", expected);
                }
            }
        }
        let Some(joint) = self.kind.joint() else { return };
        let is_bare =
            joint.resolved().forces().is_none_or(crate::description::joint::JointForces::are_absent);
        let expected = "none in the joint of a loop; a joint of a link can have them, and a motor or a load";
        reader.require(is_bare, "kind", "springs, dampers or stops", expected);
        let (motion, mimic) = joint.of_coordinate();
        for (key, is_given) in [("kind.motion", motion.is_some()), ("kind.mimic", mimic.is_some())] {
            let expected = "none: the joint of a loop is not driven; drive a joint of a link";
            reader.require(!is_given, key, "one", expected);
        }
    }
}

impl super::Loop {
    /// The description of this loop, where links and coordinates have these names.
    pub fn described(&self, link: &dyn Fn(usize) -> LinkName, coordinate: &dyn Fn(usize) -> String) -> Loop {
        let end = |end: &super::LoopEnd| {
            let &super::LoopEnd { link: on, at, position, orientation } = end;
            LoopPlace::from(LoopEnd { link: on.map(link), at, position, orientation })
        };
        let (a, b, kind) = match &self.tie {
            Tie::Joint { ends: [a, b], joint } => {
                // The robot refuses free joints.
                let kind = LoopKind::of(joint.described()).unwrap_or(LoopKind::Weld(Weld {}));
                (end(a), end(b), kind)
            }
            Tie::Distance { ends: [a, b], length } => (end(a), end(b), Distance { length: *length }.into()),
            Tie::Coordinates { coordinates: [first, second], ratio, offset } => {
                let (ratio, offset) = (*ratio, *offset);
                let [a, b] = [*first, *second].map(|k| coordinate(k).into());
                (a, b, Gear { ratio, offset }.into())
            }
        };
        Loop { a, b, kind, name: self.name.clone() }
    }
}
