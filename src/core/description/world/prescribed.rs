//! Base motions prescribed by a user-defined function. Its values are checked at every call; its derivatives
//! are computed by finite differences or verified.

use std::sync::atomic::{AtomicUsize, Ordering};

use crate::description::derivatives::{
    Derivatives, REACH, TIMES_ERROR, derivatives, derivatives_at_start, size,
};
use crate::description::signal::Function;
use crate::description::signal::Motion;
use crate::error::{Interrupted, Number};
use crate::numerics::lie::QUATERNION_TOLERANCE;

/// User-supplied derivatives are compared with finite differences at the first time of every run, and once
/// per this number of evaluations.
const TIMES_BETWEEN_CHECKS: usize = 16;

/// Tolerated relative difference between user-supplied derivatives and finite differences, beyond the error
/// of the differences.
const AGREEMENT: f64 = 1e-3;

/// Distance of the times shortly before and after, in seconds.
const DIFFERENCE_STEP: f64 = 0.25 * REACH;

/// Number of components of a quaternion.
const QUATERNION: usize = 4;

/// A function of time with its derivatives. Quaternions may have either sign.
#[derive(Debug)]
pub(crate) struct Prescribed<const N: usize> {
    function: Function<N>,
    /// Number of evaluations.
    asked: AtomicUsize,
}

impl<const N: usize> Clone for Prescribed<N> {
    /// A copy starts a new count, because it belongs to another run.
    fn clone(&self) -> Self {
        Self::new(self.function.clone())
    }
}

impl<const N: usize> Prescribed<N> {
    pub(crate) fn new(function: Function<N>) -> Self {
        Self { function, asked: AtomicUsize::new(0) }
    }

    /// Value and first two derivatives; where the second one jumps the mean of both sides, or at the start of a run that of the
    /// later one. Fails if the function fails or returns an invalid motion.
    pub(crate) fn motion(&self, t: f64, is_start: bool) -> Result<Motion<N>, Interrupted> {
        let Function(function) = &self.function;
        if let Some(motion) = function.motion(t)? {
            self.check_finite(motion.as_flattened(), t)?;
            self.check_norm(&motion[0], t)?;
            if self.asked.fetch_add(1, Ordering::Relaxed).is_multiple_of(TIMES_BETWEEN_CHECKS) {
                self.check_derivatives(&motion, t)?;
            }
            return Ok(motion);
        }
        let here = function.value(t)?;
        self.check_finite(&here, t)?;
        self.check_norm(&here, t)?;
        let value = |t: f64| function.value(t).map(|value| same_side(here, value));
        let found =
            if is_start { derivatives_at_start(t, here, value)? } else { derivatives(t, here, value)? };
        if found.are_known {
            return Ok(found.motion(here));
        }
        let (first, second) = (found.first.error, found.second.error);
        let found = format!(
            "a function without derivatives at t = {}: differences leave errors of {first:.1e} in the first and {second:.1e} in \
             the second one",
            Number(t)
        );
        let expected = "a function that is twice differentiable there, and known shortly before and after; or a function that returns \
                        value, velocity and acceleration, a table or a harmonic";
        Err(function.refuse(found, expected))
    }

    fn check_finite(&self, values: &[f64], t: f64) -> Result<(), Interrupted> {
        let Some(&value) = values.iter().find(|x| !x.is_finite()) else { return Ok(()) };
        let found = format!("{} at t = {}", Number(value), Number(t));
        Err(self.function.0.refuse(found, "finite numbers"))
    }

    fn check_norm(&self, value: &[f64; N], t: f64) -> Result<(), Interrupted> {
        if N != QUATERNION {
            return Ok(());
        }
        let norm = value.iter().map(|x| x * x).sum::<f64>().sqrt();
        if (norm - 1.0).abs() <= QUATERNION_TOLERANCE {
            return Ok(());
        }
        let found = format!("a quaternion of norm {} at t = {}", Number(norm), Number(t));
        Err(self.function.0.refuse(found, "a quaternion (w, x, y, z) of norm 1"))
    }

    /// Rejects derivatives that contradict the values. At a jump of the acceleration the derivative of one
    /// side is correct; therefore the times shortly before and after must contradict too.
    fn check_derivatives(&self, given: &Motion<N>, t: f64) -> Result<(), Interrupted> {
        let Some(found) = self.contradiction(given, t)? else { return Ok(()) };
        for t in [t - DIFFERENCE_STEP, t + DIFFERENCE_STEP] {
            let beside = self.function.0.motion(t)?;
            let contradicts = match beside {
                Some(given) => self.contradiction(&given, t)?.is_some(),
                None => true,
            };
            if !contradicts {
                return Ok(());
            }
        }
        Err(self.function.0.refuse(found, "the derivatives of the value"))
    }

    /// Describes the contradiction between given derivatives and finite differences; `None` if there is none
    /// or the differences do not converge.
    fn contradiction(&self, given: &Motion<N>, t: f64) -> Result<Option<String>, Interrupted> {
        let Function(function) = &self.function;
        let value = |t: f64| {
            let value = match function.motion(t)? {
                Some([value, ..]) => value,
                None => function.value(t)?,
            };
            Ok(same_side(given[0], value))
        };
        let found: Derivatives<N> = derivatives(t, given[0], value)?;
        if !found.are_known {
            return Ok(None);
        }
        let estimates = [("a velocity", found.first), ("an acceleration", found.second)];
        for (k, (name, estimate)) in estimates.into_iter().enumerate() {
            let given = &given[k + 1];
            let apart: [f64; N] = std::array::from_fn(|i| given[i] - estimate.value[i]);
            let scale = found.scales()[k].max(size(given));
            if size(&apart) > AGREEMENT * scale + TIMES_ERROR * estimate.error {
                return Ok(Some(format!(
                    "a value and {name} that contradict each other at t = {}: that differs by {:.1e} from differences of \
                     the values, {:.1e}",
                    Number(t),
                    size(&apart),
                    size(&estimate.value)
                )));
            }
        }
        Ok(None)
    }
}

/// For quaternions, where both signs stand for the same rotation, the sign closer to `first`; other values
/// unchanged.
fn same_side<const N: usize>(first: [f64; N], value: [f64; N]) -> [f64; N] {
    if N == QUATERNION { nearer(first, value) } else { value }
}

/// `vector` or its negative, whichever is closer to `to`.
pub(crate) fn nearer<const N: usize>(to: [f64; N], vector: [f64; N]) -> [f64; N] {
    let product: f64 = to.iter().zip(&vector).map(|(a, b)| a * b).sum();
    if product < 0.0 { vector.map(|x| -x) } else { vector }
}
