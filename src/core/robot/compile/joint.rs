//! Compiles joints to pieces of a plan.

use crate::description::joint::{JointForces, Motion};
use crate::description::rod::piece::Piece;
use crate::description::rod::{Gauss, GivenSection, STRAINS, Segment};
use crate::numerics::lie::{Twist, VectorSpace};
use crate::robot::compile::piece;
use crate::robot::plan::hinge::Hinge;
use crate::robot::plan::joined::Joined;
use crate::robot::plan::material::Moments;
use crate::robot::plan::piece::PiecePlan;
use crate::robot::plan::point::Points;
use crate::robot::turning::Turning;

/// Number of nodes of a piece with a rotation vector: its integrals of products of sines of the angle are
/// exact to rounding up to a full turn (the error of the rule, Davis and Rabinowitz 1984, eq. 2.7.12, is
/// below 1e-19 there).
const NODES_OF_A_TURN: usize = 12;

/// A rigid piece, without coordinates.
pub(crate) fn rigid<G: Turning>(joined: Joined<G>, first: usize, first_pack: usize) -> PiecePlan<G> {
    PiecePlan {
        length: 0.0,
        joined,
        is_joint: true,
        hinge: None,
        first,
        n: 0,
        first_pack,
        packs: 0,
        gauss: Gauss::none(),
        largest_gap: 0.0,
        reference_curvature: Vec::new(),
        largest_reference_curvature: 0.0,
        weights: Vec::new(),
        from_base: Vec::new(),
        to_end: Vec::new(),
        basis: Vec::new(),
        weighted_basis: Vec::new(),
        turning: G::Constants::default(),
        components: Vec::new(),
        source: None,
        reference_slope: Vec::new(),
        stretch: None,
        is_extensible: false,
        couplings: Vec::new(),
        mass: Vec::new(),
        moments: Moments::Round(Vec::new()),
        retardation_time: 0.0,
        spread: Vec::new(),
        points: Points::default(),
        immersed: None,
    }
}

/// One elementary motion of a joint, after the given hinges.
pub(crate) fn moving<G: Turning>(
    motion: Motion,
    frame: G::Frame,
    forces: Option<&JointForces>,
    joined: Joined<G>,
    [first, first_pack, hinges]: [usize; 3],
) -> PiecePlan<G> {
    let zero = Twist { angular: VectorSpace::zero(), linear: VectorSpace::zero() };
    let twist = match motion {
        Motion::AboutAll => {
            let turn = piece::plan(turn(), frame, joined, first, first_pack);
            return PiecePlan { is_joint: true, ..turn };
        }
        Motion::About(axis) => Twist { angular: G::axial_of(frame, axis.into()), ..zero },
        Motion::Screw(axis, advance) => Twist {
            angular: G::axial_of(frame, axis.into()),
            linear: G::vector_of(frame, axis.into()) * advance,
        },
        Motion::Along(axis) => Twist { linear: G::vector_of(frame, axis.into()), ..zero },
    };
    let forces = forces.filter(|forces| !forces.are_absent()).cloned();
    let turns = motion.is_turn();
    let advances = !matches!(motion, Motion::About(_));
    let hinge = Some(Hinge { twist, turns, advances, forces, index: hinges });
    PiecePlan { hinge, n: 1, ..rigid(joined, first, first_pack) }
}

/// A piece for a rotation vector: massless and without extension, so that its end coincides with its start.
/// Its curvature is the rotation vector along the length one.
fn turn() -> Piece {
    let section = GivenSection {
        stiffness: [0.0; STRAINS * STRAINS].into(),
        mass: [0.0].into(),
        inertia: [0.0; 9].into(),
        centre: [0.0; 2].into(),
    };
    let segment = Segment {
        modes: [1, 1, 1, 0, 0, 0],
        reference_strain: [0.0; STRAINS].into(),
        nodes: Some(NODES_OF_A_TURN),
        ..Segment::given(1.0, section)
    };
    Piece::whole(&segment)
}
