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
//! Outside that segment Y and Z are constant, H is constant before it, and linear in (Y, Z) behind it: the blocks
//! between different segments have rank 15 at most and cost a few products an entry. The Psi of design section 4 appears
//! only where a dead load at the tip asks how far the tip turns.

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

fn apply(columns: &[Wrench<f64>; 6], twist: Twist<f64>) -> Wrench<f64> {
    columns.iter().zip(twist.to_array()).fold(Wrench::zero(), |sum, (&column, factor)| sum + column * factor)
}

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
    /// Per component of the segment and pack: S, Y', Z' and ad_S^T F of a unit strain.
    shape: Vec<Twist<Pack>>,
    y_rate: Vec<Twist<Pack>>,
    z_rate: Vec<Twist<Pack>>,
    load: Vec<Wrench<Pack>>,
    /// Per pack, for the column at hand.
    y_source: Vec<Twist<Pack>>,
    z_source: Vec<Twist<Pack>>,
    source: Vec<Wrench<Pack>>,
    response: Vec<Wrench<Pack>>,
}

impl TangentWorkspace {
    pub(super) fn new(plan: &Plan) -> Self {
        let packs = plan.segments.iter().map(|segment| segment.packs).max().unwrap_or(0);
        let blocks =
            plan.segments.iter().map(|segment| segment.packs * segment.components.len()).max().unwrap_or(0);
        Self {
            coordinates: vec![Coordinate::ZERO; plan.n],
            shape: vec![Twist::zero(); blocks],
            y_rate: vec![Twist::zero(); blocks],
            z_rate: vec![Twist::zero(); blocks],
            load: vec![Wrench::zero(); blocks],
            y_source: vec![Twist::zero(); packs],
            z_source: vec![Twist::zero(); packs],
            source: vec![Wrench::zero(); packs],
            response: vec![Wrench::zero(); packs],
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
                let coordinate = column(plan, segment, work, memory, weights, &rest, c, degree);
                memory.coordinates[component.first + degree] = coordinate;
                project(segment, memory, component.first + degree, tangent);
                if s > 0 {
                    row(plan, segment, work, memory, weights, &rest, c, component.first + degree, degree);
                }
            }
        }
        elasticity(segment, weights, tangent);
        if s > 0 {
            add_segment(segment, work, weights, &mut rest);
        }
    }
    couple(plan, memory, tangent);
}

/// The mass at the tip.
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

/// S, Y', Z' and ad_S^T F of a unit of each strain component at all nodes.
fn pointwise(segment: &SegmentPlan, work: &Workspace, memory: &mut TangentWorkspace, weights: Weights) {
    let [w_q, w_v, w_a] = [weights.q, weights.v, weights.a].map(Pack::splat);
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
            if weights.is_mass_only {
                memory.z_rate[block] = shape * w_a;
                continue;
            }
            let velocity = work.velocity[node];
            let carried = velocity.bracket(shape);
            memory.y_rate[block] = shape * w_v + carried * w_q;
            memory.z_rate[block] = shape * w_a
                + carried * (w_v + w_v)
                + (work.acceleration[node].bracket(shape) + velocity.bracket(carried)) * w_q;
            memory.load[block] = shape.bracket_transposed(work.internal[node]) * w_q;
        }
    }
}

/// Column of coordinate (component c, degree): leaves H at the nodes of the segment in `memory.response`.
#[allow(clippy::too_many_arguments, reason = "one sweep, its inputs named one by one")]
fn column(
    plan: &Plan,
    segment: &SegmentPlan,
    work: &Workspace,
    memory: &mut TangentWorkspace,
    weights: Weights,
    rest: &Rest,
    c: usize,
    degree: usize,
) -> Coordinate {
    let packs = segment.packs;
    let blocks = c * packs..(c + 1) * packs;
    let basis = &segment.basis[degree * packs..(degree + 1) * packs];
    let (shape, y_rate, z_rate, load) = (
        &memory.shape[blocks.clone()],
        &memory.y_rate[blocks.clone()],
        &memory.z_rate[blocks.clone()],
        &memory.load[blocks],
    );
    let (mut shape_sum, mut y_sum, mut z_sum) = (Twist::zero(), Twist::zero(), Twist::zero());
    for pack in 0..packs {
        memory.z_source[pack] = z_rate[pack] * basis[pack];
        shape_sum += shape[pack] * segment.weighted_basis[degree * packs + pack];
        z_sum += memory.z_source[pack] * segment.weights[pack];
        if !weights.is_mass_only {
            memory.y_source[pack] = y_rate[pack] * basis[pack];
            y_sum += memory.y_source[pack] * segment.weights[pack];
        }
    }
    let (shape, y, z) = (shape_sum.sum(), y_sum.sum(), z_sum.sum());
    let turn = shape.angular * weights.q;

    let mut total = Wrench::zero();
    for pack in 0..packs {
        let row = segment.row(&segment.from_base, pack);
        let body = inertia::of_nodes(segment, work, pack);
        let z = weighted_sum(Twist::zero(), row, &memory.z_source[..packs]);
        let mut source = body.momentum(z);
        if !weights.is_mass_only {
            let node = segment.first_pack + pack;
            let y = weighted_sum(Twist::zero(), row, &memory.y_source[..packs]);
            source += body.gyroscopic(work.velocity[node], work.momentum[node], y);
            source = source - load[pack] * basis[pack];
        }
        memory.source[pack] = source;
        total += source * segment.weights[pack];
    }
    let mut end = rest.wrench(z, y);
    if plan.has_tip_load && !weights.is_mass_only {
        end += dead_load_response(plan, work, turn);
    }
    for pack in 0..packs {
        let row = segment.row(&segment.to_end, pack);
        memory.response[pack] = weighted_sum(end.splat(), row, &memory.source[..packs]);
    }
    Coordinate { shape, y, z, turn, before: end + total.sum(), ..Coordinate::ZERO }
}

/// H that a dead load at the tip leaves when everything behind the segment turns by `turn`.
fn dead_load_response(plan: &Plan, work: &Workspace, turn: Vector<f64>) -> Wrench<f64> {
    let tip = work.stations[plan.segments.len()].position;
    let force = plan.tip_force.cross(turn);
    -Wrench { moment: tip.cross(force) + plan.tip_moment.cross(turn), force }
}

/// Column `k` of the block of the segment: `int S_j . H`.
fn project(segment: &SegmentPlan, memory: &TangentWorkspace, k: usize, tangent: &mut Matrix) {
    let packs = segment.packs;
    let mut column = tangent.column_mut(k);
    let entries = &mut column.as_mut_slice()[segment.first..segment.first + segment.n];
    entries.fill(0.0);
    for (c, component) in segment.components.iter().enumerate() {
        let entries = &mut entries[component.first - segment.first..][..component.modes];
        for pack in 0..packs {
            let product = memory.shape[c * packs + pack].dot(memory.response[pack]);
            for (j, entry) in entries.iter_mut().enumerate() {
                *entry += (segment.weighted_basis[j * packs + pack] * product).sum();
            }
        }
    }
}

/// What the row of coordinate `j` multiplies in the columns of earlier segments: the transposes of `N Z + C Y` and of the
/// dead load, summed from the places where S_j acts to the tip.
#[allow(clippy::too_many_arguments, reason = "one sweep, its inputs named one by one")]
fn row(
    plan: &Plan,
    segment: &SegmentPlan,
    work: &Workspace,
    memory: &mut TangentWorkspace,
    weights: Weights,
    rest: &Rest,
    c: usize,
    j: usize,
    degree: usize,
) {
    let packs = segment.packs;
    for pack in 0..packs {
        memory.z_source[pack] = memory.shape[c * packs + pack] * segment.basis[degree * packs + pack];
    }
    let (mut row_z, mut row_y) = (Wrench::<Pack>::zero(), Wrench::<Pack>::zero());
    for pack in 0..packs {
        let node = segment.first_pack + pack;
        let body = inertia::of_nodes(segment, work, pack);
        // Psi_j: by exact summation by parts, w_i to_end_il = w_l from_base_li.
        let psi =
            weighted_sum(Twist::zero(), segment.row(&segment.from_base, pack), &memory.z_source[..packs]);
        row_z += body.momentum(psi) * segment.weights[pack];
        if !weights.is_mass_only {
            let transposed = body.gyroscopic_transposed(work.velocity[node], work.momentum[node], psi);
            row_y += transposed * segment.weights[pack];
        }
    }
    let coordinate = &mut memory.coordinates[j];
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
