//! Concentrated effects at places of a rod: forces, moments, rigid bodies, springs to the world.
//!
//! A place X inside a piece has the weights u_l of the integral up to it: it moves by `Psi(X) = sum_l u_l
//! S_l`. A wrench W at X has the generalised forces `Psi_j(X) . W = sum_l w_l S_j,l . (u_l / w_l) W` with the
//! quadrature weights w_l: node l carries the share u_l / w_l of it. Therefore the piece need not be divided
//! at X, the load is not smeared, and the summation by parts of the tangent remains exact.

use std::ops::Range;

use super::space::Passage;
use super::space::Space;
use crate::numerics::lie::{Quaternion, Vector};
use crate::robot::algebra::inertia::Inertia;
use crate::robot::effects::parts::AtPoint;

/// Pose relative to a place, in the axes there.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Offset {
    pub(crate) orientation: Quaternion<f64>,
    pub(crate) position: Vector<f64>,
}

impl Offset {
    /// Offset of something that has the offset `other` relative to this one.
    pub(crate) fn times(self, other: Self) -> Self {
        Self {
            orientation: self.orientation.times(other.orientation),
            position: self.position + self.orientation.rotation().apply(other.position),
        }
    }
}

/// A place along a rod, prepared for evaluating its pose in many states.
#[derive(Clone, Debug)]
pub struct Place {
    pub(crate) piece: usize,
    /// Fraction of the piece's length.
    pub(crate) x: f64,
    /// Number of the piece's nodes before the place, and the passage from the last of these (or from the
    /// piece's base).
    pub(crate) before: usize,
    pub(crate) passage: Passage,
    /// Weights of the integral from the piece's base, times length.
    pub(crate) weights: Vec<f64>,
    /// Offset from the end of the piece, if any.
    pub(crate) beside: Option<Offset>,
}

/// Concentrated effects at one place.
#[derive(Clone, Debug)]
pub(crate) struct Point<G: Space> {
    pub(crate) place: Place,
    /// Integration weights of the place; `None` for the end of a piece, which is a station.
    pub(crate) inside: Option<Inside<G>>,
    /// Total inertia of the bodies, about the place and in section axes.
    pub(crate) body: Option<Inertia<G, f64>>,
    pub(crate) effects: AtPoint<G>,
    /// Station of pieces attached here; pieces at the end of this piece use its own station.
    pub(crate) carries: Option<usize>,
    /// Whether the orientation of the section matters.
    pub(crate) is_oriented: bool,
}

impl<G: Space> Point<G> {
    /// A point without effects.
    pub(crate) fn empty(place: Place, inside: Option<Inside<G>>) -> Self {
        Self { place, inside, body: None, effects: AtPoint::default(), carries: None, is_oriented: false }
    }

    /// Integration weights of a point listed in [`Points::inside`].
    #[inline(always)]
    pub(crate) fn reach(&self) -> &Inside<G> {
        self.inside.as_ref().expect("points inside a piece are reached from its nodes")
    }
}

/// Integration weights of a place inside a piece.
#[derive(Clone, Debug)]
pub(crate) struct Inside<G: Space> {
    /// Weights of the integral up to the place, times length.
    pub(crate) up_to: Vec<G::Pack>,
    /// Share of a wrench at the place that each node carries.
    pub(crate) share: Vec<G::Pack>,
}

/// Indices of the points of a piece among those of the rod.
#[derive(Clone, Debug, Default)]
pub(crate) struct Points {
    pub(crate) inside: Range<usize>,
    /// Number of places with attached pieces among the points of preceding pieces.
    pub(crate) attachments_before: usize,
    /// At most one, because all effects at a place form one point.
    pub(crate) at_end: Range<usize>,
}

impl Points {
    pub(crate) fn all(&self) -> Range<usize> {
        self.inside.start..self.at_end.end
    }
}
