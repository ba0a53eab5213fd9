//! Columns of the tangent: Psi and the change of the force at the nodes, and the effect of a coordinate
//! outside its piece.

use super::responses;
use super::scope::Scope;
use crate::numerics::lie::{Scalar, Twist, VectorSpace, Wrench, weighted_sum};
use crate::robot::plan::piece::PiecePlan;
use crate::robot::state::tangent::{Coordinate, Rest, Shift, TangentWorkspace};
use crate::robot::turning::Turning;

impl<G: Turning> Scope<'_, G> {
    /// Column of the mass matrix for a component and degree.
    #[inline(always)]
    pub(super) fn column_of_mass(
        &self,
        memory: &mut TangentWorkspace<G>,
        rest: &Rest<G>,
        c: usize,
        degree: usize,
    ) {
        let &Self { plan, piece, weights, .. } = self;
        let packs = piece.packs;
        let k = piece.components[c].first + degree;
        let columns = (k - piece.first) * packs..(k - piece.first + 1) * packs;
        let basis = &piece.basis[degree * packs..(degree + 1) * packs];
        let w_a = G::Pack::splat(weights.a);

        let integrand = &mut memory.integrand[..packs];
        let psi = &mut memory.psi[columns.clone()];
        let source = &mut memory.source[columns];
        let shape = integrate(piece, basis, &memory.shape[c * packs..(c + 1) * packs], integrand, psi);
        if self.has_points {
            memory.points.shape(plan, piece, weights, k - piece.first, integrand);
        }
        let mut total = Wrench::zero();
        for (pack, inertia) in memory.inertia[..packs].iter().enumerate() {
            source[pack] = inertia.momentum(psi[pack] * w_a);
            total += source[pack];
        }
        if self.has_responses {
            let responses = &memory.response[..packs];
            let sweep = responses::ColumnOfMass { responses, w_a: weights.a, psi, source, total };
            total = plan.instructions.run_outlined::<G::Pack, _>(sweep);
        }
        let mut coordinate = self.coordinate_of_mass(rest, shape);
        coordinate.before = coordinate.end + total.sum();
        if self.has_points {
            coordinate.before += memory.points.sources(piece, weights, k - piece.first);
            memory.keep(plan, piece, weights, k - piece.first);
        }
        memory.coordinates[k] = coordinate;
    }

    /// Effect of a coordinate beyond its piece in the mass matrix, given its displacement `shape` at the end
    /// of the piece.
    #[inline(always)]
    pub(super) fn coordinate_of_mass(&self, rest: &Rest<G>, shape: Twist<G, f64>) -> Coordinate<G> {
        let z = shape * self.weights.a;
        let mut end = rest.inertia.momentum(z);
        if self.plan.has_responses {
            end = rest.response.inertia.times_add(z, end);
        }
        Coordinate { shape, z, end, ..Coordinate::zero() }
    }

    /// Column of the tangent for a component and degree.
    #[inline(always)]
    pub(super) fn column(&self, memory: &mut TangentWorkspace<G>, rest: &Rest<G>, c: usize, degree: usize) {
        let &Self { plan, piece, weights, .. } = self;
        let packs = piece.packs;
        let k = piece.components[c].first + degree;
        let blocks = c * packs..(c + 1) * packs;
        let columns = (k - piece.first) * packs..(k - piece.first + 1) * packs;
        let degrees = degree * packs..(degree + 1) * packs;
        let (basis, weighted_basis) = (&piece.basis[degrees.clone()], &piece.weighted_basis[degrees]);
        let [w_q, w_v, w_a] = [weights.q, weights.v, weights.a].map(G::Pack::splat);

        let integrand = &mut memory.integrand[..packs];
        let psi = &mut memory.psi[columns.clone()];
        let psi_rate = &mut memory.psi_rate[..packs];
        let psi_acceleration = &mut memory.psi_acceleration[..packs];
        let source = &mut memory.source[columns];
        let points = &mut memory.points;
        let shape = integrate(piece, basis, &memory.shape[blocks.clone()], integrand, psi);
        if self.has_points {
            points.shape(plan, piece, weights, k - piece.first, integrand);
        }
        let rate = integrate(piece, basis, &memory.shape_rate[blocks.clone()], integrand, psi_rate);
        if self.has_points {
            points.rate(plan, piece, weights, integrand);
        }
        let acceleration =
            integrate(piece, basis, &memory.shape_acceleration[blocks.clone()], integrand, psi_acceleration);
        if self.has_points {
            points.acceleration(plan, piece, weights, integrand);
        }

        let load = &memory.load[blocks];
        let (inertia, gyroscope) = (&memory.inertia[..packs], &memory.gyroscope[..packs]);
        let mut total = Wrench::zero();
        for pack in 0..packs {
            let y = (psi[pack].angular * w_v).add_scaled(psi_rate[pack].angular, w_q);
            let z = (psi[pack] * w_a)
                .add_scaled(psi_rate[pack], w_v + w_v)
                .add_scaled(psi_acceleration[pack], w_q);
            source[pack] = inertia[pack].momentum(z) + gyroscope[pack].times(y);
            source[pack] = source[pack].add_scaled(load[pack], -weighted_basis[pack]);
            total += source[pack];
        }
        if self.has_dead {
            for (pack, dead) in memory.dead[..packs].iter().enumerate() {
                let change = dead.times(psi[pack].angular * w_q);
                source[pack] += change;
                total += change;
            }
        }
        if self.has_responses {
            let responses = &memory.response[..packs];
            let psi: [&[_]; 3] = [psi, psi_rate, psi_acceleration];
            let sweep = responses::Column { responses, weights, psi, source, total };
            total = plan.instructions.run_outlined::<G::Pack, _>(sweep);
        }

        let mut coordinate = self.coordinate(memory, rest, k, [shape, rate, acceleration]);
        coordinate.before = coordinate.end + total.sum();
        if self.has_points {
            coordinate.before += memory.points.sources(piece, weights, k - piece.first);
            memory.keep(plan, piece, weights, k - piece.first);
        }
        memory.coordinates[k] = coordinate;
    }

    /// Effect of coordinate `k` beyond its piece, given Psi, Psi' and Psi'' at its end.
    #[inline(always)]
    pub(super) fn coordinate(
        &self,
        memory: &mut TangentWorkspace<G>,
        rest: &Rest<G>,
        k: usize,
        [shape, rate, acceleration]: [Twist<G, f64>; 3],
    ) -> Coordinate<G> {
        let &Self { plan, weights, .. } = self;
        let mut coordinate = Coordinate {
            shape,
            y: shape.angular * weights.v + rate.angular * weights.q,
            z: shape * weights.a,
            turn: shape.angular * weights.q,
            ..Coordinate::zero()
        };
        coordinate.z += rate * (2.0 * weights.v) + acceleration * weights.q;
        coordinate.end = rest.inertia.momentum(coordinate.z) + rest.gyroscope.times(coordinate.y);
        if plan.has_dead_loads {
            coordinate.end += rest.dead.times(coordinate.turn);
        }
        if plan.has_responses {
            let y = shape * weights.v + rate * weights.q;
            let displacement = shape * weights.q;
            memory.shifts[k] = Shift { y: y.linear, displacement: displacement.linear, ..Shift::zero() };
            coordinate.end += rest.response.to(displacement, y, coordinate.z);
        }
        coordinate
    }
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
