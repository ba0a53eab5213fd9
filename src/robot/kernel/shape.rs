//! The columns of S: what the places beyond a node do when a strain there changes.

use crate::lie::{Cross, Twist, VectorSpace};
use crate::robot::turning::Turning;

/// The twist, seen from the origin, of all that lies behind a node with this rotation and position, for a unit of the
/// strain component `index` there: a column of `Ad_g`.
#[inline(always)]
pub(crate) fn shape<G: Turning>(
    rotation: &G::Rotation<G::Pack>,
    position: G::Vector<G::Pack>,
    index: usize,
) -> Twist<G, G::Pack> {
    if index < G::ANGULAR {
        let axis = G::angular_axis(rotation, index);
        Twist { angular: axis, linear: position.cross(axis) }
    } else {
        Twist { angular: VectorSpace::zero(), linear: G::linear_axis(rotation, index - G::ANGULAR) }
    }
}
