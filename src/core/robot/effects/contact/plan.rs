//! Compiled contacts: rods as curves with radii, fixed balls and solids, and pairs of these.

use std::ops::Range;

use crate::description::rod::{Integral, Profile};
use crate::numerics::lie::Vector;
use crate::robot::effects::contact::shapes::obstacle::Solid;
use crate::robot::effects::contact::shapes::touch::Law;
use crate::robot::plan::space::Space;

/// Maximum number of separate contact intervals of a curve between two samples with the same object.
pub(crate) const MOST_INTERVALS: usize = 2;

/// Maximum number of subdivisions of an interval, where another face, edge or corner becomes the nearest one.
pub(crate) const MOST_CHANGES: usize = 4;

/// Number of Gauss-Legendre points per interval for the integration of contact: exact if overlap times shape
/// is a polynomial of degree 5.
pub(crate) const PLACES: usize = 3;

/// Nodes and weights of this rule on [0, 1].
pub(crate) const NODES: [f64; PLACES] = [0.112_701_665_379_258_31, 0.5, 0.887_298_334_620_741_7];
pub(crate) const WEIGHTS: [f64; PLACES] = [5.0 / 18.0, 8.0 / 18.0, 5.0 / 18.0];

/// Contacts of a plan.
#[derive(Clone, Debug, Default)]
pub(crate) struct Contacts<G: Space> {
    pub(crate) curves: Vec<Curve<G::Pack>>,
    /// Curves of each rod.
    pub(crate) rods: Vec<Range<usize>>,
    pub(crate) fixtures: Vec<Fixture<G::Pack>>,
    pub(crate) balls: Vec<Ball>,
    pub(crate) bodies: Vec<Body>,
    pub(crate) solids: Vec<Fixed>,
    pub(crate) pairs: Vec<Pair>,
    /// Largest number of packs of a curve's piece.
    pub(crate) packs: usize,
    /// Maximum number of simultaneous contact points.
    pub(crate) capacity: usize,
    /// What the coordinates do that move rods.
    pub(crate) mobilities: Vec<Mobility>,
}

/// By how much a coordinate turns and shifts what it moves per unit, at most: radians and metres.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Mobility {
    pub(crate) coordinate: usize,
    pub(crate) turn: f64,
    pub(crate) shift: f64,
}

/// A piece of a rod with contacts.
#[derive(Clone, Debug)]
pub(crate) struct Curve<P> {
    pub(crate) piece: usize,
    pub(crate) length: f64,
    /// Arc length of the rod at the start of the piece.
    pub(crate) start: f64,
    /// Weights for the integration points between neighbouring samples, if the whole interval is in contact.
    pub(crate) whole: Vec<[Vec<P>; PLACES]>,
    /// Whether sections have equal half extents in all directions of the kernel's space.
    pub(crate) is_round: bool,
    /// Sample places that are checked first: ends and nodes.
    pub(crate) samples: Vec<Sample>,
    /// Largest radius at its samples.
    pub(crate) thickest: f64,
    /// Largest distance of neighbouring samples, at zero strain.
    pub(crate) largest_gap: f64,
    /// Index of its first sample among those of all curves.
    pub(crate) first_sample: usize,
    /// Weights that convert values at the nodes to Chebyshev coefficients, polynomial by polynomial.
    pub(crate) expansion: Vec<Vec<P>>,
    /// Indices of its first coefficient among those of all curves, for the slope and for the position.
    pub(crate) first_coefficient: usize,
    pub(crate) first_term: usize,
    /// Integration weights up to any place.
    pub(crate) integral: Integral,
    /// Reciprocals of the nodes' quadrature weights times length.
    pub(crate) inverse_weights: Vec<P>,
    /// Pieces that move its end, each with the weights of the integral up to there; the curve's own piece is
    /// the last.
    pub(crate) moved_by: Vec<(usize, Vec<P>)>,
}

impl Pair {
    /// The stiffness at which a force presses the surfaces into each other by their soft depth.
    pub(crate) fn stiffness_for_soft_depth(&self, force: f64) -> f64 {
        force / self.soft_depth.powi(self.power)
    }
}

impl<P> Curve<P> {
    /// Number of polynomials of the curve.
    pub(crate) fn polynomials(&self) -> usize {
        self.integral.breaks().len() + 1
    }

    /// Number of coefficients of the position: for each polynomial one more than the slope has.
    pub(crate) fn terms(&self) -> usize {
        self.expansion.len() + self.polynomials()
    }

    /// Derivative of the radius with respect to the fraction of the length at a place; the radius is linear between samples.
    pub(crate) fn widening(&self, x: f64) -> f64 {
        let next = self.samples.partition_point(|sample| sample.x <= x).clamp(1, self.samples.len() - 1);
        let [begin, end] = [&self.samples[next - 1], &self.samples[next]];
        (end.radius - begin.radius) / (end.x - begin.x)
    }

    /// Arc lengths of the rod at the ends of one of its parts.
    pub(crate) fn arcs(&self, part: usize) -> [f64; 2] {
        [part, part + 1].map(|i| self.start + self.samples[i].x * self.length)
    }
}

/// A place of a curve that is checked first.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sample {
    /// Fraction of the curve's length.
    pub(crate) x: f64,
    /// Largest radius over all directions.
    pub(crate) radius: f64,
    /// Half extents along the y and z axes of the section.
    pub(crate) half_extents: [f64; 2],
}

/// A moving body in the frame of the plan to which surfaces are fixed.
#[derive(Clone, Debug)]
pub(crate) struct Fixture<P> {
    /// Index of a point of the plan; `None` is the world relative to a moving base.
    pub(crate) point: Option<usize>,
    pub(crate) moved_by: Vec<(usize, Vec<P>)>,
    /// Coordinates that rotate it, each with the largest rotation per unit.
    pub(crate) turned_by: Vec<(usize, f64)>,
}

/// A ball fixed to something.
#[derive(Clone, Debug)]
pub(crate) struct Ball {
    /// Index of the fixture; `None` is the frame of the plan.
    pub(crate) on: Option<usize>,
    /// Centre in the fixture's axes.
    pub(crate) centre: Vector<f64>,
    /// Radius; zero for the corner of a solid.
    pub(crate) radius: f64,
    /// Largest valid overlap: the radius, or half the thickness of the solid for a corner.
    pub(crate) thickness: f64,
}

/// Corners and edges of a body in contact with a solid: the points that can touch the solid first.
#[derive(Clone, Debug)]
pub(crate) struct Body {
    /// Index of the fixture; `None` is the frame of the plan.
    pub(crate) on: Option<usize>,
    /// Corners in the fixture's axes.
    pub(crate) corners: Vec<Vector<f64>>,
    /// Edges as pairs of corners.
    pub(crate) edges: Vec<[usize; 2]>,
    /// Index of its first corner among those of all bodies.
    pub(crate) first_corner: usize,
    /// Largest distance of a corner from the first one.
    pub(crate) size: f64,
    /// Rounding radius of corners and edges.
    pub(crate) radius: f64,
    /// Largest valid overlap, and twice the largest increase of the overlap in one step.
    pub(crate) thickness: f64,
    pub(crate) measure: f64,
}

/// A solid fixed to something.
#[derive(Clone, Debug)]
pub(crate) struct Fixed {
    /// Index of the fixture; `None` is the frame of the plan.
    pub(crate) on: Option<usize>,
    /// The solid in the fixture's axes.
    pub(crate) solid: Solid,
}

/// One of both sides of a pair.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Side {
    /// Curves of a rod.
    Rod(Range<usize>),
    Ball(usize),
    /// Corners and edges of a body, against a solid.
    Body(usize),
    Solid(usize),
}

/// The coefficient of sliding friction as a function of the arc length of a rod.
#[derive(Clone, Debug)]
pub(crate) struct FrictionAlong {
    pub(crate) profile: Profile<1>,
    /// Length of the rod, metres.
    pub(crate) length: f64,
}

/// A pair of surfaces that can touch. If one of them is a rod, it is the first.
#[derive(Clone, Debug)]
pub(crate) struct Pair {
    /// Index of the robot's contact, and whether its surfaces are swapped.
    pub(crate) contact: usize,
    pub(crate) is_turned: bool,
    pub(crate) sides: [Side; 2],
    pub(crate) law: Law,
    /// Friction along the first side, if it varies; the law has the largest.
    pub(crate) friction_along: Option<FrictionAlong>,
    /// Thickness of the thinner surface, and the power of lengths in the unit of the stiffness: 1, and 2 along a rod.
    pub(crate) thickness: f64,
    pub(crate) power: i32,
    /// Overlap that the forces on the pair produce in the softest contacts, with which searches for equilibria begin.
    pub(crate) soft_depth: f64,
    /// Distance by which the obstacle is larger then, metres.
    pub(crate) growth: f64,
    /// For a rod with itself, the distance along it in metres below which sections do not touch each other.
    pub(crate) neighbourhood: f64,
    /// Coordinates that move either side, in ascending order, as ranges of consecutive ones.
    pub(crate) reaches: Vec<Range<usize>>,
}
