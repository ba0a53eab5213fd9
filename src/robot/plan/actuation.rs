//! Actuators compiled for computing: forces on lengths.
//!
//! A tendon that is embedded in a rod at d(X) = (0, y, z) from its axis has the slope
//! `u = gamma + kappa x d + d'` in the axes of the section and the length `l = int |u| dX` (docs/actuators.md): it depends
//! on strains alone, and needs no pose. In the strain components e_c of a piece, `u = u_0 + sum_c b_c e_c` with the
//! directions `b_c` = e_i x d for curvatures and e_i for the others.

use super::command::Command;
use crate::lie::Vector;

/// The actuators of a plan.
#[derive(Clone, Debug)]
pub(crate) struct Actuation<P> {
    pub(crate) actuators: Vec<ActuatorPlan>,
    pub(crate) sleeves: Vec<Sleeve<P>>,
}

/// An actuator.
#[derive(Clone, Debug)]
pub(crate) struct ActuatorPlan {
    pub(crate) command: Command<1>,
    pub(crate) law: Law,
    /// The part of its length that is linear in the coordinates: its value where these are zero, and its gradient.
    pub(crate) length_at_zero: f64,
    pub(crate) gradient: Vec<(usize, f64)>,
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
}

impl<P> Actuation<P> {
    /// Whether forces follow from lengths of more than one piece: their stiffness couples these.
    pub(crate) fn couples_pieces(&self) -> bool {
        self.actuators.iter().any(|actuator| actuator.law.has_stiffness() && actuator.piece.is_none())
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
