//! What acts on a robot: one file an effect, named in the list of [`all`]. What an effect is given (its data in `plan`,
//! made by `compile` from the description) is its own matter; all that the sweeps know of it is in the trait.

pub(crate) mod actuation;
pub(crate) mod all;
pub(crate) mod contact;
pub(crate) mod immersion;
pub(crate) mod joint_forces;
pub(crate) mod load;
pub(crate) mod loops;
pub(crate) mod support;

use crate::lie::Wrench;
use crate::model::Energy;
use crate::robot::algebra::inertia::Gyroscope;
use crate::robot::algebra::products::Products;
use crate::robot::algebra::response::Response;
use crate::robot::plan::Plan;
use crate::robot::plan::piece::PiecePlan;
use crate::robot::plan::point::{Place, Point};
use crate::robot::state::Workspace;
use crate::robot::state::point::PointState;
use crate::robot::state::tangent::{Tangent, TangentWorkspace, Weights};
use crate::robot::turning::Turning;

/// What the sweeps ask of something that acts on a robot, at points or along pieces. Its wrench changes with the motion
/// in one of three ways: not at all, as the material sees it; as one that keeps its direction in the world (dead, a
/// [`Gyroscope`]); or linearly in displacement, velocity and acceleration (a [`Response`]). An effect writes only what it
/// has; the rest is nothing. What is no wrench at a place but a force on coordinates is found once the motion is known,
/// and added at the end.
///
/// Wrenches are what a motion needs against the effect, so its opposite, about the origin of the frame.
#[allow(unused_variables, reason = "the names say what is given to those who need it")]
pub(crate) trait Effect<G: Turning> {
    /// Adds its wrench at a point to the force there, the motion of the point up to date.
    #[inline(always)]
    fn act_at(plan: &Plan<G>, work: &Workspace<G>, point: &Point<G>, state: &mut PointState<G>) {}

    /// Adds the change of its dead wrenches at a point, as the material sees it when it turns.
    #[inline(always)]
    fn dead_at(
        plan: &Plan<G>,
        work: &Workspace<G>,
        point: &Point<G>,
        state: &PointState<G>,
        sum: &mut Gyroscope<G, f64>,
    ) {
    }

    /// Whether the effect responds at a point to its motion.
    #[inline(always)]
    fn responds_at(point: &Point<G>) -> bool {
        false
    }

    /// Adds its response at such a point. It has no inertia there: what has is a body.
    #[inline(always)]
    fn respond_at(
        plan: &Plan<G>,
        work: &Workspace<G>,
        point: &Point<G>,
        state: &PointState<G>,
        sum: &mut Response<G, f64>,
    ) {
    }

    /// Whether the effect acts along a piece.
    #[inline(always)]
    fn acts_along(plan: &Plan<G>, piece: &PiecePlan<G>) -> bool {
        false
    }

    /// Adds its wrenches per length to the forces at the nodes of such a piece, the motion up to date.
    #[inline(always)]
    fn act_along(plan: &Plan<G>, piece: &PiecePlan<G>, work: &mut Workspace<G>) {}

    /// What is missing in the integral of its wrenches at the nodes, from a place of such a piece to its end, because it
    /// ends abruptly somewhere between.
    fn beyond(plan: &Plan<G>, piece: &PiecePlan<G>, work: &Workspace<G>, place: &Place) -> Wrench<G, f64> {
        Wrench::zero()
    }

    /// Whether it is dead along a piece.
    #[inline(always)]
    fn is_dead_along(plan: &Plan<G>, piece: &PiecePlan<G>) -> bool {
        false
    }

    /// [`Self::dead_at`] of the nodes of such a piece, times the quadrature weights.
    #[inline(always)]
    fn dead_along(
        plan: &Plan<G>,
        piece: &PiecePlan<G>,
        work: &Workspace<G>,
        sums: &mut [Gyroscope<G, G::Pack>],
    ) {
    }

    /// Whether the effect responds to the motion of the nodes of a piece.
    #[inline(always)]
    fn responds_along(piece: &PiecePlan<G>) -> bool {
        false
    }

    /// Adds its responses at the nodes of such a piece, times the quadrature weights; that to accelerations alone,
    /// where nothing else is asked for.
    #[inline(always)]
    fn respond_along(
        plan: &Plan<G>,
        piece: &PiecePlan<G>,
        work: &Workspace<G>,
        is_mass_only: bool,
        sums: &mut [Response<G, G::Pack>],
    ) {
    }

    /// Finds what its forces on coordinates follow from, the motion of all pieces and points up to date.
    #[inline(always)]
    fn prepare(plan: &Plan<G>, work: &mut Workspace<G>, q: &[f64], qd: &[f64]) {}

    /// Adds its forces on coordinates to the generalised forces.
    #[inline(always)]
    fn push(plan: &Plan<G>, work: &Workspace<G>, tau: &mut [f64]) {}

    /// Adds the derivative of these.
    #[inline(always)]
    fn stiffen(
        plan: &Plan<G>,
        work: &Workspace<G>,
        memory: &mut TangentWorkspace<G>,
        weights: Weights,
        tangent: &mut Tangent<'_>,
    ) {
    }

    /// Whether it takes power out of motion, whether it puts any in without having a potential, and whether its wrenches
    /// depend on velocities other than by dissipation alone: where it does not, a run leaves that out.
    fn dissipates(plan: &Plan<G>) -> bool {
        false
    }
    /// The same of the shape that was looked at last.
    fn may_dissipate(plan: &Plan<G>, work: &Workspace<G>) -> bool {
        Self::dissipates(plan)
    }
    fn drives(plan: &Plan<G>) -> bool {
        false
    }
    fn depends_on_velocity(plan: &Plan<G>) -> bool {
        false
    }

    /// Adds its energies, the motion up to date.
    fn add_energy(plan: &Plan<G>, work: &Workspace<G>, energy: &mut Energy) {}

    /// Power that it takes out of the motion.
    fn dissipated_power(plan: &Plan<G>, work: &Workspace<G>) -> f64 {
        0.0
    }

    /// Power that it puts into the motion without having a potential.
    fn supplied_power(plan: &Plan<G>, work: &Workspace<G>) -> f64 {
        0.0
    }

    /// Products that it forms for a piece and its points, acting.
    fn products_of_action(plan: &Plan<G>, piece: &PiecePlan<G>) -> Products {
        Products::default()
    }

    /// Products that it forms for a piece, turning and responding along it.
    fn products_of_response(plan: &Plan<G>, piece: &PiecePlan<G>, is_mass_only: bool) -> Products {
        Products::default()
    }
}
