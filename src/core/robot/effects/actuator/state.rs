//! Actuators in a state.

use crate::numerics::lie::{LANES, Scalar, Vector};
use crate::robot::effects::actuator::plan::{Actuation, RoutingSegment};

/// Force of an actuator, and its derivatives with respect to length, rate of length and command.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Force {
    pub(crate) value: f64,
    pub(crate) of_length: f64,
    pub(crate) of_rate: f64,
    pub(crate) of_command: f64,
}

/// State of the actuators.
#[derive(Clone, Debug)]
pub(crate) struct ActuationState<P> {
    /// Commands; NaN until a required time is set.
    pub(crate) commands: Vec<f64>,
    /// First two time derivatives of the commanded lengths of inextensible tendons; zero for other actuators.
    pub(crate) command_rates: Vec<[f64; 2]>,
    pub(crate) lengths: Vec<f64>,
    pub(crate) rates: Vec<f64>,
    pub(crate) forces: Vec<Force>,
    /// Forces that replace those of single actuators.
    pub(crate) fixed_tensions: Vec<Option<f64>>,
    /// Gradients of the lengths without straight parts, n numbers each.
    pub(crate) gradients: Vec<f64>,
    /// If any tendon has friction: generalised forces of unit forces without straight parts, n numbers each.
    pub(crate) distributions: Vec<f64>,
    /// Power dissipated per unit force.
    pub(crate) work_rates: Vec<f64>,
    /// Directions in which tendons slide.
    pub(crate) slidings: Vec<Sliding>,
    pub(crate) lines: Vec<LineState>,
    /// Positions and velocities of the points of the world at which straight parts end, in the frame of the
    /// plan, which follows the base.
    pub(crate) world_points: Vec<[Vector<f64>; 2]>,
    /// For all guides, per pack: tension relative to that at the start of the path, and accumulated angle.
    pub(crate) ratios: Vec<P>,
    pub(crate) angles: Vec<P>,
    /// Per component and pack of a routing segment: strains, or another field at the nodes.
    pub(crate) field: Vec<P>,
    /// For all routing segments and their guides: per component and pack `b_c . t` with the unit tangent t, and per
    /// pack `1 / |u|`.
    pub(crate) slopes: Vec<P>,
    pub(crate) inverse_norms: Vec<P>,
}

/// Direction in which a tendon slides, 1 as if it is pulled, and its derivatives with respect to the rate of
/// length and to the command.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Sliding {
    pub(crate) commanded: f64,
    pub(crate) value: f64,
    pub(crate) of_rate: f64,
    pub(crate) of_command: f64,
}

/// State of a straight part of a tendon, in the frame of the plan.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LineState {
    pub(crate) ends: [Vector<f64>; 2],
    /// Unit vector from the first end to the second one, and reciprocal of its length; both zero without a
    /// direction.
    pub(crate) direction: Vector<f64>,
    pub(crate) inverse_length: f64,
    /// Velocity of the second end relative to the first one.
    pub(crate) velocity: Vector<f64>,
    pub(crate) rate: f64,
    /// Tension relative to that at the start of the path, and accumulated angle.
    pub(crate) ratio: f64,
    pub(crate) angle: f64,
    /// For a tendon with friction, the directions of embedded parts at both ends, and the reciprocals of |u|
    /// there.
    pub(crate) guide_exits: [(Vector<f64>, f64); 2],
}

/// Memory for the tangent of the actuators.
#[derive(Clone, Debug)]
pub(crate) struct ActuationTangent<P> {
    /// Per component and pack of a routing segment: strains, or another field at the nodes.
    pub(crate) field: Vec<P>,
    /// Per pair of components and pack of a routing segment: stiffness per length.
    pub(crate) stiffness: Vec<P>,
    /// For the current actuator, per coordinate: its gradient, the rate of the gradient, the generalised
    /// forces of a unit force, their derivative with respect to the direction of sliding, and the gradient of
    /// the angle.
    pub(crate) gradient: Vec<f64>,
    pub(crate) gradient_rate: Vec<f64>,
    pub(crate) distribution: Vec<f64>,
    pub(crate) of_sliding: Vec<f64>,
    pub(crate) angle_gradient: Vec<f64>,
    /// For all straight parts, n each: relative displacement of the ends per unit coordinate, and derivative
    /// of the length rate.
    pub(crate) moved: Vec<Vector<f64>>,
    pub(crate) rate_gradients: Vec<f64>,
    /// For tendons with friction, n per straight part: changes of the directions of embedded parts at its
    /// ends.
    pub(crate) exits_turned: Vec<[Vector<f64>; 2]>,
    /// For a routing segment with friction, per coordinate of its piece and node: derivative of the rotation there.
    pub(crate) turn_gradients: Vec<f64>,
    /// Per node of that routing segment: its share of a force, and the sum over all following nodes.
    pub(crate) shares: Vec<f64>,
    pub(crate) behind: Vec<f64>,
}

impl<P: Scalar> ActuationState<P> {
    pub(crate) fn new(actuation: &Actuation<P>, n: usize) -> Self {
        let number = actuation.actuators.len();
        let zero = P::splat(0.0);
        let nodes = |factor: fn(usize) -> usize| {
            let of_routing_segment = actuation.routing_segments.iter().map(|routing_segment| {
                routing_segment.guides.len()
                    * factor(routing_segment.components.len())
                    * routing_segment.packs
            });
            vec![zero; of_routing_segment.sum()]
        };
        let has_friction = actuation.actuators.iter().any(|actuator| actuator.friction.is_some());
        let mut ones = nodes(|_| 1);
        ones.fill(P::splat(1.0));
        Self {
            commands: vec![f64::NAN; number],
            command_rates: vec![[0.0; 2]; number],
            lengths: vec![0.0; number],
            rates: vec![0.0; number],
            forces: vec![Force::default(); number],
            fixed_tensions: vec![None; number],
            gradients: vec![0.0; number * n],
            distributions: vec![0.0; if has_friction { number * n } else { 0 }],
            work_rates: vec![0.0; number],
            slidings: vec![Sliding { commanded: f64::NAN, ..Sliding::default() }; number],
            lines: vec![LineState::new(); actuation.lines.len()],
            world_points: actuation.world_points.iter().map(|&point| [point, Vector::zero()]).collect(),
            ratios: ones,
            angles: nodes(|_| 1),
            field: largest(actuation, |components| components),
            slopes: nodes(|components| components),
            inverse_norms: nodes(|_| 1),
        }
    }
}

impl<P: Scalar> ActuationTangent<P> {
    pub(crate) fn new(actuation: &Actuation<P>, n: usize) -> Self {
        let zeros = |rows: usize| vec![0.0; if actuation.actuators.is_empty() { 0 } else { rows * n }];
        let has_guide_exits = actuation.lines.iter().flat_map(|line| &line.guide_exits).any(Option::is_some);
        let with_turning =
            actuation.routing_segments.iter().filter(|routing_segment| routing_segment.turning.is_some());
        let nodes_of = |routing_segment: &RoutingSegment<P>| routing_segment.packs * LANES;
        let modes_of = |routing_segment: &RoutingSegment<P>| {
            routing_segment.components.iter().map(|component| component.modes).sum::<usize>()
        };
        let nodes = with_turning.clone().map(nodes_of).max().unwrap_or(0);
        let gradients = with_turning
            .map(|routing_segment| nodes_of(routing_segment) * modes_of(routing_segment))
            .max()
            .unwrap_or(0);
        Self {
            field: largest(actuation, |components| components),
            stiffness: largest(actuation, |components| components * (components + 1) / 2),
            gradient: zeros(1),
            gradient_rate: zeros(1),
            distribution: zeros(1),
            of_sliding: zeros(1),
            angle_gradient: zeros(1),
            moved: vec![Vector::zero(); actuation.lines.len() * n],
            rate_gradients: vec![0.0; actuation.lines.len() * n],
            exits_turned: vec![
                [Vector::zero(); 2];
                if has_guide_exits { actuation.lines.len() * n } else { 0 }
            ],
            turn_gradients: vec![0.0; gradients],
            shares: vec![0.0; nodes],
            behind: vec![0.0; nodes],
        }
    }
}

impl LineState {
    fn new() -> Self {
        let zero = Vector::zero();
        Self {
            ends: [zero; 2],
            direction: zero,
            inverse_length: 0.0,
            velocity: zero,
            rate: 0.0,
            ratio: 1.0,
            angle: 0.0,
            guide_exits: [(zero, 0.0); 2],
        }
    }
}

/// Memory for values at the nodes of any routing segment, for the largest number of values.
fn largest<P: Scalar>(actuation: &Actuation<P>, numbers: fn(usize) -> usize) -> Vec<P> {
    let sizes = actuation
        .routing_segments
        .iter()
        .map(|routing_segment| numbers(routing_segment.components.len()) * routing_segment.packs);
    vec![P::splat(0.0); sizes.max().unwrap_or(0)]
}
