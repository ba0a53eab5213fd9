//! The memory of all sweeps along a rod, sized by the plan: nothing is allocated after construction.

use super::plan::Plan;
use crate::lie::{Pack, Quaternion, Rotation, Twist, Vector, Wrench};

/// Where a segment begins or ends: orientation and position, and the motion there. The frame is inertial, with the
/// origin at the rod's base.
#[derive(Clone, Copy, Debug)]
pub(super) struct Station {
    pub(super) orientation: Quaternion<f64>,
    pub(super) position: Vector<f64>,
    pub(super) velocity: Twist<f64>,
    /// Acceleration minus gravity.
    pub(super) acceleration: Twist<f64>,
}

/// Quantities at the nodes (all segments in a row, [`crate::lie::LANES`] nodes a pack) and at the stations between
/// segments.
#[derive(Clone, Debug)]
pub(super) struct Workspace {
    /// Base, ends of the segments: one more than there are segments.
    pub(super) stations: Vec<Station>,
    pub(super) rotation: Vec<Rotation<Pack>>,
    pub(super) position: Vec<Vector<Pack>>,
    /// Derivative of the position along the rod.
    pub(super) slope: Vec<Vector<Pack>>,
    /// `S qd`: derivative of the velocity along the rod.
    pub(super) rate: Vec<Twist<Pack>>,
    /// `S qdd + ad_V (S qd)`: derivative of the acceleration along the rod.
    pub(super) acceleration_rate: Vec<Twist<Pack>>,
    pub(super) velocity: Vec<Twist<Pack>>,
    pub(super) acceleration: Vec<Twist<Pack>>,
    /// Momentum per length, `N V`.
    pub(super) momentum: Vec<Wrench<Pack>>,
    /// Inertial force per length, gravity included: `N A - ad_V^T N V`.
    pub(super) force: Vec<Wrench<Pack>>,
    /// Internal wrench F.
    pub(super) internal: Vec<Wrench<Pack>>,
    /// The coordinates of which rotation and position are here, and the state of which the rest is here.
    pub(super) kinematics_of: Vec<f64>,
    pub(super) motion_of: Vec<f64>,
}

impl Workspace {
    pub(super) fn new(plan: &Plan) -> Self {
        let station = Station {
            orientation: plan.base_orientation,
            position: Vector::zero(),
            velocity: Twist::zero(),
            acceleration: Twist { angular: Vector::zero(), linear: -plan.gravity },
        };
        let zero = Vector::<Pack>::zero();
        Self {
            stations: vec![station; plan.segments.len() + 1],
            rotation: vec![Rotation { x: zero, y: zero, z: zero }; plan.packs],
            position: vec![zero; plan.packs],
            slope: vec![zero; plan.packs],
            rate: vec![Twist::zero(); plan.packs],
            acceleration_rate: vec![Twist::zero(); plan.packs],
            velocity: vec![Twist::zero(); plan.packs],
            acceleration: vec![Twist::zero(); plan.packs],
            momentum: vec![Wrench::zero(); plan.packs],
            force: vec![Wrench::zero(); plan.packs],
            internal: vec![Wrench::zero(); plan.packs],
            // NaN equals nothing, and nor does an entry too many where there are no coordinates: both are computed first.
            kinematics_of: vec![f64::NAN; plan.n + 1],
            motion_of: vec![f64::NAN; 3 * plan.n],
        }
    }
}
