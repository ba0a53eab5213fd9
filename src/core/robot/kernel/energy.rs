//! Energies of a state, and the supplied power.

use super::elasticity;
use crate::model::Energy;
use crate::numerics::lie::{Lanes, Scalar, Twist, VectorSpace};
use crate::robot::effects;
use crate::robot::plan::Plan;
use crate::robot::plan::material::Moments;
use crate::robot::state::Workspace;
use crate::robot::turning::Turning;

/// Energies, with the motion of (q, qd) up to date.
pub(crate) fn energy<G: Turning>(plan: &Plan<G>, work: &Workspace<G>, q: &[f64]) -> Energy {
    let surroundings = &work.surroundings;
    let mut energy = Energy { elastic: elasticity::energy(plan, q), ..Energy::default() };
    let mut twice_kinetic = G::Pack::splat(0.0);
    for piece in &plan.pieces {
        for pack in 0..piece.packs {
            let node = piece.first_pack + pack;
            let weight = piece.weights[pack];
            twice_kinetic += work.velocity[node].dot(work.momentum[node]) * weight;
            let mass = (piece.mass[pack] * weight).sum();
            let mut moment = work.position[node] * (piece.mass[pack] * weight);
            if let Moments::General(sections) = &piece.moments {
                moment += G::rotate(&work.rotation[node], sections[pack].first_moment) * weight;
            }
            let moment = G::map_vector(&moment, |pack: &G::Pack| pack.sum());
            energy.gravitational += mass * surroundings.gravity_potential - surroundings.gravity.dot(moment);
        }
    }
    energy.kinetic = 0.5 * twice_kinetic.sum();
    energy.gravitational += surroundings.body_potential;
    for point in &work.points {
        energy.kinetic += 0.5 * point.velocity.dot(point.momentum);
        energy.gravitational += point.inertia.mass * surroundings.gravity_potential
            - surroundings.gravity.dot(point.inertia.first_moment);
    }
    if plan.world.motion.is_some() {
        energy.kinetic += kinetic_energy_of_frame(plan, work);
    }
    effects::add_energy(plan, work, &mut energy);
    energy
}

/// Contribution of the frame's velocity to the kinetic energy: `v . p + m v^2 / 2` with the momentum p
/// relative to the frame.
fn kinetic_energy_of_frame<G: Turning>(plan: &Plan<G>, work: &Workspace<G>) -> f64 {
    let (mut mass, mut momentum) = (0.0, G::Vector::<f64>::zero());
    for piece in &plan.pieces {
        for pack in 0..piece.packs {
            let node = piece.first_pack + pack;
            let weight = piece.weights[pack];
            mass += (piece.mass[pack] * weight).sum();
            momentum += G::map_vector(&(work.momentum[node].force * weight), |pack: &G::Pack| pack.sum());
        }
    }
    for point in &work.points {
        mass += point.inertia.mass;
        momentum += point.momentum.force;
    }
    let velocity = work.surroundings.velocity;
    velocity.dot(momentum) + 0.5 * mass * velocity.dot(velocity)
}

/// Power of all forces without a potential, and of a moving base, with the motion of (q, qd, qdd) up to date.
pub(crate) fn supplied_power<G: Turning>(plan: &Plan<G>, work: &Workspace<G>) -> f64 {
    let mut power = effects::supplied_power(plan, work);
    if plan.world.motion.is_some() {
        let frame = Twist { angular: VectorSpace::zero(), linear: work.surroundings.velocity };
        power += (work.stations[0].velocity + frame).dot(work.carried[0]);
    }
    power
}
