//! Supports: springs and dampers to the world. Since there are few, everything is computed in three
//! dimensions and projected to a plane if necessary.

use crate::model::Energy;
use crate::numerics::lie::{Cross, Rotation, Symmetric, Twist, Vector, Wrench};
use crate::robot::algebra::response::{Linear, Response};
use crate::robot::effects::kinds::{
    Dissipation, NoCoordinateForce, NoDeadPointWrench, NoSupply, NoVelocityDependence, NotAlongRods,
    PointResponse, PointWrench, StoredEnergy,
};
use crate::robot::effects::support::plan::Anchor;
use crate::robot::plan::Plan;
use crate::robot::plan::point::Point;
use crate::robot::state::Workspace;
use crate::robot::state::point::PointState;
use crate::robot::turning::Turning;

/// Moment, force and stiffness of an anchor's springs.
pub(crate) struct Held {
    pub(crate) forces: [Vector<f64>; 2],
    pub(crate) stiffness: [Symmetric<f64>; 2],
    pub(crate) energy: f64,
    /// Principal stiffnesses below these values, smallest first, are treated as soft: at large rotations,
    /// rotational springs soften and finally repel.
    pub(crate) firm: [[f64; 3]; 2],
}

/// A rotational spring counts as firm if its stiffness exceeds this fraction of its stiffness at rest.
const FIRM_STIFFNESS: f64 = 0.1;

/// Stiffnesses below this fraction of the largest one are rounding errors.
const ROUNDING: f64 = 1e-12;

/// The section at a support, in three dimensions.
#[derive(Clone, Copy, Debug)]
struct HeldSection {
    offset: Vector<f64>,
    axes: [Vector<f64>; 3],
    angular: Vector<f64>,
    velocity: Vector<f64>,
}

impl Anchor {
    fn section<G: Turning>(&self, frame: G::Frame, state: &PointState<G>) -> HeldSection {
        let Twist { angular, linear } = state.velocity;
        let Rotation { x, y, z } = G::rotation_in_space(frame, &state.rotation);
        HeldSection {
            offset: G::in_space(frame, state.position) - self.position,
            axes: [x, y, z],
            angular: G::axial_in_space(frame, angular),
            velocity: G::in_space(frame, linear + angular.cross(state.position)),
        }
    }

    /// Moment and force of the springs on the section.
    fn elastic(&self, section: &HeldSection) -> [Vector<f64>; 2] {
        let mut moment = Vector::zero();
        for (i, axis) in section.axes.into_iter().enumerate() {
            moment += axis.cross(self.axes.axis(i)) * self.turning[i];
        }
        [moment, -self.stiffness.times(section.offset)]
    }

    /// Moment and force on the section.
    fn moment_and_force(&self, section: &HeldSection) -> [Vector<f64>; 2] {
        let [moment, force] = self.fixed_forces.unwrap_or_else(|| self.elastic(section));
        let velocity = section.velocity - self.velocity;
        [moment - self.rotational_damping.times(section.angular), force - self.damping.times(velocity)]
    }

    /// The springs at a section. A rotation by theta changes the moment m by `-H theta + theta x m / 2`, with
    /// the Hessian `H = sum_i c_i ((a_i . e_i) 1 - (a_i e_i^T + e_i a_i^T) / 2)`.
    pub(crate) fn springs<G: Turning>(&self, frame: G::Frame, state: &PointState<G>) -> Held {
        let section = self.section(frame, state);
        let mut hessian = Symmetric::diagonal(0.0);
        for (i, axis) in section.axes.into_iter().enumerate() {
            let to = self.axes.axis(i);
            hessian +=
                (Symmetric::diagonal(to.dot(axis)) - Symmetric::product(to, axis) * 0.5) * self.turning[i];
        }
        let [x, y, z] = self.turning;
        let firm = |[x, y, z]: [f64; 3], part: f64| {
            let rounding = ROUNDING * x.max(y).max(z);
            let mut firm = [x, y, z].map(|stiffness| (part * stiffness).max(rounding));
            firm.sort_by(f64::total_cmp);
            firm
        };
        Held {
            forces: self.elastic(&section),
            stiffness: [hessian, self.stiffness],
            energy: self.energy(frame, state),
            firm: [firm([y + z, z + x, x + y], FIRM_STIFFNESS), firm(self.along_axes.stiffness, 0.0)],
        }
    }

    /// Wrench on the section, about its centre.
    #[inline(always)]
    pub(crate) fn wrench<G: Turning>(&self, frame: G::Frame, state: &PointState<G>) -> Wrench<G, f64> {
        let [moment, force] = self.moment_and_force(&self.section(frame, state));
        Wrench { moment: G::axial_of(frame, moment), force: G::vector_of(frame, force) }
    }

    /// Change of the wrench that the section requires against the support. For a rotation theta, the force f
    /// changes by `delta f - theta x f` relative to the rotating material, and the moment likewise.
    #[inline(always)]
    pub(crate) fn response<G: Turning>(&self, frame: G::Frame, state: &PointState<G>) -> Response<G, f64> {
        let section = self.section(frame, state);
        let [moment, force] = self.moment_and_force(&section);
        let about_origin = |moment: Vector<f64>, force: Vector<f64>| {
            let need = Wrench { moment: G::axial_of(frame, -moment), force: G::vector_of(frame, -force) };
            need.at(state.position)
        };
        let local = |twist: Twist<G, f64>| {
            let linear = twist.linear + twist.angular.cross(state.position);
            [G::axial_in_space(frame, twist.angular), G::in_space(frame, linear)]
        };
        Response {
            stiffness: Linear::of(|displacement| {
                let [turn, shift] = local(displacement);
                let mut turned = -self.rotational_damping.times(turn.cross(section.angular));
                let mut shifted = -self.damping.times(turn.cross(section.velocity));
                match self.fixed_forces {
                    // The mean of a moment with fixed direction and a follower moment has a potential, as
                    // springs do.
                    Some([moment, _]) => turned += turn.cross(moment) * 0.5,
                    None => {
                        for (i, axis) in section.axes.into_iter().enumerate() {
                            turned += turn.cross(axis).cross(self.axes.axis(i)) * self.turning[i];
                        }
                        shifted += -self.stiffness.times(shift);
                    }
                }
                about_origin(turned - turn.cross(moment), shifted - turn.cross(force))
            }),
            damping: Linear::of(|y| {
                let [angular, velocity] = local(y);
                about_origin(-self.rotational_damping.times(angular), -self.damping.times(velocity))
            }),
            inertia: Linear::zero(),
        }
    }

    /// StoredEnergy energy of the springs.
    pub(crate) fn energy<G: Turning>(&self, frame: G::Frame, state: &PointState<G>) -> f64 {
        let section = self.section(frame, state);
        let mut energy = 0.5 * section.offset.dot(self.stiffness.times(section.offset));
        for (i, axis) in section.axes.into_iter().enumerate() {
            // 1 - a . e for unit vectors, without cancellation.
            let chord = axis - self.axes.axis(i);
            energy += 0.5 * self.turning[i] * chord.dot(chord);
        }
        energy
    }

    /// Power dissipated by the dampers.
    pub(crate) fn dissipated_power<G: Turning>(&self, frame: G::Frame, state: &PointState<G>) -> f64 {
        let HeldSection { angular, velocity, .. } = self.section(frame, state);
        let velocity = velocity - self.velocity;
        velocity.dot(self.damping.times(velocity)) + angular.dot(self.rotational_damping.times(angular))
    }
}

/// The supports of a plan.
pub(crate) struct Supports;

/// The anchors, with the state of their sections.
fn anchored_sections<'a, G: Turning>(
    plan: &'a Plan<G>,
    work: &'a Workspace<G>,
) -> impl Iterator<Item = (&'a Anchor, &'a PointState<G>)> {
    let points = plan.points.iter().zip(&work.points);
    points.flat_map(move |(point, state)| {
        point.effects.anchors.iter().map(move |&anchor| (&work.effects.anchors[anchor], state))
    })
}

impl<G: Turning> PointWrench<G> for Supports {
    #[inline(always)]
    fn act_at(plan: &Plan<G>, work: &Workspace<G>, point: &Point<G>, state: &mut PointState<G>) {
        for &anchor in &point.effects.anchors {
            state.force =
                state.force - work.effects.anchors[anchor].wrench(plan.frame, state).at(state.position);
        }
    }
}

impl<G: Turning> PointResponse<G> for Supports {
    #[inline(always)]
    fn responds_at(point: &Point<G>) -> bool {
        !point.effects.anchors.is_empty()
    }

    #[inline(always)]
    fn respond_at(
        plan: &Plan<G>,
        work: &Workspace<G>,
        point: &Point<G>,
        state: &PointState<G>,
        sum: &mut Response<G, f64>,
    ) {
        for &anchor in &point.effects.anchors {
            sum.add(work.effects.anchors[anchor].response(plan.frame, state));
        }
    }
}

impl<G: Turning> StoredEnergy<G> for Supports {
    fn add_energy(plan: &Plan<G>, work: &Workspace<G>, energy: &mut Energy) {
        for (anchor, state) in anchored_sections(plan, work) {
            energy.elastic += anchor.energy(plan.frame, state);
        }
    }
}

impl<G: Turning> Dissipation<G> for Supports {
    fn dissipates(plan: &Plan<G>) -> bool {
        plan.effects.anchors.iter().any(Anchor::is_damped)
    }

    fn dissipated_power(plan: &Plan<G>, work: &Workspace<G>) -> f64 {
        anchored_sections(plan, work).map(|(anchor, state)| anchor.dissipated_power(plan.frame, state)).sum()
    }
}

impl NotAlongRods for Supports {}
impl NoDeadPointWrench for Supports {}
impl NoCoordinateForce for Supports {}
impl NoSupply for Supports {}
impl NoVelocityDependence for Supports {}
