//! Contact forces between overlapping surfaces, at places that depend on the motion.
//!
//! Such a place along a rod is treated like a point (see `kernel::points`): node l carries the share
//! `u_l / w_l` of the wrench. The tangent is computed entirely in [`CoordinateForce::stiffen`]: let `W` be the wrench
//! that a side requires about its centre, and y the rotation of the side; then the wrench changes by `dW`
//! and, relative to the material, by `-(m x y; f x y)` as a wrench with a fixed direction.

use std::ops::Range;

use crate::model::Energy;
use crate::numerics::lie::{LANES, Lanes, Scalar, Sweep, Twist, Vector, Wrench};
use crate::numerics::linalg::Matrix;
use crate::robot::algebra::tie::Motion;
use crate::robot::effects::contact::shapes::touch::ContactPoint;
use crate::robot::effects::contact::sliding;
use crate::robot::effects::contact::state::{ContactState, ContactTangent, SidePlace, Touch};
use crate::robot::effects::kinds::{
    CoordinateForce, Dissipation, NoDeadLineWrench, NoLineResponse, NoLineWrench, NoSupply,
    NoVelocityDependence, NotAtPoints, PartialWrench, StoredEnergy,
};
use crate::robot::effects::parts::States;
use crate::robot::plan::Plan;
use crate::robot::plan::piece::PiecePlan;
use crate::robot::plan::point::Place;
use crate::robot::state::Workspace;
use crate::robot::state::tangent::{Tangent, TangentWorkspace, Weights};
use crate::robot::turning::{Turning, columns};

/// The contacts of a plan.
pub(crate) struct ContactForces;

/// Finds the contact points in the shape whose kinematics are up to date; with disabled forces there are none. Their rates and forces
/// hold if the motion is up to date, too.
pub(crate) fn find<G: Turning>(plan: &Plan<G>, work: &mut Workspace<G>) {
    if work.effects.contact.is_left {
        work.effects.contact.lay_aside();
        return;
    }
    work.effects.contact.undo_step();
    super::detection::find(plan, work);
}

/// Links the contact points along each piece.
fn link<G: Turning>(plan: &Plan<G>, contact: &mut ContactState<G::Pack>) {
    let ContactState { touches, first_along, next_along, .. } = contact;
    first_along.fill(None);
    if next_along.len() < 2 * touches.len() {
        next_along.resize(2 * touches.len(), None);
    }
    for (t, touch) in touches.iter().enumerate().rev() {
        for (s, side_place) in touch.sides.iter().enumerate().rev() {
            let SidePlace::Along { curve, .. } = *side_place else { continue };
            let first = &mut first_along[plan.pieces[plan.effects.contacts.curves[curve].piece].first_pack];
            next_along[2 * t + s] = first.replace(2 * t + s);
        }
    }
}

/// Adds the wrenches required at the contact points along a piece to the internal wrench at its nodes; returns their sum.
#[inline(always)]
pub(crate) fn carry<G: Turning>(
    plan: &Plan<G>,
    piece: &PiecePlan<G>,
    work: &mut Workspace<G>,
) -> Wrench<G, f64> {
    let mut sum = Wrench::zero();
    if work.effects.contact.touches.is_empty() {
        return sum;
    }
    let Workspace { effects: States { contact, .. }, internal, .. } = work;
    let mut next = contact.first_along[piece.first_pack];
    while let Some(place) = next {
        let (t, s) = (place / 2, place % 2);
        let touch = &contact.touches[t];
        if let SidePlace::Along { curve, .. } = touch.sides[s] {
            let need = touch.needs::<G>(plan.frame)[s];
            sum += need;
            let need = need.splat();
            let inverse_weights = &plan.effects.contacts.curves[curve].inverse_weights;
            let shares = contact.reach(plan.effects.contacts.packs, t, s).iter().zip(inverse_weights);
            for (internal, (&up_to, &inverse_weight)) in internal[piece.node_packs()].iter_mut().zip(shares) {
                *internal += need * (up_to * inverse_weight);
            }
        }
        next = contact.next_along[place];
    }
    sum
}

/// Fraction of a contact point's force that acts beyond a cut through one side, at this distance from its place in metres.
fn beyond_cut<G: Turning>(plan: &Plan<G>, work: &Workspace<G>, touch: &Touch, s: usize, cut: f64) -> f64 {
    let at_once = if cut <= 0.0 { 1.0 } else { 0.0 };
    let Some(share) = touch.share else { return at_once };
    if s == 0 {
        return share.beyond(cut);
    }
    // On the other rod, contact extends along the projection of the first one.
    let [Some(first), Some(second)] = touch.sides.map(|side| direction(plan, work, side)) else {
        return at_once;
    };
    let cosine = first.dot(second);
    if cosine == 0.0 {
        return at_once;
    }
    let part = share.beyond(cut / cosine);
    if cosine > 0.0 { part } else { 1.0 - part }
}

/// Direction of a rod at the node nearest to a contact point.
fn direction<G: Turning>(plan: &Plan<G>, work: &Workspace<G>, side: SidePlace) -> Option<Vector<f64>> {
    let SidePlace::Along { curve, x } = side else { return None };
    let piece = &plan.pieces[plan.effects.contacts.curves[curve].piece];
    let away = |node: &usize| (piece.gauss.nodes[*node] - x).abs();
    let node = (0..piece.gauss.nodes.len()).min_by(|a, b| away(a).total_cmp(&away(b)))?;
    let slope = work.slope[piece.first_pack + node / LANES];
    let slope = G::in_space(plan.frame, G::map_vector(&slope, |pack: &G::Pack| pack.lane(node % LANES)));
    Some(slope * slope.dot(slope).sqrt().recip())
}

impl<G: Turning> PartialWrench<G> for ContactForces {
    /// Contact points along a rod are not part of the nodal integrals: they act like points, or by their shares of a distributed
    /// force.
    fn beyond(plan: &Plan<G>, piece: &PiecePlan<G>, work: &Workspace<G>, place: &Place) -> Wrench<G, f64> {
        let mut sum = Wrench::zero();
        let contact = &work.effects.contact;
        if contact.touches.is_empty() || piece.packs == 0 {
            return sum;
        }
        let mut next = contact.first_along[piece.first_pack];
        while let Some(at) = next {
            let (touch, s) = (&contact.touches[at / 2], at % 2);
            if let SidePlace::Along { curve, x } = touch.sides[s] {
                let cut = (place.x - x) * plan.effects.contacts.curves[curve].length;
                sum = sum.add_scaled(touch.needs::<G>(plan.frame)[s], beyond_cut(plan, work, touch, s, cut));
            }
            next = contact.next_along[at];
        }
        sum
    }
}

impl<G: Turning> CoordinateForce<G> for ContactForces {
    fn acts(plan: &Plan<G>) -> bool {
        !plan.effects.contacts.pairs.is_empty()
    }

    #[inline(always)]
    fn prepare(plan: &Plan<G>, work: &mut Workspace<G>, _: &[f64], _: &[f64]) {
        if plan.effects.contacts.pairs.is_empty() {
            return;
        }
        find(plan, work);
        if work.effects.contact.is_left {
            return;
        }
        link(plan, &mut work.effects.contact);
        for touch in &work.effects.contact.touches {
            for (side_place, need) in touch.sides.iter().zip(touch.needs::<G>(plan.frame)) {
                if let SidePlace::On(fixture) = *side_place
                    && let Some(point) = plan.effects.contacts.fixtures[fixture].point
                {
                    work.points[point].force += need;
                }
            }
        }
    }

    /// Nothing: [`carry`] adds its wrenches to the pieces.
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
        // Robots whose effects couple branches use the dense solver.
        let Tangent::Dense(matrix) = tangent else { return };
        if weights.is_mass_only {
            return;
        }
        super::follow::follow(&work.effects.contact.touches, &mut memory.effects.contact.followed);
        memory.effects.contact.is_known.fill(false);
        memory.effects.contact.columns_of = [None; 2];
        let mut first = 0;
        for group in work.effects.contact.touches.chunk_by(|a, b| a.pair == b.pair) {
            let touches = first..first + group.len();
            first = touches.end;
            let sweep = Stiffen { plan, work, memory: &mut memory.effects.contact, weights, matrix, touches };
            plan.instructions.run_outlined::<G::Pack, _>(sweep);
        }
    }

    fn couples_pieces(plan: &Plan<G>) -> bool {
        !plan.effects.contacts.pairs.is_empty()
    }
}

impl<G: Turning> StoredEnergy<G> for ContactForces {
    fn add_energy(_: &Plan<G>, work: &Workspace<G>, energy: &mut Energy) {
        energy.elastic += super::query::overlap_energy(work);
    }
}

impl<G: Turning> Dissipation<G> for ContactForces {
    fn dissipates(plan: &Plan<G>) -> bool {
        let mut laws = plan.effects.contacts.pairs.iter().map(|pair| &pair.law);
        laws.any(|law| law.dissipation > 0.0 || law.friction != [0.0; 3])
    }

    fn may_dissipate(plan: &Plan<G>, work: &Workspace<G>) -> bool {
        <Self as Dissipation<G>>::dissipates(plan) && may_touch(&work.effects.contact)
    }

    fn dissipated_power(_: &Plan<G>, work: &Workspace<G>) -> f64 {
        work.effects.contact.touches.iter().map(|touch| touch.contact_force.dissipated_power()).sum()
    }
}

impl NotAtPoints for ContactForces {}
impl NoLineWrench for ContactForces {}
impl NoDeadLineWrench for ContactForces {}
impl NoLineResponse for ContactForces {}
impl NoSupply for ContactForces {}
impl NoVelocityDependence for ContactForces {}

/// Whether surfaces may touch in the shape evaluated last.
pub(crate) fn may_touch<P>(contact: &ContactState<P>) -> bool {
    contact.is_rigid_near || contact.is_near.contains(&true)
}

/// Adds the derivative of the forces at the contact points of a pair. Cost: 6 products for each entry and side that its row moves.
struct Stiffen<'a, G: Turning> {
    plan: &'a Plan<G>,
    work: &'a Workspace<G>,
    memory: &'a mut ContactTangent<G>,
    weights: Weights,
    matrix: &'a mut Matrix,
    touches: Range<usize>,
}

/// Displacement of the centre of a side per unit of a coordinate, and the change of its motion, from the twist Psi there and
/// `int ad_V S` (see `line::changes`).
#[inline(always)]
fn changes<G: Turning>(
    plan: &Plan<G>,
    centre: Vector<f64>,
    velocity: Twist<G, f64>,
    [psi, psi_rate]: [Twist<G, f64>; 2],
) -> [Motion; 2] {
    let at = |twist: Twist<G, f64>| {
        let angular = G::axial_in_space(plan.frame, twist.angular);
        [angular, G::in_space(plan.frame, twist.linear) + angular.cross(centre)]
    };
    let moved = at(psi);
    let mut change = at(psi.bracket(velocity) + psi_rate);
    change[1] += G::axial_in_space(plan.frame, velocity.angular).cross(moved[1]);
    [moved, change]
}

impl<G: Turning> Sweep for Stiffen<'_, G> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Self { plan, work, memory, weights, matrix, touches } = self;
        let reaches = &plan.effects.contacts.pairs[work.effects.contact.touches[touches.start].pair].reaches;
        clear(&mut memory.moved, reaches);
        clear(&mut memory.faster, reaches);
        for t in touches {
            write_motions(plan, work, memory, reaches, t);
            write_answers(plan, work, memory, weights, reaches, t);
            if memory.products.are_full() {
                memory.products.add_to(reaches, matrix);
            }
        }
        memory.products.add_to(reaches, matrix);
    }
}

/// Sets the components of motions to zero for these coordinates.
#[inline(always)]
fn clear(motions: &mut [Vec<f64>], reaches: &[Range<usize>]) {
    for component in motions {
        for rows in reaches {
            component[rows.clone()].fill(0.0);
        }
    }
}

/// Writes the motions of both sides of a contact point per unit coordinate. They are zero, or those of another point of the same pair.
#[inline(always)]
fn write_motions<G: Turning>(
    plan: &Plan<G>,
    work: &Workspace<G>,
    memory: &mut ContactTangent<G>,
    reaches: &[Range<usize>],
    t: usize,
) {
    let touch = &work.effects.contact.touches[t];
    let ContactTangent { is_known, firsts, at_nodes, moved, faster, columns, columns_of, .. } = memory;
    for (s, side_place) in touch.sides.iter().enumerate() {
        let centre = touch.centres[s];
        let (velocity, moved_by, reach, curve) = match *side_place {
            SidePlace::AtRest => continue,
            SidePlace::On(fixture) => {
                let fixture = &plan.effects.contacts.fixtures[fixture];
                let Some(point) = fixture.point else { continue };
                (work.points[point].velocity, fixture.moved_by.as_slice(), None, None)
            }
            SidePlace::Along { curve: c, .. } => {
                let curve = &plan.effects.contacts.curves[c];
                let piece = &plan.pieces[curve.piece];
                let reach = &work.effects.contact.reach(plan.effects.contacts.packs, t, s)[..piece.packs];
                let mut velocity = Twist::zero();
                for (&weight, &rate) in reach.iter().zip(&work.rate[piece.node_packs()]) {
                    velocity += rate * weight;
                }
                let velocity = work.stations[piece.joined.begin].velocity + velocity.sum();
                (velocity, curve.moved_by.as_slice(), Some((curve.piece, reach)), Some(c))
            }
        };
        // What is beyond its own piece is the same at all places of a curve.
        let is_same_curve = curve.is_some() && columns_of[s] == curve;
        columns_of[s] = curve;
        if !is_same_curve {
            // Other coordinates may move this curve than the last one.
            clear(&mut moved[6 * s..][..6], reaches);
            clear(&mut faster[6 * s..][..6], reaches);
        }
        for (p, weights) in moved_by {
            let piece = &plan.pieces[*p];
            let columns = &mut columns[s][piece.coordinates()];
            let own = reach.filter(|(own, _)| own == p);
            if own.is_some() || !is_same_curve {
                let at_nodes = &mut at_nodes[firsts[*p]..firsts[*p + 1]];
                if !std::mem::replace(&mut is_known[*p], true) {
                    columns::write_at_nodes(piece, work, at_nodes);
                }
                let weights = own.map_or(&weights[..], |(_, reach)| reach);
                columns::write_columns(work, piece, weights, at_nodes, columns);
            }
            for (k, column) in piece.coordinates().zip(columns) {
                let [displacement, change] = changes(plan, centre, velocity, *column);
                for (motions, motion) in [(&mut *moved, displacement), (&mut *faster, change)] {
                    for (component, x) in motions[6 * s..][..6].iter_mut().zip(six(motion)) {
                        component[k] = x;
                    }
                }
            }
        }
    }
}

/// Writes the changes of the wrenches of both sides for these motions, and notes the products with them.
#[inline(always)]
fn write_answers<G: Turning>(
    plan: &Plan<G>,
    work: &Workspace<G>,
    memory: &mut ContactTangent<G>,
    weights: Weights,
    reaches: &[Range<usize>],
    t: usize,
) {
    let touch = &work.effects.contact.touches[t];
    let ContactTangent { moved, faster, answers, followed, rows, products, .. } = memory;
    let linearised = followed.now[t].linearised;
    let sliding = sliding::find(plan, work, touch, linearised, rows);
    let contact_point = sliding.as_ref().map_or(&touch.contact_point, |sliding| &sliding.contact_point);
    if let Some(sliding) = &sliding {
        sliding.write(reaches, weights.q, moved, &mut rows.slides);
    }
    for reach in reaches {
        // The last pack may contain coordinates behind the range: their results are not used, or computed later.
        for first in reach.clone().step_by(LANES) {
            let motions = [motions::<G::Pack>(moved, first), motions(faster, first)];
            let mut answered = answer(touch, contact_point, linearised, weights, motions);
            if let Some(sliding) = &sliding {
                sliding.add_answers(pack(&rows.slides, first), &mut answered);
            }
            for (s, &motion) in answered.iter().enumerate() {
                for (component, x) in answers[6 * s..][..6].iter_mut().zip(six(motion)) {
                    // One check of the bounds for the whole pack.
                    let to = &mut component[first..].as_chunks_mut::<LANES>().0[0];
                    for (lane, to) in to.iter_mut().enumerate() {
                        *to = x.lane(lane);
                    }
                }
            }
        }
    }
    for (s, side_place) in touch.sides.iter().enumerate() {
        if *side_place != SidePlace::AtRest {
            for (moved, answer) in moved[6 * s..][..6].iter().zip(&answers[6 * s..]) {
                products.push(s, reaches, moved, answer);
            }
        }
    }
    if sliding.is_some() {
        // The changing shares of the nodes of the second side.
        products.push(1, reaches, &rows.shares, &rows.slides);
    }
}

/// The motions of both sides for a pack of coordinates.
#[inline(always)]
fn motions<P: Lanes>(components: &[Vec<f64>; 12], first: usize) -> [Motion<P>; 2] {
    let [of_first, of_second] = components.as_chunks::<6>().0 else { unreachable!("twelve are twice six") };
    [motion(of_first, first), motion(of_second, first)]
}

/// The motion of one side.
#[inline(always)]
fn motion<P: Lanes>([a, b, c, d, e, f]: &[Vec<f64>; 6], first: usize) -> Motion<P> {
    [
        Vector::new(pack(a, first), pack(b, first), pack(c, first)),
        Vector::new(pack(d, first), pack(e, first), pack(f, first)),
    ]
}

#[inline(always)]
fn pack<P: Lanes>(numbers: &[f64], first: usize) -> P {
    P::from_lanes(numbers[first..].as_chunks().0[0])
}

/// Changes of the required wrenches of both sides, about their centres, for displacements and changes of their motion.
#[inline(always)]
fn answer<T: Scalar>(
    touch: &Touch,
    contact_point: &ContactPoint,
    friction_ratio: Vector<f64>,
    weights: Weights,
    [moved, faster]: [[Motion<T>; 2]; 2],
) -> [Motion<T>; 2] {
    let [q, v] = [T::splat(weights.q), T::splat(weights.v)];
    // Written out: `array::map` and `from_fn` are not always inlined, and took a fifth of the time of a pile.
    let [first, second] = [scaled(moved[0], q), scaled(moved[1], q)];
    let rates = [rate(moved[0], faster[0], [q, v]), rate(moved[1], faster[1], [q, v])];
    let change = contact_point.change(&touch.contact_force, friction_ratio, [first, second], rates);
    let wrenches = contact_point.wrenches(&touch.contact_force);
    [answered(change[0], wrenches[0], first[0]), answered(change[1], wrenches[1], second[0])]
}

#[inline(always)]
fn scaled<T: Scalar>([turn, shift]: Motion<T>, q: T) -> Motion<T> {
    [turn * q, shift * q]
}

#[inline(always)]
fn rate<T: Scalar>([turn, shift]: Motion<T>, [spin, velocity]: Motion<T>, [q, v]: [T; 2]) -> Motion<T> {
    [turn * v + spin * q, shift * v + velocity * q]
}

/// Change of a side's required wrench relative to its material, from the change of the wrench and the rotation.
#[inline(always)]
fn answered<T: Scalar>([moment, force]: Motion<T>, wrench: Motion, turn: Vector<T>) -> Motion<T> {
    [-Vector::all(wrench[0]).cross_add(turn, moment), -Vector::all(wrench[1]).cross_add(turn, force)]
}

/// The components of a motion or a wrench.
#[inline(always)]
fn six<T: Scalar>([angular, linear]: Motion<T>) -> [T; 6] {
    [angular.x, angular.y, angular.z, linear.x, linear.y, linear.z]
}
