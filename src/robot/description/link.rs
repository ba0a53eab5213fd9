//! A link: a joint followed by a rod, a rigid body, or a frame alone.

use super::driven::Driven;
use crate::body::Body;
use crate::error::{Checker, InvalidInput};
use crate::joint::Joint;
use crate::lie::QUATERNION_TOLERANCE;
use crate::rod::{STRAIN_NAMES, Segment, piece};

/// A joint followed by a rod or a rigid body. The joint's frame lies on the parent at `position` with `orientation`,
/// in the axes of the section or body there; the joint moves the base of the link in that frame. A rod leaves its base
/// along the base's x axis.
#[derive(Clone, Debug, PartialEq)]
pub struct Link {
    /// Name by which loads, children and results refer to the link.
    pub name: String,
    /// Its place among the links of its parent, which stands before it; `None` is the world.
    pub parent: Option<usize>,
    /// Arc length of the parent's rod where it is attached, in metres; `None` is the tip, or the parent's body.
    pub at: Option<f64>,
    /// Where the joint's frame is, in metres.
    pub position: [f64; 3],
    /// How it is turned: quaternion (w, x, y, z), normalised on use.
    pub orientation: [f64; 4],
    /// How it moves there.
    pub joint: Joint,
    /// The source of the joint's coordinates; by default they are coordinates of the robot.
    pub driven: Option<Driven>,
    /// The segments of its rod, from base to tip; none where it is rigid.
    pub rod: Vec<Segment>,
    /// Its rigid body; its place is the base of the link.
    pub body: Option<Body>,
}

impl Link {
    /// A link that is welded to the world's origin, of nothing yet: a start for `..` syntax.
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

    /// Length of its unstretched rod in metres, zero of a rigid link.
    pub fn length(&self) -> f64 {
        self.rod.iter().map(|segment| segment.length).sum()
    }

    /// The names of the coordinates of its joint that are the robot's: none where that is driven.
    pub fn joint_coordinates(&self) -> &'static [&'static str] {
        if self.driven.is_none() { self.joint.coordinates() } else { &[] }
    }

    /// Number of its coordinates: those of the joint unless it is driven, then those of the rod.
    pub fn coordinates(&self) -> usize {
        self.joint_coordinates().len() + self.rod.iter().map(Segment::coordinates).sum::<usize>()
    }

    /// The names of its coordinates, in their order: `angle`, `bend_y[0]`; with the segment where there are several,
    /// `segment[1].bend_y[0]`.
    pub fn coordinate_names(&self) -> Vec<String> {
        let mut names: Vec<String> = self.joint_coordinates().iter().map(|&name| name.to_owned()).collect();
        for (s, segment) in self.rod.iter().enumerate() {
            let of_segment = if self.rod.len() > 1 { format!("segment[{s}].") } else { String::new() };
            // Of piecewise constant strains the pieces are counted, of others the modes.
            for (p, piece) in piece::of(segment).enumerate() {
                for (strain, &modes) in STRAIN_NAMES.iter().zip(&piece.modes) {
                    names.extend((p..p + modes).map(|k| format!("{of_segment}{strain}[{k}]")));
                }
            }
        }
        names
    }

    /// Everything that is wrong with this link by itself.
    pub fn validate(&self) -> Result<(), InvalidInput> {
        let mut check = Checker::new();
        check.require(!self.name.is_empty(), "name", "''", "a name");
        if let Some(at) = self.at {
            // How long the parent is, if it has a rod, the robot knows.
            crate::load::check_place(&mut check, at, "at", f64::INFINITY);
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

/// Notes an orientation that is none.
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
