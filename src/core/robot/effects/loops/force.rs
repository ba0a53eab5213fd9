//! Closed loops: the wrenches of multipliers, on the second end of a tie and opposite on the first one. With
//! fixed directions they are dead loads, which the sweeps handle; [`CoordinateForce::stiffen`] adds the effect of
//! changing directions to the tangent.

use crate::numerics::lie::{Sweep, Vector, Wrench};
use crate::numerics::linalg::Matrix;
use crate::robot::algebra::inertia::Gyroscope;
use crate::robot::algebra::tie::Frame;
use crate::robot::effects::kinds::{
    CoordinateForce, DeadPointWrench, NoDissipation, NoPointResponse, NoPointWrench, NoStoredEnergy,
    NoSupply, NoVelocityDependence, NotAlongRods,
};
use crate::robot::effects::loops::plan::TiePlan;
use crate::robot::effects::loops::state::LoopTangent;
use crate::robot::plan::Plan;
use crate::robot::plan::point::Point;
use crate::robot::state::Workspace;
use crate::robot::state::point::PointState;
use crate::robot::state::tangent::{Tangent, TangentWorkspace, Weights};
use crate::robot::turning::Turning;

/// The closed loops of a plan.
pub(crate) struct ClosedLoops;

/// Frames of the ends of a tie, with the kinematics up to date.
pub(crate) fn frames<G: Turning>(plan: &Plan<G>, work: &Workspace<G>, tie: &TiePlan<G::Pack>) -> [Frame; 2] {
    std::array::from_fn(|e| {
        let end = &tie.ends[e];
        let Some(on) = &end.on else { return work.effects.loops.world_ends[tie.number][e].frame };
        let state = &work.points[on.point];
        let axes = G::rotation_in_space(plan.frame, &state.rotation);
        let Frame { position, axes: beside } = end.frame;
        Frame {
            position: G::in_space(plan.frame, state.position) + axes.apply(position),
            axes: axes.times(&beside),
        }
    })
}

/// Moment about the second origin, and force there, of the multipliers on the second end.
pub(crate) fn constraint_wrench<P>(
    tie: &TiePlan<P>,
    frames: &[Frame; 2],
    multipliers: &[f64],
) -> [Vector<f64>; 2] {
    let mut sum = [Vector::zero(); 2];
    for (row, &multiplier) in tie.rows.iter().zip(&multipliers[tie.first..]) {
        let [moment, force] = row.wrench(frames);
        sum = [sum[0].add_scaled(moment, multiplier), sum[1].add_scaled(force, multiplier)];
    }
    sum
}

/// Wrench required at an end of a tie against the multipliers, about its own origin, and the position of this
/// origin.
fn needed_at<G: Turning>(
    plan: &Plan<G>,
    work: &Workspace<G>,
    tied: usize,
) -> (Wrench<G, f64>, G::Vector<f64>) {
    let (i, end) = (tied / 2, tied % 2);
    let tie = &plan.effects.loops.ties[i];
    let frames = &work.effects.loops.frames[i];
    let [mut moment, mut force] = constraint_wrench(tie, frames, &work.effects.loops.multipliers);
    if end == 0 {
        let way = frames[1].position - frames[0].position;
        (moment, force) = (-(moment + way.cross(force)), -force);
    }
    let wrench = Wrench { moment: G::axial_of(plan.frame, moment), force: G::vector_of(plan.frame, force) };
    (wrench, G::vector_of(plan.frame, frames[end].position))
}

impl<G: Turning> DeadPointWrench<G> for ClosedLoops {
    #[inline(always)]
    fn dead_at(
        plan: &Plan<G>,
        work: &Workspace<G>,
        point: &Point<G>,
        _: &PointState<G>,
        sum: &mut Gyroscope<G, f64>,
    ) {
        for &tied in &point.effects.tied {
            let (Wrench { moment, force }, position) = needed_at(plan, work, tied);
            sum.add(Gyroscope::of_dead_load(Wrench { moment: -moment, force: -force }, position));
        }
    }
}

impl<G: Turning> CoordinateForce<G> for ClosedLoops {
    fn acts(plan: &Plan<G>) -> bool {
        !plan.effects.loops.ties.is_empty() || !plan.effects.loops.gears.is_empty()
    }

    #[inline(always)]
    fn prepare(plan: &Plan<G>, work: &mut Workspace<G>, _: &[f64], _: &[f64]) {
        for (i, tie) in plan.effects.loops.ties.iter().enumerate() {
            work.effects.loops.frames[i] = frames(plan, work, tie);
            for (e, end) in tie.ends.iter().enumerate() {
                if let Some(on) = &end.on {
                    let (wrench, position) = needed_at(plan, work, 2 * i + e);
                    work.points[on.point].force += wrench.at(position);
                }
            }
        }
    }

    #[inline(always)]
    fn push(plan: &Plan<G>, work: &Workspace<G>, tau: &mut [f64]) {
        let first = plan.effects.loops.first_gear();
        let multipliers = &work.effects.loops.multipliers[first..];
        for (gear, &multiplier) in plan.effects.loops.gears.iter().zip(multipliers) {
            tau[gear.coordinates[0]] += multiplier;
            tau[gear.coordinates[1]] -= gear.ratio * multiplier;
        }
    }

    /// Let `(m; f)` be the wrench of the multipliers on the second end, about its origin. Its change
    /// `(dm; df)` acts there and oppositely on the first end, where the moment also changes with the vector
    /// between the origins.
    #[inline(always)]
    fn stiffen(
        plan: &Plan<G>,
        work: &Workspace<G>,
        memory: &mut TangentWorkspace<G>,
        weights: Weights,
        tangent: &mut Tangent<'_>,
    ) {
        // Robots with loops that couple branches use the dense solver.
        let Tangent::Dense(matrix) = tangent else { return };
        if weights.q == 0.0 {
            return;
        }
        for i in 0..plan.effects.loops.ties.len() {
            let sweep =
                Stiffen { plan, work, memory: &mut memory.effects.loops, weight: weights.q, matrix, tie: i };
            plan.instructions.run_outlined::<G::Pack, _>(sweep);
        }
    }

    fn couples_pieces(plan: &Plan<G>) -> bool {
        plan.effects.loops.rows > 0
    }
}

impl NotAlongRods for ClosedLoops {}
impl NoPointWrench for ClosedLoops {}
impl NoPointResponse for ClosedLoops {}
impl NoStoredEnergy for ClosedLoops {}
impl NoDissipation for ClosedLoops {}
impl NoSupply for ClosedLoops {}
impl NoVelocityDependence for ClosedLoops {}

/// Adds the derivative of the forces of a tie. Cost: 12 products per entry.
struct Stiffen<'a, G: Turning> {
    plan: &'a Plan<G>,
    work: &'a Workspace<G>,
    memory: &'a mut LoopTangent,
    weight: f64,
    matrix: &'a mut Matrix,
    tie: usize,
}

impl<G: Turning> Sweep for Stiffen<'_, G> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Self { plan, work, memory, weight, matrix, tie: i } = self;
        let tie = &plan.effects.loops.ties[i];
        let multipliers = &work.effects.loops.multipliers[tie.first..][..tie.rows.len()];
        if multipliers.iter().all(|&multiplier| multiplier == 0.0) {
            return;
        }
        let LoopTangent { moved, components, .. } = memory;
        let (n, frames, moved) = (plan.n, &work.effects.loops.frames[i], &moved[i * plan.n..][..plan.n]);
        for (k, [first, second]) in moved.iter().enumerate() {
            for (m, motion) in [first[0], first[1], second[0], second[1]].into_iter().enumerate() {
                for (c, x) in motion.to_array().into_iter().enumerate() {
                    components[3 * m + c][k] = x;
                }
            }
        }
        let way = frames[1].position - frames[0].position;
        let [_, force] = constraint_wrench(tie, frames, &work.effects.loops.multipliers);
        for &k in &tie.reaches {
            let mut change = [Vector::zero(); 2];
            for (row, &multiplier) in tie.rows.iter().zip(multipliers) {
                let [moment, force] = row.change(frames, &moved[k]);
                let factor = weight * multiplier;
                change = [change[0].add_scaled(moment, factor), change[1].add_scaled(force, factor)];
            }
            let [of_first, of_second] = moved[k];
            let way_changes = (of_second[1] - of_first[1]) * weight;
            let about_first = change[0] + way.cross(change[1]) + way_changes.cross(force);
            let answers = [-about_first, -change[1], change[0], change[1]];
            let column = &mut matrix.as_mut_slice()[k * n..][..n];
            for (m, answer) in answers.into_iter().enumerate() {
                let [x, y, z] = answer.to_array();
                let [of_x, of_y, of_z] = [0, 1, 2].map(|c| &components[3 * m + c][..n]);
                for (((entry, of_x), of_y), of_z) in column.iter_mut().zip(of_x).zip(of_y).zip(of_z) {
                    *entry += of_x * x + of_y * y + of_z * z;
                }
            }
        }
    }
}
