//! Topology of a plan: each piece starts at or within another one, or at the frame.

use super::joined::Relatives;
use super::piece::PiecePlan;
use super::point::Point;
use super::space::Space;

/// A place of a piece that carries others.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Carrying {
    pub(crate) piece: usize,
    /// Index of the place inside the piece; `None` is its end.
    pub(crate) attached: Option<usize>,
}

/// Relations between the pieces of a tree.
pub(crate) struct Families {
    /// By piece.
    ancestors: Vec<Vec<Relatives>>,
    descendants: Vec<Vec<Relatives>>,
    /// By station.
    carried_by: Vec<Option<Carrying>>,
    /// Places that carry pieces.
    pub(crate) carrying: Vec<Carrying>,
    /// Whether every piece begins at the end of the previous one, or is welded to that place.
    pub(crate) is_chain: bool,
}

impl Families {
    /// Relations of pieces in which each one follows its carrier.
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
            // They were found from the piece to the root.
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

    /// Writes the relations to the pieces; returns the places that carry others.
    pub(crate) fn assign_to<G: Space>(self, pieces: &mut [PiecePlan<G>]) -> Vec<Carrying> {
        let begin_of_joint = |piece: &PiecePlan<G>| {
            let is_joint = piece.packs == 0 || piece.joined.weld.is_some();
            is_joint.then(|| piece.joined.carrier())
        };
        let mut have_joints = vec![false; self.carried_by.len()];
        pieces.iter().filter_map(begin_of_joint).for_each(|station| have_joints[station] = true);
        for piece in pieces.iter_mut() {
            piece.joined.ends_at_joint = have_joints[piece.joined.end];
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

/// Appends relatives, merging them with the last range if they are contiguous.
fn extend(all: &mut Vec<Relatives>, more: Relatives) {
    match all.last_mut() {
        Some(last) if last.coordinates.end == more.coordinates.start && last.attached == more.attached => {
            last.coordinates.end = more.coordinates.end;
        }
        _ => all.push(more),
    }
}
