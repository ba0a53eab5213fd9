//! Spheres.

use super::{Cornered, Frame, Role, Shape, shape};
use crate::description::schema::Reader;
use crate::robot::effects::contact::shapes::obstacle::Solid;

shape! {
    /// A sphere fixed in the world or to a link.
    #[part(tag = "sphere", called = "a sphere")]
    pub struct Sphere {
        /// Centre.
        #[part(unit = "metres")]
        pub centre: [f64; 3],
        /// Radius.
        #[part(unit = "metres", positive)]
        pub radius: f64,
    }
}

impl Sphere {
    /// Every sphere is one.
    fn fits(&self, _reader: &mut Reader) {}
}

impl Shape for Sphere {
    fn label(&self) -> String {
        format!("a sphere of {} m", self.radius)
    }

    fn lies_across(&self, axis: usize, height: f64) -> bool {
        self.centre[axis] == height
    }

    fn thickness(&self) -> f64 {
        self.radius
    }

    fn solid(&self, frame: &Frame) -> Solid {
        Solid::Ball { centre: frame.place(self.centre), radius: self.radius }
    }

    fn corners(&self) -> Option<&dyn Cornered> {
        None
    }

    fn role(&self) -> Role {
        Role::Body
    }
}
