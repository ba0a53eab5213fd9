//! Strain and internal wrench of sections.
//!
//! These pass by two laws, which a finite number of modes makes true in different senses. The balance of all that lies
//! beyond the section, `F(X) = F_tip + int_X^L f`, holds at every place. The law of the material,
//! `-(H (xi - xi_0) + mu H xi')`, holds against the modes alone, `int phi_j . (F - F_material) = 0`: it is the projection
//! of the balance on the strains that have modes, and comes to it at every place as these become many. Active strains are
//! part of xi_0. What embedded tendons and chambers pass on is in the balance, but not in the material.

use crate::lie::{LANES, Lanes, Wrench};
use crate::robot::effect::all as effects;
use crate::robot::plan::Plan;
use crate::robot::plan::piece::PiecePlan;
use crate::robot::plan::point::Place;
use crate::robot::plan::space::Space;
use crate::robot::state::Workspace;
use crate::robot::turning::Turning;
use crate::robot::turning::place::rotation_at;
use crate::rod::STRAINS;

use super::{kinematics, points};

/// The strain at a place of a rod, in the order of [`STRAIN_NAMES`](crate::rod::STRAIN_NAMES).
pub(crate) fn strain<G: Space>(plan: &Plan<G>, q: &[f64], place: &Place) -> [f64; STRAINS] {
    let piece = &plan.pieces[place.piece];
    let reference = piece.part().reference(place.x);
    let change = of_modes(piece, q, place.x);
    std::array::from_fn(|i| reference[i] + change[i])
}

/// `sum_k phi_k(x) q_k` of every strain.
fn of_modes<G: Space>(piece: &PiecePlan<G>, q: &[f64], x: f64) -> [f64; STRAINS] {
    let part = piece.part();
    let mut basis = vec![0.0; part.degrees()];
    part.basis.values(x, &mut basis);
    let mut rest = &q[piece.coordinates()];
    part.modes.map(|modes| {
        let (own, others) = rest.split_at(modes);
        rest = others;
        own.iter().zip(&basis).map(|(q, phi)| q * phi).sum()
    })
}

/// What the material between the sections before and beyond a place passes on, by its own law: moment and force in the
/// section's axes, on what lies beyond. Nothing against strains without modes, except that active ones press on them.
pub(crate) fn material_wrench<G: Space>(
    plan: &Plan<G>,
    work: &Workspace<G>,
    q: &[f64],
    qd: &[f64],
    place: &Place,
) -> [f64; STRAINS] {
    let piece = &plan.pieces[place.piece];
    let [mut strain, rate] = [q, qd].map(|values| of_modes(piece, values, place.x));
    for active in plan.actuation.active_strains.iter().filter(|active| active.piece == place.piece) {
        strain[active.strain] -= work.actuation.commands[active.actuator] * active.of_unit(place.x);
    }
    let stiffness = piece.part().section(place.x).stiffness;
    let mu = piece.retardation_time;
    stiffness.map(|row| -(0..STRAINS).map(|i| row[i] * (strain[i] + mu * rate[i])).sum::<f64>())
}

/// What the motion of all that lies beyond a place needs there, what is at the place included: about the section's point
/// and in its axes, with the motion up to date.
pub(crate) fn internal_wrench<G: Turning>(
    plan: &Plan<G>,
    work: &Workspace<G>,
    q: &[f64],
    place: &Place,
) -> Wrench<G, f64> {
    let piece = &plan.pieces[place.piece];
    let mut sum = work.carried[piece.joined.end] + points::at_end(piece, work);
    for (i, &up_to) in place.weights.iter().enumerate() {
        let (pack, lane) = (i / LANES, i % LANES);
        let force = work.force[piece.first_pack + pack].map(|component: &G::Pack| component.lane(lane));
        sum = sum.add_scaled(force, piece.weights[pack].lane(lane) - up_to);
    }
    sum += effects::beyond(plan, piece, work, place);
    for p in piece.points.inside.clone().filter(|&p| plan.points[p].place.x >= place.x) {
        sum += work.points[p].force;
        if let Some(station) = plan.points[p].carries {
            sum += work.carried[station];
        }
    }
    let rotation = rotation_at(piece, work, q, place);
    let Wrench { moment, force } = sum.at(-kinematics::position(plan, work, place));
    Wrench { moment: G::rotate_axial_back(&rotation, moment), force: G::rotate_back(&rotation, force) }
}
