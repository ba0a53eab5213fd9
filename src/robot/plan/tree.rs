//! The topology of a plan: each piece starts at or within another one, or at the frame.

use std::ops::Range;

use super::piece::PiecePlan;
use super::point::Point;
use super::space::Space;

/// Where a piece begins and ends. Stations are counted from the frame, which is the first one.
#[derive(Clone, Debug)]
pub(crate) struct Joined<G: Space> {
    /// The station where it begins.
    pub(crate) begin: usize,
    /// The station where it ends.
    pub(crate) end: usize,
    /// What fixes the first station to another one, where it is not that one itself.
    pub(crate) weld: Option<Weld<G>>,
    /// The place that carries it, among [`Plan::carrying`](super::Plan::carrying); none is the frame.
    pub(crate) hangs_at: Option<usize>,
    /// Whether a joint or a weld begins at its end.
    pub(crate) ends_at_joint: bool,
    /// Whether nodes lie behind its end: they follow from the orientation there.
    pub(crate) is_followed_by_nodes: bool,
    /// The coordinates of the pieces that carry it, and of those that it carries; neighbours together.
    pub(crate) ancestors: Vec<Relatives>,
    pub(crate) descendants: Vec<Relatives>,
}

/// Coordinates of pieces that carry a piece, or of pieces that it carries.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Relatives {
    pub(crate) coordinates: Range<usize>,
    /// Where inside a piece what is carried is attached; at its end, if nowhere. Counted among such places.
    pub(crate) attached: Option<usize>,
}

/// A place of a piece that carries others.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Carrying {
    pub(crate) piece: usize,
    /// Where inside it, counted among all such places; at its end, if nowhere.
    pub(crate) attached: Option<usize>,
}

/// A station fixed to another one.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Weld<G: Space> {
    /// The other one.
    pub(crate) to: usize,
    /// How it is turned and where it lies, in the axes of the other one.
    pub(crate) orientation: G::Orientation,
    pub(crate) rotation: G::Rotation<f64>,
    pub(crate) position: G::Vector<f64>,
    /// Whether it is turned at all.
    pub(crate) turns: bool,
}

impl<G: Space> Joined<G> {
    /// Between two stations.
    pub(crate) fn between(begin: usize, end: usize) -> Self {
        Self {
            begin,
            end,
            weld: None,
            hangs_at: None,
            ends_at_joint: false,
            is_followed_by_nodes: false,
            ancestors: Vec::new(),
            descendants: Vec::new(),
        }
    }

    /// The station that carries it.
    #[inline(always)]
    pub(crate) fn carrier(&self) -> usize {
        self.weld.as_ref().map_or(self.begin, |weld| weld.to)
    }
}

/// The tree of pieces.
pub(crate) struct Families {
    /// By piece.
    ancestors: Vec<Vec<Relatives>>,
    descendants: Vec<Vec<Relatives>>,
    /// By station.
    carried_by: Vec<Option<Carrying>>,
    /// Those that carry something.
    pub(crate) carrying: Vec<Carrying>,
    /// Whether every piece begins where the one before ends, or is fixed to that place.
    pub(crate) is_chain: bool,
}

impl Families {
    /// Of pieces of which each one stands behind its carrier.
    pub(crate) fn of<G: Space>(pieces: &[PiecePlan<G>], points: &[Point<G>], stations: usize) -> Self {
        let mut families = Self {
            ancestors: vec![Vec::new(); pieces.len()],
            descendants: vec![Vec::new(); pieces.len()],
            carried_by: vec![None; stations],
            carrying: Vec::new(),
            is_chain: true,
        };
        let mut attachments = 0;
        let mut last = 0;
        for (p, piece) in pieces.iter().enumerate() {
            let carrier = piece.joined.carrier();
            families.is_chain &= carrier == last;
            last = piece.joined.end;
            families.carried_by[piece.joined.end] = Some(Carrying { piece: p, attached: None });
            for point in &points[piece.points.inside.clone()] {
                if let Some(station) = point.carries {
                    families.carried_by[station] = Some(Carrying { piece: p, attached: Some(attachments) });
                    attachments += 1;
                }
            }
            let mut place = families.carried_by[carrier];
            families.carrying.extend(place);
            while let Some(Carrying { piece: parent, attached }) = place {
                let coordinates = pieces[parent].coordinates();
                families.ancestors[p].push(Relatives { coordinates, attached });
                if piece.n > 0 {
                    let own = Relatives { coordinates: piece.coordinates(), attached };
                    extend(&mut families.descendants[parent], own);
                }
                place = families.carried_by[pieces[parent].joined.carrier()];
            }
            // Found from the piece to the root.
            families.ancestors[p].reverse();
            let found = std::mem::take(&mut families.ancestors[p]);
            for relatives in found.into_iter().filter(|relatives| !relatives.coordinates.is_empty()) {
                extend(&mut families.ancestors[p], relatives);
            }
        }
        families.carrying.sort();
        families.carrying.dedup();
        families
    }

    /// Tells the pieces; returns the places that carry others.
    pub(crate) fn tell<G: Space>(self, pieces: &mut [PiecePlan<G>]) -> Vec<Carrying> {
        let begin_of_joint = |piece: &PiecePlan<G>| {
            let is_joint = piece.packs == 0 || piece.joined.weld.is_some();
            is_joint.then(|| piece.joined.carrier())
        };
        let with_joints: Vec<usize> = pieces.iter().filter_map(begin_of_joint).collect();
        for piece in pieces.iter_mut() {
            piece.joined.ends_at_joint = with_joints.contains(&piece.joined.end);
        }
        let mut are_before_nodes = vec![false; self.carried_by.len()];
        for piece in pieces.iter_mut().rev() {
            let place = self.carried_by[piece.joined.carrier()];
            piece.joined.hangs_at = place.and_then(|place| self.carrying.binary_search(&place).ok());
            piece.joined.is_followed_by_nodes = are_before_nodes[piece.joined.end];
            are_before_nodes[piece.joined.carrier()] |= piece.packs > 0 || piece.joined.is_followed_by_nodes;
        }
        for ((piece, ancestors), descendants) in pieces.iter_mut().zip(self.ancestors).zip(self.descendants) {
            piece.joined.ancestors = ancestors;
            piece.joined.descendants = descendants;
        }
        self.carrying
    }
}

/// Adds relatives behind others, to the last ones where they go on.
fn extend(all: &mut Vec<Relatives>, more: Relatives) {
    match all.last_mut() {
        Some(last) if last.coordinates.end == more.coordinates.start && last.attached == more.attached => {
            last.coordinates.end = more.coordinates.end;
        }
        _ => all.push(more),
    }
}
