//! Vessels, pipes, guides and rings.

use std::sync::Arc;

use super::{Cornered, Frame, Role, Shape, shape};
use crate::description::schema::Reader;
use crate::error::{Checker, InvalidInput, Number};
use crate::numerics::lie::Vector;
use crate::robot::effects::contact::shapes::centre_line::{CentreLine, Tightest};
use crate::robot::effects::contact::shapes::obstacle::Solid;
use crate::robot::effects::contact::shapes::tube::Tube as Wall;

/// Maximum number of points: more would be a mistake in the input rather than a model of a vessel.
const MOST_POINTS: usize = 1000;

shape! {
    /// A tube with open ends: a vessel, a pipe, a guide or a ring, in which rods and balls are, or outside of it.
    ///
    /// The centre line is a smooth curve through the points, the cubic spline over the lengths of the chords between them, which bulges
    /// where a straight part ends in a bend: give more points there. Two points are a straight tube, and a short one is a ring, or the hole of a guide. Beyond its ends, whose planes are across the centre
    /// line, there is no wall; rods may leave through them, and touch their rims. A closed end is a `HalfSpace` across the tube, in a contact
    /// of its own. Rods and balls must be thinner than the bore, and round; what starts deep in the wall is refused, as with other shapes.
    #[part(tag = "tube", called = "a tube")]
    pub struct Tube {
        /// Points of the centre line, 2 to 1000, from one end to the other.
        #[part(unit = "metres")]
        pub points: Vec<[f64; 3]>,
        /// Radius of the bore. It must be smaller than the radius at which the centre line bends, and than half of the way
        /// between places where the tube comes back to itself.
        #[part(unit = "metres", positive)]
        pub radius: f64,
        /// Thickness of the wall, by default the radius. What is pushed further than half of it leaves through the other side.
        #[part(unit = "metres", positive)]
        pub wall: Option<f64>,
    }
}

impl Tube {
    fn fits(&self, reader: &mut Reader) {
        let mut found = Checker::new();
        check(&mut found, &self.points, self.radius);
        reader.nested(found);
    }

    /// Thickness of the wall, metres.
    fn thickness_of_wall(&self) -> f64 {
        self.wall.unwrap_or(self.radius)
    }
}

impl Shape for Tube {
    fn label(&self) -> String {
        format!("a tube with a bore of {} m", self.radius)
    }

    fn lies_across(&self, axis: usize, height: f64) -> bool {
        self.points.iter().all(|point| point[axis] == height)
    }

    fn thickness(&self) -> f64 {
        0.5 * self.thickness_of_wall()
    }

    fn solid(&self, frame: &Frame) -> Solid {
        Solid::Tube(Arc::new(Wall::new(&frame.places(&self.points), self.radius, self.thickness_of_wall())))
    }

    fn corners(&self) -> Option<&dyn Cornered> {
        None
    }

    fn role(&self) -> Role {
        Role::Ground
    }
}

/// Reports all problems of a centre line and a radius.
fn check(check: &mut Checker, points: &[[f64; 3]], radius: f64) {
    let number = points.len();
    let mut is_right = check.require(
        (2..=MOST_POINTS).contains(&number),
        "points",
        format_args!("{number} points"),
        &format!("the centre line: 2 to {MOST_POINTS} points, of a straight tube its two ends"),
    );
    for (i, point) in points.iter().enumerate() {
        is_right &= check.finite(point, &format!("points[{i}]"));
    }
    for (i, ends) in points.windows(2).enumerate() {
        let place = format!("points[{}]", i + 1);
        is_right &= check.require(ends[0] != ends[1], &place, "the point before it", "another point");
    }
    if !is_right {
        return;
    }
    let points: Vec<_> = points.iter().map(|&point| Vector::from(point)).collect();
    let Tightest { place, radius: most } = CentreLine::new(&points).tightest();
    let [x, y, z] = place.to_array();
    let expected = format!(
        "less than {most:.4} m: the curve through the points bends as tightly as that, or comes as near to itself, at ({x:.4}, \
         {y:.4}, {z:.4}) m"
    );
    check.require(radius < most, "radius", Number(radius), &expected);
}

/// Number of places for drawings on each part of a centre line, which turns by less than half a radian.
const DRAWN: usize = 4;

/// Places along the smooth centre line of a tube through points, for drawings.
///
/// # Errors
///
/// The problems of the points.
pub fn centre_line(points: &[[f64; 3]]) -> Result<Vec<[f64; 3]>, InvalidInput> {
    let mut found = Checker::new();
    check(&mut found, points, 0.0);
    found.finish()?;
    let points: Vec<_> = points.iter().map(|&point| Vector::from(point)).collect();
    Ok(CentreLine::new(&points).places(DRAWN).into_iter().map(Vector::to_array).collect())
}
