//! What an effect can do, one trait for each kind. An effect implements each of them, or says by a trait `No...` that it has
//! nothing of the kind; a kind that is forgotten does not compile.
//!
//! The change of a wrench with the motion is of one of three kinds: none relative to the material; that of a wrench with a
//! fixed direction in the world (dead, a [`Gyroscope`]); or linear in displacement, velocity and acceleration (a
//! [`Response`]). Wrenches are those that a motion requires against the effect, hence minus those of the effect, about the
//! origin of the frame.

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

/// Wrenches at points.
pub(crate) trait PointWrench<G: Turning> {
    /// Adds its wrench at a point to the force there, with the motion of the point up to date.
    fn act_at(plan: &Plan<G>, work: &Workspace<G>, point: &Point<G>, state: &mut PointState<G>);
}

/// Wrenches at points that keep their direction in the world while the material turns.
pub(crate) trait DeadPointWrench<G: Turning> {
    /// Adds the change of its dead wrenches at a point with rotations, relative to the material.
    fn dead_at(
        plan: &Plan<G>,
        work: &Workspace<G>,
        point: &Point<G>,
        state: &PointState<G>,
        sum: &mut Gyroscope<G, f64>,
    );
}

/// Wrenches at points that change with displacement, velocity and acceleration.
pub(crate) trait PointResponse<G: Turning> {
    /// Whether the effect responds to the motion of a point.
    fn responds_at(point: &Point<G>) -> bool;

    /// Adds its response at such a point. The response contains no inertia; that belongs to bodies.
    fn respond_at(
        plan: &Plan<G>,
        work: &Workspace<G>,
        point: &Point<G>,
        state: &PointState<G>,
        sum: &mut Response<G, f64>,
    );
}

/// Wrenches per length along pieces.
pub(crate) trait LineWrench<G: Turning> {
    /// Whether the effect acts along a piece.
    fn acts_along(plan: &Plan<G>, piece: &PiecePlan<G>) -> bool;

    /// Adds its wrenches per length to the forces at the nodes of such a piece, with the motion up to date.
    fn act_along(plan: &Plan<G>, piece: &PiecePlan<G>, work: &mut Workspace<G>);
}

/// Wrenches along pieces that start or end abruptly between nodes.
pub(crate) trait PartialWrench<G: Turning> {
    /// Correction of the nodal integral of its wrenches from a place of such a piece to its end, if the
    /// wrenches start or end abruptly in between.
    fn beyond(plan: &Plan<G>, piece: &PiecePlan<G>, work: &Workspace<G>, place: &Place) -> Wrench<G, f64>;
}

/// Wrenches per length that keep their direction in the world while the material turns.
pub(crate) trait DeadLineWrench<G: Turning> {
    /// Whether it has dead wrenches along a piece.
    fn is_dead_along(plan: &Plan<G>, piece: &PiecePlan<G>) -> bool;

    /// [`DeadPointWrench::dead_at`] for the nodes of such a piece, times the quadrature weights.
    fn dead_along(
        plan: &Plan<G>,
        piece: &PiecePlan<G>,
        work: &Workspace<G>,
        sums: &mut [Gyroscope<G, G::Pack>],
    );
}

/// Wrenches per length that change with displacement, velocity and acceleration.
pub(crate) trait LineResponse<G: Turning> {
    /// Whether the effect responds to the motion of the nodes of a piece.
    fn responds_along(piece: &PiecePlan<G>) -> bool;

    /// Adds its responses at the nodes of such a piece, times the quadrature weights; only the response to
    /// accelerations if nothing else is requested.
    fn respond_along(
        plan: &Plan<G>,
        piece: &PiecePlan<G>,
        work: &Workspace<G>,
        is_mass_only: bool,
        sums: &mut [Response<G, G::Pack>],
    );
}

/// Forces on coordinates, computed once the motion is known, and added at the end.
pub(crate) trait CoordinateForce<G: Turning> {
    /// Whether it acts in any state.
    fn acts(plan: &Plan<G>) -> bool;

    /// Prepares its forces on coordinates, with the motion of all pieces and points up to date.
    fn prepare(plan: &Plan<G>, work: &mut Workspace<G>, q: &[f64], qd: &[f64]);

    /// Adds its forces on coordinates to the generalised forces.
    fn push(plan: &Plan<G>, work: &Workspace<G>, tau: &mut [f64]);

    /// Adds the derivatives of these forces.
    fn stiffen(
        plan: &Plan<G>,
        work: &Workspace<G>,
        memory: &mut TangentWorkspace<G>,
        weights: Weights,
        tangent: &mut Tangent<'_>,
    );

    /// Whether these derivatives have entries between different pieces.
    fn couples_pieces(plan: &Plan<G>) -> bool;
}

/// Energy that is stored: of a potential, or of the motion.
pub(crate) trait StoredEnergy<G: Turning> {
    /// Adds its energies, with the motion up to date.
    fn add_energy(plan: &Plan<G>, work: &Workspace<G>, energy: &mut Energy);
}

/// Power that is dissipated. A run skips it where nothing dissipates.
pub(crate) trait Dissipation<G: Turning> {
    /// Whether it dissipates power in any state.
    fn dissipates(plan: &Plan<G>) -> bool;

    /// Whether it may dissipate power in the shape evaluated last.
    fn may_dissipate(plan: &Plan<G>, _work: &Workspace<G>) -> bool {
        Self::dissipates(plan)
    }

    /// Power that it dissipates.
    fn dissipated_power(plan: &Plan<G>, work: &Workspace<G>) -> f64;
}

/// Power that is supplied without a potential. A run skips it where nothing drives.
pub(crate) trait Supply<G: Turning> {
    /// Whether it supplies such power in any state.
    fn drives(plan: &Plan<G>) -> bool;

    /// Power that it supplies without having a potential.
    fn supplied_power(plan: &Plan<G>, work: &Workspace<G>) -> f64;
}

/// Wrenches that depend on velocities in other ways than by dissipation.
pub(crate) trait VelocityDependence<G: Turning> {
    /// Whether they do in any state.
    fn depends_on_velocity(plan: &Plan<G>) -> bool;
}

/// An effect without [`PointWrench`].
pub(crate) trait NoPointWrench {}

impl<G: Turning, E: NoPointWrench> PointWrench<G> for E {
    #[inline(always)]
    fn act_at(_: &Plan<G>, _: &Workspace<G>, _: &Point<G>, _: &mut PointState<G>) {}
}

/// An effect without [`DeadPointWrench`].
pub(crate) trait NoDeadPointWrench {}

impl<G: Turning, E: NoDeadPointWrench> DeadPointWrench<G> for E {
    #[inline(always)]
    fn dead_at(_: &Plan<G>, _: &Workspace<G>, _: &Point<G>, _: &PointState<G>, _: &mut Gyroscope<G, f64>) {}
}

/// An effect without [`PointResponse`].
pub(crate) trait NoPointResponse {}

impl<G: Turning, E: NoPointResponse> PointResponse<G> for E {
    #[inline(always)]
    fn responds_at(_: &Point<G>) -> bool {
        false
    }

    #[inline(always)]
    fn respond_at(_: &Plan<G>, _: &Workspace<G>, _: &Point<G>, _: &PointState<G>, _: &mut Response<G, f64>) {}
}

/// An effect without [`LineWrench`].
pub(crate) trait NoLineWrench {}

impl<G: Turning, E: NoLineWrench> LineWrench<G> for E {
    #[inline(always)]
    fn acts_along(_: &Plan<G>, _: &PiecePlan<G>) -> bool {
        false
    }

    #[inline(always)]
    fn act_along(_: &Plan<G>, _: &PiecePlan<G>, _: &mut Workspace<G>) {}
}

/// An effect without [`PartialWrench`].
pub(crate) trait NoPartialWrench {}

impl<G: Turning, E: NoPartialWrench> PartialWrench<G> for E {
    fn beyond(_: &Plan<G>, _: &PiecePlan<G>, _: &Workspace<G>, _: &Place) -> Wrench<G, f64> {
        Wrench::zero()
    }
}

/// An effect without [`DeadLineWrench`].
pub(crate) trait NoDeadLineWrench {}

impl<G: Turning, E: NoDeadLineWrench> DeadLineWrench<G> for E {
    #[inline(always)]
    fn is_dead_along(_: &Plan<G>, _: &PiecePlan<G>) -> bool {
        false
    }

    #[inline(always)]
    fn dead_along(_: &Plan<G>, _: &PiecePlan<G>, _: &Workspace<G>, _: &mut [Gyroscope<G, G::Pack>]) {}
}

/// An effect without [`LineResponse`].
pub(crate) trait NoLineResponse {}

impl<G: Turning, E: NoLineResponse> LineResponse<G> for E {
    #[inline(always)]
    fn responds_along(_: &PiecePlan<G>) -> bool {
        false
    }

    #[inline(always)]
    fn respond_along(
        _: &Plan<G>,
        _: &PiecePlan<G>,
        _: &Workspace<G>,
        _: bool,
        _: &mut [Response<G, G::Pack>],
    ) {
    }
}

/// An effect without [`CoordinateForce`].
pub(crate) trait NoCoordinateForce {}

impl<G: Turning, E: NoCoordinateForce> CoordinateForce<G> for E {
    fn acts(_: &Plan<G>) -> bool {
        false
    }

    #[inline(always)]
    fn prepare(_: &Plan<G>, _: &mut Workspace<G>, _: &[f64], _: &[f64]) {}

    #[inline(always)]
    fn push(_: &Plan<G>, _: &Workspace<G>, _: &mut [f64]) {}

    #[inline(always)]
    fn stiffen(_: &Plan<G>, _: &Workspace<G>, _: &mut TangentWorkspace<G>, _: Weights, _: &mut Tangent<'_>) {}

    fn couples_pieces(_: &Plan<G>) -> bool {
        false
    }
}

/// An effect without [`StoredEnergy`].
pub(crate) trait NoStoredEnergy {}

impl<G: Turning, E: NoStoredEnergy> StoredEnergy<G> for E {
    fn add_energy(_: &Plan<G>, _: &Workspace<G>, _: &mut Energy) {}
}

/// An effect without [`Dissipation`].
pub(crate) trait NoDissipation {}

impl<G: Turning, E: NoDissipation> Dissipation<G> for E {
    fn dissipates(_: &Plan<G>) -> bool {
        false
    }

    fn dissipated_power(_: &Plan<G>, _: &Workspace<G>) -> f64 {
        0.0
    }
}

/// An effect without [`Supply`].
pub(crate) trait NoSupply {}

impl<G: Turning, E: NoSupply> Supply<G> for E {
    fn drives(_: &Plan<G>) -> bool {
        false
    }

    fn supplied_power(_: &Plan<G>, _: &Workspace<G>) -> f64 {
        0.0
    }
}

/// An effect without [`VelocityDependence`].
pub(crate) trait NoVelocityDependence {}

impl<G: Turning, E: NoVelocityDependence> VelocityDependence<G> for E {
    fn depends_on_velocity(_: &Plan<G>) -> bool {
        false
    }
}

/// An effect without wrenches at points.
pub(crate) trait NotAtPoints {}

impl<E: NotAtPoints> NoPointWrench for E {}
impl<E: NotAtPoints> NoDeadPointWrench for E {}
impl<E: NotAtPoints> NoPointResponse for E {}

/// An effect without wrenches along pieces.
pub(crate) trait NotAlongRods {}

impl<E: NotAlongRods> NoLineWrench for E {}
impl<E: NotAlongRods> NoPartialWrench for E {}
impl<E: NotAlongRods> NoDeadLineWrench for E {}
impl<E: NotAlongRods> NoLineResponse for E {}
