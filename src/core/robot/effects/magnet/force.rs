//! Forces on magnets and magnetised segments.
//!
//! A uniform field b exerts the moment `m x b` on a moment m that turns with the material. Such a couple is that of two dead
//! forces, b at m and -b at zero. Fields of magnets differ from place to place ([`law`](super::law)); their forces and those of
//! magnetised segments, node by node, are computed pair by pair once all poses are known. Let y be the rotation of a dipole
//! and W the wrench on it, about its place: the wrench required against it changes by `-(dW - y x W)` relative to the material.

use super::law::{Between, Dipole, Pair};
use super::plan::{ActiveDipole, DipolePlace, MagnetTangent};
use crate::model::Energy;
use crate::numerics::lie::{Cross, Geometry, Lanes, Scalar, Vector, VectorSpace, Wrench};
use crate::robot::algebra::inertia::Gyroscope;
use crate::robot::effects::kinds::{
    CoordinateForce, DeadLineWrench, DeadPointWrench, LineWrench, NoDissipation, NoLineResponse,
    NoPartialWrench, NoPointResponse, NoVelocityDependence, PointWrench, StoredEnergy, Supply,
};
use crate::robot::plan::Plan;
use crate::robot::plan::piece::PiecePlan;
use crate::robot::plan::point::Point;
use crate::robot::state::Workspace;
use crate::robot::state::point::PointState;
use crate::robot::state::tangent::{Tangent, TangentWorkspace, Weights};
use crate::robot::turning::{Turning, columns};

/// The magnets of a plan.
pub(crate) struct Magnets;

/// The uniform field in the axes of the plan, if there is one.
#[inline(always)]
fn field<G: Turning>(plan: &Plan<G>, work: &Workspace<G>) -> Option<G::Vector<f64>> {
    plan.effects.magnets.field.map(|load| work.effects.acting[load].force)
}

/// The field at every node.
#[inline(always)]
fn splat<G: Geometry>(field: G::Vector<f64>) -> G::Vector<G::Pack> {
    G::map_vector(&field, |&x| G::Pack::splat(x))
}

/// The change of a couple `m x b` with rotations.
#[inline(always)]
fn dead<G: Geometry, T: Scalar>(moment: G::Vector<T>, field: G::Vector<T>) -> Gyroscope<G, T> {
    let force = |force| Wrench { moment: VectorSpace::zero(), force };
    let mut sum = Gyroscope::of_dead_load(force(field), moment);
    sum.add(Gyroscope::of_dead_load(force(-field), VectorSpace::zero()));
    sum
}

#[inline(always)]
fn couple<G: Geometry, T: Scalar>(moment: G::Vector<T>, field: G::Vector<T>) -> Wrench<G, T> {
    Wrench { moment: moment.cross(field), force: VectorSpace::zero() }
}

impl<G: Turning> PointWrench<G> for Magnets {
    #[inline(always)]
    fn act_at(plan: &Plan<G>, work: &Workspace<G>, point: &Point<G>, state: &mut PointState<G>) {
        for &magnet in &point.effects.magnets {
            let Some(field) = field(plan, work) else { return };
            let moment = G::rotate(&state.rotation, plan.effects.magnets.fixed[magnet].moment);
            state.force = state.force - couple(moment, field);
        }
    }
}

impl<G: Turning> DeadPointWrench<G> for Magnets {
    #[inline(always)]
    fn dead_at(
        plan: &Plan<G>,
        work: &Workspace<G>,
        point: &Point<G>,
        state: &PointState<G>,
        sum: &mut Gyroscope<G, f64>,
    ) {
        for &magnet in &point.effects.magnets {
            let Some(field) = field(plan, work) else { return };
            sum.add(dead(G::rotate(&state.rotation, plan.effects.magnets.fixed[magnet].moment), field));
        }
    }
}

impl<G: Turning> LineWrench<G> for Magnets {
    #[inline(always)]
    fn acts_along(plan: &Plan<G>, piece: &PiecePlan<G>) -> bool {
        plan.effects.magnets.act_along(piece.first_pack) && piece.packs > 0
    }

    #[inline(always)]
    fn act_along(plan: &Plan<G>, piece: &PiecePlan<G>, work: &mut Workspace<G>) {
        let Some(field) = field(plan, work) else { return };
        for node in piece.node_packs() {
            let moment = G::rotate(&work.rotation[node], plan.effects.magnets.along[node]);
            work.force[node] = work.force[node] - couple(moment, splat::<G>(field));
        }
    }
}

impl<G: Turning> DeadLineWrench<G> for Magnets {
    #[inline(always)]
    fn is_dead_along(plan: &Plan<G>, piece: &PiecePlan<G>) -> bool {
        <Self as LineWrench<G>>::acts_along(plan, piece)
    }

    #[inline(always)]
    fn dead_along(
        plan: &Plan<G>,
        piece: &PiecePlan<G>,
        work: &Workspace<G>,
        sums: &mut [Gyroscope<G, G::Pack>],
    ) {
        if !<Self as LineWrench<G>>::acts_along(plan, piece) {
            return;
        }
        let Some(field) = field(plan, work) else { return };
        for ((node, sum), &weight) in piece.node_packs().zip(sums).zip(&piece.weights) {
            let moment = G::rotate(&work.rotation[node], plan.effects.magnets.along[node]) * weight;
            sum.add(dead(moment, splat::<G>(field)));
        }
    }
}

/// A dipole in the shape.
fn dipole_in_frame<G: Turning>(
    plan: &Plan<G>,
    work: &Workspace<G>,
    active_dipole: &ActiveDipole<G::Pack>,
) -> Dipole {
    let (rotation, position) = match active_dipole.place {
        DipolePlace::Point(point) => (work.points[point].rotation, work.points[point].position),
        DipolePlace::Node { pack, lane, .. } => {
            let at = |entry: &G::Pack| entry.lane(lane);
            (G::map_rotation(&work.rotation[pack], at), G::map_vector(&work.position[pack], at))
        }
    };
    let rotation = G::rotation_in_space(plan.frame, &rotation);
    let Dipole { moment, position: beside } = active_dipole.own;
    Dipole {
        moment: rotation.apply(moment),
        position: G::in_space(plan.frame, position) + rotation.apply(beside),
    }
}

/// Moments about both dipoles of a pair, and forces on them.
#[inline(always)]
fn wrenches(dipoles: [&Dipole; 2], Between { fields, force }: &Between) -> [[Vector<f64>; 2]; 2] {
    let moment = |i: usize| dipoles[i].moment.cross(fields[i]);
    [[moment(0), *force], [moment(1), -*force]]
}

/// Adds the wrench required against this moment about a dipole and this force on it.
fn add_need<G: Turning>(
    plan: &Plan<G>,
    work: &mut Workspace<G>,
    active_dipole: &ActiveDipole<G::Pack>,
    position: Vector<f64>,
    [moment, force]: [Vector<f64>; 2],
) {
    let moment = moment + position.cross(force);
    let mut need: Wrench<G, f64> =
        Wrench { moment: G::axial_of(plan.frame, -moment), force: G::vector_of(plan.frame, -force) };
    match active_dipole.place {
        DipolePlace::Point(point) => work.points[point].force += need,
        DipolePlace::Node { pack, lane, weight } => {
            for index in 0..G::COMPONENTS {
                let more = *need.component_mut(index) / weight;
                let entry = work.force[pack].component_mut(index);
                entry.set_lane(lane, entry.lane(lane) + more);
            }
        }
    }
}

impl<G: Turning> CoordinateForce<G> for Magnets {
    fn acts(plan: &Plan<G>) -> bool {
        !plan.effects.magnets.pairs.is_empty()
    }

    #[inline(always)]
    fn prepare(plan: &Plan<G>, work: &mut Workspace<G>, _: &[f64], _: &[f64]) {
        let active_dipoles = &plan.effects.magnets.active_dipoles;
        for pair in &plan.effects.magnets.pairs {
            let [a, b] = pair.map(|i| dipole_in_frame(plan, work, &active_dipoles[i]));
            let acting = wrenches([&a, &b], &Pair::of([&a, &b]).between());
            for ((&i, dipole), wrench) in pair.iter().zip([a, b]).zip(acting) {
                add_need(plan, work, &active_dipoles[i], dipole.position, wrench);
            }
        }
    }

    /// Nothing: its wrenches are added at points and nodes.
    #[inline(always)]
    fn push(_: &Plan<G>, _: &Workspace<G>, _: &mut [f64]) {}

    #[inline(always)]
    fn stiffen(
        plan: &Plan<G>,
        work: &Workspace<G>,
        memory: &mut TangentWorkspace<G>,
        weights: Weights,
        tangent: &mut Tangent<'_>,
    ) {
        // Robots with magnets that couple branches use the dense solver.
        let Tangent::Dense(matrix) = tangent else { return };
        if plan.effects.magnets.pairs.is_empty() || weights.q == 0.0 {
            return;
        }
        let (n, memory) = (plan.n, &mut memory.effects.magnets);
        evaluate_dipoles(plan, work, memory);
        for k in 0..n {
            answer(plan, memory, k, weights.q);
            let column = &mut matrix.as_mut_slice()[k * n..][..n];
            for (moved, [moment, force]) in memory.moved.chunks_exact(n).zip(&memory.answers) {
                for (entry, [turn, shift]) in column.iter_mut().zip(moved) {
                    *entry += turn.dot(*moment) + shift.dot(*force);
                }
            }
        }
    }

    fn couples_pieces(plan: &Plan<G>) -> bool {
        !plan.effects.magnets.pairs.is_empty()
    }
}

/// Computes the dipoles in a shape, the wrenches on them, and their motion with the coordinates.
fn evaluate_dipoles<G: Turning>(plan: &Plan<G>, work: &Workspace<G>, memory: &mut MagnetTangent) {
    let MagnetTangent { dipoles, wrenches: acting, moved, .. } = memory;
    moved.fill([Vector::zero(); 2]);
    acting.fill([Vector::zero(); 2]);
    for (i, active_dipole) in plan.effects.magnets.active_dipoles.iter().enumerate() {
        dipoles[i] = dipole_in_frame(plan, work, active_dipole);
        let moved = &mut moved[i * plan.n..][..plan.n];
        columns::visit(plan, work, columns::each(&active_dipole.moved_by), |k, [psi, _]| {
            let turn = G::axial_in_space(plan.frame, psi.angular);
            let shift = G::in_space(plan.frame, psi.linear) + turn.cross(dipoles[i].position);
            moved[k] = [turn, shift];
        });
    }
    for &[a, b] in &plan.effects.magnets.pairs {
        let pair = [&dipoles[a], &dipoles[b]];
        for (i, [moment, force]) in [a, b].into_iter().zip(wrenches(pair, &Pair::of(pair).between())) {
            acting[i] = [acting[i][0] + moment, acting[i][1] + force];
        }
    }
}

/// Changes of the required wrenches of all dipoles with a coordinate, about their places.
fn answer<G: Turning>(plan: &Plan<G>, memory: &mut MagnetTangent, k: usize, weight: f64) {
    let MagnetTangent { dipoles, wrenches: acting, moved, answers } = memory;
    let motion = |i: usize| moved[i * plan.n + k].map(|v| v * weight);
    for (i, answer) in answers.iter_mut().enumerate() {
        let [turn, _] = motion(i);
        *answer = acting[i].map(|v| turn.cross(v));
    }
    for &[a, b] in &plan.effects.magnets.pairs {
        let [of_a, of_b] = [motion(a), motion(b)];
        let pair = [&dipoles[a], &dipoles[b]];
        let turned = [of_a[0].cross(pair[0].moment), of_b[0].cross(pair[1].moment)];
        let of_pair = Pair::of(pair);
        let Between { fields, force: _ } = of_pair.between();
        let change = of_pair.change(of_a[1] - of_b[1], turned);
        for (s, i) in [a, b].into_iter().enumerate() {
            let moment = turned[s].cross(fields[s]) + pair[s].moment.cross(change.fields[s]);
            let force = if s == 0 { change.force } else { -change.force };
            answers[i] = [answers[i][0] - moment, answers[i][1] - force];
        }
    }
}

impl<G: Turning> StoredEnergy<G> for Magnets {
    fn add_energy(plan: &Plan<G>, work: &Workspace<G>, energy: &mut Energy) {
        for pair in &plan.effects.magnets.pairs {
            let [a, b] = pair.map(|i| dipole_in_frame(plan, work, &plan.effects.magnets.active_dipoles[i]));
            energy.loads += Pair::of([&a, &b]).energy();
        }
        if let Some(field) = field(plan, work).filter(|_| !<Self as Supply<G>>::drives(plan)) {
            energy.loads += plan.effects.magnets.aside - total(plan, work).dot(field);
        }
    }
}

/// The total magnetic moment.
fn total<G: Turning>(plan: &Plan<G>, work: &Workspace<G>) -> G::Vector<f64> {
    let mut sum = G::Vector::<f64>::zero();
    for fixed in &plan.effects.magnets.fixed {
        sum += G::rotate(&work.points[fixed.point].rotation, fixed.moment);
    }
    for piece in plan.pieces.iter().filter(|piece| <Magnets as LineWrench<G>>::acts_along(plan, piece)) {
        for (node, &weight) in piece.node_packs().zip(&piece.weights) {
            let moment = G::rotate(&work.rotation[node], plan.effects.magnets.along[node]) * weight;
            sum += G::map_vector(&moment, |pack: &G::Pack| pack.sum());
        }
    }
    sum
}

impl<G: Turning> Supply<G> for Magnets {
    fn drives(plan: &Plan<G>) -> bool {
        plan.effects.magnets.field.is_some_and(|load| !plan.effects.loads[load].has_potential)
    }

    /// A field that varies supplies the power of its couples.
    fn supplied_power(plan: &Plan<G>, work: &Workspace<G>) -> f64 {
        let Some(field) = field(plan, work).filter(|_| <Self as Supply<G>>::drives(plan)) else { return 0.0 };
        let mut power = 0.0;
        for fixed in &plan.effects.magnets.fixed {
            let state = &work.points[fixed.point];
            let moment = G::rotate(&state.rotation, fixed.moment);
            power += state.velocity.dot(couple(moment, field));
        }
        for piece in plan.pieces.iter().filter(|piece| <Self as LineWrench<G>>::acts_along(plan, piece)) {
            for (node, &weight) in piece.node_packs().zip(&piece.weights) {
                let moment = G::rotate(&work.rotation[node], plan.effects.magnets.along[node]) * weight;
                power += work.velocity[node].dot(couple(moment, splat::<G>(field))).sum();
            }
        }
        power
    }
}

impl NoPartialWrench for Magnets {}
impl NoPointResponse for Magnets {}
impl NoLineResponse for Magnets {}
impl NoDissipation for Magnets {}
impl NoVelocityDependence for Magnets {}
