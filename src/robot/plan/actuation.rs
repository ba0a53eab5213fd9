//! Actuators compiled for computing: forces on lengths.
//!
//! A tendon that is embedded in a rod at d(X) = (0, y, z) from its axis has the slope
//! `u = gamma + kappa x d + d'` in the axes of the section and the length `l = int |u| dX` (docs/actuators.md): it depends
//! on strains alone, and needs no pose. In the strain components e_c of a piece, `u = u_0 + sum_c b_c e_c` with the
//! directions `b_c` = e_i x d for curvatures and e_i for the others.

use super::command::Command;
use crate::lie::Vector;
use crate::rod::Profile;

/// The actuators of a plan.
#[derive(Clone, Debug)]
pub(crate) struct Actuation<P> {
    pub(crate) actuators: Vec<ActuatorPlan>,
    pub(crate) sleeves: Vec<Sleeve<P>>,
    pub(crate) lines: Vec<Line<P>>,
    /// Lines that are shorter have collapsed, metres.
    pub(crate) shortest_line: f64,
    /// The points of the world that lines end at, in the frame of the base at rest.
    pub(crate) world_points: Vec<Vector<f64>>,
    pub(crate) active_strains: Vec<ActivePart>,
}

/// The part of an active strain that lies in a piece.
#[derive(Clone, Debug)]
pub(crate) struct ActivePart {
    pub(crate) actuator: usize,
    pub(crate) piece: usize,
    pub(crate) strain: usize,
    /// Of a unit, along the link's rod; and from fractions of the piece's length to those of the rod's: `from + rate x`.
    pub(crate) shape: Profile<1>,
    pub(crate) from: f64,
    pub(crate) rate: f64,
}

/// A straight part of a tendon, between two points.
#[derive(Clone, Debug)]
pub(crate) struct Line<P> {
    pub(crate) actuator: usize,
    pub(crate) ends: [End<P>; 2],
    /// Of a tendon with friction, where an embedded part goes on at an end.
    pub(crate) mouths: [Option<Mouth>; 2],
}

/// Where an embedded part of a tendon with friction begins or ends at a straight part, in the axes of the section there.
#[derive(Clone, Debug)]
pub(crate) struct Mouth {
    /// u_0, of the reference strain.
    pub(crate) start: Vector<f64>,
    /// How u changes with a unit of each coordinate that its strains depend on.
    pub(crate) changes: Vec<(usize, Vector<f64>)>,
}

impl<P> Line<P> {
    /// Whether different pieces move its ends.
    pub(crate) fn can_shrink(&self) -> bool {
        let [from, to] = self.ends.each_ref().map(|end| match end {
            End::InWorld(_) => None,
            End::On { moved_by, .. } => Some(moved_by.iter().map(|(piece, _)| *piece)),
        });
        !from.into_iter().flatten().eq(to.into_iter().flatten())
    }
}

/// An end of a straight part.
#[derive(Clone, Debug)]
pub(crate) enum End<P> {
    /// At one of the points of the world, by its place among them.
    InWorld(usize),
    /// On one of the plan's points, beside it in the axes there.
    On {
        point: usize,
        beside: Vector<f64>,
        /// The pieces that move it, each with the weights of the integral up to it; none of a hinge.
        moved_by: Vec<(usize, Vec<P>)>,
    },
}

/// A part of a tendon, in the order of its path.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Part {
    /// A thread of a sleeve, by the places of both, and by its place among all threads.
    Thread {
        sleeve: usize,
        thread: usize,
    },
    Line(usize),
}

/// Friction of a tendon along the parts that are embedded.
#[derive(Clone, Debug)]
pub(crate) struct Friction {
    /// The coefficient mu.
    pub(crate) coefficient: f64,
    /// Rate of the length below which it is smoothed.
    pub(crate) velocity: f64,
    /// The direction of sliding, where it is given.
    pub(crate) sliding: Option<Command<1>>,
}

/// An actuator.
#[derive(Clone, Debug)]
pub(crate) struct ActuatorPlan {
    pub(crate) command: Command<1>,
    pub(crate) law: Law,
    /// The part of its length that is linear in the coordinates: its value where these are zero, and its gradient.
    pub(crate) length_at_zero: f64,
    pub(crate) gradient: Vec<(usize, f64)>,
    /// Of a tendon, its way.
    pub(crate) path: Vec<Part>,
    pub(crate) friction: Option<Friction>,
    /// The coordinates that its length depends on, in ascending order.
    pub(crate) reaches: Vec<usize>,
    /// The piece that all of these belong to, if one is enough.
    pub(crate) piece: Option<usize>,
    /// Whether it is always told the same, so that its force has a potential.
    pub(crate) has_potential: bool,
}

/// How the force of an actuator follows from its length l, the rate of that, and what it is told.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Law {
    /// A tendon of this tension, slack where it is negative.
    Tension,
    /// A tendon of this free length: `max(0, k (l - l_0) + c l')`.
    Cable { stiffness: f64, damping: f64 },
    /// A tendon that is never longer than this: its tension is the multiplier of that constraint, by its place among those of
    /// this kind.
    Inextensible { place: usize },
    /// A chamber of this pressure, which makes its volume grow.
    Pressure,
    /// A motor of this torque, between limits if there are any.
    Torque { limits: Option<[f64; 2]> },
    /// A motor that answers `k (q_0 - q) - c q'`, between limits if there are any.
    Servo { stiffness: f64, damping: f64, limits: Option<[f64; 2]> },
    /// So much of an active strain, of which a unit alone has this elastic energy.
    Amount { energy_of_unit: f64 },
}

/// Tendons along one part of a piece, with nodes of their own there.
#[derive(Clone, Debug)]
pub(crate) struct Sleeve<P> {
    pub(crate) piece: usize,
    /// Fractions of the piece's length between which it lies.
    pub(crate) ends: [f64; 2],
    pub(crate) packs: usize,
    /// Quadrature weights times length.
    pub(crate) weights: Vec<P>,
    /// Basis of the piece at the nodes, and the same times the weights: entry `[degree * packs + pack]`.
    pub(crate) basis: Vec<P>,
    pub(crate) weighted_basis: Vec<P>,
    pub(crate) components: Vec<SleeveComponent>,
    pub(crate) threads: Vec<Thread<P>>,
    /// What the turning of threads with friction follows from, if there are any.
    pub(crate) turning: Option<SleeveTurning>,
}

/// What the turning of threads along a sleeve follows from.
#[derive(Clone, Debug)]
pub(crate) struct SleeveTurning {
    /// Integration matrix from the beginning of the sleeve to its nodes, times the length: entry `[node * nodes + l]`.
    pub(crate) up_to: Vec<f64>,
    /// Derivatives of the basis along the rod, per metre: entry `[degree * nodes + node]`.
    pub(crate) basis_slopes: Vec<f64>,
    /// Curvature of the reference strain at the nodes.
    pub(crate) reference: Vec<Vector<f64>>,
}

/// A strain component of the piece of a sleeve.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SleeveComponent {
    /// Its place among the six strains.
    pub(crate) strain: usize,
    pub(crate) first: usize,
    pub(crate) modes: usize,
}

/// One tendon in a sleeve.
#[derive(Clone, Debug)]
pub(crate) struct Thread<P> {
    pub(crate) actuator: usize,
    /// u_0 at the nodes: of the reference strain.
    pub(crate) start: Vec<Vector<P>>,
    /// b_c at the nodes: entry `[component * packs + pack]`.
    pub(crate) directions: Vec<Vector<P>>,
    /// `b_c . b_d` of the components c <= d: entry `[pair * packs + pack]`.
    pub(crate) products: Vec<P>,
    /// Of a tendon with friction, derivatives along the rod at the nodes: of u_0, and of b_c (entry
    /// `[component * nodes + node]`).
    pub(crate) start_slopes: Vec<Vector<f64>>,
    pub(crate) direction_slopes: Vec<Vector<f64>>,
}

impl ActivePart {
    /// The strain of a unit at a fraction of the piece's length.
    pub(crate) fn of_unit(&self, x: f64) -> f64 {
        self.shape.at(self.from + self.rate * x)[0]
    }
}

impl<P> Actuation<P> {
    /// Whether the force of an actuator follows from lengths of more than one piece, or from poses: its stiffness couples
    /// these.
    pub(crate) fn couples(&self, actuator: usize) -> bool {
        let ActuatorPlan { law, friction, piece, .. } = &self.actuators[actuator];
        let has_stiffness = law.has_stiffness() || friction.is_some();
        self.lines.iter().any(|line| line.actuator == actuator) || (has_stiffness && piece.is_none())
    }

    /// Whether any does.
    pub(crate) fn couples_pieces(&self) -> bool {
        (0..self.actuators.len()).any(|actuator| self.couples(actuator))
    }

    /// Where the threads of a sleeve begin among the numbers that all threads have for a pack, and a component and pack.
    pub(crate) fn offsets(&self, sleeve: usize, thread: usize) -> [usize; 2] {
        let before = self.sleeves[..sleeve].iter().map(|sleeve| sleeve.threads.len() * sleeve.packs);
        let with_components = self.sleeves[..sleeve]
            .iter()
            .map(|sleeve| sleeve.threads.len() * sleeve.packs * sleeve.components.len());
        let sleeve = &self.sleeves[sleeve];
        [
            before.sum::<usize>() + thread * sleeve.packs,
            with_components.sum::<usize>() + thread * sleeve.packs * sleeve.components.len(),
        ]
    }
}

impl ActuatorPlan {
    /// Whether what it is told depends on time by itself.
    pub(crate) fn varies_in_time(&self) -> bool {
        let sliding = self.friction.as_ref().and_then(|friction| friction.sliding.as_ref());
        self.command.varies_in_time() || sliding.is_some_and(Command::varies_in_time)
    }
}

impl Law {
    /// Whether the force depends on the length or on its rate.
    pub(crate) fn has_stiffness(self) -> bool {
        matches!(self, Self::Cable { .. } | Self::Servo { .. })
    }
}

/// The pairs c <= d of so many components, row by row.
pub(crate) fn pairs(components: usize) -> impl Iterator<Item = (usize, usize)> {
    (0..components).flat_map(move |c| (c..components).map(move |d| (c, d)))
}
