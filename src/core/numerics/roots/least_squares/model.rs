//! The quadratic model of `|R|^2 / 2` at an iterate, and its steps within bounds.

use super::bounds::Bounds;
use super::region::Spectrum;
use crate::numerics::linalg::{Matrix, dot, norm, norm_inf};

/// Increment of forward differences: the square root of the rounding unit, for unknowns of order one.
pub(super) const INCREMENT: f64 = 1.490_116_119_384_765_6e-8;

/// Error of a second derivative by differences with this increment, relative to the derivative and to the
/// rounding errors of R and its Jacobian; includes a safety factor.
const ERROR_OF_CURVATURE: f64 = 10.0 * INCREMENT;

/// `|R + J d|^2 / 2 + d S d / 2`, with or without the curvature S of R.
pub(super) struct Model<'a> {
    jacobian: &'a Matrix,
    curvature: Option<&'a Matrix>,
    gradient: Vec<f64>,
    /// Error of the curvature.
    error: f64,
}

/// A step, and the decrease of `|R|^2 / 2` that the model predicts.
pub(super) struct Step {
    pub(super) x: Vec<f64>,
    pub(super) predicted: f64,
}

impl<'a> Model<'a> {
    pub(super) fn new(jacobian: &'a Matrix, residual: &[f64], curvature: Option<&'a Matrix>) -> Self {
        let gradient = jacobian.column_iter().map(|column| dot(column.as_slice(), residual)).collect();
        let error = curvature.map_or(0.0, |curvature| {
            let terms = jacobian.row_iter().zip(residual).map(|(row, r)| row.amax() * r.abs()).sum::<f64>();
            ERROR_OF_CURVATURE * (terms + norm_inf(curvature.as_slice()))
        });
        Self { jacobian, curvature, gradient, error }
    }

    pub(super) fn gradient(&self) -> &[f64] {
        &self.gradient
    }

    /// Product of the model's matrix with a step.
    fn product(&self, step: &[f64]) -> Vec<f64> {
        let mut image = vec![0.0; self.jacobian.nrows()];
        for (column, &d) in self.jacobian.column_iter().zip(step).filter(|(_, d)| **d != 0.0) {
            image.iter_mut().zip(column.iter()).for_each(|(image, entry)| *image += entry * d);
        }
        let mut product: Vec<f64> =
            self.jacobian.column_iter().map(|column| dot(column.as_slice(), &image)).collect();
        if let Some(curvature) = self.curvature {
            for (product, column) in product.iter_mut().zip(curvature.column_iter()) {
                *product += dot(column.as_slice(), step);
            }
        }
        product
    }

    fn with_predicted_reduction(&self, step: Vec<f64>) -> Step {
        let predicted = -dot(&self.gradient, &step) - 0.5 * dot(&step, &self.product(&step));
        Step { x: step, predicted }
    }

    /// Eigenvectors of the submatrix of these unknowns.
    fn spectrum(&self, free: &[usize]) -> Option<Spectrum> {
        let own = self.jacobian.select_columns(free);
        let Some(curvature) = self.curvature else { return Spectrum::of_squares(&own) };
        let mut matrix = own.tr_mul(&own);
        for (j, &column) in free.iter().enumerate() {
            for (i, &row) in free.iter().enumerate() {
                matrix[(i, j)] += curvature[(row, column)];
            }
        }
        Spectrum::new(&matrix, self.error)
    }

    /// The best step of about this length that keeps x within its bounds, among the candidates of a search
    /// for the active bounds.
    pub(super) fn step(&self, x: &[f64], bounds: &Bounds, radius: f64) -> Step {
        let is_free = |&i: &usize| {
            let push = self.gradient[i];
            let [down, up] = [x[i] > bounds.lower[i], x[i] < bounds.upper[i]];
            (down && (up || push >= 0.0)) || (up && push <= 0.0)
        };
        let free: Vec<usize> = (0..x.len()).filter(is_free).collect();
        let mut best = Step { x: vec![0.0; x.len()], predicted: 0.0 };
        let mut keep = |step: Vec<f64>| {
            let step = self.with_predicted_reduction(step);
            if step.predicted > best.predicted {
                best = step;
            }
        };
        for first in self.steps(&free, &vec![0.0; x.len()], radius) {
            let is_cut = self.bind(first, free.clone(), x, bounds, radius, &mut keep);
            if is_cut {
                keep(self.downhill(&free, x, bounds, radius));
                // Steps clipped component by component leave narrow curved valleys; shortened steps do not.
                if let Some(step) = self.shortened(free.clone(), x, bounds, radius) {
                    keep(step);
                }
            }
        }
        best
    }

    /// Steps of the unknowns `free`, given the steps of the others.
    fn steps(&self, free: &[usize], others: &[f64], radius: f64) -> Vec<Vec<f64>> {
        let spectrum = if free.is_empty() { None } else { self.spectrum(free) };
        let Some(spectrum) = spectrum else { return Vec::new() };
        let product = self.product(others);
        let gradient: Vec<f64> = free.iter().map(|&i| self.gradient[i] + product[i]).collect();
        let all = |own: Vec<f64>| {
            let mut step = others.to_vec();
            free.iter().zip(own).for_each(|(&i, d)| step[i] = d);
            step
        };
        spectrum.steps(&gradient, radius).into_iter().map(all).collect()
    }

    /// Stops unknowns at their bounds and recomputes the step of the others until no further bound is
    /// reached. Returns whether any bound was reached.
    fn bind(
        &self,
        mut step: Vec<f64>,
        mut free: Vec<usize>,
        x: &[f64],
        bounds: &Bounds,
        radius: f64,
        keep: &mut impl FnMut(Vec<f64>),
    ) -> bool {
        let mut is_cut = false;
        loop {
            let stop = |i: usize| bounds.nearest(i, x[i] + step[i]) - x[i];
            let (bound, rest): (Vec<usize>, Vec<usize>) = free
                .iter()
                .partition(|&&i| x[i] + step[i] < bounds.lower[i] || x[i] + step[i] > bounds.upper[i]);
            let stopped: Vec<f64> = (0..x.len()).map(stop).collect();
            keep(stopped.clone());
            if bound.is_empty() {
                return is_cut;
            }
            is_cut = true;
            let mut others = vec![0.0; x.len()];
            (0..x.len()).filter(|i| !rest.contains(i)).for_each(|i| others[i] = stopped[i]);
            let Some(next) = self.steps(&rest, &others, radius).into_iter().next() else { return true };
            (step, free) = (next, rest);
        }
    }

    /// The step shortened to the bounds; unknowns at bounds that the step would leave are fixed.
    fn shortened(&self, mut free: Vec<usize>, x: &[f64], bounds: &Bounds, radius: f64) -> Option<Vec<f64>> {
        loop {
            let step = self.steps(&free, &vec![0.0; x.len()], radius).into_iter().next()?;
            let stays = |&i: &usize| bounds.nearest(i, x[i] + step[i]) != x[i] || step[i] == 0.0;
            let rest: Vec<usize> = free.iter().copied().filter(stays).collect();
            if rest.len() == free.len() {
                let room = |&i: &usize| {
                    let way = bounds.nearest(i, x[i] + step[i]) - x[i];
                    if way == step[i] { 1.0 } else { way / step[i] }
                };
                let part = free.iter().map(room).fold(1.0, f64::min);
                return Some(step.iter().map(|d| part * d).collect());
            }
            free = rest;
        }
    }

    /// Step along the negative gradient to the minimum of the model or to the bounds: always a descent step.
    fn downhill(&self, free: &[usize], x: &[f64], bounds: &Bounds, radius: f64) -> Vec<f64> {
        let size = norm(&self.gradient);
        let mut step = vec![0.0; x.len()];
        for &i in free {
            step[i] = bounds.nearest(i, x[i] - self.gradient[i] * (radius / size)) - x[i];
        }
        let bending = dot(&step, &self.product(&step));
        let slope = -dot(&self.gradient, &step);
        let part = if bending > slope { slope / bending } else { 1.0 };
        step.iter_mut().for_each(|d| *d *= part);
        step
    }
}
