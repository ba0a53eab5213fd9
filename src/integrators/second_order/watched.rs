//! Equations whose solution can be stopped within a step.

use super::SecondOrderSystem;
use crate::error::Interrupted;
use crate::model::Facts;
use crate::numerics::linalg::Matrix;

/// Evaluations between two questions whether to stop. Ordinary steps take fewer, so that they ask nothing; a step in thousands of parts asks
/// many times a second.
const EVALUATIONS: u32 = 64;

/// Equations of motion that ask `watch` from time to time whether to stop.
pub(crate) struct Watched<'a, S: ?Sized> {
    system: &'a mut S,
    watch: &'a mut dyn FnMut() -> Result<(), Interrupted>,
    evaluations: u32,
}

impl<'a, S: ?Sized> Watched<'a, S> {
    pub(crate) fn new(system: &'a mut S, watch: &'a mut dyn FnMut() -> Result<(), Interrupted>) -> Self {
        Self { system, watch, evaluations: 0 }
    }
}

impl<S: SecondOrderSystem + ?Sized> SecondOrderSystem for Watched<'_, S> {
    type Model = S::Model;

    #[inline]
    fn facts(&self) -> &Facts {
        self.system.facts()
    }

    #[inline]
    fn residual(
        &mut self,
        t: f64,
        q: &[f64],
        v: &[f64],
        a: &[f64],
        residual: &mut [f64],
    ) -> Result<(), Interrupted> {
        self.evaluations += 1;
        if self.evaluations == EVALUATIONS {
            self.evaluations = 0;
            (self.watch)()?;
        }
        self.system.residual(t, q, v, a, residual)
    }

    #[inline]
    fn tangent(
        &mut self,
        t: f64,
        q: &[f64],
        v: &[f64],
        a: &[f64],
        weights: [f64; 3],
        tangent: &mut Matrix,
    ) -> Result<(), Interrupted> {
        self.system.tangent(t, q, v, a, weights, tangent)
    }

    #[inline]
    fn model(&mut self) -> Option<&mut S::Model> {
        self.system.model()
    }
}
