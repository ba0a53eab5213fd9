//! Kinematics of rods: rotations from the curvature, positions by integration.

use super::{hinge, points};
use crate::numerics::lie::{
    Cross, LANES, Lanes, Rotation, Scalar, Sweep, Twist, Vector, VectorSpace, weighted_sum,
};
use crate::numerics::linalg::Matrix;
use crate::robot::plan::Plan;
use crate::robot::plan::joined::Weld;
use crate::robot::plan::packed;
use crate::robot::plan::piece::PiecePlan;
use crate::robot::plan::point::Place;
use crate::robot::state::{Placement, Workspace};
use crate::robot::turning::Turning;
use crate::robot::turning::{columns, place};

/// Pose of a place in the world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose {
    /// Body axes in world coordinates.
    pub rotation: Rotation<f64>,
    /// Position in metres.
    pub position: Vector<f64>,
}

/// Derivative of the position along the rod at a pack of nodes: `R gamma`.
#[inline(always)]
fn slope<G: Turning>(
    piece: &PiecePlan<G>,
    frame: G::Frame,
    q: &[f64],
    pack: usize,
    rotation: &G::Rotation<G::Pack>,
) -> G::Vector<G::Pack> {
    if piece.is_extensible {
        G::rotate(rotation, piece.field(q, pack).linear + piece.reference_slope[pack])
    } else {
        G::rod_axis(frame, rotation)
    }
}

/// Updates rotations and positions of all nodes and stations for the coordinates `q`, if necessary.
#[inline(always)]
pub(crate) fn update<G: Turning>(plan: &Plan<G>, work: &mut Workspace<G>, q: &[f64]) {
    if work.kinematics_of == q {
        return;
    }
    work.kinematics_of.clear();
    work.kinematics_of.extend_from_slice(q);
    // The motion in memory belongs to another shape.
    work.motion_is_known = false;
    if !plan.hinges.is_empty() {
        plan.instructions.run_outlined::<G::Pack, _>(HalfAngles { plan, work: &mut *work, q });
    }
    for run in plan.pieces.chunk_by(|a, b| (a.packs == 0) == (b.packs == 0)) {
        if run[0].packs == 0 {
            let sweep = WithoutNodes { plan, run, work: &mut *work, q };
            plan.instructions.run_outlined::<G::Pack, _>(sweep);
        } else {
            with_nodes(plan, run, work, q);
        }
    }
}

/// Start of a piece that is welded to a station.
#[inline(always)]
fn welded<G: Turning>(piece: &PiecePlan<G>, weld: &Weld<G>, station: Placement<G>) -> Placement<G> {
    let Placement { mut orientation, mut rotation, mut position } = station;
    position += G::rotate(&rotation, weld.position);
    if weld.turns {
        rotation = G::compose(&rotation, &weld.rotation);
        if piece.packs > 0 || piece.joined.is_followed_by_nodes {
            orientation = G::turned(orientation, weld.orientation);
        }
    }
    Placement { orientation, rotation, position }
}

/// Rotations and positions along consecutive pieces with nodes.
#[inline(always)]
fn with_nodes<G: Turning>(plan: &Plan<G>, pieces: &[PiecePlan<G>], work: &mut Workspace<G>, q: &[f64]) {
    for piece in pieces {
        let joined = &piece.joined;
        if let Some(weld) = &joined.weld {
            let begin = welded(piece, weld, work.stations[weld.to].placement());
            work.stations[joined.begin].place(begin);
        }
        let rotations = &mut work.rotation[piece.node_packs()];
        let base = work.stations[joined.begin];
        let end = &mut work.stations[joined.end];
        end.orientation = G::turn(piece, q, base.orientation, rotations);
        if joined.ends_at_joint {
            end.rotation = G::matrix(end.orientation);
        }

        let slopes = &mut work.slope[piece.node_packs()];
        for (pack, (slope, rotation)) in slopes.iter_mut().zip(rotations.iter()).enumerate() {
            *slope = self::slope(piece, plan.frame, q, pack, rotation);
        }
        let start = G::map_vector(&base.position, |&x| G::Pack::splat(x));
        let mut total = G::Vector::<G::Pack>::zero();
        let positions = &mut work.position[piece.node_packs()];
        for (pack, position) in positions.iter_mut().enumerate() {
            let row = piece.row(&piece.from_base, pack);
            *position = weighted_sum(start, row, slopes, |sum, slope, lane, weight| {
                sum.add_scaled(
                    G::map_vector(slope, |component: &G::Pack| G::Pack::splat(component.lane(lane))),
                    weight,
                )
            });
            total = total.add_scaled(slopes[pack], piece.weights[pack]);
        }
        end.position = base.position + G::map_vector(&total, |pack: &G::Pack| pack.sum());
        points::find(plan, piece, work, q);
    }
}

/// [`hinge::half_angles`].
struct HalfAngles<'a, G: Turning> {
    plan: &'a Plan<G>,
    work: &'a mut Workspace<G>,
    q: &'a [f64],
}

impl<G: Turning> Sweep for HalfAngles<'_, G> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        hinge::half_angles(self.plan, self.work, self.q);
    }
}

/// Ends of pieces without nodes (hinges or rigid), and points there.
struct WithoutNodes<'a, G: Turning> {
    plan: &'a Plan<G>,
    run: &'a [PiecePlan<G>],
    work: &'a mut Workspace<G>,
    q: &'a [f64],
}

impl<G: Turning> Sweep for WithoutNodes<'_, G> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Self { plan, run, work, q } = self;
        let (mut station, mut place) = (0, work.stations[0].placement());
        for piece in run {
            let joined = &piece.joined;
            // Usually the end of the previous piece, which is at hand.
            if joined.carrier() != station {
                place = work.stations[joined.carrier()].placement();
            }
            if let Some(weld) = &joined.weld {
                place = welded(piece, weld, place);
                work.stations[joined.begin].place(place);
            }
            if let Some(hinge) = &piece.hinge {
                place = hinge::place(piece, hinge, work, q, place);
            }
            work.stations[joined.end].place(place);
            for p in piece.points.at_end.clone() {
                points::stand(plan, p, work, place.rotation, place.position);
            }
            station = joined.end;
        }
    }
}

struct Update<'a, G: Turning> {
    plan: &'a Plan<G>,
    work: &'a mut Workspace<G>,
    q: &'a [f64],
}

impl<G: Turning> Sweep for Update<'_, G> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        update(self.plan, self.work, self.q);
    }
}

/// Runs [`update`] with the instruction set of the plan.
pub(crate) fn run<G: Turning>(plan: &Plan<G>, work: &mut Workspace<G>, q: &[f64]) {
    plan.instructions.run::<G::Pack, _>(Update { plan, work, q });
}

/// Pose of a place, with the kinematics up to date.
pub(crate) fn pose<G: Turning>(plan: &Plan<G>, work: &Workspace<G>, q: &[f64], place: &Place) -> Pose {
    let piece = &plan.pieces[place.piece];
    let rotation = place::rotation_at(piece, work, q, place);
    let position = position(plan, work, place);
    let base = &work.surroundings.base.rotation;
    let mut rotation = G::rotation_in_space(plan.frame, &rotation);
    if let Some(beside) = place.beside {
        let Rotation { x, y, z } = beside.orientation.rotation();
        rotation = Rotation { x: rotation.apply(x), y: rotation.apply(y), z: rotation.apply(z) };
    }
    let Rotation { x, y, z } = rotation;
    Pose {
        rotation: Rotation { x: base.apply(x), y: base.apply(y), z: base.apply(z) },
        position: work.surroundings.base.position + base.apply(G::in_space(plan.frame, position)),
    }
}

/// Position of a place in the frame, with the kinematics up to date.
pub(crate) fn position<G: Turning>(plan: &Plan<G>, work: &Workspace<G>, place: &Place) -> G::Vector<f64> {
    let joined = &plan.pieces[place.piece].joined;
    if place.weights.is_empty() {
        let end = work.stations[joined.end].position;
        let Some(beside) = place.beside else { return end };
        let rotation = place::rotation_of_end(&plan.pieces[place.piece], work);
        return end + G::rotate(&rotation, G::vector_of(plan.frame, beside.position));
    }
    let mut position = work.stations[joined.begin].position;
    let slopes = &work.slope[plan.pieces[place.piece].node_packs()];
    for (i, &weight) in place.weights.iter().enumerate() {
        position +=
            G::map_vector(&slopes[i / LANES], |component: &G::Pack| component.lane(i % LANES)) * weight;
    }
    position
}

/// Angular velocity of a place and velocity of its point, in world axes, with the motion up to date.
pub(crate) fn velocity<G: Turning>(plan: &Plan<G>, work: &Workspace<G>, place: &Place) -> [Vector<f64>; 2] {
    let joined = &plan.pieces[place.piece].joined;
    let station = if place.weights.is_empty() { joined.end } else { joined.begin };
    let Twist { mut angular, mut linear } = work.stations[station].velocity;
    let rates = &work.rate[plan.pieces[place.piece].node_packs()];
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

/// Writes the Jacobian of the pose of a place, 6 x n, with the kinematics up to date: angular velocity, and
/// velocity of the place's point, in world axes, for unit rates of the coordinates. This is `Psi = int S`,
/// shifted from the origin to the point.
pub(crate) fn jacobian<G: Turning>(
    plan: &Plan<G>,
    work: &Workspace<G>,
    place: &Place,
    jacobian: &mut Matrix,
) {
    jacobian_from(plan, work, place, None, jacobian);
}

/// For each coordinate, the twist about the origin of everything beyond its piece per unit of velocity: the larger part of the
/// Jacobians of many places.
pub(crate) fn twists_beyond<G: Turning>(plan: &Plan<G>, work: &Workspace<G>) -> Vec<Twist<G, f64>> {
    let mut twists = vec![Twist::zero(); plan.n];
    let whole = plan.pieces.iter().enumerate().filter(|(_, piece)| piece.n > 0);
    let whole = whole.map(|(p, piece)| (p, piece.weights.as_slice()));
    columns::visit(plan, work, whole, |k, [twist, _]| twists[k] = twist);
    twists
}

/// [`jacobian`], with [`twists_beyond`] if they are known.
pub(crate) fn jacobian_from<G: Turning>(
    plan: &Plan<G>,
    work: &Workspace<G>,
    place: &Place,
    beyond: Option<&[Twist<G, f64>]>,
    jacobian: &mut Matrix,
) {
    jacobian.fill(0.0);
    let point = position(plan, work, place);
    let base = &work.surroundings.base.rotation;
    let mut write = |k: usize, Twist { angular, linear }: Twist<G, f64>| {
        let velocity = linear + angular.cross(point);
        let halves = [G::axial_in_space(plan.frame, angular), G::in_space(plan.frame, velocity)];
        for (half, v) in halves.into_iter().enumerate() {
            for (i, x) in base.apply(v).to_array().into_iter().enumerate() {
                jacobian[(3 * half + i, k)] = x;
            }
        }
    };
    for (p, up_to) in movers(plan, place) {
        let piece = &plan.pieces[p];
        match (&up_to, beyond) {
            (UpTo::End, Some(beyond)) => piece.coordinates().for_each(|k| write(k, beyond[k])),
            _ => columns::visit(plan, work, [(p, up_to.weights(piece))], |k, [twist, _]| write(k, twist)),
        }
    }
}

/// The part of a piece that moves a place.
enum UpTo<'a, P> {
    /// All of it.
    End,
    /// Up to the point where the next piece is attached.
    Joint(&'a [P]),
    /// Up to the place.
    Place(Vec<P>),
}

impl<P> UpTo<'_, P> {
    /// Weights of the integral.
    fn weights<'a, G: Turning<Pack = P>>(&'a self, piece: &'a PiecePlan<G>) -> &'a [P] {
        match self {
            Self::End => &piece.weights,
            Self::Joint(weights) => weights,
            Self::Place(weights) => weights,
        }
    }
}

/// Pieces that move a place: its carriers.
fn movers<'a, G: Turning>(
    plan: &'a Plan<G>,
    place: &'a Place,
) -> impl Iterator<Item = (usize, UpTo<'a, G::Pack>)> {
    let ancestors = &plan.pieces[place.piece].joined.ancestors;
    let pieces = plan.pieces[..=place.piece].iter().enumerate().filter(|(_, piece)| piece.n > 0);
    pieces.filter_map(move |(p, piece)| {
        if p == place.piece {
            let is_end = place.weights.is_empty();
            let own = || UpTo::Place(packed(place.weights.len(), |i| place.weights[i]));
            return Some((p, if is_end { UpTo::End } else { own() }));
        }
        let relatives = ancestors.iter().find(|relatives| relatives.coordinates.contains(&piece.first))?;
        let attached = relatives.attached;
        Some((p, attached.map_or(UpTo::End, |attached| UpTo::Joint(&plan.reach(attached).up_to))))
    })
}

/// Pieces that move a place, each with the weights of the integral up to it; no weights for a hinge.
pub(crate) fn moved_by<G: Turning>(plan: &Plan<G>, place: &Place) -> Vec<(usize, Vec<G::Pack>)> {
    movers(plan, place).map(|(p, up_to)| (p, up_to.weights(&plan.pieces[p]).to_vec())).collect()
}
