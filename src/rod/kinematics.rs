//! Where the rod is: rotations from the curvature, positions by integration.

use super::plan::{Plan, SegmentPlan};
use super::points;
use super::turning::{Passage, Turning};
use super::workspace::Workspace;
use crate::lie::{Cross, LANES, Lanes, Rotation, Scalar, Twist, Vector, VectorSpace, weighted_sum};

/// A place of a rod in the world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose {
    /// Body axes in world coordinates.
    pub rotation: Rotation<f64>,
    /// Position in metres.
    pub position: Vector<f64>,
}

/// Derivative of the position along the rod at the nodes of one pack: `R gamma`.
#[inline(always)]
fn slope<G: Turning>(
    segment: &SegmentPlan<G>,
    frame: G::Frame,
    q: &[f64],
    pack: usize,
    rotation: &G::Rotation<G::Pack>,
) -> G::Vector<G::Pack> {
    if segment.is_extensible {
        G::rotate(rotation, segment.field(q, pack).linear + segment.reference_slope[pack])
    } else {
        G::rod_axis(frame, rotation)
    }
}

/// Rotations and positions of all nodes and stations for the coordinates `q`, unless they are there already.
#[inline(always)]
pub(super) fn update<G: Turning>(plan: &Plan<G>, work: &mut Workspace<G>, q: &[f64]) {
    if work.kinematics_of == q {
        return;
    }
    work.kinematics_of.clear();
    work.kinematics_of.extend_from_slice(q);
    // Whatever was computed of the motion belongs to another shape.
    work.motion_is_known = false;
    for (s, segment) in plan.segments.iter().enumerate() {
        let rotations = &mut work.rotation[segment.node_packs()];
        let base = work.stations[s];
        let end = &mut work.stations[s + 1];
        end.orientation = G::turn(segment, q, base.orientation, rotations);

        let slopes = &mut work.slope[segment.node_packs()];
        for (pack, (slope, rotation)) in slopes.iter_mut().zip(rotations.iter()).enumerate() {
            *slope = self::slope(segment, plan.frame, q, pack, rotation);
        }
        let start = G::map_vector(&base.position, |&x| G::Pack::splat(x));
        let mut total = G::Vector::<G::Pack>::zero();
        let positions = &mut work.position[segment.node_packs()];
        for (pack, position) in positions.iter_mut().enumerate() {
            let row = segment.row(&segment.from_base, pack);
            *position = weighted_sum(start, row, slopes, |sum, slope, lane, weight| {
                sum.add_scaled(
                    G::map_vector(slope, |component: &G::Pack| G::Pack::splat(component.lane(lane))),
                    weight,
                )
            });
            total = total.add_scaled(slopes[pack], segment.weights[pack]);
        }
        end.position = base.position + G::map_vector(&total, |pack: &G::Pack| pack.sum());
        points::find(plan, segment, s, work, q);
    }
}

/// A place along a rod, prepared for finding its pose in many states.
#[derive(Clone, Debug)]
pub struct Place {
    pub(super) segment: usize,
    /// Fraction of the segment's length.
    pub(super) x: f64,
    /// Nodes of the segment before the place, and the way from the last of them (from the segment's base if there is none).
    before: usize,
    passage: Passage,
    /// Weights of the integral from the segment's base, times its length.
    pub(super) weights: Vec<f64>,
}

/// The place at arc length `x` of the unstretched rod, clamped to [0, L].
pub(super) fn place<G: Turning>(segments: &[SegmentPlan<G>], x: f64) -> Place {
    let (mut s, mut start) = (0, 0.0);
    while s + 1 < segments.len() && x > start + segments[s].length {
        start += segments[s].length;
        s += 1;
    }
    // Rounding of the sum of lengths must not lead outside.
    place_in(segments, s, ((x - start) / segments[s].length).clamp(0.0, 1.0))
}

/// The place at the fraction `x` of segment `s`.
pub(super) fn place_in<G: Turning>(segments: &[SegmentPlan<G>], s: usize, x: f64) -> Place {
    let segment = &segments[s];
    let before = segment.gauss.nodes.partition_point(|&node| node <= x);
    let from = if before == 0 { 0.0 } else { segment.gauss.nodes[before - 1] };
    let passage = G::passage(segment, from, x);
    let weights = segment.gauss.weights_up_to(x).into_iter().map(|weight| weight * segment.length).collect();
    Place { segment: s, x, before, passage, weights }
}

/// The rotation at a place, with those of the nodes up to date.
#[inline(always)]
pub(super) fn rotation_at<G: Turning>(
    segment: &SegmentPlan<G>,
    work: &Workspace<G>,
    q: &[f64],
    place: &Place,
) -> G::Rotation<f64> {
    let before = match place.before {
        0 => G::matrix(work.stations[place.segment].orientation),
        i => {
            let packs = &work.rotation[segment.first_pack + (i - 1) / LANES];
            G::map_rotation(packs, |entry: &G::Pack| entry.lane((i - 1) % LANES))
        }
    };
    G::compose(&before, &G::pass(segment, q, &place.passage))
}

/// The pose at a place, with the kinematics up to date.
pub(super) fn pose<G: Turning>(plan: &Plan<G>, work: &Workspace<G>, q: &[f64], place: &Place) -> Pose {
    let segment = &plan.segments[place.segment];
    let rotation = rotation_at(segment, work, q, place);
    let position = position(plan, work, place);
    let base = &work.surroundings.base.rotation;
    let Rotation { x, y, z } = G::rotation_in_space(plan.frame, &rotation);
    Pose {
        rotation: Rotation { x: base.apply(x), y: base.apply(y), z: base.apply(z) },
        position: work.surroundings.base.position + base.apply(G::in_space(plan.frame, position)),
    }
}

/// The position of a place in the frame, with the kinematics up to date.
pub(super) fn position<G: Turning>(plan: &Plan<G>, work: &Workspace<G>, place: &Place) -> G::Vector<f64> {
    let mut position = work.stations[place.segment].position;
    let slopes = &work.slope[plan.segments[place.segment].node_packs()];
    for (i, &weight) in place.weights.iter().enumerate() {
        position +=
            G::map_vector(&slopes[i / LANES], |component: &G::Pack| component.lane(i % LANES)) * weight;
    }
    position
}

/// Angular velocity of a place and velocity of its point, in world axes, with the motion up to date.
pub(super) fn velocity<G: Turning>(plan: &Plan<G>, work: &Workspace<G>, place: &Place) -> [Vector<f64>; 2] {
    let Twist { mut angular, mut linear } = work.stations[place.segment].velocity;
    let rates = &work.rate[plan.segments[place.segment].node_packs()];
    for (i, &weight) in place.weights.iter().enumerate() {
        let (rate, lane) = (&rates[i / LANES], i % LANES);
        angular += G::map_axial(&rate.angular, |component: &G::Pack| component.lane(lane)) * weight;
        linear += G::map_vector(&rate.linear, |component: &G::Pack| component.lane(lane)) * weight;
    }
    let velocity = linear + angular.cross(position(plan, work, place));
    let base = &work.surroundings.base;
    let turned = |v| base.rotation.apply(v);
    let velocity = turned(G::in_space(plan.frame, velocity)) + base.velocity;
    [turned(G::axial_in_space(plan.frame, angular)), velocity]
}
