//! Floors and walls.

use super::{Cornered, Frame, Role, Shape, shape};
use crate::description::joint::unit;
use crate::description::schema::Reader;
use crate::numerics::lie::Vector;
use crate::robot::effects::contact::shapes::obstacle::Solid;

shape! {
    /// A floor or a wall: the region behind a plane.
    #[part(tag = "half_space", called = "a half-space", positional = 2)]
    pub struct HalfSpace {
        /// A point on the plane.
        #[part(unit = "metres", default)]
        pub point: [f64; 3],
        /// Outward normal, pointing away from the solid. Its length does not matter.
        #[part(default = [0.0, 0.0, 1.0])]
        pub normal: [f64; 3],
    }
}

impl HalfSpace {
    fn fits(&self, reader: &mut Reader) {
        let expected = "a direction: away from what is filled";
        reader.require(self.normal != [0.0; 3], "normal", "(0, 0, 0)", expected);
    }
}

impl Shape for HalfSpace {
    fn label(&self) -> String {
        "a half space".to_owned()
    }

    fn lies_across(&self, axis: usize, _height: f64) -> bool {
        self.normal[axis] == 0.0
    }

    fn thickness(&self) -> f64 {
        f64::INFINITY
    }

    fn solid(&self, frame: &Frame) -> Solid {
        Solid::HalfSpace {
            point: frame.place(self.point),
            normal: frame.turn(Vector::from(unit(self.normal))),
        }
    }

    fn corners(&self) -> Option<&dyn Cornered> {
        None
    }

    fn role(&self) -> Role {
        Role::Plane
    }
}
