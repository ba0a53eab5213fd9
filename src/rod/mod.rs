//! Cosserat rods with a strain parametrisation.
//!
//! `description` is what a rod is, in plain data; `plan` is the same compiled for computing. The sweeps of [`RodModel`] read
//! the plan and work in a `workspace`: `kinematics` (where the rod is), `inverse_dynamics` (what forces a motion needs),
//! `points` (what is concentrated at places of the rod), `tangent` (how the forces change with the motion, and the mass
//! matrix; `chain` for long rods), `energy`.

mod anchor;
mod base;
mod basis;
mod body;
mod chain;
mod cost;
mod description;
mod elasticity;
mod energy;
mod explanation;
mod fluid;
mod immersion;
mod inertia;
mod inverse_dynamics;
mod kinematics;
mod load;
mod model;
mod piece;
mod plan;
mod point_tangent;
mod points;
mod prescribed;
mod profile;
mod quadrature;
mod response;
mod section;
mod spread;
mod support;
mod surroundings;
mod sweeps;
mod tangent;
mod turning;
mod validity;
mod workspace;

pub use base::{BaseMotion, BaseRotation, quaternion_motion};
pub use basis::{Basis, legendre};
pub use body::Body;
pub use cost::Multiplications;
pub use description::{
    MAX_COORDINATES, MAX_MODES, MAX_NODES, MAX_OWN_NODES, QUATERNION_TOLERANCE, Rod, STRAIGHT, STRAIN_NAMES,
    STRAINS, Segment,
};
pub use explanation::Explanation;
pub use fluid::Fluid;
pub use kinematics::{Place, Pose};
pub use load::{Extent, Frame, Load};
pub use model::{Kernel, RodModel, Solve};
pub use profile::{MAX_DEGREE, MAX_STATIONS, Parts, Profile, Unsampled};
pub use quadrature::Gauss;
pub use section::{GivenSection, Section, SectionProperties, Shape, ShearCorrection, diagonal};
pub use support::Support;
