//! Cosserat rods with a strain parametrisation.
//!
//! `description` is what a rod is, in plain data; `plan` is the same compiled for computing. The sweeps of [`RodModel`] read
//! the plan and work in a `workspace`: `kinematics` (where the rod is), `inverse_dynamics` (what forces a motion needs),
//! `tangent` (how they change with the motion, and the mass matrix; `chain` for long rods), `energy`.

mod basis;
mod chain;
mod cost;
mod description;
mod elasticity;
mod energy;
mod explanation;
mod inertia;
mod inverse_dynamics;
mod kinematics;
mod model;
mod plan;
mod quadrature;
mod section;
mod sweeps;
mod tangent;
mod turning;
mod workspace;

pub use basis::legendre;
pub use cost::Multiplications;
pub use description::{
    MAX_COORDINATES, MAX_MODES, MAX_NODES, QUATERNION_TOLERANCE, Rod, STRAIGHT, STRAIN_NAMES, STRAINS,
    Segment,
};
pub use explanation::Explanation;
pub use kinematics::{Place, Pose};
pub use model::{Kernel, RodModel, Solve};
pub use quadrature::Gauss;
pub use section::Section;
