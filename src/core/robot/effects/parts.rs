//! Parts of effects in a compiled robot and in its memory: one line in each list.

use super::actuator::plan::Actuation;
use super::actuator::state::{ActuationState, ActuationTangent};
use super::contact::plan::Contacts;
use super::contact::state::{ContactState, ContactTangent};
use super::fluid::plan::{Hull, Immersion};
use super::load::plan::LoadPlan;
use super::loops::plan::Loops;
use super::loops::state::{LoopState, LoopTangent};
use super::magnet::plan::{MagnetTangent, Magnets};
use super::support::plan::Anchor;
use crate::numerics::lie::{Geometry, Wrench};
use crate::robot::plan::space::Space;

/// Effects of a compiled robot.
#[derive(Clone, Debug, Default)]
pub(crate) struct Plans<G: Space> {
    pub(crate) loads: Vec<LoadPlan<G>>,
    pub(crate) actuation: Actuation<G::Pack>,
    /// Springs to the world, in the frame of the base at rest.
    pub(crate) anchors: Vec<Anchor>,
    pub(crate) loops: Loops<G::Pack>,
    pub(crate) contacts: Contacts<G>,
    pub(crate) magnets: Magnets<G>,
    /// The fluid, if its forces depend on the motion.
    pub(crate) immersion: Option<Immersion>,
}

/// Effects at a point.
#[derive(Clone, Debug, Default)]
pub(crate) struct AtPoint<G: Geometry> {
    /// Hulls of the bodies, on which the fluid acts; the inertia of the bodies contains the added mass.
    pub(crate) hulls: Vec<Hull<G>>,
    /// Indices of the loads.
    pub(crate) loads: Vec<usize>,
    /// Indices of the anchors of supports.
    pub(crate) anchors: Vec<usize>,
    /// Ends of straight tendon parts: twice the index of the part, plus one for the second end.
    pub(crate) pulled: Vec<usize>,
    /// Ends of closed loops: twice the index of the tie, plus one for the second end.
    pub(crate) tied: Vec<usize>,
    /// Indices of the surfaces fixed here, among those on links.
    pub(crate) surfaces: Vec<usize>,
    /// Indices of the magnets.
    pub(crate) magnets: Vec<usize>,
}

/// Memory of effects for the motion.
#[derive(Clone, Debug)]
pub(crate) struct States<G: Geometry> {
    /// Wrenches of the loads, NaN for those that depend on time, until a time is set.
    pub(crate) acting: Vec<Wrench<G, f64>>,
    pub(crate) actuation: ActuationState<G::Pack>,
    /// Anchors of supports at the current time.
    pub(crate) anchors: Vec<Anchor>,
    pub(crate) loops: LoopState,
    pub(crate) contact: ContactState<G::Pack>,
}

impl<G: Space> States<G> {
    /// Memory for a robot with this number of coordinates and of packs of nodes.
    pub(crate) fn new(plans: &Plans<G>, n: usize, packs: usize) -> Self {
        Self {
            acting: plans.loads.iter().map(|load| load.at_first()).collect(),
            actuation: ActuationState::new(&plans.actuation, n),
            anchors: plans.anchors.clone(),
            loops: LoopState::new(&plans.loops),
            contact: ContactState::new(&plans.contacts, packs),
        }
    }
}

/// Memory of effects for the tangent.
#[derive(Clone, Debug)]
pub(crate) struct Tangents<G: Geometry> {
    pub(crate) actuation: ActuationTangent<G::Pack>,
    pub(crate) loops: LoopTangent,
    pub(crate) contact: ContactTangent<G>,
    pub(crate) magnets: MagnetTangent,
}

impl<G: Space> Tangents<G> {
    /// Memory for a robot with this number of coordinates, whose pieces have these numbers of packs of nodes times components.
    pub(crate) fn new(plans: &Plans<G>, n: usize, blocks: impl Iterator<Item = usize>) -> Self {
        Self {
            actuation: ActuationTangent::new(&plans.actuation, n),
            loops: LoopTangent::new(&plans.loops, n),
            contact: ContactTangent::new(&plans.contacts, n, blocks),
            magnets: MagnetTangent::new(&plans.magnets, n),
        }
    }
}
