//! State at the end of a step as a function of its accelerations.

use super::numbers::Numbers;
use crate::numerics::linalg::with_size;

/// A state that is affine in its accelerations: `q = q_base + weights[0] a`, `v = v_base + weights[1] a`.
#[derive(Clone, Debug)]
pub(super) struct Trial<V> {
    pub(super) t: f64,
    /// Derivatives of q, v and the accelerations in the forces with respect to a; the last one is 1 except in quasi-static motion.
    pub(super) weights: [f64; 3],
    pub(super) q_base: V,
    pub(super) v_base: V,
    pub(super) q: V,
    pub(super) v: V,
    pub(super) a: V,
    /// Accelerations in the forces, if they are scaled, followed by multipliers of constraints.
    scaled: V,
}

impl<V: Numbers> Trial<V> {
    pub(super) fn new(n: usize) -> Self {
        Self {
            t: 0.0,
            weights: [0.0; 3],
            q_base: V::zeros(n),
            v_base: V::zeros(n),
            q: V::zeros(n),
            v: V::zeros(n),
            a: V::zeros(n),
            scaled: V::zeros(n),
        }
    }

    /// Extends the memory to this number of unknowns.
    pub(super) fn lengthen(&mut self, unknowns: usize) {
        self.a.lengthen(unknowns);
        self.scaled.lengthen(unknowns);
    }

    /// The accelerations in the forces, followed by multipliers.
    #[inline(always)]
    pub(super) fn accelerations(&self) -> &[f64] {
        if V::IS_PLAIN || self.weights[2] == 1.0 { &self.a } else { &self.scaled }
    }

    /// Sets the accelerations.
    pub(super) fn set(&mut self, a: &[f64]) {
        self.a.copy_from_slice(a);
        self.update();
    }

    /// Subtracts `da` from the accelerations.
    pub(super) fn subtract(&mut self, da: &[f64]) {
        with_size!(subtract(self.a.len(), &mut self.a, da));
        self.update();
    }

    fn update(&mut self) {
        let Self { weights: [of_q, of_v, of_a], q_base, v_base, q, v, a, scaled, .. } = self;
        with_size!(combine(q.len(), q, q_base, *of_q, a));
        with_size!(combine(v.len(), v, v_base, *of_v, a));
        if !V::IS_PLAIN && *of_a != 1.0 {
            scaled.copy_from_slice(a);
            scaled[..q.len()].iter_mut().for_each(|a| *a *= *of_a);
        }
    }
}

/// `x <- x - y`.
#[inline(always)]
fn subtract(n: usize, x: &mut [f64], y: &[f64]) {
    let (x, y) = (&mut x[..n], &y[..n]);
    for i in 0..n {
        x[i] -= y[i];
    }
}

/// `x <- base + weight a`.
#[inline(always)]
fn combine(n: usize, x: &mut [f64], base: &[f64], weight: f64, a: &[f64]) {
    let (x, base, a) = (&mut x[..n], &base[..n], &a[..n]);
    for i in 0..n {
        x[i] = base[i] + weight * a[i];
    }
}
