//! Derivatives of runs of the Newmark family.

use super::equations::{Equations, Linearised};
use super::{Failure, Monitor, Parameters, StateDerivatives, Together, Trajectory};
use crate::integrators::newmark::{FIRST_STAGE, Scheme, Step};
use crate::model::{ForwardScratch, Model};
use crate::numerics::linalg::{Lu, Matrix, Singular};

/// Weights of a state whose accelerations follow from forward dynamics: the start of the run or of an interval.
const SOLVED: [f64; 3] = [0.0, 0.0, 1.0];

/// The matrix `S = w_q K + w_v D + M` of a step.
struct StepMatrix<'a, M: ?Sized> {
    equations: Equations<'a, M>,
    at: Linearised,
    tangent: Matrix,
    lu: Lu,
}

impl<'a, M: Model + ?Sized> StepMatrix<'a, M> {
    fn new(model: &'a mut M, trajectory: &Trajectory<'a>) -> Self {
        let n = model.facts().n;
        let equations = Equations::new(model, trajectory.intervals);
        Self { equations, at: Linearised::new(n), tangent: Matrix::zeros(n, n), lu: Lu::new(n) }
    }

    /// Linearises a state whose accelerations follow from forward dynamics.
    fn begin(
        &mut self,
        trajectory: &Trajectory<'_>,
        step: usize,
        is_transposed: bool,
    ) -> Result<(), Failure> {
        let (t, state) = trajectory.state(step, self.at.q.len());
        self.at.place(t, state);
        self.linearise(step, SOLVED, is_transposed)
    }

    /// Linearises the end of a step, given the weights of its accelerations.
    fn end(
        &mut self,
        trajectory: &Trajectory<'_>,
        step: usize,
        weights: [f64; 3],
        is_transposed: bool,
    ) -> Result<(), Failure> {
        let (t, state) = trajectory.state(step, self.at.q.len());
        self.at.place(t, state);
        if trajectory.interval_from(step).is_some() {
            // The recorded accelerations belong to the next interval.
            self.equations.solve(&mut self.at, step)?;
        }
        self.linearise(step, weights, is_transposed)
    }

    /// Linearises the end of the first stage of a step of two stages from the state before `step` to that state.
    fn first_stage(
        &mut self,
        trajectory: &Trajectory<'_>,
        step: usize,
        [stage, rest]: [f64; 2],
        is_transposed: bool,
    ) -> Result<(), Failure> {
        let n = self.at.q.len();
        let ((t, [q, _, _]), (_, [q_end, v_end, _])) =
            (trajectory.state(step - 1, n), trajectory.state(step, n));
        self.at.t = t + stage;
        for i in 0..n {
            self.at.v[i] = (q_end[i] - q[i] - stage * v_end[i]) / rest;
            self.at.q[i] = q[i] + stage * self.at.v[i];
        }
        self.equations.solve(&mut self.at, step)?;
        self.linearise(step, stage_weights(stage), is_transposed)
    }

    fn linearise(&mut self, step: usize, weights: [f64; 3], is_transposed: bool) -> Result<(), Failure> {
        self.equations.linearise(&mut self.at, weights, &mut self.tangent)?;
        if is_transposed {
            self.tangent.transpose_mut();
        }
        self.lu.factorise(&self.tangent).map_err(|Singular| Failure::Singular(step))
    }

    /// Derivatives of the accelerations `da = -S^-1 (K dq + D dv + dr/dp)` with respect to all parameters, n
    /// x p.
    fn accelerations<F: Model + ?Sized>(
        &mut self,
        of: [&Matrix; 2],
        parameters: &mut Parameters<'_, F>,
        da: &mut Matrix,
    ) -> Result<(), Failure> {
        self.equations.change(&self.at, of, parameters.of, da)?;
        if !da.is_empty() {
            da.as_mut_slice().chunks_exact_mut(self.at.q.len()).for_each(|column| self.lu.solve(column));
        }
        Ok(())
    }

    /// Solves `S^T lambda = lambda` in place and adds the contributions of `lambda` to the gradient and to
    /// the adjoint of coordinates and velocities.
    fn back<F: Model + ?Sized>(
        &mut self,
        lambda: &mut [f64],
        parameters: &mut Parameters<'_, F>,
        [gradient, on_q, on_v]: [&mut [f64]; 3],
        together: &mut Together,
    ) -> Result<(), Failure> {
        self.lu.solve(lambda);
        self.equations.gather(&self.at, lambda, parameters.of, gradient, together)?;
        self.at.add_transposed(lambda, [on_q, on_v]);
        Ok(())
    }
}

/// Weights of the accelerations of a stage at its end.
fn stage_weights(stage: f64) -> [f64; 3] {
    [stage * stage, stage, 1.0]
}

/// Of each step the sizes of its first stage and of the rest, if it is one of two stages, after a jump of inputs.
fn stages<M: Model + ?Sized>(
    model: &mut M,
    trajectory: &Trajectory<'_>,
    scheme: Scheme,
) -> Result<Vec<Option<[f64; 2]>>, Failure> {
    let (n, mut stages) = (model.facts().n, vec![None; trajectory.t.len() - 1]);
    let mut before = vec![0.0; n];
    let mut scratch = ForwardScratch::of(&*model);
    let mut inputs = model.facts().default_inputs.clone();
    let steps = stages.len();
    for interval in trajectory.intervals.iter().filter(|interval| interval.first < steps) {
        if interval.inputs == inputs {
            continue;
        }
        let (t, [q, v, a]) = trajectory.state(interval.first, n);
        model.set_inputs(&inputs);
        model.set_time(t)?;
        inputs.clone_from(&interval.inputs);
        let h = trajectory.t[interval.first + 1] - t;
        model
            .forward_dynamics(q, v, &mut before, &mut scratch)
            .map_err(|_| Failure::Singular(interval.first))?;
        let sizes = [FIRST_STAGE * h, h - FIRST_STAGE * h];
        if scheme.bridges_jump([&before, a], &model.facts().typical_coordinates, h)
            && (interval.first > 0 || starts_with_stages(model, trajectory, scheme, sizes)?)
        {
            stages[interval.first] = Some(sizes);
        }
    }
    Ok(stages)
}

/// Whether the first step is one of two stages of these sizes: jumps at the start are followed by a step of the scheme if that can be solved. Either
/// step relates velocities to accelerations.
fn starts_with_stages<M: Model + ?Sized>(
    model: &mut M,
    trajectory: &Trajectory<'_>,
    scheme: Scheme,
    [stage, rest]: [f64; 2],
) -> Result<bool, Failure> {
    let n = model.facts().n;
    let ((_, [q, v, a]), (t, [q_end, v_end, _])) = (trajectory.state(0, n), trajectory.state(1, n));
    let (step, mut a_end) = (scheme.step(stage + rest, Some(1.0)), vec![0.0; n]);
    model.set_inputs(&trajectory.intervals[0].inputs);
    model.set_time(t)?;
    let mut scratch = ForwardScratch::of(&*model);
    model.forward_dynamics(q_end, v_end, &mut a_end, &mut scratch).map_err(|_| Failure::Singular(1))?;
    let [mut of_scheme, mut of_stages] = [0.0_f64; 2];
    for i in 0..n {
        let change = v_end[i] - v[i];
        let by_scheme = (step.velocity[0] + step.velocity[1]) * a[i] + step.weights[1] * a_end[i];
        of_scheme = of_scheme.max((change - by_scheme).abs());
        let by_places = (q_end[i] - q[i] - stage * v_end[i]) / rest - v[i];
        of_stages = of_stages.max((by_places - stage * (change - stage * a_end[i]) / rest).abs());
    }
    Ok(of_stages < of_scheme)
}

/// Derivatives of coordinates and velocities of all states with respect to all parameters.
pub(super) fn forward<M: Model + ?Sized, F: Model + ?Sized>(
    model: &mut M,
    (trajectory, scheme): (&Trajectory<'_>, Scheme),
    parameters: &mut Parameters<'_, F>,
    monitor: &mut Monitor<'_>,
) -> Result<StateDerivatives, Failure> {
    let (n, p) = (model.facts().n, parameters.of.len());
    let (steps, stages) = (trajectory.steps(model, scheme), stages(model, trajectory, scheme)?);
    let mut system = StepMatrix::new(model, trajectory);
    let (mut q, mut v) = (parameters.dq0.clone(), parameters.dv0.clone());
    let [mut a, mut before] = [0; 2].map(|_| Matrix::zeros(n, p));
    let (mut q_base, mut v_base) = (q.clone(), v.clone());
    let mut kept = StateDerivatives::new(trajectory.t.len() * n * p);

    system.equations.hold(0, parameters.of);
    system.begin(trajectory, 0, false)?;
    system.accelerations([&q, &v], parameters, &mut a)?;
    monitor()?;
    let mut s = a.clone();
    kept.add([&q, &v]);
    for step in 1..trajectory.t.len() {
        let Step { made_for: (h, _), mut weights, displacement, velocity, mut rest, mut gain } =
            steps[step - 1];
        if let Some([stage, remaining]) = stages[step - 1] {
            weights = stage_weights(stage);
            for i in 0..n * p {
                q_base[i] = q[i] + stage * v[i];
            }
            system.first_stage(trajectory, step, [stage, remaining], false)?;
            system.accelerations([&q_base, &v], parameters, &mut a)?;
            for i in 0..n * p {
                v_base[i] = v[i] + remaining * a[i];
                q_base[i] = q[i] + remaining * (v[i] + weights[1] * a[i]) + stage * v_base[i];
            }
            // Algorithmic accelerations begin anew.
            let [of_first, of_end] = scheme.after_stages();
            (rest, gain) = ([of_first, 0.0], of_end);
        } else {
            for i in 0..n * p {
                let (a, s) = (a[i], s[i]);
                q_base[i] = q[i] + h * v[i] + displacement[0] * a + displacement[1] * s;
                v_base[i] = v[i] + velocity[0] * a + velocity[1] * s;
            }
        }
        s.iter_mut().zip(a.iter()).for_each(|(s, a)| *s = rest[0] * a + rest[1] * *s);
        system.end(trajectory, step, weights, false)?;
        system.accelerations([&q_base, &v_base], parameters, &mut a)?;
        for i in 0..n * p {
            q[i] = q_base[i] + weights[0] * a[i];
            v[i] = v_base[i] + weights[1] * a[i];
            s[i] += gain * a[i];
        }
        if let Some(interval) = trajectory.interval_from(step) {
            system.equations.hold(interval, parameters.of);
            system.begin(trajectory, step, false)?;
            before.copy_from(&a);
            system.accelerations([&q, &v], parameters, &mut a)?;
            // Inputs jump, but the lead of the algorithmic accelerations over the true ones stays the same.
            s += &a - &before;
        }
        monitor()?;
        kept.add([&q, &v]);
    }
    Ok(kept)
}

/// Gradient with respect to all parameters.
pub(super) fn adjoint<M: Model + ?Sized, F: Model + ?Sized>(
    model: &mut M,
    (trajectory, scheme): (&Trajectory<'_>, Scheme),
    weights: [&[f64]; 2],
    parameters: &mut Parameters<'_, F>,
    together: &mut Together,
    monitor: &mut Monitor<'_>,
) -> Result<Vec<f64>, Failure> {
    let n = model.facts().n;
    let mut gradient = vec![0.0; parameters.of.len()];
    let (steps, stages) = (trajectory.steps(model, scheme), stages(model, trajectory, scheme)?);
    let mut system = StepMatrix::new(model, trajectory);
    // Adjoint variables: derivatives of the function with respect to q, v, a and s of the current state.
    let [mut on_q, mut on_v, mut on_a, mut on_s] = [0; 4].map(|_| vec![0.0; n]);
    let mut lambda = vec![0.0; n];
    system.equations.hold(trajectory.last_interval(), parameters.of);
    for step in (0..trajectory.t.len()).rev() {
        for i in 0..n {
            on_q[i] += weights[0][step * n + i];
            on_v[i] += weights[1][step * n + i];
        }
        let begins = if step == 0 { Some(0) } else { trajectory.interval_from(step) };
        if let Some(interval) = begins {
            system.begin(trajectory, step, true)?;
            for i in 0..n {
                lambda[i] = -(on_a[i] + on_s[i]);
                on_a[i] = -on_s[i];
            }
            system.back(&mut lambda, parameters, [&mut gradient, &mut on_q, &mut on_v], together)?;
            if interval > 0 {
                system.equations.hold(interval - 1, parameters.of);
            }
        }
        if step > 0
            && let Some([stage, remaining]) = stages[step - 1]
        {
            let [of_q, of_v, _] = stage_weights(stage);
            let [of_first, of_end] = scheme.after_stages();
            system.end(trajectory, step, [of_q, of_v, 1.0], true)?;
            for i in 0..n {
                lambda[i] = -(on_a[i] + of_end * on_s[i] + of_q * on_q[i] + of_v * on_v[i]);
            }
            system.back(&mut lambda, parameters, [&mut gradient, &mut on_q, &mut on_v], together)?;
            // Now of what the second stage starts from: of the coordinates and velocities before the step, and of the velocities and
            // accelerations of the first stage.
            for i in 0..n {
                on_v[i] += stage * on_q[i];
                lambda[i] = -(remaining * (on_v[i] + of_v * on_q[i]) + of_first * on_s[i]);
                (on_a[i], on_s[i]) = (on_q[i], on_v[i]);
                (on_q[i], on_v[i]) = (0.0, remaining * on_q[i]);
            }
            system.first_stage(trajectory, step, [stage, remaining], true)?;
            system.back(&mut lambda, parameters, [&mut gradient, &mut on_q, &mut on_v], together)?;
            for i in 0..n {
                let (q, v) = (on_q[i], on_v[i]);
                (on_q[i], on_v[i]) = (on_a[i] + q, on_s[i] + stage * q + v);
                (on_a[i], on_s[i]) = (0.0, 0.0);
            }
        } else if step > 0 {
            let Step { made_for: (h, _), weights: of_a, displacement, velocity, rest, gain } =
                steps[step - 1];
            system.end(trajectory, step, of_a, true)?;
            for i in 0..n {
                lambda[i] = -(on_a[i] + of_a[0] * on_q[i] + of_a[1] * on_v[i] + gain * on_s[i]);
            }
            system.back(&mut lambda, parameters, [&mut gradient, &mut on_q, &mut on_v], together)?;
            for i in 0..n {
                let (q, v, s) = (on_q[i], on_v[i], on_s[i]);
                let of = |k: usize| displacement[k] * q + velocity[k] * v + rest[k] * s;
                on_v[i] += h * q;
                on_a[i] = of(0);
                on_s[i] = of(1);
            }
        }
        monitor()?;
    }
    parameters.add_starts([&on_q, &on_v], &mut gradient);
    Ok(gradient)
}
