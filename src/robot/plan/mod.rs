//! A rod compiled for computing: everything that does not change with the state, computed once.

pub(crate) mod anchor;
pub(crate) mod immersion;
pub(crate) mod load;
pub(crate) mod material;
pub(crate) mod piece;
pub(crate) mod point;
pub(crate) mod space;
pub(crate) mod stretch;
pub(crate) mod tree;
pub(crate) mod world;

use crate::lie::{Instructions, LANES, Lanes};
use crate::linalg::Matrix;
use crate::robot::plan::anchor::Anchor;
use crate::robot::plan::immersion::Immersion;
use crate::robot::plan::load::LoadPlan;
use crate::robot::plan::material::Component;
use crate::robot::plan::piece::PiecePlan;
use crate::robot::plan::point::Point;
use crate::robot::plan::space::Space;
use crate::robot::plan::tree::Joined;
use crate::robot::plan::world::World;
use crate::rod::STRAINS;

/// A rod compiled for computing, in the frame of its base: the origin there, and axes along the body axes there.
#[derive(Clone, Debug)]
pub(crate) struct Plan<G: Space> {
    pub(crate) n: usize,
    /// What its sweeps run with.
    pub(crate) instructions: Instructions,
    pub(crate) pieces: Vec<PiecePlan<G>>,
    /// Places where pieces begin and end.
    pub(crate) stations: usize,
    /// Whether it is more than a chain, every piece of which begins where the one before ends.
    pub(crate) has_branches: bool,
    /// Packs of nodes of all pieces together.
    pub(crate) packs: usize,
    /// Where the frame lies in the rod's space.
    pub(crate) frame: G::Frame,
    pub(crate) world: World,
    pub(crate) loads: Vec<LoadPlan<G>>,
    /// What is concentrated at places, in their order.
    pub(crate) points: Vec<Point<G>>,
    /// The springs to the world, in the frame of the base at rest.
    pub(crate) anchors: Vec<Anchor>,
    /// The fluid around it, where that answers to motion.
    pub(crate) immersion: Option<Immersion>,
    /// Whether a dead load acts anywhere, and whether the base or a load depends on time by itself.
    pub(crate) has_dead_loads: bool,
    pub(crate) varies_in_time: bool,
    /// Whether anything responds to the motion of its place other than by its inertia.
    pub(crate) has_responses: bool,
}

impl<G: Space> Plan<G> {
    /// Takes down which pieces carry which ones.
    pub(crate) fn find_families(&mut self) {
        let mut carried_by = vec![None; self.stations];
        let mut is_chain = true;
        for p in 0..self.pieces.len() {
            let Joined { begin, end, .. } = self.pieces[p].joined;
            let carrier = carried_by[self.pieces[p].joined.carrier()];
            is_chain &= begin == p && end == p + 1;
            carried_by[end] = Some(p);
            let mut ancestors = Vec::new();
            if let Some(parent) = carrier {
                let parent: &PiecePlan<G> = &self.pieces[parent];
                ancestors.clone_from(&parent.joined.ancestors);
                tree::extend(&mut ancestors, parent.coordinates());
            }
            self.pieces[p].joined.ancestors = ancestors;
        }
        self.has_branches = !is_chain;
        for p in 0..self.pieces.len() {
            let own = self.pieces[p].coordinates();
            let mut descendants = Vec::new();
            if is_chain {
                tree::extend(&mut descendants, own.end..self.n);
                self.pieces[p].joined.descendants = descendants;
                continue;
            }
            for other in &self.pieces[p + 1..] {
                let carries =
                    |range: &std::ops::Range<usize>| range.start <= own.start && own.end <= range.end;
                if !own.is_empty() && other.joined.ancestors.iter().any(carries) {
                    tree::extend(&mut descendants, other.coordinates());
                }
            }
            self.pieces[p].joined.descendants = descendants;
        }
    }

    /// The same plan, of a rod in space, with everything computed that could be skipped: absent strains and loads of zero
    /// included.
    pub(crate) fn with_nothing_skipped(mut self) -> Self {
        self.has_dead_loads = true;
        self.has_responses = true;
        for point in &mut self.points {
            point.is_oriented = true;
        }
        for piece in &mut self.pieces {
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

    /// Quadrature nodes of each piece.
    pub(crate) fn nodes(&self) -> Vec<usize> {
        self.pieces.iter().map(|piece| piece.gauss.nodes.len()).collect()
    }
}

/// The values of a function of the node, [`LANES`] to a pack.
pub(crate) fn packed<P: Lanes>(nodes: usize, f: impl Fn(usize) -> f64) -> Vec<P> {
    (0..nodes / LANES).map(|pack| P::from_lanes(std::array::from_fn(|lane| f(pack * LANES + lane)))).collect()
}
