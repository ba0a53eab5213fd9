//! Detects energy that fixed steps add to a motion, or remove from it. An exact motion gains energy only from loads, and loses it only
//! by dissipation; other changes show that steps are too long, such as for a free body that turns by a radian in one step. The work of
//! loads is taken into account, with its uncertainty.

use crate::error::{Interrupted, Number};
use crate::integrators::newmark::Scheme;
use crate::model::{Energy, Model};
use crate::numerics::tape::Tape;
use crate::simulation::balance::State;

/// Energies above the initial one by this part of the largest kinetic energy cause a warning: errors of speeds of half a percent.
const ENERGY_GAIN: f64 = 1e-2;

/// So do rises by this part after losses. In an impact of six steps a body loses 28 percent and regains 2.5 percent as it separates.
const ENERGY_RISE: f64 = 3e-2;

/// So do losses by this part in models without dissipation.
const ENERGY_LOSS: f64 = 3e-2;

/// The same for contact of rigid shapes, where steps may stop impacts that they do not resolve.
const LOSS_IN_CONTACT: f64 = 0.25;

/// Changes must also exceed this part of the elastic energy, including that of contact: models nearly at rest vibrate by less
/// than a hundredth of their deformation, and their kinetic energy is no measure.
const AT_REST: f64 = 1e-4;

/// The same for potential energies of loads, whose origin is arbitrary, and for the energy of uniform motions: errors of Newton's method
/// are far smaller.
const ROUNDING: f64 = 1e-9;

/// Changes must also exceed the energy of errors of coordinates of this part of their typical sizes: rounding makes robots that cannot
/// move, and closed loops without forces, vibrate from step to step.
const ROUNDING_OF_PLACES: f64 = 1e-12;

/// Changes by more than this factor of the largest kinetic energy are reported in joules.
const REPORTED_IN_JOULES: f64 = 100.0;

/// A part whose velocities have changed by less than this, relative to themselves, moves uniformly: it exchanges no energy.
const UNIFORM_VELOCITY: f64 = 1e-6;

/// Number of steps between evaluations of the energy while nothing can touch: the cheapest steps cost as much as four evaluations.
const STEPS_PER_EVALUATION: usize = 8;

/// Number of evaluations for which a rise must last in a model with contact: within an impact the energy rises and falls again,
/// because a step samples the overlap at its end only.
const EVALUATIONS_OF_A_RISE: usize = 3;

/// The energy over a run with fixed steps.
#[derive(Clone, Debug)]
pub(super) struct EnergyWatch {
    dt: f64,
    /// Upper bound of the energy supplied by loads so far.
    supplied: f64,
    /// Steps until the next evaluation.
    left: usize,
    /// Whether loads vary in time.
    varies: bool,
    /// Whether something may supply energy: loads, motors, inputs.
    is_driven: bool,
    /// Whether neither the model nor the method dissipates energy.
    keeps_energy: bool,
    /// Whether the model dissipates no energy, and only rigid shapes touch.
    keeps_in_contact: bool,
    /// Whether surfaces may touch; steps in which they do are all examined.
    has_contact: bool,
    /// The last energies, as many as a rise must last.
    last: Vec<f64>,
    start: f64,
    /// The largest rise above the start, and the largest loss since the start with its time.
    gain: f64,
    loss: (f64, f64),
    /// The lowest energy so far and its time.
    lowest: (f64, f64),
    /// The largest rise above the lowest energy before it, and when it began and ended.
    rise: f64,
    during: (f64, f64),
    /// The largest energies so far; the kinetic one without parts that move uniformly.
    largest: Energy,
    /// The largest kinetic energy of all parts so far.
    of_all: f64,
    /// Velocities at the start if the model has several independent parts, and work memory.
    began: Vec<f64>,
    moving: Vec<f64>,
}

impl EnergyWatch {
    /// For a run by this scheme with steps of the size `dt`. `None` for models with a moving base or prescribed coordinates: their power
    /// is known at the ends of steps only, where it may be far larger than the energies.
    pub(super) fn new<M: Model>(
        model: &mut M,
        State { t: t0, q, v, .. }: State<'_>,
        scheme: Scheme,
        dt: f64,
    ) -> Option<Self> {
        if model.facts().is_carried {
            return None;
        }
        let has_contact = model.facts().has_contact;
        let varies = model.facts().varies_in_time;
        if varies && model.set_time(t0).is_err() {
            return None;
        }
        let is_driven = model.facts().is_driven || varies || model.facts().inputs() > 0;
        let is_free = !model.facts().is_damped && !model.facts().is_one_sided && !is_driven;
        let lasting = if has_contact { EVALUATIONS_OF_A_RISE } else { 1 };
        let mut largest = model.energy(q, v);
        let (start, of_all) = (largest.total(), largest.kinetic);
        let began = if model.facts().parts.len() > 1 { v.to_vec() } else { Vec::new() };
        if !began.is_empty() {
            // Parts that do not move uniformly are included later.
            largest.kinetic = 0.0;
        }
        Some(Self {
            dt,
            supplied: 0.0,
            left: STEPS_PER_EVALUATION,
            varies,
            is_driven,
            keeps_energy: is_free && !has_contact && scheme == Scheme::AVERAGE_ACCELERATION,
            keeps_in_contact: is_free && has_contact && !model.facts().has_rods_in_contact,
            has_contact,
            last: vec![start; lasting],
            start,
            gain: 0.0,
            loss: (0.0, t0),
            lowest: (start, t0),
            rise: 0.0,
            during: (t0, t0),
            largest,
            of_all,
            moving: Vec::with_capacity(began.len()),
            began,
        })
    }

    /// Examines the state after a step if its turn has come. `supplied` is an upper bound of the energy supplied by loads.
    pub(super) fn step<M: Model>(
        &mut self,
        model: &mut M,
        state: State<'_>,
        supplied: f64,
    ) -> Result<(), Interrupted> {
        self.supplied = supplied;
        self.left -= 1;
        if self.left > 0 && !(self.has_contact && model.may_touch()) {
            return Ok(());
        }
        self.left = STEPS_PER_EVALUATION;
        self.record_energy(model, state)
    }

    fn record_energy<M: Model>(
        &mut self,
        model: &mut M,
        State { t, q, v, .. }: State<'_>,
    ) -> Result<(), Interrupted> {
        if self.varies {
            model.set_time(t)?;
        }
        let energy = model.energy(q, v);
        let total = energy.total() - self.supplied;
        let of_changing = self.kinetic(model, [q, v], energy.kinetic);
        self.of_all = self.of_all.max(energy.kinetic);
        let Energy { kinetic, elastic, gravitational, loads } = &mut self.largest;
        let parts = [(kinetic, of_changing), (elastic, energy.elastic)];
        let of_loads = [(gravitational, energy.gravitational), (loads, energy.loads)];
        parts.into_iter().chain(of_loads).for_each(|(most, part)| *most = most.max(part.abs()));
        self.last.rotate_left(1);
        *self.last.last_mut().expect("as many as a rise must last") = total;
        let lasting = self.last.iter().copied().fold(f64::INFINITY, f64::min);
        self.gain = self.gain.max(lasting - self.start);
        if self.start - total > self.loss.0 {
            self.loss = (self.start - total, t);
        }
        if total < self.lowest.0 {
            self.lowest = (total, t);
        } else if lasting - self.lowest.0 > self.rise {
            (self.rise, self.during) = (lasting - self.lowest.0, (self.lowest.1, t));
        }
        Ok(())
    }

    /// The kinetic energy of the parts whose velocities have changed since the start, now or at the start, whichever is larger; `whole` is
    /// that of all parts.
    fn kinetic<M: Model>(&mut self, model: &mut M, [q, v]: [&[f64]; 2], whole: f64) -> f64 {
        let Self { began, moving, .. } = self;
        if began.iter().all(|&v| v == 0.0) {
            return whole;
        }
        let mut most: f64 = 0.0;
        for velocities in [v, &began[..]] {
            moving.clear();
            for &size in &model.facts().parts {
                let part = moving.len()..moving.len() + size;
                let mut pairs = v[part.clone()].iter().zip(&began[part.clone()]);
                let is_uniform = pairs.all(|(now, then)| (now - then).abs() <= UNIFORM_VELOCITY * then.abs());
                moving.extend(velocities[part].iter().map(|&v| if is_uniform { 0.0 } else { v }));
            }
            if moving == v {
                return whole;
            }
            most = most.max(model.energy(q, moving).kinetic);
        }
        most
    }

    /// A warning if the energy has changed, the state being the last one.
    pub(super) fn verdict<M: Model>(&self, model: &mut M, end: State<'_>) -> Option<String> {
        let mut watch = self.clone();
        watch.record_energy(model, end).ok()?;
        watch.found(model, end)
    }

    /// A warning if much of it has gone where rigid shapes meet, though nothing dissipates any, whatever steps have seen of impacts.
    pub(super) fn loss_in_contact<M: Model>(&self, model: &mut M, end: State<'_>) -> Option<String> {
        let mut watch = self.clone();
        watch.record_energy(model, end).ok()?;
        let lost = watch.start - watch.last.last()?;
        let least = (LOSS_IN_CONTACT * watch.largest.kinetic).max(watch.rounding());
        (self.keeps_in_contact && lost > least).then(|| {
            format!(
                "The energy has fallen by {:.0} % of the largest kinetic energy, though nothing dissipates any: steps of {} s do not resolve \
                 all impacts. Take shorter steps, or method \"radau\" or \"auto\".",
                100.0 * lost / watch.largest.kinetic,
                Number(self.dt)
            )
        })
    }

    /// Changes of the energy that rounding explains.
    fn rounding(&self) -> f64 {
        let Self { largest, of_all, .. } = self;
        ROUNDING * (largest.gravitational + largest.loads + of_all)
    }

    fn found<M: Model>(self, model: &mut M, end: State<'_>) -> Option<String> {
        let rounding = self.rounding();
        let Self {
            keeps_energy, is_driven, gain, loss: (loss, at), rise, during: (from, to), largest, ..
        } = self;
        let hidden = (AT_REST * largest.elastic).max(rounding);
        let exceeds = |change: f64, part: f64| change > (part * largest.kinetic).max(hidden);
        let share = |change: f64| match change < REPORTED_IN_JOULES * largest.kinetic {
            true => format!("{:.1} % of the largest kinetic energy", 100.0 * change / largest.kinetic),
            false => format!("{change:.1e} J, far more than the largest kinetic energy"),
        };
        let found = if exceeds(gain, ENERGY_GAIN) || exceeds(rise, ENERGY_RISE) {
            // The potential of loads and motors is part of the energy.
            let but = match is_driven || largest.loads > 0.0 {
                true => "beyond what loads, motors and inputs supply",
                false => "though nothing supplies any",
            };
            format!("Between t = {from:.3} s and {to:.3} s the energy rises by {}, {but}", share(rise))
        } else if keeps_energy && exceeds(loss, ENERGY_LOSS) {
            format!("Until t = {at:.3} s the energy falls by {}, though nothing dissipates any", share(loss))
        } else {
            return None;
        };
        let change = gain.max(rise).max(if keeps_energy { loss } else { 0.0 });
        if change <= energy_of_rounding(model, end, self.dt) {
            return None;
        }
        Some(format!(
            "{found}: steps of {} s are too long for this motion. Take shorter steps, adaptive ones, or method \"auto\".",
            Number(self.dt)
        ))
    }

    /// Serialises all data that persist from step to step.
    pub(super) fn serialise(&mut self, tape: &mut Tape<'_>) {
        let Self { supplied, start, gain, loss, lowest, rise, during, largest, of_all, began, .. } = self;
        let Energy { kinetic, elastic, gravitational, loads } = largest;
        let pairs = [loss, lowest, during].into_iter().flat_map(|(a, b)| [a, b]);
        let numbers = [supplied, start, gain, rise, kinetic, elastic, gravitational, loads, of_all];
        numbers.into_iter().chain(pairs).for_each(|number| tape.number(number));
        tape.numbers(began);
        tape.numbers(&mut self.last);
        let mut made = STEPS_PER_EVALUATION - self.left;
        tape.below(STEPS_PER_EVALUATION, &mut made);
        self.left = STEPS_PER_EVALUATION - made;
    }
}

/// Change of the energy by rounding errors of coordinates, and the kinetic energy of such an error within one step. Allocates.
fn energy_of_rounding<M: Model>(model: &mut M, State { q, v, .. }: State<'_>, dt: f64) -> f64 {
    let mut by = model.facts().typical_coordinates.clone();
    by.iter_mut().for_each(|size| *size *= ROUNDING_OF_PLACES);
    let beside: Vec<f64> = q.iter().zip(&by).map(|(q, by)| q + by).collect();
    let of_places = (model.energy(&beside, v).total() - model.energy(q, v).total()).abs();
    by.iter_mut().for_each(|size| *size /= dt);
    of_places + model.energy(q, &by).kinetic
}
