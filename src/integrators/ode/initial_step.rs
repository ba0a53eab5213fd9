//! Size of the first step (Hairer, Norsett and Wanner 1993, section II.4, "Starting step size").

use super::FirstOrderSystem;
use super::norm::scaled_norm;
use super::options::Tolerances;
use crate::error::Interrupted;

/// Scaled norms of y and f below this value say nothing about the scale of the problem (ibid., step b).
const NEGLIGIBLE_NORM: f64 = 1e-5;
/// First guess without a scale (ibid., step b).
const DEFAULT_GUESS: f64 = 1e-6;
/// An explicit Euler step of the first guess changes y by this fraction (ibid., step b).
const EULER_FRACTION: f64 = 0.01;
/// Derivatives below this value count as zero (ibid., step e).
const ZERO_DERIVATIVE: f64 = 1e-15;
/// Step size for zero derivatives, relative to the first guess (ibid., step e).
const ZERO_DERIVATIVE_FACTOR: f64 = 1e-3;
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
/// end. May be NaN if the problem is not finite.
pub(crate) fn select<S: FirstOrderSystem + ?Sized>(
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
        .map(|(y, (rtol, atol))| atol + y.abs() * rtol)
        .collect();
    let d0 = scaled_norm(start.y0, &scale);
    let d1 = scaled_norm(start.f0, &scale);
    let guess =
        if d0 < NEGLIGIBLE_NORM || d1 < NEGLIGIBLE_NORM { DEFAULT_GUESS } else { EULER_FRACTION * d0 / d1 };
    let guess = guess.min(interval);
    let y1: Vec<f64> = start.y0.iter().zip(start.f0).map(|(y, f)| y + guess * start.direction * f).collect();
    let mut difference = vec![0.0; y1.len()];
    system.rhs(start.t0 + guess * start.direction, &y1, &mut difference)?;
    for (f1, f0) in difference.iter_mut().zip(start.f0) {
        *f1 -= f0;
    }
    let d2 = scaled_norm(&difference, &scale) / guess;
    let second_guess = if d1 <= ZERO_DERIVATIVE && d2 <= ZERO_DERIVATIVE {
        DEFAULT_GUESS.max(guess * ZERO_DERIVATIVE_FACTOR)
    } else {
        (EULER_FRACTION / d1.max(d2)).powf(1.0 / (error_order + 1.0))
    };
    Ok((LARGEST_GROWTH * guess).min(second_guess).min(interval).min(start.max_step))
}
