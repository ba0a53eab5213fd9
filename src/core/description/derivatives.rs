//! First and second derivatives of a function of time by finite differences with an error estimate.
//!
//! Central differences over decreasing distances are extrapolated to distance zero (Richardson). The result
//! is the entry of the tableau that agrees best with its neighbours; the disagreement is the error estimate
//! (Ridders 1982, Adv. Eng. Software 4(2); Press et al., Numerical Recipes, section 5.7). Slow functions take
//! nine values. A function that oscillates or has a kink within the largest distance takes more and shorter
//! distances; a function with a kink or a jump at the point itself never converges. Where only its second derivative jumps, beside
//! that point, differences of one side do.

use crate::description::signal::Motion;
use crate::error::Interrupted;

/// Largest distance in seconds. Functions are also evaluated this far before and after a run.
pub(crate) const REACH: f64 = 4e-3;

/// Ratio of successive distances: the golden ratio. No period divides all distances, so that no oscillation
/// looks constant.
const RATIO: f64 = 1.618_033_988_749_895;

/// Maximum number of distances: down to 0.26 microseconds.
const MAX_LEVELS: usize = 20;

/// Minimum number of distances before a result is accepted: two or three may agree by chance.
const FEWEST_LEVELS: usize = 4;

/// Entries per row of the tableau. Longer rows would include distances over which a fast function is not
/// smooth.
const COLUMNS: usize = 8;

/// Error at which the search stops (`TARGET_ERROR`), and the largest one that is accepted after all distances
/// (`LARGEST_ERROR`), relative to the size of the derivative nearby ([`Estimate::scale`]).
const TARGET_ERROR: f64 = 1e-8;
const LARGEST_ERROR: f64 = 1e-3;

/// Safety factor for error estimates, which are not bounds.
pub(crate) const TIMES_ERROR: f64 = 10.0;

/// Assumed error of function values and of their times, in units of rounding.
const UNITS_OF_ROUNDING: f64 = 8.0;

/// The power of the distance in errors of central differences and in those of one side.
const CENTRAL_POWER: i32 = 2;
const ONE_SIDED: i32 = 1;

/// Errors below this size, in any units, come from underflow, such as in the tails of pulses.
const UNDERFLOW: f64 = 1e-100;

/// A derivative with the estimated error of its components.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Estimate<const N: usize> {
    pub(crate) value: [f64; N],
    pub(crate) error: f64,
    /// Size of the derivative at this time and nearby: the largest difference quotient over the distances
    /// that this estimate uses and all larger ones. A motion may start with derivatives of zero, which are
    /// no measure of their errors. Quotients over smaller distances are left out, because those across a
    /// kink or a jump grow without bound.
    scale: f64,
}

/// First and second derivatives.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Derivatives<const N: usize> {
    pub(crate) first: Estimate<N>,
    pub(crate) second: Estimate<N>,
    /// Whether both errors are small enough.
    pub(crate) are_known: bool,
}

impl<const N: usize> Derivatives<N> {
    /// Value `here` and both derivatives of the function.
    pub(crate) fn motion(&self, here: [f64; N]) -> Motion<N> {
        [here, self.first.value, self.second.value]
    }

    /// Scales for relative errors of the first and of the second derivative. The scale of the first
    /// derivative includes its change over the largest distance.
    pub(crate) fn scales(&self) -> [f64; 2] {
        [self.first.scale + REACH * self.second.scale, self.second.scale]
    }
}

/// Derivatives at `t` of a function with the value `here`. A distance with non-finite values is discarded:
/// shorter distances may stay within the function's domain. Next to a jump of the second derivative, nearer than several of the
/// distances, those of the side that the jump is not on.
pub(crate) fn derivatives<const N: usize>(
    t: f64,
    here: [f64; N],
    mut value: impl FnMut(f64) -> Result<[f64; N], Interrupted>,
) -> Result<Derivatives<N>, Interrupted> {
    // The distance between representable times, so that rounding of `t + wanted` adds no error.
    let found = extrapolated(t, here, REACH, CENTRAL_POWER, |wanted| {
        let h = (t + wanted) - t;
        let (before, after) = (value(t - h)?, value(t + h)?);
        let first = std::array::from_fn(|i| (after[i] - before[i]) / (2.0 * h));
        let second = std::array::from_fn(|i| ((after[i] - here[i]) - (here[i] - before[i])) / (h * h));
        Ok((h, [first, second]))
    })?;
    if found.are_known || found.first.error > LARGEST_ERROR * found.scales()[0] {
        return Ok(found);
    }
    for side in [1.0, -1.0] {
        let of_side = of_one_side(t, here, side, &mut value)?;
        if of_side.are_known && agree(&found, &of_side) {
            return Ok(of_side);
        }
    }
    Ok(found)
}

/// The same at the start of a motion: where the second derivative jumps there, that after the jump. What was before does not
/// belong to the motion.
pub(crate) fn derivatives_at_start<const N: usize>(
    t: f64,
    here: [f64; N],
    mut value: impl FnMut(f64) -> Result<[f64; N], Interrupted>,
) -> Result<Derivatives<N>, Interrupted> {
    let found = derivatives(t, here, &mut value)?;
    if !found.are_known {
        return Ok(found);
    }
    let after = of_one_side(t, here, 1.0, &mut value)?;
    let apart: [f64; N] = std::array::from_fn(|i| after.second.value[i] - found.second.value[i]);
    let errors = TIMES_ERROR * (found.second.error + after.second.error);
    let jumps = size(&apart) > errors.max(LARGEST_ERROR * after.scales()[1]);
    Ok(if after.are_known && agree(&found, &after) && jumps { after } else { found })
}

/// Derivatives from values on one side alone: at later times (1) or at earlier ones (-1).
fn of_one_side<const N: usize>(
    t: f64,
    here: [f64; N],
    side: f64,
    mut value: impl FnMut(f64) -> Result<[f64; N], Interrupted>,
) -> Result<Derivatives<N>, Interrupted> {
    extrapolated(t, here, 0.5 * REACH, ONE_SIDED, |wanted| {
        let h = 0.5 * ((t + 2.0 * wanted) - t);
        let (near, far) = (value(t + side * h)?, value(t + 2.0 * side * h)?);
        let first = std::array::from_fn(|i| side * (near[i] - here[i]) / h);
        let second = std::array::from_fn(|i| ((far[i] - near[i]) - (near[i] - here[i])) / (h * h));
        Ok((h, [first, second]))
    })
}

/// Whether the first derivative is the same from both sides as from one: at a kink no side is right.
fn agree<const N: usize>(found: &Derivatives<N>, of_side: &Derivatives<N>) -> bool {
    let apart: [f64; N] = std::array::from_fn(|i| of_side.first.value[i] - found.first.value[i]);
    size(&apart) <= LARGEST_ERROR * (found.first.scale + REACH * of_side.second.scale)
}

/// Difference quotients over decreasing distances from the largest one, extrapolated to zero. Their errors are polynomials in the
/// distance to this power. `quotients` are those over a distance near the wanted one, which it returns as well.
fn extrapolated<const N: usize>(
    t: f64,
    here: [f64; N],
    largest: f64,
    power: i32,
    mut quotients: impl FnMut(f64) -> Result<(f64, [[f64; N]; 2]), Interrupted>,
) -> Result<Derivatives<N>, Interrupted> {
    let [mut first, mut second] = [0; 2].map(|_| Tableau::new(power));
    let mut wanted = largest;
    for level in 1..=MAX_LEVELS {
        let (h, of_distance) = quotients(wanted)?;
        wanted /= RATIO;
        if !of_distance.as_flattened().iter().all(|x| x.is_finite()) || h <= 0.0 {
            [first, second] = [0; 2].map(|_| Tableau::new(power));
            continue;
        }
        first.add(of_distance[0]);
        second.add(of_distance[1]);
        let found = Derivatives { first: first.best, second: second.best, are_known: true };
        let scales = found.scales();
        let rounding = UNITS_OF_ROUNDING * f64::EPSILON * (size(&here) + t.abs() * scales[0]);
        let floors = [rounding / h, rounding / (h * h)];
        let is_right =
            |k: usize, estimate: &Estimate<N>| estimate.error <= TARGET_ERROR * scales[k] + floors[k];
        if level >= FEWEST_LEVELS && is_right(0, &first.best) && is_right(1, &second.best) {
            return Ok(found);
        }
    }
    let mut found = Derivatives { first: first.best, second: second.best, are_known: false };
    let scales = found.scales();
    let is_accepted = |k: usize, error: f64| error <= LARGEST_ERROR * scales[k] || error <= UNDERFLOW;
    found.are_known = is_accepted(0, found.first.error) && is_accepted(1, found.second.error);
    Ok(found)
}

/// Largest magnitude.
pub(crate) fn size(values: &[f64]) -> f64 {
    values.iter().map(|x| x.abs()).fold(0.0, f64::max)
}

/// Last row of Neville's tableau in a power of the distance, and the best of all its entries.
struct Tableau<const N: usize> {
    /// Ratio of successive distances to that power.
    ratio: f64,
    row: [[f64; N]; COLUMNS],
    rows: usize,
    /// Largest quotient so far.
    largest: f64,
    best: Estimate<N>,
}

impl<const N: usize> Tableau<N> {
    fn new(power: i32) -> Self {
        let nothing = Estimate { value: [f64::NAN; N], error: f64::INFINITY, scale: f64::NAN };
        Self { ratio: RATIO.powi(power), row: [[0.0; N]; COLUMNS], rows: 0, largest: 0.0, best: nothing }
    }

    fn add(&mut self, quotient: [f64; N]) {
        let above = self.row;
        self.row[0] = quotient;
        self.largest = self.largest.max(size(&quotient));
        let mut power = 1.0;
        for j in 1..COLUMNS.min(self.rows + 1) {
            power *= self.ratio;
            let (left, corner) = (self.row[j - 1], above[j - 1]);
            let entry: [f64; N] = std::array::from_fn(|i| left[i] + (left[i] - corner[i]) / (power - 1.0));
            let apart = |other: [f64; N]| size(&std::array::from_fn::<f64, N, _>(|i| entry[i] - other[i]));
            let error = apart(left).max(apart(corner));
            if error < self.best.error {
                self.best = Estimate { value: entry, error, scale: self.largest };
            }
            self.row[j] = entry;
        }
        self.rows += 1;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::cell::Cell;
    use std::f64::consts::TAU;

    fn of(t: f64, f: impl Fn(f64) -> f64) -> (Derivatives<1>, usize) {
        let calls = Cell::new(0);
        let value = |t: f64| {
            calls.set(calls.get() + 1);
            Ok([f(t)])
        };
        (derivatives(t, [f(t)], value).unwrap(), calls.get())
    }

    #[test]
    fn sines_of_every_frequency_have_their_derivatives() {
        for hertz in [0.01, 1.0, 50.0, 250.0, 500.0, 1000.0, 12_345.0, 1e5] {
            let omega = TAU * hertz;
            for t in [0.0, 0.123, 7.7] {
                let (found, calls) = of(t, |t| 0.3 + 1e-3 * (omega * t + 0.4).sin());
                let (sine, cosine) = (omega * t + 0.4).sin_cos();
                let wanted = [1e-3 * omega * cosine, -1e-3 * omega * omega * sine];
                assert!(found.are_known, "{hertz} Hz at {t}: {found:?}");
                assert!(hertz > 10.0 || calls <= 12, "{calls} calls at {hertz} Hz");
                // Rounding of 0.3 in second differences over milliseconds.
                let [first, second] = [found.first, found.second].map(|estimate| estimate.value[0]);
                assert!(
                    (first - wanted[0]).abs() <= 1e-5 * 1e-3 * omega + 1e-10,
                    "{hertz} Hz at {t}: {found:?}"
                );
                assert!(
                    (second - wanted[1]).abs() <= 1e-5 * 1e-3 * omega * omega + 1e-7,
                    "{hertz} Hz at {t}: {found:?}"
                );
                let off = (second - wanted[1]).abs();
                assert!(
                    off <= found.second.error.max(1e-7) * 3.0,
                    "the error is no estimate: {off} {found:?}"
                );
            }
        }
    }

    #[test]
    fn kinks_and_jumps_are_refused_where_they_are_and_passed_by_where_they_are_not() {
        let kink = |t: f64| (t - 0.5).abs();
        let jump = |t: f64| f64::from(t >= 0.5);
        assert!(!of(0.5, kink).0.are_known && !of(0.5, jump).0.are_known);
        assert!(!of(0.5 + 1e-8, kink).0.are_known && !of(0.5 - 1e-8, jump).0.are_known);
        for off in [-0.1, -1e-3, 2e-4, 0.3] {
            let (found, _) = of(0.5 + off, kink);
            assert!(found.are_known && (found.first.value[0] - off.signum()).abs() < 1e-6, "{off} {found:?}");
            assert!(found.second.value[0].abs() < 1e-3, "{off} {found:?}");
        }
    }

    /// A base that starts with an acceleration: the mean of both sides, as for a table.
    #[test]
    fn where_the_acceleration_jumps_it_is_the_mean() {
        let (found, _) = of(0.0, |t| 0.5 * 9.0 * t.max(0.0).powi(2));
        assert!(found.are_known && (found.second.value[0] - 4.5).abs() < 1e-9, "{found:?}");
        assert!(found.first.value[0].abs() < 1e-4, "{found:?}");
    }

    /// At the start of a run what was before does not count.
    #[test]
    fn at_the_start_the_acceleration_is_that_after_a_jump() {
        let smooth_step = |s: f64| s * s * (3.0 - 2.0 * s);
        let at_start = |t: f64, f: &dyn Fn(f64) -> f64| {
            let found = derivatives_at_start(t, [f(t)], |t| Ok([f(t)])).unwrap();
            assert!(found.are_known, "{found:?}");
            [found.first.value[0], found.second.value[0]]
        };
        for at in [0.0, 0.1, 0.25] {
            let [first, second] = at_start(at, &|t| 0.5 * 9.0 * (t - at).max(0.0).powi(2));
            assert!(first.abs() < 1e-6 && (second - 9.0).abs() < 1e-4, "{at}: {first} {second}");
            let [first, second] = at_start(at, &|t| 0.1 * smooth_step(((t - at) / 0.5).clamp(0.0, 1.0)));
            assert!(first.abs() < 1e-6 && (second - 2.4).abs() < 1e-4, "{at}: {first} {second}");
            // From both sides where nothing jumps, bit for bit.
            let sine = |t: f64| (7.0 * t).sin();
            let both = of(at, sine).0;
            assert_eq!(at_start(at, &sine), [both.first.value[0], both.second.value[0]]);
        }
        // A motion that starts with a velocity has no acceleration.
        let kink = |t: f64| [t.max(0.0)];
        assert!(!derivatives_at_start(0.0, kink(0.0), |t| Ok(kink(t))).unwrap().are_known);
    }

    /// Adaptive steps come as near to such a place as they like.
    #[test]
    fn beside_a_jump_of_the_acceleration_it_is_that_of_one_side() {
        let smooth_step = |s: f64| s * s * (3.0 - 2.0 * s);
        for at in [0.0, 0.1, 0.25] {
            let motion = |t: f64| 0.1 * smooth_step(((t - at) / 0.5).clamp(0.0, 1.0));
            for off in [1e-9, 1e-8, 1e-7, 3e-7, 6e-7, 1e-6, 3e-6, 1e-5, 1e-4, 1e-3] {
                for (t, inside) in
                    [(at + off, off), (at - off, 0.0), (at + 0.5 - off, 0.5 - off), (at + 0.5 + off, 0.5)]
                {
                    let (found, _) = of(t, motion);
                    let is_still = inside == 0.0 || inside == 0.5;
                    let s = 2.0 * inside;
                    let velocity = 1.2 * s * (1.0 - s);
                    assert!(found.are_known, "{at} {t}: {found:?}");
                    assert!((found.first.value[0] - velocity).abs() < 1e-5, "{at} {t}: {found:?}");
                    let acceleration = if is_still { 0.0 } else { 0.1 * (6.0 - 12.0 * s) / 0.25 };
                    let [second, jump] = [found.second.value[0], 2.4];
                    // Between the values of both sides if rounding decides on which side the time is.
                    let slack = if off < 1e-6 { jump + 1e-3 } else { 0.02 };
                    assert!((second - acceleration).abs() < slack, "{at} {t}: {second} {acceleration}");
                }
            }
        }
    }

    /// The polynomial of robotics, the cycloid and powers, in other units of time and length.
    #[test]
    fn motions_that_start_from_rest_have_derivatives_of_zero() {
        let quintic = |s: f64| s.powi(3) * (10.0 + s * (-15.0 + 6.0 * s));
        let cycloid = |s: f64| s - (TAU * s).sin() / TAU;
        let starts: [(&str, &dyn Fn(f64) -> f64); 5] = [
            ("quintic", &quintic),
            ("cycloid", &cycloid),
            ("t^3", &|s| s.powi(3)),
            ("t^4", &|s| s.powi(4)),
            ("t^5", &|s| s.powi(5)),
        ];
        for (name, start) in starts {
            for duration in [1e-3, 0.02, 1.0, 60.0, 1000.0, 1e5] {
                for stroke in [1e-6, 1.0, 1e3] {
                    for at in [0.0, 0.7] {
                        let motion = |t: f64| stroke * start(((t - at) / duration).clamp(0.0, 1.0));
                        let (found, _) = of(at, motion);
                        let [first, second] = [found.first, found.second].map(|estimate| estimate.value[0]);
                        let shown = format!("{name} of {stroke} in {duration} s from {at} s: {found:?}");
                        assert!(found.are_known, "{shown}");
                        assert!(first.abs() <= 1e-3 * stroke / duration, "{shown}");
                        assert!(second.abs() <= 1e-2 * stroke / duration / duration, "{shown}");
                    }
                }
            }
        }
        // Motions at rest.
        assert!(of(0.0, |_| 3.0).0.are_known && of(0.0, |_| 0.0).0.are_known);
    }

    /// The largest quotient nearby is no excuse for what never converges.
    #[test]
    fn a_start_at_once_has_no_acceleration() {
        for speed in [1e-9, 1.0, 1e6] {
            assert!(!of(0.0, |t| speed * t.max(0.0)).0.are_known);
            assert!(!of(0.0, |t| speed * t.max(0.0).powf(1.5)).0.are_known);
        }
        assert!(!of(0.0, |t| t.powi(2) + 0.1 * t.max(0.0)).0.are_known);
    }

    #[test]
    fn noise_has_no_derivatives() {
        // Fractional parts of a large multiple, as pseudorandom numbers.
        let noise = |t: f64| 1e-9 * (t * 1e9 * 0.754_877_666).fract();
        assert!(!of(0.3, noise).0.are_known);
    }

    #[test]
    fn values_that_are_unknown_far_away_are_not_needed() {
        let (found, _) = of(1.0, |t| if t > 1.001 { f64::NAN } else { t * t * t });
        assert!(found.are_known && (found.second.value[0] - 6.0).abs() < 1e-4, "{found:?}");
        assert!(!of(1.0, |t| if t > 1.0 { f64::NAN } else { t }).0.are_known);
    }
}
