//! Equations of equilibrium of a model under a fraction of its loads.

use super::load_parameter::LoadParameter;
use super::tunnelling::Passage;
use crate::analysis::normalised;
use crate::analysis::normalised::{Normalised, scaled};
use crate::analysis::small_motions::small_motions;
use crate::analysis::stability;
use crate::analysis::stability::Verdict;
use crate::error::Interrupted;
use crate::model::springs::Springs;
use crate::model::{InvalidShape, Static, Switch, rotation_vectors};
use crate::numerics::linalg::{Matrix, dot, norm};

/// Cost of a search.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counters {
    /// Newton iterations.
    pub iterations: usize,
    /// Evaluations of the generalised forces.
    pub forces: usize,
    /// Evaluations of their tangent.
    pub tangents: usize,
}

impl std::ops::Add for Counters {
    type Output = Self;

    fn add(self, more: Self) -> Self {
        Self {
            iterations: self.iterations + more.iterations,
            forces: self.forces + more.forces,
            tangents: self.tangents + more.tangents,
        }
    }
}

/// Equilibrium equations `R(q, lambda) = 0` at rest with the load factor lambda ([`LoadParameter`]):
/// `tau_elastic(q) + lambda (tau(q) - tau_elastic(q))` if lambda scales all loads including gravity, or
/// `tau(q; u(lambda))` if inputs follow a path. Loads need no potential.
///
/// Coordinates and forces have mixed units. Norms are therefore those of `q_i / s_i` (dimensionless) and `s_i
/// R_i` (joules) with the typical sizes s of the model; these are called *scaled* below. Systems are solved
/// in normalised coordinates (see [`crate::model::springs`]), at forces of the springs that are part of the state.
pub(super) struct Equations<'a> {
    pub(super) model: &'a mut dyn Static,
    monitor: &'a mut dyn FnMut() -> Result<(), Interrupted>,
    pub(super) sizes: Vec<f64>,
    pub(super) counters: Counters,
    load_parameter: LoadParameter,
    rest: Vec<f64>,
    elastic: Vec<f64>,
    /// Reference stiffnesses of coordinates without elasticity along a path of inputs: those at its start, so
    /// that tests relative to them do not change along the path.
    reference: Option<Vec<f64>>,
    /// Whether the work of contacts is computed from their energy instead of their forces.
    pub(super) knows_overlaps: bool,
    /// Scaled tangent of the material, if it does not depend on the shape.
    material: Option<Matrix>,
    /// Whether to judge stability.
    pub(super) judges: bool,
}

/// A state of the iteration: coordinates, load factor, and the forces of the springs.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct State {
    pub(super) q: Vec<f64>,
    pub(super) load_factor: f64,
    pub(super) forces: Vec<f64>,
}

/// A change of a state: of the scaled coordinates followed by the load factor, and of the forces of the
/// springs.
#[derive(Clone, Debug)]
pub(super) struct Step {
    pub(super) scaled: Vec<f64>,
    pub(super) forces: Vec<f64>,
}

/// The equations linearised at a state, in normalised coordinates.
#[derive(Clone, Debug)]
pub(super) struct Linear {
    pub(super) residual: Vec<f64>,
    /// Derivatives of the residual with respect to the load factor and to the coordinates.
    pub(super) load: Vec<f64>,
    pub(super) tangent: Matrix,
    pub(super) normalised: Normalised,
    springs: Option<Springs>,
    /// Derivative of the springs' forces with respect to the load factor, if not zero.
    load_on_springs: Option<Vec<f64>>,
    /// Scaled norm of the residual at the state's spring forces.
    pub(super) residual_norm: f64,
}

/// Quantities of a state for a descent.
#[derive(Clone, Debug)]
pub(super) struct DescentState {
    residual: Vec<f64>,
    energy: f64,
    pub(super) residual_norm: f64,
}

impl DescentState {
    /// Work of a step from this state to another one, by the trapezoidal rule.
    pub(super) fn work(&self, other: &Self, step: &Step) -> f64 {
        0.5 * (dot(&self.residual, &step.scaled) + dot(&other.residual, &step.scaled))
            + (other.energy - self.energy)
    }
}

impl Step {
    /// Component of the load factor.
    pub(super) fn load_factor(&self) -> f64 {
        self.scaled[self.scaled.len() - 1]
    }
}

impl State {
    /// Adds a multiple of a step.
    pub(super) fn advance(&mut self, step: &Step, length: f64, sizes: &[f64]) {
        for (i, q) in self.q.iter_mut().enumerate() {
            *q += length * step.scaled[i] * sizes[i];
        }
        self.load_factor += length * step.load_factor();
        for (force, change) in self.forces.iter_mut().zip(&step.forces) {
            *force += length * change;
        }
    }

    /// The step from another state to this one.
    pub(super) fn since(&self, other: &Self, sizes: &[f64]) -> Step {
        let coordinates = (0..self.q.len()).map(|i| (self.q[i] - other.q[i]) / sizes[i]);
        Step {
            scaled: coordinates.chain([self.load_factor - other.load_factor]).collect(),
            forces: self.forces.iter().zip(&other.forces).map(|(to, from)| to - from).collect(),
        }
    }
}

impl Linear {
    /// The step for a change `x` of the normalised coordinates and a change of the load factor, to first order.
    pub(super) fn step(&self, x: &[f64], load_factor: f64) -> Step {
        let forces = self.springs.as_ref().map(|springs| self.normalised.change_of_forces(springs, x));
        let mut scaled = self.normalised.coordinates(x);
        scaled.push(load_factor);
        Step { scaled, forces: self.with_load(forces, load_factor) }
    }

    fn with_load(&self, forces: Option<Vec<f64>>, load_factor: f64) -> Vec<f64> {
        let mut forces = forces.unwrap_or_default();
        for (force, rate) in forces.iter_mut().zip(self.load_on_springs.iter().flatten()) {
            *force += rate * load_factor;
        }
        forces
    }

    /// The step for a scaled direction of coordinates and load factor.
    pub(super) fn moved(&self, scaled: Vec<f64>) -> Step {
        let n = scaled.len() - 1;
        let forces = self.springs.as_ref().map(|springs| springs.changes(&scaled[..n]));
        let forces = self.with_load(forces, scaled[n]);
        Step { scaled, forces }
    }

    /// Applies such a step to the state of this linearisation; the springs' forces change to first order.
    pub(super) fn advance(&self, state: &mut State, step: &Step, sizes: &[f64]) {
        if let Some(springs) = &self.springs {
            state.forces.copy_from_slice(&springs.forces);
        }
        state.advance(step, 1.0, sizes);
    }
}

impl<'a> Equations<'a> {
    /// Near a shape, which sets the sizes of the coordinates. `monitor` is called before every evaluation of forces and may stop
    /// the search.
    pub(super) fn new(
        model: &'a mut dyn Static,
        load_parameter: LoadParameter,
        near: &[f64],
        monitor: &'a mut dyn FnMut() -> Result<(), Interrupted>,
    ) -> Self {
        let n = model.facts().n;
        let mut sizes = vec![0.0; n];
        model.sizes(near, &mut sizes);
        let rest = vec![0.0; n];
        let material = (model.facts().springs > 0).then(|| normalised::material(model, &rest, &sizes));
        let (counters, elastic) = (Counters::default(), rest.clone());
        Self {
            model,
            monitor,
            sizes,
            counters,
            load_parameter,
            elastic,
            rest,
            knows_overlaps: false,
            reference: None,
            material,
            judges: true,
        }
    }

    /// Inputs at a load factor; empty if loads grow instead.
    pub(super) fn inputs_at(&self, load_factor: f64) -> Vec<f64> {
        self.load_parameter.inputs_at(load_factor).unwrap_or_default()
    }

    /// Rewrites a shape with rotation vectors no longer than pi.
    pub(super) fn wrap(&self, q: &mut [f64]) {
        let mut rest = vec![0.0; q.len()];
        rotation_vectors::wrap(&self.model.facts().rotation_vectors, q, &mut rest, &mut []);
    }

    /// The same with rates of the coordinates; whether anything has changed.
    pub(super) fn fold(&self, q: &mut [f64], rates: &mut [f64]) -> bool {
        rotation_vectors::wrap(&self.model.facts().rotation_vectors, q, rates, &mut [])
    }

    pub(super) fn n(&self) -> usize {
        self.sizes.len()
    }

    pub(super) fn has_contact(&self) -> bool {
        self.model.facts().has_contact
    }

    /// Problem of an invalid shape; `None` for a valid one.
    pub(super) fn invalid_shape(&mut self, q: &[f64]) -> Option<InvalidShape> {
        self.model.invalid_shape(q)
    }

    /// What surfaces do on the path between two shapes, of this scaled length.
    pub(super) fn passage(&mut self, ends: [&[f64]; 2], length: f64) -> Passage {
        Passage::between(&mut *self.model, ends, length)
    }

    /// Problem of a shape with deep penetration; `None` otherwise.
    pub(super) fn deep_penetration(&mut self, q: &[f64]) -> Option<InvalidShape> {
        self.model.deep_penetration(q)
    }

    /// State with the forces of the springs in this shape.
    pub(super) fn state(&mut self, q: Vec<f64>, load_factor: f64) -> Result<State, Interrupted> {
        let mut state = State { q, load_factor, forces: Vec::new() };
        self.load_parameter.set(self.model, load_factor)?;
        if let Some(own) = normalised::linearised(self.model, &state.q, &self.sizes) {
            state.forces.clone_from(&own.forces);
            if let Some(linear) = self.linearise(&state)? {
                state.forces = linear.normalised.forces_at_equilibrium(&own, &linear.residual);
            }
        }
        Ok(state)
    }

    /// Updates the active set of one-sided constraints: activates violated ones, or releases one that would
    /// have to push. Returns whether anything changed.
    pub(super) fn switch(&mut self, state: &mut State) -> Result<bool, Interrupted> {
        if !self.model.facts().is_one_sided {
            return Ok(false);
        }
        self.load_parameter.set(self.model, state.load_factor)?;
        let mut multipliers: Vec<f64> = state.forces.iter().map(|force| -force).collect();
        if self.model.switch(&state.q, &mut multipliers) == Switch::Nothing {
            return Ok(false);
        }
        state.forces.iter_mut().zip(multipliers).for_each(|(force, multiplier)| *force = -multiplier);
        Ok(true)
    }

    /// Whether `switch` would change anything.
    pub(super) fn would_switch(&mut self, state: &State) -> Result<bool, Interrupted> {
        let active: Vec<f64> =
            self.model.active().into_iter().map(|is_active| f64::from(u8::from(is_active))).collect();
        let would_switch = self.switch(&mut state.clone())?;
        if would_switch {
            self.model.release(&active);
        }
        Ok(would_switch)
    }

    /// Derivative of the springs' forces with respect to the load factor in a shape: from commanded lengths,
    /// which depend linearly on the inputs.
    fn load_on_springs(
        &mut self,
        state: &State,
        springs: Option<&Springs>,
    ) -> Result<Option<Vec<f64>>, Interrupted> {
        let (Some(springs), LoadParameter::Inputs(_), true) =
            (springs, &self.load_parameter, self.model.facts().is_one_sided)
        else {
            return Ok(None);
        };
        self.load_parameter.set(self.model, state.load_factor + 1.0)?;
        let there = normalised::linearised(self.model, &state.q, &self.sizes);
        self.load_parameter.set(self.model, state.load_factor)?;
        let rates =
            |there: Springs| there.forces.iter().zip(&springs.forces).map(|(to, from)| to - from).collect();
        Ok(there.map(rates))
    }

    /// Scaled residual, with the springs' forces of the shape or with fixed forces, and its derivative with
    /// respect to the load factor.
    fn forces(
        &mut self,
        q: &[f64],
        load_factor: f64,
        spring_forces: Option<&[f64]>,
        residual: &mut [f64],
        load: &mut [f64],
    ) -> Result<(), Interrupted> {
        (self.monitor)()?;
        self.counters.forces += 1;
        self.load_parameter.set(self.model, load_factor)?;
        self.model.hold_springs(spring_forces);
        match &mut self.load_parameter {
            LoadParameter::Loads => {
                self.model.inverse_dynamics(q, &self.rest, &self.rest, load);
                self.model.elastic_forces(q, &mut self.elastic);
            }
            LoadParameter::Inputs(inputs) => {
                self.model.inverse_dynamics(q, &self.rest, &self.rest, residual);
                inputs.load(self.model, q, &self.rest, load);
            }
        }
        self.model.hold_springs(None);
        for i in 0..q.len() {
            let size = self.sizes[i];
            if matches!(self.load_parameter, LoadParameter::Loads) {
                load[i] = size * (load[i] - self.elastic[i]);
                residual[i] = size * self.elastic[i] + load_factor * load[i];
            } else {
                (load[i], residual[i]) = (size * load[i], size * residual[i]);
            }
        }
        Ok(())
    }

    /// Scaled residual, and its derivative with respect to the load factor.
    pub(super) fn residual(
        &mut self,
        q: &[f64],
        load_factor: f64,
        residual: &mut [f64],
        load: &mut [f64],
    ) -> Result<(), Interrupted> {
        self.forces(q, load_factor, None, residual, load)
    }

    /// Quantities from which the work of a step is computed: the scaled residual without springs, the energy
    /// of the springs, and the norm of the residual at the state's spring forces. The force of a stiff spring
    /// has a large rounding error, its energy does not.
    pub(super) fn downhill(&mut self, state: &State) -> Result<DescentState, Interrupted> {
        let n = state.q.len();
        let (mut residual, mut load) = (vec![0.0; n], vec![0.0; n]);
        self.load_parameter.set(self.model, state.load_factor)?;
        let springs = normalised::linearised(self.model, &state.q, &self.sizes);
        let spring_forces = springs.is_some().then_some(&state.forces[..]);
        self.forces(&state.q, state.load_factor, spring_forces, &mut residual, &mut load)?;
        let residual_norm = norm(&residual);
        if springs.is_some() {
            let none = vec![0.0; state.forces.len()];
            self.forces(&state.q, state.load_factor, Some(&none), &mut residual, &mut load)?;
        }
        let has_springs = springs.is_some();
        let mut energy = springs.map_or(0.0, |springs| springs.energy);
        if self.knows_overlaps {
            energy += self.leave_contact(state, has_springs, &mut residual, &mut load)?;
        }
        Ok(DescentState { residual, energy, residual_norm })
    }

    /// Removes contact forces from a residual and returns their energy. The trapezoidal rule across the onset
    /// of a contact would overestimate the work.
    fn leave_contact(
        &mut self,
        state: &State,
        has_springs: bool,
        residual: &mut [f64],
        load: &mut [f64],
    ) -> Result<f64, Interrupted> {
        let none = vec![0.0; state.forces.len()];
        let touching = self.model.energy(&state.q, &self.rest).elastic;
        self.model.leave_contact(true);
        let apart = self.model.energy(&state.q, &self.rest).elastic;
        let left = self.forces(&state.q, state.load_factor, has_springs.then_some(&none), residual, load);
        self.model.leave_contact(false);
        left?;
        Ok(state.load_factor * (touching - apart))
    }

    /// The scaled tangent `dR/dq` and its elastic part, with the springs' forces of the shape or with fixed
    /// forces.
    fn tangents(
        &mut self,
        q: &[f64],
        load_factor: f64,
        spring_forces: Option<&[f64]>,
    ) -> Result<[Matrix; 2], Interrupted> {
        let n = q.len();
        let [mut tangent, mut elastic] = [Matrix::zeros(n, n), Matrix::zeros(n, n)];
        self.counters.tangents += 1;
        self.load_parameter.set(self.model, load_factor)?;
        self.model.hold_springs(spring_forces);
        self.model.weighted_tangent(q, &self.rest, &self.rest, [1.0, 0.0, 0.0], &mut tangent);
        self.model.elastic_tangent(q, &mut elastic);
        self.model.hold_springs(None);
        if matches!(self.load_parameter, LoadParameter::Loads) && load_factor != 1.0 {
            for (entry, part) in tangent.iter_mut().zip(&elastic) {
                *entry = part + load_factor * (*entry - part);
            }
        }
        Ok([scaled(tangent, &self.sizes), scaled(elastic, &self.sizes)])
    }

    /// Scaled tangent `dR/dq`.
    pub(super) fn tangent(
        &mut self,
        q: &[f64],
        load_factor: f64,
        tangent: &mut Matrix,
    ) -> Result<(), Interrupted> {
        let [of_all, _] = self.tangents(q, load_factor, None)?;
        tangent.copy_from(&of_all);
        Ok(())
    }

    /// The equations linearised at a state; `None` if a number is not finite.
    pub(super) fn linearise(&mut self, state: &State) -> Result<Option<Linear>, Interrupted> {
        let State { q, load_factor, forces } = state;
        let n = q.len();
        self.load_parameter.set(self.model, *load_factor)?;
        let springs = normalised::linearised(self.model, q, &self.sizes);
        let spring_forces = springs.is_some().then_some(&forces[..]);
        let (mut residual, mut load) = (vec![0.0; n], vec![0.0; n]);
        self.forces(q, *load_factor, spring_forces, &mut residual, &mut load)?;
        let [tangent, elastic] = self.tangents(q, *load_factor, spring_forces)?;
        let material = self.material.as_ref().unwrap_or(&elastic);
        let reference = || {
            let forces: Vec<f64> =
                load.iter().zip(&residual).map(|(l, r): (&f64, &f64)| l.abs().max(r.abs())).collect();
            normalised::reference(material, &tangent, &forces, &self.model.facts().parts, &[])
        };
        if matches!(self.load_parameter, LoadParameter::Inputs(_)) && self.reference.is_none() {
            self.reference = Some(reference());
        }
        let fallback = || self.reference.clone().unwrap_or_else(reference);
        let is_finite = tangent.iter().chain(&residual).chain(&load).all(|x| x.is_finite());
        let normalised = if is_finite { Normalised::new(material, springs.as_ref(), fallback) } else { None };
        let load_on_springs = self.load_on_springs(state, springs.as_ref())?;
        Ok(normalised.map(|normalised| Linear {
            residual_norm: norm(&residual),
            residual: normalised.residual(&residual, springs.as_ref(), forces),
            load: match (&load_on_springs, &springs) {
                (Some(rates), Some(springs)) => {
                    let rated = Springs { forces: rates.clone(), ..springs.clone() };
                    normalised.residual(&load, Some(&rated), &vec![0.0; rates.len()])
                }
                _ => normalised.forces(&load),
            },
            load_on_springs,
            tangent: normalised.tangent(&tangent, springs.as_ref()),
            normalised,
            springs,
        }))
    }

    /// Changes a shape, by first-order steps, until its springs carry the state's spring forces. Stiff
    /// directions adapt, soft ones stay.
    pub(super) fn restore(&mut self, state: &mut State, iterations: usize) {
        /// Longest step for which the linearisation is useful.
        const LONGEST_STEP: f64 = 0.5;
        /// Steps below this length are negligible.
        const SHORTEST_STEP: f64 = 1e-10;
        let Some(material) = &self.material else { return };
        for _ in 0..iterations {
            let Some(springs) = normalised::linearised(self.model, &state.q, &self.sizes) else { return };
            let work = normalised::work_of_loads(self.model, &state.q, &self.sizes);
            let reference =
                || normalised::reference(material, material, &work, &self.model.facts().parts, &[]);
            let Some(normalised) = Normalised::new(material, Some(&springs), reference) else {
                return;
            };
            let step = normalised.coordinates(&normalised.restoring(&springs, &state.forces));
            let length = norm(&step);
            let part = (LONGEST_STEP / length).min(1.0);
            for ((q, step), size) in state.q.iter_mut().zip(&step).zip(&self.sizes) {
                *q += part * step * size;
            }
            if length.is_nan() || length <= SHORTEST_STEP {
                return;
            }
        }
    }

    /// Stability of an equilibrium; `None` if unknown or not requested.
    pub(super) fn judgement(&mut self, state: &State) -> Result<Option<Verdict>, Interrupted> {
        if self.judges { self.verdict(state) } else { Ok(None) }
    }

    /// Stability of an equilibrium. Terms that depend on velocities are not scaled by the load factor.
    pub(super) fn verdict(&mut self, state: &State) -> Result<Option<Verdict>, Interrupted> {
        self.load_parameter.set(self.model, state.load_factor)?;
        let loads = if matches!(self.load_parameter, LoadParameter::Loads) { state.load_factor } else { 1.0 };
        let motions = small_motions(self.model, &state.q, &self.sizes, loads, &[]);
        Ok(motions.and_then(|motions| stability::verdict(&motions)))
    }
}
