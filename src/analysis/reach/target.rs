//! The target pose of a link.

use crate::error::{Checker, InvalidInput};
use crate::numerics::lie::{Quaternion, Rotation, Vector};
use crate::robot::Robot;

/// Tolerated deviation of the products of a rotation matrix's columns; larger deviations are rejected as a
/// mistake.
const ROTATION_TOLERANCE: f64 = 1e-3;

/// Target position of a point of a link, target orientation of its section or body, or both.
#[derive(Clone, Debug, PartialEq)]
pub struct Target {
    /// Index of the link in the robot.
    pub link: usize,
    /// Arc length on the link's unstretched rod in metres; `None` is the tip, or the base of a rigid link.
    pub at: Option<f64>,
    /// The point, in the axes of that section or body, in metres.
    pub point: [f64; 3],
    /// Target position in the world, in metres.
    pub position: Option<[f64; 3]>,
    /// Target axes of the section or body in the world: columns of a matrix given by its rows.
    pub orientation: Option<[[f64; 3]; 3]>,
    /// Weights of the position error along the axes of the world, and of the orientation error about the
    /// target axes; zero ignores a component. With weights of one, a radian counts as much as the length of
    /// the robot.
    pub weights: [[f64; 3]; 2],
}

impl Target {
    /// No target yet, for the tip of a link or its body: a start for `..` syntax.
    pub fn new(link: usize) -> Self {
        let weights = [[1.0; 3]; 2];
        Self { link, at: None, point: [0.0; 3], position: None, orientation: None, weights }
    }

    /// Reports every problem of this target, without the robot.
    pub fn validate(&self) -> Result<(), InvalidInput> {
        let mut check = Checker::new();
        check.finite(&self.point, "point");
        let is_given = self.position.is_some() || self.orientation.is_some();
        check.require(is_given, "pose", "nothing", "a position, an orientation, or both");
        if let Some(position) = &self.position {
            check.finite(position, "position");
        }
        if let Some(orientation) = &self.orientation {
            check_rotation(&mut check, orientation);
        }
        let mut largest = 0.0_f64;
        for ((weights, name), is_given) in self
            .weights
            .iter()
            .zip(["position_weight", "orientation_weight"])
            .zip([self.position.is_some(), self.orientation.is_some()])
        {
            for (i, &weight) in weights.iter().enumerate() {
                check.non_negative(weight, &format!("{name}[{i}]"), "no unit");
                largest = if is_given { largest.max(weight) } else { largest };
            }
        }
        let expected = "a weight > 0 for something that is wanted";
        check.require(!check.is_ok() || largest > 0.0, "position_weight", "no weight at all", expected);
        check.finish()
    }

    /// Reports problems of the target on a robot.
    pub(crate) fn check(&self, check: &mut Checker, place: &str, robot: &Robot) {
        check.nested(place, self.validate());
        let Some(link) = robot.links.get(self.link) else {
            let expected = format!("a link, 0 to {}", robot.links.len() - 1);
            check.require(false, &format!("{place}.link"), self.link, &expected);
            return;
        };
        let Some(at) = self.at else { return };
        let place = format!("{place}.X");
        if link.rod.is_empty() {
            let found = format_args!("{at} on '{}', which has no rod", link.name);
            check.require(false, &place, found, "None: the body of the link");
        } else {
            crate::description::rod::arc_length::check_place(check, at, &place, link.length());
        }
    }

    /// Rotation to the target axes.
    pub(super) fn rotation(&self) -> Option<Quaternion<f64>> {
        let rows = self.orientation?;
        let [x, y, z] = [0, 1, 2].map(|j| Vector::from(rows.map(|row| row[j])));
        Some(Quaternion::of_rotation(&Rotation { x, y, z }))
    }
}

/// Reports a matrix that is not a rotation, and why.
fn check_rotation(check: &mut Checker, rows: &[[f64; 3]; 3]) {
    let place = "orientation";
    let finite = rows.iter().enumerate().all(|(i, row)| check.finite(row, &format!("{place}[{i}]")));
    if !finite {
        return;
    }
    let columns = [0, 1, 2].map(|j| Vector::from(rows.map(|row| row[j])));
    let [x, y, z] = columns;
    for (j, column) in columns.iter().enumerate() {
        let length = column.dot(*column).sqrt();
        let found = format_args!("a column {j} of length {length}");
        let ok = (length - 1.0).abs() <= ROTATION_TOLERANCE;
        if !check.require(ok, place, found, "a rotation matrix: columns of length 1") {
            return;
        }
    }
    for (a, b, names) in [(x, y, "0 and 1"), (x, z, "0 and 2"), (y, z, "1 and 2")] {
        let cosine = a.dot(b);
        let found = format_args!("columns {names} with the scalar product {cosine}");
        let ok = cosine.abs() <= ROTATION_TOLERANCE;
        if !check.require(ok, place, found, "a rotation matrix: columns at right angles") {
            return;
        }
    }
    let expected = "a rotation matrix: a determinant of 1";
    check.require(x.cross(y).dot(z) > 0.0, place, "a reflection: its determinant is -1", expected);
}
