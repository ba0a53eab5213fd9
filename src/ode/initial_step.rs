//! Size of the first step, after Hairer, Norsett and Wanner (1993), section II.4, "Starting step size", in a form that
//! does not depend on the unit of time.

use super::System;
use super::norm::scaled_norm;
use super::options::Tolerances;
use crate::error::Interrupted;

/// An explicit Euler step of the first guess changes y by this fraction (ibid., step b)...
const EULER_FRACTION: f64 = 0.01;
/// ...or by one tolerance, if y is smaller than this many tolerances. A change of one tolerance is small.
const SMALLEST_SIZE: f64 = 1.0 / EULER_FRACTION;
/// A derivative that would change y by less than this many tolerances over the whole interval says nothing about the
/// scale of the problem (ibid., step b, for the interval in place of the unit of time).
const NEGLIGIBLE_CHANGE: f64 = 1e-5;
/// First guess without a scale, relative to the interval (ibid., step b).
const DEFAULT_GUESS: f64 = 1e-6;
/// Estimated error of the first step relative to the tolerance (ibid., step e).
const FIRST_ERROR: f64 = 0.01;
/// Largest first step relative to the first guess (ibid., step f).
const LARGEST_GROWTH: f64 = 100.0;

/// Start of an integration.
pub(crate) struct Start<'a> {
    pub(crate) t0: f64,
    pub(crate) t_end: f64,
    pub(crate) direction: f64,
    pub(crate) y0: &'a [f64],
    pub(crate) f0: &'a [f64],
    pub(crate) max_step: f64,
}

/// Chooses the first step for an error estimate of order `error_order`, with one evaluation; never beyond the
/// end.
///
/// Hairer, Norsett and Wanner estimate the derivative of order `error_order + 1` by the larger of the first two, whose units
/// differ. Here it is `size rate^(error_order + 1)`, where `1 / rate` is the time in which y or its derivative
/// changes and `size` the change of y in this time.
pub(crate) fn select<S: System + ?Sized>(
    system: &mut S,
    start: &Start<'_>,
    tolerances: &Tolerances,
    error_order: f64,
) -> Result<f64, Interrupted> {
    let interval = (start.t_end - start.t0).abs();
    let scale: Vec<f64> = start
        .y0
        .iter()
        .zip(tolerances.rtol.iter().zip(&tolerances.atol))
        .map(|(y, (rtol, atol))| match atol + y.abs() * rtol {
            // A component that is 0 without an absolute tolerance has no tolerance yet.
            0.0 => f64::INFINITY,
            scale => scale,
        })
        .collect();
    let d0 = scaled_norm(start.y0, &scale).max(SMALLEST_SIZE);
    let d1 = scaled_norm(start.f0, &scale);
    let guess = if d1 * interval > NEGLIGIBLE_CHANGE {
        EULER_FRACTION * d0 / d1
    } else if interval.is_finite() {
        DEFAULT_GUESS * interval
    } else {
        DEFAULT_GUESS // in the unit of time: nothing else is known
    };
    let guess = guess.min(interval);
    let y1: Vec<f64> = start.y0.iter().zip(start.f0).map(|(y, f)| y + guess * start.direction * f).collect();
    let mut difference = vec![0.0; y1.len()];
    system.rhs(start.t0 + guess * start.direction, &y1, &mut difference)?;
    for (f1, f0) in difference.iter_mut().zip(start.f0) {
        *f1 -= f0;
    }
    let d2 = scaled_norm(&difference, &scale) / guess;
    // Of the derivative, but not faster than a vibration of the size of y; `min` and `max` ignore NaN.
    let rate = (d2 / d1).min((d2 / d0).sqrt()).max(d1 / d0);
    let size = (d2 / (rate * rate)).max(d1 / rate);
    let second_guess =
        if rate > 0.0 { (FIRST_ERROR / size).powf(1.0 / (error_order + 1.0)) / rate } else { guess };
    Ok((LARGEST_GROWTH * guess).min(second_guess).min(interval).min(start.max_step))
}
