//! The exact tangent of the inverse dynamics, all columns in one sweep.
//!
//! For a variation of coordinate k by (dq, dqd, dqdd) = (w_q, w_v, w_a), let Y = dV - ad_Psi V and
//! Z = dA - ad_Psi A + ad_V Y be the variations of velocity and acceleration as the moving material sees them. Then the
//! tangent (`docs/rod.md`) collapses to integrals over the piece of coordinate k alone:
//!
//! ```text
//! Y' = w_v S + w_q ad_V S
//! Z' = w_a S + 2 w_v ad_V S + w_q (ad_A + ad_V ad_V) S
//! H' = -(N Z + C Y) + w_q ad_S^T F          with C Y = -(N ad_V + ad_V^T N) Y - ad_Y^T N V
//! dtau_j = int S_j . H + (w_q K + w_v D)_jk
//! ```
//!
//! With `Psi = int S` of one coordinate, `Psi' = int ad_V S` and `Psi'' = int (ad_A + ad_V ad_V) S`, all from the
//! base of its piece, Y and Z are sums of these three, and by summation by parts (exact for this quadrature)
//! `int S_j . H = Psi_j . H_end + int Psi_j . (N Z + C Y - w_q ad_S^T F)`.
//!
//! Springs and the fluid answer to the whole of Y and of the displacement `w_q Psi` (see `response`).
//!
//! Outside its own piece a coordinate's Y and Z are constant; its H is constant before the piece, and linear in (Y,
//! Z) behind it: the blocks between different pieces have rank 12 at most and cost a few products an entry. How far
//! the material turns appears only where dead loads ask for it (the whole of Y and of its displacement, where springs
//! or fluid do); follower loads turn with the material and change nothing that it sees.

use super::chain;
use super::shape::shape;
use crate::lie::{Lanes, Scalar, Twist, VectorSpace, Wrench, weighted_sum};
use crate::linalg::Matrix;
use crate::robot::algebra::inertia::Seen as _;
use crate::robot::algebra::inertia::{General, Gyroscope, Inertia, Round, Sections};
use crate::robot::algebra::response::Response;
use crate::robot::effect::{immersion, point_tangent};
use crate::robot::plan::Plan;
use crate::robot::plan::material::Moments;
use crate::robot::plan::piece::PiecePlan;
use crate::robot::state::Workspace;
use crate::robot::state::tangent::{Coordinate, Rest, Row, Shift, Tangent, TangentWorkspace, Weights};
use crate::robot::turning::Turning;

/// `w_q dtau/dq + w_v dtau/dqd + w_a dtau/dqdd` with the motion up to date (for the mass matrix, weights (0, 0, w_a), the
/// kinematics are enough). A chain's matrix must have the structure of [`chain_matrix`]. `PLAIN`: of a plan that
/// [is plain](Plan::is_plain).
#[inline(always)]
pub(crate) fn weighted_tangent<G: Turning, const PLAIN: bool>(
    plan: &Plan<G>,
    work: &Workspace<G>,
    memory: &mut TangentWorkspace<G>,
    weights: [f64; 3],
    mut tangent: Tangent<'_>,
) {
    let [q, v, a] = weights;
    let weights = Weights { q, v, a, is_mass_only: q == 0.0 && v == 0.0 };
    let mut rest = Rest {
        inertia: Inertia::zero(),
        gyroscope: Gyroscope::zero(),
        dead: Gyroscope::zero(),
        response: Response::zero(),
    };
    for (s, piece) in plan.pieces.iter().enumerate().rev() {
        point_tangent::add_to_rest(plan, work, piece.points.at_end.clone(), weights, &mut rest);
        memory.points.prepare(plan, piece, work, weights);
        match &piece.moments {
            Moments::Round(rotary) => {
                let sections = Round { mass: &piece.mass, rotary };
                sections_in_motion(plan, piece, &sections, work, memory, weights);
            }
            Moments::General(_) if PLAIN => unreachable!("sections of plain rods look round"),
            Moments::General(sections) => {
                sections_in_motion(plan, piece, &General(sections), work, memory, weights);
            }
        }
        if has_dead_loads(plan, piece, weights) {
            spread(plan, piece, work, memory);
        }
        if !PLAIN {
            immersion::respond(plan, piece, work, weights.is_mass_only, &mut memory.response);
        }
        shapes(piece, work, memory, weights);
        for (c, component) in piece.components.iter().enumerate() {
            for degree in 0..component.modes {
                column::<G, PLAIN>(plan, piece, work, memory, weights, &rest, c, degree);
                // A mass matrix is symmetric: its rows are its columns.
                if s > 0 && !weights.is_mass_only {
                    row::<G, PLAIN>(plan, piece, work, memory, weights, &rest, component.first + degree);
                }
            }
        }
        let (entries, stride) = tangent.block(s, piece);
        block(piece, memory, weights, entries, stride);
        elasticity::<G, PLAIN>(piece, weights, entries, stride);
        if s > 0 {
            add_segment::<G, PLAIN>(plan, piece, work, memory, weights, &mut rest);
        }
    }
    match tangent {
        Tangent::Dense(matrix) => couple::<G, PLAIN>(plan, memory, weights, matrix),
        Tangent::Chain(matrix) => {
            chain::generate(&memory.coordinates, &memory.shifts, weights.is_mass_only, matrix);
        }
    }
}

/// N and C of all nodes, times the quadrature weights.
#[inline(always)]
fn sections_in_motion<G: Turning>(
    plan: &Plan<G>,
    piece: &PiecePlan<G>,
    sections: &impl Sections<G>,
    work: &Workspace<G>,
    memory: &mut TangentWorkspace<G>,
    weights: Weights,
) {
    for pack in 0..piece.packs {
        let node = piece.first_pack + pack;
        let weight = piece.weights[pack];
        let seen = sections.seen(plan.frame, pack, &work.rotation[node], work.position[node]);
        let inertia = seen.weighted(weight);
        memory.inertia[pack] = inertia;
        if !weights.is_mass_only {
            memory.gyroscope[pack] =
                Gyroscope::new(&inertia, work.velocity[node], work.momentum[node] * weight);
        }
    }
}

/// Whether dead loads are spread along the piece, and matter.
#[inline(always)]
fn has_dead_loads<G: Turning>(plan: &Plan<G>, piece: &PiecePlan<G>, weights: Weights) -> bool {
    !weights.is_mass_only && piece.spread.iter().any(|spread| spread.is_dead(plan))
}

/// The gyroscopes of the dead loads that are spread along the piece.
#[inline(always)]
fn spread<G: Turning>(
    plan: &Plan<G>,
    piece: &PiecePlan<G>,
    work: &Workspace<G>,
    memory: &mut TangentWorkspace<G>,
) {
    memory.dead[..piece.packs].fill(Gyroscope::zero());
    for spread in piece.spread.iter().filter(|spread| spread.is_dead(plan)) {
        for pack in 0..piece.packs {
            let node = piece.first_pack + pack;
            let load = spread.wrench(plan, work, pack, &work.rotation[node]) * piece.weights[pack];
            memory.dead[pack].add(Gyroscope::of_dead_load(load, work.position[node]));
        }
    }
}

#[inline(always)]
fn add_segment<G: Turning, const PLAIN: bool>(
    plan: &Plan<G>,
    piece: &PiecePlan<G>,
    work: &Workspace<G>,
    memory: &TangentWorkspace<G>,
    weights: Weights,
    rest: &mut Rest<G>,
) {
    for pack in 0..piece.packs {
        rest.inertia.add(memory.inertia[pack].sum());
        if !weights.is_mass_only {
            rest.gyroscope.add(memory.gyroscope[pack].sum());
        }
    }
    if has_dead_loads(plan, piece, weights) {
        for dead in &memory.dead[..piece.packs] {
            rest.dead.add(dead.sum());
        }
    }
    if !PLAIN && piece.immersed.is_some() {
        for response in &memory.response[..piece.packs] {
            rest.response.add(response.sum());
        }
    }
    point_tangent::add_to_rest(plan, work, piece.points.inside.clone(), weights, rest);
}

/// S, ad_V S, (ad_A + ad_V ad_V) S and w_q ad_S^T F of a unit of each strain component at all nodes.
#[inline(always)]
fn shapes<G: Turning>(
    piece: &PiecePlan<G>,
    work: &Workspace<G>,
    memory: &mut TangentWorkspace<G>,
    weights: Weights,
) {
    for (c, component) in piece.components.iter().enumerate() {
        for pack in 0..piece.packs {
            let node = piece.first_pack + pack;
            let rotation = &work.rotation[node];
            let shape = shape(rotation, work.position[node], component.index);
            let block = c * piece.packs + pack;
            memory.shape[block] = shape;
            if !weights.is_mass_only {
                let velocity = work.velocity[node];
                let rate = velocity.bracket(shape);
                memory.shape_rate[block] = rate;
                memory.shape_acceleration[block] =
                    velocity.bracket_add(rate, work.acceleration[node].bracket(shape));
                memory.load[block] =
                    shape.bracket_transposed(work.internal[node]) * G::Pack::splat(weights.q);
            }
        }
    }
}

/// The column of a component and degree: Psi and the change of the force at the nodes, and what the coordinate is outside
/// its piece.
#[allow(clippy::too_many_arguments, reason = "one sweep, its inputs named one by one")]
#[inline(always)]
fn column<G: Turning, const PLAIN: bool>(
    plan: &Plan<G>,
    piece: &PiecePlan<G>,
    work: &Workspace<G>,
    memory: &mut TangentWorkspace<G>,
    weights: Weights,
    rest: &Rest<G>,
    c: usize,
    degree: usize,
) {
    let packs = piece.packs;
    let k = piece.components[c].first + degree;
    let blocks = c * packs..(c + 1) * packs;
    let columns = (k - piece.first) * packs..(k - piece.first + 1) * packs;
    let degrees = degree * packs..(degree + 1) * packs;
    let (basis, weighted_basis) = (&piece.basis[degrees.clone()], &piece.weighted_basis[degrees]);
    let [w_q, w_v, w_a] = [weights.q, weights.v, weights.a].map(G::Pack::splat);

    let integrand = &mut memory.integrand[..packs];
    let psi = &mut memory.psi[columns.clone()];
    let source = &mut memory.source[columns];
    let inertia = &memory.inertia[..packs];
    let shape = integrate(piece, basis, &memory.shape[blocks.clone()], integrand, psi);
    let points = &mut memory.points;
    let has_points = !piece.points.inside.is_empty();
    if has_points {
        points.shape(plan, piece, weights, k - piece.first, integrand);
    }
    let mut coordinate = Coordinate { shape, z: shape * weights.a, ..Coordinate::zero() };
    let mut total = Wrench::zero();
    if weights.is_mass_only {
        for pack in 0..packs {
            source[pack] = inertia[pack].momentum(psi[pack] * w_a);
            total += source[pack];
        }
        coordinate.end = rest.inertia.momentum(coordinate.z);
        if !PLAIN && piece.immersed.is_some() {
            for (pack, response) in memory.response[..packs].iter().enumerate() {
                let change = response.inertia.times_add(psi[pack] * w_a, Wrench::zero());
                source[pack] += change;
                total += change;
            }
            coordinate.end = rest.response.inertia.times_add(coordinate.z, coordinate.end);
        }
    } else {
        let psi_rate = &mut memory.psi_rate[..packs];
        let psi_acceleration = &mut memory.psi_acceleration[..packs];
        let rate = integrate(piece, basis, &memory.shape_rate[blocks.clone()], integrand, psi_rate);
        if has_points {
            points.rate(plan, piece, weights, integrand);
        }
        let acceleration =
            integrate(piece, basis, &memory.shape_acceleration[blocks.clone()], integrand, psi_acceleration);
        if has_points {
            points.acceleration(plan, piece, weights, integrand);
        }
        let load = &memory.load[blocks];
        for pack in 0..packs {
            let y = (psi[pack].angular * w_v).add_scaled(psi_rate[pack].angular, w_q);
            let z = (psi[pack] * w_a)
                .add_scaled(psi_rate[pack], w_v + w_v)
                .add_scaled(psi_acceleration[pack], w_q);
            source[pack] = inertia[pack].momentum(z) + memory.gyroscope[pack].times(y);
            source[pack] = source[pack].add_scaled(load[pack], -weighted_basis[pack]);
            total += source[pack];
        }
        if has_dead_loads(plan, piece, weights) {
            for pack in 0..packs {
                let change = memory.dead[pack].times(psi[pack].angular * w_q);
                source[pack] += change;
                total += change;
            }
        }
        if !PLAIN && piece.immersed.is_some() {
            for (pack, response) in memory.response[..packs].iter().enumerate() {
                let y = (psi[pack] * w_v).add_scaled(psi_rate[pack], w_q);
                let z = (psi[pack] * w_a)
                    .add_scaled(psi_rate[pack], w_v + w_v)
                    .add_scaled(psi_acceleration[pack], w_q);
                let change = response.to(psi[pack] * w_q, y, z);
                source[pack] += change;
                total += change;
            }
        }
        coordinate.y = shape.angular * weights.v + rate.angular * weights.q;
        coordinate.z += rate * (2.0 * weights.v) + acceleration * weights.q;
        coordinate.turn = shape.angular * weights.q;
        coordinate.end = rest.inertia.momentum(coordinate.z) + rest.gyroscope.times(coordinate.y);
        if plan.has_dead_loads {
            coordinate.end += rest.dead.times(coordinate.turn);
        }
        if !PLAIN && plan.has_responses {
            let y = shape * weights.v + rate * weights.q;
            let displacement = shape * weights.q;
            memory.shifts[k] = Shift { y: y.linear, displacement: displacement.linear, ..Shift::zero() };
            coordinate.end += rest.response.to(displacement, y, coordinate.z);
        }
    }
    coordinate.before = coordinate.end + total.sum();
    if has_points {
        coordinate.before += points.sources(piece, work, weights, k - piece.first);
    }
    memory.coordinates[k] = coordinate;
}

/// Integrals of `basis * values` from the piece's base to the nodes; returns the integral over the piece.
#[inline(always)]
fn integrate<G: Turning>(
    piece: &PiecePlan<G>,
    basis: &[G::Pack],
    values: &[Twist<G, G::Pack>],
    integrand: &mut [Twist<G, G::Pack>],
    integrals: &mut [Twist<G, G::Pack>],
) -> Twist<G, f64> {
    let mut total = Twist::zero();
    for (pack, integrand) in integrand.iter_mut().enumerate() {
        *integrand = values[pack] * basis[pack];
        total = total.add_scaled(*integrand, piece.weights[pack]);
    }
    for (pack, integral) in integrals.iter_mut().enumerate() {
        *integral =
            weighted_sum(Twist::zero(), piece.row(&piece.from_base, pack), integrand, Twist::add_lane);
    }
    total.sum()
}

/// What the row of coordinate `j` multiplies in the columns of earlier pieces: the transposes of `N Z + C Y` and of the
/// dead loads, summed from the places where its S acts to the tip.
#[inline(always)]
fn row<G: Turning, const PLAIN: bool>(
    plan: &Plan<G>,
    piece: &PiecePlan<G>,
    work: &Workspace<G>,
    memory: &mut TangentWorkspace<G>,
    weights: Weights,
    rest: &Rest<G>,
    j: usize,
) {
    let psi = &memory.psi[(j - piece.first) * piece.packs..][..piece.packs];
    let coordinate = &mut memory.coordinates[j];
    let shape = coordinate.shape;
    let mut row_z = Wrench::<G, G::Pack>::zero();
    for (psi, inertia) in psi.iter().zip(&memory.inertia) {
        row_z += inertia.momentum(*psi);
    }
    coordinate.row_z = row_z.sum() + rest.inertia.momentum(shape);
    if !piece.points.inside.is_empty() {
        memory.points.row(piece, work, weights, j - piece.first, coordinate);
        if !PLAIN && plan.has_responses {
            let mut row = Row { coordinate, shift: &mut memory.shifts[j] };
            memory.points.answer(piece, j - piece.first, &mut row);
        }
    }
    let mut row_y = G::Axial::<G::Pack>::zero();
    for (psi, gyroscope) in psi.iter().zip(&memory.gyroscope) {
        row_y += gyroscope.transposed_times(*psi);
    }
    coordinate.row_y +=
        G::map_axial(&row_y, |pack: &G::Pack| pack.sum()) + rest.gyroscope.transposed_times(shape);
    if !PLAIN && plan.has_responses {
        let mut row = Row { coordinate, shift: &mut memory.shifts[j] };
        row.answer(&rest.response, shape);
        if !PLAIN && piece.immersed.is_some() {
            for (&psi, response) in psi.iter().zip(&memory.response) {
                row.answer_nodes(response, psi);
            }
        }
    }
    if plan.has_dead_loads {
        coordinate.row_turn += rest.dead.transposed_times(shape);
        if has_dead_loads(plan, piece, weights) {
            for (psi, dead) in psi.iter().zip(&memory.dead) {
                coordinate.row_turn +=
                    G::map_axial(&dead.transposed_times(*psi), |pack: &G::Pack| pack.sum());
            }
        }
    }
}

/// Rows whose products with a column are formed together, so that it is loaded once for all of them.
const ROWS: usize = 4;

/// The block of the piece: `Psi_j . H_end + int Psi_j . source`. That of a mass matrix is computed above the diagonal.
#[inline(always)]
fn block<G: Turning>(
    piece: &PiecePlan<G>,
    memory: &TangentWorkspace<G>,
    weights: Weights,
    block: &mut [f64],
    stride: usize,
) {
    let (n, packs) = (piece.n, piece.packs);
    let own = &memory.coordinates[piece.first..][..n];
    for (k, column) in own.iter().enumerate() {
        let source = &memory.source[k * packs..][..packs];
        let rows = if weights.is_mass_only { k + 1 } else { n };
        let entries = &mut block[k * stride..][..rows];
        let mut psi = memory.psi.chunks_exact(ROWS * packs);
        let mut groups = entries.chunks_exact_mut(ROWS);
        for (entries, psi) in (&mut groups).zip(&mut psi) {
            entries.copy_from_slice(&products::<G, ROWS>(psi, source));
        }
        let first = rows / ROWS * ROWS;
        for (entry, psi) in
            groups.into_remainder().iter_mut().zip(memory.psi[first * packs..].chunks_exact(packs))
        {
            [*entry] = products::<G, 1>(psi, source);
        }
        for (entry, row) in entries.iter_mut().zip(own) {
            *entry += row.shape.dot(column.end);
        }
        if !piece.points.inside.is_empty() {
            for (j, entry) in entries.iter_mut().enumerate() {
                *entry += memory.points.entry(piece, j, k);
            }
        }
    }
    if weights.is_mass_only {
        for k in 0..n {
            for j in 0..k {
                block[j * stride + k] = block[k * stride + j];
            }
        }
    }
}

/// `int Psi_j . source` of several rows, whose Psi stand one after the other.
#[inline(always)]
fn products<G: Turning, const ROWS: usize>(
    psi: &[Twist<G, G::Pack>],
    source: &[Wrench<G, G::Pack>],
) -> [f64; ROWS] {
    // Slices of one length, so that no index below needs a check.
    let packs = source.len();
    let rows: [_; ROWS] = std::array::from_fn(|row| &psi[row * packs..][..packs]);
    let mut sums = [G::Pack::splat(0.0); ROWS];
    for (pack, source) in source.iter().enumerate() {
        for (sum, psi) in sums.iter_mut().zip(&rows) {
            *sum = psi[pack].dot_add(*source, *sum);
        }
    }
    sums.map(Lanes::sum)
}

/// Adds `w_q K + w_v D`.
#[inline(always)]
fn elasticity<G: Turning, const PLAIN: bool>(
    piece: &PiecePlan<G>,
    weights: Weights,
    block: &mut [f64],
    stride: usize,
) {
    let factor = weights.q + weights.v * piece.retardation_time;
    if factor == 0.0 {
        return;
    }
    for component in &piece.components {
        let first = component.first - piece.first;
        for k in 0..component.modes {
            let entries = &mut block[(first + k) * stride + first..][..component.modes];
            for (j, entry) in entries.iter_mut().enumerate() {
                *entry += factor * component.stiffness[(j, k)];
            }
        }
    }
    if PLAIN {
        return;
    }
    for coupling in &piece.couplings {
        let [rows, columns] = coupling.coordinates();
        for (j, row) in rows.map(|row| row - piece.first).enumerate() {
            for (k, column) in columns.clone().map(|column| column - piece.first).enumerate() {
                let stiffness = factor * coupling.stiffness[(j, k)];
                block[column * stride + row] += stiffness;
                block[row * stride + column] += stiffness;
            }
        }
    }
}

/// The blocks between different pieces.
#[inline(always)]
fn couple<G: Turning, const PLAIN: bool>(
    plan: &Plan<G>,
    memory: &TangentWorkspace<G>,
    weights: Weights,
    tangent: &mut Matrix,
) {
    for piece in &plan.pieces {
        for k in piece.first..piece.first + piece.n {
            let column = &memory.coordinates[k];
            let mut entries = tangent.column_mut(k);
            let entries = entries.as_mut_slice();
            for (entry, row) in entries[..piece.first].iter_mut().zip(&memory.coordinates) {
                *entry = row.shape.dot(column.before);
            }
            if weights.is_mass_only {
                for j in 0..piece.first {
                    tangent[(k, j)] = tangent[(j, k)];
                }
                continue;
            }
            let behind = piece.first + piece.n;
            for (entry, row) in entries[behind..].iter_mut().zip(&memory.coordinates[behind..]) {
                *entry = column.z.dot(row.row_z) + column.y.dot(row.row_y) + column.turn.dot(row.row_turn);
            }
            if !PLAIN && plan.has_responses {
                let column = &memory.shifts[k];
                for (entry, row) in entries[behind..].iter_mut().zip(&memory.shifts[behind..]) {
                    *entry += column.y.dot(row.row_y) + column.displacement.dot(row.row_displacement);
                }
            }
        }
    }
}
