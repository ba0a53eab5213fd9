//! Inverse dynamics by one forward sweep for the motion and one backward sweep for the forces: `tau = Q + K
//! q + D qd`.
//!
//! In the inertial frame the recursions along the rod are plain integrals (`docs/theory.md`):
//! V = int S qd, A = -(0; g) + int [S qdd + ad_V (S qd)], F = int (N A - ad_V^T N V - loads), Q_j = int S_j . F.

use super::adjoint::carried;
use super::{hinge, points};
use crate::numerics::lie::{Cross, Lanes, Scalar, Sweep, Twist, Wrench, weighted_sum};
use crate::robot::algebra::inertia::InertiaAboutOrigin as _;
use crate::robot::algebra::inertia::{General, Round, Sections};
use crate::robot::effects;
use crate::robot::effects::contact::force as contact;
use crate::robot::plan::Plan;
use crate::robot::plan::material::Moments;
use crate::robot::plan::piece::PiecePlan;
use crate::robot::state::{Station, Workspace};
use crate::robot::turning::Turning;

/// Updates motion and internal wrench of a state whose kinematics are up to date, if necessary.
#[inline(always)]
pub(crate) fn update<G: Turning>(
    plan: &Plan<G>,
    work: &mut Workspace<G>,
    q: &[f64],
    qd: &[f64],
    qdd: &[f64],
) {
    let n = plan.n;
    let known = &mut work.motion_of;
    if work.motion_is_known && known[..n] == *q && known[n..2 * n] == *qd && known[2 * n..] == *qdd {
        return;
    }
    work.motion_is_known = true;
    known[..n].copy_from_slice(q);
    known[n..2 * n].copy_from_slice(qd);
    known[2 * n..].copy_from_slice(qdd);
    for run in plan.pieces.chunk_by(|a, b| (a.packs == 0) == (b.packs == 0)) {
        if run[0].packs == 0 {
            let sweep = WithoutNodes { plan, run, work: &mut *work, rates: [qd, qdd] };
            plan.instructions.run_outlined::<G::Pack, _>(sweep);
            continue;
        }
        for piece in run {
            if let Some(weld) = &piece.joined.weld {
                let Station { velocity, acceleration, .. } = work.stations[weld.to];
                let begin = &mut work.stations[piece.joined.begin];
                (begin.velocity, begin.acceleration) = (velocity, acceleration);
            }
            match &piece.moments {
                Moments::Round(rotary) => {
                    let sections = Round { mass: &piece.mass, rotary };
                    sweep_out(plan.frame, piece, &sections, work, [qd, qdd]);
                }
                Moments::General(sections) => {
                    let sections = General(sections);
                    let sweep = SweepOut { frame: plan.frame, piece, sections, work, rates: [qd, qdd] };
                    plan.instructions.run_outlined::<G::Pack, _>(sweep);
                }
            }
            effects::act_along(plan, piece, work);
            points::drive(plan, piece, work);
        }
    }
    effects::prepare(plan, work, q, qd);
    gather(plan, work);
}

/// Sums the forces at nodes and points to internal wrenches, from the leaves to the root.
#[inline(always)]
pub(super) fn gather<G: Turning>(plan: &Plan<G>, work: &mut Workspace<G>) {
    work.carried.fill(Wrench::zero());
    for piece in plan.pieces.iter().rev() {
        let end = work.carried[piece.joined.end] + points::at_end(piece, work);
        if piece.packs == 0 {
            work.through[piece.joined.end] = end;
            work.carried[piece.joined.carrier()] += end;
            continue;
        }
        let mut begin = sweep_back(piece, work, end);
        begin += points::carry(plan, piece, work);
        begin += contact::carry(plan, piece, work);
        work.through[piece.joined.end] = begin;
        work.carried[piece.joined.carrier()] += begin;
    }
}

/// Motion beyond pieces without nodes (hinges or rigid), and the forces at their ends.
struct WithoutNodes<'a, G: Turning> {
    plan: &'a Plan<G>,
    run: &'a [PiecePlan<G>],
    work: &'a mut Workspace<G>,
    rates: [&'a [f64]; 2],
}

impl<G: Turning> Sweep for WithoutNodes<'_, G> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Self { plan, run, work, rates } = self;
        let motion_of = |station: &Station<G>| (station.velocity, station.acceleration);
        let (mut station, mut motion) = (0, motion_of(&work.stations[0]));
        for piece in run {
            let joined = &piece.joined;
            // Usually the end of the previous piece, which is at hand.
            if joined.carrier() != station {
                motion = motion_of(&work.stations[joined.carrier()]);
            }
            if joined.weld.is_some() {
                let begin = &mut work.stations[joined.begin];
                (begin.velocity, begin.acceleration) = motion;
            }
            if let Some(hinge) = &piece.hinge {
                motion = hinge::drive(piece, hinge, work, rates, motion);
            }
            let end = &mut work.stations[joined.end];
            (end.velocity, end.acceleration) = motion;
            for p in piece.points.at_end.clone() {
                points::take(plan, p, work, motion);
            }
            station = joined.end;
        }
    }
}

/// [`sweep_out`] for general sections.
struct SweepOut<'a, G: Turning> {
    frame: G::Frame,
    piece: &'a PiecePlan<G>,
    sections: General<'a, G>,
    work: &'a mut Workspace<G>,
    rates: [&'a [f64]; 2],
}

impl<G: Turning> Sweep for SweepOut<'_, G> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        sweep_out(self.frame, self.piece, &self.sections, self.work, self.rates);
    }
}

/// Motion of a piece and the forces that it requires, from the motion of its base.
#[inline(always)]
fn sweep_out<G: Turning>(
    frame: G::Frame,
    piece: &PiecePlan<G>,
    sections: &impl Sections<G>,
    work: &mut Workspace<G>,
    [qd, qdd]: [&[f64]; 2],
) {
    // Slices of equal length avoid bounds checks below.
    let packs = piece.packs;
    let nodes = piece.node_packs();
    let rotation = &work.rotation[nodes.clone()][..packs];
    let position = &work.position[nodes.clone()][..packs];
    let rate = &mut work.rate[nodes.clone()][..packs];
    let acceleration_rate = &mut work.acceleration_rate[nodes.clone()][..packs];
    let velocity = &mut work.velocity[nodes.clone()][..packs];
    let acceleration = &mut work.acceleration[nodes.clone()][..packs];
    let momentum = &mut work.momentum[nodes.clone()][..packs];
    let force = &mut work.force[nodes][..packs];
    let weights = &piece.weights[..packs];

    let base = work.stations[piece.joined.begin];
    piece.fields(qd, rate);
    piece.fields(qdd, acceleration_rate);
    for pack in 0..packs {
        let place = (&rotation[pack], position[pack]);
        rate[pack] = carried(place.0, place.1, rate[pack], piece.is_extensible);
        acceleration_rate[pack] = carried(place.0, place.1, acceleration_rate[pack], piece.is_extensible);
    }
    let mut change = (Twist::zero(), Twist::zero());
    let start = base.velocity.splat();
    for (pack, row) in piece.rows(&piece.from_base).enumerate() {
        velocity[pack] = weighted_sum(start, row, rate, Twist::add_lane);
        acceleration_rate[pack] = velocity[pack].bracket_add(rate[pack], acceleration_rate[pack]);
        change.0 = change.0.add_scaled(rate[pack], weights[pack]);
        change.1 = change.1.add_scaled(acceleration_rate[pack], weights[pack]);
    }
    let start = base.acceleration.splat();
    for (pack, row) in piece.rows(&piece.from_base).enumerate() {
        acceleration[pack] = weighted_sum(start, row, acceleration_rate, Twist::add_lane);
        let inertia = sections.about_origin(frame, pack, &rotation[pack], position[pack]);
        momentum[pack] = inertia.momentum(velocity[pack]);
        force[pack] =
            inertia.momentum(acceleration[pack]) - velocity[pack].bracket_transposed(momentum[pack]);
    }
    let next = &mut work.stations[piece.joined.end];
    next.velocity = base.velocity + change.0.sum();
    next.acceleration = base.acceleration + change.1.sum();
}

/// Internal wrench at the nodes from that at the piece's end; returns that at its base.
#[inline(always)]
fn sweep_back<G: Turning>(
    piece: &PiecePlan<G>,
    work: &mut Workspace<G>,
    end: Wrench<G, f64>,
) -> Wrench<G, f64> {
    let nodes = piece.node_packs();
    let force = &work.force[nodes.clone()][..piece.packs];
    let internal = &mut work.internal[nodes][..piece.packs];
    let mut total = Wrench::zero();
    let start = end.splat();
    for (pack, row) in piece.rows(&piece.to_end).enumerate() {
        internal[pack] = weighted_sum(start, row, force, Wrench::add_lane);
        total = total.add_scaled(force[pack], piece.weights[pack]);
    }
    end + total.sum()
}

/// `tau = Q + K q + D qd` of the state last passed to [`update`].
#[inline(always)]
pub(crate) fn project<G: Turning>(
    plan: &Plan<G>,
    work: &mut Workspace<G>,
    q: &[f64],
    qd: &[f64],
    tau: &mut [f64],
) {
    for piece in &plan.pieces {
        if let Some(hinge) = &piece.hinge {
            let k = piece.first;
            tau[k] = hinge::project(piece, hinge, work, [q[k], qd[k], work.motion_of[2 * plan.n + k]]);
            continue;
        }
        let packs = piece.packs;
        let nodes = piece.node_packs();
        let rotation = &work.rotation[nodes.clone()][..packs];
        let position = &work.position[nodes.clone()][..packs];
        let internal = &work.internal[nodes.clone()][..packs];
        let body = &mut work.body[nodes][..packs];
        for pack in 0..packs {
            let Wrench { moment, force } = internal[pack];
            body[pack] = Wrench {
                moment: G::rotate_axial_back(&rotation[pack], (-position[pack]).cross_add(force, moment)),
                force: G::rotate_back(&rotation[pack], force),
            };
        }
        let mu = piece.retardation_time;
        for component in &piece.components {
            let own = component.first..component.first + component.modes;
            let (q, qd) = (&q[own.clone()], &qd[own.clone()]);
            let tau = &mut tau[own];
            let rows = piece.weighted_basis.chunks_exact(packs);
            for ((j, tau), row) in tau.iter_mut().enumerate().zip(rows) {
                let mut sum = G::Pack::splat(0.0);
                for (&weight, wrench) in row.iter().zip(body.iter_mut()) {
                    sum = weight.mul_add(*wrench.component_mut(component.index), sum);
                }
                *tau = sum.sum() + component.elastic_force(j, q, qd, mu);
            }
        }
        for coupling in &piece.couplings {
            coupling.add_elastic_force(q, qd, mu, tau);
        }
    }
    effects::push(plan, work, tau);
}
