//! Contacts, compiled: rods as curves with radii, balls and solids that are fixed to something, and the pairs of these.

use std::ops::Range;

use super::space::Space;
use crate::lie::Vector;
use crate::robot::algebra::obstacle::Solid;
use crate::robot::algebra::touch::Law;
use crate::rod::Integral;

/// So many parts of a curve between two samples can touch the same thing.
pub(crate) const MOST_INTERVALS: usize = 2;

/// Each of these is divided where another face, edge or corner becomes the nearest one, at so many places at most.
pub(crate) const MOST_CHANGES: usize = 4;

/// On each of these parts contact is integrated at so many places (Gauss-Legendre): exact where overlap times shape
/// is a polynomial of degree 5 there.
pub(crate) const PLACES: usize = 3;

/// Nodes and weights of that rule on [0, 1].
pub(crate) const NODES: [f64; PLACES] = [0.112_701_665_379_258_31, 0.5, 0.887_298_334_620_741_7];
pub(crate) const WEIGHTS: [f64; PLACES] = [5.0 / 18.0, 8.0 / 18.0, 5.0 / 18.0];

/// The contacts of a plan.
#[derive(Clone, Debug)]
pub(crate) struct Contacts<G: Space> {
    pub(crate) curves: Vec<Curve<G::Pack>>,
    /// The curves of each rod.
    pub(crate) rods: Vec<Range<usize>>,
    pub(crate) fixtures: Vec<Fixture<G::Pack>>,
    pub(crate) balls: Vec<Ball>,
    pub(crate) bodies: Vec<Body>,
    pub(crate) solids: Vec<Fixed>,
    pub(crate) pairs: Vec<Pair>,
    /// The largest number of packs of a curve's piece.
    pub(crate) packs: usize,
    /// How many places can be touched at once.
    pub(crate) capacity: usize,
}

impl<G: Space> Contacts<G> {
    pub(crate) fn none() -> Self {
        Self {
            curves: Vec::new(),
            rods: Vec::new(),
            fixtures: Vec::new(),
            balls: Vec::new(),
            bodies: Vec::new(),
            solids: Vec::new(),
            pairs: Vec::new(),
            packs: 0,
            capacity: 0,
        }
    }
}

/// A piece of a rod that touches.
#[derive(Clone, Debug)]
pub(crate) struct Curve<P> {
    pub(crate) piece: usize,
    pub(crate) length: f64,
    /// Arc length of its rod where it begins.
    pub(crate) start: f64,
    /// How its nodes reach the places of the integrals between neighbouring samples, where all of that way is touched.
    pub(crate) whole: Vec<[Vec<P>; PLACES]>,
    /// Whether its sections reach as far in all directions that the kernel knows.
    pub(crate) is_round: bool,
    /// Places where it is looked at first: its ends and nodes.
    pub(crate) samples: Vec<Sample>,
    /// The longest way between neighbouring ones, at zero strain.
    pub(crate) largest_gap: f64,
    /// The first of them among those of all curves.
    pub(crate) first_sample: usize,
    /// Chebyshev coefficients of what has these values at the nodes: the weights of each, polynomial by polynomial.
    pub(crate) expansion: Vec<Vec<P>>,
    /// The first of them among those of all curves, and the first one of the position among those.
    pub(crate) first_coefficient: usize,
    pub(crate) first_term: usize,
    /// How its nodes reach any place.
    pub(crate) integral: Integral,
    /// One over the quadrature weights, times the length, of its nodes.
    pub(crate) inverse_weights: Vec<P>,
    /// The pieces that move its end, each with the weights of the integral up to there; itself last.
    pub(crate) moved_by: Vec<(usize, Vec<P>)>,
}

impl<P> Curve<P> {
    /// How many polynomials it is made of.
    pub(crate) fn polynomials(&self) -> usize {
        self.integral.breaks().len() + 1
    }

    /// The number of coefficients of its position: one more for each polynomial than its slope has.
    pub(crate) fn terms(&self) -> usize {
        self.expansion.len() + self.polynomials()
    }

    /// The arc lengths of the rod between which one of its parts lies.
    pub(crate) fn arcs(&self, part: usize) -> [f64; 2] {
        [part, part + 1].map(|i| self.start + self.samples[i].x * self.length)
    }
}

/// A place where a curve is looked at first.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sample {
    /// Fraction of the curve's length.
    pub(crate) x: f64,
    /// In the direction in which that is most.
    pub(crate) radius: f64,
    /// Along the y and the z axis of the section.
    pub(crate) half_extents: [f64; 2],
}

/// What surfaces are fixed to that moves in the frame of the plan.
#[derive(Clone, Debug)]
pub(crate) struct Fixture<P> {
    /// A point of the plan; nothing is the world, as a base that moves sees it.
    pub(crate) point: Option<usize>,
    pub(crate) moved_by: Vec<(usize, Vec<P>)>,
    /// The coordinates that turn it, each with the largest rate at which a unit of it does.
    pub(crate) turned_by: Vec<(usize, f64)>,
}

/// A ball that is fixed to something.
#[derive(Clone, Debug)]
pub(crate) struct Ball {
    /// The fixture; nothing is the frame of the plan.
    pub(crate) on: Option<usize>,
    /// In the axes there.
    pub(crate) centre: Vector<f64>,
    /// Zero of the corner of a solid.
    pub(crate) radius: f64,
    /// How deep it may sink in: its radius, or half the thickness of the solid that it is a corner of.
    pub(crate) thickness: f64,
}

/// Corners and edges of a body that meets a solid: all that can touch this first.
#[derive(Clone, Debug)]
pub(crate) struct Body {
    /// The fixture; nothing is the frame of the plan.
    pub(crate) on: Option<usize>,
    /// In the axes there.
    pub(crate) corners: Vec<Vector<f64>>,
    /// By their corners.
    pub(crate) edges: Vec<[usize; 2]>,
    /// The first of its corners among those of all bodies.
    pub(crate) first_corner: usize,
    /// No corner is further from the first one.
    pub(crate) size: f64,
    /// By which corners and edges are rounded.
    pub(crate) radius: f64,
    /// How deep it may sink in, and twice how deep it may get in a single step.
    pub(crate) thickness: f64,
    pub(crate) measure: f64,
}

/// A solid that is fixed to something.
#[derive(Clone, Debug)]
pub(crate) struct Fixed {
    /// The fixture; nothing is the frame of the plan.
    pub(crate) on: Option<usize>,
    /// In the axes there.
    pub(crate) solid: Solid,
}

/// One of two that touch.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Side {
    /// The curves of a rod.
    Rod(Range<usize>),
    Ball(usize),
    /// The corners and edges of a body, which meet a solid.
    Body(usize),
    Solid(usize),
}

/// A pair of surfaces that can touch. If one of them is a rod, it is the first.
#[derive(Clone, Debug)]
pub(crate) struct Pair {
    /// The contact of the robot that it is of, and whether its surfaces are the other way round there.
    pub(crate) contact: usize,
    pub(crate) is_turned: bool,
    pub(crate) sides: [Side; 2],
    pub(crate) law: Law,
    /// Of a rod with itself: places that are nearer to each other along it are neighbours, which do not touch. Metres.
    pub(crate) neighbourhood: f64,
    /// The coordinates that move any of both, in ascending order, as runs of neighbouring ones.
    pub(crate) reaches: Vec<Range<usize>>,
}
