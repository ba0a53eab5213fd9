//! Sizes of vectors relative to the tolerances.

/// `value / scale`, with 0 / 0 = 0 (a component that stays 0 with an absolute tolerance of 0).
pub(crate) fn scaled(value: f64, scale: f64) -> f64 {
    if value == 0.0 { 0.0 } else { value / scale }
}

/// Root mean square of `values[i] / scale[i]`.
pub(crate) fn scaled_norm(values: &[f64], scale: &[f64]) -> f64 {
    let sum: f64 = values.iter().zip(scale).map(|(&value, &scale)| scaled(value, scale).powi(2)).sum();
    sum.sqrt() / (values.len() as f64).sqrt()
}

/// True if all entries are finite. Avoids a branch per entry: 0 times infinity or NaN is NaN.
pub(crate) fn all_finite(values: &[f64]) -> bool {
    values.iter().map(|value| value * 0.0).sum::<f64>() == 0.0
}
