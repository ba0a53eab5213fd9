//! Rigid motions in space and in the plane: vectors, rotations, twists and wrenches.
//!
//! All types are generic over a [`Scalar`]: `f64` for one point of a rod, [`Pack`] for several points at
//! once. Sweeps along a rod are also generic over a [`Geometry`]. Twists are (angular; linear) and wrenches
//! (moment; force), both about the origin of the inertial frame.
//!
//! ```
//! use lissom::lie::{Quaternion, Vector};
//!
//! let quarter = Quaternion::exp(Vector { x: 0.0, y: 0.0, z: std::f64::consts::FRAC_PI_2 });
//! let turned = quarter.rotation().apply(Vector { x: 1.0, y: 0.0, z: 0.0 });
//! assert!((turned.y - 1.0).abs() < 1e-15);
//! ```

#[cfg(test)]
mod counted;
mod geometry;
mod instructions;
mod pack;
mod planar;
mod rotation;
mod rotation_vector;
mod scalar;
mod sine_cosine;
mod spatial;
mod symmetric;
mod twist;
mod vector;

#[cfg(test)]
pub(crate) use counted::products;
pub use geometry::{Cross, Geometry, SecondMoment, VectorSpace};
pub use instructions::{Instructions, Sweep, run_portably};
pub use pack::{LANES, Lanes, Pack, weighted_sum};
pub use planar::{Planar, Plane, PlaneRotation, PlaneVector, Turn};
pub use rotation::{QUATERNION_TOLERANCE, Quaternion, Rotation};
pub use rotation_vector::{
    moment_of_rotation_vector, moment_of_rotation_vector_slopes, rotation_vector_motion, rotation_vector_rate,
};
pub use scalar::Scalar;
pub use sine_cosine::sine_cosine;
pub use spatial::Spatial;
pub use symmetric::Symmetric;
pub use twist::{Twist, Wrench};
pub use vector::Vector;
