//! The unit of computation within a segment: the whole segment, or a piece of constant strain.

use super::basis::Basis;
use super::section::SectionProperties;
use super::segment::Segment;
use super::strain::STRAINS;

/// Tables with up to this number of stations get a quadrature rule between any two of them. In longer tables
/// the kinks are small, and one rule covers all.
const MAX_STATIONS: usize = 17;

/// Points closer than this fraction of a piece count as one.
const SAME_PLACE: f64 = 1e-9;

/// A piece of a segment. Positions in it are fractions of its own length.
#[derive(Clone, Debug)]
pub struct Piece {
    pub(crate) segment: Segment,
    /// Number of modes of each strain, and their basis.
    pub modes: [usize; STRAINS],
    pub(crate) basis: Basis,
    /// Start and length, as fractions of the segment's length.
    from: f64,
    part: f64,
}

/// Number of pieces of a segment.
pub(crate) fn number(segment: &Segment) -> usize {
    segment.basis.pieces(segment.modes.iter().copied().max().unwrap_or(0))
}

/// The pieces of a segment, from base to tip.
pub fn of(segment: &Segment) -> impl Iterator<Item = Piece> + '_ {
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
    /// A segment as a single piece.
    pub(crate) fn whole(segment: &Segment) -> Self {
        Self { segment: segment.clone(), modes: segment.modes, basis: segment.basis, from: 0.0, part: 1.0 }
    }

    /// Whether this is the first piece of its segment.
    pub(crate) fn begins_segment(&self) -> bool {
        self.from == 0.0
    }

    /// Length in metres.
    pub(crate) fn length(&self) -> f64 {
        self.segment.length * self.part
    }

    /// Half extents along the y and z axes of the section at the fraction `x`, in metres.
    pub(crate) fn half_extents(&self, x: f64) -> [f64; 2] {
        self.segment.section.half_extents(self.from + self.part * x)
    }

    /// Largest number of modes of a strain.
    pub(crate) fn degrees(&self) -> usize {
        self.modes.iter().copied().max().unwrap_or(0)
    }

    /// Polynomial degree of modes and reference strain between breaks. For tables with too many stations for
    /// breaks, the number of stations.
    pub(crate) fn degree(&self) -> usize {
        let reference = &self.segment.reference_strain;
        let longest = self.tables().map(<[f64]>::len).filter(|&stations| stations > MAX_STATIONS).max();
        let of_reference = if reference.stations().len() > MAX_STATIONS { 0 } else { reference.degree() };
        self.basis.degree(self.degrees()).max(of_reference).max(longest.unwrap_or(0))
    }

    /// Stations of the reference strain and of the varying properties of the section.
    fn tables(&self) -> impl Iterator<Item = &[f64]> {
        let variations = self.segment.section.variations();
        let of_section = variations.into_iter().map(|variation| variation.stations);
        let of_effects = self.segment.of_effects().into_iter().map(|(_, along)| along.stations());
        of_section.chain([self.segment.reference_strain.stations()]).chain(of_effects)
    }

    /// Points inside (0, 1) where the basis, the reference strain or the section has a kink.
    pub(crate) fn breaks(&self) -> Vec<f64> {
        self.with_stations(
            self.basis.breaks(self.degrees()),
            self.tables().filter(|stations| stations.len() <= MAX_STATIONS),
        )
    }

    /// Points inside (0, 1) where this number of modes or the section has a kink, without a limit on their
    /// number, because the stiffness is integrated only once.
    pub(crate) fn breaks_of_stiffness(&self, modes: usize) -> Vec<f64> {
        let variations = self.segment.section.variations();
        let stations = variations.iter().map(|variation| variation.stations);
        self.with_stations(self.basis.breaks(modes), stations)
    }

    /// Adds the stations of tables, given as arc lengths of the segment, to these points.
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

    /// Polynomial degree of the section's properties between stations.
    pub(crate) fn degree_of_section(&self) -> usize {
        self.segment.section.variations().iter().map(|variation| variation.degree).max().unwrap_or(0)
    }

    /// Position as a fraction of the segment's length.
    pub(crate) fn place(&self, x: f64) -> f64 {
        self.from + self.part * x
    }

    pub(crate) fn section(&self, x: f64) -> SectionProperties {
        SectionProperties::at(&self.segment, self.place(x))
    }

    /// Whether the section is the same everywhere.
    pub(crate) fn has_constant_section(&self) -> bool {
        self.segment.section.variations().is_empty()
    }

    /// Reference strain.
    pub(crate) fn reference(&self, x: f64) -> [f64; STRAINS] {
        self.segment.reference_strain.at(self.place(x))
    }

    /// Derivative of the reference strain with respect to arc length, per metre.
    pub(crate) fn reference_slope(&self, x: f64) -> [f64; STRAINS] {
        self.segment.reference_strain.jet(self.place(x))[1].map(|slope| slope / self.segment.length)
    }

    /// Integral of the reference strain between two fractions.
    pub(crate) fn reference_between(&self, from: f64, to: f64) -> [f64; STRAINS] {
        let profile = &self.segment.reference_strain;
        if let Some(strain) = profile.constant() {
            return strain.map(|strain| strain * (to - from));
        }
        let [start, end] = [from, to].map(|x| profile.integral(self.place(x)));
        std::array::from_fn(|i| (end[i] - start[i]) / self.part)
    }
}
