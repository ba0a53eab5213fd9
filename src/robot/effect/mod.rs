//! What acts on a robot: one file an effect. To add one, write its file and name it in the list of [`all`].

pub(crate) mod all;
pub(crate) mod immersion;
pub(crate) mod load;
pub(crate) mod support;

use crate::model::Energy;
use crate::robot::algebra::inertia::Gyroscope;
use crate::robot::algebra::products::Products;
use crate::robot::algebra::response::Response;
use crate::robot::plan::Plan;
use crate::robot::plan::piece::PiecePlan;
use crate::robot::plan::point::Point;
use crate::robot::state::Workspace;
use crate::robot::state::point::PointState;
use crate::robot::turning::Turning;

/// What the sweeps ask of something that acts on a robot. It acts at points, along pieces, or both, and says of each
/// how its wrench changes: as one that keeps its direction (a gyroscope) or as any that is linear in the motion (a
/// response). An effect writes only what it has; the rest is nothing.
///
/// Wrenches are what a motion needs against the effect, so its opposite, about the origin of the frame.
#[allow(unused_variables, reason = "the names say what is given to those who need it")]
pub(crate) trait Effect<G: Turning> {
    /// Adds its wrench at a point to the force there, the motion of the point up to date.
    #[inline(always)]
    fn act_at(plan: &Plan<G>, work: &Workspace<G>, point: &Point<G>, state: &mut PointState<G>) {}

    /// Adds what turns with the material relative to wrenches that keep their direction.
    #[inline(always)]
    fn turn_at(
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

    /// Adds its response at such a point.
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

    /// Whether its wrenches along a piece keep their direction.
    #[inline(always)]
    fn turns_along(plan: &Plan<G>, piece: &PiecePlan<G>) -> bool {
        false
    }

    /// Adds what turns with the material of such a piece relative to them, times the quadrature weights.
    #[inline(always)]
    fn turn_along(
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
