//! Contacts in a state.

use std::ops::Range;

use crate::lie::{Lanes, Vector};
use crate::robot::algebra::distance;
use crate::robot::algebra::obstacle::Pose;
use crate::robot::algebra::touch::{Meeting, Pressing};
use crate::robot::plan::contact::{Contacts, Curve};
use crate::robot::plan::space::Space;

/// What is known of contact: moved out of the workspace while it is found.
#[derive(Clone, Debug)]
pub(crate) struct ContactState<P> {
    /// Chebyshev coefficients of all curves.
    pub(crate) terms: Vec<Term>,
    /// Likewise of the y and z axes of the sections, of curves that are not round; none if there are no such curves.
    pub(crate) axes: Vec<[Vector<f64>; 2]>,
    /// Position and slope at the samples of all curves. Slopes are known of those that were seen closely; of those that nothing
    /// may touch, the slopes at the ends are those at the nodes next to them.
    pub(crate) samples: Vec<[Vector<f64>; 2]>,
    /// What the parts of curves that were seen closely lie in between two samples, each with the number of its first sample.
    pub(crate) spans: Vec<Span>,
    /// Of every curve, the centre and the radius of a ball that it lies in, and whether anything else may touch it.
    pub(crate) bounds: Vec<(Vector<f64>, f64)>,
    pub(crate) is_near: Vec<bool>,
    /// Whether any ball or body is near what it may touch.
    pub(crate) is_rigid_near: bool,
    /// Whether curves were seen closely in this state, and what these lie in around their chords.
    pub(crate) is_seen: Vec<bool>,
    pub(crate) chords: Vec<Span>,
    /// Balls around branches of rods (see `effect::contact::near`).
    pub(crate) branches: Vec<(Vector<f64>, f64)>,
    /// Curves of two rods that may touch, pair by pair, in ascending order; and which of these are of each pair.
    pub(crate) near: Vec<[usize; 2]>,
    pub(crate) near_of: Vec<Range<usize>>,
    /// Centres of the balls, corners of the bodies, and where the axes of the solids are.
    pub(crate) centres: Vec<Vector<f64>>,
    pub(crate) corners: Vec<Vector<f64>>,
    pub(crate) poses: Vec<Pose>,
    /// Where surfaces were in another shape.
    pub(crate) noted: Noted,
    /// Whether surfaces pass through each other.
    pub(crate) is_left: bool,
    /// Where anything touches; there is memory for all that can.
    pub(crate) touches: Vec<Touch>,
    /// How fast the distances of those of another motion grow.
    pub(crate) rates: Vec<f64>,
    /// Of every touch and side, how the nodes of its piece reach it.
    pub(crate) up_to: Vec<P>,
    /// Memory for weights of nodes, and for polynomials.
    pub(crate) weights: Vec<f64>,
    pub(crate) polynomials: Vec<f64>,
}

/// Where surfaces are in a shape.
#[derive(Clone, Debug, Default)]
pub(crate) struct Noted {
    /// Its coordinates.
    pub(crate) of: Vec<f64>,
    /// Samples and bounds of all curves, centres of all balls, corners of all bodies, and axes of all solids, as above.
    pub(crate) places: Vec<Vector<f64>>,
    pub(crate) bounds: Vec<(Vector<f64>, f64)>,
    pub(crate) centres: Vec<Vector<f64>>,
    pub(crate) corners: Vec<Vector<f64>>,
    pub(crate) poses: Vec<Pose>,
    /// How far the curves have moved since then, at most; balls around what they sweep, and around what branches of rods sweep.
    pub(crate) moved: Vec<f64>,
    pub(crate) swept: Vec<(Vector<f64>, f64)>,
    pub(crate) branches: Vec<(Vector<f64>, f64)>,
}

/// Of one Chebyshev polynomial in the position of a curve, and in its first and second derivatives along the fraction of its
/// length.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Term {
    pub(crate) position: Vector<f64>,
    pub(crate) slope: Vector<f64>,
    pub(crate) bend: Vector<f64>,
}

/// All that is no further from a segment than its width.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Span {
    ends: [Vector<f64>; 2],
    width: f64,
    /// A ball that it lies in.
    centre: Vector<f64>,
    radius: f64,
}

impl Span {
    pub(crate) fn new(ends: [Vector<f64>; 2], width: f64) -> Self {
        let radius = width + 0.5 * distance::between(ends[0], ends[1]);
        Self { ends, width, centre: (ends[0] + ends[1]) * 0.5, radius }
    }

    pub(crate) fn width(&self) -> f64 {
        self.width
    }

    /// That and what is next to it.
    pub(crate) fn widened(&self, by: f64) -> Self {
        Self { width: self.width + by, radius: self.radius + by, ..*self }
    }

    /// What is in it is not nearer to a point than that.
    pub(crate) fn distance(&self, point: Vector<f64>) -> f64 {
        distance::to_segment(point, self.ends) - self.width
    }

    /// Whether two overlap.
    pub(crate) fn meets(&self, other: &Self) -> bool {
        let (way, reach) = (self.centre - other.centre, self.radius + other.radius);
        way.dot(way) <= reach * reach
            && distance::of_segments(self.ends, other.ends) <= self.width + other.width
    }
}

/// Where two sides touch.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Touch {
    pub(crate) pair: usize,
    pub(crate) sides: [Standing; 2],
    /// In space and the frame of the plan.
    pub(crate) centres: [Vector<f64>; 2],
    pub(crate) meeting: Meeting,
    pub(crate) pressing: Pressing,
}

/// Where a side of a touch is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Standing {
    /// At a fraction of the length of a curve.
    Along { curve: usize, x: f64 },
    /// On a fixture.
    On(usize),
    /// In the frame of the plan.
    Still,
}

impl Standing {
    /// That of what is fixed to something.
    pub(crate) fn of(on: Option<usize>) -> Self {
        on.map_or(Self::Still, Self::On)
    }
}

impl<P> Default for ContactState<P> {
    /// Nothing, without any memory.
    fn default() -> Self {
        Self {
            terms: Vec::new(),
            axes: Vec::new(),
            samples: Vec::new(),
            spans: Vec::new(),
            bounds: Vec::new(),
            is_near: Vec::new(),
            is_seen: Vec::new(),
            chords: Vec::new(),
            branches: Vec::new(),
            near: Vec::new(),
            near_of: Vec::new(),
            centres: Vec::new(),
            corners: Vec::new(),
            poses: Vec::new(),
            noted: Noted::default(),
            is_rigid_near: false,
            is_left: false,
            touches: Vec::new(),
            rates: Vec::new(),
            up_to: Vec::new(),
            weights: Vec::new(),
            polynomials: Vec::new(),
        }
    }
}

impl<P: Lanes> ContactState<P> {
    pub(crate) fn new<G: Space<Pack = P>>(contacts: &Contacts<G>) -> Self {
        let samples = contacts.curves.iter().map(|curve| curve.samples.len()).sum();
        let coefficients = contacts.curves.iter().map(|curve| curve.expansion.len()).sum();
        let terms = contacts.curves.iter().map(Curve::terms).sum();
        let is_round = contacts.curves.iter().all(|curve| curve.is_round);
        let nodes = contacts.packs * crate::lie::LANES;
        Self {
            terms: vec![
                Term { position: Vector::zero(), slope: Vector::zero(), bend: Vector::zero() };
                terms
            ],
            axes: vec![[Vector::zero(); 2]; if is_round { 0 } else { coefficients }],
            samples: vec![[Vector::zero(); 2]; samples],
            spans: vec![Span::new([Vector::zero(); 2], 0.0); samples],
            bounds: vec![(Vector::zero(), 0.0); contacts.curves.len()],
            is_near: vec![false; contacts.curves.len()],
            is_seen: vec![false; contacts.curves.len()],
            chords: vec![Span::new([Vector::zero(); 2], 0.0); contacts.curves.len()],
            branches: vec![(Vector::zero(), 0.0); 2 * contacts.curves.len()],
            near: Vec::new(),
            near_of: vec![0..0; contacts.pairs.len()],
            centres: vec![Vector::zero(); contacts.balls.len()],
            corners: vec![Vector::zero(); contacts.bodies.iter().map(|body| body.corners.len()).sum()],
            poses: vec![Pose::unmoved(); contacts.solids.len()],
            noted: Noted::default(),
            is_rigid_near: false,
            is_left: false,
            touches: Vec::with_capacity(contacts.capacity),
            rates: Vec::with_capacity(contacts.capacity),
            up_to: vec![P::splat(0.0); 2 * contacts.capacity * contacts.packs],
            weights: vec![0.0; nodes],
            polynomials: vec![0.0; nodes + 1],
        }
    }

    /// How the nodes of its piece reach a side of a touch: the weights of the integral up to it, times the length.
    pub(crate) fn reach(&self, packs: usize, touch: usize, side: usize) -> &[P] {
        &self.up_to[(2 * touch + side) * packs..][..packs]
    }
}

/// Memory for the tangent of contact.
#[derive(Clone, Debug)]
pub(crate) struct ContactTangent {
    /// How the sides of the touch at hand move with the coordinates, and how their motion changes.
    pub(crate) moved: Vec<[[Vector<f64>; 2]; 2]>,
    pub(crate) faster: Vec<[[Vector<f64>; 2]; 2]>,
    /// The former, component by component: turns and shifts of the first side, then of the second.
    pub(crate) components: [Vec<f64>; 12],
    /// What each side answers to a unit of each coordinate: moment and force.
    pub(crate) answers: Vec<[[f64; 6]; 2]>,
    pub(crate) followed: Followed,
}

/// Friction as the tangents of an iteration linearise it (see `effect::contact::follow`).
#[derive(Clone, Debug)]
pub(crate) struct Followed {
    /// Which part of the last increment was taken; nothing where tangents are exact.
    pub(crate) length: Option<f64>,
    /// Whether the iteration begins.
    pub(crate) is_new: bool,
    /// At the touches of the tangent at hand, and of the last one of the iteration.
    pub(crate) now: Vec<Rubbing>,
    pub(crate) before: Vec<Rubbing>,
}

/// Friction at a touch as it is linearised.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Rubbing {
    /// The pair, and the curve of the first side.
    pub(crate) of: [usize; 2],
    /// Where on that it is.
    pub(crate) x: f64,
    pub(crate) pressing: Pressing,
    /// Of a unit normal force, on the second side.
    pub(crate) linearised: Vector<f64>,
}

impl ContactTangent {
    pub(crate) fn new<G: Space>(contacts: &Contacts<G>, n: usize) -> Self {
        let n = if contacts.pairs.is_empty() { 0 } else { n };
        Self {
            moved: vec![[[Vector::zero(); 2]; 2]; n],
            faster: vec![[[Vector::zero(); 2]; 2]; n],
            components: std::array::from_fn(|_| vec![0.0; n]),
            answers: vec![[[0.0; 6]; 2]; n],
            followed: Followed {
                length: None,
                is_new: true,
                now: Vec::with_capacity(contacts.capacity),
                before: Vec::with_capacity(contacts.capacity),
            },
        }
    }
}
