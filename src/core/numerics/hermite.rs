//! Hermite interpolation over a step of length `h` from the values at its ends; x runs from 0 to 1.

/// Cubic polynomial with given values and derivatives at the ends.
pub fn cubic(x: f64, h: f64, value: [f64; 2], derivative: [f64; 2]) -> f64 {
    let y = 1.0 - x;
    y * y * ((1.0 + 2.0 * x) * value[0] + x * h * derivative[0])
        + x * x * ((1.0 + 2.0 * y) * value[1] - y * h * derivative[1])
}

/// The same polynomial with its first two derivatives.
pub(crate) fn cubic_motion(x: f64, h: f64, value: [f64; 2], derivative: [f64; 2]) -> [f64; 3] {
    let secant = (value[1] - value[0]) / h;
    let rate = derivative[0] * (1.0 - x) * (1.0 - 3.0 * x)
        + derivative[1] * x * (3.0 * x - 2.0)
        + secant * 6.0 * x * (1.0 - x);
    let bend = derivative[0] * (6.0 * x - 4.0) + derivative[1] * (6.0 * x - 2.0) + secant * (6.0 - 12.0 * x);
    [cubic(x, h, value, derivative), rate, bend / h]
}

/// Values of the cubic polynomials of several coordinates.
pub(crate) fn cubics(x: f64, h: f64, ends: [&[f64]; 2], rates: [&[f64]; 2], out: &mut [f64]) {
    for (i, out) in out.iter_mut().enumerate() {
        *out = cubic(x, h, ends.map(|end| end[i]), rates.map(|rate| rate[i]));
    }
}

/// Values of the cubic polynomial at the middle of the step.
pub fn middle(h: f64, [from, to]: [&[f64]; 2], [leaving, coming]: [&[f64]; 2], out: &mut Vec<f64>) {
    out.clear();
    let ends = from.iter().zip(to).zip(leaving.iter().zip(coming));
    out.extend(ends.map(|((a, b), (u, v))| 0.5 * (a + b) + 0.125 * h * (u - v)));
}

/// Quintic polynomial through displacements, velocities and accelerations at both ends of a step.
#[derive(Clone, Copy, Debug)]
pub struct Quintic {
    h: f64,
    /// Weights, in the displacement and its first two derivatives with respect to x, of the displacement at
    /// the end (the weight at the start is 1 minus that), of both velocities and of both accelerations.
    weights: [[f64; 5]; 3],
}

impl Quintic {
    /// Evaluates the weights at x.
    pub fn at(x: f64, h: f64) -> Self {
        let (x2, x3) = (x * x, x * x * x);
        let weights = [
            [
                x3 * (10.0 - 15.0 * x + 6.0 * x2),
                x - x3 * (6.0 - 8.0 * x + 3.0 * x2),
                -x3 * (4.0 - 7.0 * x + 3.0 * x2),
                0.5 * x2 * (1.0 - 3.0 * x + 3.0 * x2 - x3),
                0.5 * x3 * (1.0 - 2.0 * x + x2),
            ],
            [
                x2 * (30.0 - 60.0 * x + 30.0 * x2),
                1.0 - x2 * (18.0 - 32.0 * x + 15.0 * x2),
                -x2 * (12.0 - 28.0 * x + 15.0 * x2),
                0.5 * x * (2.0 - 9.0 * x + 12.0 * x2 - 5.0 * x3),
                0.5 * x2 * (3.0 - 8.0 * x + 5.0 * x2),
            ],
            [
                x * (60.0 - 180.0 * x + 120.0 * x2),
                -x * (36.0 - 96.0 * x + 60.0 * x2),
                -x * (24.0 - 84.0 * x + 60.0 * x2),
                0.5 * (2.0 - 18.0 * x + 36.0 * x2 - 20.0 * x3),
                0.5 * x * (6.0 - 24.0 * x + 20.0 * x2),
            ],
        ];
        Self { h, weights }
    }

    /// Displacement, velocity and acceleration of one coordinate, given these at the start and at the end.
    pub fn motion(&self, start: [f64; 3], end: [f64; 3]) -> [f64; 3] {
        let Self { h, weights } = self;
        let change = end[0] - start[0];
        let [q, v, a] = weights.map(|w| {
            w[0] * change + h * (w[1] * start[1] + w[2] * end[1] + h * (w[3] * start[2] + w[4] * end[2]))
        });
        [start[0] + q, v / h, a / (h * h)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cubic_polynomials_are_interpolated_exactly() {
        let (f, df) = (|x: f64| x * x * x - 2.0 * x + 1.0, |x: f64| 3.0 * x * x - 2.0);
        let (start, h) = (0.5, 2.0);
        for x in [0.0, 0.3, 0.5, 0.9, 1.0] {
            let found = cubic(x, h, [f(start), f(start + h)], [df(start), df(start + h)]);
            assert!((found - f(start + x * h)).abs() < 1e-14, "{x}");
            let [value, rate, bend] =
                cubic_motion(x, h, [f(start), f(start + h)], [df(start), df(start + h)]);
            assert!(value == found && (rate - df(start + x * h)).abs() < 1e-13, "{x}");
            assert!((bend - 6.0 * (start + x * h)).abs() < 1e-13, "{x}");
        }
    }

    #[test]
    fn motions_of_degree_five_are_interpolated_exactly() {
        let motion = |t: f64| {
            [
                t.powi(5) - 2.0 * t.powi(3) + t + 3.0,
                5.0 * t.powi(4) - 6.0 * t.powi(2) + 1.0,
                20.0 * t.powi(3) - 12.0 * t,
            ]
        };
        let (start, h) = (-0.4, 1.7);
        for x in [0.0, 0.2, 0.5, 0.7, 1.0] {
            let found = Quintic::at(x, h).motion(motion(start), motion(start + h));
            for (found, expected) in found.into_iter().zip(motion(start + x * h)) {
                assert!((found - expected).abs() < 1e-13, "{x}: {found} {expected}");
            }
        }
    }
}
