//! The target pose of a link.

use crate::error::{Checker, InvalidInput};
use crate::lie::{Quaternion, Rotation, Vector};
use crate::robot::Robot;

/// A matrix that is no rotation by more than this in any product of its columns is refused as a mistake.
const ROTATION_TOLERANCE: f64 = 1e-3;

/// Where a point of a link shall be and how its section or body shall be turned; one of both, or both.
#[derive(Clone, Debug, PartialEq)]
pub struct Target {
    /// The link, by its place among all.
    pub link: usize,
    /// Arc length of its unstretched rod in metres; `None` is the tip, and the base of a rigid link.
    pub at: Option<f64>,
    /// The point that shall be somewhere, in the axes of the section or body there, in metres.
    pub point: [f64; 3],
    /// Where it shall be in the world, in metres.
    pub position: Option<[f64; 3]>,
    /// The axes that section or body shall have in the world, as the columns of a matrix that is given by its rows.
    pub orientation: Option<[[f64; 3]; 3]>,
    /// How much the components of the position count, along the axes of the world, and those of the orientation, about
    /// the axes that are wanted; zero for those that do not matter. With weights of one, a radian counts as much as the
    /// length of the robot.
    pub weights: [[f64; 3]; 2],
}

impl Target {
    /// For the tip of a link, or its body, without any wish yet: a start for `..` syntax.
    pub fn new(link: usize) -> Self {
        let weights = [[1.0; 3]; 2];
        Self { link, at: None, point: [0.0; 3], position: None, orientation: None, weights }
    }

    /// Everything that is wrong with this target by itself.
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

    /// Notes what is wrong with it on a robot.
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
            crate::load::check_place(check, at, &place, link.length());
        }
    }

    /// The rotation to the axes that are wanted.
    pub(super) fn rotation(&self) -> Option<Quaternion<f64>> {
        let rows = self.orientation?;
        let [x, y, z] = [0, 1, 2].map(|j| Vector::from(rows.map(|row| row[j])));
        Some(Quaternion::of_rotation(&Rotation { x, y, z }))
    }
}

/// Notes a matrix that is no rotation, and why.
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
