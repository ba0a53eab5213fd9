//! Energy balance of a motion: energies over time, and the energy that left or entered the system.
//!
//! ```
//! use lissom::newmark;
//! use lissom::pendulum::SpringPendulum;
//! use lissom::simulate::{Method, simulate};
//!
//! let mut pendulum = SpringPendulum::new(1.0, 1.0, 10.0, 9.81)?;
//! let method = Method::Newmark(newmark::Options::new(1e-3));
//! let (q0, v0) = ([-0.7, 0.5], [0.0, 0.0]);
//! let motion = simulate(pendulum.clone(), (0.0, 1.0), &q0, &v0, &method, None, &mut |_| Ok(()))?;
//! let balance = motion.balance(&mut pendulum).expect("no function of time that could fail");
//! assert!(balance.drift() < 1e-3);
//! # Ok::<(), lissom::error::InvalidInput>(())
//! ```

use crate::error::Interrupted;
use crate::model::{Energy, ForwardScratch, Model, rotation_vectors};
use crate::numerics::hermite::{Quintic, cubic};
use crate::numerics::tape::Tape;

/// Relative change, with respect to the largest part, below which energies count as constant.
const ROUNDING: f64 = 1e3 * f64::EPSILON;

/// Nodes on [0, 1] and weights of the Gauss-Legendre formula of order 6.
const GAUSS: [(f64, f64); 3] =
    [(0.112_701_665_379_258_31, 5.0 / 18.0), (0.5, 8.0 / 18.0), (0.887_298_334_620_741_7, 5.0 / 18.0)];

/// Accumulated energy flows of a motion since its start, in joules, at each of its times. A vector is empty
/// if the model has no such flow.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Flow {
    /// Energy dissipated by damping and by impacts of inextensible tendons.
    pub dissipated: Vec<f64>,
    /// Work of loads without a potential, such as moments of fixed direction.
    pub work: Vec<f64>,
}

/// A part of a step resolves a power if its mean differs from the value in the middle by at most this part of the largest power so far: an
/// oscillation by 2.6 rad, which the formula of order 6 integrates to 2e-4.
const RESOLVED_DIFFERENCE: f64 = 0.25;

/// Maximum number of halvings of a step for its powers: steps of methods of high order may contain many periods of a prescribed motion
/// that moves nothing else.
const MOST_HALVINGS: usize = 8;

/// Energies in joules at each time of a motion.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Balance {
    /// Energies of the states.
    pub energies: Vec<Energy>,
    /// Energy dissipated by damping so far.
    pub dissipated: Vec<f64>,
    /// Work of loads without a potential so far.
    pub work: Vec<f64>,
}

impl Balance {
    /// Computes the balance of a motion with the states (q, v), n numbers each, for given inputs and flows.
    /// Evaluates the energy once per state.
    pub fn new<M: Model + ?Sized>(
        model: &mut M,
        t: &[f64],
        q: &[f64],
        v: &[f64],
        u: &[f64],
        flow: &Flow,
    ) -> Result<Self, Interrupted> {
        let n = model.facts().n;
        let inputs = u.len() / t.len().max(1);
        let energies = (0..t.len()).map(|i| {
            if inputs > 0 {
                model.set_inputs(&u[i * inputs..][..inputs]);
            }
            model.set_time(t[i])?;
            Ok(model.energy(&q[i * n..][..n], &v[i * n..][..n]))
        });
        let energies = energies.collect::<Result<Vec<Energy>, Interrupted>>()?;
        let flow_of = |flow: &[f64]| if flow.is_empty() { vec![0.0; energies.len()] } else { flow.to_vec() };
        Ok(Self { dissipated: flow_of(&flow.dissipated), work: flow_of(&flow.work), energies })
    }

    /// Kinetic + elastic + gravitational + loads + dissipated - work, at each time: constant for an exact
    /// motion.
    pub fn total(&self) -> Vec<f64> {
        let flows = self.dissipated.iter().zip(&self.work);
        self.energies.iter().zip(flows).map(|(energy, (out, work))| energy.total() + out - work).collect()
    }

    /// Energy scale in joules: the largest kinetic energy, or the largest range of another part.
    pub fn scale(&self) -> f64 {
        let parts: [&dyn Fn(usize) -> f64; 5] = [
            &|i| self.energies[i].elastic,
            &|i| self.energies[i].gravitational,
            &|i| self.energies[i].loads,
            &|i| self.dissipated[i],
            &|i| self.work[i],
        ];
        let range = |part: &dyn Fn(usize) -> f64| {
            let values = || (0..self.energies.len()).map(part);
            // A motion without times has no energies to compare.
            if self.energies.is_empty() { 0.0 } else { largest(values()) + largest(values().map(|x| -x)) }
        };
        let kinetic = self.energies.iter().map(|energy| energy.kinetic.abs());
        largest(parts.into_iter().map(range).chain(kinetic).chain([0.0]))
    }

    /// False if all changes of the energies are rounding errors. NaN counts as a change.
    pub fn moves(&self) -> bool {
        let size = |energy: &Energy| {
            [energy.kinetic, energy.elastic, energy.gravitational, energy.loads].map(f64::abs)
        };
        let rounding = ROUNDING * largest(self.energies.iter().flat_map(size).chain([0.0]));
        let scale = self.scale();
        !scale.is_finite() || !rounding.is_finite() || scale > rounding
    }

    /// Largest change of the total, relative to [`Balance::scale`]; zero if nothing moved, NaN if an energy
    /// is not finite.
    pub fn drift(&self) -> f64 {
        let total = self.total();
        let Some(first) = total.first().filter(|_| self.moves()) else { return 0.0 };
        largest(total.iter().map(|value| (value - first).abs())) / self.scale()
    }
}

/// Weights of the integral from 0 to `x` of the polynomial through values at 0, at the nodes of Gauss and at 1.
fn weights_up_to(x: f64) -> [f64; 5] {
    // Integrals of the Lagrange polynomials in s = 2 x - 1, with nodes at -1, -g, 0, g and 1.
    let (s, g) = (2.0 * x - 1.0, 0.6_f64.sqrt());
    let power = |k: i32| 0.5 * (s.powi(k + 1) - (-1.0_f64).powi(k + 1)) / f64::from(k + 1);
    let [zeroth, linear, square, cubic, fourth] = [0, 1, 2, 3, 4].map(power);
    let at_end = |side: f64| (fourth + side * cubic - 0.6 * square - side * 0.6 * linear) / 0.8;
    let at_node = |side: f64| (fourth + side * g * cubic - square - side * g * linear) / -0.48;
    let in_middle = (fourth - 1.6 * square + 0.6 * zeroth) / 0.6;
    [at_end(-1.0), at_node(-1.0), in_middle, at_node(1.0), at_end(1.0)]
}

fn mean((before, after): (&f64, &f64)) -> f64 {
    0.5 * (before + after)
}

/// Mean velocity between two places within `h`; the mean of the velocities at both ends if the step is so short that both agree to
/// rounding of the places.
fn mean_velocity(places: (&f64, &f64), rates: (&f64, &f64), h: f64) -> f64 {
    let (way, by_rates) = (places.1 - places.0, mean(rates));
    let rounding = f64::EPSILON * (places.0.abs() + places.1.abs());
    if (way - h * by_rates).abs() <= rounding { by_rates } else { way / h }
}

/// Maximum of the values; NaN if one of them is NaN, which `f64::max` would ignore.
fn largest(values: impl Iterator<Item = f64>) -> f64 {
    values.fold(f64::NEG_INFINITY, |most, value| if most >= value || most.is_nan() { most } else { value })
}

/// How flows are integrated over a step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Rule {
    /// One evaluation of the power, in the mean of the shapes at both ends of the step and with the mean velocity between them; if loads
    /// vary in time, the mean of the powers at the times of both ends. For the average-acceleration rule without varying loads,
    /// the balance of a linear system is then exact. With one-sided constraints always the powers at both
    /// ends, where the constraints hold.
    Mean,
    /// Gauss-Legendre with three evaluations along the quintic polynomial through the states at both ends: order 5. Steps in which powers
    /// oscillate are halved repeatedly.
    Quintic,
}

/// State of a motion at a time.
#[derive(Clone, Copy, Debug)]
pub(crate) struct State<'a> {
    pub(crate) t: f64,
    pub(crate) q: &'a [f64],
    pub(crate) v: &'a [f64],
    pub(crate) a: &'a [f64],
}

/// Integrates dissipated power and power of loads along a motion, step by step. Skips flows that the model
/// lacks.
#[derive(Clone, Debug)]
pub(crate) struct FlowMeter<'a> {
    is_damped: bool,
    is_driven: bool,
    rule: Rule,
    /// Fractions of a step at which powers are evaluated, with their weights, and whether these are only its ends.
    parts: &'static [(f64, f64)],
    is_at_ends: bool,
    t_eval: Option<&'a [f64]>,
    t: f64,
    q: Vec<f64>,
    v: Vec<f64>,
    a: Vec<f64>,
    q_between: Vec<f64>,
    v_between: Vec<f64>,
    a_between: Vec<f64>,
    /// Dissipated energy and work so far.
    total: [f64; 2],
    /// Bound of the error of the work: the change of the power between successive evaluations, times their distances.
    uncertain: f64,
    power: f64,
    /// Whether surfaces may touch at the start of the step, and whether they may at neither end: the equations of a step then have no contact
    /// forces.
    was_near: bool,
    is_apart: bool,
    /// The largest powers so far.
    largest: [f64; 2],
    flow: Flow,
}

impl<'a> FlowMeter<'a> {
    /// Creates a meter at the start `t0` of a motion that records the flow at the times `t_eval`, or after
    /// every step; `None` for a model without flows.
    pub(crate) fn new<M: Model + ?Sized>(
        model: &mut M,
        rule: Rule,
        t0: f64,
        [q0, v0]: [&[f64]; 2],
        t_eval: Option<&'a [f64]>,
    ) -> Option<Self> {
        let has_impacts = model.facts().is_one_sided;
        let (is_damped, is_driven) = (model.facts().is_damped || has_impacts, model.facts().is_driven);
        if !is_damped && !is_driven {
            return None;
        }
        // Between the ends of a step an inextensible tendon does not have its commanded length.
        let is_at_ends = rule == Rule::Mean && model.facts().is_one_sided;
        let parts: &[(f64, f64)] = match rule {
            Rule::Mean if is_at_ends || model.facts().varies_in_time => &[(0.0, 0.5), (1.0, 0.5)],
            Rule::Mean => &[(0.5, 1.0)],
            Rule::Quintic => &GAUSS,
        };
        let n = model.facts().n;
        let mut a = vec![0.0; n];
        if rule == Rule::Quintic || model.facts().varies_in_time {
            // If loads or accelerations cannot be evaluated, the run takes no step, and the meter is not
            // used.
            if model.set_time(t0).is_ok() {
                let _ = model.forward_dynamics(q0, v0, &mut a, &mut ForwardScratch::new(n));
            }
        }
        let [q_between, v_between, a_between] = [(); 3].map(|()| vec![0.0; n]);
        let mut meter = Self {
            is_damped,
            is_driven,
            rule,
            parts,
            is_at_ends,
            t_eval,
            t: t0,
            q: q0.to_vec(),
            v: v0.to_vec(),
            a,
            q_between,
            v_between,
            a_between,
            total: [0.0; 2],
            uncertain: 0.0,
            power: 0.0,
            was_near: true,
            is_apart: false,
            largest: [0.0; 2],
            flow: Flow::default(),
        };
        let points = t_eval.map_or(0, <[f64]>::len);
        meter.flow.dissipated.reserve(points);
        meter.flow.work.reserve(points);
        if t_eval.is_none_or(|times| times.first() == Some(&t0)) {
            meter.record([0.0; 2]);
        }
        Some(meter)
    }

    /// A meter that only measures the work of loads, and records nothing.
    pub(crate) fn of_supply<M: Model + ?Sized>(model: &mut M, t0: f64, start: [&[f64]; 2]) -> Option<Self> {
        if !model.facts().is_driven {
            return None;
        }
        Self::new(model, Rule::Mean, t0, start, Some(&[])).map(|meter| Self { is_damped: false, ..meter })
    }

    /// Integrates over an accepted step to this state, the last one that the model has evaluated.
    pub(crate) fn step<M: Model + ?Sized>(
        &mut self,
        model: &mut M,
        state: State<'_>,
    ) -> Result<(), Interrupted> {
        self.step_that_loses(model, state, None)
    }

    /// The same; at least what energies lose over the step, if that is given, is dissipated or work.
    fn step_that_loses<M: Model + ?Sized>(
        &mut self,
        model: &mut M,
        state: State<'_>,
        lost: Option<f64>,
    ) -> Result<(), Interrupted> {
        let before = self.total;
        let is_near = model.facts().has_contact && model.may_touch();
        self.is_apart = self.is_damped
            && model.facts().has_contact
            && self.rule == Rule::Mean
            && !is_near
            && !self.was_near;
        self.was_near = is_near;
        self.add_step(model, &state, self.rule)?;
        if let Some(lost) = lost {
            let [dissipated, work] = [0, 1].map(|i| self.total[i] - before[i]);
            self.total[0] += (lost + work - dissipated).max(0.0);
        }
        match self.t_eval {
            None => self.record(self.total),
            Some(times) => self.record_up_to(model, times, &state, before)?,
        }
        self.begin_at(state);
        Ok(())
    }

    /// The same over a step after a jump. Of a damped model, what energies lose beyond counts as dissipated: the step removes what the jump excites
    /// and damping consumes within the step.
    pub(crate) fn step_after_jump<M: Model + ?Sized>(
        &mut self,
        model: &mut M,
        state: State<'_>,
    ) -> Result<(), Interrupted> {
        if !self.is_damped {
            return self.step(model, state);
        }
        let mut lost = 0.0;
        for (t, [q, v], sign) in [(self.t, [&self.q[..], &self.v], 1.0), (state.t, [state.q, state.v], -1.0)]
        {
            model.set_time(t)?;
            lost += sign * model.energy(q, v).total();
        }
        self.step_that_loses(model, state, Some(lost))
    }

    /// The same over a step that consists of these, each from one state to the next, along the quintic polynomials through both.
    pub(crate) fn steps<'b, M: Model + ?Sized>(
        &mut self,
        model: &mut M,
        steps: impl Iterator<Item = [State<'b>; 2]>,
    ) -> Result<(), Interrupted> {
        (self.was_near, self.is_apart) = (true, false);
        for [start, end] in steps {
            self.begin_at(start);
            let before = self.total;
            self.add_step(model, &end, Rule::Quintic)?;
            if let Some(times) = self.t_eval {
                self.record_up_to(model, times, &end, before)?;
            }
            self.begin_at(end);
        }
        if self.t_eval.is_none() {
            self.record(self.total);
        }
        Ok(())
    }

    /// Adds what flows in the step to this state.
    fn add_step<M: Model + ?Sized>(
        &mut self,
        model: &mut M,
        state: &State<'_>,
        rule: Rule,
    ) -> Result<(), Interrupted> {
        // Express the start of the step in the rotation vectors of its end.
        rotation_vectors::wrap(&model.facts().rotation_vectors, &mut self.q, &mut self.v, &mut [&mut self.a]);
        let h = state.t - self.t;
        if h == 0.0 {
            // A step that was followed otherwise has its flow at once.
            [_, self.power] = self.powers(model, state.t, [state.q, state.v, state.a])?;
        } else if rule == Rule::Quintic {
            self.over_part(model, state, [0.0, 1.0], MOST_HALVINGS)?;
        } else {
            for &(x, weight) in self.parts {
                self.place_by_mean(state, x);
                let powers = self.powers_at(model, self.t + x * h)?;
                self.add(powers, h * weight);
            }
        }
        Ok(())
    }

    /// The next step begins here.
    fn begin_at(&mut self, state: State<'_>) {
        self.t = state.t;
        // As it is written now: rotation vectors may have changed.
        self.q.copy_from_slice(state.q);
        self.v.copy_from_slice(state.v);
        self.a.copy_from_slice(state.a);
    }

    /// Integrates over the part of a step between these fractions of it, in halves if powers oscillate within it.
    fn over_part<M: Model + ?Sized>(
        &mut self,
        model: &mut M,
        state: &State<'_>,
        [from, to]: [f64; 2],
        halvings: usize,
    ) -> Result<(), Interrupted> {
        let (t, h) = (self.t, state.t - self.t);
        let mut powers = [[0.0; 2]; GAUSS.len()];
        for ((x, _), powers) in GAUSS.iter().zip(&mut powers) {
            let x = from + (to - from) * x;
            self.place(state, x);
            *powers = self.powers_at(model, t + x * h)?;
        }
        let is_resolved = (0..2).all(|kind| {
            let here = || powers.iter().map(|powers| powers[kind]);
            let largest = here().fold(self.largest[kind], |most, power| most.max(power.abs()));
            self.largest[kind] = largest;
            let mean: f64 = here().zip(GAUSS).map(|(power, (_, weight))| weight * power).sum();
            let [_, middle, _] = powers;
            // Powers that are not finite count as resolved: halving would not help.
            let swings = (mean - middle[kind]).abs() > RESOLVED_DIFFERENCE * largest;
            !swings
        });
        if is_resolved || halvings == 0 {
            self.record_within(model, state, [from, to], powers)?;
            for ((_, weight), powers) in GAUSS.into_iter().zip(powers) {
                self.add(powers, h * (to - from) * weight);
            }
            return Ok(());
        }
        let middle = 0.5 * (from + to);
        self.over_part(model, state, [from, middle], halvings - 1)?;
        self.over_part(model, state, [middle, to], halvings - 1)
    }

    /// Records the requested times before the end of a part of a step, given the powers at the Gauss nodes: the flow so far plus the
    /// integral of the polynomial through these powers and those at both ends. At the end this agrees with the Gauss formula.
    fn record_within<M: Model + ?Sized>(
        &mut self,
        model: &mut M,
        state: &State<'_>,
        [from, to]: [f64; 2],
        [first, middle, last]: [[f64; 2]; GAUSS.len()],
    ) -> Result<(), Interrupted> {
        let Some(times) = self.t_eval else { return Ok(()) };
        let (t, h) = (self.t, state.t - self.t);
        let end = if to < 1.0 { t + to * h } else { state.t };
        let mut ends = None;
        while let Some(&time) = times.get(self.flow.dissipated.len().max(self.flow.work.len()))
            && time < end
        {
            let [start, stop] = match ends {
                Some(known) => known,
                None => {
                    let mut found = [[0.0; 2]; 2];
                    for (x, powers) in [from, to].into_iter().zip(&mut found) {
                        self.place(state, x);
                        *powers = self.powers_at(model, t + x * h)?;
                    }
                    *ends.insert(found)
                }
            };
            let weights = weights_up_to(((time - t) / h - from) / (to - from));
            let powers = [start, first, middle, last, stop];
            self.record(std::array::from_fn(|kind| {
                let mean: f64 =
                    weights.iter().zip(&powers).map(|(weight, powers)| weight * powers[kind]).sum();
                self.total[kind] + h * (to - from) * mean
            }));
        }
        Ok(())
    }

    /// Finds the motion at the fraction `x` of the step to this state by the rule of means.
    fn place_by_mean(&mut self, state: &State<'_>, x: f64) {
        let h = state.t - self.t;
        if self.is_at_ends {
            let end = if x == 0.0 { [&self.q[..], &self.v, &self.a] } else { [state.q, state.v, state.a] };
            let between = [&mut self.q_between, &mut self.v_between, &mut self.a_between];
            between.into_iter().zip(end).for_each(|(between, end)| between.copy_from_slice(end));
        } else {
            let places = self.q.iter().zip(state.q);
            let rates = self.v.iter().zip(state.v);
            for ((q, v), (places, rates)) in
                self.q_between.iter_mut().zip(&mut self.v_between).zip(places.zip(rates))
            {
                *q = mean(places);
                *v = mean_velocity(places, rates, h);
            }
            for (a, ends) in self.a_between.iter_mut().zip(self.a.iter().zip(state.a)) {
                *a = mean(ends);
            }
        }
    }

    /// The same on the quintic polynomial through both ends of the step.
    fn place(&mut self, state: &State<'_>, x: f64) {
        let quintic = Quintic::at(x, state.t - self.t);
        for i in 0..self.q.len() {
            let start = [self.q[i], self.v[i], self.a[i]];
            let [q, v, a] = quintic.motion(start, [state.q[i], state.v[i], state.a[i]]);
            (self.q_between[i], self.v_between[i], self.a_between[i]) = (q, v, a);
        }
    }

    fn powers_at<M: Model + ?Sized>(&self, model: &mut M, t: f64) -> Result<[f64; 2], Interrupted> {
        self.powers(model, t, [&self.q_between, &self.v_between, &self.a_between])
    }

    /// Adds the energies of these powers over this time.
    fn add(&mut self, powers: [f64; 2], time: f64) {
        for (total, power) in self.total.iter_mut().zip(powers) {
            *total += time * power;
        }
        let [_, power] = powers;
        self.uncertain += time * (power - std::mem::replace(&mut self.power, power)).abs();
    }

    /// Takes note of a jump, of inputs or by an impact, or of a step that was followed otherwise: accelerations have jumped, and
    /// energies by what was dissipated and by this work.
    pub(crate) fn jump(&mut self, state: State<'_>, [dissipated, work]: [f64; 2]) {
        self.begin_at(state);
        self.total[0] += dissipated;
        self.total[1] += work;
    }

    /// Upper bound of the energy supplied by loads so far.
    pub(crate) fn supplied(&self) -> f64 {
        self.total[1] + self.uncertain
    }

    /// Serialises the data of a meter that records nothing.
    pub(crate) fn serialise(&mut self, tape: &mut Tape<'_>) {
        let Self { t, q, v, a, total, uncertain, power, .. } = self;
        [t, uncertain, power].into_iter().for_each(|number| tape.number(number));
        [&mut q[..], v, a, total].into_iter().for_each(|numbers| tape.numbers(numbers));
    }

    /// Flow at the first `points` of the requested times.
    pub(crate) fn into_flow(mut self, points: usize) -> Flow {
        // A run stopped during the integration over its last step has no entry for that step.
        let flows = [
            (self.is_damped, &mut self.flow.dissipated, self.total[0]),
            (self.is_driven, &mut self.flow.work, self.total[1]),
        ];
        for (_, flow, total) in flows.into_iter().filter(|(is_there, ..)| *is_there) {
            flow.resize(points, total);
        }
        self.flow
    }

    /// Dissipated power and power of loads without a potential, in watts.
    fn powers<M: Model + ?Sized>(
        &self,
        model: &mut M,
        t: f64,
        [q, v, a]: [&[f64]; 3],
    ) -> Result<[f64; 2], Interrupted> {
        model.set_time(t)?;
        if self.is_apart {
            model.leave_contact(true);
        }
        let dissipated = if self.is_damped { model.dissipated_power(q, v) } else { 0.0 };
        if self.is_apart {
            model.leave_contact(false);
        }
        let supplied = if self.is_driven { model.supplied_power(q, v, a) } else { 0.0 };
        Ok([dissipated, supplied])
    }

    fn record(&mut self, total: [f64; 2]) {
        if self.is_damped {
            self.flow.dissipated.push(total[0]);
        }
        if self.is_driven {
            self.flow.work.push(total[1]);
        }
    }

    /// Records the requested times up to the end of the step to `state` that are not recorded yet, by cubic interpolation of energies
    /// and powers.
    fn record_up_to<M: Model + ?Sized>(
        &mut self,
        model: &mut M,
        times: &[f64],
        state: &State<'_>,
        before: [f64; 2],
    ) -> Result<(), Interrupted> {
        let mut powers = None;
        let recorded = |meter: &Self| meter.flow.dissipated.len().max(meter.flow.work.len());
        while let Some(&t) = times.get(recorded(self))
            && t <= state.t
        {
            // A step that was followed otherwise has its flow at once.
            if t == state.t || self.t == state.t {
                self.record(self.total);
                continue;
            }
            let [start, end] = match powers {
                Some(known) => known,
                None => *powers.insert([
                    self.powers(model, self.t, [&self.q, &self.v, &self.a])?,
                    self.powers(model, state.t, [state.q, state.v, state.a])?,
                ]),
            };
            let h = state.t - self.t;
            let x = (t - self.t) / h;
            let total = self.total;
            self.record(std::array::from_fn(|i| cubic(x, h, [before[i], total[i]], [start[i], end[i]])));
        }
        Ok(())
    }
}
