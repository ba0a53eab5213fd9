//! The equations of equilibrium of a model under a fraction of its loads.

use super::growth::Growth;
use super::stability::Stiffness;
use crate::error::Interrupted;
use crate::linalg::{Matrix, dot, norm};
use crate::model::{Flaw, Model, Switch, rotation_vectors};
use crate::natural::{self, Natural, scaled};
use crate::small_motions::SmallMotions;
use crate::springs::Springs;
use crate::stability::{self, Verdict};

/// What a search has cost.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counters {
    /// Newton iterations.
    pub iterations: usize,
    /// Evaluations of the generalised forces.
    pub forces: usize,
    /// Evaluations of their tangent.
    pub tangents: usize,
}

/// `R(q, lambda) = 0` at rest, where lambda is how far what acts has grown ([`Growth`]): `tau_elastic(q) + lambda (tau(q) -
/// tau_elastic(q))` where it scales all loads at once, gravity included, or `tau(q; u(lambda))` where inputs go from one
/// place to another. Nothing of it needs a potential.
///
/// Coordinates and forces have different units, so that norms make sense only of `q_i / s_i` and `s_i R_i` with the
/// typical sizes s of the model: numbers without unit, and joules. What is called *scaled* below is meant so. What is
/// solved is solved in natural coordinates (see [`crate::springs`]), at forces of the springs that are part of the
/// state.
pub(super) struct Equations<'a> {
    model: &'a mut dyn Model,
    monitor: &'a mut dyn FnMut() -> Result<(), Interrupted>,
    pub(super) sizes: Vec<f64>,
    pub(super) counters: Counters,
    growth: Growth,
    rest: Vec<f64>,
    elastic: Vec<f64>,
    /// Stiffnesses of coordinates without elasticity along a path of inputs: those at its start, so that what is judged by them
    /// does not change with the tangent.
    reference: Option<Vec<f64>>,
    /// Whether the work against surfaces that touch is told by its energy, not by forces.
    pub(super) knows_overlaps: bool,
    /// Scaled tangent of the material, where that is all that does not depend on the shape.
    material: Option<Matrix>,
}

/// A state on its way to equilibrium: coordinates, load factor, and the forces of the springs.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct State {
    pub(super) q: Vec<f64>,
    pub(super) load_factor: f64,
    pub(super) forces: Vec<f64>,
}

/// A change of a state: of the scaled coordinates and, last, the load factor; and of the forces of the springs.
#[derive(Clone, Debug)]
pub(super) struct Step {
    pub(super) scaled: Vec<f64>,
    pub(super) forces: Vec<f64>,
}

/// The equations near a state, in natural coordinates.
#[derive(Clone, Debug)]
pub(super) struct Linear {
    pub(super) residual: Vec<f64>,
    /// Derivatives of the residual with respect to the load factor and the coordinates.
    pub(super) load: Vec<f64>,
    pub(super) tangent: Matrix,
    pub(super) natural: Natural,
    springs: Option<Springs>,
    /// How the forces of the springs change with the load factor, where they do.
    load_on_springs: Option<Vec<f64>>,
    /// Scaled norm of the residual at the forces of the springs that the state has.
    pub(super) residual_norm: f64,
}

/// A state as a descent sees it.
#[derive(Clone, Debug)]
pub(super) struct Downhill {
    residual: Vec<f64>,
    energy: f64,
    pub(super) residual_norm: f64,
}

impl Downhill {
    /// The work of a step from here to another state, by the trapezoidal rule.
    pub(super) fn work(&self, other: &Self, step: &Step) -> f64 {
        0.5 * (dot(&self.residual, &step.scaled) + dot(&other.residual, &step.scaled))
            + (other.energy - self.energy)
    }
}

impl Step {
    /// The load factor's part.
    pub(super) fn load_factor(&self) -> f64 {
        self.scaled[self.scaled.len() - 1]
    }
}

impl State {
    /// Moves by a multiple of a step.
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
    /// The step that moves natural coordinates by `x` and the load factor, to first order.
    pub(super) fn step(&self, x: &[f64], load_factor: f64) -> Step {
        let forces = self.springs.as_ref().map(|springs| self.natural.change_of_forces(springs, x));
        let mut scaled = self.natural.coordinates(x);
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

    /// A scaled direction of coordinates and load factor as a step.
    pub(super) fn moved(&self, scaled: Vec<f64>) -> Step {
        let n = scaled.len() - 1;
        let forces = self.springs.as_ref().map(|springs| springs.changes(&scaled[..n]));
        let forces = self.with_load(forces, scaled[n]);
        Step { scaled, forces }
    }

    /// Moves a state, that of this one, by such a step: its springs then have the forces that they have to first order.
    pub(super) fn advance(&self, state: &mut State, step: &Step, sizes: &[f64]) {
        if let Some(springs) = &self.springs {
            state.forces.copy_from_slice(&springs.forces);
        }
        state.advance(step, 1.0, sizes);
    }
}

impl<'a> Equations<'a> {
    /// `monitor` is asked before every evaluation of forces whether to go on.
    pub(super) fn new(
        model: &'a mut dyn Model,
        growth: Growth,
        monitor: &'a mut dyn FnMut() -> Result<(), Interrupted>,
    ) -> Self {
        let n = model.n();
        let mut sizes = vec![0.0; n];
        model.typical_coordinates(&mut sizes);
        let rest = vec![0.0; n];
        let material = (model.springs() > 0).then(|| natural::material(model, &rest, &sizes));
        let (counters, elastic) = (Counters::default(), rest.clone());
        Self {
            model,
            monitor,
            sizes,
            counters,
            growth,
            elastic,
            rest,
            knows_overlaps: false,
            reference: None,
            material,
        }
    }

    /// Sets the inputs of the model to where they are at a load factor on their way.
    pub(super) fn set_inputs_of(&mut self, growth: &mut Growth, load_factor: f64) -> Result<(), Interrupted> {
        growth.set(self.model, load_factor)
    }

    /// From now on this grows.
    pub(super) fn grow(&mut self, growth: Growth) {
        self.growth = growth;
    }

    /// The inputs at a load factor, where they are what grows.
    pub(super) fn inputs_at(&self, load_factor: f64) -> Vec<f64> {
        self.growth.inputs_at(load_factor).unwrap_or_default()
    }

    /// Writes a shape with no rotation vector longer than pi.
    pub(super) fn wrap(&self, q: &mut [f64]) {
        let mut rest = vec![0.0; q.len()];
        rotation_vectors::wrap(self.model.rotation_vectors(), q, &mut rest, &mut []);
    }

    pub(super) fn n(&self) -> usize {
        self.sizes.len()
    }

    pub(super) fn has_contact(&self) -> bool {
        self.model.has_contact()
    }

    /// Why a shape is none that the model has.
    pub(super) fn flaw(&mut self, q: &[f64]) -> Option<Flaw> {
        self.model.flaw(q)
    }

    /// What is sunk in a shape.
    pub(super) fn sunk(&mut self, q: &[f64]) -> Option<Flaw> {
        self.model.sunk(q)
    }

    /// A state, with the forces that its springs have.
    pub(super) fn state(&mut self, q: Vec<f64>, load_factor: f64) -> Result<State, Interrupted> {
        let mut state = State { q, load_factor, forces: Vec::new() };
        self.growth.set(self.model, load_factor)?;
        if let Some(own) = natural::linearised(self.model, &state.q, &self.sizes) {
            state.forces.clone_from(&own.forces);
            if let Some(linear) = self.linearise(&state)? {
                state.forces = linear.natural.settled(&own, &linear.residual);
            }
        }
        Ok(state)
    }

    /// Lets go of what would have to push, or takes up what has been passed, of constraints that hold one way only; says whether
    /// there was any.
    pub(super) fn switch(&mut self, state: &mut State) -> Result<bool, Interrupted> {
        if !self.model.is_one_sided() {
            return Ok(false);
        }
        self.growth.set(self.model, state.load_factor)?;
        let mut multipliers: Vec<f64> = state.forces.iter().map(|force| -force).collect();
        if self.model.switch(&state.q, &mut multipliers) == Switch::Nothing {
            return Ok(false);
        }
        state.forces.iter_mut().zip(multipliers).for_each(|(force, multiplier)| *force = -multiplier);
        Ok(true)
    }

    /// Whether it would switch any.
    pub(super) fn would_switch(&mut self, state: &State) -> Result<bool, Interrupted> {
        let held: Vec<f64> =
            self.model.held().into_iter().map(|is_held| f64::from(u8::from(is_held))).collect();
        let would_switch = self.switch(&mut state.clone())?;
        if would_switch {
            self.model.release(&held);
        }
        Ok(would_switch)
    }

    /// How the forces of the springs change with the load factor in a shape: of lengths that are told, as they change with
    /// inputs, straight.
    fn load_on_springs(
        &mut self,
        state: &State,
        springs: Option<&Springs>,
    ) -> Result<Option<Vec<f64>>, Interrupted> {
        let (Some(springs), Growth::Inputs(_), true) = (springs, &self.growth, self.model.is_one_sided())
        else {
            return Ok(None);
        };
        self.growth.set(self.model, state.load_factor + 1.0)?;
        let there = natural::linearised(self.model, &state.q, &self.sizes);
        self.growth.set(self.model, state.load_factor)?;
        let rates =
            |there: Springs| there.forces.iter().zip(&springs.forces).map(|(to, from)| to - from).collect();
        Ok(there.map(rates))
    }

    /// The scaled residual at springs' forces of their own, or at those that are held; and its derivative with
    /// respect to the load factor.
    fn forces(
        &mut self,
        q: &[f64],
        load_factor: f64,
        held: Option<&[f64]>,
        residual: &mut [f64],
        load: &mut [f64],
    ) -> Result<(), Interrupted> {
        (self.monitor)()?;
        self.counters.forces += 1;
        self.growth.set(self.model, load_factor)?;
        self.model.hold_springs(held);
        match &mut self.growth {
            Growth::Loads => {
                self.model.inverse_dynamics(q, &self.rest, &self.rest, load);
                self.model.elastic_forces(q, &mut self.elastic);
            }
            Growth::Inputs(inputs) => {
                self.model.inverse_dynamics(q, &self.rest, &self.rest, residual);
                inputs.load(self.model, q, &self.rest, load);
            }
        }
        self.model.hold_springs(None);
        for i in 0..q.len() {
            let size = self.sizes[i];
            if matches!(self.growth, Growth::Loads) {
                load[i] = size * (load[i] - self.elastic[i]);
                residual[i] = size * self.elastic[i] + load_factor * load[i];
            } else {
                (load[i], residual[i]) = (size * load[i], size * residual[i]);
            }
        }
        Ok(())
    }

    /// The scaled residual, and its derivative with respect to the load factor.
    pub(super) fn residual(
        &mut self,
        q: &[f64],
        load_factor: f64,
        residual: &mut [f64],
        load: &mut [f64],
    ) -> Result<(), Interrupted> {
        self.forces(q, load_factor, None, residual, load)
    }

    /// What a step's work is told from: the scaled residual without the springs, their energy, and the norm of the
    /// residual at the forces that the state has. The force of a stiff spring is rounding times stiffness; its energy
    /// is not.
    pub(super) fn downhill(&mut self, state: &State) -> Result<Downhill, Interrupted> {
        let n = state.q.len();
        let (mut residual, mut load) = (vec![0.0; n], vec![0.0; n]);
        self.growth.set(self.model, state.load_factor)?;
        let springs = natural::linearised(self.model, &state.q, &self.sizes);
        let held = springs.is_some().then_some(&state.forces[..]);
        self.forces(&state.q, state.load_factor, held, &mut residual, &mut load)?;
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
        Ok(Downhill { residual, energy, residual_norm })
    }

    /// Takes what surfaces do to each other out of a residual; returns its energy. A trapezoid through the slopes before and
    /// behind the place where they meet sees much more work than there is.
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

    /// The scaled tangents `dR/dq`, and of what is elastic, at springs' forces of their own or at those that are held.
    fn tangents(
        &mut self,
        q: &[f64],
        load_factor: f64,
        held: Option<&[f64]>,
    ) -> Result<[Matrix; 2], Interrupted> {
        let n = q.len();
        let [mut tangent, mut elastic] = [Matrix::zeros(n, n), Matrix::zeros(n, n)];
        self.counters.tangents += 1;
        self.growth.set(self.model, load_factor)?;
        self.model.hold_springs(held);
        self.model.weighted_tangent(q, &self.rest, &self.rest, [1.0, 0.0, 0.0], &mut tangent);
        self.model.elastic_tangent(q, &mut elastic);
        self.model.hold_springs(None);
        if matches!(self.growth, Growth::Loads) && load_factor != 1.0 {
            for (entry, part) in tangent.iter_mut().zip(&elastic) {
                *entry = part + load_factor * (*entry - part);
            }
        }
        Ok([scaled(tangent, &self.sizes), scaled(elastic, &self.sizes)])
    }

    /// The scaled tangent `dR/dq`.
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

    /// The equations near a state; `None` where something is not finite.
    pub(super) fn linearise(&mut self, state: &State) -> Result<Option<Linear>, Interrupted> {
        let State { q, load_factor, forces } = state;
        let n = q.len();
        self.growth.set(self.model, *load_factor)?;
        let springs = natural::linearised(self.model, q, &self.sizes);
        let held = springs.is_some().then_some(&forces[..]);
        let (mut residual, mut load) = (vec![0.0; n], vec![0.0; n]);
        self.forces(q, *load_factor, held, &mut residual, &mut load)?;
        let [tangent, elastic] = self.tangents(q, *load_factor, held)?;
        let material = self.material.as_ref().unwrap_or(&elastic);
        if matches!(self.growth, Growth::Inputs(_)) && self.reference.is_none() {
            self.reference = Some(natural::reference(material, &tangent));
        }
        let fallback = || self.reference.clone().unwrap_or_else(|| natural::reference(material, &tangent));
        let is_finite = tangent.iter().chain(&residual).chain(&load).all(|x| x.is_finite());
        let natural = if is_finite { Natural::new(material, springs.as_ref(), fallback) } else { None };
        let load_on_springs = self.load_on_springs(state, springs.as_ref())?;
        Ok(natural.map(|natural| Linear {
            residual_norm: norm(&residual),
            residual: natural.residual(&residual, springs.as_ref(), forces),
            load: match (&load_on_springs, &springs) {
                (Some(rates), Some(springs)) => {
                    let rated = Springs { forces: rates.clone(), ..springs.clone() };
                    natural.residual(&load, Some(&rated), &vec![0.0; rates.len()])
                }
                _ => natural.forces(&load),
            },
            load_on_springs,
            tangent: natural.tangent(&tangent, springs.as_ref()),
            natural,
            springs,
        }))
    }

    /// Moves a shape, to first order and then on, until its springs carry the forces that the state has: what is
    /// stiff follows, what is soft stays.
    pub(super) fn restore(&mut self, state: &mut State, iterations: usize) {
        /// Longest step: what is linear in it is no guide beyond.
        const LONGEST: f64 = 0.5;
        /// Steps below that do not matter.
        const SHORTEST: f64 = 1e-10;
        let Some(material) = &self.material else { return };
        for _ in 0..iterations {
            let Some(springs) = natural::linearised(self.model, &state.q, &self.sizes) else { return };
            let Some(natural) =
                Natural::new(material, Some(&springs), || natural::reference(material, material))
            else {
                return;
            };
            let step = natural.coordinates(&natural.restoring(&springs, &state.forces));
            let length = norm(&step);
            let part = (LONGEST / length).min(1.0);
            for ((q, step), size) in state.q.iter_mut().zip(&step).zip(&self.sizes) {
                *q += part * step * size;
            }
            if length.is_nan() || length <= SHORTEST {
                return;
            }
        }
    }

    /// What small disturbances of an equilibrium do. Asks mass and damping only where stiffness alone does not decide.
    pub(super) fn verdict(
        &mut self,
        state: &State,
        linear: &Linear,
        stiffness: &Stiffness,
    ) -> Result<Option<Verdict>, Interrupted> {
        if stiffness.is_symmetric && !self.model.has_velocity_forces() {
            return Ok(stability::of_stiffness(stiffness.lowest, state.q.len(), stiffness.size()));
        }
        Ok(stability::verdict(&self.small_motions(state, linear)?))
    }

    /// Small motions about an equilibrium. What depends on velocities is not scaled by the load factor.
    fn small_motions(&mut self, state: &State, linear: &Linear) -> Result<SmallMotions, Interrupted> {
        let n = state.q.len();
        self.growth.set(self.model, state.load_factor)?;
        let [mut damping, mut mass] = [Matrix::zeros(n, n), Matrix::zeros(n, n)];
        self.model.weighted_tangent(&state.q, &self.rest, &self.rest, [0.0, 1.0, 0.0], &mut damping);
        self.model.mass_matrix(&state.q, &mut mass);
        let [mass, damping] = [mass, damping].map(|a| linear.natural.matrix(&scaled(a, &self.sizes)));
        Ok(SmallMotions {
            mass,
            damping,
            stiffness: linear.tangent.clone(),
            basis: linear.natural.basis(),
            sizes: self.sizes.clone(),
        })
    }
}
