//! Loads: forces and moments at points, or distributed along a part of the rod.

use crate::model::Energy;
use crate::numerics::lie::{LANES, Lanes, Twist, VectorSpace, Wrench};
use crate::robot::algebra::inertia::Gyroscope;
use crate::robot::effects::kinds::{
    DeadLineWrench, DeadPointWrench, LineWrench, NoCoordinateForce, NoDissipation, NoLineResponse,
    NoPointResponse, NoVelocityDependence, PartialWrench, PointWrench, StoredEnergy, Supply,
};
use crate::robot::effects::load::Frame;
use crate::robot::effects::load::plan::{LoadPlan, Spread};
use crate::robot::plan::Plan;
use crate::robot::plan::piece::PiecePlan;
use crate::robot::plan::point::{Place, Point};
use crate::robot::state::Workspace;
use crate::robot::state::point::PointState;
use crate::robot::turning::Turning;

/// The loads of a plan.
pub(crate) struct Loads;

impl<G: Turning> LoadPlan<G> {
    /// Whether the load keeps its direction in the world.
    #[inline(always)]
    fn is_dead(&self) -> bool {
        self.frame == Frame::World
    }
}

/// Wrench of a load at a point, about the point.
#[inline(always)]
fn at_point<G: Turning>(
    load: usize,
    plan: &Plan<G>,
    work: &Workspace<G>,
    state: &PointState<G>,
) -> Wrench<G, f64> {
    let wrench = work.effects.acting[load];
    if plan.effects.loads[load].is_dead() { wrench } else { wrench.rotated(&state.rotation) }
}

impl<G: Turning> Spread<G> {
    #[inline(always)]
    fn is_dead(&self, plan: &Plan<G>) -> bool {
        plan.effects.loads[self.load].is_dead()
    }

    /// Wrench per length at a pack of nodes, about these nodes.
    #[inline(always)]
    fn wrench(
        &self,
        plan: &Plan<G>,
        work: &Workspace<G>,
        pack: usize,
        rotation: &G::Rotation<G::Pack>,
    ) -> Wrench<G, G::Pack> {
        let wrench = work.effects.acting[self.load].splat() * self.density[pack];
        if self.is_dead(plan) { wrench } else { wrench.rotated(rotation) }
    }

    /// The same at density one.
    fn acting(
        &self,
        plan: &Plan<G>,
        work: &Workspace<G>,
        rotation: &G::Rotation<G::Pack>,
    ) -> Wrench<G, G::Pack> {
        let wrench = work.effects.acting[self.load].splat();
        if self.is_dead(plan) { wrench } else { wrench.rotated(rotation) }
    }
}

/// Products of constant dead forces with the positions at which they act.
fn work_of_dead_forces<G: Turning>(plan: &Plan<G>, work: &Workspace<G>) -> f64 {
    let mut sum = 0.0;
    for (point, state) in plan.points.iter().zip(&work.points) {
        for &load in point.effects.loads.iter().filter(|&&load| plan.effects.loads[load].has_potential) {
            sum += work.effects.acting[load].force.dot(state.position);
        }
    }
    for piece in &plan.pieces {
        for spread in piece.spread.iter().filter(|spread| plan.effects.loads[spread.load].has_potential) {
            for pack in 0..piece.packs {
                let node = piece.first_pack + pack;
                let force = spread.wrench(plan, work, pack, &work.rotation[node]).force;
                sum += (force.dot(work.position[node]) * piece.weights[pack]).sum();
            }
        }
    }
    sum
}

impl<G: Turning> PointWrench<G> for Loads {
    #[inline(always)]
    fn act_at(plan: &Plan<G>, work: &Workspace<G>, point: &Point<G>, state: &mut PointState<G>) {
        for &load in &point.effects.loads {
            state.force = state.force - at_point(load, plan, work, state).at(state.position);
        }
    }
}

impl<G: Turning> DeadPointWrench<G> for Loads {
    #[inline(always)]
    fn dead_at(
        plan: &Plan<G>,
        work: &Workspace<G>,
        point: &Point<G>,
        state: &PointState<G>,
        sum: &mut Gyroscope<G, f64>,
    ) {
        for &load in point.effects.loads.iter().filter(|&&load| plan.effects.loads[load].is_dead()) {
            sum.add(Gyroscope::of_dead_load(work.effects.acting[load], state.position));
        }
    }
}

impl<G: Turning> LineWrench<G> for Loads {
    #[inline(always)]
    fn acts_along(_: &Plan<G>, piece: &PiecePlan<G>) -> bool {
        !piece.spread.is_empty()
    }

    #[inline(always)]
    fn act_along(plan: &Plan<G>, piece: &PiecePlan<G>, work: &mut Workspace<G>) {
        for spread in &piece.spread {
            for pack in 0..piece.packs {
                let node = piece.first_pack + pack;
                let wrench = spread.wrench(plan, work, pack, &work.rotation[node]);
                work.force[node] = work.force[node] - wrench.at(work.position[node]);
            }
        }
    }
}

impl<G: Turning> PartialWrench<G> for Loads {
    fn beyond(plan: &Plan<G>, piece: &PiecePlan<G>, work: &Workspace<G>, place: &Place) -> Wrench<G, f64> {
        let mut sum = Wrench::zero();
        for spread in &piece.spread {
            let Some(part) = spread.part else { continue };
            // The load itself is smooth, so that its integral between two places is accurate.
            let [from, to] = part.map(|x| piece.gauss.weights_up_to(x.max(place.x)));
            for pack in 0..piece.packs {
                let node = piece.first_pack + pack;
                let wrench = spread.acting(plan, work, &work.rotation[node]).at(work.position[node]);
                for lane in 0..LANES {
                    let i = pack * LANES + lane;
                    let density = spread.density[pack].lane(lane);
                    let seen = density * (piece.weights[pack].lane(lane) - place.weights[i]);
                    let missing = (to[i] - from[i]) * piece.length - seen;
                    sum = sum.add_scaled(wrench.map(|component: &G::Pack| component.lane(lane)), -missing);
                }
            }
        }
        sum
    }
}

impl<G: Turning> DeadLineWrench<G> for Loads {
    #[inline(always)]
    fn is_dead_along(plan: &Plan<G>, piece: &PiecePlan<G>) -> bool {
        piece.spread.iter().any(|spread| spread.is_dead(plan))
    }

    #[inline(always)]
    fn dead_along(
        plan: &Plan<G>,
        piece: &PiecePlan<G>,
        work: &Workspace<G>,
        sums: &mut [Gyroscope<G, G::Pack>],
    ) {
        for spread in piece.spread.iter().filter(|spread| spread.is_dead(plan)) {
            for (pack, sum) in sums.iter_mut().enumerate() {
                let node = piece.first_pack + pack;
                let load = spread.wrench(plan, work, pack, &work.rotation[node]) * piece.weights[pack];
                sum.add(Gyroscope::of_dead_load(load, work.position[node]));
            }
        }
    }
}

impl<G: Turning> StoredEnergy<G> for Loads {
    fn add_energy(plan: &Plan<G>, work: &Workspace<G>, energy: &mut Energy) {
        energy.loads += work.surroundings.load_potential - work_of_dead_forces(plan, work);
    }
}

impl<G: Turning> Supply<G> for Loads {
    fn drives(plan: &Plan<G>) -> bool {
        plan.effects.loads.iter().any(|load| !load.has_potential || load.has_moment)
    }

    fn supplied_power(plan: &Plan<G>, work: &Workspace<G>) -> f64 {
        let frame = Twist { angular: VectorSpace::zero(), linear: work.surroundings.velocity };
        let mut power = 0.0;
        for (point, state) in plan.points.iter().zip(&work.points) {
            for &load in &point.effects.loads {
                let mut wrench = at_point(load, plan, work, state);
                if plan.effects.loads[load].has_potential {
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
                    if plan.effects.loads[spread.load].has_potential {
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
}

impl NoPointResponse for Loads {}
impl NoLineResponse for Loads {}
impl NoCoordinateForce for Loads {}
impl NoDissipation for Loads {}
impl NoVelocityDependence for Loads {}
