//! Strain and internal wrench of sections.
//!
//! Two laws determine the internal wrench, and with a finite number of modes they hold in different senses.
//! The balance of everything beyond the section, `F(X) = F_tip + int_X^L f`, holds at every place. The law of
//! the material, `-(H (xi - xi_0) + mu H xi')`, holds only weighted with the modes, `int phi_j . (F -
//! F_material) = 0`: it is the projection of the balance onto the strains that have modes, and converges to
//! the balance at every place as the number of modes increases. Active strains are part of xi_0. The forces
//! of embedded tendons and chambers are part of the balance, but not of the material.

use crate::description::rod::STRAINS;
use crate::numerics::lie::{LANES, Lanes, Wrench};
use crate::robot::effects;
use crate::robot::plan::Plan;
use crate::robot::plan::piece::PiecePlan;
use crate::robot::plan::point::Place;
use crate::robot::plan::space::Space;
use crate::robot::state::Workspace;
use crate::robot::turning::Turning;
use crate::robot::turning::place::rotation_at;

use super::{kinematics, points};

/// Strain at a place of a rod, in the order of [`STRAIN_NAMES`](crate::description::rod::STRAIN_NAMES).
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

/// Moment and force that the material transmits at a place by its own law, in section axes, on what lies
/// beyond. Zero for strains without modes, except for the effect of active strains.
pub(crate) fn material_wrench<G: Space>(
    plan: &Plan<G>,
    work: &Workspace<G>,
    q: &[f64],
    qd: &[f64],
    place: &Place,
) -> [f64; STRAINS] {
    let piece = &plan.pieces[place.piece];
    let [mut strain, rate] = [q, qd].map(|values| of_modes(piece, values, place.x));
    for active in plan.effects.actuation.active_strains.iter().filter(|active| active.piece == place.piece) {
        strain[active.strain] -= work.effects.actuation.commands[active.actuator] * active.of_unit(place.x);
    }
    let stiffness = piece.part().section(place.x).stiffness;
    let mu = piece.retardation_time;
    stiffness.map(|row| -(0..STRAINS).map(|i| row[i] * (strain[i] + mu * rate[i])).sum::<f64>())
}

/// Wrench required at a place by the motion of everything beyond it, including bodies and loads at the place:
/// about the section's point and in its axes, with the motion up to date.
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
