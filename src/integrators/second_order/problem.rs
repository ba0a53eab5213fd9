//! Validation of an interval, an initial state and a step size.

use crate::error::{Checker, InvalidInput, Number};

/// Rejects invalid intervals, initial states and step sizes.
pub(crate) fn check_start(
    n: usize,
    t_span: (f64, f64),
    q0: &[f64],
    v0: &[f64],
    dt: f64,
) -> Result<(), InvalidInput> {
    let mut checker = Checker::new();
    check_problem(n, t_span, q0, v0, dt, &mut checker);
    checker.finish()
}

pub(crate) fn check_problem(
    n: usize,
    (t0, t_end): (f64, f64),
    q0: &[f64],
    v0: &[f64],
    dt: f64,
    checker: &mut Checker,
) {
    checker.require(t0.is_finite(), "t_span[0]", t0, "a finite number");
    if checker.require(t_end.is_finite(), "t_span[1]", t_end, "a finite number") && t0.is_finite() {
        let expected = format!("at least t_span[0] = {}: the methods go forward in time", Number(t0));
        checker.require(t_end >= t0, "t_span[1]", Number(t_end), &expected);
    }
    for (values, place) in [(q0, "q0"), (v0, "v0")] {
        checker.length(values, n, place);
        checker.finite(values, place);
    }
    let is_visible = t_end == t0 || t0 + dt > t0 && t_end - dt < t_end;
    if checker.positive(dt, "dt", "in units of time") && t0.is_finite() && t_end.is_finite() {
        checker.require(is_visible, "dt", Number(dt), "a step that rounding of the time does not swallow");
    }
}
