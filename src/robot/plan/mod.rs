//! A robot compiled for computing: everything that does not change with the state, computed once.

pub(crate) mod actuation;
pub(crate) mod anchor;
pub(crate) mod command;
pub(crate) mod contact;
pub(crate) mod hinge;
pub(crate) mod immersion;
pub(crate) mod link;
pub(crate) mod load;
pub(crate) mod loops;
pub(crate) mod material;
pub(crate) mod piece;
pub(crate) mod point;
pub(crate) mod space;
pub(crate) mod stretch;
pub(crate) mod tree;
pub(crate) mod world;

use std::ops::Range;

use crate::lie::{Instructions, LANES, Lanes};
use crate::linalg::Matrix;
use crate::robot::description::Inputs;
use crate::robot::plan::actuation::Actuation;
use crate::robot::plan::anchor::Anchor;
use crate::robot::plan::contact::Contacts;
use crate::robot::plan::immersion::Immersion;
use crate::robot::plan::link::LinkPlan;
use crate::robot::plan::load::LoadPlan;
use crate::robot::plan::loops::Loops;
use crate::robot::plan::material::Component;
use crate::robot::plan::piece::PiecePlan;
use crate::robot::plan::point::{Inside, Point};
use crate::robot::plan::space::Space;
use crate::robot::plan::tree::{Carrying, Families};
use crate::robot::plan::world::World;
use crate::rod::STRAINS;

/// A robot compiled for computing, in the frame of its first link's joint: the origin there, and axes along those of
/// that frame.
#[derive(Clone, Debug)]
pub(crate) struct Plan<G: Space> {
    pub(crate) n: usize,
    /// What its sweeps run with.
    pub(crate) instructions: Instructions,
    pub(crate) pieces: Vec<PiecePlan<G>>,
    /// Where the links of the robot are among them.
    pub(crate) links: Vec<LinkPlan>,
    /// Places where pieces begin and end.
    pub(crate) stations: usize,
    /// Whether it is more than a chain, every piece of which begins where the one before ends, or is fixed there.
    pub(crate) has_branches: bool,
    /// The places that carry others, in the order of their pieces.
    pub(crate) carrying: Vec<Carrying>,
    /// The coordinates of the hinges.
    pub(crate) hinges: Vec<usize>,
    /// Packs of nodes of all pieces together.
    pub(crate) packs: usize,
    /// Where the frame lies in the rod's space.
    pub(crate) frame: G::Frame,
    pub(crate) world: World,
    pub(crate) loads: Vec<LoadPlan<G>>,
    /// The inputs and the actuators.
    pub(crate) inputs: Inputs,
    pub(crate) actuation: Actuation<G::Pack>,
    /// Concentrated effects, ordered by place.
    pub(crate) points: Vec<Point<G>>,
    /// The springs to the world, in the frame of the base at rest.
    pub(crate) anchors: Vec<Anchor>,
    /// Joints that close loops of links.
    pub(crate) loops: Loops<G::Pack>,
    /// Pairs of surfaces that can touch.
    pub(crate) contacts: Contacts<G>,
    /// The fluid around it, where that answers to motion.
    pub(crate) immersion: Option<Immersion>,
    /// Whether a dead load acts anywhere, and whether the base, a load or an actuator depends on time by itself.
    pub(crate) has_dead_loads: bool,
    pub(crate) varies_in_time: bool,
    /// Whether anything responds to the motion of its place other than by its inertia.
    pub(crate) has_responses: bool,
}

impl<G: Space> Plan<G> {
    /// Takes down which pieces carry which ones.
    pub(crate) fn find_families(&mut self) {
        let families = Families::of(&self.pieces, &self.points, self.stations);
        self.has_branches = !families.is_chain;
        self.carrying = families.tell(&mut self.pieces);
    }

    /// The places inside pieces where others are attached.
    pub(crate) fn attachments(&self) -> impl Iterator<Item = &Point<G>> {
        self.points.iter().filter(|point| point.carries.is_some())
    }

    /// How one of them is reached.
    pub(crate) fn reach(&self, attached: usize) -> &Inside<G> {
        self.attachments().nth(attached).expect("attachments are counted").reach()
    }

    /// The same plan, of a rod in space, with everything computed that could be skipped: absent strains and loads of zero
    /// included.
    pub(crate) fn with_nothing_skipped(mut self) -> Self {
        self.has_dead_loads = true;
        self.has_responses = true;
        for point in &mut self.points {
            point.is_oriented = true;
        }
        for piece in self.pieces.iter_mut().filter(|piece| !piece.is_joint) {
            piece.is_extensible = true;
            for component in &mut piece.components {
                component.is_orthogonal = false;
            }
            piece.moments = piece.general_moments(self.frame);
            piece.couple_all();
            for index in 0..STRAINS {
                if piece.components.iter().all(|component| component.index != index) {
                    piece.components.push(Component {
                        index,
                        modes: 0,
                        first: piece.first,
                        stiffness: Matrix::zeros(0, 0),
                        is_orthogonal: false,
                    });
                }
            }
        }
        self
    }

    /// The pieces of a link: of its joint, of its rod, or a rigid one. A link that is where another one ends has none.
    pub(crate) fn pieces_of(&self, link: usize) -> Range<usize> {
        self.links[link].pieces.clone()
    }

    /// Quadrature nodes of each segment of the rods.
    pub(crate) fn nodes(&self) -> Vec<usize> {
        let mut nodes: Vec<usize> = Vec::new();
        for piece in self.links.iter().flat_map(|link| &self.pieces[link.rod.clone()]) {
            match nodes.last_mut() {
                Some(last) if !piece.part().begins_segment() => *last += piece.gauss.nodes.len(),
                _ => nodes.push(piece.gauss.nodes.len()),
            }
        }
        nodes
    }
}

/// The values of a function of the node, [`LANES`] to a pack.
pub(crate) fn packed<P: Lanes>(nodes: usize, f: impl Fn(usize) -> f64) -> Vec<P> {
    (0..nodes / LANES).map(|pack| P::from_lanes(std::array::from_fn(|lane| f(pack * LANES + lane)))).collect()
}
