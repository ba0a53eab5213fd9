//! The exact tangent of the inverse dynamics, all columns in one sweep.
//!
//! For a variation of coordinate k by (dq, dqd, dqdd) = (w_q, w_v, w_a), let Y = dV - ad_Psi V and
//! Z = dA - ad_Psi A + ad_V Y be the variations of velocity and acceleration as the moving material sees them. Then the
//! tangent of design section 4 collapses to integrals over the segment of coordinate k alone:
//!
//! ```text
//! Y' = w_v S + w_q ad_V S
//! Z' = w_a S + 2 w_v ad_V S + w_q (ad_A + ad_V ad_V) S
//! H' = -(N Z + C Y) + w_q ad_S^T F          with C Y = -(N ad_V + ad_V^T N) Y - ad_Y^T N V
//! dtau_j = int S_j . H + (w_q K + w_v D)_jk
//! ```
//!
//! With `Psi = int S` of one coordinate, `Psi' = int ad_V S` and `Psi'' = int (ad_A + ad_V ad_V) S`, all from the base of its
//! segment, Y and Z are sums of these three, and by summation by parts (exact for this quadrature)
//! `int S_j . H = Psi_j . H_end + int Psi_j . (N Z + C Y - w_q ad_S^T F)`.
//!
//! Outside its own segment a coordinate's Y and Z are constant; its H is constant before the segment, and linear in (Y, Z)
//! behind it: the blocks between different segments have rank 15 at most and cost a few products an entry. How far the
//! material turns appears only where a dead load at the tip asks for it.

use super::inertia::{self, Inertia};
use super::plan::{Plan, SegmentPlan};
use super::workspace::Workspace;
use crate::lie::{Pack, Scalar, Twist, Vector, Wrench, weighted_sum};
use crate::linalg::Matrix;

/// What the rest of the rod, from a place to the tip, answers to variations that are constant along it: `N Z + C Y` with
/// N and C as six columns each.
#[derive(Clone, Copy, Debug)]
struct Rest {
    inertia: [Wrench<f64>; 6],
    gyroscopic: [Wrench<f64>; 6],
}

impl Rest {
    const NOTHING: Self = {
        let zero = Vector { x: 0.0, y: 0.0, z: 0.0 };
        let zero = Wrench { moment: zero, force: zero };
        Self { inertia: [zero; 6], gyroscopic: [zero; 6] }
    };

    fn wrench(&self, z: Twist<f64>, y: Twist<f64>) -> Wrench<f64> {
        apply(&self.inertia, z) + apply(&self.gyroscopic, y)
    }

    /// Adds a body (a pack of nodes, or a single one) that moves with `velocity`.
    fn add(&mut self, mut body: impl FnMut(Twist<f64>) -> (Wrench<f64>, Wrench<f64>)) {
        for i in 0..6 {
            let mut unit = [0.0; 6];
            unit[i] = 1.0;
            let (inertia, gyroscopic) = body(Twist::from_array(unit));
            self.inertia[i] += inertia;
            self.gyroscopic[i] += gyroscopic;
        }
    }
}

#[inline(always)]
fn apply(columns: &[Wrench<f64>; 6], twist: Twist<f64>) -> Wrench<f64> {
    columns.iter().zip(twist.to_array()).fold(Wrench::zero(), |sum, (&column, factor)| sum + column * factor)
}

#[inline(always)]
fn apply_transposed(columns: &[Wrench<f64>; 6], twist: Twist<f64>) -> Wrench<f64> {
    Wrench::from_array(columns.map(|column| twist.dot(column)))
}

/// What is left of a coordinate outside its own segment.
#[derive(Clone, Copy, Debug)]
struct Coordinate {
    /// `int S_j` over the segment.
    shape: Twist<f64>,
    /// As a column: Y, Z and the turn of all that lies behind the segment; H of all that lies before it.
    y: Twist<f64>,
    z: Twist<f64>,
    turn: Vector<f64>,
    before: Wrench<f64>,
    /// H at the end of its own segment.
    end: Wrench<f64>,
    /// As a row: products with Z, Y and turn of the coordinates of earlier segments.
    row_z: Wrench<f64>,
    row_y: Wrench<f64>,
    row_turn: Vector<f64>,
}

impl Coordinate {
    const ZERO: Self = {
        let zero = Vector { x: 0.0, y: 0.0, z: 0.0 };
        let twist = Twist { angular: zero, linear: zero };
        let wrench = Wrench { moment: zero, force: zero };
        Self {
            shape: twist,
            y: twist,
            z: twist,
            turn: zero,
            before: wrench,
            end: wrench,
            row_z: wrench,
            row_y: wrench,
            row_turn: zero,
        }
    };
}

/// Memory of the tangent: blocks of one segment at a time, and what is left of every coordinate.
#[derive(Clone, Debug)]
pub(super) struct TangentWorkspace {
    coordinates: Vec<Coordinate>,
    /// Per component of the segment and pack: S, ad_V S, (ad_A + ad_V ad_V) S and ad_S^T F of a unit strain.
    shape: Vec<Twist<Pack>>,
    shape_rate: Vec<Twist<Pack>>,
    shape_acceleration: Vec<Twist<Pack>>,
    load: Vec<Wrench<Pack>>,
    /// Per pack, for the column at hand.
    integrand: Vec<Twist<Pack>>,
    /// Per coordinate of the segment and pack: Psi, and the weighted change of the force.
    psi: Vec<Twist<Pack>>,
    source: Vec<Wrench<Pack>>,
}

impl TangentWorkspace {
    pub(super) fn new(plan: &Plan) -> Self {
        let largest = |size: fn(&SegmentPlan) -> usize| plan.segments.iter().map(size).max().unwrap_or(0);
        let packs = largest(|segment| segment.packs);
        let blocks = largest(|segment| segment.packs * segment.components.len());
        let columns = largest(|segment| segment.packs * segment.n);
        Self {
            coordinates: vec![Coordinate::ZERO; plan.n],
            shape: vec![Twist::zero(); blocks],
            shape_rate: vec![Twist::zero(); blocks],
            shape_acceleration: vec![Twist::zero(); blocks],
            load: vec![Wrench::zero(); blocks],
            integrand: vec![Twist::zero(); packs],
            psi: vec![Twist::zero(); columns],
            source: vec![Wrench::zero(); columns],
        }
    }
}

/// The weights of a tangent, with what they make unnecessary.
#[derive(Clone, Copy, Debug)]
struct Weights {
    q: f64,
    v: f64,
    a: f64,
    /// The mass matrix alone: Y and the loads vanish.
    is_mass_only: bool,
}

/// `w_q dtau/dq + w_v dtau/dqd + w_a dtau/dqdd` with the motion up to date (for the mass matrix, weights (0, 0, w_a), the
/// kinematics are enough).
#[inline(always)]
pub(super) fn weighted_tangent(
    plan: &Plan,
    work: &Workspace,
    memory: &mut TangentWorkspace,
    weights: [f64; 3],
    tangent: &mut Matrix,
) {
    let [q, v, a] = weights;
    let weights = Weights { q, v, a, is_mass_only: q == 0.0 && v == 0.0 };
    let mut rest = tip(plan, work, weights);
    for (s, segment) in plan.segments.iter().enumerate().rev() {
        pointwise(segment, work, memory, weights);
        for (c, component) in segment.components.iter().enumerate() {
            for degree in 0..component.modes {
                column(plan, segment, work, memory, weights, &rest, (c, degree), s > 0);
            }
        }
        block(segment, memory, tangent);
        elasticity(segment, weights, tangent);
        if s > 0 {
            add_segment(segment, work, weights, &mut rest);
        }
    }
    couple(plan, memory, tangent);
}

/// The mass at the tip.
#[inline(always)]
fn tip(plan: &Plan, work: &Workspace, weights: Weights) -> Rest {
    let mut rest = Rest::NOTHING;
    if plan.tip_mass > 0.0 {
        let body = inertia::of_tip(plan, work);
        let velocity = work.stations[plan.segments.len()].velocity;
        rest.add(|unit| answer(&body, velocity, weights, unit));
    }
    rest
}

#[inline(always)]
fn answer<T: Scalar>(
    body: &Inertia<T>,
    velocity: Twist<T>,
    weights: Weights,
    unit: Twist<T>,
) -> (Wrench<T>, Wrench<T>) {
    let gyroscopic = if weights.is_mass_only {
        Wrench::zero()
    } else {
        body.gyroscopic(velocity, body.momentum(velocity), unit)
    };
    (body.momentum(unit), gyroscopic)
}

#[inline(always)]
fn add_segment(segment: &SegmentPlan, work: &Workspace, weights: Weights, rest: &mut Rest) {
    for pack in 0..segment.packs {
        let body = inertia::of_nodes(segment, work, pack);
        let velocity = work.velocity[segment.first_pack + pack];
        rest.add(|unit| {
            let (inertia, gyroscopic) = answer(&body, velocity, weights, unit.splat());
            ((inertia * segment.weights[pack]).sum(), (gyroscopic * segment.weights[pack]).sum())
        });
    }
}

/// S, ad_V S, (ad_A + ad_V ad_V) S and ad_S^T F of a unit of each strain component at all nodes.
#[inline(always)]
fn pointwise(segment: &SegmentPlan, work: &Workspace, memory: &mut TangentWorkspace, weights: Weights) {
    for (c, component) in segment.components.iter().enumerate() {
        for pack in 0..segment.packs {
            let node = segment.first_pack + pack;
            let axis = work.rotation[node].axis(component.strain % 3);
            let shape = if component.strain < 3 {
                Twist { angular: axis, linear: work.position[node].cross(axis) }
            } else {
                Twist { angular: Vector::zero(), linear: axis }
            };
            let block = c * segment.packs + pack;
            memory.shape[block] = shape;
            if !weights.is_mass_only {
                let velocity = work.velocity[node];
                let rate = velocity.bracket(shape);
                memory.shape_rate[block] = rate;
                memory.shape_acceleration[block] =
                    work.acceleration[node].bracket(shape) + velocity.bracket(rate);
                memory.load[block] = shape.bracket_transposed(work.internal[node]) * Pack::splat(weights.q);
            }
        }
    }
}

/// The coordinate (component, degree): Psi and the weighted change of the force at the nodes, and what is left of it
/// outside its segment.
#[allow(clippy::too_many_arguments, reason = "one sweep, its inputs named one by one")]
#[inline(always)]
fn column(
    plan: &Plan,
    segment: &SegmentPlan,
    work: &Workspace,
    memory: &mut TangentWorkspace,
    weights: Weights,
    rest: &Rest,
    (c, degree): (usize, usize),
    has_earlier_segments: bool,
) {
    let packs = segment.packs;
    let k = segment.components[c].first + degree;
    let blocks = c * packs..(c + 1) * packs;
    let columns = (k - segment.first) * packs..(k - segment.first + 1) * packs;
    let basis = &segment.basis[degree * packs..(degree + 1) * packs];
    let [w_q, w_v, w_a] = [weights.q, weights.v, weights.a].map(Pack::splat);
    let psi = &mut memory.psi[columns.clone()];
    let source = &mut memory.source[columns];
    let integrand = &mut memory.integrand[..packs];

    let shape =
        integral(segment, basis, &memory.shape[blocks.clone()], integrand, |pack, value| psi[pack] = value);
    let (mut y, mut z) = (Twist::zero(), shape * weights.a);
    if weights.is_mass_only {
        for pack in 0..packs {
            source[pack] = inertia::of_nodes(segment, work, pack).momentum(psi[pack] * w_a);
        }
    } else {
        // Y and Z stand in `source` until both are there.
        let rate = integral(segment, basis, &memory.shape_rate[blocks.clone()], integrand, |pack, value| {
            source[pack] = Wrench { moment: value.angular, force: value.linear };
        });
        y = shape * weights.v + rate * weights.q;
        z += rate * (2.0 * weights.v);
        let load = &memory.load[blocks.clone()];
        z += integral(segment, basis, &memory.shape_acceleration[blocks], integrand, |pack, value| {
            let node = segment.first_pack + pack;
            let rate = Twist { angular: source[pack].moment, linear: source[pack].force };
            let y = psi[pack] * w_v + rate * w_q;
            let z = psi[pack] * w_a + rate * (w_v + w_v) + value * w_q;
            let body = inertia::of_nodes(segment, work, pack);
            source[pack] = body.momentum(z) + body.gyroscopic(work.velocity[node], work.momentum[node], y)
                - load[pack] * basis[pack];
        }) * weights.q;
    }
    let mut total = Wrench::zero();
    for pack in 0..packs {
        source[pack] = source[pack] * segment.weights[pack];
        total += source[pack];
    }

    let turn = shape.angular * weights.q;
    let mut end = rest.wrench(z, y);
    if plan.has_tip_load && !weights.is_mass_only {
        end += dead_load_response(plan, work, turn);
    }
    let mut coordinate = Coordinate { shape, y, z, turn, end, before: end + total.sum(), ..Coordinate::ZERO };
    if has_earlier_segments {
        row(plan, segment, work, weights, rest, psi, &mut coordinate);
    }
    memory.coordinates[k] = coordinate;
}

/// Integrals of `basis * values` up to the nodes, given pack by pack to `store`; returns the whole integral.
#[inline(always)]
fn integral(
    segment: &SegmentPlan,
    basis: &[Pack],
    values: &[Twist<Pack>],
    integrand: &mut [Twist<Pack>],
    mut store: impl FnMut(usize, Twist<Pack>),
) -> Twist<f64> {
    let mut total = Twist::zero();
    for (pack, integrand) in integrand.iter_mut().enumerate() {
        *integrand = values[pack] * basis[pack];
        total += *integrand * segment.weights[pack];
    }
    for pack in 0..segment.packs {
        store(pack, weighted_sum(Twist::zero(), segment.row(&segment.from_base, pack), integrand));
    }
    total.sum()
}

/// H that a dead load at the tip leaves when everything behind the segment turns by `turn`.
#[inline(always)]
fn dead_load_response(plan: &Plan, work: &Workspace, turn: Vector<f64>) -> Wrench<f64> {
    let tip = work.stations[plan.segments.len()].position;
    let force = plan.tip_force.cross(turn);
    -Wrench { moment: tip.cross(force) + plan.tip_moment.cross(turn), force }
}

/// The block of the segment: `Psi_j . H_end + int Psi_j . source`.
#[inline(always)]
fn block(segment: &SegmentPlan, memory: &TangentWorkspace, tangent: &mut Matrix) {
    let own = segment.first..segment.first + segment.n;
    for k in own.clone() {
        let end = memory.coordinates[k].end;
        let source = &memory.source[(k - segment.first) * segment.packs..][..segment.packs];
        let mut column = tangent.column_mut(k);
        let entries = &mut column.as_mut_slice()[own.clone()];
        for (j, (entry, row)) in entries.iter_mut().zip(&memory.coordinates[own.clone()]).enumerate() {
            let psi = &memory.psi[j * segment.packs..][..segment.packs];
            let mut sum = Pack::ZERO;
            for (psi, source) in psi.iter().zip(source) {
                sum += psi.dot(*source);
            }
            *entry = row.shape.dot(end) + sum.sum();
        }
    }
}

/// What the row of a coordinate multiplies in the columns of earlier segments: the transposes of `N Z + C Y` and of the
/// dead load, summed from the places where its S acts to the tip.
#[inline(always)]
fn row(
    plan: &Plan,
    segment: &SegmentPlan,
    work: &Workspace,
    weights: Weights,
    rest: &Rest,
    psi: &[Twist<Pack>],
    coordinate: &mut Coordinate,
) {
    let (mut row_z, mut row_y) = (Wrench::<Pack>::zero(), Wrench::<Pack>::zero());
    for (pack, &psi) in psi.iter().enumerate() {
        let node = segment.first_pack + pack;
        let body = inertia::of_nodes(segment, work, pack);
        row_z += body.momentum(psi) * segment.weights[pack];
        if !weights.is_mass_only {
            let transposed = body.gyroscopic_transposed(work.velocity[node], work.momentum[node], psi);
            row_y += transposed * segment.weights[pack];
        }
    }
    let shape = coordinate.shape;
    coordinate.row_z = row_z.sum() + apply_transposed(&rest.inertia, shape);
    coordinate.row_y = row_y.sum() + apply_transposed(&rest.gyroscopic, shape);
    if plan.has_tip_load {
        let tip = work.stations[plan.segments.len()].position;
        let motion = shape.angular.cross(tip) + shape.linear;
        coordinate.row_turn = -(motion.cross(plan.tip_force) + shape.angular.cross(plan.tip_moment));
    }
}

/// Adds `w_q K + w_v D`.
#[inline(always)]
fn elasticity(segment: &SegmentPlan, weights: Weights, tangent: &mut Matrix) {
    let factor = weights.q + weights.v * segment.retardation_time;
    if factor == 0.0 {
        return;
    }
    for component in &segment.components {
        for k in 0..component.modes {
            for j in 0..component.modes {
                tangent[(component.first + j, component.first + k)] += factor * component.stiffness[(j, k)];
            }
        }
    }
}

/// The blocks between different segments.
#[inline(always)]
fn couple(plan: &Plan, memory: &TangentWorkspace, tangent: &mut Matrix) {
    for segment in &plan.segments {
        for k in segment.first..segment.first + segment.n {
            let column = &memory.coordinates[k];
            let mut entries = tangent.column_mut(k);
            let entries = entries.as_mut_slice();
            for (entry, row) in entries[..segment.first].iter_mut().zip(&memory.coordinates) {
                *entry = row.shape.dot(column.before);
            }
            let behind = segment.first + segment.n;
            for (entry, row) in entries[behind..].iter_mut().zip(&memory.coordinates[behind..]) {
                *entry = column.z.dot(row.row_z) + column.y.dot(row.row_y) + column.turn.dot(row.row_turn);
            }
        }
    }
}
