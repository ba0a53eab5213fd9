//! lissom simulates soft robots and other slender bodies as Cosserat rods. Its solvers are usable on their
//! own.
//!
//! Describe a rod in plain data ([`rod::Segment`], [`robot::Rod`]) and compile it into a model
//! ([`robot::RobotModel`]). For any [`model::Model`] lissom computes motions
//! ([`simulate()`](simulate::simulate)), step by step with inputs ([`stepping`]), to a given accuracy
//! ([`accuracy`]) or thousands in parallel ([`ensemble`]), equilibria ([`statics`]) and vibrations
//! ([`modes`]). The solvers do not depend on rods: [`roots`], [`ode`], [`newmark`], [`radau`].
//!
//! ```
//! use lissom::robot::{Rod, RobotModel};
//! use lissom::rod::Segment;
//! use lissom::statics::{self, equilibrium};
//!
//! // A wire of steel, one metre long and two millimetres thick, with three modes of bending in the vertical plane.
//! let segment = Segment { modes: [0, 3, 0, 0, 0, 0], ..Segment::straight(1.0, 1e-3, 210e9, 80e9, 7800.0) };
//! let mut wire = RobotModel::of_rod(&Rod::new(vec![segment]))?;
//! let shape = equilibrium(&mut wire, &statics::Options::default(), &mut || Ok(()))?.expect("nothing interrupts it");
//! let tip = wire.place(1.0);
//! let sag = -wire.pose_at(&shape.q, &tip).position.z;
//! assert!((sag - 0.17756).abs() < 1e-4);
//! # Ok::<(), lissom::error::InvalidInput>(())
//! ```
//!
//! All units are SI. Invalid input returns an [`error::InvalidInput`] that lists every mistake; the outcome
//! of a computation is a status in its result.

mod analysis;
mod integrators;
#[cfg(feature = "python")]
#[doc(hidden)]
pub mod python;
#[cfg(feature = "scene")]
pub mod scene;
mod simulation;

// The rooms below these, under the same paths as in their crate.
use lissom_core::{description, numerics};
pub use lissom_core::{error, model, robot};

pub use analysis::{actuate, curve, modes, reach, refined_modes, stability, statics};
pub use description::{body, joint, rod, schema, signal, world};
pub use integrators::{newmark, ode, radau, second_order};
pub use model::{pendulum, springs};
pub use numerics::{lie, linalg, parallel, roots};
pub use robot::effects::*;
pub use simulation::{accuracy, balance, ensemble, methods, sensitivity, simulate, stepping, time_limit};
