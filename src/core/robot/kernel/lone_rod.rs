//! Forces without accelerations, and the mass matrix, of a rod on which only its weight acts.
//!
//! Both follow from `Psi_k = int S_k` at the nodes. The velocity is `V = sum_k Psi_k qd_k`, and summation by parts (exact for this
//! quadrature) turns the forces `Q_j = int S_j . F` into `int Psi_j . f` with the forces per length `f = N A - ad_V^T N V`, where
//! `A = int ad_V (S qd) - (0; g)`. The general sweeps also integrate `S qd` and `f`, and rotate F into the axes of the sections.

use super::tangent::products;
use crate::numerics::lie::{LANES, Scalar, Twist, weighted_sum};
use crate::numerics::linalg::Matrix;
use crate::robot::algebra::inertia::{General, InertiaAboutOrigin as _, Round, Sections};
use crate::robot::effects;
use crate::robot::plan::Plan;
use crate::robot::plan::material::Moments;
use crate::robot::state::Workspace;
use crate::robot::state::tangent::TangentWorkspace;
use crate::robot::turning::Turning;
use crate::robot::turning::columns::shape;

/// Packs of nodes of segments with up to three modes of every strain (`nodes`).
const USUAL_PACKS: usize = 3;

/// Whether a robot is a rod of one piece on which nothing acts.
pub(crate) fn is_lone<G: Turning>(plan: &Plan<G>) -> bool {
    let [piece] = &plan.pieces[..] else { return false };
    piece.n > 0 && !piece.is_joint && plan.points.is_empty() && !effects::act(plan, piece)
}

/// `tau(q, qd, 0)` and the mass matrix of a [lone rod](is_lone), with the kinematics up to date.
#[inline(always)]
pub(crate) fn forces_and_mass<G: Turning>(
    plan: &Plan<G>,
    work: &Workspace<G>,
    memory: &mut TangentWorkspace<G>,
    [q, qd]: [&[f64]; 2],
    tau: &mut [f64],
    mass: &mut Matrix,
) {
    let piece = &plan.pieces[0];
    let mu = piece.retardation_time;
    match &piece.moments {
        Moments::Round(rotary) => {
            let sections = Round { mass: &piece.mass, rotary };
            // Loops of known length save a tenth of the instructions.
            match piece.packs {
                USUAL_PACKS => momenta(plan, &sections, work, memory, qd, USUAL_PACKS),
                packs => momenta(plan, &sections, work, memory, qd, packs),
            }
        }
        Moments::General(sections) => momenta(plan, &General(sections), work, memory, qd, piece.packs),
    }
    let packs = piece.packs;
    let force = &memory.load[..packs];
    for component in &piece.components {
        let own = component.first..component.first + component.modes;
        for (j, k) in own.clone().enumerate() {
            let psi = &memory.psi[k * packs..][..packs];
            let [inertial] = products::<G, 1>(psi, force);
            tau[k] = inertial + component.elastic_force(j, &q[own.clone()], &qd[own.clone()], mu);
            for j in 0..=k {
                let [entry] = products::<G, 1>(psi, &memory.source[j * packs..][..packs]);
                (mass[(j, k)], mass[(k, j)]) = (entry, entry);
            }
        }
    }
    for coupling in &piece.couplings {
        coupling.add_elastic_force(q, qd, mu, tau);
    }
}

/// Psi and `N Psi` of all coordinates, and the forces per length, at the nodes; the latter times the quadrature weights.
#[inline(always)]
fn momenta<G: Turning>(
    plan: &Plan<G>,
    sections: &impl Sections<G>,
    work: &Workspace<G>,
    memory: &mut TangentWorkspace<G>,
    qd: &[f64],
    packs: usize,
) {
    let piece = &plan.pieces[0];
    let (rotation, position) = (&work.rotation[..packs], &work.position[..packs]);
    let base = &work.stations[piece.joined.carrier()];
    // Slices of equal length avoid bounds checks below.
    let (weights, integrand) = (&piece.weights[..packs], &mut memory.integrand[..packs]);
    let (rate, velocity) = (&mut memory.psi_rate[..packs], &mut memory.psi_acceleration[..packs]);
    let force = &mut memory.load[..packs];
    let rows = || piece.from_base.chunks_exact(packs * LANES);

    rate.fill(Twist::zero());
    velocity.fill(base.velocity.splat());
    for component in &piece.components {
        let shapes = &mut memory.shape[..packs];
        for (pack, to) in shapes.iter_mut().enumerate() {
            *to = shape(&rotation[pack], position[pack], component.index);
        }
        for (degree, basis) in piece.basis.chunks_exact(packs).take(component.modes).enumerate() {
            let k = component.first + degree;
            let qd = G::Pack::splat(qd[k]);
            for pack in 0..packs {
                integrand[pack] = shapes[pack] * basis[pack];
                rate[pack] = rate[pack].add_scaled(integrand[pack], qd);
            }
            let psi = &mut memory.psi[k * packs..][..packs];
            for (pack, row) in rows().enumerate() {
                psi[pack] = weighted_sum(Twist::zero(), row, integrand, Twist::add_lane);
                velocity[pack] = velocity[pack].add_scaled(psi[pack], qd);
            }
        }
    }
    for pack in 0..packs {
        integrand[pack] = velocity[pack].bracket(rate[pack]);
    }
    let start = base.acceleration.splat();
    for (pack, row) in rows().enumerate() {
        let acceleration = weighted_sum(start, row, integrand, Twist::add_lane);
        let inertia = sections.about_origin(plan.frame, pack, &rotation[pack], position[pack]);
        let momentum = inertia.momentum(velocity[pack]);
        let of_inertia = inertia.momentum(acceleration) - velocity[pack].bracket_transposed(momentum);
        force[pack] = of_inertia * weights[pack];
        for k in 0..piece.n {
            let at = k * packs + pack;
            memory.source[at] = inertia.momentum(memory.psi[at]) * weights[pack];
        }
    }
}
