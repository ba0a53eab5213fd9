//! Exact tangent of the inverse dynamics, with all columns in one sweep.
//!
//! For a variation of coordinate k by (dq, dqd, dqdd) = (w_q, w_v, w_a), let Y = dV - ad_Psi V and Z = dA -
//! ad_Psi A + ad_V Y be the variations of velocity and acceleration relative to the moving material. Then the
//! tangent (`docs/theory.md`) reduces to integrals over the piece of coordinate k only:
//!
//! ```text
//! Y' = w_v S + w_q ad_V S
//! Z' = w_a S + 2 w_v ad_V S + w_q (ad_A + ad_V ad_V) S
//! H' = -(N Z + C Y) + w_q ad_S^T F          with C Y = -(N ad_V + ad_V^T N) Y - ad_Y^T N V
//! dtau_j = int S_j . H + (w_q K + w_v D)_jk
//! ```
//!
//! With `Psi = int S` of one coordinate, `Psi' = int ad_V S` and `Psi'' = int (ad_A + ad_V ad_V) S`, all from
//! the base of its piece, Y and Z are sums of these three. By summation by parts (exact for this quadrature)
//! `int S_j . H = Psi_j . H_end + int Psi_j . (N Z + C Y - w_q ad_S^T F)`.
//!
//! Springs and the fluid respond to all components of Y and of the displacement `w_q Psi` (see `response`).
//!
//! Outside its own piece a coordinate's Y and Z are constant; its H is constant before the piece, and linear
//! in (Y, Z) beyond it. Blocks between different pieces thus have rank 12 at most and cost a few products per
//! entry. The rotation of the material is needed only for dead loads (all components of Y and of the
//! displacement for springs or fluid); follower loads rotate with the material and do not change relative to
//! it.

mod blocks;
mod column;
mod hinge;
mod points;
mod responses;
mod row;
mod scope;

pub(super) use self::blocks::products;
pub(super) use self::points::gyroscopes;
use self::scope::Scope;
use super::{elasticity, lines, loops, tree};
use crate::numerics::lie::{Scalar, Sweep};
use crate::robot::algebra::inertia::InertiaAboutOrigin as _;
use crate::robot::algebra::inertia::{General, Gyroscope, Inertia, Round, Sections};
use crate::robot::effects;
use crate::robot::plan::Plan;
use crate::robot::plan::material::Moments;
use crate::robot::state::Workspace;
use crate::robot::state::tangent::{Rest, Tangent, TangentWorkspace, Weights};
use crate::robot::turning::Turning;
use crate::robot::turning::columns::shape;

/// `w_q dtau/dq + w_v dtau/dqd + w_a dtau/dqdd`, with the motion up to date (for the mass matrix, weights (0,
/// 0, w_a), only the kinematics). The matrix of a tree must have the structure of [`tree::tangent`] or
/// [`tree::mass`].
#[inline(always)]
pub(crate) fn weighted_tangent<G: Turning>(
    plan: &Plan<G>,
    work: &Workspace<G>,
    memory: &mut TangentWorkspace<G>,
    [q, v, a]: [f64; 3],
    mut tangent: Tangent<'_>,
) {
    let weights = Weights { q, v, a, is_mass_only: q == 0.0 && v == 0.0 };
    let mut rest = Rest::zero();
    if plan.has_branches {
        for carried in &mut memory.carried {
            carried.set(&rest, plan.has_responses);
        }
        if let Tangent::Dense(matrix) = &mut tangent {
            matrix.fill(0.0);
        }
    }
    for (s, piece) in plan.pieces.iter().enumerate().rev() {
        let scope = Scope {
            plan,
            piece,
            work,
            weights,
            has_points: !piece.points.inside.is_empty(),
            has_dead: !weights.is_mass_only && effects::is_dead_along(plan, piece),
            has_responses: effects::responds_along(piece),
        };
        let is_carried = !piece.joined.ancestors.is_empty();
        if plan.has_branches {
            rest.set(&memory.carried[piece.joined.end], plan.has_responses);
        }
        points::add_to_rest(plan, work, piece.points.at_end.clone(), weights, &mut rest);
        if piece.packs == 0 {
            let block = tangent.block(s, piece).0;
            let sweep =
                hinge::WithoutNodes { scope: &scope, memory: &mut *memory, rest: &rest, is_carried, block };
            plan.instructions.run_outlined::<G::Pack, _>(sweep);
            memory.carry(plan, piece, &rest);
            continue;
        }
        memory.points.prepare(plan, piece, work, weights, &memory.carried);
        scope.nodes(memory);
        scope.shapes(memory);
        for (c, component) in piece.components.iter().enumerate() {
            for degree in 0..component.modes {
                if weights.is_mass_only {
                    scope.column_of_mass(memory, &rest, c, degree);
                    continue;
                }
                scope.column(memory, &rest, c, degree);
                if is_carried {
                    scope.row(memory, &rest, component.first + degree);
                }
            }
        }
        let (entries, stride) = tangent.block(s, piece);
        scope.own_block(memory, entries, stride);
        elasticity::add_to_tangent(piece, [q, v], entries, stride);
        if is_carried {
            scope.add_to_rest(memory, &mut rest);
        }
        memory.carry(plan, piece, &rest);
    }
    match &mut tangent {
        Tangent::Dense(matrix) => blocks::others(plan, memory, weights, matrix),
        Tangent::Tree(matrix) => tree::generate(plan, memory, weights.is_mass_only, matrix),
    }
    if !weights.is_mass_only {
        lines::find(plan, work, &mut memory.effects.actuation);
        loops::find(plan, work, &mut memory.effects.loops);
        effects::stiffen(plan, work, memory, weights, &mut tangent);
    }
}

/// N and C at all nodes of a piece, times the quadrature weights.
#[inline(always)]
fn sections_in_motion<G: Turning>(
    scope: &Scope<'_, G>,
    sections: &impl Sections<G>,
    inertias: &mut [Inertia<G, G::Pack>],
    gyroscopes: &mut [Gyroscope<G, G::Pack>],
) {
    let &Scope { plan, piece, work, weights, .. } = scope;
    for pack in 0..piece.packs {
        let node = piece.first_pack + pack;
        let weight = piece.weights[pack];
        let about_origin = sections.about_origin(plan.frame, pack, &work.rotation[node], work.position[node]);
        let inertia = about_origin.weighted(weight);
        inertias[pack] = inertia;
        if !weights.is_mass_only {
            gyroscopes[pack] = Gyroscope::new(&inertia, work.velocity[node], work.momentum[node] * weight);
        }
    }
}

/// [`sections_in_motion`] for general sections.
struct SectionsInMotion<'a, G: Turning> {
    scope: &'a Scope<'a, G>,
    sections: General<'a, G>,
    inertias: &'a mut [Inertia<G, G::Pack>],
    gyroscopes: &'a mut [Gyroscope<G, G::Pack>],
}

impl<G: Turning> Sweep for SectionsInMotion<'_, G> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        sections_in_motion(self.scope, &self.sections, self.inertias, self.gyroscopes);
    }
}

impl<G: Turning> Scope<'_, G> {
    /// Inertia, motion and forces at the nodes.
    #[inline(always)]
    fn nodes(&self, memory: &mut TangentWorkspace<G>) {
        let &Self { plan, piece, work, weights, .. } = self;
        let (inertias, gyroscopes) = (&mut memory.inertia[..], &mut memory.gyroscope[..]);
        match &piece.moments {
            Moments::Round(rotary) => {
                sections_in_motion(self, &Round { mass: &piece.mass, rotary }, inertias, gyroscopes);
            }
            Moments::General(sections) => {
                let sections = General(sections);
                let sweep = SectionsInMotion { scope: self, sections, inertias, gyroscopes };
                plan.instructions.run_outlined::<G::Pack, _>(sweep);
            }
        }
        if self.has_dead {
            effects::dead_along(plan, piece, work, &mut memory.dead[..piece.packs]);
        }
        if self.has_responses {
            let responses = &mut memory.response[..piece.packs];
            effects::respond_along(plan, piece, work, weights.is_mass_only, responses);
        }
    }

    /// S, ad_V S, (ad_A + ad_V ad_V) S and w_q ad_S^T F at all nodes for a unit of each strain component.
    #[inline(always)]
    fn shapes(&self, memory: &mut TangentWorkspace<G>) {
        let &Self { piece, work, weights, .. } = self;
        for (c, component) in piece.components.iter().enumerate() {
            for pack in 0..piece.packs {
                let node = piece.first_pack + pack;
                let rotation = &work.rotation[node];
                memory.shape[c * piece.packs + pack] = shape(rotation, work.position[node], component.index);
            }
        }
        if weights.is_mass_only {
            return;
        }
        for c in 0..piece.components.len() {
            for pack in 0..piece.packs {
                let node = piece.first_pack + pack;
                let block = c * piece.packs + pack;
                let (shape, velocity) = (memory.shape[block], work.velocity[node]);
                let rate = velocity.bracket(shape);
                memory.shape_rate[block] = rate;
                memory.shape_acceleration[block] =
                    velocity.bracket_add(rate, work.acceleration[node].bracket(shape));
                memory.load[block] =
                    shape.bracket_transposed(work.internal[node]) * G::Pack::splat(weights.q);
            }
        }
    }

    /// Adds the piece to the sums of what lies beyond a place.
    #[inline(always)]
    fn add_to_rest(&self, memory: &TangentWorkspace<G>, rest: &mut Rest<G>) {
        let &Self { plan, piece, work, weights, .. } = self;
        for pack in 0..piece.packs {
            rest.inertia.add(memory.inertia[pack].sum());
            if !weights.is_mass_only {
                rest.gyroscope.add(memory.gyroscope[pack].sum());
            }
        }
        if self.has_dead {
            for dead in &memory.dead[..piece.packs] {
                rest.dead.add(dead.sum());
            }
        }
        if self.has_responses {
            let responses = &memory.response[..piece.packs];
            plan.instructions
                .run_outlined::<G::Pack, _>(responses::Sum { responses, sum: &mut rest.response });
        }
        points::add_to_rest(plan, work, piece.points.inside.clone(), weights, rest);
        points::add_carried(plan, piece, &memory.carried, rest);
    }
}
