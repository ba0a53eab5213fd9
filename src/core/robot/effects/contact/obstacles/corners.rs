//! Bodies with corners and edges.

use super::Frame;
use crate::numerics::lie::Vector;
use crate::robot::effects::contact::shapes::obstacle::Solid;

/// A body with corners, as contacts use it.
pub(crate) trait Cornered {
    /// Points that touch a half-space first, and the radius around them.
    fn corners(&self) -> (Vec<[f64; 3]>, f64);

    /// Points that touch uneven ground and walls of tubes, and the radius around them: corners, and middles of edges and faces; of a
    /// capsule points along it.
    fn places_on_ground(&self) -> (Vec<Vector<f64>>, f64);

    /// The core of the body, with sharp edges rounded by a radius.
    fn core(&self, rounding: f64) -> Core;

    /// The rounded body, which has this core, as a solid for the corners and edges of another.
    fn rounded(&self, core: &Core, frame: &Frame) -> Solid;
}

/// Core of a body: the body consists of all points within a radius of it.
pub(crate) struct Core {
    pub(crate) corners: Vec<Vector<f64>>,
    pub(crate) edges: Vec<[usize; 2]>,
    pub(crate) radius: f64,
}

/// The middle of points.
pub(super) fn mean(points: &[Vector<f64>]) -> Vector<f64> {
    let sum = points.iter().fold(Vector::zero(), |sum, &point| sum + point);
    sum * (points.len() as f64).recip()
}
