//! A joint with one coordinate, compiled: the part beyond it moves along one twist.

use super::space::Space;
use crate::joint::JointForces;
use crate::lie::Twist;

/// A joint of one coordinate.
#[derive(Clone, Debug)]
pub(crate) struct Hinge<G: Space> {
    /// The unit twist of what lies behind it, in the axes of the place before it: a turn or a shift.
    pub(crate) twist: Twist<G, f64>,
    /// Whether it is a turn.
    pub(crate) turns: bool,
    /// Forces on its coordinate, if there are any.
    pub(crate) forces: Option<JointForces>,
    /// Its place among all hinges.
    pub(crate) index: usize,
}
