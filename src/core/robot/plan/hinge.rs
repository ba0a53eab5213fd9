//! A compiled joint with one coordinate: everything beyond it moves along one twist.

use super::space::Space;
use crate::description::joint::JointForces;
use crate::numerics::lie::Twist;

/// A joint of one coordinate.
#[derive(Clone, Debug)]
pub(crate) struct Hinge<G: Space> {
    /// Unit twist of everything beyond the joint, in the axes before it: a rotation or a translation.
    pub(crate) twist: Twist<G, f64>,
    /// Whether the twist is a rotation.
    pub(crate) turns: bool,
    /// Forces on the coordinate, if any.
    pub(crate) forces: Option<JointForces>,
    /// Index among all hinges.
    pub(crate) index: usize,
}
