//! Derivative of the generalised forces with respect to a parameter of the model.

use crate::error::Interrupted;
use crate::model::Model;
use crate::numerics::linalg::{Matrix, dot, norm_inf};

/// Relative rounding error of sums of compiled models, for some hundred operations.
const ROUNDING: f64 = 1e-13;

/// Row, column and value of an entry of a matrix.
type Entry = (usize, usize, f64);

/// Entries that multiply q, v and a, and the constant part.
type Affine = ([Vec<Entry>; 3], Vec<f64>);

/// Derivative of `tau(q, v, a)` with respect to a parameter: a weighted sum of the forces of models that
/// differ in the parameter, or the coefficients of this sum if it is affine in the state.
#[derive(Debug)]
pub struct ForceDerivative<M: ?Sized> {
    terms: Vec<(Box<M>, f64)>,
    /// Coefficients, if the derivative is affine in the state.
    affine: Option<Affine>,
    tau: Vec<f64>,
    sum: Vec<f64>,
}

impl<M: Model + ?Sized> ForceDerivative<M> {
    /// Derivative from models of `n` coordinates and their weights; no models if no force depends on the
    /// parameter. Coefficients are precomputed only if the models do not depend on time or, if `is_steered`,
    /// on inputs, and if their forces act in all states.
    pub fn new(terms: Vec<(Box<M>, f64)>, n: usize, is_steered: bool) -> Result<Self, Interrupted> {
        let zeros = vec![0.0; n];
        let mut derivative = Self { affine: None, tau: zeros.clone(), sum: zeros.clone(), terms };
        // One-sided forces may vanish in the sampled states and act in others.
        let changes = |model: &M| {
            model.facts().varies_in_time
                || is_steered && model.facts().inputs() > 0
                || model.facts().has_one_sided_forces
        };
        if derivative.terms.iter().any(|(model, _)| changes(model)) || !derivative.may_be_affine(n)? {
            return Ok(derivative);
        }
        let terms = &mut derivative.terms;
        let mut entries = [Vec::new(), Vec::new(), Vec::new()];
        let mut tangent = Matrix::zeros(n, n);
        for (k, entries) in entries.iter_mut().enumerate() {
            let mut weights = [0.0; 3];
            weights[k] = 1.0;
            let (mut sum, mut size) = (Matrix::zeros(n, n), Matrix::zeros(n, n));
            for (model, weight) in terms.iter_mut() {
                model.weighted_tangent(&zeros, &zeros, &zeros, weights, &mut tangent);
                sum += &tangent * *weight;
                size += tangent.abs() * weight.abs();
            }
            for column in 0..n {
                for row in 0..n {
                    let entry = sum[(row, column)];
                    if !entry.is_finite() {
                        return Ok(derivative);
                    }
                    if entry.abs() > ROUNDING * size[(row, column)] {
                        entries.push((row, column, entry));
                    }
                }
            }
        }
        let mut rest = zeros.clone();
        let size = derivative.add_terms(1.0, 0.0, [&zeros; 3].map(Vec::as_slice), &mut rest)?;
        rest.iter_mut().filter(|x| x.abs() <= ROUNDING * size).for_each(|x| *x = 0.0);
        let affine = (entries, rest);
        for probe in [1.0, -0.4, 0.15] {
            let states = some_state(n, probe);
            let state = [0, 1, 2].map(|k| states[k].as_slice());
            let mut wrong = zeros.clone();
            let size = derivative.add_terms(1.0, 0.0, state, &mut wrong)?;
            add_affine(&affine, -1.0, state, &mut wrong);
            let error = norm_inf(&wrong);
            if error.is_nan() || error > ROUNDING * size {
                return Ok(derivative);
            }
        }
        derivative.affine = Some(affine);
        Ok(derivative)
    }

    /// Whether the mean of two opposite states equals the value at rest: rules out most derivatives that are
    /// not affine, before any tangent is evaluated.
    fn may_be_affine(&mut self, n: usize) -> Result<bool, Interrupted> {
        let mut sum = vec![0.0; n];
        let mut size = 0.0;
        for (probe, factor) in [(1.0, 1.0), (-1.0, 1.0), (0.0, -2.0)] {
            let states = some_state(n, probe);
            let state = [0, 1, 2].map(|k| states[k].as_slice());
            size += self.add_terms(factor, 0.0, state, &mut sum)?;
        }
        Ok(norm_inf(&sum) <= ROUNDING * size)
    }

    /// Derivative with respect to a material parameter of one segment: the derivatives of stiffness and
    /// damping, k x k each, for its k coordinates, which start at index `first` of all `n`.
    pub fn of_material(first: usize, [stiffness, damping]: [&Matrix; 2], n: usize) -> Self {
        let entries = |block: &Matrix| -> Vec<Entry> {
            let (rows, columns) = block.shape();
            let places = (0..columns).flat_map(|column| (0..rows).map(move |row| (row, column)));
            let entry = |(row, column)| (first + row, first + column, block[(row, column)]);
            places.map(entry).filter(|entry| entry.2 != 0.0).collect()
        };
        let zeros = vec![0.0; n];
        Self {
            terms: Vec::new(),
            affine: Some(([entries(stiffness), entries(damping), Vec::new()], zeros.clone())),
            tau: zeros.clone(),
            sum: zeros,
        }
    }

    /// Sets the inputs.
    pub(super) fn set_inputs(&mut self, inputs: &[f64]) {
        self.terms.iter_mut().for_each(|(model, _)| model.set_inputs(inputs));
    }

    /// Adds a multiple of the derivative at a time and a state.
    pub(super) fn add(
        &mut self,
        factor: f64,
        t: f64,
        state: [&[f64]; 3],
        to: &mut [f64],
    ) -> Result<(), Interrupted> {
        match &self.affine {
            Some(affine) => add_affine(affine, factor, state, to),
            None => _ = self.add_terms(factor, t, state, to)?,
        }
        Ok(())
    }

    /// Product of the derivative with a vector.
    pub(super) fn along(&mut self, lambda: &[f64], t: f64, state: [&[f64]; 3]) -> Result<f64, Interrupted> {
        if let Some((entries, rest)) = &self.affine {
            let of_state = entries.iter().zip(state).map(|(entries, state)| {
                entries.iter().map(|&(i, j, entry)| lambda[i] * entry * state[j]).sum::<f64>()
            });
            return Ok(dot(lambda, rest) + of_state.sum::<f64>());
        }
        let mut sum = std::mem::take(&mut self.sum);
        sum.fill(0.0);
        let added = self.add_terms(1.0, t, state, &mut sum);
        let product = dot(lambda, &sum);
        self.sum = sum;
        added.map(|_| product)
    }

    /// Adds a multiple of the weighted sum; returns the largest added magnitude.
    fn add_terms(
        &mut self,
        factor: f64,
        t: f64,
        [q, v, a]: [&[f64]; 3],
        to: &mut [f64],
    ) -> Result<f64, Interrupted> {
        let mut size = 0.0;
        for (model, weight) in &mut self.terms {
            model.set_time(t)?;
            model.inverse_dynamics(q, v, a, &mut self.tau);
            size += weight.abs() * norm_inf(&self.tau);
            to.iter_mut().zip(&self.tau).for_each(|(to, tau)| *to += factor * *weight * tau);
        }
        Ok(size)
    }
}

/// Coordinates, velocities and accelerations of this size, without any pattern that a model could have.
fn some_state(n: usize, size: f64) -> [Vec<f64>; 3] {
    [0.3, 1.1, 2.3].map(|shift| (0..n).map(|i| size * (1.7 * (i as f64) + shift).sin()).collect())
}

fn add_affine((entries, rest): &Affine, factor: f64, state: [&[f64]; 3], to: &mut [f64]) {
    to.iter_mut().zip(rest).for_each(|(to, rest)| *to += factor * rest);
    for (entries, state) in entries.iter().zip(state) {
        for &(i, j, entry) in entries {
            to[i] += factor * entry * state[j];
        }
    }
}
