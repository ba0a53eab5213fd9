//! State of contacts.

use std::ops::Range;

use crate::numerics::lie::{Geometry, LANES, Lanes, Scalar, Twist, Vector, Wrench};
use crate::robot::effects::contact::plan::{Contacts, Curve, NODES, PLACES, WEIGHTS};
use crate::robot::effects::contact::products::Products;
use crate::robot::effects::contact::shapes::distance;
use crate::robot::effects::contact::shapes::obstacle::Pose;
use crate::robot::effects::contact::shapes::touch::{ContactForce, ContactPoint};
use crate::robot::plan::space::Space;

/// Number of contact points for which memory is reserved, if as many are possible. Piles of rods have about twenty for each rod; hundreds of
/// thousands are possible, of each pair with each other.
const RESERVED: usize = 4096;

/// State of contacts, moved out of the workspace while contacts are evaluated.
#[derive(Clone, Debug)]
pub(crate) struct ContactState<P> {
    /// Chebyshev coefficients of all curves.
    pub(crate) terms: Vec<Term>,
    /// Chebyshev coefficients of the sections' y and z axes, for curves that are not round; empty if there
    /// are none.
    pub(crate) axes: Vec<[Vector<f64>; 2]>,
    /// Upper bounds of the second derivatives of curves, with respect to the fraction of their length; up to date like `terms`.
    pub(crate) bends: Vec<f64>,
    /// Position and slope at the samples of all curves. Slopes are computed only for curves examined closely;
    /// for other curves the slopes at the ends are those at the adjacent nodes.
    pub(crate) samples: Vec<[Vector<f64>; 2]>,
    /// Bounding volumes of the parts of closely examined curves between samples, each with the index of its
    /// first sample.
    pub(crate) spans: Vec<Span>,
    /// For every curve, centre and radius of a bounding ball, and whether anything may touch it.
    pub(crate) bounds: Vec<(Vector<f64>, f64)>,
    pub(crate) is_near: Vec<bool>,
    /// Whether any ball or body is close to a surface that it may touch.
    pub(crate) is_rigid_near: bool,
    /// Whether curves were examined closely in this state, and bounds of their distances from their chords.
    pub(crate) is_seen: Vec<bool>,
    pub(crate) chords: Vec<Span>,
    /// Bounding balls of branches of rods (see `broad_phase`).
    pub(crate) branches: Vec<(Vector<f64>, f64)>,
    /// Pairs of curves of two rods that may touch, by pair of surfaces in ascending order; and the range of
    /// each pair of surfaces.
    pub(crate) near: Vec<[usize; 2]>,
    pub(crate) near_of: Vec<Range<usize>>,
    /// Centres of the balls, corners of the bodies, and poses of the solids.
    pub(crate) centres: Vec<Vector<f64>>,
    pub(crate) corners: Vec<Vector<f64>>,
    pub(crate) poses: Vec<Pose>,
    /// Positions of surfaces in a stored shape.
    pub(crate) cached: Cached,
    /// Whether contact forces are disabled.
    pub(crate) is_left: bool,
    /// A shape in which nothing is near.
    pub(crate) clearance: Clearance,
    /// Coordinates of the shape of `touches`, or of `laid_aside` while forces are disabled, if these are known.
    touches_of: Vec<f64>,
    touches_are_known: bool,
    laid_aside: Option<Vec<Touch>>,
    /// Largest stiffness of every pair: infinite unless contacts are softened.
    pub(crate) stiffest: Vec<f64>,
    /// Distance by which the obstacle of every pair is larger, metres: zero unless contacts are softened.
    pub(crate) grown: Vec<f64>,
    /// Normal forces of friction along rods, in the order of pairs, curves and places; `None` for those that act.
    pub(crate) held: Option<Vec<Held>>,
    /// Contact points.
    pub(crate) touches: Vec<Touch>,
    /// Whether there have been contact points since the last query.
    pub(crate) has_touched: bool,
    /// Contact points along pieces as linked lists: the first one of the piece whose nodes begin with this pack, and the next one of the
    /// same piece. Points and sides are counted as in `up_to`.
    pub(crate) first_along: Vec<Option<usize>>,
    pub(crate) next_along: Vec<Option<usize>>,
    /// Growth rates of the distances at the contact points of another motion.
    pub(crate) rates: Vec<f64>,
    /// Accelerations of separation at the contact points without contact forces.
    pub(crate) openings: Vec<f64>,
    /// By how much more they open per overlap with contact forces: stiffness over the mass that takes part. Whether that is of a pair alone, which
    /// others press.
    pub(crate) stiffnesses: Vec<(f64, bool)>,
    /// For every contact point and side, and for those of the next one, integration weights of the piece's nodes.
    pub(crate) up_to: Vec<P>,
    /// Memory for weights of nodes, and for polynomials.
    pub(crate) weights: Vec<f64>,
    pub(crate) polynomials: Vec<f64>,
}

/// Positions of surfaces in a shape.
#[derive(Clone, Debug, Default)]
pub(crate) struct Cached {
    /// Coordinates of the shape.
    pub(crate) of: Vec<f64>,
    /// Samples and bounds of all curves, centres of all balls, corners of all bodies, and axes of all solids,
    /// in this order.
    pub(crate) samples: Vec<[Vector<f64>; 2]>,
    pub(crate) bounds: Vec<(Vector<f64>, f64)>,
    pub(crate) centres: Vec<Vector<f64>>,
    pub(crate) corners: Vec<Vector<f64>>,
    pub(crate) poses: Vec<Pose>,
    /// Whether they are still to be computed, because nothing was near in the shape.
    pub(crate) is_pending: bool,
    /// Upper bounds of the curves' displacements since then; bounding balls of the volumes that curves and
    /// branches of rods sweep.
    pub(crate) moved: Vec<f64>,
    pub(crate) swept: Vec<(Vector<f64>, f64)>,
    pub(crate) branches: Vec<(Vector<f64>, f64)>,
    /// The same of the parts of curves that come close to others, in the places of their first samples.
    pub(crate) swept_parts: Vec<Option<(Vector<f64>, f64)>>,
}

impl Cached {
    /// Stores a shape whose positions are computed when they are asked for.
    pub(crate) fn store_pending(&mut self, q: &[f64]) {
        self.of.clear();
        self.of.extend_from_slice(q);
        self.is_pending = true;
    }
}

/// A shape in which nothing is near (see `clearance`).
#[derive(Clone, Debug, Default)]
pub(crate) struct Clearance {
    /// Its coordinates; empty if none is known.
    pub(super) of: Vec<f64>,
    /// Smallest gap between a ball around a curve and a solid, metres; and the longest lever of a coordinate.
    pub(super) gap: f64,
    pub(super) lever: f64,
}

impl Clearance {
    /// Marks it as unknown.
    pub(crate) fn forget(&mut self) {
        self.of.clear();
    }
}

/// Coefficient of one Chebyshev polynomial in the position of a curve, and in its first and second
/// derivatives with respect to the fraction of its length.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Term {
    pub(crate) position: Vector<f64>,
    pub(crate) slope: Vector<f64>,
    pub(crate) bend: Vector<f64>,
}

/// All points within a distance of a segment.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Span {
    ends: [Vector<f64>; 2],
    width: f64,
    /// Bounding ball.
    centre: Vector<f64>,
    radius: f64,
}

impl Span {
    pub(crate) fn new(ends: [Vector<f64>; 2], width: f64) -> Self {
        let radius = width + 0.5 * distance::between(ends[0], ends[1]);
        Self { ends, width, centre: (ends[0] + ends[1]) * 0.5, radius }
    }

    pub(crate) fn width(&self) -> f64 {
        self.width
    }

    /// The volume enlarged by a distance.
    pub(crate) fn widened(&self, by: f64) -> Self {
        Self { width: self.width + by, radius: self.radius + by, ..*self }
    }

    /// Lower bound of the distance of a point from the volume.
    pub(crate) fn distance(&self, point: Vector<f64>) -> f64 {
        distance::to_segment(point, self.ends) - self.width
    }

    /// Fraction of its segment that is nearest to the segment of another volume.
    pub(crate) fn nearest_to(&self, other: &Self) -> f64 {
        distance::nearest_of_segments(self.ends, other.ends)[0]
    }

    /// Whether two volumes may overlap.
    pub(crate) fn may_overlap(&self, other: &Self) -> bool {
        let (way, reach) = (self.centre - other.centre, self.radius + other.radius);
        way.dot(way) <= reach * reach
            && distance::of_segments(self.ends, other.ends) <= self.width + other.width
    }
}

/// A contact point of two sides.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Touch {
    pub(crate) pair: usize,
    pub(crate) sides: [SidePlace; 2],
    /// Centres, in space and the frame of the plan.
    pub(crate) centres: [Vector<f64>; 2],
    /// Its share of a distributed contact along the first side.
    pub(crate) share: Option<Share>,
    pub(crate) contact_point: ContactPoint,
    pub(crate) contact_force: ContactForce,
}

impl Touch {
    /// Wrenches, about the origin, that the two sides of a contact point require against it.
    pub(super) fn needs<G: Geometry>(&self, frame: G::Frame) -> [Wrench<G, f64>; 2] {
        let wrenches = self.contact_point.wrenches(&self.contact_force);
        std::array::from_fn(|s| {
            let [moment, force] = wrenches[s];
            let moment = moment + self.centres[s].cross(force);
            Wrench { moment: G::axial_of(frame, -moment), force: G::vector_of(frame, -force) }
        })
    }
}

/// The normal force with which friction is held at a place along a rod.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Held {
    /// Indices of the pair and of the first side's curve, and position along this curve.
    of: [usize; 2],
    x: f64,
    /// Normal force over the contact point's fraction of the stiffness, newtons.
    pressing: f64,
}

impl Held {
    fn of(touch: &Touch) -> Option<Self> {
        let SidePlace::Along { curve, x } = touch.sides[0] else { return None };
        let pressing = touch.contact_force.normal_force / touch.contact_point.weight;
        Some(Self { of: [touch.pair, curve], x, pressing })
    }

    /// The normal force at a contact point of this pair and first side: between places by linear interpolation, beyond the outermost
    /// ones theirs, and zero where the curve did not touch. `None` beside a rod, where it is not held.
    pub(super) fn at(held: &[Self], pair: usize, on: SidePlace, weight: f64) -> Option<f64> {
        let SidePlace::Along { curve, x } = on else { return None };
        let first = held.partition_point(|held| held.of < [pair, curve]);
        let held = &held[first..];
        let held = &held[..held.partition_point(|held| held.of == [pair, curve])];
        let next = held.partition_point(|held| held.x < x);
        let pressing = match (next.checked_sub(1).map(|before| held[before]), held.get(next)) {
            (Some(before), Some(after)) => {
                let part = (x - before.x) / (after.x - before.x);
                before.pressing + part * (after.pressing - before.pressing)
            }
            (Some(nearest), None) => nearest.pressing,
            (None, Some(nearest)) => nearest.pressing,
            (None, None) => 0.0,
        };
        Some(weight * pressing)
    }
}

/// A place of the rule that integrates over an interval of a rod.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Share {
    /// Index among the nodes of the rule.
    pub(crate) node: usize,
    /// Length of the interval, metres.
    pub(crate) length: f64,
}

impl Share {
    /// Its fraction beyond a cut at this distance from its place in metres, with forces per length as the polynomial through the nodes.
    /// One before the interval, zero behind it.
    pub(crate) fn beyond(&self, cut: f64) -> f64 {
        let place = (NODES[self.node] + cut / self.length).clamp(0.0, 1.0);
        // Lagrange's polynomial of the node, with the other nodes as its zeros, integrated up to the cut.
        let [a, b] = [1, 2].map(|other| NODES[(self.node + other) % PLACES]);
        let integral = place * (a * b - place * (0.5 * (a + b) - place / 3.0));
        let node = NODES[self.node];
        1.0 - integral / ((node - a) * (node - b) * WEIGHTS[self.node])
    }
}

/// Location of one side of a contact point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum SidePlace {
    /// At a fraction of a curve's length.
    Along { curve: usize, x: f64 },
    /// On a fixture.
    On(usize),
    /// At rest in the frame of the plan.
    AtRest,
}

impl SidePlace {
    /// Location of a surface on a fixture, or at rest without one.
    pub(crate) fn of(on: Option<usize>) -> Self {
        on.map_or(Self::AtRest, Self::On)
    }
}

impl<P> Default for ContactState<P> {
    /// An empty state without memory.
    fn default() -> Self {
        Self {
            terms: Vec::new(),
            axes: Vec::new(),
            bends: Vec::new(),
            samples: Vec::new(),
            spans: Vec::new(),
            bounds: Vec::new(),
            is_near: Vec::new(),
            is_seen: Vec::new(),
            chords: Vec::new(),
            branches: Vec::new(),
            near: Vec::new(),
            near_of: Vec::new(),
            centres: Vec::new(),
            corners: Vec::new(),
            poses: Vec::new(),
            cached: Cached::default(),
            is_rigid_near: false,
            is_left: false,
            clearance: Clearance::default(),
            touches_of: Vec::new(),
            touches_are_known: false,
            laid_aside: None,
            stiffest: Vec::new(),
            grown: Vec::new(),
            held: None,
            touches: Vec::new(),
            has_touched: false,
            first_along: Vec::new(),
            next_along: Vec::new(),
            rates: Vec::new(),
            openings: Vec::new(),
            stiffnesses: Vec::new(),
            up_to: Vec::new(),
            weights: Vec::new(),
            polynomials: Vec::new(),
        }
    }
}

impl<P> ContactState<P> {
    /// Whether the contact points are those of this shape. Only their forces depend on velocities.
    pub(crate) fn is_known_in(&self, q: &[f64]) -> bool {
        self.touches_are_known && self.touches_of == q
    }

    /// Marks the contact points as those of a shape.
    pub(super) fn know(&mut self, q: &[f64]) {
        self.touches_of.clear();
        self.touches_of.extend_from_slice(q);
        self.touches_are_known = true;
    }

    /// Marks the contact points as those of no shape.
    pub(crate) fn forget(&mut self) {
        self.touches_are_known = false;
    }

    /// Marks that nothing is near in this shape.
    pub(super) fn know_apart(&mut self, q: &[f64]) {
        self.touches.clear();
        self.mark_apart();
        self.know(q);
    }

    /// Marks that nothing is near.
    pub(crate) fn mark_apart(&mut self) {
        self.is_near.fill(false);
        self.is_rigid_near = false;
        self.is_seen.fill(false);
        self.near.clear();
        self.near_of.fill(0..0);
    }

    /// Lays the contact points aside while forces are disabled.
    pub(super) fn lay_aside(&mut self) {
        if self.laid_aside.is_none() {
            self.laid_aside = Some(std::mem::take(&mut self.touches));
        }
    }

    /// Holds the normal forces of friction along rods at those of the contact points, or takes those that act again.
    pub(crate) fn hold_friction(&mut self, holds: bool) {
        self.held = holds.then(|| {
            let mut held: Vec<Held> = self.touches.iter().filter_map(Held::of).collect();
            held.sort_by(|a, b| a.of.cmp(&b.of).then(a.x.total_cmp(&b.x)));
            held
        });
    }

    /// Takes them back.
    pub(super) fn undo_step(&mut self) {
        if let Some(touches) = self.laid_aside.take() {
            self.touches = touches;
        }
    }
}

impl<P: Lanes> ContactState<P> {
    /// State of contacts of a plan with this number of packs.
    pub(crate) fn new<G: Space<Pack = P>>(contacts: &Contacts<G>, packs: usize) -> Self {
        let samples = contacts.curves.iter().map(|curve| curve.samples.len()).sum();
        let coefficients = contacts.curves.iter().map(|curve| curve.expansion.len()).sum();
        let terms = contacts.curves.iter().map(Curve::terms).sum();
        let is_round = contacts.curves.iter().all(|curve| curve.is_round);
        let nodes = contacts.packs * LANES;
        let reserved = contacts.capacity.min(RESERVED);
        Self {
            terms: vec![
                Term { position: Vector::zero(), slope: Vector::zero(), bend: Vector::zero() };
                terms
            ],
            axes: vec![[Vector::zero(); 2]; if is_round { 0 } else { coefficients }],
            bends: vec![0.0; contacts.curves.len()],
            samples: vec![[Vector::zero(); 2]; samples],
            spans: vec![Span::new([Vector::zero(); 2], 0.0); samples],
            bounds: vec![(Vector::zero(), 0.0); contacts.curves.len()],
            is_near: vec![false; contacts.curves.len()],
            is_seen: vec![false; contacts.curves.len()],
            chords: vec![Span::new([Vector::zero(); 2], 0.0); contacts.curves.len()],
            branches: vec![(Vector::zero(), 0.0); 2 * contacts.curves.len()],
            near: Vec::new(),
            near_of: vec![0..0; contacts.pairs.len()],
            centres: vec![Vector::zero(); contacts.balls.len()],
            corners: vec![Vector::zero(); contacts.bodies.iter().map(|body| body.corners.len()).sum()],
            poses: vec![Pose::unmoved(); contacts.solids.len()],
            cached: Cached::default(),
            is_rigid_near: false,
            is_left: false,
            clearance: Clearance::default(),
            touches_of: Vec::new(),
            touches_are_known: false,
            laid_aside: None,
            stiffest: vec![f64::INFINITY; contacts.pairs.len()],
            grown: vec![0.0; contacts.pairs.len()],
            held: None,
            touches: Vec::with_capacity(reserved),
            has_touched: false,
            first_along: vec![None; packs],
            next_along: vec![None; 2 * reserved],
            rates: Vec::with_capacity(reserved),
            openings: Vec::new(),
            stiffnesses: Vec::new(),
            up_to: vec![P::splat(0.0); 2 * reserved * contacts.packs],
            weights: vec![0.0; nodes],
            polynomials: vec![0.0; nodes + 1],
        }
    }

    /// Integration weights of a side of a contact point: up to the point, times length.
    pub(crate) fn reach(&self, packs: usize, touch: usize, side: usize) -> &[P] {
        &self.up_to[(2 * touch + side) * packs..][..packs]
    }
}

/// Memory for the tangent of contacts.
#[derive(Clone, Debug)]
pub(crate) struct ContactTangent<G: Geometry> {
    /// S and ad_V S at the nodes of pieces that move contact points (see `turning::columns`): whether those of a
    /// piece are up to date, and where they begin.
    pub(crate) is_known: Vec<bool>,
    pub(crate) firsts: Vec<usize>,
    pub(crate) at_nodes: Vec<[Twist<G, G::Pack>; 2]>,
    /// Displacements of both sides of the current contact point per unit coordinate, changes of their motion,
    /// and changes of their required wrenches: each component by component, angular and linear ones of the first side,
    /// then of the second. A pack fits behind the last coordinate.
    pub(crate) moved: [Vec<f64>; 12],
    pub(crate) faster: [Vec<f64>; 12],
    pub(crate) answers: [Vec<f64>; 12],
    pub(crate) followed: Followed,
    pub(crate) rows: Rows<G::Pack>,
    /// For both sides, `int S` and `int ad_V S` up to the place of every coordinate, and the curve whose coordinates beyond its own
    /// piece they hold.
    pub(crate) columns: [Vec<[Twist<G, f64>; 2]>; 2],
    pub(crate) columns_of: [Option<usize>; 2],
    pub(crate) products: Products,
}

/// Memory for the motion of nearest places along rods (see `sliding`): rows with an entry for each coordinate, like those above.
#[derive(Clone, Debug)]
pub(crate) struct Rows<P> {
    /// Motion of the place on the second side along its curve per unit coordinate, and the effect of the changing shares of nodes per unit
    /// of that motion.
    pub(crate) slides: Vec<f64>,
    pub(crate) shares: Vec<f64>,
    /// Memory for weights of nodes, and for polynomials.
    pub(crate) at: Vec<P>,
    pub(crate) weights: Vec<f64>,
    pub(crate) polynomials: Vec<f64>,
}

/// Linearisation of friction in an iteration (see `follow`).
#[derive(Clone, Debug)]
pub(crate) struct Followed {
    /// Fraction of the last increment that was taken; `None` for exact tangents.
    pub(crate) length: Option<f64>,
    /// Whether the iteration is at its start.
    pub(crate) is_new: bool,
    /// Friction at the contact points of the current tangent, and of the previous one in the iteration.
    pub(crate) now: Vec<LinearisedFriction>,
    pub(crate) before: Vec<LinearisedFriction>,
}

/// Linearised friction at a contact point.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LinearisedFriction {
    /// Indices of the pair and of the first side's curve.
    pub(crate) of: [usize; 2],
    /// Position along this curve.
    pub(crate) x: f64,
    pub(crate) contact_force: ContactForce,
    /// Friction per unit normal force, on the second side.
    pub(crate) linearised: Vector<f64>,
}

impl<G: Space> ContactTangent<G> {
    /// Memory for a robot with this number of coordinates, whose pieces have these numbers of packs of nodes times components.
    pub(crate) fn new(contacts: &Contacts<G>, n: usize, blocks: impl Iterator<Item = usize>) -> Self {
        let has_contact = !contacts.pairs.is_empty();
        let numbers = if has_contact { n + LANES } else { 0 };
        let components = || std::array::from_fn(|_| vec![0.0; numbers]);
        let mut firsts = vec![0];
        firsts.extend(blocks.filter(|_| has_contact).scan(0, |first, block| {
            *first += block;
            Some(*first)
        }));
        let pieces = firsts.len() - 1;
        let nodes = contacts.packs * LANES;
        let reserved = contacts.capacity.min(RESERVED);
        Self {
            is_known: vec![false; pieces],
            at_nodes: vec![[Twist::zero(); 2]; firsts[pieces]],
            firsts,
            moved: components(),
            faster: components(),
            answers: components(),
            followed: Followed {
                length: None,
                is_new: true,
                now: Vec::with_capacity(reserved),
                before: Vec::with_capacity(reserved),
            },
            rows: Rows {
                slides: vec![0.0; numbers],
                shares: vec![0.0; numbers],
                at: vec![<G::Pack as Scalar>::splat(0.0); contacts.packs],
                weights: vec![0.0; nodes],
                polynomials: vec![0.0; nodes + 1],
            },
            columns: [(); 2].map(|()| vec![[Twist::zero(); 2]; if has_contact { n } else { 0 }]),
            columns_of: [None; 2],
            products: Products::new(contacts),
        }
    }
}
