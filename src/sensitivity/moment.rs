//! One state of a run, linearised: how its accelerations follow from coordinates, velocities and parameters.

use super::{Course, Failure, Family, Leg, Parameter};
use crate::linalg::{Lu, Matrix, Singular, dot};
use crate::model::{ForwardScratch, Model};

/// The equations of a run at one state, with the inputs that are held there.
pub(super) struct Moment<'a, M: ?Sized> {
    model: &'a mut M,
    course: &'a Course<'a>,
    n: usize,
    /// Number of the leg whose inputs are held.
    leg: usize,
    /// Number of the state, and its accelerations with these inputs.
    step: usize,
    a: Vec<f64>,
    stiffness: Matrix,
    damping: Matrix,
    /// The weighted tangent of the step.
    tangent: Matrix,
    /// The derivative of the forces with respect to inputs, where one of them is a parameter.
    of_inputs: Matrix,
    lu: Lu,
    is_transposed: bool,
    scratch: ForwardScratch,
}

impl<'a, M: Model + ?Sized> Moment<'a, M> {
    /// For the derivatives forward; transposed, for those of the adjoint.
    pub(super) fn new(model: &'a mut M, course: &'a Course<'a>, is_transposed: bool) -> Self {
        let n = model.n();
        let [stiffness, damping, tangent] = [0; 3].map(|_| Matrix::zeros(n, n));
        Self {
            n,
            leg: 0,
            step: 0,
            a: vec![0.0; n],
            stiffness,
            damping,
            tangent,
            of_inputs: Matrix::zeros(n, model.inputs()),
            lu: Lu::new(n),
            is_transposed,
            scratch: ForwardScratch::of(&*model),
            model,
            course,
        }
    }

    /// Sets the inputs of a leg.
    pub(super) fn hold<F: Model + ?Sized>(&mut self, leg: usize, parameters: &mut [Parameter<F>]) {
        self.leg = leg;
        let Some(Leg { inputs, .. }) = self.course.legs.get(leg) else { return };
        self.model.set_inputs(inputs);
        for parameter in parameters {
            if let Parameter::Model(force) = parameter {
                force.set_inputs(inputs);
            }
        }
    }

    /// Linearises a state where the accelerations have been solved for: the start, or that of a leg.
    pub(super) fn begin(&mut self, step: usize) -> Result<(), Failure> {
        self.a.copy_from_slice(self.course.state(step, self.n).1[2]);
        self.linearise(step, [0.0, 0.0, 1.0])
    }

    /// Linearises the end of a step with these weights of its accelerations.
    pub(super) fn end(&mut self, step: usize, weights: [f64; 3]) -> Result<(), Failure> {
        let (t, [q, v, a]) = self.course.state(step, self.n);
        self.a.copy_from_slice(a);
        if self.course.leg_from(step).is_some() {
            // What is recorded there are those of the leg that follows.
            self.model.set_time(t)?;
            self.model
                .forward_dynamics(q, v, &mut self.a, &mut self.scratch)
                .map_err(|_| Failure::Singular(step))?;
        }
        self.linearise(step, weights)
    }

    fn linearise(&mut self, step: usize, weights: [f64; 3]) -> Result<(), Failure> {
        let (t, [q, v, _]) = self.course.state(step, self.n);
        self.step = step;
        self.model.set_time(t)?;
        self.model.weighted_tangent(q, v, &self.a, [1.0, 0.0, 0.0], &mut self.stiffness);
        self.model.weighted_tangent(q, v, &self.a, [0.0, 1.0, 0.0], &mut self.damping);
        self.model.weighted_tangent(q, v, &self.a, weights, &mut self.tangent);
        if self.is_transposed {
            self.tangent.transpose_mut();
        }
        self.lu.factorise(&self.tangent).map_err(|Singular| Failure::Singular(step))
    }

    /// Evaluates the derivative with respect to inputs, where one that is held here is a parameter.
    fn differentiate_inputs<F: ?Sized>(&mut self, parameters: &[Parameter<F>]) {
        let is_held =
            |parameter: &Parameter<F>| matches!(parameter, Parameter::Input { leg, .. } if *leg == self.leg);
        if parameters.iter().any(is_held) {
            let [q, v, _] = self.course.state(self.step, self.n).1;
            self.model.input_tangent(q, v, &self.a, &mut self.of_inputs);
        }
    }

    /// The derivatives of the accelerations `da = -S^-1 (K dq + D dv + dr/dp)` with respect to all parameters, n x p.
    pub(super) fn accelerations<F: Model + ?Sized>(
        &mut self,
        [dq, dv]: [&Matrix; 2],
        parameters: &mut [Parameter<F>],
        da: &mut Matrix,
    ) -> Result<(), Failure> {
        da.gemm(-1.0, &self.stiffness, dq, 0.0);
        da.gemm(-1.0, &self.damping, dv, 1.0);
        self.differentiate_inputs(parameters);
        let (t, [q, v, _]) = self.course.state(self.step, self.n);
        for (i, parameter) in parameters.iter_mut().enumerate() {
            let column = &mut da.as_mut_slice()[i * self.n..(i + 1) * self.n];
            match parameter {
                Parameter::Model(force) => force.add(-1.0, t, [q, v, &self.a], column)?,
                Parameter::Input { leg, input } if *leg == self.leg => {
                    column.iter_mut().zip(&self.of_inputs.column(*input)).for_each(|(x, b)| *x -= b);
                }
                Parameter::Input { .. } | Parameter::Start => {}
            }
            self.lu.solve(column);
        }
        Ok(())
    }

    /// Solves `S^T lambda = lambda` and adds what `lambda` carries to the parameters, coordinates and velocities.
    pub(super) fn back<F: Model + ?Sized>(
        &mut self,
        lambda: &mut [f64],
        parameters: &mut [Parameter<F>],
        gradient: &mut [f64],
        [on_q, on_v]: [&mut [f64]; 2],
    ) -> Result<(), Failure> {
        self.lu.solve(lambda);
        self.differentiate_inputs(parameters);
        let (t, [q, v, _]) = self.course.state(self.step, self.n);
        for (gradient, parameter) in gradient.iter_mut().zip(parameters) {
            *gradient += match parameter {
                Parameter::Model(force) => force.along(lambda, t, [q, v, &self.a])?,
                Parameter::Input { leg, input } if *leg == self.leg => {
                    dot(lambda, self.of_inputs.column(*input).as_slice())
                }
                Parameter::Input { .. } | Parameter::Start => 0.0,
            };
        }
        for i in 0..self.n {
            on_q[i] += dot(self.stiffness.column(i).as_slice(), lambda);
            on_v[i] += dot(self.damping.column(i).as_slice(), lambda);
        }
        Ok(())
    }

    /// Adds to families what a solved `lambda` carries to them.
    pub(super) fn back_in_families<F: Model + ?Sized>(
        &mut self,
        lambda: &[f64],
        families: &mut [Family<F>],
    ) -> Result<(), Failure> {
        let (t, [q, v, _]) = self.course.state(self.step, self.n);
        for Family { terms, gradient } in families {
            let mut powers = vec![0.0; gradient.len()];
            for (model, weight) in terms {
                model.set_time(t)?;
                model.segment_powers(q, v, &self.a, lambda, &mut powers);
                gradient.iter_mut().zip(&powers).for_each(|(sum, power)| *sum += *weight * power);
            }
        }
        Ok(())
    }
}
