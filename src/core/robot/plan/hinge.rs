//! A compiled joint with one coordinate: everything beyond it moves along one twist.

use super::space::Space;
use crate::description::joint::JointForces;
use crate::numerics::lie::Twist;

/// A joint of one coordinate.
#[derive(Clone, Debug)]
pub(crate) struct Hinge<G: Space> {
    /// Twist of everything beyond the joint by a unit of the coordinate, in the axes before it: a rotation, a translation, or
    /// both along one axis.
    pub(crate) twist: Twist<G, f64>,
    /// Whether the twist rotates.
    pub(crate) turns: bool,
    /// Whether it translates.
    pub(crate) advances: bool,
    /// Forces on the coordinate, if any.
    pub(crate) forces: Option<JointForces>,
    /// Index among all hinges.
    pub(crate) index: usize,
}
