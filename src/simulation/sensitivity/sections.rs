//! Gradient of a function of a run with respect to parameters of the inertia of sections.

use crate::model::InertiaMatrix;

/// Derivative of the inertia of sections with respect to a parameter.
#[derive(Clone, Debug)]
pub struct OfInertia {
    /// Index of the parameter.
    pub parameter: usize,
    /// Indices of the affected sections, with the derivatives of their inertia matrices per length.
    pub at: Vec<(usize, InertiaMatrix)>,
}

/// Parameters of the inertia of sections. One pass over the run serves all of them.
///
/// Forces are linear in the inertia. Therefore the derivatives of the power with respect to the inertia are
/// accumulated over the run and multiplied with the parameters' derivatives at its end.
#[derive(Clone, Debug)]
pub struct Sections {
    of: Vec<OfInertia>,
    by_inertia: Vec<InertiaMatrix>,
}

impl Sections {
    /// For a model with this number of [sections](crate::model::Facts::section_places).
    ///
    /// # Panics
    /// If a parameter affects other sections.
    pub fn new(of: Vec<OfInertia>, places: usize) -> Self {
        let is_known = |of: &OfInertia| of.at.iter().all(|&(place, _)| place < places);
        assert!(of.iter().all(is_known), "there are {places} places");
        let wanted = if of.is_empty() { 0 } else { places };
        Self { of, by_inertia: vec![[[0.0; 6]; 6]; wanted] }
    }

    /// Accumulator for the derivatives of the power, if any parameter needs it.
    pub(super) fn wanted(&mut self) -> Option<&mut [InertiaMatrix]> {
        if self.of.is_empty() { None } else { Some(&mut self.by_inertia) }
    }

    /// Adds the accumulated derivatives to those with respect to the parameters.
    pub(super) fn add_to(&self, gradient: &mut [f64]) {
        for OfInertia { parameter, at } in &self.of {
            gradient[*parameter] +=
                at.iter().map(|(place, change)| product(&self.by_inertia[*place], change)).sum::<f64>();
        }
    }
}

/// Sum of the products of entries.
fn product(a: &InertiaMatrix, b: &InertiaMatrix) -> f64 {
    a.iter().flatten().zip(b.iter().flatten()).map(|(a, b)| a * b).sum()
}
