//! The anchor of a support with its springs and dampers, in the frame of the base.

use crate::description::world::base_motion::Base;
use crate::numerics::lie::{Rotation, Symmetric, Vector};

/// An anchor with its springs and dampers, in the frame of the base.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Anchor {
    pub(crate) position: Vector<f64>,
    pub(crate) axes: Rotation<f64>,
    /// Velocity relative to the frame that follows the base: zero for a base at rest.
    pub(crate) velocity: Vector<f64>,
    pub(crate) along_axes: AlongAxes,
    pub(crate) stiffness: Symmetric<f64>,
    pub(crate) damping: Symmetric<f64>,
    /// Factors c of the rotational potential (see [`Support`]).
    pub(crate) turning: [f64; 3],
    pub(crate) rotational_damping: Symmetric<f64>,
    /// Moment and force that replace those of the springs.
    pub(crate) fixed_forces: Option<[Vector<f64>; 2]>,
}

/// Coefficients of a support along and about the axes of its anchor.
#[derive(Clone, Copy, Debug)]
pub(crate) struct AlongAxes {
    pub(crate) stiffness: [f64; 3],
    pub(crate) damping: [f64; 3],
    pub(crate) rotational_damping: [f64; 3],
}

impl Anchor {
    pub(crate) fn new(
        position: Vector<f64>,
        axes: Rotation<f64>,
        turning: [f64; 3],
        along_axes: AlongAxes,
    ) -> Self {
        let about = |diagonal: [f64; 3]| {
            let mut sum = Symmetric::diagonal(0.0);
            for (i, value) in diagonal.into_iter().enumerate() {
                sum += Symmetric::square(axes.axis(i)) * value;
            }
            sum
        };
        Self {
            stiffness: about(along_axes.stiffness),
            damping: about(along_axes.damping),
            rotational_damping: about(along_axes.rotational_damping),
            velocity: Vector::from([0.0; 3]),
            position,
            axes,
            turning,
            along_axes,
            fixed_forces: None,
        }
    }

    /// Replaces moment and force of the springs by these values for any pose; `None` undoes that.
    pub(crate) fn hold(&mut self, forces: Option<[Vector<f64>; 2]>) {
        self.fixed_forces = forces;
    }

    /// An anchor given in the frame of the base at rest, relative to the current base.
    pub(crate) fn relative_to(&self, base: &Base, at_rest: &Base) -> Self {
        let turned = |v: Vector<f64>| base.rotation.apply_transposed(at_rest.rotation.apply(v));
        let [position, velocity] = base.point_in_frame(self.position, at_rest);
        let Rotation { x, y, z } = self.axes;
        let axes = Rotation { x: turned(x), y: turned(y), z: turned(z) };
        Self { velocity, ..Self::new(position, axes, self.turning, self.along_axes) }
    }

    pub(crate) fn is_damped(&self) -> bool {
        let none = Symmetric::diagonal(0.0);
        self.damping != none || self.rotational_damping != none
    }
}
