//! The kinds of effects, one trait for each. An effect implements each of them, or a marker trait `No...` for a kind that it does
//! not have; code that forgets a kind does not compile.
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

/// Defines for each kind the marker trait of effects without it.
macro_rules! without {
    ($($no:ident: $kind:ident { $(fn $name:ident($($of:ty),*) $(-> $result:ty)? { $($value:expr)? })* })*) => { $(
        #[doc = concat!("An effect without [`", stringify!($kind), "`].")]
        pub(crate) trait $no {}

        impl<G: Turning, E: $no> $kind<G> for E {
            $(#[inline(always)] fn $name($(_: $of),*) $(-> $result)? { $($value)? })*
        }
    )* };
}

without! {
    NoPointWrench: PointWrench {
        fn act_at(&Plan<G>, &Workspace<G>, &Point<G>, &mut PointState<G>) {}
    }
    NoDeadPointWrench: DeadPointWrench {
        fn dead_at(&Plan<G>, &Workspace<G>, &Point<G>, &PointState<G>, &mut Gyroscope<G, f64>) {}
    }
    NoPointResponse: PointResponse {
        fn responds_at(&Point<G>) -> bool { false }
        fn respond_at(&Plan<G>, &Workspace<G>, &Point<G>, &PointState<G>, &mut Response<G, f64>) {}
    }
    NoLineWrench: LineWrench {
        fn acts_along(&Plan<G>, &PiecePlan<G>) -> bool { false }
        fn act_along(&Plan<G>, &PiecePlan<G>, &mut Workspace<G>) {}
    }
    NoPartialWrench: PartialWrench {
        fn beyond(&Plan<G>, &PiecePlan<G>, &Workspace<G>, &Place) -> Wrench<G, f64> { Wrench::zero() }
    }
    NoDeadLineWrench: DeadLineWrench {
        fn is_dead_along(&Plan<G>, &PiecePlan<G>) -> bool { false }
        fn dead_along(&Plan<G>, &PiecePlan<G>, &Workspace<G>, &mut [Gyroscope<G, G::Pack>]) {}
    }
    NoLineResponse: LineResponse {
        fn responds_along(&PiecePlan<G>) -> bool { false }
        fn respond_along(&Plan<G>, &PiecePlan<G>, &Workspace<G>, bool, &mut [Response<G, G::Pack>]) {}
    }
    NoCoordinateForce: CoordinateForce {
        fn acts(&Plan<G>) -> bool { false }
        fn prepare(&Plan<G>, &mut Workspace<G>, &[f64], &[f64]) {}
        fn push(&Plan<G>, &Workspace<G>, &mut [f64]) {}
        fn stiffen(&Plan<G>, &Workspace<G>, &mut TangentWorkspace<G>, Weights, &mut Tangent<'_>) {}
        fn couples_pieces(&Plan<G>) -> bool { false }
    }
    NoStoredEnergy: StoredEnergy {
        fn add_energy(&Plan<G>, &Workspace<G>, &mut Energy) {}
    }
    NoDissipation: Dissipation {
        fn dissipates(&Plan<G>) -> bool { false }
        fn dissipated_power(&Plan<G>, &Workspace<G>) -> f64 { 0.0 }
    }
    NoSupply: Supply {
        fn drives(&Plan<G>) -> bool { false }
        fn supplied_power(&Plan<G>, &Workspace<G>) -> f64 { 0.0 }
    }
    NoVelocityDependence: VelocityDependence {
        fn depends_on_velocity(&Plan<G>) -> bool { false }
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
