//! Bounds of unknowns.

/// Lower and upper bounds of the unknowns; infinite without a bound, equal for a fixed unknown.
#[derive(Clone, Debug, PartialEq)]
pub struct Bounds {
    /// Lower bounds, not greater than `upper`.
    pub lower: Vec<f64>,
    /// Upper bounds, not less than `lower`.
    pub upper: Vec<f64>,
}

impl Bounds {
    /// Infinite bounds for this number of unknowns.
    pub fn none(unknowns: usize) -> Self {
        Self { lower: vec![f64::NEG_INFINITY; unknowns], upper: vec![f64::INFINITY; unknowns] }
    }

    /// Value of an unknown within its bounds closest to `x`.
    pub fn nearest(&self, unknown: usize, x: f64) -> f64 {
        x.max(self.lower[unknown]).min(self.upper[unknown])
    }

    /// Clips all unknowns to their bounds.
    pub fn clip(&self, x: &mut [f64]) {
        for (i, x) in x.iter_mut().enumerate() {
            *x = self.nearest(i, *x);
        }
    }
}
