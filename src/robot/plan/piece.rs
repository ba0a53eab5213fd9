//! A piece of a rod, or a joint, compiled for computing.

use super::hinge::Hinge;
use super::immersion::Immersed;
use super::load::Spread;
use super::material::{Component, Coupling, Moments};
use super::point::Points;
use super::space::Space;
use super::stretch::Stretch;
use super::tree::Joined;
use crate::lie::{LANES, Scalar, Twist};
use crate::linalg::Matrix;
use crate::robot::algebra::inertia::Inertia;
use crate::rod::Gauss;
use crate::rod::piece::Piece;

/// One piece of a [`Plan`](super::Plan): a piece of a rod, a joint, or what is rigid between joints. A joint of one
/// coordinate and what is rigid have no nodes. A joint that turns about all axes is a piece without mass that has the
/// length one and bends alike all along.
#[derive(Clone, Debug)]
pub(crate) struct PiecePlan<G: Space> {
    pub(crate) length: f64,
    pub(crate) joined: Joined<G>,
    /// Whether it is no piece of a rod.
    pub(crate) is_joint: bool,
    /// The piece as a joint with one coordinate.
    pub(crate) hinge: Option<Hinge<G>>,
    /// First coordinate and number of coordinates.
    pub(crate) first: usize,
    pub(crate) n: usize,
    /// First pack of nodes and number of packs.
    pub(crate) first_pack: usize,
    pub(crate) packs: usize,
    pub(crate) gauss: Gauss,
    /// Between neighbouring nodes, or the ends and the nodes next to them, in metres; zero where twisting turns
    /// nothing, because the piece is straight.
    pub(crate) largest_gap: f64,
    /// Of the reference strain, at the nodes: radians per metre.
    pub(crate) reference_curvature: Vec<G::Axial<f64>>,
    pub(crate) largest_reference_curvature: f64,
    /// Quadrature weights, times the length.
    pub(crate) weights: Vec<G::Pack>,
    /// Integration matrix from the piece's base to the nodes, times the length: entry `[pack * nodes + l]`.
    pub(crate) from_base: Vec<G::Pack>,
    /// The same from the nodes to the piece's end.
    pub(crate) to_end: Vec<G::Pack>,
    /// Basis at the nodes: entry `[degree * packs + pack]`.
    pub(crate) basis: Vec<G::Pack>,
    /// Basis times quadrature weights.
    pub(crate) weighted_basis: Vec<G::Pack>,
    pub(crate) turning: G::Constants,
    pub(crate) components: Vec<Component>,
    /// What is computed; nothing where there are no nodes.
    pub(crate) source: Option<Piece>,
    /// Linear part of the reference strain at the nodes.
    pub(crate) reference_slope: Vec<G::Vector<G::Pack>>,
    /// Its stretch, where it has modes of that.
    pub(crate) stretch: Option<Stretch>,
    /// Whether stretch or shear can differ from those of a straight rod.
    pub(crate) is_extensible: bool,
    /// Stiffness between components, where strains are coupled.
    pub(crate) couplings: Vec<Coupling>,
    /// Mass per length at the nodes.
    pub(crate) mass: Vec<G::Pack>,
    pub(crate) moments: Moments<G>,
    pub(crate) retardation_time: f64,
    /// Distributed and concentrated effects on the piece.
    pub(crate) spread: Vec<Spread<G>>,
    pub(crate) points: Points,
    /// The fluid around it, where that answers to motion.
    pub(crate) immersed: Option<Immersed<G>>,
}

impl<G: Space> PiecePlan<G> {
    /// The moments of its sections as those of any.
    pub(crate) fn general_moments(&self, frame: G::Frame) -> Moments<G> {
        match &self.moments {
            Moments::General(_) => self.moments.clone(),
            Moments::Round(rotary) => Moments::General(
                self.mass
                    .iter()
                    .zip(rotary)
                    .map(|(&mass, &rotary)| Inertia::round(frame, mass, rotary))
                    .collect(),
            ),
        }
    }

    /// Couples all components that are not coupled yet, by zeros.
    pub(crate) fn couple_all(&mut self) {
        for (i, a) in self.components.iter().enumerate() {
            for b in &self.components[i + 1..] {
                let first = [a.first, b.first];
                if self.couplings.iter().all(|coupling| coupling.first != first) {
                    self.couplings.push(Coupling { first, stiffness: Matrix::zeros(a.modes, b.modes) });
                }
            }
        }
    }

    /// The part of a segment that a piece with nodes is computed of.
    pub(crate) fn part(&self) -> &Piece {
        self.source.as_ref().expect("what has nodes is a part of a segment")
    }

    /// Its coordinates.
    pub(crate) fn coordinates(&self) -> std::ops::Range<usize> {
        self.first..self.first + self.n
    }

    /// The packs of this piece's nodes among those of the rod.
    pub(crate) fn node_packs(&self) -> std::ops::Range<usize> {
        self.first_pack..self.first_pack + self.packs
    }

    /// The row of an integration matrix (`from_base` or `to_end`) that leads to pack `pack`.
    pub(crate) fn row<'a>(&self, matrix: &'a [G::Pack], pack: usize) -> &'a [G::Pack] {
        let nodes = self.packs * LANES;
        &matrix[pack * nodes..(pack + 1) * nodes]
    }

    /// The rows of an integration matrix.
    #[inline(always)]
    pub(crate) fn rows<'a>(&self, matrix: &'a [G::Pack]) -> std::slice::ChunksExact<'a, G::Pack> {
        matrix.chunks_exact(self.packs * LANES)
    }

    /// [`Self::field`] at all nodes.
    #[inline(always)]
    pub(crate) fn fields(&self, q: &[f64], fields: &mut [Twist<G, G::Pack>]) {
        fields.fill(Twist::zero());
        for component in &self.components {
            let rows = self.basis.chunks_exact(self.packs);
            for (&q, row) in q[component.first..][..component.modes].iter().zip(rows) {
                for (field, &basis) in fields.iter_mut().zip(row) {
                    let entry = field.component_mut(component.index);
                    *entry = basis.mul_add(G::Pack::splat(q), *entry);
                }
            }
        }
    }

    /// `sum_k phi_k q_k` of every strain at the nodes of one pack; components that do not exist are zero.
    #[inline(always)]
    pub(crate) fn field(&self, q: &[f64], pack: usize) -> Twist<G, G::Pack> {
        let mut field = Twist::zero();
        for component in &self.components {
            let mut sum = G::Pack::splat(0.0);
            for (k, &q) in q[component.first..][..component.modes].iter().enumerate() {
                sum = self.basis[k * self.packs + pack].mul_add(G::Pack::splat(q), sum);
            }
            *field.component_mut(component.index) = sum;
        }
        field
    }
}
