//! The interface of equilibria and vibrations to a model.

use crate::linalg::Matrix;
use crate::springs::Springs;

/// The elasticity of a model, and its springs to the world.
pub trait Elastic {
    /// The part of `tau` at rest that is there without any load: that of elasticity, `K q` of a rod without supports.
    fn elastic_forces(&mut self, q: &[f64], tau: &mut [f64]);

    /// The derivative of [`Self::elastic_forces`], symmetric.
    fn elastic_tangent(&mut self, q: &[f64], tangent: &mut Matrix);

    /// How many forces its springs to the world have.
    fn springs(&self) -> usize {
        0
    }

    /// Its springs in a shape, with the forces that they have there. Some evaluations of the forces for each; not for
    /// step loops.
    fn linearise_springs(&mut self, _q: &[f64], _springs: &mut Springs) {}

    /// From now on forces and tangents at rest take these for the springs' forces, whatever the shape, until they get
    /// `None`.
    fn hold_springs(&mut self, _forces: Option<&[f64]>) {}

    /// Changes of the coordinates that count as large, all > 0: what makes coordinates of different units comparable.
    fn typical_coordinates(&self, sizes: &mut [f64]) {
        sizes.fill(1.0);
    }
}
