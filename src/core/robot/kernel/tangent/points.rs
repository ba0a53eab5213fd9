//! Contributions of points to the tangent: additional places at which Psi is known and forces change.

use crate::numerics::lie::{Twist, Wrench};
use crate::robot::algebra::inertia::Gyroscope;
use crate::robot::algebra::response::Response;
use crate::robot::effects;
use crate::robot::plan::Plan;
use crate::robot::plan::piece::PiecePlan;
use crate::robot::state::Workspace;
use crate::robot::state::tangent::{Coordinate, PointTangents, Rest, Row, Weights};
use crate::robot::turning::Turning;

impl<G: Turning> PointTangents<G> {
    /// Responses of the points inside a piece, including what is attached there.
    #[inline(always)]
    pub(crate) fn prepare(
        &mut self,
        plan: &Plan<G>,
        piece: &PiecePlan<G>,
        work: &Workspace<G>,
        weights: Weights,
        carried: &[Rest<G>],
    ) {
        for (i, p) in piece.points.inside.clone().enumerate() {
            let carried = plan.points[p].carries.map(|station| &carried[station]);
            self.inertia[i] = work.points[p].inertia;
            self.response[i] = None;
            if !weights.is_mass_only {
                (self.gyroscope[i], self.dead[i]) = gyroscopes(plan, work, p);
                self.response[i] = effects::respond_at(plan, work, &plan.points[p], &work.points[p]);
            }
            let Some(carried) = carried else { continue };
            self.inertia[i].add(carried.inertia);
            self.gyroscope[i].add(carried.gyroscope);
            self.dead[i].add(carried.dead);
            if plan.has_responses {
                self.response[i].get_or_insert_with(Response::zero).add(carried.response);
            }
        }
    }

    /// Psi at the points for coordinate `k` of the piece, whose integrand at the nodes is given.
    #[inline(always)]
    pub(crate) fn shape(
        &mut self,
        plan: &Plan<G>,
        piece: &PiecePlan<G>,
        weights: Weights,
        k: usize,
        integrand: &[Twist<G, G::Pack>],
    ) {
        let points = &plan.points[piece.points.inside.clone()];
        for (i, point) in points.iter().enumerate() {
            let psi = point.reach().integral(integrand);
            self.psi[k * points.len() + i] = psi;
            self.y[i] = psi * weights.v;
            self.z[i] = psi * weights.a;
        }
    }

    /// Psi' at the points.
    #[inline(always)]
    pub(crate) fn rate(
        &mut self,
        plan: &Plan<G>,
        piece: &PiecePlan<G>,
        weights: Weights,
        integrand: &[Twist<G, G::Pack>],
    ) {
        for (i, point) in plan.points[piece.points.inside.clone()].iter().enumerate() {
            let rate = point.reach().integral(integrand);
            self.y[i] += rate * weights.q;
            self.z[i] += rate * (2.0 * weights.v);
        }
    }

    /// Psi'' at the points.
    #[inline(always)]
    pub(crate) fn acceleration(
        &mut self,
        plan: &Plan<G>,
        piece: &PiecePlan<G>,
        weights: Weights,
        integrand: &[Twist<G, G::Pack>],
    ) {
        for (i, point) in plan.points[piece.points.inside.clone()].iter().enumerate() {
            self.z[i] += point.reach().integral(integrand) * weights.q;
        }
    }

    /// Change of the forces at the points for coordinate `k`; returns the sum.
    #[inline(always)]
    pub(crate) fn sources(&mut self, piece: &PiecePlan<G>, weights: Weights, k: usize) -> Wrench<G, f64> {
        let mut total = Wrench::zero();
        let points = piece.points.inside.len();
        for i in 0..points {
            let column = k * points + i;
            let mut source = self.inertia[i].momentum(self.z[i]);
            if weights.is_mass_only {
                if let Some(response) = &self.response[i] {
                    source = response.inertia.times_add(self.z[i], source);
                }
            } else {
                let displacement = self.psi[column] * weights.q;
                source +=
                    self.gyroscope[i].times(self.y[i].angular) + self.dead[i].times(displacement.angular);
                if let Some(response) = &self.response[i] {
                    source += response.to(displacement, self.y[i], self.z[i]);
                }
            }
            self.source[column] = source;
            total += source;
        }
        total
    }

    /// Contribution of the points to entry (j, k) of the piece's block.
    #[inline(always)]
    pub(crate) fn entry(&self, piece: &PiecePlan<G>, j: usize, k: usize) -> f64 {
        let points = piece.points.inside.len();
        let columns = |k: usize| k * points..(k + 1) * points;
        self.psi[columns(j)].iter().zip(&self.source[columns(k)]).map(|(psi, source)| psi.dot(*source)).sum()
    }

    /// Adds the contribution of the points to the row of coordinate `j` of the piece.
    #[inline(always)]
    pub(crate) fn row(&self, piece: &PiecePlan<G>, weights: Weights, j: usize, row: &mut Coordinate<G>) {
        let points = piece.points.inside.len();
        for i in 0..points {
            let psi = self.psi[j * points + i];
            row.row_z += self.inertia[i].momentum(psi);
            if !weights.is_mass_only {
                row.row_y += self.gyroscope[i].transposed_times(psi);
                row.row_turn += self.dead[i].transposed_times(psi);
            }
        }
    }

    /// Adds the contribution of the points' responses to a row.
    #[inline(always)]
    pub(crate) fn answer(&self, piece: &PiecePlan<G>, j: usize, row: &mut Row<'_, G>) {
        let points = piece.points.inside.len();
        for (response, &psi) in self.response.iter().zip(&self.psi[j * points..][..points]) {
            if let Some(response) = response {
                row.answer(response, psi);
            }
        }
    }
}

/// Adds everything attached inside a piece to the sums at its beginning.
#[inline(always)]
pub(crate) fn add_carried<G: Turning>(
    plan: &Plan<G>,
    piece: &PiecePlan<G>,
    carried: &[Rest<G>],
    rest: &mut Rest<G>,
) {
    for station in plan.points[piece.points.inside.clone()].iter().filter_map(|point| point.carries) {
        rest.add(&carried[station], plan.has_responses);
    }
}

/// Gyroscopes at a point: of the bodies, and of dead loads.
#[inline(always)]
pub(crate) fn gyroscopes<G: Turning>(
    plan: &Plan<G>,
    work: &Workspace<G>,
    p: usize,
) -> (Gyroscope<G, f64>, Gyroscope<G, f64>) {
    let state = &work.points[p];
    let dead = effects::dead_at(plan, work, &plan.points[p], state);
    (Gyroscope::new(&state.inertia, state.velocity, state.momentum), dead)
}

/// Adds the points of a piece, either those inside or those at its end, to the sums of what lies beyond a
/// place.
#[inline(always)]
pub(crate) fn add_to_rest<G: Turning>(
    plan: &Plan<G>,
    work: &Workspace<G>,
    points: std::ops::Range<usize>,
    weights: Weights,
    rest: &mut Rest<G>,
) {
    for p in points {
        rest.inertia.add(work.points[p].inertia);
        if !weights.is_mass_only {
            let (gyroscope, dead) = gyroscopes(plan, work, p);
            rest.gyroscope.add(gyroscope);
            rest.dead.add(dead);
            if let Some(response) = effects::respond_at(plan, work, &plan.points[p], &work.points[p]) {
                rest.response.add(response);
            }
        }
    }
}
