//! Convex bodies with flat faces.

use std::sync::Arc;

use super::corners::mean;
use super::{Core, Cornered, Frame, Role, Shape, convexity, shape};
use crate::description::schema::Reader;
use crate::error::Checker;
use crate::numerics::lie::Vector;
use crate::robot::effects::contact::shapes::convex_mesh::ConvexMesh as Mesh;
use crate::robot::effects::contact::shapes::obstacle::Solid;

shape! {
    /// A convex body with flat faces, rounded by a radius.
    #[part(tag = "convex_mesh", called = "a convex mesh", positional = 3)]
    pub struct ConvexMesh {
        /// Corners, 4 to 2000. Every corner belongs to a face.
        #[part(unit = "metres")]
        pub points: Vec<[f64; 3]>,
        /// Triangles, as indices into `points` (from 0) in any order. They must enclose the body.
        pub faces: Vec<[usize; 3]>,
        /// Rounding radius. The body grows by this radius on all sides.
        #[part(unit = "metres", non_negative, default = 0.0)]
        pub radius: f64,
    }
}

impl ConvexMesh {
    fn fits(&self, reader: &mut Reader) {
        let mut check = Checker::new();
        convexity::check(&mut check, &self.points, &self.faces);
        reader.nested(check);
    }

    fn vertices(&self) -> Vec<Vector<f64>> {
        self.points.iter().map(|&point| Vector::from(point)).collect()
    }

    fn mesh(&self) -> Mesh {
        Mesh::new(&self.vertices(), &self.faces, self.radius)
    }
}

impl Shape for ConvexMesh {
    fn label(&self) -> String {
        format!("a convex mesh of {} points", self.points.len())
    }

    /// The nearest point may be anywhere.
    fn lies_across(&self, _axis: usize, _height: f64) -> bool {
        false
    }

    fn thickness(&self) -> f64 {
        self.mesh().thickness(&self.vertices())
    }

    fn solid(&self, frame: &Frame) -> Solid {
        Solid::ConvexMesh(Arc::new(Mesh::new(&frame.places(&self.points), &self.faces, self.radius)))
    }

    fn corners(&self) -> Option<&dyn Cornered> {
        Some(self)
    }

    fn role(&self) -> Role {
        Role::Body
    }
}

impl Cornered for ConvexMesh {
    fn corners(&self) -> (Vec<[f64; 3]>, f64) {
        (self.points.clone(), self.radius)
    }

    fn places_on_ground(&self) -> (Vec<Vector<f64>>, f64) {
        let corners = self.vertices();
        let mut places = corners.clone();
        places.extend(self.mesh().edges().iter().map(|&[p, q]| mean(&[corners[p], corners[q]])));
        places.extend(self.faces.iter().map(|face| mean(&face.map(|p| corners[p]))));
        (places, self.radius)
    }

    fn core(&self, rounding: f64) -> Core {
        let (mesh, corners) = (self.mesh(), self.vertices());
        let edges = mesh.edges();
        if self.radius > 0.0 {
            return Core { corners, edges, radius: self.radius };
        }
        Core { corners: mesh.inset(&corners, rounding), edges, radius: rounding }
    }

    fn rounded(&self, core: &Core, frame: &Frame) -> Solid {
        let points = core.corners.iter().map(|corner| corner.to_array()).collect();
        Self { points, faces: self.faces.clone(), radius: core.radius }.solid(frame)
    }
}
