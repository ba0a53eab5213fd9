//! Compiled actuators: forces that act on lengths.
//!
//! A tendon embedded in a rod at the offset d(X) = (0, y, z) from its axis has the slope `u = gamma + kappa x
//! d + d'` in section axes and the length `l = int |u| dX` (docs/actuators.md), which depends only on
//! strains, not on poses. In the strain components e_c of a piece, `u = u_0 + sum_c b_c e_c` with the
//! directions `b_c` = e_i x d for curvatures and e_i for the others.

use crate::description::rod::Profile;
use crate::numerics::lie::Vector;
use crate::robot::plan::command::Command;

/// Actuators of a plan.
#[derive(Clone, Debug, Default)]
pub(crate) struct Actuation<P> {
    pub(crate) actuators: Vec<ActuatorPlan>,
    pub(crate) routing_segments: Vec<RoutingSegment<P>>,
    pub(crate) lines: Vec<Line<P>>,
    /// Points of the world at which straight parts end, in the frame of the base at rest.
    pub(crate) world_points: Vec<Vector<f64>>,
    pub(crate) active_strains: Vec<ActivePart>,
}

/// Part of an active strain in one piece.
#[derive(Clone, Debug)]
pub(crate) struct ActivePart {
    pub(crate) actuator: usize,
    pub(crate) piece: usize,
    pub(crate) strain: usize,
    /// Shape of a unit active strain along the link's rod, and the conversion from fractions of the piece's
    /// length to those of the rod: `from + rate x`.
    pub(crate) shape: Profile<1>,
    pub(crate) from: f64,
    pub(crate) rate: f64,
}

/// A straight part of a tendon between two points.
#[derive(Clone, Debug)]
pub(crate) struct Line<P> {
    pub(crate) actuator: usize,
    pub(crate) ends: [End<P>; 2],
    /// For a tendon with friction, the embedded parts that continue at the ends.
    pub(crate) guide_exits: [Option<GuideExit>; 2],
    /// Length below which it has collapsed, metres.
    pub(crate) shortest: f64,
}

/// Transition between a straight and an embedded part of a tendon with friction, in section axes.
#[derive(Clone, Debug)]
pub(crate) struct GuideExit {
    /// u_0, for the reference strain.
    pub(crate) start: Vector<f64>,
    /// Derivatives of u with respect to the coordinates of the strains at this place.
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
    /// At a point of the world, by index.
    InWorld(usize),
    /// On a point of the plan, at an offset in its axes.
    On {
        point: usize,
        beside: Vector<f64>,
        /// Pieces that move the end, each with the weights of the integral up to it; no weights for a hinge.
        moved_by: Vec<(usize, Vec<P>)>,
    },
}

/// Parts of a tendon in the order of its path.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Part {
    /// A guide of a routing segment, by the indices of both, and by the index among all guides.
    Guide {
        routing_segment: usize,
        guide: usize,
    },
    Line(usize),
}

/// Friction of a tendon along its embedded parts.
#[derive(Clone, Debug)]
pub(crate) struct Friction {
    /// Coefficient mu.
    pub(crate) coefficient: f64,
    /// Rate of length below which friction is smoothed.
    pub(crate) velocity: f64,
    /// Prescribed direction of sliding, if any.
    pub(crate) sliding: Option<Command<1>>,
}

/// An actuator.
#[derive(Clone, Debug)]
pub(crate) struct ActuatorPlan {
    pub(crate) command: Command<1>,
    pub(crate) law: Law,
    /// The part of its length that is linear in the coordinates: the value at zero coordinates, and the
    /// gradient.
    pub(crate) length_at_zero: f64,
    pub(crate) gradient: Vec<(usize, f64)>,
    /// Path of a tendon.
    pub(crate) path: Vec<Part>,
    pub(crate) friction: Option<Friction>,
    /// Coordinates on which its length depends, in ascending order.
    pub(crate) reaches: Vec<usize>,
    /// The piece of all these coordinates, if there is only one.
    pub(crate) piece: Option<usize>,
    /// Whether the command is constant, so that the force has a potential.
    pub(crate) has_potential: bool,
}

/// Force law of an actuator: force from the length l, its rate, and the command.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Law {
    /// Tendon with commanded tension, slack if negative.
    Tension,
    /// Tendon with commanded rest length: `max(0, k (l - l_0) + c l')`.
    Cable { stiffness: f64, damping: f64 },
    /// Inextensible tendon: the tension is the multiplier of the constraint on its length, by the index among
    /// inextensible tendons.
    Inextensible { place: usize },
    /// Chamber with commanded pressure, which increases its volume.
    Pressure,
    /// Motor with commanded torque, between limits if any.
    Torque { limits: Option<[f64; 2]> },
    /// Motor with the force `k (q_0 - q) - c q'`, between limits if any.
    Servo { stiffness: f64, damping: f64, limits: Option<[f64; 2]> },
    /// Active strain with commanded amount; the elastic energy of a unit alone.
    Amount { energy_of_unit: f64 },
}

/// Tendons along one part of a piece, with separate nodes.
#[derive(Clone, Debug)]
pub(crate) struct RoutingSegment<P> {
    pub(crate) piece: usize,
    /// Start and end as fractions of the piece's length.
    pub(crate) ends: [f64; 2],
    pub(crate) packs: usize,
    /// Quadrature weights times length.
    pub(crate) weights: Vec<P>,
    /// Basis of the piece at the nodes, without and with the weights: entry `[degree * packs + pack]`.
    pub(crate) basis: Vec<P>,
    pub(crate) weighted_basis: Vec<P>,
    pub(crate) components: Vec<RoutingComponent>,
    pub(crate) guides: Vec<Guide<P>>,
    /// Data for the rotation of guides with friction, if any.
    pub(crate) turning: Option<RoutingTurns>,
}

/// Data for the rotation of guides along a routing segment.
#[derive(Clone, Debug)]
pub(crate) struct RoutingTurns {
    /// Integration matrix from the start of the routing segment to its nodes, times the length: entry `[node * nodes +
    /// l]`.
    pub(crate) up_to: Vec<f64>,
    /// Derivatives of the basis along the rod, per metre: entry `[degree * nodes + node]`.
    pub(crate) basis_slopes: Vec<f64>,
    /// Curvature of the reference strain at the nodes.
    pub(crate) reference: Vec<Vector<f64>>,
}

/// A strain component of the piece of a routing segment.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RoutingComponent {
    /// Index among the six strains.
    pub(crate) strain: usize,
    pub(crate) first: usize,
    pub(crate) modes: usize,
}

/// One tendon in a routing segment.
#[derive(Clone, Debug)]
pub(crate) struct Guide<P> {
    pub(crate) actuator: usize,
    /// u_0 at the nodes, for the reference strain.
    pub(crate) start: Vec<Vector<P>>,
    /// b_c at the nodes: entry `[component * packs + pack]`.
    pub(crate) directions: Vec<Vector<P>>,
    /// `b_c . b_d` for components c <= d: entry `[pair * packs + pack]`.
    pub(crate) products: Vec<P>,
    /// For tendons with friction, derivatives along the rod at the nodes: of u_0, and of b_c (entry
    /// `[component * nodes + node]`).
    pub(crate) start_slopes: Vec<Vector<f64>>,
    pub(crate) direction_slopes: Vec<Vector<f64>>,
}

impl ActivePart {
    /// Strain of a unit amount at a fraction of the piece's length.
    pub(crate) fn of_unit(&self, x: f64) -> f64 {
        self.shape.at(self.from + self.rate * x)[0]
    }
}

impl<P> Actuation<P> {
    /// The straight parts of an actuator.
    #[inline(always)]
    pub(crate) fn lines_of(&self, actuator: usize) -> impl Iterator<Item = usize> {
        (0..self.lines.len()).filter(move |&line| self.lines[line].actuator == actuator)
    }

    /// Whether an actuator's force depends on the lengths of several pieces, or on poses, so that its
    /// stiffness couples pieces.
    pub(crate) fn couples(&self, actuator: usize) -> bool {
        let ActuatorPlan { law, friction, piece, .. } = &self.actuators[actuator];
        let has_stiffness = law.has_stiffness() || friction.is_some();
        self.lines_of(actuator).next().is_some() || (has_stiffness && piece.is_none())
    }

    /// Whether any actuator couples pieces.
    pub(crate) fn couples_pieces(&self) -> bool {
        (0..self.actuators.len()).any(|actuator| self.couples(actuator))
    }

    /// Start of a routing segment's guide in arrays over all guides: per pack, and per component and pack.
    pub(crate) fn offsets(&self, routing_segment: usize, guide: usize) -> [usize; 2] {
        let before = self.routing_segments[..routing_segment]
            .iter()
            .map(|routing_segment| routing_segment.guides.len() * routing_segment.packs);
        let with_components = self.routing_segments[..routing_segment].iter().map(|routing_segment| {
            routing_segment.guides.len() * routing_segment.packs * routing_segment.components.len()
        });
        let routing_segment = &self.routing_segments[routing_segment];
        [
            before.sum::<usize>() + guide * routing_segment.packs,
            with_components.sum::<usize>() + guide * routing_segment.packs * routing_segment.components.len(),
        ]
    }
}

impl ActuatorPlan {
    /// Whether the command depends on time explicitly.
    pub(crate) fn varies_in_time(&self) -> bool {
        let sliding = self.friction.as_ref().and_then(|friction| friction.sliding.as_ref());
        self.command.varies_in_time() || sliding.is_some_and(Command::varies_in_time)
    }
}

impl Law {
    /// Whether the force depends on the length or its rate.
    pub(crate) fn has_stiffness(self) -> bool {
        matches!(self, Self::Cable { .. } | Self::Servo { .. })
    }

    /// Fixes whether a tendon exactly at its commanded length is taut, independently of rounding.
    pub(crate) fn decide(&mut self, is_taut: bool) {
        if let Self::Cable { stiffness, damping } = *self {
            *self = match is_taut {
                true => Self::Servo { stiffness, damping, limits: None },
                false => Self::Cable { stiffness: 0.0, damping: 0.0 },
            };
        }
    }

    /// Whether the force begins at a length.
    pub(crate) fn is_cable(self) -> bool {
        matches!(self, Self::Cable { .. })
    }
}

/// Pairs c <= d of this number of components, row by row.
pub(crate) fn pairs(components: usize) -> impl Iterator<Item = (usize, usize)> {
    (0..components).flat_map(move |c| (c..components).map(move |d| (c, d)))
}
