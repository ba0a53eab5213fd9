//! Twists in other frames.

use crate::numerics::lie::{Cross, Scalar, Twist};
use crate::robot::turning::Turning;

/// Twist of a body-frame strain at a place: `Ad_g (angular; linear)`.
#[inline(always)]
pub(crate) fn carried<G: Turning, T: Scalar>(
    rotation: &G::Rotation<T>,
    position: G::Vector<T>,
    strain: Twist<G, T>,
    is_extensible: bool,
) -> Twist<G, T> {
    let angular = G::rotate_axial(rotation, strain.angular);
    let mut linear = position.cross(angular);
    if is_extensible {
        linear += G::rotate(rotation, strain.linear);
    }
    Twist { angular, linear }
}
