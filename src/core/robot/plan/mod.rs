//! A compiled robot: everything that does not depend on the state, computed once.

pub(crate) mod command;
pub(crate) mod hinge;
pub(crate) mod joined;
pub(crate) mod link;
pub(crate) mod material;
pub(crate) mod piece;
pub(crate) mod point;
pub(crate) mod space;
pub(crate) mod stretch;
pub(crate) mod tree;
pub(crate) mod world;

use std::ops::Range;

use crate::description::rod::STRAINS;
use crate::numerics::lie::{Instructions, LANES, Lanes};
use crate::numerics::linalg::Matrix;
use crate::robot::description::Inputs;
use crate::robot::effects::parts::Plans;
use crate::robot::plan::link::LinkPlan;
use crate::robot::plan::material::Component;
use crate::robot::plan::piece::PiecePlan;
use crate::robot::plan::point::{Inside, Point};
use crate::robot::plan::space::Space;
use crate::robot::plan::tree::{Carrying, Families};
use crate::robot::plan::world::World;

/// A compiled robot, in the frame of its first link's joint: with the origin and the axes of that frame.
#[derive(Clone, Debug)]
pub(crate) struct Plan<G: Space> {
    pub(crate) n: usize,
    /// Instruction set of its sweeps.
    pub(crate) instructions: Instructions,
    pub(crate) pieces: Vec<PiecePlan<G>>,
    /// Positions of the robot's links among the pieces.
    pub(crate) links: Vec<LinkPlan>,
    /// Number of stations, at which pieces begin and end.
    pub(crate) stations: usize,
    /// Whether the robot is not a chain, in which every piece begins at the end of the previous one, or is
    /// welded there.
    pub(crate) has_branches: bool,
    /// Places that carry other pieces, in the order of their pieces.
    pub(crate) carrying: Vec<Carrying>,
    /// Coordinates of the hinges.
    pub(crate) hinges: Vec<usize>,
    /// Number of packs of nodes in all pieces.
    pub(crate) packs: usize,
    /// Position of the frame in the rod's space.
    pub(crate) frame: G::Frame,
    pub(crate) world: World,
    pub(crate) inputs: Inputs,
    pub(crate) effects: Plans<G>,
    /// Concentrated effects, ordered by place.
    pub(crate) points: Vec<Point<G>>,
    /// Whether there are dead loads, and whether the base, a load or an actuator depends on time explicitly.
    pub(crate) has_dead_loads: bool,
    pub(crate) varies_in_time: bool,
    /// Whether there are responses to motion other than inertia.
    pub(crate) has_responses: bool,
}

impl<G: Space> Plan<G> {
    /// A plan without pieces.
    pub(crate) fn empty(frame: G::Frame, world: World, inputs: Inputs, effects: Plans<G>) -> Self {
        Self {
            n: 0,
            instructions: Instructions::of_machine(),
            pieces: Vec::new(),
            links: Vec::new(),
            stations: 0,
            has_branches: false,
            carrying: Vec::new(),
            hinges: Vec::new(),
            packs: 0,
            frame,
            world,
            inputs,
            effects,
            points: Vec::new(),
            has_dead_loads: false,
            varies_in_time: false,
            has_responses: false,
        }
    }

    /// Determines which pieces carry which.
    pub(crate) fn find_families(&mut self) {
        let families = Families::of(&self.pieces, &self.points, self.stations);
        self.has_branches = !families.is_chain;
        self.carrying = families.assign_to(&mut self.pieces);
    }

    /// Places inside pieces at which others are attached.
    pub(crate) fn attachments(&self) -> impl Iterator<Item = &Point<G>> {
        self.points.iter().filter(|point| point.carries.is_some())
    }

    /// Integration weights of such a place.
    pub(crate) fn reach(&self, attached: usize) -> &Inside<G> {
        self.attachments().nth(attached).expect("attachments are counted").reach()
    }

    /// The same plan for a rod in space, without skipping anything, including absent strains and zero loads.
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

    /// Pieces of a link: of its joint and rod, or a rigid one. Empty for a link merged with its parent.
    pub(crate) fn pieces_of(&self, link: usize) -> Range<usize> {
        self.links[link].pieces.clone()
    }

    /// Number of quadrature nodes of each segment.
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

/// Packs the values of a function of the node, [`LANES`] per pack.
pub(crate) fn packed<P: Lanes>(nodes: usize, f: impl Fn(usize) -> f64) -> Vec<P> {
    (0..nodes / LANES).map(|pack| P::from_lanes(std::array::from_fn(|lane| f(pack * LANES + lane)))).collect()
}
