//! Derivatives of forces with respect to parameters of a model.

use super::{Dynamics, InertiaMatrix};

/// A model whose runs can be differentiated by its parameters.
pub trait Differentiable: Dynamics {
    /// Adds the derivatives of the power `rates . tau` with respect to the inertia matrices per length (of a twist in the
    /// section's axes, (angular; linear)) at each of the
    /// [`section_places`](super::Facts::section_places). Allocates.
    fn add_power_by_inertia(
        &mut self,
        q: &[f64],
        qd: &[f64],
        qdd: &[f64],
        rates: &[f64],
        by_inertia: &mut [InertiaMatrix],
    );

    /// Adds the derivatives of the power `rates . tau` with respect to the length of each of the
    /// [`free_lengths`](super::Facts::free_lengths) segments. Allocates.
    fn add_power_by_length(
        &mut self,
        q: &[f64],
        qd: &[f64],
        qdd: &[f64],
        rates: &[f64],
        by_length: &mut [f64],
    );
}
