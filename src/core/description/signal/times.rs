//! Times that are meant to be equal.

/// End of the longest step from `t`: the horizon, or the end of the run if both differ only by rounding,
/// because the remaining step would be too short.
pub fn end_of_step(t: f64, t_end: f64, horizon: f64) -> f64 {
    if t_end - horizon <= rounding_of_times(t_end - t, t_end) { t_end } else { horizon }
}

/// Tolerance, near `t`, for times that are meant to be equal, if distinct times are `apart`.
pub fn rounding_of_times(apart: f64, t: f64) -> f64 {
    const PART: f64 = 1e-9;
    const UNITS: f64 = 8.0;
    (PART * apart).max(UNITS * f64::EPSILON * t.abs())
}

/// Whether a time lies between two others, or beyond them by rounding only, as at the last step of a run.
pub fn covers([from, to]: [f64; 2], t: f64) -> bool {
    /// Rounding of a time, relative to the length of the interval.
    const ROUNDING: f64 = 1e-12;
    let margin = if (to - from).is_finite() { ROUNDING * (to - from) } else { 0.0 };
    (from - margin..=to + margin).contains(&t)
}
