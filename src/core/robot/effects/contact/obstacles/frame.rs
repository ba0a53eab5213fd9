//! Axes in which shapes are computed.

use crate::numerics::lie::{Quaternion, Rotation, Vector};

/// The map from the axes in which a shape is described to those in which it is computed.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Frame {
    rotation: Rotation<f64>,
    position: Vector<f64>,
    /// Whether rotation and position are those of the axes of computation in the axes of the description.
    is_inverse: bool,
}

impl Frame {
    /// The frame of a shape that is described in axes with this pose.
    pub(crate) fn of(rotation: Rotation<f64>, position: Vector<f64>) -> Self {
        Self { rotation, position, is_inverse: false }
    }

    /// The frame of a shape that is computed in axes with this pose.
    pub(crate) fn relative_to(rotation: Rotation<f64>, position: Vector<f64>) -> Self {
        Self { rotation, position, is_inverse: true }
    }

    pub(crate) fn turn(&self, v: Vector<f64>) -> Vector<f64> {
        if self.is_inverse { self.rotation.apply_transposed(v) } else { self.rotation.apply(v) }
    }

    pub(crate) fn place(&self, point: [f64; 3]) -> Vector<f64> {
        let point = Vector::from(point);
        if self.is_inverse { self.turn(point - self.position) } else { self.position + self.turn(point) }
    }

    pub(crate) fn places(&self, points: &[[f64; 3]]) -> Vec<Vector<f64>> {
        points.iter().map(|&point| self.place(point)).collect()
    }

    /// Axes with this orientation: unit quaternion (w, x, y, z).
    pub(crate) fn axes(&self, orientation: [f64; 4]) -> Rotation<f64> {
        let Rotation { x, y, z } = Quaternion::from_array(orientation).rotation();
        Rotation { x: self.turn(x), y: self.turn(y), z: self.turn(z) }
    }
}
