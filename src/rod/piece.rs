//! The part of a segment that is computed as one: the whole of it, or a piece of constant strain.

use super::basis::Basis;
use super::description::{STRAINS, Segment};
use super::section::SectionProperties;

/// Tables of so many stations have quadrature begin anew at each. Of longer ones the kinks are small, and seen by one rule.
const MAX_STATIONS: usize = 17;

/// Places that are nearer to each other than this part of a piece are one.
const SAME_PLACE: f64 = 1e-9;

/// A piece of a segment. Places in it are fractions of its own length.
#[derive(Clone, Debug)]
pub(super) struct Piece {
    pub(super) segment: Segment,
    /// Modes of each strain, and what they are.
    pub(super) modes: [usize; STRAINS],
    pub(super) basis: Basis,
    /// Where it begins and how long it is, as fractions of the segment's length.
    from: f64,
    part: f64,
}

/// How many pieces a segment has.
pub(super) fn number(segment: &Segment) -> usize {
    segment.basis.pieces(segment.modes.iter().copied().max().unwrap_or(0))
}

/// The pieces of a segment, from base to tip.
pub(super) fn of(segment: &Segment) -> impl Iterator<Item = Piece> + '_ {
    let number = number(segment);
    let modes = match segment.basis {
        Basis::PiecewiseConstant => segment.modes.map(|modes| modes.min(1)),
        _ => segment.modes,
    };
    (0..number).map(move |i| Piece {
        segment: segment.clone(),
        modes,
        basis: segment.basis,
        from: i as f64 / number as f64,
        part: 1.0 / number as f64,
    })
}

impl Piece {
    /// Length in metres.
    pub(super) fn length(&self) -> f64 {
        self.segment.length * self.part
    }

    /// The largest number of modes of a strain.
    pub(super) fn degrees(&self) -> usize {
        self.modes.iter().copied().max().unwrap_or(0)
    }

    /// Degree of the polynomials, between any two breaks, that the modes and the reference strain are.
    pub(super) fn degree(&self) -> usize {
        let reference = &self.segment.reference_strain;
        let of_reference = if reference.stations().len() > MAX_STATIONS {
            reference.stations().len()
        } else {
            reference.degree()
        };
        self.basis.degree(self.degrees()).max(of_reference)
    }

    /// Places inside (0, 1) where the basis or the reference strain has a kink.
    pub(super) fn breaks(&self) -> Vec<f64> {
        let mut breaks = self.basis.breaks(self.degrees());
        let stations = self.segment.reference_strain.stations();
        if let (Some(end), 3..=MAX_STATIONS) = (stations.last(), stations.len()) {
            breaks.extend(stations.iter().map(|station| (station / end - self.from) / self.part));
            breaks.retain(|&x| x > SAME_PLACE && x < 1.0 - SAME_PLACE);
            breaks.sort_by(f64::total_cmp);
            breaks.dedup_by(|a, b| *a - *b < SAME_PLACE);
        }
        breaks
    }

    /// The fraction of the segment's length.
    fn place(&self, x: f64) -> f64 {
        self.from + self.part * x
    }

    pub(super) fn section(&self, x: f64) -> SectionProperties {
        SectionProperties::at(&self.segment, self.place(x))
    }

    /// The reference strain.
    pub(super) fn reference(&self, x: f64) -> [f64; STRAINS] {
        self.segment.reference_strain.at(self.place(x))
    }

    /// Its integral from one fraction to another.
    pub(super) fn reference_between(&self, from: f64, to: f64) -> [f64; STRAINS] {
        let profile = &self.segment.reference_strain;
        if let Some(strain) = profile.constant() {
            return strain.map(|strain| strain * (to - from));
        }
        let [start, end] = [from, to].map(|x| profile.integral(self.place(x)));
        std::array::from_fn(|i| (end[i] - start[i]) / self.part)
    }
}
