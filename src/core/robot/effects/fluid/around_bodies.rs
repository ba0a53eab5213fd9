//! Buoyancy, drag and added mass of the fluid at rigid bodies.
//!
//! A hull is the same in all directions. Its added mass is then that of a particle at the centre of its volume,
//! which moves with the body: it is part of the body's inertia, and a steady current exerts no moment on it. Its
//! weight, which the inertia includes, is subtracted here. Since there are few bodies, everything is computed one by one.

use crate::model::Energy;
use crate::numerics::lie::{Cross, Twist, VectorSpace, Wrench};
use crate::robot::algebra::response::{Linear, Response};
use crate::robot::effects::fluid::plan::Hull;
use crate::robot::effects::kinds::{
    Dissipation, NoCoordinateForce, NoDeadPointWrench, NotAlongRods, PointResponse, PointWrench,
    StoredEnergy, Supply, VelocityDependence,
};
use crate::robot::plan::Plan;
use crate::robot::plan::point::Point;
use crate::robot::state::Workspace;
use crate::robot::state::point::PointState;
use crate::robot::turning::Turning;

impl<G: Turning> Hull<G> {
    /// Centre of the volume.
    #[inline(always)]
    pub(crate) fn position(&self, state: &PointState<G>) -> G::Vector<f64> {
        state.position + G::rotate(&state.rotation, self.centre)
    }

    /// Speed of the fluid relative to the hull, never zero.
    #[inline(always)]
    fn speed(relative: G::Vector<f64>, crossing: f64) -> f64 {
        (relative.dot(relative) + crossing + f64::MIN_POSITIVE).sqrt()
    }

    /// Minus the drag over the relative velocity.
    #[inline(always)]
    fn factor(&self, relative: G::Vector<f64>, crossing: f64) -> f64 {
        self.viscous + self.quadratic * Self::speed(relative, crossing)
    }

    /// Minus the drag, for the velocity relative to the fluid.
    #[inline(always)]
    fn drag(&self, relative: G::Vector<f64>, crossing: f64) -> G::Vector<f64> {
        relative * self.factor(relative, crossing)
    }

    /// Its change with the relative velocity.
    #[inline(always)]
    fn change_of_drag(
        &self,
        relative: G::Vector<f64>,
        crossing: f64,
        change: G::Vector<f64>,
    ) -> G::Vector<f64> {
        let of_speed = relative.dot(change) / Self::speed(relative, crossing);
        change * self.factor(relative, crossing) + relative * (self.quadratic * of_speed)
    }

    /// Force required against buoyancy and drag.
    #[inline(always)]
    fn force(&self, work: &Workspace<G>, state: &PointState<G>) -> G::Vector<f64> {
        let position = self.position(state);
        let velocity = velocity_at::<G>(state.velocity, position);
        let drag = self.drag(velocity - work.surroundings.current, work.surroundings.crossing);
        drag + work.surroundings.gravity * (self.displaced + self.added_mass)
    }

    fn response(&self, work: &Workspace<G>, state: &PointState<G>) -> Response<G, f64> {
        let (current, crossing) = (work.surroundings.current, work.surroundings.crossing);
        let position = self.position(state);
        let relative = velocity_at::<G>(state.velocity, position) - current;
        let lifted = work.surroundings.gravity * (self.displaced + self.added_mass);
        let at_centre = |force| force_at::<G>(force, position);
        Response {
            stiffness: Linear::of(|displacement: Twist<G, f64>| {
                let turn: G::Axial<f64> = displacement.angular;
                let turned = |v: G::Vector<f64>| turn.cross(v);
                at_centre(self.change_of_drag(relative, crossing, turned(current)) - turned(lifted))
            }),
            damping: Linear::of(|y: Twist<G, f64>| {
                at_centre(self.change_of_drag(relative, crossing, velocity_at::<G>(y, position)))
            }),
            inertia: Linear::zero(),
        }
    }
}

#[inline(always)]
pub(crate) fn velocity_at<G: Turning>(twist: Twist<G, f64>, position: G::Vector<f64>) -> G::Vector<f64> {
    twist.linear + twist.angular.cross(position)
}

#[inline(always)]
pub(crate) fn force_at<G: Turning>(force: G::Vector<f64>, position: G::Vector<f64>) -> Wrench<G, f64> {
    Wrench { moment: VectorSpace::zero(), force }.at(position)
}

/// The hulls of a plan with the states of their points.
pub(crate) fn hulls<'a, G: Turning>(
    plan: &'a Plan<G>,
    work: &'a Workspace<G>,
) -> impl Iterator<Item = (&'a Hull<G>, &'a PointState<G>)> {
    let points = plan.points.iter().zip(&work.points);
    points.flat_map(|(point, state)| point.effects.hulls.iter().map(move |hull| (hull, state)))
}

/// Power that drag dissipates in the motion relative to the fluid, and power that the current supplies.
fn powers<G: Turning>(plan: &Plan<G>, work: &Workspace<G>) -> [f64; 2] {
    let (frame, current) = (work.surroundings.velocity, work.surroundings.current);
    let crossing = work.surroundings.crossing;
    let mut sum = [0.0; 2];
    for (hull, state) in hulls(plan, work) {
        let velocity = velocity_at::<G>(state.velocity, hull.position(state));
        let relative = velocity - current;
        let drag = hull.drag(relative, crossing);
        let supplied = hull.factor(relative, crossing) * crossing - drag.dot(current + frame);
        sum[0] += drag.dot(velocity + frame) + supplied;
        sum[1] += supplied;
    }
    sum
}

/// The fluid around rigid bodies.
pub(crate) struct FluidAroundBodies;

fn has_drag<G: Turning>(plan: &Plan<G>) -> bool {
    let mut hulls = plan.points.iter().flat_map(|point| &point.effects.hulls);
    hulls.any(|hull| hull.viscous > 0.0 || hull.quadratic > 0.0)
}

impl<G: Turning> PointWrench<G> for FluidAroundBodies {
    #[inline(always)]
    fn act_at(_: &Plan<G>, work: &Workspace<G>, point: &Point<G>, state: &mut PointState<G>) {
        for hull in &point.effects.hulls {
            let force = hull.force(work, state);
            state.force += force_at::<G>(force, hull.position(state));
        }
    }
}

impl<G: Turning> PointResponse<G> for FluidAroundBodies {
    #[inline(always)]
    fn responds_at(point: &Point<G>) -> bool {
        !point.effects.hulls.is_empty()
    }

    #[inline(always)]
    fn respond_at(
        _: &Plan<G>,
        work: &Workspace<G>,
        point: &Point<G>,
        state: &PointState<G>,
        sum: &mut Response<G, f64>,
    ) {
        for hull in &point.effects.hulls {
            sum.add(hull.response(work, state));
        }
    }
}

impl<G: Turning> StoredEnergy<G> for FluidAroundBodies {
    /// The potential of the buoyancy. The added mass has no weight.
    fn add_energy(plan: &Plan<G>, work: &Workspace<G>, energy: &mut Energy) {
        let surroundings = &work.surroundings;
        for (hull, state) in hulls(plan, work) {
            let of_unit_mass =
                surroundings.gravity_potential - surroundings.gravity.dot(hull.position(state));
            energy.gravitational -= hull.added_mass * of_unit_mass;
            energy.loads -= hull.displaced * of_unit_mass;
        }
    }
}

impl<G: Turning> Dissipation<G> for FluidAroundBodies {
    fn dissipates(plan: &Plan<G>) -> bool {
        has_drag(plan)
    }

    fn dissipated_power(plan: &Plan<G>, work: &Workspace<G>) -> f64 {
        powers(plan, work)[0]
    }
}

impl<G: Turning> Supply<G> for FluidAroundBodies {
    fn drives(plan: &Plan<G>) -> bool {
        has_drag(plan) && plan.world.has_current()
    }

    fn supplied_power(plan: &Plan<G>, work: &Workspace<G>) -> f64 {
        powers(plan, work)[1]
    }
}

impl<G: Turning> VelocityDependence<G> for FluidAroundBodies {
    fn depends_on_velocity(plan: &Plan<G>) -> bool {
        has_drag(plan)
    }
}

impl NotAlongRods for FluidAroundBodies {}
impl NoDeadPointWrench for FluidAroundBodies {}
impl NoCoordinateForce for FluidAroundBodies {}
