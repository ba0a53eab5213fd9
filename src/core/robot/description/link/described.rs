//! Links as users describe them: on links with these names.

use super::{Driven, Link as Resolved};
use crate::description::body::described::Body;
use crate::description::joint::described::{Joint, Weld};
use crate::description::rod::described::Segment;
use crate::description::schema::{Described, LinkName, Reader};
use crate::error::Number;

/// The rod of a link.
#[derive(Clone, Debug, PartialEq, Described)]
#[part(list)]
pub struct LinkRod {
    /// Segments from base to tip; each one starts where the previous one ends.
    pub segment: Vec<Segment>,
}

/// A joint followed by a rod, a rigid body, or a frame alone.
///
/// `position` and `orientation` place the joint frame on the parent, in the axes of the section or body there. The joint moves
/// the base of the link relative to that frame. A rod starts at the base, along its x axis.
#[derive(Clone, Debug, PartialEq, Described)]
#[part(concise, called = "a link", check = Link::fits, example = include_str!("example.txt"))]
pub struct Link {
    /// Name by which loads, child links and results refer to the link.
    pub name: String,
    /// Segments of the rod, from base to tip, instead of a body.
    pub rod: Option<LinkRod>,
    /// Rigid body, instead of a rod; its centre and inertia are in the axes of the link's base.
    pub body: Option<Body>,
    /// Joint between the link and its parent; by default a rigid connection.
    #[part(default = Joint::from(Weld {}))]
    pub joint: Joint,
    /// Link that carries this one; it must come earlier in the robot. By default the world.
    pub parent: Option<LinkName>,
    /// Arc length of the parent's unstretched rod at which the link is attached; by default the tip, or the parent's body.
    #[part(arc_length)]
    pub at: Option<f64>,
    /// Position of the joint frame on the parent, in the axes of the section or body there.
    #[part(unit = "metres", default)]
    pub position: [f64; 3],
    /// Orientation of the joint frame: unit quaternion (w, x, y, z) that maps its axes to those of the parent.
    #[part(default = [1.0, 0.0, 0.0, 0.0])]
    pub orientation: [f64; 4],
}

impl Link {
    /// A frame welded to the world's origin: a start for `..` syntax.
    pub fn new(name: impl Into<String>) -> Self {
        Self {
            name: name.into(),
            rod: None,
            body: None,
            joint: Weld {}.into(),
            parent: None,
            at: None,
            position: [0.0; 3],
            orientation: [1.0, 0.0, 0.0, 0.0],
        }
    }

    /// The segments of its rod.
    pub fn segments(&self) -> &[Segment] {
        self.rod.as_ref().map_or(&[], |rod| &rod.segment)
    }

    fn fits(&self, reader: &mut Reader) {
        reader.require(!self.name.is_empty(), "name", "''", "a name");
        let has_segments = self.rod.is_none() || !self.segments().is_empty();
        reader.require(has_segments, "rod", "no segments", "at least one, or no rod");
        let has_both = self.rod.is_some() && self.body.is_some();
        let expected = "a rod or a body; further bodies of a robot can be on any link";
        reader.require(!has_both, "body", "a body beside a rod", expected);
        if let Some(Body { at, link, .. }) = &self.body {
            reader.check_unused("body.at", at.map(Number), "the body of a link is at its base");
            let name = link.as_ref().map(|LinkName(name)| format!("'{name}'"));
            reader.check_unused("body.link", name, "the body is that of this link");
        }
        reader.check_orientation(&self.orientation);
    }

    /// The link of a robot on the parent with this index, with what drives its joint.
    pub(crate) fn resolved(&self, parent: Option<usize>, driven: Option<Driven>) -> Resolved {
        Resolved {
            name: self.name.clone(),
            parent,
            // Without a known parent, the place on it cannot be checked.
            at: self.at.filter(|_| parent.is_some() || self.parent.is_none()),
            position: self.position,
            orientation: self.orientation,
            joint: self.joint.resolved(),
            driven,
            rod: self.segments().iter().map(Segment::resolved).collect(),
            body: self.body.as_ref().map(|body| body.resolved(0)),
        }
    }
}

impl Resolved {
    /// The description of this link on a parent of this name, with its joint as described.
    pub(crate) fn described(&self, parent: Option<LinkName>, joint: Joint) -> Link {
        let segments = self.rod.iter().map(crate::description::rod::Segment::described);
        Link {
            name: self.name.clone(),
            rod: (!self.rod.is_empty()).then(|| LinkRod { segment: segments.collect() }),
            body: self.body.as_ref().map(|body| body.described(None)),
            joint,
            parent,
            at: self.at,
            position: self.position,
            orientation: self.orientation,
        }
    }
}
