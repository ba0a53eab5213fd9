//! Effects that act on a robot: one folder per effect, all of which are listed here. The sweeps use only the traits in [`kinds`].

pub mod actuator;
pub mod contact;
pub mod fluid;
pub(crate) mod joint_forces;
pub(crate) mod kinds;
pub mod load;
pub mod loops;
pub mod magnet;
pub(crate) mod parts;
pub mod support;

use std::marker::PhantomData;

use self::joint_forces::OnJoints;
use self::kinds::{
    CoordinateForce, DeadLineWrench, DeadPointWrench, Dissipation, LineResponse, LineWrench, PartialWrench,
    PointResponse, PointWrench, StoredEnergy, Supply, VelocityDependence,
};
#[cfg(feature = "python")]
use crate::description::schema::{Part as _, Schema};
use crate::model::Energy;
use crate::numerics::lie::{Sweep, Wrench};
use crate::robot::algebra::inertia::Gyroscope;
use crate::robot::algebra::response::Response;
use crate::robot::compile::links::Tree;
use crate::robot::compile::points::PointsFor;
use crate::robot::description::Robot;
use crate::robot::effects::actuator::force::Actuators;
use crate::robot::effects::contact::force::Touching;
use crate::robot::effects::fluid::along_rods::FluidAround;
use crate::robot::effects::fluid::around_bodies::FluidAroundBodies;
use crate::robot::effects::load::force::Loads;
use crate::robot::effects::loops::force::ClosedLoops;
use crate::robot::effects::magnet::force::Magnets;
use crate::robot::effects::support::force::Supports;
use crate::robot::explain::text::Explained;
use crate::robot::plan::Plan;
use crate::robot::plan::piece::PiecePlan;
use crate::robot::plan::point::{Place, Point};
use crate::robot::state::Workspace;
use crate::robot::state::point::PointState;
use crate::robot::state::tangent::{Tangent, TangentWorkspace, Weights};
use crate::robot::turning::Turning;

/// Tables of what users describe, those that others hold first.
#[cfg(feature = "python")]
pub(crate) const PARTS: [&Schema; 22] = [
    load::described::Load::SCHEMA,
    support::described::Support::SCHEMA,
    fluid::Fluid::SCHEMA,
    actuator::described::Along::SCHEMA,
    actuator::described::Via::SCHEMA,
    actuator::described::Tendon::SCHEMA,
    actuator::described::Chamber::SCHEMA,
    actuator::described::Motor::SCHEMA,
    actuator::described::ActiveStrain::SCHEMA,
    loops::described::LoopEnd::SCHEMA,
    loops::described::Distance::SCHEMA,
    loops::described::Gear::SCHEMA,
    loops::described::Loop::SCHEMA,
    contact::described::Ball::SCHEMA,
    contact::described::HalfSpace::SCHEMA,
    contact::described::Sphere::SCHEMA,
    contact::described::Capsule::SCHEMA,
    contact::described::Cuboid::SCHEMA,
    contact::described::HeightField::SCHEMA,
    contact::described::ConvexMesh::SCHEMA,
    contact::described::Contact::SCHEMA,
    magnet::described::Magnet::SCHEMA,
];

/// Executes code for every effect, in the order of this list.
macro_rules! for_every_effect {
    ($effect:ident => $call:expr) => {
        for_every_effect!($effect in [Loads, Supports, FluidAround, FluidAroundBodies, OnJoints, Actuators, ClosedLoops, Touching, Magnets] => $call)
    };
    ($effect:ident in [$($kind:ty),*] => $call:expr) => {
        $({
            type $effect = $kind;
            $call
        })*
    };
}

/// Whether a predicate holds for any effect.
macro_rules! any_effect {
    ($effect:ident => $call:expr) => {{
        let mut is_any = false;
        for_every_effect!($effect => is_any |= $call);
        is_any
    }};
}

/// Sum of a quantity over all effects.
macro_rules! sum_of_effects {
    ($effect:ident => $call:expr) => {{
        let mut sum = Default::default();
        for_every_effect!($effect => sum += $call);
        sum
    }};
}

/// The places at which effects need points, `pulled` those of ends of straight parts of tendons, and the list of a point in
/// which they find their indices there.
pub(crate) fn places<G: Turning>(
    robot: &Robot,
    tree: &Tree<G>,
    pulled: Vec<Option<Place>>,
) -> [PointsFor<G>; 5] {
    [
        (support::compile::places(robot, tree), |point| &mut point.effects.anchors),
        (pulled, |point| &mut point.effects.pulled),
        (loops::compile::places(robot, tree), |point| &mut point.effects.tied),
        (contact::compile::places(robot, tree), |point| &mut point.effects.surfaces),
        (magnet::compile::places(robot, tree), |point| &mut point.effects.magnets),
    ]
}

/// Adds effects to a plan whose points are known.
pub(crate) fn compile<G: Turning>(plan: &mut Plan<G>, robot: &Robot) {
    loops::compile::compile(plan, robot);
    contact::compile::compile(plan, robot);
    magnet::compile::compile(plan, robot);
    support::compile::compile(plan, robot);
    fluid::compile::compile(plan, robot);
    plan.has_responses = responds(plan);
}

/// What `explain()` says of effects besides loads, fluid and actuators.
pub(crate) fn explain(robot: &Robot) -> impl Iterator<Item = Explained> {
    [loops::explain::explain(robot), contact::explain::explain(robot), magnet::explain::explain(robot)]
        .into_iter()
        .flatten()
}

/// Wrenches along a piece that are linear in the inputs of loads.
pub(crate) fn load_along<G: Turning>(plan: &Plan<G>, piece: &PiecePlan<G>, work: &mut Workspace<G>) {
    for_every_effect!(Kind in [Loads, Magnets] => if <Kind as LineWrench<G>>::acts_along(plan, piece) {
        <Kind as LineWrench<G>>::act_along(plan, piece, work);
    });
}

/// Wrenches at a point that are linear in the inputs of loads.
pub(crate) fn load_at<G: Turning>(
    plan: &Plan<G>,
    work: &Workspace<G>,
    point: &Point<G>,
    state: &mut PointState<G>,
) {
    for_every_effect!(Kind in [Loads, Magnets] => <Kind as PointWrench<G>>::act_at(plan, work, point, state));
}

/// [`PointWrench::act_at`].
#[inline(always)]
pub(crate) fn act_at<G: Turning>(
    plan: &Plan<G>,
    work: &Workspace<G>,
    point: &Point<G>,
    state: &mut PointState<G>,
) {
    for_every_effect!(Kind => <Kind as PointWrench<G>>::act_at(plan, work, point, state));
}

/// [`DeadPointWrench::dead_at`]: the sum.
#[inline(always)]
pub(crate) fn dead_at<G: Turning>(
    plan: &Plan<G>,
    work: &Workspace<G>,
    point: &Point<G>,
    state: &PointState<G>,
) -> Gyroscope<G, f64> {
    let mut sum = Gyroscope::zero();
    for_every_effect!(Kind => <Kind as DeadPointWrench<G>>::dead_at(plan, work, point, state, &mut sum));
    sum
}

/// [`PointResponse::respond_at`]: the sum, if there is any.
#[inline(always)]
pub(crate) fn respond_at<G: Turning>(
    plan: &Plan<G>,
    work: &Workspace<G>,
    point: &Point<G>,
    state: &PointState<G>,
) -> Option<Response<G, f64>> {
    let mut sum = responds_at(point).then(Response::zero)?;
    for_every_effect!(Kind => <Kind as PointResponse<G>>::respond_at(plan, work, point, state, &mut sum));
    Some(sum)
}

struct ActAlong<'a, G: Turning, E> {
    plan: &'a Plan<G>,
    piece: &'a PiecePlan<G>,
    work: &'a mut Workspace<G>,
    effect: PhantomData<E>,
}

impl<G: Turning, E: LineWrench<G>> Sweep for ActAlong<'_, G, E> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        E::act_along(self.plan, self.piece, self.work);
    }
}

/// [`LineWrench::act_along`].
#[inline(always)]
pub(crate) fn act_along<G: Turning>(plan: &Plan<G>, piece: &PiecePlan<G>, work: &mut Workspace<G>) {
    for_every_effect!(Kind => if <Kind as LineWrench<G>>::acts_along(plan, piece) {
        let sweep = ActAlong { plan, piece, work: &mut *work, effect: PhantomData::<Kind> };
        plan.instructions.run_apart::<G::Pack, _>(sweep);
    });
}

/// [`PartialWrench::beyond`]: the sum.
pub(crate) fn beyond<G: Turning>(
    plan: &Plan<G>,
    piece: &PiecePlan<G>,
    work: &Workspace<G>,
    place: &Place,
) -> Wrench<G, f64> {
    let mut sum = Wrench::zero();
    for_every_effect!(Kind => sum += <Kind as PartialWrench<G>>::beyond(plan, piece, work, place));
    sum
}

/// [`DeadLineWrench::is_dead_along`].
#[inline(always)]
pub(crate) fn is_dead_along<G: Turning>(plan: &Plan<G>, piece: &PiecePlan<G>) -> bool {
    any_effect!(Kind => <Kind as DeadLineWrench<G>>::is_dead_along(plan, piece))
}

/// [`DeadLineWrench::dead_along`]: the sums.
#[inline(always)]
pub(crate) fn dead_along<G: Turning>(
    plan: &Plan<G>,
    piece: &PiecePlan<G>,
    work: &Workspace<G>,
    sums: &mut [Gyroscope<G, G::Pack>],
) {
    sums.fill(Gyroscope::zero());
    for_every_effect!(Kind => <Kind as DeadLineWrench<G>>::dead_along(plan, piece, work, sums));
}

struct RespondAlong<'a, G: Turning, E> {
    plan: &'a Plan<G>,
    piece: &'a PiecePlan<G>,
    work: &'a Workspace<G>,
    is_mass_only: bool,
    sums: &'a mut [Response<G, G::Pack>],
    effect: PhantomData<E>,
}

impl<G: Turning, E: LineResponse<G>> Sweep for RespondAlong<'_, G, E> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        E::respond_along(self.plan, self.piece, self.work, self.is_mass_only, self.sums);
    }
}

/// Whether anything [responds along](LineResponse::responds_along) a piece.
#[inline(always)]
pub(crate) fn responds_along<G: Turning>(piece: &PiecePlan<G>) -> bool {
    any_effect!(Kind => <Kind as LineResponse<G>>::responds_along(piece))
}

/// [`LineResponse::respond_along`]: the sums.
#[inline(always)]
pub(crate) fn respond_along<G: Turning>(
    plan: &Plan<G>,
    piece: &PiecePlan<G>,
    work: &Workspace<G>,
    is_mass_only: bool,
    sums: &mut [Response<G, G::Pack>],
) {
    sums.fill(Response::zero());
    for_every_effect!(Kind => if <Kind as LineResponse<G>>::responds_along(piece) {
        let effect = PhantomData::<Kind>;
        let sweep = RespondAlong { plan, piece, work, is_mass_only, sums: &mut *sums, effect };
        plan.instructions.run_apart::<G::Pack, _>(sweep);
    });
}

/// Whether anything [responds at](PointResponse::responds_at) a point.
#[inline(always)]
pub(crate) fn responds_at<G: Turning>(point: &Point<G>) -> bool {
    any_effect!(Kind => <Kind as PointResponse<G>>::responds_at(point))
}

/// Whether anything responds anywhere.
pub(crate) fn responds<G: Turning>(plan: &Plan<G>) -> bool {
    plan.points.iter().any(responds_at) || plan.pieces.iter().any(responds_along)
}

/// Whether anything acts along a piece or on coordinates, in any state.
pub(crate) fn act<G: Turning>(plan: &Plan<G>, piece: &PiecePlan<G>) -> bool {
    any_effect!(Kind => {
        let acts_along =
            <Kind as LineWrench<G>>::acts_along(plan, piece) || <Kind as LineResponse<G>>::responds_along(piece);
        acts_along || <Kind as CoordinateForce<G>>::acts(plan)
    })
}

/// [`CoordinateForce::prepare`].
#[inline(always)]
pub(crate) fn prepare<G: Turning>(plan: &Plan<G>, work: &mut Workspace<G>, q: &[f64], qd: &[f64]) {
    for_every_effect!(Kind => <Kind as CoordinateForce<G>>::prepare(plan, work, q, qd));
}

/// [`CoordinateForce::push`].
#[inline(always)]
pub(crate) fn push<G: Turning>(plan: &Plan<G>, work: &Workspace<G>, tau: &mut [f64]) {
    for_every_effect!(Kind => <Kind as CoordinateForce<G>>::push(plan, work, tau));
}

/// [`CoordinateForce::stiffen`].
#[inline(always)]
pub(crate) fn stiffen<G: Turning>(
    plan: &Plan<G>,
    work: &Workspace<G>,
    memory: &mut TangentWorkspace<G>,
    weights: Weights,
    tangent: &mut Tangent<'_>,
) {
    for_every_effect!(Kind => <Kind as CoordinateForce<G>>::stiffen(plan, work, memory, weights, tangent));
}

/// [`CoordinateForce::couples_pieces`].
pub(crate) fn couple_pieces<G: Turning>(plan: &Plan<G>) -> bool {
    any_effect!(Kind => <Kind as CoordinateForce<G>>::couples_pieces(plan))
}

/// [`Dissipation::dissipates`].
pub(crate) fn dissipates<G: Turning>(plan: &Plan<G>) -> bool {
    any_effect!(Kind => <Kind as Dissipation<G>>::dissipates(plan))
}

/// [`Dissipation::may_dissipate`].
pub(crate) fn may_dissipate<G: Turning>(plan: &Plan<G>, work: &Workspace<G>) -> bool {
    any_effect!(Kind => <Kind as Dissipation<G>>::may_dissipate(plan, work))
}

/// [`Supply::drives`].
pub(crate) fn drives<G: Turning>(plan: &Plan<G>) -> bool {
    any_effect!(Kind => <Kind as Supply<G>>::drives(plan))
}

/// [`VelocityDependence::depends_on_velocity`].
pub(crate) fn depends_on_velocity<G: Turning>(plan: &Plan<G>) -> bool {
    any_effect!(Kind => <Kind as VelocityDependence<G>>::depends_on_velocity(plan))
}

/// [`StoredEnergy::add_energy`].
pub(crate) fn add_energy<G: Turning>(plan: &Plan<G>, work: &Workspace<G>, energy: &mut Energy) {
    for_every_effect!(Kind => <Kind as StoredEnergy<G>>::add_energy(plan, work, energy));
}

/// [`Dissipation::dissipated_power`]: the sum.
pub(crate) fn dissipated_power<G: Turning>(plan: &Plan<G>, work: &Workspace<G>) -> f64 {
    sum_of_effects!(Kind => <Kind as Dissipation<G>>::dissipated_power(plan, work))
}

/// [`Supply::supplied_power`]: the sum.
pub(crate) fn supplied_power<G: Turning>(plan: &Plan<G>, work: &Workspace<G>) -> f64 {
    sum_of_effects!(Kind => <Kind as Supply<G>>::supplied_power(plan, work))
}
