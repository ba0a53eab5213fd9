//! Energies of a state, and the power that damping takes out of it.

use crate::lie::{Lanes, Scalar, Twist, VectorSpace};
use crate::model::Energy;
use crate::robot::effect::immersion;
use crate::robot::plan::Plan;
use crate::robot::plan::anchor::Anchor;
use crate::robot::plan::material::Moments;
use crate::robot::state::Workspace;
use crate::robot::state::point::PointState;
use crate::robot::turning::Turning;

/// Energies with the motion of (q, qd) up to date.
pub(crate) fn energy<G: Turning>(plan: &Plan<G>, work: &Workspace<G>, q: &[f64]) -> Energy {
    let surroundings = &work.surroundings;
    let mut energy = Energy { elastic: 0.5 * quadratic_form(plan, q, |_| 1.0), ..Energy::default() };
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
    for (anchor, state) in held(plan, work) {
        energy.elastic += anchor.energy(plan.frame, state);
    }
    energy.loads = surroundings.load_potential - dead_forces(plan, work);
    let fluid = immersion::exchange(plan, work);
    energy.kinetic += fluid.kinetic;
    energy.loads += fluid.potential;
    energy
}

/// The supports, with what is known of the sections that they hold.
fn held<'a, G: Turning>(
    plan: &'a Plan<G>,
    work: &'a Workspace<G>,
) -> impl Iterator<Item = (&'a Anchor, &'a PointState<G>)> {
    let points = plan.points.iter().zip(&work.points);
    points.flat_map(move |(point, state)| {
        point.anchors.iter().map(move |&anchor| (&work.anchors[anchor], state))
    })
}

/// What the velocity of the frame adds to the kinetic energy in it: `v . p + m v^2 / 2` with the momentum p in the frame.
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

/// Constant dead forces times the positions where they act.
fn dead_forces<G: Turning>(plan: &Plan<G>, work: &Workspace<G>) -> f64 {
    let mut sum = 0.0;
    for (point, state) in plan.points.iter().zip(&work.points) {
        for &load in point.loads.iter().filter(|&&load| plan.loads[load].has_potential) {
            sum += work.acting[load].force.dot(state.position);
        }
    }
    for piece in &plan.pieces {
        for spread in piece.spread.iter().filter(|spread| plan.loads[spread.load].has_potential) {
            for pack in 0..piece.packs {
                let node = piece.first_pack + pack;
                let force = spread.wrench(plan, work, pack, &work.rotation[node]).force;
                sum += (force.dot(work.position[node]) * piece.weights[pack]).sum();
            }
        }
    }
    sum
}

/// Power of the loads that have no potential, and of the base if it moves, with the motion of (q, qd, qdd) up to date.
pub(crate) fn supplied_power<G: Turning>(plan: &Plan<G>, work: &Workspace<G>) -> f64 {
    let frame = Twist { angular: VectorSpace::zero(), linear: work.surroundings.velocity };
    let mut power = immersion::exchange(plan, work).supplied;
    if plan.world.motion.is_some() {
        power += (work.stations[0].velocity + frame).dot(work.base_wrench);
    }
    for (point, state) in plan.points.iter().zip(&work.points) {
        for &load in &point.loads {
            let mut wrench = point.wrench(load, plan, work, state);
            if plan.loads[load].has_potential {
                wrench.force = VectorSpace::zero();
            }
            power += (state.velocity + frame).dot(wrench.at(state.position));
        }
    }
    for piece in &plan.pieces {
        for spread in &piece.spread {
            for pack in 0..piece.packs {
                let node = piece.first_pack + pack;
                let mut wrench = spread.wrench(plan, work, pack, &work.rotation[node]);
                if plan.loads[spread.load].has_potential {
                    wrench.force = VectorSpace::zero();
                }
                let velocity = work.velocity[node] + frame.splat();
                let power_of_nodes = velocity.dot(wrench.at(work.position[node]));
                power += (power_of_nodes * piece.weights[pack]).sum();
            }
        }
    }
    power
}

/// Power of Kelvin-Voigt damping, `qd D qd`.
pub(crate) fn power_of_damping<G: Turning>(plan: &Plan<G>, qd: &[f64]) -> f64 {
    quadratic_form(plan, qd, |retardation_time| retardation_time)
}

/// Power that anything but the rod's own material takes out of its motion, with that of (q, qd) up to date.
pub(crate) fn power_of_resistance<G: Turning>(plan: &Plan<G>, work: &Workspace<G>) -> f64 {
    let dampers: f64 =
        held(plan, work).map(|(anchor, state)| anchor.dissipated_power(plan.frame, state)).sum();
    dampers + immersion::exchange(plan, work).dissipated
}

/// `sum_segments factor(mu) x K x`.
fn quadratic_form<G: Turning>(plan: &Plan<G>, x: &[f64], factor: impl Fn(f64) -> f64) -> f64 {
    let mut total = 0.0;
    for piece in &plan.pieces {
        let factor = factor(piece.retardation_time);
        for component in &piece.components {
            let x = &x[component.first..component.first + component.modes];
            for j in 0..component.modes {
                for k in 0..component.modes {
                    total += factor * x[j] * component.stiffness[(j, k)] * x[k];
                }
            }
        }
        for coupling in &piece.couplings {
            let [rows, columns] = coupling.coordinates();
            for (j, row) in rows.enumerate() {
                for (k, column) in columns.clone().enumerate() {
                    total += 2.0 * factor * x[row] * coupling.stiffness[(j, k)] * x[column];
                }
            }
        }
    }
    total
}
