//! A rod compiled for computing: everything that does not change with the state, computed once.

use std::f64::consts::PI;

use super::anchor::{self, Anchor};
use super::description::{Rod, STRAIGHT, STRAINS, Segment};
use super::immersion::{self, Immersed, Immersion};
use super::inertia::{self, Inertia};
use super::load::{self, Extent, Frame};
use super::piece::{self, Piece};
use super::points::{self, Point, Points};
use super::quadrature::Gauss;
use super::section::{Section, SectionProperties};
use super::spread::{self, Spread};
use super::surroundings::World;
use super::turning::Turning;
use super::validity::Stretch;
use crate::lie::{LANES, Lanes, Rotation, Scalar, Twist, VectorSpace, Wrench};
use crate::linalg::{Matrix, condition_number};
use crate::signal::Signal;

/// Nodes that a segment needs beyond its number of modes: two integrations (strain to velocity, velocity to force) and
/// a rotation by up to about half a turn cost this many degrees of the polynomials; see `docs/rod.md` for the measured
/// error.
const NODES_BEYOND_MODES: usize = 9;

/// A linearly tapered radius enters the second moment of area with its fourth power, and takes so many nodes.
const NODES_FOR_TAPER: usize = 4;

/// Nodes that every rule of a row needs beyond its share, by the part of the segment that the widest one covers.
const NODES_AT_KINKS: f64 = 3.0;

/// Nodes that a stiffness takes beyond its modes where it is no polynomial along the rod: quotients of sizes converge like
/// their nearest pole, and these nodes leave rounding for tapers as steep as 1 to 10.
const NODES_FOR_QUOTIENTS: usize = 30;

/// A rod compiled for computing, in the frame of its base: the origin there, and axes along the body axes there.
#[derive(Clone, Debug)]
pub(super) struct Plan<G: Turning> {
    pub(super) n: usize,
    pub(super) segments: Vec<SegmentPlan<G>>,
    /// Packs of nodes of all segments together.
    pub(super) packs: usize,
    /// Where the frame lies in the rod's space.
    pub(super) frame: G::Frame,
    pub(super) world: World,
    pub(super) loads: Vec<Load<G>>,
    /// What is concentrated at places, in their order.
    pub(super) points: Vec<Point<G>>,
    /// The springs to the world, in the frame of the base at rest.
    pub(super) anchors: Vec<Anchor>,
    /// The fluid around it, where that answers to motion.
    pub(super) immersion: Option<Immersion>,
    /// Whether a dead load acts anywhere, and whether the base or a load depends on time by itself.
    pub(super) has_dead_loads: bool,
    pub(super) varies_in_time: bool,
    /// Whether anything responds to the motion of its place other than by its inertia.
    pub(super) has_responses: bool,
}

/// A load. Its wrench about the place where it acts, in the axes of the plan if it is dead, else in those of the section, stands in the
/// workspace: it may change with time.
#[derive(Clone, Debug)]
pub(super) struct Load<G: Turning> {
    pub(super) extent: Extent,
    pub(super) frame: Frame,
    /// The wrench, as far as it is constant.
    pub(super) wrench: Wrench<G, f64>,
    /// Force and moment, where the wrench varies: because one of them does, or the base moves and the load is dead.
    pub(super) signals: Option<[Signal<3>; 2]>,
    /// Whether its force has a potential: a constant dead force. No moment has one.
    pub(super) has_potential: bool,
    pub(super) has_moment: bool,
}

/// One segment of a [`Plan`]: a segment of the rod, or a piece of one.
#[derive(Clone, Debug)]
pub(super) struct SegmentPlan<G: Turning> {
    pub(super) length: f64,
    /// First coordinate and number of coordinates.
    pub(super) first: usize,
    pub(super) n: usize,
    /// First pack of nodes and number of packs.
    pub(super) first_pack: usize,
    pub(super) packs: usize,
    pub(super) gauss: Gauss,
    /// Between neighbouring nodes, or the ends and the nodes next to them, in metres; zero where twisting turns nothing, because the
    /// segment is straight.
    pub(super) largest_gap: f64,
    /// Of the reference strain, at the nodes: radians per metre.
    pub(super) reference_curvature: Vec<G::Axial<f64>>,
    pub(super) largest_reference_curvature: f64,
    /// Quadrature weights, times the length.
    pub(super) weights: Vec<G::Pack>,
    /// Integration matrix from the segment's base to the nodes, times the length: entry `[pack * nodes + l]`.
    pub(super) from_base: Vec<G::Pack>,
    /// The same from the nodes to the segment's end.
    pub(super) to_end: Vec<G::Pack>,
    /// Basis at the nodes: entry `[degree * packs + pack]`.
    pub(super) basis: Vec<G::Pack>,
    /// Basis times quadrature weights.
    pub(super) weighted_basis: Vec<G::Pack>,
    pub(super) turning: G::Constants,
    pub(super) components: Vec<Component>,
    /// What is computed.
    pub(super) piece: Piece,
    /// Linear part of the reference strain at the nodes.
    pub(super) reference_slope: Vec<G::Vector<G::Pack>>,
    /// Its stretch, where it has modes of that.
    pub(super) stretch: Option<Stretch>,
    /// Whether stretch or shear can differ from those of a straight rod.
    pub(super) is_extensible: bool,
    /// Stiffness between components, where strains are coupled.
    pub(super) couplings: Vec<Coupling>,
    /// Mass per length at the nodes.
    pub(super) mass: Vec<G::Pack>,
    pub(super) moments: Moments<G>,
    pub(super) retardation_time: f64,
    /// What is spread along it, and what is concentrated at places of it.
    pub(super) spread: Vec<Spread<G>>,
    pub(super) points: Points,
    /// The fluid around it, where that answers to motion.
    pub(super) immersed: Option<Immersed<G>>,
}

/// A strain component that exists in a segment.
#[derive(Clone, Debug)]
pub(super) struct Component {
    /// Index among the strains of the geometry.
    pub(super) index: usize,
    pub(super) modes: usize,
    /// First coordinate.
    pub(super) first: usize,
    /// `int phi_j H phi_k`, modes x modes.
    pub(super) stiffness: Matrix,
    /// Whether that is diagonal.
    pub(super) is_orthogonal: bool,
}

impl Component {
    /// Row `j` of `K (q + mu qd)`, of this component's coordinates.
    #[inline(always)]
    pub(super) fn elastic_force(&self, j: usize, q: &[f64], qd: &[f64], mu: f64) -> f64 {
        if self.is_orthogonal {
            return self.stiffness[(j, j)] * (q[j] + mu * qd[j]);
        }
        (0..self.modes).map(|k| self.stiffness[(j, k)] * (q[k] + mu * qd[k])).sum()
    }
}

/// The stiffness between two strain components of a segment, `int phi_j H phi_k` of the first by the second: K has it above
/// the diagonal, and its transpose below.
#[derive(Clone, Debug)]
pub(super) struct Coupling {
    /// First coordinates.
    pub(super) first: [usize; 2],
    pub(super) stiffness: Matrix,
}

impl Coupling {
    /// The coordinates of both components.
    #[inline(always)]
    pub(super) fn coordinates(&self) -> [std::ops::Range<usize>; 2] {
        let (rows, columns) = self.stiffness.shape();
        [self.first[0]..self.first[0] + rows, self.first[1]..self.first[1] + columns]
    }

    /// Adds this part of `K (q + mu qd)`.
    #[inline(always)]
    pub(super) fn add_elastic_force(&self, q: &[f64], qd: &[f64], mu: f64, tau: &mut [f64]) {
        let [rows, columns] = self.coordinates();
        for (j, row) in rows.enumerate() {
            for (k, column) in columns.clone().enumerate() {
                let stiffness = self.stiffness[(j, k)];
                tau[row] += stiffness * (q[column] + mu * qd[column]);
                tau[column] += stiffness * (q[row] + mu * qd[row]);
            }
        }
    }
}

/// How the mass of a segment's sections is spread across.
#[derive(Clone, Debug)]
pub(super) enum Moments<G: Turning> {
    /// Alike in all directions of the space that the rod moves in: the rotary inertia per length at the nodes.
    Round(Vec<G::Pack>),
    /// Any: the inertia per length at the nodes, about the rod's axis and in the section's axes.
    General(Vec<Inertia<G, G::Pack>>),
}

impl<G: Turning> Moments<G> {
    fn new(frame: G::Frame, sections: &[SectionProperties]) -> Self {
        let nodes = sections.len();
        let is_centred = |section: &SectionProperties| {
            let centre = G::vector_of(frame, section.centre.into());
            centre.dot(centre) == 0.0
        };
        let round = |section: &SectionProperties| {
            is_centred(section).then(|| G::rotary_inertia(frame, section.inertia_about_axis())).flatten()
        };
        match sections.iter().map(round).collect::<Option<Vec<f64>>>() {
            Some(rotary) => Self::Round(packed(nodes, |i| rotary[i])),
            None => Self::General(inertia::packed(nodes, |i| {
                let section = &sections[i];
                Inertia {
                    mass: section.mass,
                    first_moment: G::vector_of(frame, section.centre.into()) * section.mass,
                    second_moment: G::second_moment_of(frame, section.inertia_about_axis()),
                }
            })),
        }
    }
}

/// The values of a function of the node, [`LANES`] to a pack.
pub(super) fn packed<P: Lanes>(nodes: usize, f: impl Fn(usize) -> f64) -> Vec<P> {
    (0..nodes / LANES).map(|pack| P::from_lanes(std::array::from_fn(|lane| f(pack * LANES + lane)))).collect()
}

impl<G: Turning> Plan<G> {
    /// Compiles a valid rod for a frame that it does not leave.
    pub(super) fn new(rod: &Rod, frame: G::Frame) -> Self {
        let mut segments = Vec::with_capacity(rod.segments.len());
        let (mut first, mut first_pack) = (0, 0);
        for piece in rod.segments.iter().flat_map(piece::of) {
            let plan = SegmentPlan::new(piece, frame, first, first_pack);
            first += plan.n;
            first_pack += plan.packs;
            segments.push(plan);
        }
        let world = World::new(rod);
        let is_moving = world.motion.is_some();
        let loads: Vec<Load<G>> =
            rod.all_loads().map(|load| Load::new(load, frame, &world.base.rotation, is_moving)).collect();
        spread::compile(&mut segments, &loads);
        let (points, supported) =
            points::compile(frame, &mut segments, &loads, rod.all_bodies(), &rod.supports);
        let mut plan = Self {
            n: first,
            packs: first_pack,
            frame,
            points,
            anchors: Vec::new(),
            immersion: None,
            has_responses: !rod.supports.is_empty(),
            has_dead_loads: loads.iter().any(|load| load.frame == Frame::World),
            varies_in_time: is_moving || loads.iter().any(|load| load.signals.is_some()),
            segments,
            loads,
            world,
        };
        if !rod.supports.is_empty() {
            plan.anchors = anchor::compile(&plan, &rod.supports, &supported);
        }
        if let Some(fluid) = &rod.fluid {
            immersion::compile(&mut plan, rod, fluid);
        }
        plan
    }

    /// Whether anything but the rod's own material takes energy out of its motion.
    pub(super) fn is_resisted(&self) -> bool {
        self.anchors.iter().any(Anchor::is_damped) || self.immersion.is_some_and(|fluid| fluid.has_drag)
    }

    /// Whether its sections look round and nothing couples their strains or answers to motion: no springs, no fluid. Sweeps are
    /// compiled once for such rods and once for all others, because what is never reached still costs a loop its registers
    /// (measured: forward dynamics of plain rods took a fifth longer when one sweep served all).
    pub(super) fn is_plain(&self) -> bool {
        let is_plain = |segment: &SegmentPlan<G>| {
            matches!(segment.moments, Moments::Round(_))
                && segment.couplings.is_empty()
                && segment.immersed.is_none()
        };
        !self.has_responses && self.segments.iter().all(is_plain)
    }

    /// Whether motion loses energy.
    pub(super) fn is_damped(&self) -> bool {
        self.segments.iter().any(|segment| segment.retardation_time > 0.0) || self.is_resisted()
    }

    /// Whether drag, a current or the motion of the base make forces depend on velocities.
    pub(super) fn has_velocity_forces(&self) -> bool {
        let flows = |fluid: Immersion| fluid.has_drag || (fluid.has_added_mass && self.world.has_current());
        self.world.motion.is_some() || self.immersion.is_some_and(flows)
    }

    /// Whether the base moves or a load has no potential.
    pub(super) fn is_driven(&self) -> bool {
        let is_driven = |load: &Load<G>| !load.has_potential || load.has_moment;
        self.world.motion.is_some()
            || self.loads.iter().any(is_driven)
            || self.immersion.is_some_and(|fluid| fluid.has_drag && self.world.has_current())
    }

    /// The same plan, of a rod in space, with everything computed that could be skipped: absent strains and loads of zero
    /// included.
    pub(super) fn with_nothing_skipped(mut self) -> Self {
        self.has_dead_loads = true;
        self.has_responses = true;
        for point in &mut self.points {
            point.is_oriented = true;
        }
        for segment in &mut self.segments {
            segment.is_extensible = true;
            for component in &mut segment.components {
                component.is_orthogonal = false;
            }
            segment.moments = segment.general_moments(self.frame);
            segment.couple_all();
            for index in 0..STRAINS {
                if segment.components.iter().all(|component| component.index != index) {
                    segment.components.push(Component {
                        index,
                        modes: 0,
                        first: segment.first,
                        stiffness: Matrix::zeros(0, 0),
                        is_orthogonal: false,
                    });
                }
            }
        }
        self
    }

    /// Quadrature nodes of each segment.
    pub(super) fn nodes(&self) -> Vec<usize> {
        self.segments.iter().map(|segment| segment.gauss.nodes.len()).collect()
    }
}

impl<G: Turning> Load<G> {
    pub(super) fn new(
        load: load::Load,
        frame: G::Frame,
        base_rotation: &Rotation<f64>,
        base_moves: bool,
    ) -> Self {
        let constant = [&load.force, &load.moment].map(|signal| signal.constant().unwrap_or_default());
        let wrench: Wrench<G, f64> = wrench(constant, load.frame, frame, base_rotation);
        let varies = load.varies_in_time() || (base_moves && load.frame == Frame::World);
        Self {
            extent: load.extent,
            frame: load.frame,
            has_potential: load.frame == Frame::World && load.force.constant().is_some(),
            has_moment: load.moment.constant().is_none() || wrench.moment.dot(wrench.moment) > 0.0,
            signals: varies.then_some([load.force, load.moment]),
            wrench,
        }
    }

    /// The wrench before any time is set: NaN where it depends on it.
    pub(super) fn at_first(&self) -> Wrench<G, f64> {
        if self.signals.is_some() { self.wrench * f64::NAN } else { self.wrench }
    }
}

/// The wrench of a force and a moment in the axes that a load keeps its direction in: those of the world are turned into those of the
/// plan.
pub(super) fn wrench<G: Turning>(
    [force, moment]: [[f64; 3]; 2],
    axes: Frame,
    frame: G::Frame,
    base_rotation: &Rotation<f64>,
) -> Wrench<G, f64> {
    let [force, moment] = [force, moment].map(|v| match axes {
        Frame::World => base_rotation.apply_transposed(v.into()),
        Frame::Body => v.into(),
    });
    Wrench { moment: G::axial_of(frame, moment), force: G::vector_of(frame, force) }
}

impl<G: Turning> SegmentPlan<G> {
    fn new(piece: Piece, frame: G::Frame, first: usize, first_pack: usize) -> Self {
        let degrees = piece.degrees();
        let gauss = quadrature(&piece);
        let nodes = gauss.nodes.len();
        let packs = nodes / LANES;
        let length = piece.length();

        let pack = |f: &dyn Fn(usize) -> f64| packed(nodes, f);
        let integral = gauss.integral();
        let up_to: Vec<Vec<f64>> = gauss.nodes.iter().map(|&x| integral.weights_up_to(x)).collect();
        let matrix = |f: &dyn Fn(usize, usize) -> f64| -> Vec<G::Pack> {
            let entry =
                |p: usize, l: usize| G::Pack::from_lanes(std::array::from_fn(|lane| f(p * LANES + lane, l)));
            (0..packs).flat_map(|p| (0..nodes).map(move |l| (p, l))).map(|(p, l)| entry(p, l)).collect()
        };
        let at_nodes: Vec<Vec<f64>> = gauss
            .nodes
            .iter()
            .map(|&x| {
                let mut values = vec![0.0; degrees];
                piece.basis.values(x, &mut values);
                values
            })
            .collect();

        let mut components = Vec::new();
        let mut next = first;
        for (strain, &modes) in piece.modes.iter().enumerate() {
            if modes > 0 {
                let stiffness = stiffness(&piece, [strain; 2]);
                let index = G::strain_index(frame, strain);
                components.push(Component {
                    index,
                    modes,
                    first: next,
                    stiffness,
                    is_orthogonal: !is_tapered(&piece) && piece.basis.is_orthogonal(),
                });
                next += modes;
            }
        }
        let before_stretch: usize = piece.modes[..3].iter().sum();
        let stretch = (piece.modes[3] > 0).then(|| Stretch::new(&piece, &gauss, first + before_stretch));
        let reference_slope = (0..packs)
            .map(|pack| {
                let at = |lane: usize| {
                    let [.., d, e, f] = piece.reference(gauss.nodes[pack * LANES + lane]);
                    G::vector_of(frame, [d, e, f].into())
                };
                let mut slope = G::Vector::<G::Pack>::zero();
                for index in 0..G::COMPONENTS - G::ANGULAR {
                    *G::vector_component(&mut slope, index) =
                        G::Pack::from_lanes(std::array::from_fn(|lane| {
                            *G::vector_component(&mut at(lane), index)
                        }));
                }
                slope
            })
            .collect();
        let sections: Vec<_> = gauss.nodes.iter().map(|&x| piece.section(x)).collect();
        let is_straight = |strain: usize| {
            piece.segment.reference_strain.is_entry_constant(strain) == Some(STRAIGHT[strain])
        };
        let is_extensible = piece.modes[3..].iter().any(|&modes| modes > 0) || !(3..STRAINS).all(is_straight);

        let [_, bend_y, bend_z, _, shear_y, shear_z] = piece.modes;
        let turns = bend_y + bend_z + shear_y + shear_z > 0 || !(1..STRAINS).all(is_straight);

        Self {
            length,
            largest_gap: if turns { length * gauss.largest_gap() } else { 0.0 },
            first,
            n: next - first,
            first_pack,
            packs,
            weights: pack(&|i| length * gauss.weights[i]),
            from_base: matrix(&|i, l| length * up_to[i][l]),
            to_end: matrix(&|i, l| length * (gauss.weights[l] - up_to[i][l])),
            basis: (0..degrees).flat_map(|k| pack(&|i| at_nodes[i][k])).collect(),
            weighted_basis: (0..degrees)
                .flat_map(|k| pack(&|i| length * gauss.weights[i] * at_nodes[i][k]))
                .collect(),
            largest_reference_curvature: largest_reference_curvature(&piece, &gauss.nodes),
            reference_curvature: gauss
                .nodes
                .iter()
                .map(|&x| {
                    let [a, b, c, ..] = piece.reference(x);
                    G::axial_of(frame, [a, b, c].into())
                })
                .collect(),
            turning: G::constants(&piece, frame, &gauss, &components),
            couplings: couplings(&piece, first),
            components,
            reference_slope,
            stretch,
            is_extensible,
            mass: pack(&|i| sections[i].mass),
            moments: Moments::new(frame, &sections),
            retardation_time: piece.segment.retardation_time,
            spread: Vec::new(),
            points: Points::default(),
            immersed: None,
            gauss,
            piece,
        }
    }

    /// The moments of its sections as those of any.
    fn general_moments(&self, frame: G::Frame) -> Moments<G> {
        match &self.moments {
            Moments::General(_) => self.moments.clone(),
            Moments::Round(rotary) => Moments::General(
                self.mass
                    .iter()
                    .zip(rotary)
                    .map(|(&mass, &rotary)| Inertia::round(frame, mass, rotary))
                    .collect(),
            ),
        }
    }

    /// Couples all components that are not coupled yet, by zeros.
    fn couple_all(&mut self) {
        for (i, a) in self.components.iter().enumerate() {
            for b in &self.components[i + 1..] {
                let first = [a.first, b.first];
                if self.couplings.iter().all(|coupling| coupling.first != first) {
                    self.couplings.push(Coupling { first, stiffness: Matrix::zeros(a.modes, b.modes) });
                }
            }
        }
    }

    /// The packs of this segment's nodes among those of the rod.
    pub(super) fn node_packs(&self) -> std::ops::Range<usize> {
        self.first_pack..self.first_pack + self.packs
    }

    /// The row of an integration matrix (`from_base` or `to_end`) that leads to pack `pack`.
    pub(super) fn row<'a>(&self, matrix: &'a [G::Pack], pack: usize) -> &'a [G::Pack] {
        let nodes = self.packs * LANES;
        &matrix[pack * nodes..(pack + 1) * nodes]
    }

    /// The rows of an integration matrix.
    #[inline(always)]
    pub(super) fn rows<'a>(&self, matrix: &'a [G::Pack]) -> std::slice::ChunksExact<'a, G::Pack> {
        matrix.chunks_exact(self.packs * LANES)
    }

    /// [`Self::field`] at all nodes.
    #[inline(always)]
    pub(super) fn fields(&self, q: &[f64], fields: &mut [Twist<G, G::Pack>]) {
        fields.fill(Twist::zero());
        for component in &self.components {
            let rows = self.basis.chunks_exact(self.packs);
            for (&q, row) in q[component.first..][..component.modes].iter().zip(rows) {
                for (field, &basis) in fields.iter_mut().zip(row) {
                    let entry = field.component_mut(component.index);
                    *entry = basis.mul_add(G::Pack::splat(q), *entry);
                }
            }
        }
    }

    /// `sum_k phi_k q_k` of every strain at the nodes of one pack; components that do not exist are zero.
    #[inline(always)]
    pub(super) fn field(&self, q: &[f64], pack: usize) -> Twist<G, G::Pack> {
        let mut field = Twist::zero();
        for component in &self.components {
            let mut sum = G::Pack::splat(0.0);
            for (k, &q) in q[component.first..][..component.modes].iter().enumerate() {
                sum = self.basis[k * self.packs + pack].mul_add(G::Pack::splat(q), sum);
            }
            *field.component_mut(component.index) = sum;
        }
        field
    }
}

fn is_tapered(piece: &Piece) -> bool {
    !piece.segment.section.is_constant()
}

/// The nodes of a piece: whole packs of them, the same number between any two places where the basis, the reference strain or
/// the section has a kink.
fn quadrature(piece: &Piece) -> Gauss {
    let breaks = piece.breaks();
    Gauss::composite(nodes_of_rule(piece, &breaks) as usize, &breaks)
}

/// How many nodes a piece takes; infinite where no number of them would do.
pub(super) fn number_of_nodes(piece: &Piece) -> f64 {
    let breaks = piece.breaks();
    nodes_of_rule(piece, &breaks) * (breaks.len() + 1) as f64
}

/// Nodes between any two of its breaks.
fn nodes_of_rule(piece: &Piece, breaks: &[f64]) -> f64 {
    let rules = breaks.len() + 1;
    let of_rule = match (piece.segment.nodes, rules) {
        (Some(nodes), _) => nodes.div_ceil(rules) as f64,
        (None, 1) => needed(piece),
        (None, _) => (needed(piece) * widest(breaks)).ceil() + NODES_AT_KINKS,
    };
    // Whole packs: the rounding up costs nothing and buys accuracy.
    let lanes = (0..LANES).map(|more| of_rule + more as f64);
    lanes.into_iter().find(|of_rule| (rules as f64 * of_rule) % LANES as f64 == 0.0).unwrap_or(of_rule)
}

/// Nodes that a piece without kinks takes.
fn needed(piece: &Piece) -> f64 {
    let beyond = NODES_BEYOND_MODES + nodes_for_taper(piece.segment.section.degree_of_inertia());
    (piece.degree() + 1 + beyond) as f64 + nodes_for_turns(piece)
}

/// Nodes for a reference strain that turns the rod by more than the half turn that [`NODES_BEYOND_MODES`] are for. Polynomials follow
/// `exp(i k x)` on (-1, 1) once their degree is beyond k (Boyd 2001, section 2.4): half the turn in radians. Products of two such
/// functions are integrated by half as many nodes as they have degrees.
pub(super) fn nodes_for_turns(piece: &Piece) -> f64 {
    (0.5 * (turn(piece) - PI)).max(0.0).ceil()
}

/// By how much the reference strain turns a piece, in radians.
pub(super) fn turn(piece: &Piece) -> f64 {
    /// Places that are looked at.
    const LOOKS: usize = 32;
    let places: Vec<f64> = (0..=LOOKS).map(|i| i as f64 / LOOKS as f64).collect();
    largest_reference_curvature(piece, &places) * piece.length()
}

/// The largest curvature or twist of the reference strain at these places.
fn largest_reference_curvature(piece: &Piece, places: &[f64]) -> f64 {
    let curvature = |&x: &f64| {
        let [a, b, c, ..] = piece.reference(x);
        (a * a + b * b + c * c).sqrt()
    };
    places.iter().map(curvature).fold(0.0, f64::max)
}

/// Nodes for inertia of this degree along the rod. Beyond a linear taper, each node integrates two degrees more.
fn nodes_for_taper(degree: usize) -> usize {
    degree.min(NODES_FOR_TAPER) + degree.saturating_sub(NODES_FOR_TAPER).div_ceil(2)
}

/// The largest distance between these places of (0, 1), and of its ends.
fn widest(breaks: &[f64]) -> f64 {
    let ends = breaks.iter().chain(&[1.0]);
    [0.0].iter().chain(breaks).zip(ends).map(|(from, to)| to - from).fold(0.0, f64::max)
}

/// The largest condition number of the stiffness of a strain, in the 2-norm.
pub(super) fn condition_of_stiffness(segment: &Segment) -> f64 {
    let condition = |piece: Piece| {
        let present = (0..STRAINS).filter(|&strain| piece.modes[strain] > 0);
        let of_strain = |strain: usize| condition_number(&stiffness(&piece, [strain; 2]));
        present.map(of_strain).fold(1.0, f64::max)
    };
    piece::of(segment).map(condition).fold(1.0, f64::max)
}

/// `int phi_j H phi_k` of a strain component, or between two: exact where the section is a circle, given or constant.
fn stiffness(piece: &Piece, strains: [usize; 2]) -> Matrix {
    let [rows, columns] = strains.map(|strain| piece.modes[strain]);
    let modes = rows.max(columns);
    // Degree 2 (modes - 1) + 4, a linear radius to the fourth power; and 4 for each degree more.
    let beyond = if piece.segment.section.is_polynomial() { 3 } else { NODES_FOR_QUOTIENTS };
    let beyond = beyond + 2 * piece.degree_of_section().saturating_sub(1);
    let gauss = Gauss::composite(piece.basis.degree(modes) + beyond, &piece.breaks_of_stiffness(modes));
    let mut stiffness = Matrix::zeros(rows, columns);
    let mut phi = vec![0.0; modes];
    let is_orthogonal = !is_tapered(piece) && piece.basis.is_orthogonal();
    for (&x, &weight) in gauss.nodes.iter().zip(&gauss.weights) {
        piece.basis.values(x, &mut phi);
        let [row, column] = strains;
        let scale = piece.length() * weight * piece.section(x).stiffness[row][column];
        for j in 0..rows {
            for k in 0..columns {
                // What stands off the diagonal of an orthogonal basis is rounding where the section is constant.
                if j == k || !is_orthogonal {
                    stiffness[(j, k)] += scale * phi[j] * phi[k];
                }
            }
        }
    }
    stiffness
}

/// The stiffness between different strains of a piece whose first coordinate is `first`.
fn couplings(piece: &Piece, first: usize) -> Vec<Coupling> {
    let Section::Given(given) = &piece.segment.section else { return Vec::new() };
    let start = |strain: usize| first + piece.modes[..strain].iter().sum::<usize>();
    let coupling =
        |strains: [usize; 2]| Coupling { first: strains.map(start), stiffness: stiffness(piece, strains) };
    given.coupled(&piece.modes).map(coupling).collect()
}
