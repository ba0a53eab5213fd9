//! The gap of a part of a rod to the wall of a tube, as the search for overlaps sees it.

use super::curve::Part;
use super::shapes::bracket;
use super::shapes::obstacle::Placed;
use super::shapes::tube::{Location, Tube};

/// Maximum number of equal pieces of a part in a bore. More do not fit beside its clearance where a part bends by a thousand clearances.
const MOST_PARTS: usize = 32;

/// A part is divided until the velocity across the bore changes in a piece by this many clearances.
const CHANGE_OF_SPEED: f64 = 2.0;

/// Maximum number of places at which a part is divided: between equal pieces, and two before each end of a tube.
const MOST_CUTS: usize = MOST_PARTS + 3;

/// A gap g to the wall of a bore, and its slope, transformed for the search to `g - g^2 / (2 C)` with the clearance C, which shrinks as
/// the rod widens. In the middle of the bore, g = C has a peak with unbounded negative second derivative; the transformed gap has the
/// same zeros with the same slopes and a bounded one. Gaps are limited to the clearance.
pub(super) fn up_to_clearance((value, slope): (f64, f64), clearance: f64, widening: f64) -> (f64, f64) {
    if clearance <= 0.0 {
        return (value, slope);
    }
    let part = (value / clearance).min(1.0);
    let seen = if part < 1.0 { value } else { clearance };
    let slope = if part < 1.0 { slope * (1.0 - part) } else { 0.0 };
    (seen * (1.0 - 0.5 * part), slope - 0.5 * part * part * widening)
}

/// A part of a rod, divided where it crosses the planes across the ends of a tube and where it is a radius beyond them. In the bore it moves
/// along the wall, just beyond an end away from its rim, and farther away nothing touches.
#[derive(Clone, Copy)]
pub(super) struct Pieces {
    cuts: [f64; MOST_CUTS],
    number: usize,
    bends: [f64; MOST_CUTS + 1],
}

impl Pieces {
    /// One piece, of a gap with this bound of the negative second derivative.
    pub(super) fn one(bend: f64) -> Self {
        Self { cuts: [0.0; MOST_CUTS], number: 0, bends: [bend; MOST_CUTS + 1] }
    }

    /// Ends the last piece at a place, and begins one with this bound.
    fn cut(&mut self, x: f64, bend: f64) {
        self.cuts[self.number] = x;
        self.number += 1;
        self.bends[self.number] = bend;
    }

    /// The places at which the part is divided, in ascending order.
    pub(super) fn cuts(&self) -> &[f64] {
        &self.cuts[..self.number]
    }

    /// The bound in the piece with a place.
    pub(super) fn bend(&self, x: f64) -> f64 {
        self.bends[self.cuts().partition_point(|cut| *cut <= x)]
    }
}

/// A part of a rod near a tube.
pub(super) struct InTube<'a> {
    pub(super) part: &'a Part<'a>,
    pub(super) solid: Placed<'a>,
    pub(super) tube: &'a Tube,
    /// Bound of the negative second derivative of the distance from the wall outside of the bore.
    pub(super) bend: f64,
}

impl InTube<'_> {
    /// The pieces of the part, for the transformed gap ([`up_to_clearance`]); `None` if it is outside of the wall, or as wide as the bore.
    ///
    /// With the distance rho from the centre line and the clearance C, the transformed gap is `(C^2 - rho^2) / (2 C)`. Its negative second
    /// derivative is the square of the velocity across the centre line over C, plus those of both curves; beyond the ends, that of the whole
    /// velocity. The velocity across changes by no more than both curves bend.
    pub(super) fn pieces(&self) -> Option<Pieces> {
        let radius = self.part.radii[0].max(self.part.radii[1]);
        let clearance = self.tube.radius() - radius;
        let locations =
            self.part.ends.map(|[position, _]| self.tube.location(self.solid.local_position(position)));
        if clearance <= 0.0 || locations.iter().all(|location| *location == Location::Outside) {
            return None;
        }
        let [[_, start], [_, end]] = self.part.ends;
        let fastest = start.dot(start).max(end.dot(end)).sqrt() + self.part.bend;
        let beyond = fastest * fastest / clearance + self.bend;
        let crossed = |location: Location, other: Location| match location {
            Location::Beyond(end) if other != location => Some(end),
            _ => None,
        };
        let [first, last] = [crossed(locations[0], locations[1]), crossed(locations[1], locations[0])];
        if let [Location::Beyond(end), Location::Beyond(_)] = locations
            && first.is_none()
        {
            let nearest = self.height(end, 0.0).0.min(self.height(end, 1.0).0);
            let is_far = nearest - self.part.bend > radius;
            return Some(Pieces::one(if is_far { self.bend } else { beyond }));
        }
        let mut pieces = Pieces::one(beyond);
        let (mut from, mut to) = (0.0, 1.0);
        if let Some(end) = first {
            if self.height(end, 0.0).0 > radius {
                pieces.bends[0] = self.bend;
                pieces.cut(self.rise(end, radius, [1.0, 0.0]), beyond);
            }
            from = self.rise(end, 0.0, [1.0, 0.0]);
            pieces.cut(from, beyond);
        }
        if let Some(end) = last {
            to = self.rise(end, 0.0, [0.0, 1.0]);
        }
        // Beside an end outside, the sides are not those of the bore.
        if !locations.contains(&Location::Outside) {
            self.divide(&mut pieces, [from, to], [first, last], clearance);
        }
        if let Some(end) = last {
            pieces.cut(to, beyond);
            if self.height(end, 1.0).0 > radius {
                pieces.cut(self.rise(end, radius, [0.0, 1.0]), self.bend);
            }
        }
        Some(pieces)
    }

    /// Divides the last piece, between two places of which these are in the planes across ends of the tube, into equal ones.
    fn divide(&self, pieces: &mut Pieces, [from, to]: [f64; 2], crossed: [Option<usize>; 2], clearance: f64) {
        let change = self.bend * (to - from);
        let number = (change / (CHANGE_OF_SPEED * clearance)).ceil().clamp(1.0, MOST_PARTS as f64);
        let mut before = self.speed_across(from, crossed[0]);
        for k in 1..=number as usize {
            let is_last = k as f64 == number;
            let x = if is_last { to } else { from + (to - from) * k as f64 / number };
            let after = self.speed_across(x, if is_last { crossed[1] } else { None });
            let fastest = before.max(after) + 0.5 * change / number;
            pieces.bends[pieces.number] = fastest * fastest / clearance + self.bend;
            if !is_last {
                pieces.cut(x, 0.0);
            }
            before = after;
        }
    }

    /// Speed across the centre line at a place, or across the axis of an end whose plane it is in.
    fn speed_across(&self, x: f64, crossed: Option<usize>) -> f64 {
        let [position, slope, _] = self.part.at(x);
        let slope = self.solid.local_direction(slope);
        let across = match crossed {
            Some(end) => {
                let outward = self.tube.outward(end);
                slope - outward * outward.dot(slope)
            }
            None => self.tube.across(self.solid.local_position(position), slope),
        };
        across.dot(across).sqrt()
    }

    /// Height of a place of the part above the plane of an end of the tube, and its derivative.
    fn height(&self, end: usize, x: f64) -> (f64, f64) {
        let [position, slope, _] = self.part.at(x);
        let height = self.tube.height(end, self.solid.local_position(position));
        (height, self.tube.outward(end).dot(self.solid.local_direction(slope)))
    }

    /// The place at which the part rises above a height over the plane of an end, on the way from a place below.
    fn rise(&self, end: usize, height: f64, [from, to]: [f64; 2]) -> f64 {
        let above = |t: f64| {
            let (here, slope) = self.height(end, from + (to - from) * t);
            (here - height, slope * (to - from))
        };
        let [low, high] = [above(0.0).0, above(1.0).0];
        let guess = if high > low { (-low / (high - low)).clamp(0.0, 1.0) } else { 0.5 };
        from + (to - from) * bracket::root(guess, above)
    }
}
