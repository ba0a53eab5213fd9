//! Elasticity and springs of a model, for equilibria and vibrations.

use crate::linalg::Matrix;
use crate::springs::Springs;

/// The elasticity of a model, and its springs to the world.
pub trait Elastic {
    /// The part of `tau` at rest without loads: elastic forces, `K q` for a rod without supports.
    fn elastic_forces(&mut self, q: &[f64], tau: &mut [f64]);

    /// The derivative of [`Self::elastic_forces`], symmetric.
    fn elastic_tangent(&mut self, q: &[f64], tangent: &mut Matrix);

    /// Number of forces of the springs to the world.
    fn springs(&self) -> usize {
        0
    }

    /// Springs in a shape, with their forces there. Costs several evaluations of the forces per spring; not
    /// for step loops.
    fn linearise_springs(&mut self, _q: &[f64], _springs: &mut Springs) {}

    /// Replaces the springs' forces, in forces and tangents at rest for any shape, by these values; `None`
    /// undoes that.
    fn hold_springs(&mut self, _forces: Option<&[f64]>) {}

    /// Large changes of the coordinates, all > 0, to compare coordinates of different units.
    fn typical_coordinates(&self, sizes: &mut [f64]) {
        sizes.fill(1.0);
    }
}
