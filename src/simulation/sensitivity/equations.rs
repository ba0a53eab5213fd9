//! The equations of a run, linearised at one state with respect to coordinates, velocities and parameters.

use super::{Failure, Interval, Parameter, Together};
use crate::model::{ForwardScratch, Model};
use crate::numerics::linalg::{Matrix, dot};

/// A state of a run with its tangents.
pub(super) struct Linearised {
    pub(super) t: f64,
    pub(super) q: Vec<f64>,
    pub(super) v: Vec<f64>,
    pub(super) a: Vec<f64>,
    pub(super) stiffness: Matrix,
    pub(super) damping: Matrix,
}

impl Linearised {
    pub(super) fn new(n: usize) -> Self {
        let [stiffness, damping] = [0; 2].map(|_| Matrix::zeros(n, n));
        let [q, v, a] = [0; 3].map(|_| vec![0.0; n]);
        Self { t: 0.0, q, v, a, stiffness, damping }
    }

    /// Sets the state.
    pub(super) fn place(&mut self, t: f64, [q, v, a]: [&[f64]; 3]) {
        self.t = t;
        self.q.copy_from_slice(q);
        self.v.copy_from_slice(v);
        self.a.copy_from_slice(a);
    }

    /// Adds `K^T lambda` and `D^T lambda`.
    pub(super) fn add_transposed(&self, lambda: &[f64], [on_q, on_v]: [&mut [f64]; 2]) {
        for i in 0..lambda.len() {
            on_q[i] += dot(self.stiffness.column(i).as_slice(), lambda);
            on_v[i] += dot(self.damping.column(i).as_slice(), lambda);
        }
    }
}

/// The equations of a run `r(q, v, a, p, t) = 0` with constant inputs.
pub(super) struct Equations<'a, M: ?Sized> {
    model: &'a mut M,
    intervals: &'a [Interval],
    /// Index of the interval whose inputs are set.
    interval: usize,
    /// Derivative of the forces with respect to inputs, if an input of this interval is a parameter.
    of_inputs: Matrix,
    scratch: ForwardScratch,
}

impl<'a, M: Model + ?Sized> Equations<'a, M> {
    pub(super) fn new(model: &'a mut M, intervals: &'a [Interval]) -> Self {
        Self {
            of_inputs: Matrix::zeros(model.facts().n, model.facts().inputs()),
            scratch: ForwardScratch::of(&*model),
            interval: 0,
            model,
            intervals,
        }
    }

    /// Sets the inputs of an interval.
    pub(super) fn hold<F: Model + ?Sized>(&mut self, interval: usize, parameters: &mut [Parameter<F>]) {
        self.interval = interval;
        let Some(Interval { inputs, .. }) = self.intervals.get(interval) else { return };
        self.model.set_inputs(inputs);
        for parameter in parameters {
            if let Parameter::Model(force) = parameter {
                force.set_inputs(inputs);
            }
        }
    }

    /// Solves for the accelerations of a state; fails if there are none.
    pub(super) fn solve(&mut self, at: &mut Linearised, step: usize) -> Result<(), Failure> {
        self.model.set_time(at.t)?;
        let Linearised { q, v, a, .. } = at;
        self.model.forward_dynamics(q, v, a, &mut self.scratch).map_err(|_| Failure::Singular(step))
    }

    /// Residual of the equations at a state.
    pub(super) fn residual(&mut self, at: &Linearised, residual: &mut [f64]) -> Result<(), Failure> {
        self.model.set_time(at.t)?;
        self.model.inverse_dynamics(&at.q, &at.v, &at.a, residual);
        Ok(())
    }

    /// Evaluates the tangents of a state, and their weighted sum.
    pub(super) fn linearise(
        &mut self,
        at: &mut Linearised,
        weights: [f64; 3],
        sum: &mut Matrix,
    ) -> Result<(), Failure> {
        self.model.set_time(at.t)?;
        let Linearised { q, v, a, stiffness, damping, .. } = at;
        self.model.weighted_tangent(q, v, a, [1.0, 0.0, 0.0], stiffness);
        self.model.weighted_tangent(q, v, a, [0.0, 1.0, 0.0], damping);
        self.model.weighted_tangent(q, v, a, weights, sum);
        Ok(())
    }

    /// Evaluates the derivative with respect to inputs, if an input of this interval is a parameter.
    fn differentiate_inputs<F: ?Sized>(&mut self, at: &Linearised, parameters: &[Parameter<F>]) {
        let is_held = |parameter: &Parameter<F>| matches!(parameter, Parameter::Input { interval, .. } if *interval == self.interval);
        if parameters.iter().any(is_held) {
            self.model.input_tangent(&at.q, &at.v, &at.a, &mut self.of_inputs);
        }
    }

    /// `change = -(K dq + D dv + dr/dp)` for all parameters, n x p.
    pub(super) fn change<F: Model + ?Sized>(
        &mut self,
        at: &Linearised,
        [dq, dv]: [&Matrix; 2],
        parameters: &mut [Parameter<F>],
        change: &mut Matrix,
    ) -> Result<(), Failure> {
        change.gemm(-1.0, &at.stiffness, dq, 0.0);
        change.gemm(-1.0, &at.damping, dv, 1.0);
        self.differentiate_inputs(at, parameters);
        let n = at.q.len();
        for (i, parameter) in parameters.iter_mut().enumerate() {
            let column = &mut change.as_mut_slice()[i * n..(i + 1) * n];
            match parameter {
                Parameter::Model(force) => force.add(-1.0, at.t, [&at.q, &at.v, &at.a], column)?,
                Parameter::Input { interval, input } if *interval == self.interval => {
                    column.iter_mut().zip(&self.of_inputs.column(*input)).for_each(|(x, b)| *x -= b);
                }
                Parameter::Input { .. } | Parameter::Start => {}
            }
        }
        Ok(())
    }

    /// Adds `lambda . dr/dp` to the gradient with respect to all parameters, and accumulates shared
    /// derivatives.
    pub(super) fn gather<F: Model + ?Sized>(
        &mut self,
        at: &Linearised,
        lambda: &[f64],
        parameters: &mut [Parameter<F>],
        gradient: &mut [f64],
        together: &mut Together,
    ) -> Result<(), Failure> {
        self.differentiate_inputs(at, parameters);
        let state = [&at.q[..], &at.v, &at.a];
        for (gradient, parameter) in gradient.iter_mut().zip(parameters) {
            *gradient += match parameter {
                Parameter::Model(force) => force.along(lambda, at.t, state)?,
                Parameter::Input { interval, input } if *interval == self.interval => {
                    dot(lambda, self.of_inputs.column(*input).as_slice())
                }
                Parameter::Input { .. } | Parameter::Start => 0.0,
            };
        }
        let [q, v, a] = state;
        if let Some(by_length) = together.lengths.wanted() {
            self.model.set_time(at.t)?;
            self.model.add_power_by_length(q, v, a, lambda, by_length);
        }
        if let Some(by_inertia) = together.sections.wanted() {
            self.model.set_time(at.t)?;
            self.model.add_power_by_inertia(q, v, a, lambda, by_inertia);
        }
        Ok(())
    }
}
