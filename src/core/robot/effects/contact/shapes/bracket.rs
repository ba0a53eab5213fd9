//! Newton's method within a bracket.

/// Brackets shorter than this fraction of the interval count as one place.
const SAME_PLACE: f64 = 1e-13;

/// Newton's increments of less than this fraction leave an error of their square.
const LAST_INCREMENT: f64 = 1e-8;

/// More steps than bisection alone takes to [`SAME_PLACE`].
const MOST_STEPS: usize = 50;

/// Zero on [0, 1] of a function that is negative at 0 and positive at 1, from a first guess. `function` returns value and derivative. If
/// Newton's method leaves the bracket, the bracket is halved.
#[inline(always)]
pub(crate) fn root(mut x: f64, function: impl Fn(f64) -> (f64, f64)) -> f64 {
    let (mut from, mut to) = (0.0, 1.0);
    for _ in 0..MOST_STEPS {
        let (value, change) = function(x);
        if value < 0.0 {
            from = x;
        } else {
            to = x;
        }
        let next = x - value / change;
        // Rounding may put the last place a little beyond the ends.
        if change > 0.0 && (next - x).abs() <= LAST_INCREMENT {
            return next.clamp(0.0, 1.0);
        }
        x = if change > 0.0 && next > from && next < to { next } else { 0.5 * (from + to) };
        if to - from <= SAME_PLACE {
            break;
        }
    }
    x
}
