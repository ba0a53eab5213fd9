//! Base motions prescribed by a function of the caller: its values are checked whenever it is
//! asked, its derivatives found or verified.

use std::sync::atomic::{AtomicUsize, Ordering};

use crate::derivatives::{Derivatives, REACH, derivatives, size};
use crate::error::{Interrupted, Number};
use crate::lie::QUATERNION_TOLERANCE;
use crate::signal::Function;
use crate::signal::Motion;

/// Derivatives that a function gives are held against differences at the first time of every run, and at every so
/// many times.
const TIMES_BETWEEN_CHECKS: usize = 16;

/// Relative difference between derivatives that are given and those by differences, beside the error of these, that
/// is none.
const AGREEMENT: f64 = 1e-3;

/// Estimates of an error are no bounds: so many times.
const TIMES_ERROR: f64 = 10.0;

/// "Shortly before" and "after", in seconds.
const BESIDE: f64 = 0.25 * REACH;

/// Numbers of a quaternion.
const QUATERNION: usize = 4;

/// A function of time and its derivatives. A function of quaternions may return any sign.
#[derive(Debug)]
pub(crate) struct Prescribed<const N: usize> {
    function: Function<N>,
    /// How often it was asked.
    asked: AtomicUsize,
}

impl<const N: usize> Clone for Prescribed<N> {
    /// A copy is for another run.
    fn clone(&self) -> Self {
        Self::new(self.function.clone())
    }
}

impl<const N: usize> Prescribed<N> {
    pub(crate) fn new(function: Function<N>) -> Self {
        Self { function, asked: AtomicUsize::new(0) }
    }

    /// The value and its first two derivatives. Fails where the function does, and where what it returns is no motion.
    pub(crate) fn motion(&self, t: f64) -> Result<Motion<N>, Interrupted> {
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
        let found = derivatives(t, here, |t| function.value(t).map(|value| same_side(here, value)))?;
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

    /// Given derivatives must be those of the values. Where an acceleration jumps it is that of one side: the times
    /// shortly before and after must contradict, too.
    fn check_derivatives(&self, given: &Motion<N>, t: f64) -> Result<(), Interrupted> {
        let Some(found) = self.contradiction(given, t)? else { return Ok(()) };
        for t in [t - BESIDE, t + BESIDE] {
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

    /// What differences of the values say against the given derivatives; nothing where they find none.
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

/// Of quaternions, which stand for the same rotation with either sign, the one that is nearer to the first; other
/// values as they are.
fn same_side<const N: usize>(first: [f64; N], value: [f64; N]) -> [f64; N] {
    if N == QUATERNION { nearer(first, value) } else { value }
}

/// The one of a vector and its negative that is nearer to another one.
pub(crate) fn nearer<const N: usize>(to: [f64; N], vector: [f64; N]) -> [f64; N] {
    let product: f64 = to.iter().zip(&vector).map(|(a, b)| a * b).sum();
    if product < 0.0 { vector.map(|x| -x) } else { vector }
}
