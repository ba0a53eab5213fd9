//! Storage of a state's numbers: vectors, or arrays of fixed size for plain systems of few coordinates.

use std::fmt::Debug;
use std::ops::{Deref, DerefMut};

/// One number for each unknown of a system. Steppers are generic over the storage.
pub(super) trait Numbers: Clone + Debug + DerefMut<Target = [f64]> {
    /// Whether steps of such a system have [nothing to handle](crate::model::Facts::watched) beside coordinates.
    const IS_PLAIN: bool;

    fn zeros(n: usize) -> Self;

    fn of(values: &[f64]) -> Self {
        let mut numbers = Self::zeros(values.len());
        numbers.copy_from_slice(values);
        numbers
    }

    /// Makes room for multipliers of constraints.
    fn lengthen(&mut self, n: usize);
}

impl Numbers for Vec<f64> {
    const IS_PLAIN: bool = false;

    fn zeros(n: usize) -> Self {
        vec![0.0; n]
    }

    fn lengthen(&mut self, n: usize) {
        self.resize(n, 0.0);
    }
}

/// Numbers of a plain system of `N` coordinates: loops are unrolled, and the memory of a step is contiguous.
#[derive(Clone, Copy, Debug)]
pub(super) struct FixedSize<const N: usize>([f64; N]);

impl<const N: usize> Deref for FixedSize<N> {
    type Target = [f64];

    #[inline(always)]
    fn deref(&self) -> &[f64] {
        &self.0
    }
}

impl<const N: usize> DerefMut for FixedSize<N> {
    #[inline(always)]
    fn deref_mut(&mut self) -> &mut [f64] {
        &mut self.0
    }
}

impl<const N: usize> Numbers for FixedSize<N> {
    const IS_PLAIN: bool = true;

    fn zeros(n: usize) -> Self {
        assert_eq!(n, N, "a system of so many coordinates");
        Self([0.0; N])
    }

    fn lengthen(&mut self, n: usize) {
        assert_eq!(n, N, "plain systems have no constraints");
    }
}
