//! The gradient of a number with respect to what the inertia of sections depends on.

use crate::model::InertiaMatrix;

/// How the inertia of sections changes with a parameter.
#[derive(Clone, Debug)]
pub struct OfInertia {
    /// Number of the parameter.
    pub parameter: usize,
    /// Numbers of the places where it changes, and the derivative of the inertia matrix per length.
    pub at: Vec<(usize, InertiaMatrix)>,
}

/// Parameters that the inertia of sections depends on: one pass over the run serves all of them.
///
/// The forces are linear in the inertia, so that the derivatives of the power with respect to it are added up over the run, and meet
/// the parameters at its end.
#[derive(Clone, Debug)]
pub struct Sections {
    of: Vec<OfInertia>,
    by_inertia: Vec<InertiaMatrix>,
}

impl Sections {
    /// For a model with so many [places](crate::model::Model::section_places).
    ///
    /// # Panics
    /// If a parameter acts at others.
    pub fn new(of: Vec<OfInertia>, places: usize) -> Self {
        let is_known = |of: &OfInertia| of.at.iter().all(|&(place, _)| place < places);
        assert!(of.iter().all(is_known), "there are {places} places");
        let wanted = if of.is_empty() { 0 } else { places };
        Self { of, by_inertia: vec![[[0.0; 6]; 6]; wanted] }
    }

    /// Where the derivatives of the power are added up, if a parameter asks for them.
    pub(super) fn wanted(&mut self) -> Option<&mut [InertiaMatrix]> {
        if self.of.is_empty() { None } else { Some(&mut self.by_inertia) }
    }

    /// Adds what has been summed up to the derivatives with respect to the parameters.
    pub(super) fn add_to(&self, gradient: &mut [f64]) {
        for OfInertia { parameter, at } in &self.of {
            gradient[*parameter] +=
                at.iter().map(|(place, change)| product(&self.by_inertia[*place], change)).sum::<f64>();
        }
    }
}

/// The sum of the products of the entries.
fn product(a: &InertiaMatrix, b: &InertiaMatrix) -> f64 {
    a.iter().flatten().zip(b.iter().flatten()).map(|(a, b)| a * b).sum()
}
