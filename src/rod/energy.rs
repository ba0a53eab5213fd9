//! Energies of a state, and the power that damping takes out of it.

use super::inertia;
use super::plan::Plan;
use super::turning::Turning;
use super::workspace::Workspace;
use crate::lie::{Lanes, Scalar, VectorSpace};
use crate::model::Energy;

/// Energies with the motion of (q, qd) up to date.
pub(super) fn energy<G: Turning>(plan: &Plan<G>, work: &Workspace<G>, q: &[f64]) -> Energy {
    let mut energy = Energy { elastic: 0.5 * quadratic_form(plan, q, |_| 1.0), ..Energy::default() };
    let mut twice_kinetic = G::Pack::splat(0.0);
    for segment in &plan.segments {
        for pack in 0..segment.packs {
            let node = segment.first_pack + pack;
            let weight = segment.weights[pack];
            twice_kinetic += work.velocity[node].dot(work.momentum[node]) * weight;
            let mass = (segment.mass[pack] * weight).sum();
            let moment =
                G::map_vector(&(work.position[node] * (segment.mass[pack] * weight)), |pack: &G::Pack| {
                    pack.sum()
                });
            energy.gravitational += mass * plan.gravity_potential - plan.gravity.dot(moment);
        }
    }
    let tip = &work.stations[plan.segments.len()];
    let mut kinetic = 0.5 * twice_kinetic.sum();
    if plan.has_tip_mass {
        kinetic += 0.5 * tip.velocity.dot(inertia::of_tip(plan, work).momentum(tip.velocity));
        energy.gravitational += plan.tip_mass * (plan.gravity_potential - plan.gravity.dot(tip.position));
    }
    Energy { kinetic, loads: plan.load_potential - plan.tip_force.dot(tip.position), ..energy }
}

/// Power of Kelvin-Voigt damping, `qd D qd`.
pub(super) fn dissipated_power<G: Turning>(plan: &Plan<G>, qd: &[f64]) -> f64 {
    quadratic_form(plan, qd, |retardation_time| retardation_time)
}

/// Power of the tip moment, which has no potential, with the motion of (q, qd) up to date.
pub(super) fn supplied_power<G: Turning>(plan: &Plan<G>, work: &Workspace<G>) -> f64 {
    plan.tip_moment.dot(work.stations[plan.segments.len()].velocity.angular)
}

/// `sum_segments factor(mu) x K x`.
fn quadratic_form<G: Turning>(plan: &Plan<G>, x: &[f64], factor: impl Fn(f64) -> f64) -> f64 {
    let mut total = 0.0;
    for segment in &plan.segments {
        let factor = factor(segment.retardation_time);
        for component in &segment.components {
            let x = &x[component.first..component.first + component.modes];
            for j in 0..component.modes {
                for k in 0..component.modes {
                    total += factor * x[j] * component.stiffness[(j, k)] * x[k];
                }
            }
        }
    }
    total
}
