//! Compiles actuators to parts of a plan.

use std::iter::Peekable;
use std::ops::Range;
use std::vec::IntoIter;

use crate::description::rod::piece::Piece;
use crate::description::rod::{Gauss, Profile, STRAINS};
use crate::numerics::lie::{LANES, Lanes, Quaternion, Vector};
use crate::robot::compile::links::Tree;
use crate::robot::description::{Inputs, Robot, Spans};
use crate::robot::effects::actuator;
use crate::robot::effects::actuator::force::law;
use crate::robot::effects::actuator::plan::{
    ActivePart, Actuation, ActuatorPlan, End, Friction, Guide, GuideExit, Law, Line, Part, RoutingComponent,
    RoutingSegment, RoutingTurns, pairs,
};
use crate::robot::effects::actuator::{ActiveStrain, Actuator, Along, Drive, MotorCommand, Tendon};
use crate::robot::kernel::kinematics;
use crate::robot::plan::command::Command;
use crate::robot::plan::link::LinkPlan;
use crate::robot::plan::piece::PiecePlan;
use crate::robot::plan::point::{Offset, Place, Point};
use crate::robot::plan::{Plan, packed};
use crate::robot::turning::{Turning, place};

/// Smallest length of a straight part relative to the length of the links that the tendon moves: shorter parts have a stiffness
/// that cannot be resolved.
const SHORTEST_LINE: f64 = 1e-6;

/// Number of angular strains.
const ANGULAR: usize = 3;

/// Points closer than this fraction of their distance from the axis count as one.
const SAME_SPOT: f64 = 1e-9;

/// Parts shorter than this fraction of a piece are rounding errors of arc lengths.
const SHORTEST_PART: f64 = 1e-12;

/// Compiles the actuators of a robot whose links have become these pieces.
pub(crate) fn compile<G: Turning>(
    robot: &Robot,
    pieces: &[PiecePlan<G>],
    links: &[LinkPlan],
    inputs: &Inputs,
    straight: Vec<Straight>,
) -> Actuation<G::Pack> {
    let mut compiler = Compiler {
        robot,
        pieces,
        links,
        inputs,
        spans: Spans::new(robot),
        straight: straight.into_iter().peekable(),
        inextensible: 0,
        actuation: Actuation::default(),
    };
    for (i, actuator) in robot.actuators.iter().enumerate() {
        let compiled = compiler.actuator(i, actuator);
        compiler.actuation.actuators.push(compiled);
    }
    compiler.actuation
}

/// Compiles actuators one after another.
struct Compiler<'a, G: Turning> {
    robot: &'a Robot,
    pieces: &'a [PiecePlan<G>],
    links: &'a [LinkPlan],
    inputs: &'a Inputs,
    spans: Spans<'a>,
    /// Straight parts of this tendon and of those that follow.
    straight: Peekable<IntoIter<Straight>>,
    /// Number of inextensible tendons so far.
    inextensible: usize,
    actuation: Actuation<G::Pack>,
}

impl<'a, G: Turning> Compiler<'a, G> {
    fn actuator(&mut self, i: usize, actuator: &'a Actuator) -> ActuatorPlan {
        let (mut length_at_zero, mut gradient) = (0.0, Vec::new());
        let (mut path, mut friction) = (Vec::new(), None);
        let law = match actuator {
            Actuator::Tendon(tendon) => {
                friction = (tendon.friction > 0.0).then(|| Friction {
                    coefficient: tendon.friction,
                    velocity: tendon.friction_velocity,
                    sliding: tendon.sliding.as_ref().map(|signal| Command::new(signal, self.inputs)),
                });
                path = self.path(i, tendon, SHORTEST_LINE * self.spans.of_tendon(actuator));
                match tendon.drive {
                    Drive::Tension(_) => Law::Tension,
                    Drive::Length { stiffness: Some(stiffness), damping, .. } => {
                        Law::Cable { stiffness, damping }
                    }
                    Drive::Length { stiffness: None, .. } => {
                        self.inextensible += 1;
                        Law::Inextensible { place: self.inextensible - 1 }
                    }
                }
            }
            Actuator::Chamber(chamber) => {
                for along in &chamber.path {
                    for part in self.parts(along) {
                        length_at_zero += volume(self.pieces, &part, chamber.area, &mut gradient);
                    }
                }
                Law::Pressure
            }
            Actuator::Motor(motor) => {
                let joint = &self.pieces[self.links[motor.link].pieces.start + motor.coordinate];
                gradient.push((joint.first, 1.0));
                match motor.command {
                    MotorCommand::Torque(_) => Law::Torque { limits: motor.limits },
                    MotorCommand::Position { stiffness, damping, .. } => {
                        Law::Servo { stiffness, damping, limits: motor.limits }
                    }
                }
            }
            Actuator::ActiveStrain(active) => self.active_strain(i, active, &mut gradient),
        };
        let has_friction = friction.is_some();
        let mut reaches: Vec<usize> = gradient.iter().map(|&(k, _)| k).collect();
        for part in &path {
            if let &Part::Guide { routing_segment, .. } = part {
                reaches.extend(
                    self.pieces[self.actuation.routing_segments[routing_segment].piece].coordinates(),
                );
            }
        }
        reaches.sort_unstable();
        reaches.dedup();
        let holds_all = |piece: &PiecePlan<G>| reaches.iter().all(|k| piece.coordinates().contains(k));
        ActuatorPlan {
            command: Command::new(actuator.command(), self.inputs),
            law,
            length_at_zero,
            gradient,
            path,
            friction,
            piece: self.pieces.iter().position(|piece| !reaches.is_empty() && holds_all(piece)),
            reaches,
            has_potential: !has_friction
                && actuator.command().constant().is_some()
                && law::potential(law, 0.0, 0.0).is_some(),
        }
    }

    /// Parts of an embedded path in the pieces of its rod.
    fn parts(&self, along: &'a Along) -> Vec<Embedded<'a>> {
        parts(along, self.robot, self.pieces, &self.links[along.link].rod)
    }

    /// The parts of a tendon's path: lines, none shorter than this, and guides.
    fn path(&mut self, i: usize, tendon: &'a Tendon, shortest: f64) -> Vec<Part> {
        let has_friction = tendon.friction > 0.0;
        let mut path = Vec::new();
        for (k, part) in tendon.path.iter().enumerate() {
            if let Some(line) = self.straight.next_if(|line| line.actuator == i && line.before == k) {
                path.push(Part::Line(self.actuation.lines.len()));
                let ends = line.ends.map(|place_of_end| end(place_of_end, &mut self.actuation.world_points));
                let guide_exit = |part: &'a actuator::Part, end: usize| {
                    guide_exit(&self.parts(part.along().filter(|_| has_friction)?), end, self.pieces)
                };
                let guide_exits = [guide_exit(&tendon.path[k - 1], 1), guide_exit(part, 0)];
                self.actuation.lines.push(Line { actuator: i, ends, guide_exits, shortest });
            }
            let Some(along) = part.along() else { continue };
            for part in self.parts(along) {
                path.push(guide(&mut self.actuation.routing_segments, self.pieces, i, &part, has_friction));
            }
        }
        path
    }

    fn active_strain(&mut self, i: usize, active: &ActiveStrain, gradient: &mut Vec<(usize, f64)>) -> Law {
        let whole = Along {
            link: active.link,
            offset: [Profile::from(0.0), Profile::from(0.0)],
            along: [0.0, self.robot.links[active.link].length()],
        };
        let mut energy_of_unit = 0.0;
        for part in parts(&whole, self.robot, self.pieces, &self.links[active.link].rod) {
            let active_part = ActivePart {
                actuator: i,
                piece: part.piece,
                strain: active.strain as usize,
                shape: active.shape.clone(),
                from: part.from,
                rate: part.rate,
            };
            energy_of_unit += energy_of_active_part(self.pieces, &part, &active_part, gradient);
            self.actuation.active_strains.push(active_part);
        }
        Law::Amount { energy_of_unit }
    }
}

/// A straight part of a tendon before its points are known.
pub(crate) struct Straight {
    actuator: usize,
    /// Index of the path's part before which it lies.
    before: usize,
    pub(crate) ends: [EndPlace; 2],
}

/// An end: a point of the world, in the frame of the base at rest, or a place on a link.
pub(crate) enum EndPlace {
    InWorld(Vector<f64>),
    On { place: Place, beside: Vector<f64> },
}

/// Converts an end; the index of a point on a link is not known yet.
fn end<P>(place_of_end: EndPlace, world_points: &mut Vec<Vector<f64>>) -> End<P> {
    match place_of_end {
        EndPlace::InWorld(position) => {
            world_points.push(position);
            End::InWorld(world_points.len() - 1)
        }
        EndPlace::On { beside, .. } => End::On { point: usize::MAX, beside, moved_by: Vec::new() },
    }
}

impl EndPlace {
    pub(crate) fn place(&self) -> Option<&Place> {
        if let Self::On { place, .. } = self { Some(place) } else { None }
    }

    /// Whether a tendon continues from here to another end without a straight part between them: the ends
    /// coincide, or the second one is at the start of the piece that follows the first one.
    fn goes_on_to<G: Turning>(&self, other: &Self, pieces: &[PiecePlan<G>]) -> bool {
        let (Self::On { place, beside }, Self::On { place: next, beside: next_beside }) = (self, other)
        else {
            return false;
        };
        let gap = *next_beside - *beside;
        let is_beside = gap.dot(gap) <= SAME_SPOT * SAME_SPOT * beside.dot(*beside);
        let is_same = place.piece == next.piece && place.x == next.x;
        let joined = &pieces[next.piece].joined;
        let goes_on = place.x >= 1.0
            && next.x <= 0.0
            && joined.weld.is_none()
            && joined.begin == pieces[place.piece].joined.end;
        is_beside && (is_same || goes_on)
    }
}

/// Straight parts of all tendons, in order.
pub(crate) fn straight<G: Turning>(robot: &Robot, tree: &Tree<G>) -> Vec<Straight> {
    let Tree { pieces, links, .. } = tree;
    let root = &robot.links[0];
    let place_of_end = |link: usize, x: Option<f64>, point: Vector<f64>| {
        let place = place::on_link(pieces, &links[link], x);
        let beside = match place.beside {
            Some(Offset { orientation, position }) => position + orientation.rotation().apply(point),
            None => point,
        };
        EndPlace::On { place, beside }
    };
    let end_of = |part: &actuator::Part, end: usize| match part {
        actuator::Part::Along(along) => {
            let x = along.along[end];
            let fraction = x / robot.links[along.link].length();
            let [[y], [z]] = [0, 1].map(|i| along.offset[i].at(fraction));
            place_of_end(along.link, Some(x), Vector { x: 0.0, y, z })
        }
        actuator::Part::Via(via) => match via.link {
            Some(link) => place_of_end(link, via.at, via.point.into()),
            None => {
                let base = Quaternion::from_array(root.orientation).rotation();
                let position = Vector::from(via.point) - Vector::from(root.position);
                EndPlace::InWorld(base.apply_transposed(position))
            }
        },
    };
    let mut found = Vec::new();
    for (i, actuator) in robot.actuators.iter().enumerate() {
        let Actuator::Tendon(tendon) = actuator else { continue };
        for (k, pair) in tendon.path.windows(2).enumerate() {
            let ends = [end_of(&pair[0], 1), end_of(&pair[1], 0)];
            if !ends[0].goes_on_to(&ends[1], pieces) {
                found.push(Straight { actuator: i, before: k + 1, ends });
            }
        }
    }
    found
}

/// Assigns points, and the coordinates that move them, to the ends of straight parts.
pub(crate) fn attach<G: Turning>(plan: &mut Plan<G>) {
    let mut lines = std::mem::take(&mut plan.effects.actuation.lines);
    for (i, line) in lines.iter_mut().enumerate() {
        for (e, end) in line.ends.iter_mut().enumerate() {
            let End::On { point, moved_by, .. } = end else { continue };
            let has_it = |point: &Point<G>| point.effects.pulled.contains(&(2 * i + e));
            *point = plan.points.iter().position(has_it).expect("every end is at a point");
            *moved_by = kinematics::moved_by(plan, &plan.points[*point].place);
        }
    }
    plan.effects.actuation.lines = lines;
    for i in 0..plan.effects.actuation.actuators.len() {
        let actuation = &plan.effects.actuation;
        let ends = actuation.lines_of(i).flat_map(|l| &actuation.lines[l].ends);
        let moved_by = ends.flat_map(|end| match end {
            End::InWorld(_) => [].iter(),
            End::On { moved_by, .. } => moved_by.iter(),
        });
        let coordinates: Vec<usize> = moved_by.flat_map(|(s, _)| plan.pieces[*s].coordinates()).collect();
        let actuator = &mut plan.effects.actuation.actuators[i];
        if !coordinates.is_empty() {
            actuator.reaches.extend(coordinates);
            actuator.reaches.sort_unstable();
            actuator.reaches.dedup();
            actuator.piece = None;
        }
    }
}

/// The part of a path within one piece.
pub(super) struct Embedded<'a> {
    pub(super) piece: usize,
    part: &'a Piece,
    offset: &'a [Profile<1>; 2],
    /// Start and end as fractions of the piece's length.
    pub(super) ends: [f64; 2],
    /// Conversion from fractions of the piece's length to those of the link's: `from + rate x`.
    from: f64,
    rate: f64,
    length_of_link: f64,
}

impl Embedded<'_> {
    /// Fraction of the link's length.
    fn on_link(&self, x: f64) -> f64 {
        self.from + self.rate * x
    }

    /// Nodes and weights as fractions of the piece's length.
    fn spread(&self, gauss: &Gauss) -> (Vec<f64>, Vec<f64>) {
        let [from, to] = self.ends;
        (
            gauss.nodes.iter().map(|x| from + (to - from) * x).collect(),
            gauss.weights.iter().map(|weight| (to - from) * weight).collect(),
        )
    }

    /// Quadrature as fractions of the part, with the node density of the piece, and more nodes if the offset
    /// varies; whole packs.
    fn quadrature(&self, nodes_of_piece: usize, profiles: &[&Profile<1>]) -> Gauss {
        let mut breaks = self.part.breaks();
        let rules_of_piece = breaks.len() + 1;
        for profile in profiles {
            let stations = profile.stations();
            if let Some(&end) = stations.last() {
                breaks.extend(stations.iter().map(|station| (station / end - self.from) / self.rate));
            }
        }
        let [from, to] = self.ends;
        let mut breaks: Vec<f64> = breaks.into_iter().map(|x| (x - from) / (to - from)).collect();
        breaks.retain(|&x| x > SHORTEST_PART && x < 1.0 - SHORTEST_PART);
        breaks.sort_by(f64::total_cmp);
        breaks.dedup_by(|a, b| *a - *b < SHORTEST_PART);
        let rules = breaks.len() + 1;
        let degree = profiles.iter().map(|profile| profile.degree()).max().unwrap_or(0);
        let of_rule = nodes_of_piece / rules_of_piece + degree;
        let of_rule = (of_rule..).find(|nodes| (rules * nodes).is_multiple_of(LANES)).unwrap_or(of_rule);
        Gauss::composite(of_rule, &breaks)
    }
}

/// Parts of a path in the pieces of a rod.
pub(super) fn parts<'a, G: Turning>(
    along: &'a Along,
    robot: &Robot,
    pieces: &'a [PiecePlan<G>],
    rod: &Range<usize>,
) -> Vec<Embedded<'a>> {
    let length_of_link = robot.links[along.link].length();
    let mut start = 0.0;
    let mut found = Vec::new();
    for s in rod.clone() {
        let piece = &pieces[s];
        let ends = along.along.map(|x| ((x - start) / piece.length).clamp(0.0, 1.0));
        if ends[1] - ends[0] > SHORTEST_PART {
            found.push(Embedded {
                piece: s,
                part: piece.part(),
                offset: &along.offset,
                ends,
                from: start / length_of_link,
                rate: piece.length / length_of_link,
                length_of_link,
            });
        }
        start += piece.length;
    }
    found
}

/// Strain components of a piece.
pub(super) fn components<G: Turning>(piece: &PiecePlan<G>) -> Vec<RoutingComponent> {
    let mut first = piece.first;
    let modes = piece.part().modes;
    let present = modes.iter().enumerate().filter(|&(_, &modes)| modes > 0);
    present
        .map(|(strain, &modes)| {
            first += modes;
            RoutingComponent { strain, first: first - modes, modes }
        })
        .collect()
}

/// Slope of a path per unit strain: `e_i x d`, or `e_i`.
pub(super) fn direction(strain: usize, [y, z]: [f64; 2]) -> Vector<f64> {
    let unit = Vector::from(std::array::from_fn(|i| if i == strain % ANGULAR { 1.0 } else { 0.0 }));
    if strain < ANGULAR { unit.cross(Vector { x: 0.0, y, z }) } else { unit }
}

/// Offset d and derivative d' of an embedded path at a fraction of its piece, d' per metre.
pub(super) fn offset(part: &Embedded<'_>, x: f64) -> [[f64; 2]; 2] {
    let [y, z] = [0, 1].map(|i| part.offset[i].jet(part.on_link(x)));
    [[y[0][0], z[0][0]], [y[1][0] / part.length_of_link, z[1][0] / part.length_of_link]]
}

/// Slope u_0 of a path at zero coordinates.
pub(super) fn slope_at_zero(part: &Embedded<'_>, x: f64) -> Vector<f64> {
    let [d, [y, z]] = offset(part, x);
    let reference = part.part.reference(x);
    let sum = |sum: Vector<f64>, strain: usize| sum + direction(strain, d) * reference[strain];
    (0..STRAINS).fold(Vector { x: 0.0, y, z }, sum)
}

/// Adds a tendon to the routing segment of a part of a piece; creates a routing segment if none has the same nodes.
fn guide<G: Turning>(
    routing_segments: &mut Vec<RoutingSegment<G::Pack>>,
    pieces: &[PiecePlan<G>],
    actuator: usize,
    part: &Embedded<'_>,
    has_friction: bool,
) -> Part {
    let piece = &pieces[part.piece];
    let [y, z] = part.offset;
    let gauss = part.quadrature(piece.gauss.nodes.len(), &[y, z]);
    let (nodes, weights) = part.spread(&gauss);
    let number = nodes.len();
    let packs = number / LANES;
    let weights = packed::<G::Pack>(number, |i| piece.length * weights[i]);
    let components = components(piece);
    let is_same = |routing_segment: &RoutingSegment<G::Pack>| {
        let lanes = |weights: &[G::Pack]| -> Vec<f64> {
            weights.iter().flat_map(|pack| (0..LANES).map(|lane| pack.lane(lane))).collect()
        };
        routing_segment.piece == part.piece
            && routing_segment.ends == part.ends
            && lanes(&routing_segment.weights) == lanes(&weights)
    };
    let found = routing_segments.iter().position(is_same);
    let position = found.unwrap_or(routing_segments.len());
    let routing_segment = match found {
        Some(found) => &mut routing_segments[found],
        None => {
            let degrees = part.part.degrees();
            let at_nodes: Vec<Vec<f64>> = nodes.iter().map(|&x| basis(part.part, x)).collect();
            let basis: Vec<G::Pack> = (0..degrees).flat_map(|k| packed(number, |i| at_nodes[i][k])).collect();
            let weighted_basis =
                basis.iter().enumerate().map(|(i, &basis)| basis * weights[i % packs]).collect();
            routing_segments.push(RoutingSegment {
                piece: part.piece,
                ends: part.ends,
                packs,
                weights,
                basis,
                weighted_basis,
                components: components.clone(),
                guides: Vec::new(),
                turning: None,
            });
            routing_segments.last_mut().expect("one was pushed")
        }
    };
    let pack_of = |f: &dyn Fn(f64) -> Vector<f64>| -> Vec<Vector<G::Pack>> {
        let values: Vec<[f64; 3]> = nodes.iter().map(|&x| f(x).to_array()).collect();
        let [x, y, z] = [0, 1, 2].map(|k| packed::<G::Pack>(number, |i| values[i][k]));
        (0..packs).map(|pack| Vector { x: x[pack], y: y[pack], z: z[pack] }).collect()
    };
    let of_component =
        |component: &RoutingComponent| pack_of(&|x| direction(component.strain, offset(part, x)[0]));
    let directions: Vec<Vector<G::Pack>> = components.iter().flat_map(of_component).collect();
    let at = |c: usize, pack: usize| directions[c * packs + pack];
    let products = pairs(components.len())
        .flat_map(|(c, d)| (0..packs).map(move |pack| (c, d, pack)))
        .map(|(c, d, pack)| at(c, pack).dot(at(d, pack)))
        .collect();
    let start = pack_of(&|x| slope_at_zero(part, x));
    let (mut start_slopes, mut direction_slopes) = (Vec::new(), Vec::new());
    if has_friction {
        start_slopes.extend(nodes.iter().map(|&x| slope_of_slope(part, x)));
        for component in &components {
            direction_slopes.extend(nodes.iter().map(|&x| {
                let [_, slope] = offset(part, x);
                if component.strain < ANGULAR { direction(component.strain, slope) } else { Vector::zero() }
            }));
        }
        routing_segment.turning.get_or_insert_with(|| turning(part, piece.length, &nodes, &gauss));
    }
    let guide = Guide { actuator, start, directions, products, start_slopes, direction_slopes };
    routing_segment.guides.push(guide);
    Part::Guide { routing_segment: position, guide: routing_segment.guides.len() - 1 }
}

/// An end of an embedded part that continues as a straight one.
fn guide_exit<G: Turning>(parts: &[Embedded<'_>], end: usize, pieces: &[PiecePlan<G>]) -> Option<GuideExit> {
    let part = if end == 0 { parts.first() } else { parts.last() }?;
    let x = part.ends[end];
    let values = basis(part.part, x);
    let [d, _] = offset(part, x);
    let changes = components(&pieces[part.piece]).into_iter().flat_map(|component| {
        let of_strain = direction(component.strain, d);
        let of_modes = values[..component.modes].iter().map(move |&value| of_strain * value);
        (component.first..).zip(of_modes).collect::<Vec<_>>()
    });
    Some(GuideExit { start: slope_at_zero(part, x), changes: changes.collect() })
}

/// Data for the rotation of guides at these nodes of a piece.
fn turning(part: &Embedded<'_>, length: f64, nodes: &[f64], gauss: &Gauss) -> RoutingTurns {
    /// Step of central differences of the basis, which is smooth between breaks: cube root of the rounding
    /// unit.
    const STEP: f64 = 6e-6;
    let [from, to] = part.ends;
    let way = length * (to - from);
    let up_to = gauss.nodes.iter().flat_map(|&x| gauss.weights_up_to(x)).map(|weight| way * weight).collect();
    let slopes = |k: usize| {
        nodes.iter().map(move |&x| {
            let [before, after] = [x - STEP, x + STEP].map(|x| basis(part.part, x)[k]);
            (after - before) / (2.0 * STEP * length)
        })
    };
    let reference = nodes.iter().map(|&x| {
        let [a, b, c, ..] = part.part.reference(x);
        Vector { x: a, y: b, z: c }
    });
    RoutingTurns {
        up_to,
        basis_slopes: (0..part.part.degrees()).flat_map(slopes).collect(),
        reference: reference.collect(),
    }
}

/// Derivative of u_0 along the rod, per metre.
fn slope_of_slope(part: &Embedded<'_>, x: f64) -> Vector<f64> {
    let [d, d_slope] = offset(part, x);
    let [y, z] = [0, 1].map(|i| part.offset[i].jet(part.on_link(x))[2][0] / part.length_of_link.powi(2));
    let (reference, reference_slope) = (part.part.reference(x), part.part.reference_slope(x));
    let mut sum = Vector { x: 0.0, y, z };
    for strain in 0..STRAINS {
        sum += direction(strain, d) * reference_slope[strain];
        if strain < ANGULAR {
            sum += direction(strain, d_slope) * reference[strain];
        }
    }
    sum
}

/// Basis functions of a piece.
fn basis(part: &Piece, x: f64) -> Vec<f64> {
    let mut values = vec![0.0; part.degrees()];
    part.basis.values(x, &mut values);
    values
}

/// Volume of a chamber in a piece at zero coordinates; adds its gradient.
fn volume<G: Turning>(
    pieces: &[PiecePlan<G>],
    part: &Embedded<'_>,
    area: f64,
    gradient: &mut Vec<(usize, f64)>,
) -> f64 {
    let piece = &pieces[part.piece];
    let [y, z] = part.offset;
    let (nodes, weights) = part.spread(&part.quadrature(piece.gauss.nodes.len(), &[y, z]));
    let mut volume = 0.0;
    for (&x, weight) in nodes.iter().zip(weights) {
        let weight = weight * piece.length;
        volume += area * weight * slope_at_zero(part, x).x;
        let values = basis(part.part, x);
        let [d, _] = offset(part, x);
        for component in components(piece) {
            let along = area * weight * direction(component.strain, d).x;
            add(gradient, component, &values, along);
        }
    }
    volume
}

/// Adds a force per strain to the gradient of a length.
fn add(gradient: &mut Vec<(usize, f64)>, component: RoutingComponent, basis: &[f64], force: f64) {
    for (j, value) in basis[..component.modes].iter().enumerate() {
        let k = component.first + j;
        match gradient.iter_mut().find(|(known, _)| *known == k) {
            Some((_, entry)) => *entry += value * force,
            None => gradient.push((k, value * force)),
        }
    }
}

/// Adds the effect of a unit active strain in a piece, `int phi H shape`; returns twice its own elastic
/// energy.
fn energy_of_active_part<G: Turning>(
    pieces: &[PiecePlan<G>],
    part: &Embedded<'_>,
    active: &ActivePart,
    gradient: &mut Vec<(usize, f64)>,
) -> f64 {
    let piece = &pieces[part.piece];
    let strain = active.strain;
    let (nodes, weights) = part.spread(&part.quadrature(piece.gauss.nodes.len(), &[&active.shape]));
    let mut energy = 0.0;
    for (&x, weight) in nodes.iter().zip(weights) {
        let shape = active.of_unit(x);
        let weight = weight * piece.length * shape;
        let stiffness = part.part.section(x).stiffness;
        energy += weight * shape * stiffness[strain][strain];
        let values = basis(part.part, x);
        for component in components(piece) {
            let force = weight * stiffness[component.strain][strain];
            if force != 0.0 {
                add(gradient, component, &values, force);
            }
        }
    }
    energy
}
