//! Drive motion of a base as users describe it.

use super::base_motion::{self, BaseRotation};
use crate::description::schema::{Described, Fault, Reader};
use crate::description::signal::Drive;
use crate::error::Checker;

/// Drive motion of the base of a rod, as a function of time.
///
/// The base is at ``base_position + translation(t)``. Its axes are those of ``base_orientation``, rotated by ``rotation(t)``
/// or by ``angle(t)`` about `axis`.
///
/// The motion needs velocities and accelerations. A table is interpolated by a twice continuously differentiable cubic
/// spline (quaternions in R^4 and normalised; consecutive ones must differ by less than a right angle) and must cover the
/// time of a run. Its interpolation may also be 'monotone', by cubic pieces that do not overshoot and have a continuous
/// velocity (PCHIP; Fritsch and Butland 1984), or 'linear', held constant outside: the velocity then jumps at corners, and
/// velocities of the model jump by the impulse (``docs/time.md``).
///
/// A callable of Python returns the value, or a tuple of value, velocity and acceleration: for `translation` in m/s and
/// m/s^2, for `angle` in rad/s and rad/s^2, for `rotation` the angular velocity and angular acceleration in world axes, three
/// numbers each. Without derivatives they are computed by finite differences (nine values or more, up to 4 ms before and
/// after). A ValueError that names the time is raised if values are not finite, quaternions do not have norm 1, or derivatives
/// cannot be found or contradict the values; in a run, its attribute `result` is the partial result.
#[derive(Clone, Debug, PartialEq, Described)]
#[part(brief, check = BaseMotion::fits, example = include_str!("base_motion_example.txt"))]
pub struct BaseMotion {
    /// Displacement in world axes.
    #[part(unit = "metres", default)]
    pub translation: Drive<3>,
    /// Axis of the rotation in world axes. Its length does not matter.
    pub axis: Option<[f64; 3]>,
    /// Angle about `axis`.
    #[part(unit = "radians")]
    pub angle: Option<Drive<1>>,
    /// Rotation in world axes as a unit quaternion (w, x, y, z); instead of `axis` and `angle`.
    pub rotation: Option<Drive<4>>,
}

impl BaseMotion {
    fn fits(&self, reader: &mut Reader) {
        let Self { axis, angle, rotation, .. } = self;
        if rotation.is_some() && (axis.is_some() || angle.is_some()) {
            reader.refuse("rotation", Fault::Both(["rotation", "axis or angle"]));
        }
        let mut needs = |key, needed, meaning| reader.refuse(key, Fault::Without { key, needed, meaning });
        match (axis, angle) {
            (None, Some(_)) => needs("angle", "axis", "the axis of the angle"),
            (Some(_), None) => needs("axis", "angle", "an angle about the axis"),
            _ => {}
        }
        let mut check = Checker::new();
        check.all(self.resolved().validate());
        reader.nested(check);
    }

    /// The motion of a robot's base.
    pub fn resolved(&self) -> base_motion::BaseMotion {
        let rest = base_motion::BaseMotion::rest();
        let rotation = match (&self.rotation, self.axis, &self.angle) {
            (Some(Drive(quaternion)), ..) => BaseRotation::By(quaternion.clone()),
            (None, Some(axis), Some(Drive(angle))) => BaseRotation::About { axis, angle: angle.clone() },
            _ => rest.rotation,
        };
        base_motion::BaseMotion { translation: self.translation.0.clone(), rotation }
    }
}

impl base_motion::BaseMotion {
    /// The description of this motion.
    pub fn described(&self) -> BaseMotion {
        let (mut axis, mut angle, mut rotation) = (None, None, None);
        match &self.rotation {
            BaseRotation::About { angle: signal, .. } if signal.is_zero() => {}
            BaseRotation::About { axis: about, angle: signal } => {
                (axis, angle) = (Some(*about), Some(Drive(signal.clone())));
            }
            BaseRotation::By(quaternion) => rotation = Some(Drive(quaternion.clone())),
        }
        BaseMotion { translation: Drive(self.translation.clone()), axis, angle, rotation }
    }
}
