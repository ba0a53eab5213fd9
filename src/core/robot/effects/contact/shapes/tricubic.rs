//! Tricubic splines through values on a regular grid in space.
//!
//! The tensor product of natural cubic splines (de Boor 2001, chapter XVII): its second derivatives are continuous. The error of smooth
//! functions falls with the fourth power of the spacing, but close to the border, where second derivatives across it are zero, with the
//! square. Beyond the border it continues linearly.

use super::bernstein::bernstein;
use super::spline::{coefficients_of, weights};
use crate::numerics::lie::{Symmetric, Vector};

/// A spline on a grid with its first value at the origin and the third axis varying fastest.
#[derive(Clone, Debug)]
pub(super) struct Tricubic {
    /// Number of values along each axis, two or more, and their distance, metres.
    pub(super) shape: [usize; 3],
    pub(super) spacing: [f64; 3],
    /// Coefficients of the cubic B-splines: one more at each end of an axis than values.
    coefficients: Vec<f64>,
}

/// Value, gradient and second derivatives at a place.
#[derive(Clone, Copy, Debug)]
pub(super) struct Local {
    pub(super) value: f64,
    pub(super) gradient: Vector<f64>,
    pub(super) bend: Symmetric<f64>,
}

impl Tricubic {
    pub(super) fn new(values: &[f64], shape: [usize; 3], spacing: [f64; 3]) -> Self {
        let mut coefficients = values.to_vec();
        let mut size = shape;
        for axis in 0..3 {
            coefficients = along(&coefficients, size, axis);
            size[axis] += 2;
        }
        Self { shape, spacing, coefficients }
    }

    /// Multiplies all values by a factor.
    pub(super) fn scale(&mut self, factor: f64) {
        self.coefficients.iter_mut().for_each(|coefficient| *coefficient *= factor);
    }

    /// Length of the grid along an axis.
    pub(super) fn length(&self, axis: usize) -> f64 {
        (self.shape[axis] - 1) as f64 * self.spacing[axis]
    }

    /// Whether a place is within the border.
    pub(super) fn contains(&self, place: Vector<f64>) -> bool {
        place.to_array().into_iter().enumerate().all(|(axis, x)| (0.0..=self.length(axis)).contains(&x))
    }

    /// Coefficients along the third axis of a row on which a cell depends.
    fn row(&self, [i, j, k]: [usize; 3]) -> [f64; 4] {
        let [_, columns, depth] = self.shape.map(|n| n + 2);
        let first = (i * columns + j) * depth + k;
        std::array::from_fn(|n| self.coefficients[first + n])
    }

    pub(super) fn at(&self, place: Vector<f64>) -> Local {
        let [(i, along_x), (j, along_y), (k, along_z)] = {
            let place = place.to_array();
            [0, 1, 2].map(|axis| {
                let x = place[axis] / self.spacing[axis];
                let cell = (x.floor().max(0.0) as usize).min(self.shape[axis] - 2);
                (cell, weights(x - cell as f64))
            })
        };
        // Derivatives by how often they are along x, y and z.
        let [mut value, mut x, mut y, mut z] = [0.0; 4];
        let [mut xx, mut yy, mut zz, mut xy, mut xz, mut yz] = [0.0; 6];
        for a in 0..4 {
            let [mut sum, mut of_y, mut of_z, mut of_yy, mut of_zz, mut of_yz] = [0.0; 6];
            for b in 0..4 {
                let row = self.row([i + a, j + b, k]);
                let [along, slope, bend] =
                    along_z.map(|weights| row.iter().zip(weights).map(|(c, weight)| c * weight).sum::<f64>());
                sum += along * along_y[0][b];
                of_y += along * along_y[1][b];
                of_yy += along * along_y[2][b];
                of_z += slope * along_y[0][b];
                of_yz += slope * along_y[1][b];
                of_zz += bend * along_y[0][b];
            }
            value += sum * along_x[0][a];
            x += sum * along_x[1][a];
            xx += sum * along_x[2][a];
            y += of_y * along_x[0][a];
            z += of_z * along_x[0][a];
            xy += of_y * along_x[1][a];
            xz += of_z * along_x[1][a];
            yy += of_yy * along_x[0][a];
            yz += of_yz * along_x[0][a];
            zz += of_zz * along_x[0][a];
        }
        let [p, q, r] = self.spacing.map(f64::recip);
        Local {
            value,
            gradient: Vector::new(x * p, y * q, z * r),
            bend: Symmetric {
                xx: xx * p * p,
                yy: yy * q * q,
                zz: zz * r * r,
                xy: xy * p * q,
                xz: xz * p * r,
                yz: yz * q * r,
            },
        }
    }

    /// Bernstein coefficients of a cell, between the least and the greatest of which its values lie.
    pub(super) fn bernstein_of_cell(&self, [i, j, k]: [usize; 3]) -> [[[f64; 4]; 4]; 4] {
        let along_z: [[[f64; 4]; 4]; 4] =
            std::array::from_fn(|a| std::array::from_fn(|b| bernstein(self.row([i + a, j + b, k]))));
        let along_y: [[[f64; 4]; 4]; 4] = std::array::from_fn(|a| {
            let lines: [[f64; 4]; 4] =
                std::array::from_fn(|c| bernstein(std::array::from_fn(|b| along_z[a][b][c])));
            std::array::from_fn(|b| std::array::from_fn(|c| lines[c][b]))
        });
        let mut whole = [[[0.0; 4]; 4]; 4];
        for b in 0..4 {
            for c in 0..4 {
                let line = bernstein(std::array::from_fn(|a| along_y[a][b][c]));
                (0..4).for_each(|a| whole[a][b][c] = line[a]);
            }
        }
        whole
    }

    /// Bounds of its slope within the border, and of mixed second and third derivatives, from differences of coefficients.
    pub(super) fn bounds(&self) -> [f64; 3] {
        let size = self.shape.map(|n| n + 2);
        let steps = [size[1] * size[2], size[2], 1];
        let mut slopes = [0.0_f64; 3];
        let [mut mixed, mut triple] = [0.0_f64; 2];
        let c = &self.coefficients;
        for n in 0..c.len() {
            let place = [n / steps[0], n / steps[1] % size[1], n % size[2]];
            let mut rises = [None; 3];
            for axis in 0..3 {
                if place[axis] > 0 {
                    rises[axis] = Some(c[n] - c[n - steps[axis]]);
                    slopes[axis] = slopes[axis].max(rises[axis].map_or(0.0, f64::abs) / self.spacing[axis]);
                }
            }
            for [a, b] in [[0, 1], [0, 2], [1, 2]] {
                if let (Some(rise), Some(_)) = (rises[a], rises[b]) {
                    let before = c[n - steps[b]] - c[n - steps[a] - steps[b]];
                    mixed = mixed.max((rise - before).abs() / (self.spacing[a] * self.spacing[b]));
                }
            }
            if rises.iter().all(Option::is_some) {
                let face = |n: usize| c[n] - c[n - steps[0]] - c[n - steps[1]] + c[n - steps[0] - steps[1]];
                let change = (face(n) - face(n - 1)).abs();
                triple = triple.max(change / self.spacing.iter().product::<f64>());
            }
        }
        [slopes.iter().map(|slope| slope * slope).sum::<f64>().sqrt(), mixed, triple]
    }
}

/// Coefficients of splines along an axis of values.
fn along(values: &[f64], size: [usize; 3], axis: usize) -> Vec<f64> {
    let (inner, number) = (size[axis + 1..].iter().product::<usize>(), size[axis]);
    let outer: usize = size[..axis].iter().product();
    let mut found = vec![0.0; outer * (number + 2) * inner];
    let mut line = vec![0.0; number];
    for o in 0..outer {
        for i in 0..inner {
            for (n, value) in line.iter_mut().enumerate() {
                *value = values[(o * number + n) * inner + i];
            }
            for (n, coefficient) in coefficients_of(&line).into_iter().enumerate() {
                found[(o * (number + 2) + n) * inner + i] = coefficient;
            }
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sampled(f: impl Fn(f64, f64, f64) -> f64, shape: [usize; 3], spacing: [f64; 3]) -> Tricubic {
        let [_, columns, depth] = shape;
        let numbers = 0..shape.iter().product::<usize>();
        let place = |n: usize| [n / (columns * depth), n / depth % columns, n % depth];
        let values = numbers.map(|n| {
            let [i, j, k] = place(n);
            f(i as f64 * spacing[0], j as f64 * spacing[1], k as f64 * spacing[2])
        });
        Tricubic::new(&values.collect::<Vec<_>>(), shape, spacing)
    }

    /// Values are met, and derivatives are those of the values, also beyond the border.
    #[test]
    fn values_are_met_and_change_as_they_say() {
        let (shape, spacing) = ([5, 4, 6], [0.1, 0.15, 0.2]);
        let f = |x: f64, y: f64, z: f64| (7.0 * x).sin() * (5.0 * y).cos() + z * z - 0.3 * x * z;
        let spline = sampled(f, shape, spacing);
        for [i, j, k] in [[0, 0, 0], [4, 3, 5], [2, 1, 3], [3, 0, 4]] {
            let place = Vector::new(i as f64 * 0.1, j as f64 * 0.15, k as f64 * 0.2);
            assert!((spline.at(place).value - f(place.x, place.y, place.z)).abs() < 1e-14);
        }
        let h = 1e-5;
        for place in [(0.13, 0.22, 0.47), (0.38, 0.01, 0.9), (-0.2, 0.31, 0.1), (0.6, 0.9, -0.3)] {
            let place = Vector::new(place.0, place.1, place.2);
            let Local { gradient, bend, .. } = spline.at(place);
            for axis in [Vector::new(1.0, 0.0, 0.0), Vector::new(0.0, 1.0, 0.0), Vector::new(0.0, 0.0, 1.0)] {
                let [ahead, behind] = [h, -h].map(|h| spline.at(place + axis * h));
                assert!(((ahead.value - behind.value) / (2.0 * h) - gradient.dot(axis)).abs() < 1e-8);
                let change = (ahead.gradient - behind.gradient) * (0.5 / h) - bend.times(axis);
                assert!(change.dot(change).sqrt() < 1e-7, "{place:?} {change:?}");
            }
        }
    }

    /// Within a cell, values lie between the coefficients; over the grid, slopes are within their bound.
    #[test]
    fn bounds_hold() {
        let f = |x: f64, y: f64, z: f64| (9.0 * x * y).sin() + (8.0 * z - 5.0 * x).cos();
        let spline = sampled(f, [4, 5, 4], [0.2, 0.1, 0.15]);
        let [steepest, mixed, _] = spline.bounds();
        for n in 0..4000 {
            let share = |k: u32| f64::from(n).mul_add(0.618_034 * f64::from(k), 0.1 * f64::from(k)).fract();
            let place = [share(1) * 0.6, share(2) * 0.4, share(3) * 0.45];
            let cell = [place[0] / 0.2, place[1] / 0.1, place[2] / 0.15].map(|x| x as usize);
            let Local { value, gradient, bend } = spline.at(Vector::from(place));
            let coefficients = spline.bernstein_of_cell(cell);
            let all = || coefficients.iter().flatten().flatten();
            let low = all().fold(f64::INFINITY, |low, &c| low.min(c));
            let high = all().fold(f64::NEG_INFINITY, |high, &c| high.max(c));
            assert!((low - 1e-12..=high + 1e-12).contains(&value), "{low} {value} {high}");
            assert!(gradient.dot(gradient).sqrt() <= steepest);
            assert!([bend.xy, bend.xz, bend.yz].iter().all(|x| x.abs() <= mixed));
        }
    }
}
