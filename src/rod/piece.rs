//! The unit of computation within a segment: all of it, or a piece of constant strain.

use super::basis::Basis;
use super::section::SectionProperties;
use super::segment::Segment;
use super::strain::STRAINS;

/// Tables of so many stations have quadrature begin anew at each. Of longer ones the kinks are small, and seen by one
/// rule.
const MAX_STATIONS: usize = 17;

/// Places that are nearer to each other than this part of a piece are one.
const SAME_PLACE: f64 = 1e-9;

/// A piece of a segment. Places in it are fractions of its own length.
#[derive(Clone, Debug)]
pub(crate) struct Piece {
    pub(crate) segment: Segment,
    /// Modes of each strain, and what they are.
    pub(crate) modes: [usize; STRAINS],
    pub(crate) basis: Basis,
    /// Where it begins and how long it is, as fractions of the segment's length.
    from: f64,
    part: f64,
}

/// How many pieces a segment has.
pub(crate) fn number(segment: &Segment) -> usize {
    segment.basis.pieces(segment.modes.iter().copied().max().unwrap_or(0))
}

/// The pieces of a segment, from base to tip.
pub(crate) fn of(segment: &Segment) -> impl Iterator<Item = Piece> + '_ {
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
    /// The whole of a segment.
    pub(crate) fn whole(segment: &Segment) -> Self {
        Self { segment: segment.clone(), modes: segment.modes, basis: segment.basis, from: 0.0, part: 1.0 }
    }

    /// Whether no other piece of its segment lies before it.
    pub(crate) fn begins_segment(&self) -> bool {
        self.from == 0.0
    }

    /// Length in metres.
    pub(crate) fn length(&self) -> f64 {
        self.segment.length * self.part
    }

    /// How far it reaches from the rod's axis along the y and the z axis of the section, at the fraction `x` of it: metres.
    pub(crate) fn half_extents(&self, x: f64) -> [f64; 2] {
        self.segment.section.half_extents(self.from + self.part * x)
    }

    /// The largest number of modes of a strain.
    pub(crate) fn degrees(&self) -> usize {
        self.modes.iter().copied().max().unwrap_or(0)
    }

    /// Degree of the polynomials, between any two breaks, that the modes and the reference strain are; where a table
    /// has too many stations for breaks, as many as it has.
    pub(crate) fn degree(&self) -> usize {
        let reference = &self.segment.reference_strain;
        let longest = self.tables().map(<[f64]>::len).filter(|&stations| stations > MAX_STATIONS).max();
        let of_reference = if reference.stations().len() > MAX_STATIONS { 0 } else { reference.degree() };
        self.basis.degree(self.degrees()).max(of_reference).max(longest.unwrap_or(0))
    }

    /// Stations of the reference strain and of what varies of the section.
    fn tables(&self) -> impl Iterator<Item = &[f64]> {
        let variations = self.segment.section.variations();
        let of_section = variations.into_iter().map(|variation| variation.stations);
        of_section.chain([self.segment.reference_strain.stations()])
    }

    /// Places inside (0, 1) where the basis, the reference strain or the section has a kink.
    pub(crate) fn breaks(&self) -> Vec<f64> {
        self.with_stations(
            self.basis.breaks(self.degrees()),
            self.tables().filter(|stations| stations.len() <= MAX_STATIONS),
        )
    }

    /// Places inside (0, 1) where so many modes or the section have a kink, however many those are: the stiffness is
    /// integrated once.
    pub(crate) fn breaks_of_stiffness(&self, modes: usize) -> Vec<f64> {
        let variations = self.segment.section.variations();
        let stations = variations.iter().map(|variation| variation.stations);
        self.with_stations(self.basis.breaks(modes), stations)
    }

    /// These places with the stations of tables, which are arc lengths of the segment.
    fn with_stations<'a>(&self, mut breaks: Vec<f64>, tables: impl Iterator<Item = &'a [f64]>) -> Vec<f64> {
        let number = breaks.len();
        for stations in tables.filter(|stations| stations.len() > 2) {
            let end = stations[stations.len() - 1];
            breaks.extend(stations.iter().map(|station| (station / end - self.from) / self.part));
        }
        if breaks.len() > number {
            breaks.retain(|&x| x > SAME_PLACE && x < 1.0 - SAME_PLACE);
            breaks.sort_by(f64::total_cmp);
            breaks.dedup_by(|a, b| *a - *b < SAME_PLACE);
        }
        breaks
    }

    /// Degree of the polynomials, between any two stations, that the section's numbers are.
    pub(crate) fn degree_of_section(&self) -> usize {
        self.segment.section.variations().iter().map(|variation| variation.degree).max().unwrap_or(0)
    }

    /// The fraction of the segment's length.
    pub(crate) fn place(&self, x: f64) -> f64 {
        self.from + self.part * x
    }

    pub(crate) fn section(&self, x: f64) -> SectionProperties {
        SectionProperties::at(&self.segment, self.place(x))
    }

    /// The reference strain.
    pub(crate) fn reference(&self, x: f64) -> [f64; STRAINS] {
        self.segment.reference_strain.at(self.place(x))
    }

    /// Its derivative along the rod, per metre.
    pub(crate) fn reference_slope(&self, x: f64) -> [f64; STRAINS] {
        self.segment.reference_strain.jet(self.place(x))[1].map(|slope| slope / self.segment.length)
    }

    /// Its integral from one fraction to another.
    pub(crate) fn reference_between(&self, from: f64, to: f64) -> [f64; STRAINS] {
        let profile = &self.segment.reference_strain;
        if let Some(strain) = profile.constant() {
            return strain.map(|strain| strain * (to - from));
        }
        let [start, end] = [from, to].map(|x| profile.integral(self.place(x)));
        std::array::from_fn(|i| (end[i] - start[i]) / self.part)
    }
}
