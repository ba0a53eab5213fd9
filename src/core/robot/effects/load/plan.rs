//! Compiled loads.

use crate::numerics::lie::{Rotation, Wrench};
use crate::robot::effects::load::{Extent, Frame};
use crate::robot::plan::command::Command;
use crate::robot::plan::space::Space;

/// A load. Its wrench about the place where it acts is stored in the workspace, because it may vary in time:
/// in the axes of the plan for a dead load, otherwise in those of the section.
#[derive(Clone, Debug)]
pub(crate) struct LoadPlan<G: Space> {
    pub(crate) link: usize,
    pub(crate) extent: Extent,
    pub(crate) frame: Frame,
    /// The constant part of the wrench.
    pub(crate) wrench: Wrench<G, f64>,
    /// Force and moment, if the wrench varies: because one of them is a function of time or an input, or
    /// because the base moves and the load is dead.
    pub(crate) signals: Option<[Command<3>; 2]>,
    /// Whether the wrench varies in time.
    pub(crate) varies_in_time: bool,
    /// Whether the force has a potential: a constant dead force. Moments have none.
    pub(crate) has_potential: bool,
    pub(crate) has_moment: bool,
}

impl<G: Space> LoadPlan<G> {
    /// The wrench before a time is set: NaN if it depends on time.
    pub(crate) fn at_first(&self) -> Wrench<G, f64> {
        if self.signals.is_some() { self.wrench * f64::NAN } else { self.wrench }
    }
}

/// Wrench of a force and a moment in the load's axes; world axes are rotated to those of the plan.
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

/// Part of a distributed load on one piece.
#[derive(Clone, Debug)]
pub(crate) struct Spread<G: Space> {
    pub(crate) load: usize,
    /// Density at the nodes for the integral over the part of the piece between two places, `sum_l (u_l(to) -
    /// u_l(from)) f_l`: differences of the integration weights over the quadrature weights.
    pub(crate) density: Vec<G::Pack>,
    /// Start and end as fractions of the piece's length, if they lie inside; the nodes do not resolve them.
    pub(crate) part: Option<[f64; 2]>,
}
