//! Effects that act on a robot: one folder per effect, all of which are listed here. The sweeps use only the traits in `kinds`.

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
use crate::description::schema::{Part as _, Schema};
use crate::model::Energy;
use crate::numerics::lie::{Sweep, Wrench};
use crate::robot::algebra::inertia::Gyroscope;
use crate::robot::algebra::response::Response;
use crate::robot::compile::links::Tree;
use crate::robot::compile::points::PointsFor;
use crate::robot::description::Robot;
use crate::robot::effects::actuator::force::Actuators;
use crate::robot::effects::contact::force::ContactForces;
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

/// Tables of the descriptions of effects, contained ones before those that contain them.
pub const PARTS: [&Schema; 25] = [
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
    contact::described::Tube::SCHEMA,
    contact::described::DistanceGrid::SCHEMA,
    contact::described::Mesh::SCHEMA,
    contact::described::Contact::SCHEMA,
    magnet::described::Magnet::SCHEMA,
];

/// Executes code for every effect, in the order of this list.
macro_rules! for_every_effect {
    ($effect:ident => $call:expr) => {
        for_every_effect!($effect in [Loads, Supports, FluidAround, FluidAroundBodies, OnJoints, Actuators, ClosedLoops, ContactForces, Magnets] => $call)
    };
    ($effect:ident in [$($kind:ty),*] => $call:expr) => {
        $({
            type $effect = $kind;
            $call
        })*
    };
}

/// Defines functions that call one method of all effects: `each` calls it, `any` ors the results, `sum` adds them.
macro_rules! of_all_effects {
    ($($how:ident $name:ident: $kind:ident::$method:ident($($arg:ident: $of:ty),*) $(-> $result:ty)?;)*) => { $(
        #[doc = concat!("[`", stringify!($kind), "::", stringify!($method), "`] of all effects.")]
        #[inline(always)]
        pub(crate) fn $name<G: Turning>($($arg: $of),*) $(-> $result)? {
            of_all_effects!($how Kind => <Kind as $kind<G>>::$method($($arg),*))
        }
    )* };
    (each $effect:ident => $call:expr) => {{
        for_every_effect!($effect => $call);
    }};
    (any $effect:ident => $call:expr) => {{
        let mut is_any = false;
        for_every_effect!($effect => is_any |= $call);
        is_any
    }};
    (sum $effect:ident => $call:expr) => {{
        let mut sum = Default::default();
        for_every_effect!($effect => sum += $call);
        sum
    }};
}

of_all_effects! {
    each act_at: PointWrench::act_at(plan: &Plan<G>, work: &Workspace<G>, point: &Point<G>, state: &mut PointState<G>);
    any is_dead_along: DeadLineWrench::is_dead_along(plan: &Plan<G>, piece: &PiecePlan<G>) -> bool;
    any responds_along: LineResponse::responds_along(piece: &PiecePlan<G>) -> bool;
    any responds_at: PointResponse::responds_at(point: &Point<G>) -> bool;
    each prepare: CoordinateForce::prepare(plan: &Plan<G>, work: &mut Workspace<G>, q: &[f64], qd: &[f64]);
    each push: CoordinateForce::push(plan: &Plan<G>, work: &Workspace<G>, tau: &mut [f64]);
    each stiffen: CoordinateForce::stiffen(
        plan: &Plan<G>, work: &Workspace<G>, memory: &mut TangentWorkspace<G>, weights: Weights, tangent: &mut Tangent<'_>
    );
    any couple_pieces: CoordinateForce::couples_pieces(plan: &Plan<G>) -> bool;
    each add_energy: StoredEnergy::add_energy(plan: &Plan<G>, work: &Workspace<G>, energy: &mut Energy);
    any dissipates: Dissipation::dissipates(plan: &Plan<G>) -> bool;
    any may_dissipate: Dissipation::may_dissipate(plan: &Plan<G>, work: &Workspace<G>) -> bool;
    sum dissipated_power: Dissipation::dissipated_power(plan: &Plan<G>, work: &Workspace<G>) -> f64;
    any drives: Supply::drives(plan: &Plan<G>) -> bool;
    sum supplied_power: Supply::supplied_power(plan: &Plan<G>, work: &Workspace<G>) -> f64;
    any depends_on_velocity: VelocityDependence::depends_on_velocity(plan: &Plan<G>) -> bool;
}

/// The places at which effects need points, and the lists of a point for their indices; `pulled` are the ends of straight parts of
/// tendons.
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

/// Explanations of effects other than loads, fluid and actuators.
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
        plan.instructions.run_outlined::<G::Pack, _>(sweep);
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
        plan.instructions.run_outlined::<G::Pack, _>(sweep);
    });
}

/// Whether anything responds anywhere.
pub(crate) fn responds<G: Turning>(plan: &Plan<G>) -> bool {
    plan.points.iter().any(responds_at) || plan.pieces.iter().any(responds_along)
}

/// Whether anything acts along a piece or on coordinates, in any state.
pub(crate) fn act<G: Turning>(plan: &Plan<G>, piece: &PiecePlan<G>) -> bool {
    of_all_effects!(any Kind => {
        let acts_along =
            <Kind as LineWrench<G>>::acts_along(plan, piece) || <Kind as LineResponse<G>>::responds_along(piece);
        acts_along || <Kind as CoordinateForce<G>>::acts(plan)
    })
}
