//! Pegs, bars and pipes.

use super::{Core, Cornered, Frame, Role, Shape, shape};
use crate::description::schema::Reader;
use crate::numerics::lie::Vector;
use crate::robot::effects::contact::shapes::obstacle::Solid;

/// Number of points along a capsule for contact with height fields and tubes.
const PLACES_ON_GROUND: usize = 5;

shape! {
    /// A capsule fixed in the world, such as a peg, bar or pipe: the points within a radius of a line segment.
    #[part(tag = "capsule", called = "a capsule")]
    pub struct Capsule {
        /// Start of the line segment.
        #[part(unit = "metres")]
        pub start: [f64; 3],
        /// End of the line segment.
        #[part(unit = "metres")]
        pub end: [f64; 3],
        /// Radius.
        #[part(unit = "metres", positive)]
        pub radius: f64,
    }
}

impl Capsule {
    fn fits(&self, reader: &mut Reader) {
        reader.require(self.start != self.end, "end", "the start", "another point; a ball is a Sphere");
    }
}

impl Shape for Capsule {
    fn label(&self) -> String {
        format!("a capsule of {} m", self.radius)
    }

    fn lies_across(&self, axis: usize, height: f64) -> bool {
        self.start[axis] == height && self.end[axis] == height
    }

    fn thickness(&self) -> f64 {
        self.radius
    }

    fn solid(&self, frame: &Frame) -> Solid {
        Solid::Capsule { ends: [self.start, self.end].map(|end| frame.place(end)), radius: self.radius }
    }

    fn corners(&self) -> Option<&dyn Cornered> {
        Some(self)
    }

    fn role(&self) -> Role {
        Role::Body
    }
}

impl Cornered for Capsule {
    fn corners(&self) -> (Vec<[f64; 3]>, f64) {
        (vec![self.start, self.end], self.radius)
    }

    fn places_on_ground(&self) -> (Vec<Vector<f64>>, f64) {
        let [start, end] = [self.start, self.end].map(Vector::from);
        let place = |k: usize| start + (end - start) * (k as f64 / (PLACES_ON_GROUND - 1) as f64);
        ((0..PLACES_ON_GROUND).map(place).collect(), self.radius)
    }

    fn core(&self, _rounding: f64) -> Core {
        let corners = [self.start, self.end].map(Vector::from).to_vec();
        Core { corners, edges: vec![[0, 1]], radius: self.radius }
    }

    fn rounded(&self, _core: &Core, frame: &Frame) -> Solid {
        self.solid(frame)
    }
}
