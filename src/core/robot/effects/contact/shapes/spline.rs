//! Cubic splines on a grid by their B-spline coefficients.

/// Bounds of slopes and second derivatives of a spline, from its coefficients.
pub(super) fn bounds(coefficients: &[f64], [rows, columns]: [usize; 2], [dx, dy]: [f64; 2]) -> [f64; 2] {
    let c = |i: usize, j: usize| coefficients[i * columns + j];
    let mut most = [0.0_f64; 5];
    let mut note = |k: usize, value: f64| most[k] = most[k].max(value.abs());
    for i in 0..rows {
        for j in 0..columns {
            if i > 0 {
                note(0, (c(i, j) - c(i - 1, j)) / dx);
            }
            if j > 0 {
                note(1, (c(i, j) - c(i, j - 1)) / dy);
            }
            if i > 1 {
                note(2, (c(i, j) - 2.0 * c(i - 1, j) + c(i - 2, j)) / (dx * dx));
            }
            if j > 1 {
                note(3, (c(i, j) - 2.0 * c(i, j - 1) + c(i, j - 2)) / (dy * dy));
            }
            if i > 0 && j > 0 {
                note(4, (c(i, j) - c(i - 1, j) - c(i, j - 1) + c(i - 1, j - 1)) / (dx * dy));
            }
        }
    }
    [most[0].hypot(most[1]), most[2].max(most[3]) + most[4]]
}

/// Coefficients of the natural cubic spline through values, with one more at each end.
pub(super) fn coefficients_of(values: &[f64]) -> Vec<f64> {
    let n = values.len();
    let mut own = vec![0.0; n + 2];
    own[1..=n].copy_from_slice(values);
    // In the interior `c[i-1] + 4 c[i] + c[i+1] = 6 h[i]`; at the ends the second derivative is zero, and `c
    // = h`.
    let mut factors = vec![0.0; n];
    for i in 1..n.saturating_sub(1) {
        let pivot = 4.0 - factors[i - 1];
        factors[i] = 1.0 / pivot;
        own[i + 1] = (6.0 * values[i] - own[i]) / pivot;
    }
    for i in (1..n.saturating_sub(1)).rev() {
        own[i + 1] -= factors[i] * own[i + 2];
    }
    own[0] = 2.0 * own[1] - own[2];
    own[n + 1] = 2.0 * own[n] - own[n - 1];
    own
}

/// Weights of four cubic B-splines at a fraction of a cell, and their derivatives; linear beyond the cell.
pub(super) fn weights(x: f64) -> [[f64; 4]; 3] {
    let t = x.clamp(0.0, 1.0);
    let s = 1.0 - t;
    let mut values = [
        s * s * s / 6.0,
        2.0 / 3.0 - t * t + 0.5 * t * t * t,
        2.0 / 3.0 - s * s + 0.5 * s * s * s,
        t * t * t / 6.0,
    ];
    let slopes = [-0.5 * s * s, -2.0 * t + 1.5 * t * t, 2.0 * s - 1.5 * s * s, 0.5 * t * t];
    if x == t {
        return [values, slopes, [s, 3.0 * t - 2.0, 3.0 * s - 2.0, t]];
    }
    for (value, slope) in values.iter_mut().zip(slopes) {
        *value += (x - t) * slope;
    }
    [values, slopes, [0.0; 4]]
}
