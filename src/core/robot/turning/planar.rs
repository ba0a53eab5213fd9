//! Rotations in the plane: sums of angles.

use super::{Turning, angular_degrees, integrals_between};
use crate::description::rod::Gauss;
use crate::description::rod::piece::Piece;
use crate::numerics::lie::{Planar, PlaneRotation, Scalar};
use crate::robot::plan::material::Component;
use crate::robot::plan::packed;
use crate::robot::plan::piece::PiecePlan;
use crate::robot::plan::space::{Angles, Passage};

/// The bending component, if the piece has one.
fn bend<const FUSED: bool>(piece: &PiecePlan<Planar<FUSED>>) -> Option<&Component> {
    piece.components.iter().find(|component| component.index == 0)
}

impl<const FUSED: bool> Turning for Planar<FUSED> {
    fn constants(
        piece: &Piece,
        frame: Self::Frame,
        gauss: &Gauss,
        components: &[Component],
    ) -> Angles<Self::Pack> {
        let degrees = angular_degrees::<Self>(components);
        let nodes = gauss.nodes.len();
        let length = piece.length();
        let up_to: Vec<Vec<f64>> =
            gauss.nodes.iter().map(|&x| integrals_between(piece, 0.0, x, degrees)).collect();
        let reference = |x: f64| piece.reference_between(0.0, x)[frame.normal];
        let mut means = integrals_between(piece, 0.0, 1.0, degrees);
        while means.last() == Some(&0.0) {
            means.pop();
        }
        Angles {
            reference: match piece.segment.reference_strain.constant() {
                Some(strain) => packed(nodes, |i| strain[frame.normal] * length * gauss.nodes[i]),
                None => packed(nodes, |i| length * reference(gauss.nodes[i])),
            },
            at_nodes: (0..degrees).flat_map(|k| packed(nodes, |i| length * up_to[i][k])).collect(),
            mean_reference: reference(1.0),
            means,
            normal: frame.normal,
        }
    }

    #[inline(always)]
    fn turn(
        piece: &PiecePlan<Self>,
        q: &[f64],
        orientation: f64,
        rotations: &mut [PlaneRotation<Self::Pack>],
    ) -> f64 {
        let Angles { reference, at_nodes, mean_reference, means, .. } = &piece.turning;
        let q = bend(piece).map_or(&[][..], |bend| &q[bend.first..][..bend.modes]);
        for (pack, rotation) in rotations.iter_mut().enumerate() {
            let mut angle = reference[pack] + Self::Pack::splat(orientation);
            for (k, &q) in q.iter().enumerate() {
                angle = at_nodes[k * piece.packs + pack].mul_add(Self::Pack::splat(q), angle);
            }
            *rotation = PlaneRotation::by(angle);
        }
        let mut mean = *mean_reference;
        for (mean_of_basis, q) in means.iter().zip(q) {
            mean += mean_of_basis * q;
        }
        orientation + piece.length * mean
    }

    fn passage(piece: &PiecePlan<Self>, from: f64, to: f64) -> Passage {
        let modes = bend(piece).map_or(0, |bend| bend.modes);
        let source = piece.part();
        let integrals = integrals_between(source, from, to, modes);
        let (normal, step) = (piece.turning.normal, (to - from) * piece.length);
        let reference = match source.segment.reference_strain.constant() {
            Some(strain) => strain[normal] * step,
            None => piece.length * source.reference_between(from, to)[normal],
        };
        Passage {
            step,
            basis: integrals.into_iter().map(|integral| piece.length * integral).collect(),
            reference: vec![reference],
        }
    }

    #[inline(always)]
    fn pass(piece: &PiecePlan<Self>, q: &[f64], passage: &Passage) -> PlaneRotation<f64> {
        let mut angle = passage.reference[0];
        if let Some(bend) = bend(piece) {
            for (q, integral) in q[bend.first..][..bend.modes].iter().zip(&passage.basis) {
                angle += q * integral;
            }
        }
        PlaneRotation::by(angle)
    }
}
