//! Robots, and their compilation for fast evaluation.
//!
//! `description` describes a robot as plain data; `compile` converts it to a `plan` for the computation. The
//! sweeps read the plan and work in a `state`: the `kernel` contains the recursions along the rod
//! (kinematics, inverse dynamics, tangents), each of the `effects` a kind of force. `explain` reports the computation
//! and its cost.
//!
//! ```
//! use lissom::body::Body;
//! use lissom::joint::{Joint, JointForces};
//! use lissom::robot::{Link, Robot, RobotModel};
//! use lissom::rod::Segment;
//!
//! let hinge = Joint::Revolute { axis: [0.0, 1.0, 0.0], forces: JointForces::default() };
//! let arm = Link { joint: hinge, body: Some(Body::point(0.1)), ..Link::new("arm") };
//! let segment = Segment { modes: [0, 2, 0, 0, 0, 0], ..Segment::straight(0.3, 8e-3, 5e5, 2e5, 1070.0) };
//! let tail = Link { parent: Some(0), position: [0.2, 0.0, 0.0], rod: vec![segment], ..Link::new("tail") };
//! let robot = Robot::new(vec![arm, tail]);
//! assert_eq!(robot.coordinate_names(), ["arm.angle", "tail.bend_y[0]", "tail.bend_y[1]"]);
//! let mut model = RobotModel::new(&robot)?;
//! let tip = model.place_on(1, None);
//! assert!((model.pose_at(&[0.0; 3], &tip).position.x - 0.5).abs() < 1e-12);
//! # Ok::<(), lissom::error::InvalidInput>(())
//! ```

mod algebra;
mod choice;
mod compile;
mod description;
mod driven;
#[doc(hidden)]
pub mod effects;
pub(crate) mod explain;
mod facts;
mod kernel;
mod model;
mod plan;
mod state;
mod sweeps;
#[cfg(test)]
mod tests;
#[cfg(test)]
mod tests_of_contact;
#[cfg(test)]
mod tests_of_loops;
mod turning;

pub use crate::robot::effects::contact::query::ReportedTouch;
pub use crate::robot::explain::{Explanation, Multiplications};
pub use choice::{Kernel, Solve};
pub use description::{Driven, Inputs, Link, MAX_COORDINATES, Robot, Rod, described};
#[doc(hidden)]
pub use description::{Origin, SignalOf, Spans, origin};
pub use kernel::kinematics::Pose;
pub use kernel::momentum::Momentum;
pub use model::RobotModel;
pub use plan::point::Place;
