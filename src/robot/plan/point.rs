//! Concentrated effects at places of the rod: forces, moments, rigid bodies, springs to the world.
//!
//! A place X inside a piece is reached by the weights u_l of the integral up to it: what lies there moves by
//! `Psi(X) = sum_l u_l S_l`. A wrench W there has the generalised forces
//! `Psi_j(X) . W = sum_l w_l S_j,l . (u_l / w_l) W` with the quadrature weights w_l: node l carries the share u_l /
//! w_l of it. So a piece need not end there, nothing is smeared out, and the summation by parts behind the tangent
//! stays exact.

use std::ops::Range;

use super::space::Passage;
use super::space::Space;
use crate::lie::{Quaternion, Vector};
use crate::robot::algebra::inertia::Inertia;

/// How something lies that is fixed beside a place, in the axes there.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Offset {
    pub(crate) orientation: Quaternion<f64>,
    pub(crate) position: Vector<f64>,
}

impl Offset {
    /// That of what is fixed beside something at this offset.
    pub(crate) fn times(self, other: Self) -> Self {
        Self {
            orientation: self.orientation.times(other.orientation),
            position: self.position + self.orientation.rotation().apply(other.position),
        }
    }
}

/// A place along a rod, prepared for finding its pose in many states.
#[derive(Clone, Debug)]
pub struct Place {
    pub(crate) piece: usize,
    /// Fraction of the piece's length.
    pub(crate) x: f64,
    /// Nodes of the piece before the place, and the way from the last of them (from the piece's base if there is none).
    pub(crate) before: usize,
    pub(crate) passage: Passage,
    /// Weights of the integral from the piece's base, times its length.
    pub(crate) weights: Vec<f64>,
    /// Where what is meant is fixed beside the end of the piece.
    pub(crate) beside: Option<Offset>,
}

/// The concentrated effects at one place.
#[derive(Clone, Debug)]
pub(crate) struct Point<G: Space> {
    pub(crate) place: Place,
    /// How the nodes of the piece reach it; nothing at the end of a piece, which is a station.
    pub(crate) inside: Option<Inside<G>>,
    /// The bodies there together, about the place and in the section's axes.
    pub(crate) body: Option<Inertia<G, f64>>,
    /// The loads that act there.
    pub(crate) loads: Vec<usize>,
    /// The anchors of the springs that hold it.
    pub(crate) anchors: Vec<usize>,
    /// The ends of straight parts of tendons there, each by twice the place of the part, and one more for the second.
    pub(crate) pulled: Vec<usize>,
    /// The ends of closed loops there, each by twice the place of the tie, and one more for the second.
    pub(crate) tied: Vec<usize>,
    /// The surfaces that are fixed to it, by their place among those that are fixed to links.
    pub(crate) surfaces: Vec<usize>,
    /// The station of other pieces that are attached there; those at the end of a piece are at its own station.
    pub(crate) carries: Option<usize>,
    /// Whether it matters how the section is turned.
    pub(crate) is_oriented: bool,
}

impl<G: Space> Point<G> {
    /// How the nodes reach a point that [`Points::inside`] names.
    #[inline(always)]
    pub(crate) fn reach(&self) -> &Inside<G> {
        self.inside.as_ref().expect("points inside a piece are reached from its nodes")
    }
}

/// How the nodes of a piece reach a place inside it.
#[derive(Clone, Debug)]
pub(crate) struct Inside<G: Space> {
    /// Weights of the integral up to the place, times the length.
    pub(crate) up_to: Vec<G::Pack>,
    /// The share of a wrench at the place that each node carries.
    pub(crate) share: Vec<G::Pack>,
}

/// Where the points of a piece stand among those of the rod.
#[derive(Clone, Debug, Default)]
pub(crate) struct Points {
    pub(crate) inside: Range<usize>,
    /// Places where others are attached, among the points of the pieces before.
    pub(crate) attachments_before: usize,
    /// At most one, as all that is at one place makes one point.
    pub(crate) at_end: Range<usize>,
}

impl Points {
    pub(crate) fn all(&self) -> Range<usize> {
        self.inside.start..self.at_end.end
    }
}
