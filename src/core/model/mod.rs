//! The interface of mechanical systems to the solvers.
//!
//! ```
//! use lissom::model::Dynamics;
//! use lissom::pendulum::SpringPendulum;
//!
//! let mut pendulum = SpringPendulum::new(1.0, 1.0, 10.0, 9.81)?;
//! let mut tau = [0.0; 2];
//! pendulum.inverse_dynamics(&[0.0, 0.1], &[0.0, 0.0], &[0.0, 0.0], &mut tau);
//! assert!((tau[1] - 1.0).abs() < 1e-12); // newtons along the spring: stiffness times elongation
//! # Ok::<(), lissom::error::InvalidInput>(())
//! ```

#[doc(hidden)]
pub mod chart;
mod colliding_parts;
#[doc(hidden)]
pub mod constraint;
mod differentiable;
mod dynamics;
mod elastic;
mod energy;
mod facts;
mod forward;
mod in_contact;
mod in_time;
mod invalid_shape;
mod passing;
pub mod pendulum;
mod refinable;
#[doc(hidden)]
pub mod rotation_vectors;
mod smooth;
pub mod springs;
mod tied;

#[doc(hidden)]
pub use colliding_parts::CollidingParts;
pub use differentiable::Differentiable;
pub use dynamics::Dynamics;
pub(crate) use dynamics::forward_dynamics;
pub use elastic::{Elastic, Sprung};
pub use energy::Energy;
pub use facts::Facts;
pub use forward::{ForwardScratch, SingularMass, Tree};
pub(crate) use in_contact::REACHED;
pub use in_contact::{ContactText, FrictionTreatment, InContact, InImpact, Overlap, Reached, Softened};
pub use in_time::{Excitation, InTime};
#[doc(hidden)]
pub use invalid_shape::at_least;
pub use invalid_shape::{Constraint, InvalidShape, Radius};
pub use passing::{EnergySnapshot, GainCheck, Impact, STEPS_OF_AN_IMPACT, Separation};
#[doc(hidden)]
pub use passing::{have_missed, have_tunnelled, may_miss};
pub use refinable::{MissingStrain, Refinable, RigidStretch};
pub use smooth::{Autonomous, Smooth, Untied};
pub use tied::{OneSided, Switch, Tied};

/// A section of a rod.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SectionPlace {
    /// Index of the segment, counted through all rods.
    pub segment: usize,
    /// Position as a fraction of the segment's length.
    pub x: f64,
}

/// Maps the twist of a section, (angular; linear), to its momentum per length. Also used for derivatives with
/// respect to the entries of such a matrix.
pub type InertiaMatrix = [[f64; 6]; 6];

/// The traits that equilibria, vibrations and constraints need; implemented for every type that has them.
pub trait Static: Dynamics + InTime + Sprung + Tied + OneSided + InContact {}

impl<M: Dynamics + InTime + Sprung + Tied + OneSided + InContact> Static for M {}

/// A model with all computations: motions, also to a requested accuracy, their derivatives, equilibria and vibrations. Implemented
/// for every type that has these traits.
///
/// A model of one's own implements [`Dynamics`] and [`Elastic`], and either [`Autonomous`] and [`Smooth`] by one empty line each, or the
/// traits that these provide.
pub trait Model: Static + Excitation + InImpact + Differentiable + Refinable {}

impl<M: Static + Excitation + InImpact + Differentiable + Refinable> Model for M {}
