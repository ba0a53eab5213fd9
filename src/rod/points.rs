//! What is concentrated at places of the rod: forces, moments, rigid bodies, springs to the world.
//!
//! A place X inside a segment is reached by the weights u_l of the integral up to it: what lies there moves by
//! `Psi(X) = sum_l u_l S_l`. A wrench W there has the generalised forces `Psi_j(X) . W = sum_l w_l S_j,l . (u_l / w_l) W` with the
//! quadrature weights w_l: node l carries the share u_l / w_l of it. So a segment need not end there, nothing is smeared out,
//! and the summation by parts behind the tangent stays exact.

use std::ops::Range;

use super::body::Body;
use super::inertia::Inertia;
use super::kinematics::{self, Place};
use super::load::{Extent, Frame};
use super::plan::{Load, Plan, SegmentPlan, packed};
use super::support::Support;
use super::turning::Turning;
use super::workspace::Workspace;
use crate::lie::{Lanes, Twist, VectorSpace, Wrench};

/// All that is concentrated at one place.
#[derive(Clone, Debug)]
pub(super) struct Point<G: Turning> {
    place: Place,
    /// How the nodes of the segment reach it; nothing at the end of a segment, which is a station.
    inside: Option<Inside<G>>,
    /// The bodies there together, about the place and in the section's axes.
    pub(super) body: Option<Inertia<G, f64>>,
    /// The loads that act there.
    pub(super) loads: Vec<usize>,
    /// The anchors of the springs that hold it.
    pub(super) anchors: Vec<usize>,
    /// Whether it matters how the section is turned.
    pub(super) is_oriented: bool,
}

/// How the nodes of a segment reach a place inside it.
#[derive(Clone, Debug)]
pub(super) struct Inside<G: Turning> {
    /// Weights of the integral up to the place, times the length.
    pub(super) up_to: Vec<G::Pack>,
    /// The share of a wrench at the place that each node carries.
    share: Vec<G::Pack>,
}

/// What is known of a place in a state.
#[derive(Clone, Copy, Debug)]
pub(super) struct PointState<G: Turning> {
    pub(super) position: G::Vector<f64>,
    pub(super) rotation: G::Rotation<f64>,
    /// Of the bodies, about the origin.
    pub(super) inertia: Inertia<G, f64>,
    pub(super) velocity: Twist<G, f64>,
    /// Acceleration minus gravity.
    acceleration: Twist<G, f64>,
    pub(super) momentum: Wrench<G, f64>,
    /// What the motion of the bodies needs, less the loads.
    force: Wrench<G, f64>,
}

impl<G: Turning> PointState<G> {
    pub(super) fn new() -> Self {
        Self {
            position: VectorSpace::zero(),
            rotation: G::unrotated(),
            inertia: Inertia::zero(),
            velocity: Twist::zero(),
            acceleration: Twist::zero(),
            momentum: Wrench::zero(),
            force: Wrench::zero(),
        }
    }
}

/// Where the points of a segment stand among those of the rod.
#[derive(Clone, Debug, Default)]
pub(super) struct Points {
    pub(super) inside: Range<usize>,
    /// At most one, as all that is at one place makes one point.
    pub(super) at_end: Range<usize>,
}

impl Points {
    pub(super) fn all(&self) -> Range<usize> {
        self.inside.start..self.at_end.end
    }
}

/// All that is concentrated on a rod with these segments, in the order of the places, and at which of these points each
/// support acts; tells the segments which points are theirs.
pub(super) fn compile<G: Turning>(
    frame: G::Frame,
    segments: &mut [SegmentPlan<G>],
    loads: &[Load<G>],
    bodies: impl Iterator<Item = Body>,
    supports: &[Support],
) -> (Vec<Point<G>>, Vec<usize>) {
    let length: f64 = segments.iter().map(|segment| segment.length).sum();
    let mut points: Vec<Point<G>> = Vec::new();
    for (l, load) in loads.iter().enumerate() {
        let x = match load.extent {
            Extent::Tip => length,
            Extent::At(x) => x,
            Extent::Along(_) => continue,
        };
        let point = point_at(&mut points, segments, x);
        point.loads.push(l);
        point.is_oriented |= load.frame == Frame::Body;
    }
    for body in bodies {
        let point = point_at(&mut points, segments, body.at.unwrap_or(length));
        point.is_oriented |= body.centre != [0.0; 3] || body.inertia != [[0.0; 3]; 3];
        let first_moment = G::vector_of(frame, body.centre.into()) * body.mass;
        let second_moment = G::second_moment_of(frame, body.inertia_about_section());
        point.body.get_or_insert(Inertia::zero()).add(Inertia {
            mass: body.mass,
            first_moment,
            second_moment,
        });
    }
    for (a, support) in supports.iter().enumerate() {
        let point = point_at(&mut points, segments, support.at.unwrap_or(length));
        point.anchors.push(a);
        point.is_oriented = true;
    }
    let order = |point: &Point<G>| (point.place.segment, point.place.x);
    points.sort_by(|a, b| order(a).partial_cmp(&order(b)).expect("places are finite"));
    for (s, segment) in segments.iter_mut().enumerate() {
        let first = points.partition_point(|point| point.place.segment < s);
        let end = points.partition_point(|point| point.place.segment <= s);
        let inside = points[first..end].iter().filter(|point| point.inside.is_some()).count();
        segment.points = Points { inside: first..first + inside, at_end: first + inside..end };
    }
    let holds = |a: usize| points.iter().position(|point| point.anchors.contains(&a));
    let supported = (0..supports.len()).filter_map(holds).collect();
    (points, supported)
}

/// The point at arc length `x` of the rod, a new one if there is none yet.
fn point_at<'a, G: Turning>(
    points: &'a mut Vec<Point<G>>,
    segments: &[SegmentPlan<G>],
    x: f64,
) -> &'a mut Point<G> {
    let place = kinematics::place(segments, x);
    let is_there = |point: &Point<G>| (point.place.segment, point.place.x) == (place.segment, place.x);
    let i = points.iter().position(is_there).unwrap_or_else(|| {
        points.push(Point::new(&segments[place.segment], place));
        points.len() - 1
    });
    &mut points[i]
}

impl<G: Turning> Point<G> {
    /// A place with nothing there.
    fn new(segment: &SegmentPlan<G>, place: Place) -> Self {
        let inside = (place.x < 1.0).then(|| {
            let nodes = place.weights.len();
            let weight = |i: usize| segment.length * segment.gauss.weights[i];
            Inside {
                up_to: packed(nodes, |i| place.weights[i]),
                share: packed(nodes, |i| place.weights[i] / weight(i)),
            }
        });
        Self { place, inside, body: None, loads: Vec::new(), anchors: Vec::new(), is_oriented: false }
    }

    /// How the nodes reach a point that [`Points::inside`] names.
    #[inline(always)]
    pub(super) fn reach(&self) -> &Inside<G> {
        self.inside.as_ref().expect("points inside a segment are reached from its nodes")
    }

    /// The wrench of a load at this point, about the point.
    #[inline(always)]
    pub(super) fn wrench(
        &self,
        load: usize,
        plan: &Plan<G>,
        work: &Workspace<G>,
        state: &PointState<G>,
    ) -> Wrench<G, f64> {
        let wrench = work.acting[load];
        match plan.loads[load].frame {
            Frame::World => wrench,
            Frame::Body => wrench.rotated(&state.rotation),
        }
    }
}

impl<G: Turning> Inside<G> {
    /// The integral up to the place of what has these values at the nodes.
    #[inline(always)]
    pub(super) fn integral(&self, values: &[Twist<G, G::Pack>]) -> Twist<G, f64> {
        let mut sum = Twist::zero();
        for (&weight, &value) in self.up_to.iter().zip(values) {
            sum += value * weight;
        }
        sum.sum()
    }
}

/// Positions, rotations and inertia at the points of segment `s`, with the kinematics of the segment up to date.
#[inline(always)]
pub(super) fn find<G: Turning>(
    plan: &Plan<G>,
    segment: &SegmentPlan<G>,
    s: usize,
    work: &mut Workspace<G>,
    q: &[f64],
) {
    for p in segment.points.all() {
        let point = &plan.points[p];
        let (position, rotation) = match &point.inside {
            Some(inside) => {
                let mut change = G::Vector::<G::Pack>::zero();
                for (&weight, &slope) in inside.up_to.iter().zip(&work.slope[segment.node_packs()]) {
                    change += slope * weight;
                }
                let position =
                    work.stations[s].position + G::map_vector(&change, |pack: &G::Pack| pack.sum());
                let is_oriented = point.is_oriented;
                let rotation = is_oriented.then(|| kinematics::rotation_at(segment, work, q, &point.place));
                (position, rotation)
            }
            None => {
                let end = &work.stations[s + 1];
                (end.position, point.is_oriented.then(|| G::matrix(end.orientation)))
            }
        };
        let state = &mut work.points[p];
        state.position = position;
        state.rotation = rotation.unwrap_or_else(G::unrotated);
        if let Some(body) = &point.body {
            state.inertia = body.carried(&state.rotation, position);
        }
    }
}

/// Motion and force at the points of segment `s`, with the motion of the segment up to date.
#[inline(always)]
pub(super) fn drive<G: Turning>(plan: &Plan<G>, segment: &SegmentPlan<G>, s: usize, work: &mut Workspace<G>) {
    for p in segment.points.all() {
        let point = &plan.points[p];
        let mut state = work.points[p];
        let motion = match &point.inside {
            Some(inside) => {
                let nodes = segment.node_packs();
                let base = &work.stations[s];
                let velocity = base.velocity + inside.integral(&work.rate[nodes.clone()]);
                let acceleration = base.acceleration + inside.integral(&work.acceleration_rate[nodes]);
                (velocity, acceleration)
            }
            None => (work.stations[s + 1].velocity, work.stations[s + 1].acceleration),
        };
        (state.velocity, state.acceleration) = motion;
        state.force = Wrench::zero();
        if point.body.is_some() {
            state.momentum = state.inertia.momentum(state.velocity);
            state.force = state.inertia.momentum(state.acceleration)
                - state.velocity.bracket_transposed(state.momentum);
        }
        for &load in &point.loads {
            state.force = state.force - point.wrench(load, plan, work, &state).at(state.position);
        }
        for &anchor in &point.anchors {
            state.force = state.force - work.anchors[anchor].wrench(plan.frame, &state).at(state.position);
        }
        work.points[p] = state;
    }
}

/// The wrench that the points at the end of a segment need.
#[inline(always)]
pub(super) fn at_end<G: Turning>(segment: &SegmentPlan<G>, work: &Workspace<G>) -> Wrench<G, f64> {
    let mut sum = Wrench::zero();
    for point in &work.points[segment.points.at_end.clone()] {
        sum += point.force;
    }
    sum
}

/// Adds what the points inside a segment need to the internal wrench at the nodes; returns their sum.
#[inline(always)]
pub(super) fn carry<G: Turning>(
    plan: &Plan<G>,
    segment: &SegmentPlan<G>,
    work: &mut Workspace<G>,
) -> Wrench<G, f64> {
    let mut sum = Wrench::zero();
    for p in segment.points.inside.clone() {
        let force = work.points[p].force;
        sum += force;
        let force = force.splat();
        let internal = &mut work.internal[segment.node_packs()];
        for (internal, &share) in internal.iter_mut().zip(&plan.points[p].reach().share) {
            *internal += force * share;
        }
    }
    sum
}
