//! A link: a joint followed by a rod, a rigid body, or only a frame.

pub(super) mod described;

use super::driven::Driven;
use crate::description::body::Body;
use crate::description::joint::Joint;
use crate::description::rod::{STRAIN_NAMES, Segment, piece};
use crate::error::{Checker, InvalidInput};
use crate::numerics::lie::QUATERNION_TOLERANCE;

/// A joint followed by a rod or a rigid body. The joint's frame has `position` and `orientation` in the axes
/// of the parent's section or body; the joint moves the base of the link relative to this frame. A rod starts
/// along the x axis of the base.
#[derive(Clone, Debug, PartialEq)]
pub struct Link {
    /// Name by which loads, children and results refer to the link.
    pub name: String,
    /// Index of the parent, which precedes the link; `None` is the world.
    pub parent: Option<usize>,
    /// Arc length on the parent's rod at which the link is attached, in metres; `None` is the tip, or the
    /// parent's body.
    pub at: Option<f64>,
    /// Position of the joint's frame, in metres.
    pub position: [f64; 3],
    /// Orientation of the joint's frame: quaternion (w, x, y, z), normalised on use.
    pub orientation: [f64; 4],
    /// The joint.
    pub joint: Joint,
    /// Source of the joint's coordinates if it is driven; otherwise they are coordinates of the robot.
    pub driven: Option<Driven>,
    /// Segments of the rod, from base to tip; empty for a rigid link.
    pub rod: Vec<Segment>,
    /// Rigid body, located at the base of the link.
    pub body: Option<Body>,
}

impl Link {
    /// An empty link welded to the world's origin: a start for `..` syntax.
    pub fn new(name: impl Into<String>) -> Self {
        Self {
            name: name.into(),
            parent: None,
            at: None,
            position: [0.0; 3],
            orientation: [1.0, 0.0, 0.0, 0.0],
            joint: Joint::Weld,
            driven: None,
            rod: Vec::new(),
            body: None,
        }
    }

    /// Length of the unstretched rod in metres; zero for a rigid link.
    pub fn length(&self) -> f64 {
        self.rod.iter().map(|segment| segment.length).sum()
    }

    /// Names of the joint's coordinates; empty for a driven joint.
    pub fn joint_coordinates(&self) -> &'static [&'static str] {
        if self.driven.is_none() { self.joint.coordinates() } else { &[] }
    }

    /// Number of coordinates: those of the joint unless it is driven, then those of the rod.
    pub fn coordinates(&self) -> usize {
        self.joint_coordinates().len() + self.rod.iter().map(Segment::coordinates).sum::<usize>()
    }

    /// Names of the coordinates in order: `angle`, `bend_y[0]`; with the segment if there are several,
    /// `segment[1].bend_y[0]`.
    pub fn coordinate_names(&self) -> Vec<String> {
        let mut names: Vec<String> = self.joint_coordinates().iter().map(|&name| name.to_owned()).collect();
        for (s, segment) in self.rod.iter().enumerate() {
            let of_segment = if self.rod.len() > 1 { format!("segment[{s}].") } else { String::new() };
            // The index counts pieces for piecewise constant strains, and modes otherwise.
            for (p, piece) in piece::of(segment).enumerate() {
                for (strain, &modes) in STRAIN_NAMES.iter().zip(&piece.modes) {
                    names.extend((p..p + modes).map(|k| format!("{of_segment}{strain}[{k}]")));
                }
            }
        }
        names
    }

    /// Reports every problem of this link, without the robot.
    pub fn validate(&self) -> Result<(), InvalidInput> {
        let mut check = Checker::new();
        check.require(!self.name.is_empty(), "name", "''", "a name");
        if let Some(at) = self.at {
            // The length of the parent's rod is known only to the robot's validation.
            crate::description::rod::arc_length::check_place(&mut check, at, "at", f64::INFINITY);
        }
        check.finite(&self.position, "position");
        check_orientation(&mut check, &self.orientation, "orientation");
        check.nested("joint", self.joint.validate());
        if let Some(driven) = &self.driven {
            check.nested("joint", driven.validate(&self.joint));
        }
        let has_both = !self.rod.is_empty() && self.body.is_some();
        let expected = "a rod or a body; further bodies of a robot can be on any link";
        check.require(!has_both, "body", "a body beside a rod", expected);
        for (i, segment) in self.rod.iter().enumerate() {
            check.nested(&format!("rod[{i}]"), segment.validate());
        }
        if let Some(body) = &self.body {
            check.nested("body", body.validate(0.0));
            check.require(
                body.at.is_none(),
                "body.at",
                "an arc length",
                "none: it is at the base of the link",
            );
        }
        check.finish()
    }
}

/// Reports an invalid orientation.
pub(super) fn check_orientation(check: &mut Checker, orientation: &[f64; 4], place: &str) {
    if check.finite(orientation, place) {
        let norm = orientation.iter().map(|x| x * x).sum::<f64>().sqrt();
        check.require(
            (norm - 1.0).abs() <= QUATERNION_TOLERANCE,
            place,
            format_args!("a quaternion of norm {norm}"),
            "a quaternion (w, x, y, z) of norm 1",
        );
    }
}
