//! A compiled piece of a rod, or a compiled joint.

use super::hinge::Hinge;
use super::joined::Joined;
use super::material::{Component, Coupling, Moments};
use super::point::Points;
use super::space::Space;
use super::stretch::Stretch;
use crate::description::rod::Gauss;
use crate::description::rod::piece::Piece;
use crate::numerics::lie::{LANES, Scalar, Twist};
use crate::numerics::linalg::Matrix;
use crate::robot::algebra::inertia::Inertia;
use crate::robot::effects::fluid::plan::Immersed;
use crate::robot::effects::load::plan::Spread;

/// A piece of a [`Plan`](super::Plan): a piece of a rod, a joint, or a rigid part between joints. A joint
/// with one coordinate and a rigid part have no nodes. A spherical joint is a massless piece of length one
/// with constant curvature.
#[derive(Clone, Debug)]
pub(crate) struct PiecePlan<G: Space> {
    pub(crate) length: f64,
    pub(crate) joined: Joined<G>,
    /// Whether the piece is not part of a rod.
    pub(crate) is_joint: bool,
    /// The hinge, for a joint with one coordinate.
    pub(crate) hinge: Option<Hinge<G>>,
    /// Index of the first coordinate, and number of coordinates.
    pub(crate) first: usize,
    pub(crate) n: usize,
    /// Index of the first pack of nodes, and number of packs.
    pub(crate) first_pack: usize,
    pub(crate) packs: usize,
    pub(crate) gauss: Gauss,
    /// Largest distance between neighbouring nodes, or between an end and the adjacent node, in metres; zero
    /// for straight pieces, in which torsion does not change the shape.
    pub(crate) largest_gap: f64,
    /// Reference curvature at the nodes, radians per metre.
    pub(crate) reference_curvature: Vec<G::Axial<f64>>,
    pub(crate) largest_reference_curvature: f64,
    /// Quadrature weights times length.
    pub(crate) weights: Vec<G::Pack>,
    /// Integration matrix from the piece's base to the nodes, times length: entry `[pack * nodes + l]`.
    pub(crate) from_base: Vec<G::Pack>,
    /// Integration matrix from the nodes to the piece's end.
    pub(crate) to_end: Vec<G::Pack>,
    /// Basis at the nodes: entry `[degree * packs + pack]`.
    pub(crate) basis: Vec<G::Pack>,
    /// Basis times quadrature weights.
    pub(crate) weighted_basis: Vec<G::Pack>,
    pub(crate) turning: G::Constants,
    pub(crate) components: Vec<Component>,
    /// The part of the segment; `None` without nodes.
    pub(crate) source: Option<Piece>,
    /// Linear part of the reference strain at the nodes.
    pub(crate) reference_slope: Vec<G::Vector<G::Pack>>,
    /// Data for the stretch, if it has modes.
    pub(crate) stretch: Option<Stretch>,
    /// Whether stretch or shear can differ from those of a straight rod.
    pub(crate) is_extensible: bool,
    /// Stiffness between coupled components.
    pub(crate) couplings: Vec<Coupling>,
    /// Mass per length at the nodes.
    pub(crate) mass: Vec<G::Pack>,
    pub(crate) moments: Moments<G>,
    pub(crate) retardation_time: f64,
    /// Distributed and concentrated effects on the piece.
    pub(crate) spread: Vec<Spread<G>>,
    pub(crate) points: Points,
    /// The fluid around the piece, if its forces depend on the motion.
    pub(crate) immersed: Option<Immersed<G>>,
}

impl<G: Space> PiecePlan<G> {
    /// The moments of its sections in general form.
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

    /// Couples all uncoupled components with zero stiffness.
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

    /// The part of a segment of which a piece with nodes consists.
    pub(crate) fn part(&self) -> &Piece {
        self.source.as_ref().expect("what has nodes is a part of a segment")
    }

    /// Indices of its coordinates.
    pub(crate) fn coordinates(&self) -> std::ops::Range<usize> {
        self.first..self.first + self.n
    }

    /// Indices of this piece's packs among those of the rod.
    pub(crate) fn node_packs(&self) -> std::ops::Range<usize> {
        self.first_pack..self.first_pack + self.packs
    }

    /// Row of an integration matrix (`from_base` or `to_end`) for pack `pack`.
    pub(crate) fn row<'a>(&self, matrix: &'a [G::Pack], pack: usize) -> &'a [G::Pack] {
        let nodes = self.packs * LANES;
        &matrix[pack * nodes..(pack + 1) * nodes]
    }

    /// Rows of an integration matrix.
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

    /// `sum_k phi_k q_k` of every strain at a pack of nodes; zero for components without modes.
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
