//! How the pieces of a plan hang together: each begins where another one ends or passes, or at the frame.

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
    /// Whether a joint or a weld begins at its end.
    pub(crate) ends_at_joint: bool,
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

/// A station fixed to another one.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Weld<G: Space> {
    /// The other one.
    pub(crate) to: usize,
    /// How it is turned and where it lies, in the axes of the other one.
    pub(crate) orientation: G::Orientation,
    pub(crate) position: G::Vector<f64>,
    /// Whether it is turned at all.
    pub(crate) turns: bool,
}

impl<G: Space> Joined<G> {
    /// Between two stations.
    pub(crate) fn between(begin: usize, end: usize) -> Self {
        Self { begin, end, weld: None, ends_at_joint: false, ancestors: Vec::new(), descendants: Vec::new() }
    }

    /// The station that carries it.
    #[inline(always)]
    pub(crate) fn carrier(&self) -> usize {
        self.weld.as_ref().map_or(self.begin, |weld| weld.to)
    }
}

/// Who carries whom.
pub(crate) struct Families {
    /// By piece.
    ancestors: Vec<Vec<Relatives>>,
    descendants: Vec<Vec<Relatives>>,
    /// Whether every piece begins where the one before ends, or is fixed to that place.
    pub(crate) is_chain: bool,
}

impl Families {
    /// Of pieces of which each one stands behind its carrier.
    pub(crate) fn of<G: Space>(pieces: &[PiecePlan<G>], points: &[Point<G>], stations: usize) -> Self {
        let mut carried_by: Vec<Option<(usize, Option<usize>)>> = vec![None; stations];
        let mut families = Self {
            ancestors: vec![Vec::new(); pieces.len()],
            descendants: vec![Vec::new(); pieces.len()],
            is_chain: true,
        };
        let mut attachments = 0;
        let mut last = 0;
        for (p, piece) in pieces.iter().enumerate() {
            let carrier = piece.joined.carrier();
            families.is_chain &= carrier == last;
            last = piece.joined.end;
            carried_by[piece.joined.end] = Some((p, None));
            for point in &points[piece.points.inside.clone()] {
                if let Some(station) = point.carries {
                    carried_by[station] = Some((p, Some(attachments)));
                    attachments += 1;
                }
            }
            let mut place = carried_by[carrier];
            while let Some((parent, attached)) = place {
                let coordinates = pieces[parent].coordinates();
                families.ancestors[p].push(Relatives { coordinates, attached });
                if piece.n > 0 {
                    let own = Relatives { coordinates: piece.coordinates(), attached };
                    extend(&mut families.descendants[parent], own);
                }
                place = carried_by[pieces[parent].joined.carrier()];
            }
            // Found from the piece to the root.
            families.ancestors[p].reverse();
            let found = std::mem::take(&mut families.ancestors[p]);
            for relatives in found.into_iter().filter(|relatives| !relatives.coordinates.is_empty()) {
                extend(&mut families.ancestors[p], relatives);
            }
        }
        families
    }

    /// Tells the pieces.
    pub(crate) fn tell<G: Space>(self, pieces: &mut [PiecePlan<G>]) {
        let begin_of_joint = |piece: &PiecePlan<G>| {
            let is_joint = piece.packs == 0 || piece.joined.weld.is_some();
            is_joint.then(|| piece.joined.carrier())
        };
        let with_joints: Vec<usize> = pieces.iter().filter_map(begin_of_joint).collect();
        for piece in pieces.iter_mut() {
            piece.joined.ends_at_joint = with_joints.contains(&piece.joined.end);
        }
        for ((piece, ancestors), descendants) in pieces.iter_mut().zip(self.ancestors).zip(self.descendants) {
            piece.joined.ancestors = ancestors;
            piece.joined.descendants = descendants;
        }
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
