//! Compiles the links of a robot to connected pieces of a plan.

use super::{joint, piece};
use crate::description::rod::piece as part;
use crate::numerics::lie::{Quaternion, Vector};
use crate::robot::description::{Link, Robot};
use crate::robot::plan::joined::{Joined, Weld};
use crate::robot::plan::link::LinkPlan;
use crate::robot::plan::piece::PiecePlan;
use crate::robot::plan::point::{Offset, Place};
use crate::robot::turning::Turning;
use crate::robot::turning::place;

/// Pieces and their connections.
pub(crate) struct Tree<G: Turning> {
    frame: G::Frame,
    pub(crate) pieces: Vec<PiecePlan<G>>,
    pub(crate) links: Vec<LinkPlan>,
    /// The pieces that end at each station; `None` for the first one and for stations inside pieces.
    ending: Vec<Option<usize>>,
    /// Places inside pieces at which others are attached, with their stations.
    pub(crate) attachments: Vec<(Place, usize)>,
    pub(crate) n: usize,
    pub(crate) packs: usize,
    pub(crate) hinges: Vec<usize>,
}

/// Start of the next piece: a station, and the offset from it.
struct Start {
    station: usize,
    weld: Option<Offset>,
}

impl<G: Turning> Tree<G> {
    /// Tree of a valid robot, in the frame of its first link's joint. With `makes_one`, rigid links that are
    /// welded and unloaded are merged with their parents.
    pub(crate) fn of(robot: &Robot, frame: G::Frame, makes_one: bool) -> Self {
        let mut tree = Self {
            frame,
            pieces: Vec::new(),
            links: Vec::with_capacity(robot.links.len()),
            ending: vec![None],
            attachments: Vec::new(),
            n: 0,
            packs: 0,
            hinges: Vec::new(),
        };
        let mut is_acted_on = vec![false; robot.links.len()];
        let of_loads = robot.loads.iter().map(|load| load.link);
        for link in of_loads.chain(robot.supports.iter().map(|support| support.link)) {
            is_acted_on[link] = true;
        }
        for (link, is_acted_on) in robot.links.iter().zip(is_acted_on) {
            let start = tree.start(link, &robot.links[0]);
            tree.add(link, start, makes_one && !is_acted_on);
        }
        tree
    }

    pub(crate) fn stations(&self) -> usize {
        self.ending.len()
    }

    /// Start of a link.
    fn start(&mut self, link: &Link, root: &Link) -> Start {
        let mut offset = Offset {
            orientation: Quaternion::from_array(link.orientation),
            position: Vector::from(link.position),
        };
        let station = match link.parent {
            Some(parent) => {
                if let Some(beside) = self.links[parent].beside {
                    offset = beside.times(offset);
                }
                self.station_on(parent, link.at)
            }
            None => {
                let of_root = Quaternion::from_array(root.orientation);
                let back = Quaternion { v: -of_root.v, ..of_root };
                let position = offset.position - Vector::from(root.position);
                offset.position = of_root.rotation().apply_transposed(position);
                offset.orientation = back.times(offset.orientation);
                0
            }
        };
        let is_first = self.links.is_empty();
        let is_moved = offset.position != Vector::zero() || offset.orientation.v != Vector::zero();
        Start { station, weld: (is_moved && !is_first).then_some(offset) }
    }

    /// Station of a place on a link.
    fn station_on(&mut self, link: usize, at: Option<f64>) -> usize {
        let LinkPlan { rod, base, .. } = &self.links[link];
        let (Some(x), false) = (at, rod.is_empty()) else {
            let last = if rod.is_empty() { *base } else { rod.end - 1 };
            return self.pieces[last].joined.end;
        };
        let place = place::at_arc_length(&self.pieces, rod.clone(), x);
        if place.x >= 1.0 {
            return self.pieces[place.piece].joined.end;
        }
        let is_there = |(other, _): &&(Place, usize)| (other.piece, other.x) == (place.piece, place.x);
        if let Some((_, station)) = self.attachments.iter().find(is_there) {
            return *station;
        }
        self.ending.push(None);
        let station = self.ending.len() - 1;
        self.attachments.push((place, station));
        station
    }

    fn add(&mut self, link: &Link, mut start: Start, can_be_one: bool) {
        let before = self.pieces.len();
        for motion in link.joint.motions() {
            let joined = self.join(&mut start);
            let counts = [self.n, self.packs, self.hinges.len()];
            self.push(joint::moving(motion, self.frame, link.joint.forces(), joined, counts));
        }
        let begin = self.pieces.len();
        for part in link.rod.iter().flat_map(part::of) {
            let joined = self.join(&mut start);
            self.push(piece::plan(part, self.frame, joined, self.n, self.packs));
        }
        let rod = begin..self.pieces.len();
        let ends_there = self.ending[start.station];
        let mut beside = None;
        if rod.is_empty() {
            // A link moved by its own joint ends at its own piece.
            let is_one = ends_there.is_some() && (can_be_one || begin > before);
            if is_one {
                beside = start.weld.take();
            } else {
                let joined = self.join(&mut start);
                self.push(joint::rigid(joined, self.n, self.packs));
            }
        }
        let base = self.ending[start.station].unwrap_or(0);
        self.links.push(LinkPlan { pieces: before..self.pieces.len(), rod, base, beside });
    }

    /// Stations of the next piece; the following piece starts at its end.
    fn join(&mut self, start: &mut Start) -> Joined<G> {
        let mut begin = start.station;
        let mut weld = None;
        if let Some(Offset { orientation, position }) = start.weld.take() {
            let turns = orientation.v != Vector::zero();
            let orientation = G::orientation_of(self.frame, orientation);
            let position = G::vector_of(self.frame, position);
            let rotation = G::matrix(orientation);
            weld = Some(Weld { to: begin, orientation, rotation, position, turns });
            self.ending.push(None);
            begin = self.ending.len() - 1;
        }
        self.ending.push(Some(self.pieces.len()));
        start.station = self.ending.len() - 1;
        Joined { weld, ..Joined::between(begin, start.station) }
    }

    fn push(&mut self, piece: PiecePlan<G>) {
        self.hinges.extend(piece.hinge.is_some().then_some(self.n));
        self.n += piece.n;
        self.packs += piece.packs;
        self.pieces.push(piece);
    }
}
