//! Derivative of the virtual power of all forces with respect to the lengths of segments.
//!
//! Strains are functions of the fraction of a piece's length. If a piece lengthens by the fraction e, it
//! moves as if all its strains, including the reference strain xi_0, and their rates increased by this
//! fraction, and so do its quadrature weights. In the symbols of the tangent (`docs/theory.md`, "Tangent") e
//! is a coordinate with `S = Ad_g xi`, `S qd` and `S qdd` instead of `w_q S_k`, `w_v S_k` and `w_a S_k`:
//!
//! ```text
//! Y' = S qd + ad_V S
//! Z' = S qdd + 2 ad_V (S qd) + (ad_A + ad_V ad_V) S
//! H' = -(N Z + C Y) + ad_S^T F - f
//! ```
//!
//! with the forces per length f of `F = int f`. The forces of the segment's own coordinates are integrals
//! over the segment, and increase by the fraction e too. In the virtual motion `W = int S_j lambda_j` the
//! power is `P = lambda . tau`, and by summation by parts
//!
//! ```text
//! dP/de = int_segment [ Z' . P_Z + Y' . P_Y + S . P_turn - W . (ad_S^T F - f) ] + (lambda . tau)_segment
//! P_Z(X) = int_X N W,    P_Y(X) = int_X C^T W,    P_turn(X) = int_X dead^T W
//! ```
//!
//! so that one forward and one backward sweep serve all segments.

use super::adjoint::carried;
use super::tangent::gyroscopes;
use crate::numerics::lie::{
    Cross as _, LANES, Lanes, Scalar as _, Sweep, Twist, VectorSpace, Wrench, weighted_sum,
};
use crate::robot::algebra::inertia::{General, Gyroscope, Inertia, InertiaAboutOrigin as _, Round, Sections};
use crate::robot::plan::Plan;
use crate::robot::plan::material::Moments;
use crate::robot::plan::piece::PiecePlan;
use crate::robot::state::Workspace;
use crate::robot::turning::Turning;

/// Number of leading segments whose lengths affect only their own rods and what these carry at their tips.
/// Zero if places inside pieces matter, or forces that depend on the position of the rod.
pub(crate) fn segments<G: Turning>(plan: &Plan<G>) -> usize {
    let is_alone = |piece: &PiecePlan<G>| piece.points.inside.is_empty() && piece.spread.is_empty();
    let has_carried_points = plan.points.iter().any(|point| point.carries.is_some());
    let has_lines = !plan.effects.actuation.lines.is_empty();
    if plan.has_responses || has_carried_points || has_lines || !plan.pieces.iter().all(is_alone) {
        return 0;
    }
    of_segments(plan).last().map_or(0, |(segment, _)| segment + 1)
}

/// Pieces of rods, by their indices in the plan, with the indices of their segments.
fn of_segments<G: Turning>(plan: &Plan<G>) -> impl Iterator<Item = (usize, usize)> {
    let rods = plan.links.iter().flat_map(|link| link.rod.clone());
    rods.scan(0, |segments, p| {
        *segments += usize::from(plan.pieces[p].part().begins_segment());
        Some((*segments - 1, p))
    })
}

/// Virtual motion W.
struct VirtualMotion<G: Turning> {
    nodes: Vec<Twist<G, G::Pack>>,
    stations: Vec<Twist<G, f64>>,
}

/// `N W` and `C^T W` per length at a pack of nodes.
#[derive(Clone, Copy)]
struct Density<G: Turning> {
    z: Wrench<G, G::Pack>,
    y: G::Axial<G::Pack>,
}

impl<G: Turning> Density<G> {
    #[inline(always)]
    fn add_scaled(self, other: Self, factor: G::Pack) -> Self {
        Self { z: self.z.add_scaled(other.z, factor), y: self.y.add_scaled(other.y, factor) }
    }

    /// Adds `weight` times one lane of `other` to every lane.
    #[inline(always)]
    fn add_lane(self, other: &Self, lane: usize, weight: G::Pack) -> Self {
        let of_lane = |pack: &G::Pack| G::Pack::splat(pack.lane(lane));
        let counted = Self { z: other.z.map(of_lane), y: G::map_axial(&other.y, of_lane) };
        self.add_scaled(counted, weight)
    }
}

/// Sums of the virtual motion's contributions beyond a place.
#[derive(Clone, Copy)]
struct Beyond<G: Turning> {
    z: Wrench<G, f64>,
    y: G::Axial<f64>,
    turn: G::Axial<f64>,
}

impl<G: Turning> Beyond<G> {
    fn zero() -> Self {
        Self { z: Wrench::zero(), y: VectorSpace::zero(), turn: VectorSpace::zero() }
    }

    fn add(&mut self, Self { z, y, turn }: Self) {
        self.z += z;
        self.y += y;
        self.turn += turn;
    }
}

/// Adds the derivatives of the power with respect to the length of each segment. The motion must be up to
/// date, with the forces `tau`. Allocates.
pub(crate) struct ByLength<'a, G: Turning> {
    pub(crate) plan: &'a Plan<G>,
    pub(crate) work: &'a Workspace<G>,
    pub(crate) q: &'a [f64],
    pub(crate) rates: &'a [f64],
    pub(crate) tau: &'a [f64],
    pub(crate) by_length: &'a mut [f64],
}

impl<G: Turning> Sweep for ByLength<'_, G> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Self { plan, work, q, rates, tau, by_length } = self;
        let VirtualMotion { nodes, stations } = sweep_out(plan, work, rates);
        let mut segment_of = vec![None; plan.pieces.len()];
        for (segment, p) in of_segments(plan) {
            segment_of[p] = Some(segment);
        }
        let mut beyond = vec![Beyond::<G>::zero(); plan.stations];
        for (p, piece) in plan.pieces.iter().enumerate().rev() {
            let mut end = beyond[piece.joined.end];
            for point in piece.points.at_end.clone() {
                end.add(at_point(plan, work, point, stations[piece.joined.end]));
            }
            if piece.packs > 0 {
                let virtual_motion = &nodes[piece.node_packs()];
                let within = densities(plan, piece, work, virtual_motion);
                if let Some(segment) = segment_of[p] {
                    let own = piece.coordinates();
                    let power: f64 = rates[own.clone()].iter().zip(&tau[own]).map(|(l, tau)| l * tau).sum();
                    let by_part = power + power_of_stretching(piece, work, q, virtual_motion, &within, end);
                    by_length[segment] += by_part / piece.part().segment.length;
                }
                let mut total = Density { z: Wrench::zero(), y: VectorSpace::zero() };
                for (&weight, &density) in piece.weights.iter().zip(&within) {
                    total = total.add_scaled(density, weight);
                }
                let y = G::map_axial(&total.y, |pack: &G::Pack| pack.sum());
                end.add(Beyond { z: total.z.sum(), y, turn: VectorSpace::zero() });
            }
            beyond[piece.joined.carrier()].add(end);
        }
    }
}

/// Virtual motion for these rates of the coordinates.
#[inline(always)]
fn sweep_out<G: Turning>(plan: &Plan<G>, work: &Workspace<G>, rates: &[f64]) -> VirtualMotion<G> {
    let mut nodes = vec![Twist::zero(); plan.packs];
    let mut stations = vec![Twist::zero(); plan.stations];
    let most = plan.pieces.iter().map(|piece| piece.packs).max().unwrap_or(0);
    let mut slopes = vec![Twist::zero(); most];
    for piece in &plan.pieces {
        let base: Twist<G, f64> = stations[piece.joined.carrier()];
        stations[piece.joined.begin] = base;
        let mut end = base;
        if let Some(hinge) = &piece.hinge {
            end += work.hinges[hinge.index] * rates[piece.first];
        }
        if piece.packs > 0 {
            let slopes = &mut slopes[..piece.packs];
            piece.fields(rates, slopes);
            let mut change = Twist::zero();
            for (pack, node) in piece.node_packs().enumerate() {
                let place = (&work.rotation[node], work.position[node]);
                slopes[pack] = carried(place.0, place.1, slopes[pack], piece.is_extensible);
                change = change.add_scaled(slopes[pack], piece.weights[pack]);
            }
            let start = base.splat();
            for (row, node) in piece.rows(&piece.from_base).zip(piece.node_packs()) {
                nodes[node] = weighted_sum(start, row, slopes, Twist::add_lane);
            }
            end += change.sum();
        }
        stations[piece.joined.end] = end;
    }
    VirtualMotion { nodes, stations }
}

/// Contribution of a point at the end of a piece.
#[inline(always)]
fn at_point<G: Turning>(plan: &Plan<G>, work: &Workspace<G>, p: usize, moves: Twist<G, f64>) -> Beyond<G> {
    let (gyroscope, dead) = gyroscopes(plan, work, p);
    Beyond {
        z: work.points[p].inertia.momentum(moves),
        y: gyroscope.transposed_times(moves),
        turn: dead.transposed_times(moves),
    }
}

/// `N W` and `C^T W` per length at the nodes of a piece.
#[inline(always)]
fn densities<G: Turning>(
    plan: &Plan<G>,
    piece: &PiecePlan<G>,
    work: &Workspace<G>,
    virtual_motion: &[Twist<G, G::Pack>],
) -> Vec<Density<G>> {
    let at_node = |(pack, node): (usize, usize)| {
        let (rotation, position) = (&work.rotation[node], work.position[node]);
        let inertia: Inertia<G, G::Pack> = match &piece.moments {
            Moments::Round(rotary) => {
                let sections = Round { mass: &piece.mass, rotary };
                sections.about_origin(plan.frame, pack, rotation, position).weighted(G::Pack::splat(1.0))
            }
            Moments::General(sections) => {
                General(sections).about_origin(plan.frame, pack, rotation, position)
            }
        };
        let gyroscope = Gyroscope::new(&inertia, work.velocity[node], work.momentum[node]);
        let moves = virtual_motion[pack];
        Density { z: inertia.momentum(moves), y: gyroscope.transposed_times(moves) }
    };
    piece.node_packs().enumerate().map(at_node).collect()
}

/// Derivative of the power with respect to the relative lengthening of a piece, without the power of its own
/// forces.
#[inline(always)]
fn power_of_stretching<G: Turning>(
    piece: &PiecePlan<G>,
    work: &Workspace<G>,
    q: &[f64],
    virtual_motion: &[Twist<G, G::Pack>],
    within: &[Density<G>],
    end: Beyond<G>,
) -> f64 {
    let mut sum = G::Pack::splat(0.0);
    let start = Density { z: end.z.splat(), y: G::map_axial(&end.y, |&x| G::Pack::splat(x)) };
    let turn = G::map_axial(&end.turn, |&x| G::Pack::splat(x));
    for ((pack, row), node) in piece.rows(&piece.to_end).enumerate().zip(piece.node_packs()) {
        let beyond = weighted_sum(start, row, within, Density::add_lane);
        let strain = strain(piece, work, q, pack);
        let (velocity, acceleration) = (work.velocity[node], work.acceleration[node]);
        let y = velocity.bracket_add(strain, work.rate[node]);
        let z = velocity.bracket_add(y, acceleration.bracket_add(strain, work.acceleration_rate[node]));
        let load = strain.bracket_transposed(work.internal[node]) - work.force[node];
        let turned = strain.angular.dot_add(turn, y.angular.dot_add(beyond.y, G::Pack::splat(0.0)));
        let density = z.dot_add(beyond.z, turned) - virtual_motion[pack].dot(load);
        sum = density.mul_add(piece.weights[pack], sum);
    }
    sum.sum()
}

/// `Ad_g xi` at a pack of nodes, for the total strain including the reference strain.
#[inline(always)]
fn strain<G: Turning>(
    piece: &PiecePlan<G>,
    work: &Workspace<G>,
    q: &[f64],
    pack: usize,
) -> Twist<G, G::Pack> {
    let node = piece.first_pack + pack;
    let mut curvature = piece.field(q, pack).angular;
    if piece.largest_reference_curvature > 0.0 {
        for lane in 0..LANES {
            let only = G::Pack::from_lanes(std::array::from_fn(|i| f64::from(u8::from(i == lane))));
            curvature +=
                G::map_axial(&piece.reference_curvature[pack * LANES + lane], |&x| only * G::Pack::splat(x));
        }
    }
    let angular = G::rotate_axial(&work.rotation[node], curvature);
    Twist { angular, linear: work.position[node].cross(angular) + work.slope[node] }
}
