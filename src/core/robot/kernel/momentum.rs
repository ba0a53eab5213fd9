//! Mass, centre of mass and momentum of the robot.

use crate::numerics::lie::{Cross, Lanes, Vector, VectorSpace, Wrench};
use crate::robot::effects::fluid::around_bodies::{force_at, hulls, velocity_at};
use crate::robot::plan::Plan;
use crate::robot::plan::material::Moments;
use crate::robot::state::Workspace;
use crate::robot::turning::Turning;

/// Mass, first moment, and momentum.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Momentum {
    /// Mass, kg.
    pub mass: f64,
    /// Mass times the position of the centre of mass, kg m.
    pub first_moment: Vector<f64>,
    /// Linear momentum, kg m/s.
    pub linear: Vector<f64>,
    /// Angular momentum about the origin of the world, kg m^2/s.
    pub angular: Vector<f64>,
}

/// Momentum in world axes, with the motion up to date; for a planar robot the components in its plane.
pub(crate) fn momentum<G: Turning>(plan: &Plan<G>, work: &Workspace<G>) -> Momentum {
    let (mut mass, mut first, mut sum) = (0.0, G::Vector::<f64>::zero(), Wrench::<G, f64>::zero());
    for piece in &plan.pieces {
        for pack in 0..piece.packs {
            let node = piece.first_pack + pack;
            let weight = piece.weights[pack];
            mass += (piece.mass[pack] * weight).sum();
            let mut moment = work.position[node] * (piece.mass[pack] * weight);
            if let Moments::General(sections) = &piece.moments {
                moment += G::rotate(&work.rotation[node], sections[pack].first_moment) * weight;
            }
            first += G::map_vector(&moment, |pack: &G::Pack| pack.sum());
            sum += (work.momentum[node] * weight).sum();
        }
    }
    for point in &work.points {
        mass += point.inertia.mass;
        first += point.inertia.first_moment;
        sum += point.momentum;
    }
    // The added mass belongs to the fluid.
    for (hull, state) in hulls(plan, work) {
        let position = hull.position(state);
        mass -= hull.added_mass;
        first = first - position * hull.added_mass;
        sum = sum - force_at::<G>(velocity_at::<G>(state.velocity, position) * hull.added_mass, position);
    }
    // The frame's own velocity, which the sweeps omit.
    let velocity = work.surroundings.velocity;
    let angular = sum.moment + first.cross(velocity);
    let linear = sum.force + velocity * mass;
    let base = &work.surroundings.base;
    let [first, linear] = [first, linear].map(|v| base.rotation.apply(G::in_space(plan.frame, v)));
    let angular = base.rotation.apply(G::axial_in_space(plan.frame, angular));
    Momentum {
        mass,
        first_moment: first + base.position * mass,
        linear,
        angular: angular + base.position.cross(linear),
    }
}
