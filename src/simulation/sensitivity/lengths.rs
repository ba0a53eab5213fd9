//! Gradient of a function of a run with respect to lengths of segments.

/// Parameters that are lengths of segments. One pass over the run serves all of them.
#[derive(Clone, Debug)]
pub struct Lengths {
    /// Indices of parameter and segment.
    of: Vec<[usize; 2]>,
    by_length: Vec<f64>,
}

impl Lengths {
    /// Parameters with their segments, for a model with this number of [free
    /// lengths](crate::model::Facts::free_lengths).
    ///
    /// # Panics
    /// If the length of a segment is not free.
    pub fn new(of: Vec<[usize; 2]>, free: usize) -> Self {
        assert!(of.iter().all(|&[_, segment]| segment < free), "{free} lengths are free");
        let wanted = if of.is_empty() { 0 } else { free };
        Self { of, by_length: vec![0.0; wanted] }
    }

    /// Accumulator for the derivatives of the power, if any parameter needs it.
    pub(super) fn wanted(&mut self) -> Option<&mut [f64]> {
        if self.of.is_empty() { None } else { Some(&mut self.by_length) }
    }

    /// Adds the accumulated derivatives to those with respect to the parameters.
    pub(super) fn add_to(&self, gradient: &mut [f64]) {
        for &[parameter, segment] in &self.of {
            gradient[parameter] += self.by_length[segment];
        }
    }
}
