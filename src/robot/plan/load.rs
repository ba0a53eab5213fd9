//! Loads compiled for computing.

use super::command::Command;
use super::space::Space;
use crate::lie::{Rotation, Wrench};
use crate::load::{Extent, Frame};

/// A load. Its wrench about the place where it acts, in the axes of the plan if it is dead, else in those of the
/// section, stands in the workspace: it may change with time.
#[derive(Clone, Debug)]
pub(crate) struct LoadPlan<G: Space> {
    pub(crate) link: usize,
    pub(crate) extent: Extent,
    pub(crate) frame: Frame,
    /// The wrench, as far as it is constant.
    pub(crate) wrench: Wrench<G, f64>,
    /// Force and moment, where the wrench varies: because one of them does, is set from outside, or the base moves and the
    /// load is dead.
    pub(crate) signals: Option<[Command<3>; 2]>,
    /// Whether that is because of time.
    pub(crate) varies_in_time: bool,
    /// Whether its force has a potential: a constant dead force. No moment has one.
    pub(crate) has_potential: bool,
    pub(crate) has_moment: bool,
}

impl<G: Space> LoadPlan<G> {
    /// The wrench before any time is set: NaN where it depends on it.
    pub(crate) fn at_first(&self) -> Wrench<G, f64> {
        if self.signals.is_some() { self.wrench * f64::NAN } else { self.wrench }
    }
}

/// The wrench of a force and a moment in the axes that a load keeps its direction in: those of the world are turned
/// into those of the plan.
pub(crate) fn wrench<G: Space>(
    [force, moment]: [[f64; 3]; 2],
    axes: Frame,
    frame: G::Frame,
    base_rotation: &Rotation<f64>,
) -> Wrench<G, f64> {
    let [force, moment] = [force, moment].map(|v| match axes {
        Frame::World => base_rotation.apply_transposed(v.into()),
        Frame::Body => v.into(),
    });
    Wrench { moment: G::axial_of(frame, moment), force: G::vector_of(frame, force) }
}

/// The part of a load on one piece.
#[derive(Clone, Debug)]
pub(crate) struct Spread<G: Space> {
    pub(crate) load: usize,
    /// How densely it acts at the nodes: for the integral over the part of the piece between two places,
    /// `sum_l (u_l(to) - u_l(from)) f_l`, the differences of the weights over the quadrature weights.
    pub(crate) density: Vec<G::Pack>,
    /// Between which fractions of the piece's length, where it ends abruptly inside; the nodes do not see where.
    pub(crate) part: Option<[f64; 2]>,
}
