//! How far rods may move from a shape in which nothing is near before anything can be.
//!
//! A shape in which the balls around all curves reach none of the solids at rest leaves a gap. Other shapes are told apart from it by their
//! coordinates alone, without computing positions: a coordinate that changes by `d` turns what it moves by at most `turn d` and shifts it by
//! at most `shift d`. With levers of length l at first, which become longer by twice the displacement, all that turns by at most a and
//! shifts by at most b moves by `(a l + b) exp(2 a)` at most (Gronwall's inequality along the straight path of coordinates).

use crate::numerics::lie::{LANES, Lanes as _, Vector};
use crate::robot::effects::contact::bounds::{LARGEST_RADIUS, stretched};
use crate::robot::effects::contact::plan::{Contacts, Curve, Mobility};
use crate::robot::effects::contact::state::Clearance;
use crate::robot::plan::Plan;
use crate::robot::plan::piece::PiecePlan;
use crate::robot::plan::space::Space;
use crate::robot::state::Workspace;
use crate::robot::turning::Turning;

/// By which factor rotations and displacements within a piece may exceed the integrals of their rates: they are sums over nodes with weights
/// that are not all positive.
const ABOVE_INTEGRALS: f64 = 2.0;

/// Stores the shape whose kinematics are up to date, with its gap.
#[inline(never)]
pub(super) fn store<G: Turning>(clearance: &mut Clearance, plan: &Plan<G>, work: &Workspace<G>, gap: f64) {
    clearance.of.clear();
    clearance.of.extend_from_slice(&work.kinematics_of);
    clearance.gap = gap;
    clearance.lever = 2.0 * extent(plan, work);
}

/// Whether nothing is near in another shape either.
pub(super) fn covers<G: Space>(clearance: &Clearance, contacts: &Contacts<G>, q: &[f64]) -> bool {
    // Coordinates that are no numbers are not near to anything.
    clearance.of.len() == q.len() && !q.is_empty() && displacement(clearance, contacts, q) < clearance.gap
}

/// By how much balls around curves are displaced and grow up to another shape, at most.
fn displacement<G: Space>(clearance: &Clearance, contacts: &Contacts<G>, q: &[f64]) -> f64 {
    let [mut turn, mut shift] = [0.0; 2];
    for &Mobility { coordinate, turn: turns, shift: shifts } in &contacts.mobilities {
        let change = (q[coordinate] - clearance.of[coordinate]).abs();
        turn += turns * change;
        shift += shifts * change;
    }
    (turn * clearance.lever + shift) * (2.0 * turn).exp()
}

/// Radius of a ball around the first station that contains all pieces.
fn extent<G: Turning>(plan: &Plan<G>, work: &Workspace<G>) -> f64 {
    let place = |station: usize| G::in_space(plan.frame, work.stations[station].position);
    let middle = place(0);
    let extents = plan.pieces.iter().map(|piece| {
        let within = if piece.hinge.is_some() || piece.packs == 0 {
            0.0
        } else {
            stretched(piece, work, piece.gauss.nodes.len()) * piece.length
        };
        let ends = [piece.joined.begin, piece.joined.end].map(|station| place(station) - middle);
        ends.map(|way| way.dot(way).sqrt()).into_iter().fold(0.0, f64::max) + within
    });
    extents.fold(0.0, f64::max)
}

/// What the coordinates do that move these curves.
pub(super) fn mobilities<G: Space>(plan: &Plan<G>, curves: &[Curve<G::Pack>]) -> Vec<Mobility> {
    let mut pieces: Vec<usize> =
        curves.iter().flat_map(|curve| curve.moved_by.iter().map(|(piece, _)| *piece)).collect();
    pieces.sort_unstable();
    pieces.dedup();
    pieces.into_iter().flat_map(|p| of_piece(plan, &plan.pieces[p])).collect()
}

fn of_piece<G: Space>(plan: &Plan<G>, piece: &PiecePlan<G>) -> Vec<Mobility> {
    if let Some(hinge) = &piece.hinge {
        let size = |v: Vector<f64>| v.dot(v).sqrt();
        let turn = size(G::axial_in_space(plan.frame, hinge.twist.angular));
        let shift = size(G::in_space(plan.frame, hinge.twist.linear));
        return vec![Mobility { coordinate: piece.first, turn, shift }];
    }
    let mut found = Vec::new();
    for component in &piece.components {
        for (degree, basis) in piece.basis.chunks_exact(piece.packs).take(component.modes).enumerate() {
            let lanes = |pack: G::Pack| (0..LANES).map(move |lane| pack.lane(lane).abs());
            let sizes = piece.weights.iter().zip(basis).map(|(&weight, &basis)| weight * basis);
            let whole = ABOVE_INTEGRALS * sizes.flat_map(lanes).sum::<f64>();
            let largest = basis.iter().copied().flat_map(lanes).fold(0.0, f64::max);
            let is_angular = component.index < G::ANGULAR;
            found.push(Mobility {
                coordinate: component.first + degree,
                turn: if is_angular { whole } else { 0.0 },
                // A stretched curve has a larger ball, too.
                shift: if is_angular { 0.0 } else { whole + LARGEST_RADIUS * largest * piece.length },
            });
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::description::body::Body;
    use crate::description::joint::{Joint, JointForces};
    use crate::description::rod::Segment;
    use crate::numerics::lie::Spatial;
    use crate::robot::compile;
    use crate::robot::description::{Link, Robot};
    use crate::robot::effects::contact::bounds::ball_around_ends;
    use crate::robot::effects::contact::{Contact, HalfSpace, Surface};
    use crate::robot::kernel::kinematics;
    use proptest::prelude::*;

    /// Two rods on joints of all kinds, and a body that carries the second.
    fn robot() -> Robot {
        let rod =
            |length| Segment { modes: [2, 3, 2, 1, 2, 1], ..Segment::straight(length, 0.02, 1e6, 4e5, 1e3) };
        let forces = JointForces::default;
        let hinge = Joint::Revolute { axis: [1.0, 2.0, 3.0], forces: forces() };
        let links = vec![
            Link { rod: vec![rod(0.5), rod(0.3)], joint: Joint::Free, ..Link::new("arm") },
            Link {
                body: Some(Body::point(0.3)),
                parent: Some(0),
                at: Some(0.2),
                joint: hinge,
                position: [0.0, 0.1, 0.0],
                ..Link::new("block")
            },
            Link { rod: vec![rod(0.4)], parent: Some(1), joint: Joint::Spherical, ..Link::new("leg") },
            Link {
                rod: vec![rod(0.2)],
                parent: Some(2),
                joint: Joint::Prismatic { axis: [0.0, 0.0, 1.0], forces: forces() },
                ..Link::new("foot")
            },
        ];
        let floor = HalfSpace { point: [0.0, 0.0, -9.0], normal: [0.0, 0.0, 1.0] };
        let contacts = [0, 2, 3].map(|link| {
            Contact::between("contact", [Surface::Rod { link }, Surface::Obstacle(floor.clone().into())])
        });
        Robot { contacts: contacts.into(), ..Robot::new(links) }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(200))]
        /// No ball around a curve comes nearer to anything by more than the bound.
        #[test]
        fn bounds_hold(
            (start, change) in (prop::collection::vec(-0.5..0.5, 60), prop::collection::vec(-0.5..0.5, 60)),
            size in 0_i32..5,
        ) {
            let plan = compile::plan::<Spatial<true>>(&robot(), ());
            prop_assert!(plan.n > 40 && plan.n <= 60);
            let mut work = Workspace::new(&plan);
            let mut balls = |q: &[f64]| {
                kinematics::run(&plan, &mut work, q);
                let mut clearance = Clearance::default();
                store(&mut clearance, &plan, &work, f64::INFINITY);
                let curves = &plan.effects.contacts.curves;
                let balls: Vec<_> =
                    curves.iter().map(|curve| ball_around_ends(&plan, &work, curve)).collect();
                (clearance, balls)
            };
            let q = &start[..plan.n];
            let (clearance, before) = balls(q);
            let q: Vec<f64> = q.iter().zip(&change).map(|(q, d)| q + d * 10.0_f64.powi(-size)).collect();
            let (_, after) = balls(&q);
            let most = displacement(&clearance, &plan.effects.contacts, &q);
            for ((centre, radius), (there, of_other)) in before.into_iter().zip(after) {
                let way = there - centre;
                prop_assert!(way.dot(way).sqrt() + of_other - radius <= most, "{most}");
            }
        }
    }
}
