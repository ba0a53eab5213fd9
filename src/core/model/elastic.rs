//! Elasticity and springs of a model, for equilibria and vibrations.

use super::Dynamics;
use crate::model::springs::{LengthTendons, Springs};
use crate::numerics::linalg::Matrix;

/// The elasticity of a model.
pub trait Elastic: Dynamics {
    /// The part of `tau` at rest without loads: elastic forces, `K q` for a rod without supports.
    fn elastic_forces(&mut self, q: &[f64], tau: &mut [f64]);

    /// The derivative of [`Self::elastic_forces`], symmetric.
    fn elastic_tangent(&mut self, q: &[f64], tangent: &mut Matrix);

    /// Generalised forces, n x 3, of the weight and the loads if all of them acted along the first, second or third axis of the
    /// base: their magnitudes in a shape for any directions. `constraint_loads` gets the magnitudes of the constraint wrenches of
    /// joints about the origin of the base, projected on their coordinates: a joint's own force is a small difference of such products.
    fn turned_loads(&mut self, q: &[f64], forces: &mut Matrix, constraint_loads: &mut [f64]);

    /// Sizes of the coordinates in a shape, all > 0: a step of this size turns something by one radian; if a coordinate only shifts
    /// parts, it is a strain of one, or the extent of these parts. Parts that a coordinate does not move have no influence.
    /// Rotation vectors are measured as turns. Allocates; not for step loops.
    fn sizes(&mut self, q: &[f64], sizes: &mut [f64]);
}

/// Springs of a model to the world, and its tendons of a commanded length. Statics treats their forces as separate unknowns.
pub trait Sprung: Elastic {
    /// Springs in a shape, with their forces there. Costs several evaluations of the forces per spring; not
    /// for step loops.
    fn linearise_springs(&mut self, q: &[f64], springs: &mut Springs);

    /// Replaces the springs' forces, in forces and tangents at rest for any shape, by these values; `None`
    /// undoes that.
    fn hold_springs(&mut self, forces: Option<&[f64]>);

    /// These tendons in a shape.
    fn linearise_length_tendons(&mut self, q: &[f64], length_tendons: &mut LengthTendons);

    /// Replaces their tensions, in forces and tangents at rest for any shape, by these values, also by negative ones; `None`
    /// undoes that.
    fn hold_length_tendons(&mut self, tensions: Option<&[f64]>);
}
