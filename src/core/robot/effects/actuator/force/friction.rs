//! Friction of tendons along embedded parts, and at the transitions to straight parts:
//! `T(X) = T_0 exp(-mu s theta(X))` (capstan equation), with the angle `theta = int |dt/dX| dX` by which the
//! tendon turns in space up to X, and the direction of sliding s in [-1, 1], 1 if the tendon is pulled.
//!
//! With `w = u' + kappa x u` the tangent turns by `r = (1 - t t^T) w / |u|`, and
//!
//! ```text
//! r . dr = (r . dw - (t . w) / |u| r . du - |r|^2 t . du) / |u|
//! ```
//!
//! Between straight parts with the directions d and e, or between a straight part and an embedded one, the
//! tendon turns by their angle, whose derivative is `-(dd . e + d . de) / |d x e|`.
//!
//! Friction is not local: a strain changes the tension in everything that follows. Computed with plain
//! numbers instead of packs, because few robots need it.

use crate::numerics::lie::{LANES, Lanes, Vector};
use crate::robot::effects::actuator::plan::{
    Actuation, ActuatorPlan, Friction, Guide, Part, RoutingSegment, RoutingTurns,
};
use crate::robot::effects::actuator::state::{ActuationState, ActuationTangent, LineState, Sliding};

/// Number of angular strains.
const ANGULAR: usize = 3;

/// Curvature below which the rotation of a tendon is smoothed, because it has a kink at zero curvature: this
/// number of radians over the length of the part. The angle of a part that turns by one radian has an error
/// of half its square.
const SMALLEST_TURN: f64 = 1e-6;

/// The angle between parts of these directions, and minus its derivative with respect to their scalar
/// product. Smoothed like that of embedded parts.
fn corner(before: Vector<f64>, after: Vector<f64>) -> [f64; 2] {
    let cross = before.cross(after);
    let sine = cross.dot(cross).sqrt();
    let angle = sine.atan2(before.dot(after));
    let smoothed = angle * angle + SMALLEST_TURN * SMALLEST_TURN;
    let slope = angle * (smoothed + SMALLEST_TURN * SMALLEST_TURN) / (smoothed * smoothed.sqrt());
    // For opposite directions every direction of change is a steepest one.
    let of_product = if sine > 0.0 { slope / sine } else { 0.0 };
    [angle * angle / smoothed.sqrt(), of_product]
}

/// Direction of sliding at a rate of length. A commanded direction is clipped to [-1, 1].
pub(super) fn sliding(friction: &Friction, commanded: f64, rate: f64) -> Sliding {
    if friction.sliding.is_some() {
        let of_command = if commanded.abs() <= 1.0 { 1.0 } else { 0.0 };
        return Sliding { commanded, value: commanded.clamp(-1.0, 1.0), of_rate: 0.0, of_command };
    }
    let root = rate.hypot(friction.velocity);
    let of_rate = -friction.velocity * friction.velocity / (root * root * root);
    Sliding { commanded, value: -rate / root, of_rate, of_command: 0.0 }
}

/// State of a guide at a node.
struct Node {
    u: Vector<f64>,
    /// Reciprocal of |u|.
    inverse: f64,
    /// dt/dX, and `(t . w) / |u|`.
    turn: Vector<f64>,
    along: f64,
    /// kappa.
    curvature: Vector<f64>,
}

/// Strains and their slopes, `[strain, slope]`, of a component at a node.
fn strains<P: Lanes>(
    routing_segment: &RoutingSegment<P>,
    turning: &RoutingTurns,
    q: &[f64],
    c: usize,
    node: usize,
) -> [f64; 2] {
    let component = routing_segment.components[c];
    let nodes = routing_segment.packs * LANES;
    let mut sums = [0.0; 2];
    for (degree, q) in q[component.first..][..component.modes].iter().enumerate() {
        let value = routing_segment.basis[degree * routing_segment.packs + node / LANES].lane(node % LANES);
        sums[0] += value * q;
        sums[1] += turning.basis_slopes[degree * nodes + node] * q;
    }
    sums
}

fn direction<P: Lanes>(
    routing_segment: &RoutingSegment<P>,
    guide: &Guide<P>,
    c: usize,
    node: usize,
) -> Vector<f64> {
    guide.directions[c * routing_segment.packs + node / LANES].lane(node % LANES)
}

/// Axis of an angular component.
fn axis(strain: usize) -> Option<Vector<f64>> {
    (strain < ANGULAR).then(|| Vector::from(std::array::from_fn(|i| if i == strain { 1.0 } else { 0.0 })))
}

fn node_of<P: Lanes>(
    routing_segment: &RoutingSegment<P>,
    turning: &RoutingTurns,
    guide: &Guide<P>,
    q: &[f64],
    node: usize,
) -> Node {
    let nodes = routing_segment.packs * LANES;
    let mut u = guide.start[node / LANES].lane(node % LANES);
    let mut slope = guide.start_slopes[node];
    let mut curvature = turning.reference[node];
    for (c, component) in routing_segment.components.iter().enumerate() {
        let [strain, strain_slope] = strains(routing_segment, turning, q, c, node);
        let b = direction(routing_segment, guide, c, node);
        u += b * strain;
        slope += b * strain_slope + guide.direction_slopes[c * nodes + node] * strain;
        if let Some(axis) = axis(component.strain) {
            curvature += axis * strain;
        }
    }
    let inverse = u.dot(u).sqrt().recip();
    let t = u * inverse;
    let w = slope + curvature.cross(u);
    let along = t.dot(w) * inverse;
    Node { u, inverse, turn: (w - t * t.dot(w)) * inverse, along, curvature }
}

/// Smallest curvature without smoothing.
fn smallest<P: Lanes>(routing_segment: &RoutingSegment<P>) -> f64 {
    SMALLEST_TURN / routing_segment.weights.iter().map(|weight| weight.sum()).sum::<f64>()
}

/// Computes angles and tensions along a tendon, and the generalised forces of a unit force.
pub(super) fn measure<P: Lanes>(
    actuation: &Actuation<P>,
    state: &mut ActuationState<P>,
    i: usize,
    friction: &Friction,
    q: &[f64],
) {
    let n = q.len();
    let falls = friction.coefficient * state.slidings[i].value;
    let mut angle = 0.0;
    // The straight part that ends where the next one begins.
    let mut before = None;
    state.distributions[i * n..][..n].fill(0.0);
    for part in &actuation.actuators[i].path {
        let &Part::Guide { routing_segment: s, guide: k } = part else {
            let &Part::Line(line) = part else { unreachable!("there are two kinds of parts") };
            let direction = state.lines[line].direction;
            let [entry, exit] = &actuation.lines[line].guide_exits;
            let [from, to] = state.lines[line].guide_exits.map(|(direction, _)| direction);
            let before = match before.replace(line) {
                Some(before) => Some(state.lines[before].direction),
                None => entry.as_ref().map(|_| from),
            };
            angle += before.map_or(0.0, |before| corner(before, direction)[0]);
            (state.lines[line].angle, state.lines[line].ratio) = (angle, (-falls * angle).exp());
            angle += exit.as_ref().map_or(0.0, |_| corner(direction, to)[0]);
            continue;
        };
        before = None;
        let (routing_segment, [first, first_slope]) =
            (&actuation.routing_segments[s], actuation.offsets(s, k));
        let (guide, nodes) = (&routing_segment.guides[k], routing_segment.packs * LANES);
        let turning = routing_segment.turning.as_ref().expect("guides with friction know how they turn");
        let smallest = smallest(routing_segment);
        let turn = |node: usize| {
            let turn = node_of(routing_segment, turning, guide, q, node).turn;
            turn.dot(turn) / (turn.dot(turn) + smallest * smallest).sqrt()
        };
        let mut total = 0.0;
        for (pack, weight) in routing_segment.weights.iter().enumerate() {
            for lane in 0..LANES {
                let turn = turn(pack * LANES + lane);
                total += weight.lane(lane) * turn;
                // Stored temporarily in place of the ratios.
                state.ratios[first + pack].set_lane(lane, turn);
            }
        }
        for node in 0..nodes {
            let row = &turning.up_to[node * nodes..][..nodes];
            let up_to: f64 = row
                .iter()
                .enumerate()
                .map(|(l, w)| w * state.ratios[first + l / LANES].lane(l % LANES))
                .sum();
            state.angles[first + node / LANES].set_lane(node % LANES, angle + up_to);
        }
        angle += total;
        for pack in 0..routing_segment.packs {
            let angles = state.angles[first + pack];
            let ratios = std::array::from_fn(|lane| (-falls * angles.lane(lane)).exp());
            state.ratios[first + pack] = P::from_lanes(ratios);
        }
        let distribution = &mut state.distributions[i * n..][..n];
        for (c, component) in routing_segment.components.iter().enumerate() {
            for degree in 0..component.modes {
                let sum: P = (0..routing_segment.packs).fold(P::splat(0.0), |sum, pack| {
                    let density = state.slopes[first_slope + c * routing_segment.packs + pack]
                        * state.ratios[first + pack];
                    routing_segment.weighted_basis[degree * routing_segment.packs + pack]
                        .mul_add(density, sum)
                });
                distribution[component.first + degree] += sum.sum();
            }
        }
    }
}

/// Computes, for a unit force, the generalised forces including straight parts, and their derivative with
/// respect to the direction of sliding. Adds `factor` times the part of their derivatives with respect to the
/// coordinates that is due to angles.
pub(super) fn stiffen<P: Lanes>(
    actuation: &Actuation<P>,
    state: &ActuationState<P>,
    memory: &mut ActuationTangent<P>,
    i: usize,
    q: &[f64],
    factor: f64,
    mut add: impl FnMut(usize, usize, f64),
) {
    let n = q.len();
    let actuator = &actuation.actuators[i];
    let friction = actuator.friction.as_ref().expect("a tendon with friction");
    let falls = friction.coefficient * state.slidings[i].value;
    memory.distribution.copy_from_slice(&state.distributions[i * n..][..n]);
    memory.of_sliding.fill(0.0);
    memory.angle_gradient.fill(0.0);
    let tendon =
        TendonWithFriction { actuation, state, actuator, coefficient: friction.coefficient, falls, factor };
    let mut before = None;
    for part in &actuator.path {
        match *part {
            Part::Line(line) => tendon.stiffen_line(line, before.replace(line), memory, n, &mut add),
            Part::Guide { routing_segment, guide } => {
                before = None;
                tendon.stiffen_guide(routing_segment, guide, memory, q, &mut add);
            }
        }
    }
}

/// A tendon with friction.
struct TendonWithFriction<'a, P> {
    actuation: &'a Actuation<P>,
    state: &'a ActuationState<P>,
    actuator: &'a ActuatorPlan,
    coefficient: f64,
    /// Rate at which the logarithm of the tension falls with the angle.
    falls: f64,
    factor: f64,
}

impl<P: Lanes> TendonWithFriction<'_, P> {
    /// The contributions of a straight part, and of the corners to the straight part or the guide before it and to the guide
    /// behind it.
    #[inline(always)]
    fn stiffen_line(
        &self,
        line: usize,
        before: Option<usize>,
        memory: &mut ActuationTangent<P>,
        n: usize,
        mut add: impl FnMut(usize, usize, f64),
    ) {
        let of_line = |line: usize| Side {
            direction: self.state.lines[line].direction,
            turned: TurnState::Line { state: &self.state.lines[line], moved: &memory.moved[line * n..][..n] },
        };
        let of_exit = |end: usize| {
            self.actuation.lines[line].guide_exits[end].as_ref().map(|_| Side {
                direction: self.state.lines[line].guide_exits[end].0,
                turned: TurnState::GuideExit { turned: &memory.exits_turned[line * n..][..n], end },
            })
        };
        let entry = before.map_or_else(|| of_exit(0), |before| Some(of_line(before)));
        let (here, exit) = (of_line(line), of_exit(1));
        if let Some(entry) = entry {
            add_corner(&entry, &here, &self.actuator.reaches, &mut memory.angle_gradient);
        }
        let state = &self.state.lines[line];
        for &j in &self.actuator.reaches {
            let of_unit = state.ratio * state.direction.dot(memory.moved[line * n + j]);
            memory.distribution[j] += of_unit;
            memory.of_sliding[j] -= self.coefficient * state.angle * of_unit;
            for &k in &self.actuator.reaches {
                add(j, k, -self.factor * self.falls * of_unit * memory.angle_gradient[k]);
            }
        }
        if let Some(exit) = exit {
            add_corner(&here, &exit, &self.actuator.reaches, &mut memory.angle_gradient);
        }
    }

    /// The contributions of an embedded part.
    #[inline(always)]
    fn stiffen_guide(
        &self,
        s: usize,
        k: usize,
        memory: &mut ActuationTangent<P>,
        q: &[f64],
        mut add: impl FnMut(usize, usize, f64),
    ) {
        let (routing_segment, [first, first_slope]) =
            (&self.actuation.routing_segments[s], self.actuation.offsets(s, k));
        let (guide, nodes) = (&routing_segment.guides[k], routing_segment.packs * LANES);
        let turning = routing_segment.turning.as_ref().expect("guides with friction know how they turn");
        turn_changes(routing_segment, turning, guide, q, memory);
        let ActuationTangent { turn_gradients, shares, behind, of_sliding, angle_gradient, .. } = memory;
        let (shares, behind) = (&mut shares[..nodes], &mut behind[..nodes]);
        for (c, component) in routing_segment.components.iter().enumerate() {
            for degree in 0..component.modes {
                let j = component.first + degree;
                // Share of each node in the force on the coordinate.
                let mut sum = 0.0;
                for pack in 0..routing_segment.packs {
                    let slope = self.state.slopes[first_slope + c * routing_segment.packs + pack];
                    let weighted = routing_segment.weighted_basis[degree * routing_segment.packs + pack];
                    let share = weighted * slope * self.state.ratios[first + pack];
                    sum += share.sum();
                    of_sliding[j] -= self.coefficient * (share * self.state.angles[first + pack]).sum();
                    for lane in 0..LANES {
                        shares[pack * LANES + lane] = share.lane(lane);
                    }
                }
                if self.factor == 0.0 {
                    continue;
                }
                // Angles of the preceding parts.
                for &k in &self.actuator.reaches {
                    add(j, k, -self.factor * self.falls * sum * angle_gradient[k]);
                }
                // For this part, a rotation at a node changes the tension at all following nodes.
                behind.fill(0.0);
                for (&share, row) in shares.iter().zip(turning.up_to.chunks_exact(nodes)) {
                    for (behind, &weight) in behind.iter_mut().zip(row) {
                        *behind += share * weight;
                    }
                }
                let rows = turn_gradients.chunks_exact(nodes);
                for (k, row) in coordinates_of(routing_segment).zip(rows) {
                    let change: f64 = behind.iter().zip(row).map(|(behind, change)| behind * change).sum();
                    add(j, k, -self.factor * self.falls * change);
                }
            }
        }
        for (k, row) in coordinates_of(routing_segment).zip(turn_gradients.chunks_exact(nodes)) {
            let weights = (0..nodes).map(|l| routing_segment.weights[l / LANES].lane(l % LANES));
            angle_gradient[k] += row.iter().zip(weights).map(|(change, weight)| change * weight).sum::<f64>();
        }
    }
}

/// The direction of the part on one side of a corner, and its derivatives.
struct Side<'a> {
    direction: Vector<f64>,
    turned: TurnState<'a>,
}

enum TurnState<'a> {
    Line { state: &'a LineState, moved: &'a [Vector<f64>] },
    GuideExit { turned: &'a [[Vector<f64>; 2]], end: usize },
}

impl Side<'_> {
    /// Derivative of the direction with respect to a coordinate.
    fn turned(&self, k: usize) -> Vector<f64> {
        match self.turned {
            TurnState::Line { state, moved } => {
                (moved[k] - self.direction * self.direction.dot(moved[k])) * state.inverse_length
            }
            TurnState::GuideExit { turned, end } => turned[k][end],
        }
    }
}

/// Adds the derivative of a corner's angle.
fn add_corner(before: &Side<'_>, after: &Side<'_>, reaches: &[usize], angle_gradient: &mut [f64]) {
    let [_, of_product] = corner(before.direction, after.direction);
    for &k in reaches {
        let change = before.turned(k).dot(after.direction) + after.turned(k).dot(before.direction);
        angle_gradient[k] -= of_product * change;
    }
}

/// Coordinates of a routing segment, component by component.
fn coordinates_of<P>(routing_segment: &RoutingSegment<P>) -> impl Iterator<Item = usize> {
    routing_segment.components.iter().flat_map(|component| component.first..component.first + component.modes)
}

/// Computes the derivatives of a guide's rotation at its nodes with respect to the coordinates of its piece.
fn turn_changes<P: Lanes>(
    routing_segment: &RoutingSegment<P>,
    turning: &RoutingTurns,
    guide: &Guide<P>,
    q: &[f64],
    memory: &mut ActuationTangent<P>,
) {
    let nodes = routing_segment.packs * LANES;
    let smallest = smallest(routing_segment);
    for node in 0..nodes {
        let Node { u, inverse, turn, along, curvature } = node_of(routing_segment, turning, guide, q, node);
        let square = turn.dot(turn);
        let smoothed = square + smallest * smallest;
        let scale = inverse * (smoothed + smallest * smallest) / (smoothed * smoothed.sqrt());
        let mut row = 0;
        for (c, component) in routing_segment.components.iter().enumerate() {
            let b = direction(routing_segment, guide, c, node);
            let mut change = guide.direction_slopes[c * nodes + node] + curvature.cross(b);
            if let Some(axis) = axis(component.strain) {
                change += axis.cross(u);
            }
            let of_u = along * turn.dot(b) + square * inverse * u.dot(b);
            let (of_strain, of_slope) = (scale * (turn.dot(change) - of_u), scale * turn.dot(b));
            for degree in 0..component.modes {
                let value =
                    routing_segment.basis[degree * routing_segment.packs + node / LANES].lane(node % LANES);
                let slope = turning.basis_slopes[degree * nodes + node];
                memory.turn_gradients[row * nodes + node] = of_strain * value + of_slope * slope;
                row += 1;
            }
        }
    }
}
