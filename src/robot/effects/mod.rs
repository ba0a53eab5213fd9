//! Effects that act on a robot: one file per effect, listed in [`all`]. The data of an effect (in `plan`,
//! written by `compile` from the description) is private to it; the sweeps use only the trait.

pub mod actuator;
pub(crate) mod all;
pub mod contact;
pub mod fluid;
pub(crate) mod joint_forces;
pub mod load;
pub mod loops;
pub mod support;

use crate::model::Energy;
use crate::numerics::lie::Wrench;
use crate::robot::algebra::inertia::Gyroscope;
use crate::robot::algebra::response::Response;
use crate::robot::plan::Plan;
use crate::robot::plan::piece::PiecePlan;
use crate::robot::plan::point::{Place, Point};
use crate::robot::state::Workspace;
use crate::robot::state::point::PointState;
use crate::robot::state::tangent::{Tangent, TangentWorkspace, Weights};
use crate::robot::turning::Turning;

/// Interface of an effect to the sweeps, at points or along pieces. The change of its wrench with the motion
/// is of one of three kinds: none relative to the material; that of a wrench with a fixed direction in the
/// world (dead, a [`Gyroscope`]); or linear in displacement, velocity and acceleration (a [`Response`]). An
/// effect implements only what it needs; the defaults do nothing. Forces on coordinates, rather than wrenches
/// at places, are computed once the motion is known, and added at the end.
///
/// Wrenches are those that a motion requires against the effect, hence minus those of the effect, about the
/// origin of the frame.
#[allow(unused_variables, reason = "the names say what is given to those who need it")]
pub(crate) trait Effect<G: Turning> {
    /// Adds its wrench at a point to the force there, with the motion of the point up to date.
    #[inline(always)]
    fn act_at(plan: &Plan<G>, work: &Workspace<G>, point: &Point<G>, state: &mut PointState<G>) {}

    /// Adds the change of its dead wrenches at a point with rotations, relative to the material.
    #[inline(always)]
    fn dead_at(
        plan: &Plan<G>,
        work: &Workspace<G>,
        point: &Point<G>,
        state: &PointState<G>,
        sum: &mut Gyroscope<G, f64>,
    ) {
    }

    /// Whether the effect responds to the motion of a point.
    #[inline(always)]
    fn responds_at(point: &Point<G>) -> bool {
        false
    }

    /// Adds its response at such a point. The response contains no inertia; that belongs to bodies.
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

    /// Adds its wrenches per length to the forces at the nodes of such a piece, with the motion up to date.
    #[inline(always)]
    fn act_along(plan: &Plan<G>, piece: &PiecePlan<G>, work: &mut Workspace<G>) {}

    /// Correction of the nodal integral of its wrenches from a place of such a piece to its end, if the
    /// wrenches start or end abruptly in between.
    fn beyond(plan: &Plan<G>, piece: &PiecePlan<G>, work: &Workspace<G>, place: &Place) -> Wrench<G, f64> {
        Wrench::zero()
    }

    /// Whether it has dead wrenches along a piece.
    #[inline(always)]
    fn is_dead_along(plan: &Plan<G>, piece: &PiecePlan<G>) -> bool {
        false
    }

    /// [`Self::dead_at`] for the nodes of such a piece, times the quadrature weights.
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

    /// Adds its responses at the nodes of such a piece, times the quadrature weights; only the response to
    /// accelerations if nothing else is requested.
    #[inline(always)]
    fn respond_along(
        plan: &Plan<G>,
        piece: &PiecePlan<G>,
        work: &Workspace<G>,
        is_mass_only: bool,
        sums: &mut [Response<G, G::Pack>],
    ) {
    }

    /// Prepares its forces on coordinates, with the motion of all pieces and points up to date.
    #[inline(always)]
    fn prepare(plan: &Plan<G>, work: &mut Workspace<G>, q: &[f64], qd: &[f64]) {}

    /// Adds its forces on coordinates to the generalised forces.
    #[inline(always)]
    fn push(plan: &Plan<G>, work: &Workspace<G>, tau: &mut [f64]) {}

    /// Adds the derivatives of these forces.
    #[inline(always)]
    fn stiffen(
        plan: &Plan<G>,
        work: &Workspace<G>,
        memory: &mut TangentWorkspace<G>,
        weights: Weights,
        tangent: &mut Tangent<'_>,
    ) {
    }

    /// Whether it dissipates power, whether it supplies power without having a potential, and whether its
    /// wrenches depend on velocities in ways other than dissipation. A run skips what does not apply.
    fn dissipates(plan: &Plan<G>) -> bool {
        false
    }
    /// Whether it may dissipate power in the shape evaluated last.
    fn may_dissipate(plan: &Plan<G>, work: &Workspace<G>) -> bool {
        Self::dissipates(plan)
    }
    fn drives(plan: &Plan<G>) -> bool {
        false
    }
    fn depends_on_velocity(plan: &Plan<G>) -> bool {
        false
    }

    /// Adds its energies, with the motion up to date.
    fn add_energy(plan: &Plan<G>, work: &Workspace<G>, energy: &mut Energy) {}

    /// Power that it dissipates.
    fn dissipated_power(plan: &Plan<G>, work: &Workspace<G>) -> f64 {
        0.0
    }

    /// Power that it supplies without having a potential.
    fn supplied_power(plan: &Plan<G>, work: &Workspace<G>) -> f64 {
        0.0
    }
}
