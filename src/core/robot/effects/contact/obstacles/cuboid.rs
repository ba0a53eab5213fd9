//! Boxes.

use super::corners::mean;
use super::{Core, Cornered, Frame, Role, Shape, shape};
use crate::description::schema::Reader;
use crate::numerics::lie::{Quaternion, Vector};
use crate::robot::effects::contact::shapes::obstacle::Solid;

shape! {
    /// A box with sharp edges, fixed in the world or to a link.
    ///
    /// Against boxes, meshes and capsules its edges are rounded by 0.04 of half the thickness of the thinner body.
    #[part(name = "Box", tag = "box", called = "a box", positional = 3)]
    pub struct Cuboid {
        /// Centre.
        #[part(unit = "metres")]
        pub centre: [f64; 3],
        /// Half the edge lengths.
        #[part(unit = "metres", positive)]
        pub half_extents: [f64; 3],
        /// Orientation of its axes: unit quaternion (w, x, y, z).
        #[part(default = [1.0, 0.0, 0.0, 0.0])]
        pub orientation: [f64; 4],
    }
}

impl Cuboid {
    fn fits(&self, reader: &mut Reader) {
        reader.check_orientation(&self.orientation);
    }

    /// Corners of a box with other half extents: bit i of the index is the side along axis i.
    fn corners_at(&self, half_extents: [f64; 3]) -> Vec<Vector<f64>> {
        let axes = Quaternion::from_array(self.orientation).rotation();
        let corner = |k: usize| {
            let beside = std::array::from_fn(|i| half_extents[i] * if k >> i & 1 == 0 { -1.0 } else { 1.0 });
            Vector::from(self.centre) + axes.apply(Vector::from(beside))
        };
        (0..8).map(corner).collect()
    }

    /// The box around this core.
    fn rounded_by(&self, radius: f64, frame: &Frame) -> Solid {
        Solid::Cuboid {
            centre: frame.place(self.centre),
            axes: frame.axes(self.orientation),
            half_extents: Vector::from(self.half_extents) - Vector::from([radius; 3]),
            radius,
        }
    }
}

fn edges() -> Vec<[usize; 2]> {
    let along = |i: usize| (0..8).filter(move |k| k >> i & 1 == 0).map(move |k| [k, k | 1 << i]);
    (0..3).flat_map(along).collect()
}

impl Shape for Cuboid {
    fn label(&self) -> String {
        "a box".to_owned()
    }

    /// The nearest point may be anywhere.
    fn lies_across(&self, _axis: usize, _height: f64) -> bool {
        false
    }

    fn thickness(&self) -> f64 {
        self.half_extents.iter().copied().fold(f64::INFINITY, f64::min)
    }

    fn solid(&self, frame: &Frame) -> Solid {
        self.rounded_by(0.0, frame)
    }

    fn corners(&self) -> Option<&dyn Cornered> {
        Some(self)
    }

    fn role(&self) -> Role {
        Role::Body
    }
}

impl Cornered for Cuboid {
    fn corners(&self) -> (Vec<[f64; 3]>, f64) {
        (self.corners_at(self.half_extents).into_iter().map(Vector::to_array).collect(), 0.0)
    }

    fn places_on_ground(&self) -> (Vec<Vector<f64>>, f64) {
        let corners = self.corners_at(self.half_extents);
        let mut places = corners.clone();
        places.extend(edges().iter().map(|&[p, q]| mean(&[corners[p], corners[q]])));
        for i in 0..3 {
            for side in 0..2 {
                let face: Vec<_> = (0..8).filter(|k| k >> i & 1 == side).map(|k| corners[k]).collect();
                places.push(mean(&face));
            }
        }
        (places, 0.0)
    }

    fn core(&self, rounding: f64) -> Core {
        let corners = self.corners_at(self.half_extents.map(|half| half - rounding));
        Core { corners, edges: edges(), radius: rounding }
    }

    fn rounded(&self, core: &Core, frame: &Frame) -> Solid {
        self.rounded_by(core.radius, frame)
    }
}
