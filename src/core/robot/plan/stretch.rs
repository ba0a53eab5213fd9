//! The stretch of a piece, which must remain positive.

use crate::description::rod::Gauss;
use crate::description::rod::piece::Piece;

/// Index of the stretch among the strains.
const STRETCH: usize = 3;

/// Data to check that the stretch of a segment is positive at its nodes and at both ends.
#[derive(Clone, Debug)]
pub(crate) struct Stretch {
    /// Index of its first coordinate.
    pub(crate) first: usize,
    /// Fractions of the segment's length, with the basis and the reference stretch there.
    pub(crate) places: Vec<(f64, Vec<f64>, f64)>,
    pub(crate) smallest_reference: f64,
}

impl Stretch {
    /// For a piece whose stretch begins at coordinate `first`.
    pub(crate) fn new(piece: &Piece, gauss: &Gauss, first: usize) -> Self {
        let at = |x: f64| {
            let mut basis = vec![0.0; piece.modes[STRETCH]];
            piece.basis.values(x, &mut basis);
            (x, basis, piece.reference(x)[STRETCH])
        };
        let places: Vec<_> = [0.0].iter().chain(&gauss.nodes).chain(&[1.0]).map(|&x| at(x)).collect();
        let smallest_reference = places.iter().fold(f64::INFINITY, |smallest, place| smallest.min(place.2));
        Self { first, places, smallest_reference }
    }

    /// The smallest stretch and its place, if it is not positive.
    pub(crate) fn inverted(&self, q: &[f64]) -> Option<(f64, f64)> {
        let q = &q[self.first..][..self.places[0].1.len()];
        // Basis functions never exceed one, so that usually the coordinates suffice as a bound.
        let bound: f64 = q.iter().map(|q| q.abs()).sum();
        if bound < self.smallest_reference {
            return None;
        }
        let stretches = self.places.iter().map(|(x, basis, reference)| {
            (*x, reference + basis.iter().zip(q).map(|(basis, q)| basis * q).sum::<f64>())
        });
        stretches.filter(|(_, stretch)| *stretch <= 0.0).min_by(|a, b| a.1.total_cmp(&b.1))
    }
}
