//! Working memory of all sweeps, sized by the plan; nothing is allocated after construction.

pub(crate) mod point;
pub(crate) mod surroundings;
pub(crate) mod tangent;

use crate::description::signal::StepContext;
use crate::numerics::lie::{LANES, Scalar, Twist, VectorSpace, Wrench};
use crate::robot::effects::parts::States;
use crate::robot::plan::Plan;
use crate::robot::plan::space::Space;
use crate::robot::state::point::PointState;
use crate::robot::state::surroundings::Surroundings;

/// Orientation, position and motion of a station, where a piece begins or ends.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Station<G: Space> {
    /// Orientation, if pieces with nodes follow.
    pub(crate) orientation: G::Orientation,
    /// Rotation, if joints or welds follow.
    pub(crate) rotation: G::Rotation<f64>,
    pub(crate) position: G::Vector<f64>,
    pub(crate) velocity: Twist<G, f64>,
    /// Acceleration minus gravity.
    pub(crate) acceleration: Twist<G, f64>,
}

/// Orientation and position of a station.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Placement<G: Space> {
    pub(crate) orientation: G::Orientation,
    pub(crate) rotation: G::Rotation<f64>,
    pub(crate) position: G::Vector<f64>,
}

impl<G: Space> Station<G> {
    #[inline(always)]
    pub(crate) fn placement(&self) -> Placement<G> {
        let &Self { orientation, rotation, position, .. } = self;
        Placement { orientation, rotation, position }
    }

    #[inline(always)]
    pub(crate) fn place(&mut self, placement: Placement<G>) {
        let Placement { orientation, rotation, position } = placement;
        (self.orientation, self.rotation, self.position) = (orientation, rotation, position);
    }
}

/// Quantities at the nodes (all pieces in sequence, [`crate::numerics::lie::LANES`] nodes per pack) and at the stations
/// between pieces, in the frame of the plan.
#[derive(Clone, Debug)]
pub(crate) struct Workspace<G: Space> {
    /// Stations, starting with the frame.
    pub(crate) stations: Vec<Station<G>>,
    pub(crate) rotation: Vec<G::Rotation<G::Pack>>,
    pub(crate) position: Vec<G::Vector<G::Pack>>,
    /// Derivative of the position along the rod.
    pub(crate) slope: Vec<G::Vector<G::Pack>>,
    /// `S qd`: derivative of the velocity along the rod.
    pub(crate) rate: Vec<Twist<G, G::Pack>>,
    /// `S qdd + ad_V (S qd)`: derivative of the acceleration along the rod.
    pub(crate) acceleration_rate: Vec<Twist<G, G::Pack>>,
    pub(crate) velocity: Vec<Twist<G, G::Pack>>,
    pub(crate) acceleration: Vec<Twist<G, G::Pack>>,
    /// Momentum per length, `N V`.
    pub(crate) momentum: Vec<Wrench<G, G::Pack>>,
    /// Inertial force per length, gravity included: `N A - ad_V^T N V`.
    pub(crate) force: Vec<Wrench<G, G::Pack>>,
    /// Internal wrench F.
    pub(crate) internal: Vec<Wrench<G, G::Pack>>,
    /// Internal wrench in section axes, about the node.
    pub(crate) body: Vec<Wrench<G, G::Pack>>,
    /// State of the plan's points.
    pub(crate) points: Vec<PointState<G>>,
    pub(crate) inputs: Vec<f64>,
    pub(crate) effects: States<G>,
    /// Time at which varying base and loads are evaluated, NaN until it is set; and the world at that time.
    pub(crate) time: f64,
    /// How tables of loads and commands are evaluated, and the time of the last jump.
    pub(crate) step_context: StepContext,
    /// By how much earlier loads are evaluated than everything else, in seconds.
    pub(crate) lag: f64,
    pub(crate) surroundings: Surroundings<G>,
    /// Unit twists S of the hinges, and sine and cosine of half their angles.
    pub(crate) hinges: Vec<Twist<G, f64>>,
    pub(crate) half_angles: Vec<[G::Pack; 2]>,
    /// Wrench required by everything that a station carries; for the first station the wrench exerted by the
    /// base.
    pub(crate) carried: Vec<Wrench<G, f64>>,
    /// Wrench transmitted at the start of the piece that ends at a station.
    pub(crate) through: Vec<Wrench<G, f64>>,
    /// Coordinates of the rotations and positions in memory, and the state of all other quantities, if valid.
    pub(crate) kinematics_of: Vec<f64>,
    pub(crate) motion_of: Vec<f64>,
    pub(crate) motion_is_known: bool,
}

impl<G: Space> Workspace<G> {
    pub(crate) fn new(plan: &Plan<G>) -> Self {
        let surroundings = Surroundings::at_first(&plan.world, plan.frame);
        let (velocity, acceleration) = surroundings.motion(&plan.world, plan.frame);
        let mut effects = States::new(&plan.effects, plan.n, plan.packs);
        if plan.world.motion.is_some() {
            effects.anchors = surroundings::anchors_in_base(plan, &surroundings.base).collect();
            effects.actuation.world_points = surroundings::points_in_base(plan, &surroundings.base).collect();
            effects.loops.world_ends = surroundings::ends_in_base(plan, &surroundings.base).collect();
        }
        let station = Station {
            orientation: G::start(),
            rotation: G::unrotated(),
            position: VectorSpace::zero(),
            velocity,
            acceleration,
        };
        let vectors = vec![VectorSpace::zero(); plan.packs];
        let twists = vec![Twist::zero(); plan.packs];
        let wrenches = vec![Wrench::zero(); plan.packs];
        Self {
            stations: vec![station; plan.stations],
            hinges: vec![Twist::zero(); plan.hinges.len()],
            half_angles: vec![[G::Pack::splat(0.0); 2]; plan.hinges.len().div_ceil(LANES)],
            carried: vec![Wrench::zero(); plan.stations],
            through: vec![Wrench::zero(); plan.stations],
            rotation: vec![G::unrotated(); plan.packs],
            position: vectors.clone(),
            slope: vectors,
            rate: twists.clone(),
            acceleration_rate: twists.clone(),
            velocity: twists.clone(),
            acceleration: twists,
            momentum: wrenches.clone(),
            force: wrenches.clone(),
            internal: wrenches.clone(),
            body: wrenches,
            points: vec![PointState::new(); plan.points.len()],
            inputs: plan.inputs.defaults().to_vec(),
            effects,
            time: f64::NAN,
            step_context: StepContext::EXACT,
            lag: 0.0,
            surroundings,
            kinematics_of: unknown(plan.n),
            motion_of: vec![f64::NAN; 3 * plan.n],
            motion_is_known: false,
        }
    }

    /// Marks kinematics and motion as invalid.
    pub(crate) fn forget(&mut self) {
        let n = self.motion_of.len() / 3;
        self.kinematics_of = unknown(n);
        self.motion_is_known = false;
        self.effects.contact.forget();
    }
}

/// Coordinates that differ from those of every state: NaN, and one additional entry for robots without
/// coordinates.
fn unknown(n: usize) -> Vec<f64> {
    vec![f64::NAN; n + 1]
}
