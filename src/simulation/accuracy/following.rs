//! Vibrations that steps must resolve, and the step sizes that resolve them.
//!
//! An implicit method damps vibrations that its steps do not resolve, without any sign in its error estimate:
//! two runs that both miss a vibration agree with each other, but not with the exact motion. Therefore
//! vibrations visible at the tip are resolved from the start. They are known beforehand: those excited by the
//! initial state, and those excited by loads and the base motion, by the linear response of each mode.

use std::f64::consts::E;

use super::drive::Drive;
use super::growth_resolution::GrowthResolution;
use super::inputs::Given;
use super::integrator::Integrator;
use crate::analysis::growing::{Growing, amplitude};
use crate::analysis::spectrum::{Spectrum, Vibration};
use crate::error::Interrupted;
use crate::model::{ForwardScratch, Model};
use crate::numerics::linalg::Matrix;

/// Changes of the excitation that move the tip by less than this fraction of what was asked need not be resolved.
const VISIBLE_CHANGE: f64 = 0.15;

/// Vibrations that together move the tip by less than this fraction of what was asked need not be resolved.
const NEGLECTED_MOTION: f64 = 0.25;

/// Fraction of what was asked that each vibration may use in the first run.
const ERROR_SHARE: f64 = 0.75;

/// Upper bound of the tip error, relative to the length.
const FARTHEST: f64 = 2.0;

/// Minimum number of steps per known period of the excitation.
const STEPS_OF_A_PERIOD: f64 = 4.0;

/// A vibration that must be resolved.
#[derive(Clone, Copy, Debug)]
struct Followed {
    /// Frequency in rad/s.
    frequency: f64,
    /// Amplitude at the tip, relative to the length.
    reach: f64,
    /// Radians over which its error accumulates: during the whole time, or until the vibration has decayed.
    radians: f64,
    /// Radians of the whole motion.
    angle: f64,
    /// Elastic part of the stiffness: what moves against weight or by inertia is not late if elastic stiffnesses are wrong.
    elastic_share: f64,
}

/// A state is near an equilibrium if all of its vibrations together move the tip by less than this part of the length.
const NEAR_EQUILIBRIUM: f64 = 0.1;

/// Vibrations to be resolved, and other limits of the step.
#[derive(Clone, Debug)]
pub(super) struct Following {
    /// Vibrations of each state examined so far.
    vibrations: Vec<Vec<Followed>>,
    /// What grows about the start.
    growths: Vec<GrowthResolution>,
    /// What grows fastest about each later state near an equilibrium.
    later: Vec<GrowthResolution>,
    /// Whether the motion begins near an equilibrium.
    begins_near: bool,
    /// Displacements that the start excites, with their speeds in 1/s.
    excited: Vec<(Vec<f64>, f64)>,
    /// Longest step, in seconds, that misses no feature of the excitation, if steps end at `ends`.
    of_drive: f64,
    pub(super) ends: Vec<f64>,
    /// Largest rate, in 1/s. The error estimate of an explicit method tolerates steps beyond the stability
    /// limit, which cause errors in the long run.
    rate: f64,
    /// Tolerance of the first run.
    loosest: f64,
    /// Requested accuracy.
    wanted: f64,
}

impl Following {
    /// No limits.
    pub(super) fn nothing() -> Self {
        Self {
            vibrations: Vec::new(),
            growths: Vec::new(),
            later: Vec::new(),
            begins_near: false,
            excited: Vec::new(),
            of_drive: f64::INFINITY,
            ends: Vec::new(),
            rate: 0.0,
            loosest: 0.0,
            wanted: 0.0,
        }
    }

    /// Vibrations about `q0` that the initial state and the excitation over `t_span` cause. `loosest` is the
    /// tolerance of the first run. `known` is what was found of a coarser model with the same excitation. `monitor` is called regularly
    /// with the start time and may stop the search.
    pub(super) fn new<M: Model>(
        model: &mut M,
        given: Given<'_>,
        spectrum: &Spectrum,
        [loosest, wanted]: [f64; 2],
        known: Option<&Self>,
        monitor: &mut dyn FnMut(f64) -> Result<(), Interrupted>,
    ) -> Result<Self, Interrupted> {
        let Given { t_span, start: [q0, v0], held, .. } = given;
        let mut of_drive = model.facts().shortest_period / STEPS_OF_A_PERIOD;
        let mut sizes: Vec<f64> = spectrum.modes.iter().map(|mode| mode.size).collect();
        let mut ends = Vec::new();
        let duration = t_span.1 - t_span.0;
        // What grows in a finer model does in the coarser one.
        let growing = match known {
            None => growing(model, t_span.0, [q0, v0], duration, spectrum),
            Some(_) => Vec::new(),
        };
        let mut seeds: Vec<f64> = growing.iter().map(|growing| growing.size).collect();
        if model.facts().varies_in_time || held.is_some() {
            if let Some(known) = known {
                model.end_steps_at(&known.ends);
            }
            let visible = (VISIBLE_CHANGE * wanted, known.is_none());
            let drive = Drive::new(model, given, (spectrum, &growing), visible, monitor)?;
            for (size, driven) in sizes.iter_mut().zip(drive.sizes) {
                *size = size.max(driven);
            }
            for (seed, grown) in seeds.iter_mut().zip(drive.grown) {
                *seed = seed.max(grown);
            }
            let found = (drive.longest_step, drive.ends);
            let (longest, at) = known.map_or(found, |known| (known.of_drive, known.ends.clone()));
            (of_drive, ends) = (of_drive.min(longest), at);
        }
        let rate = spectrum.rate();
        let mut following = Self { of_drive, ends, rate, loosest, wanted, ..Self::nothing() };
        following.begins_near = following.add(model, duration, q0, spectrum, &sizes);
        let growth =
            |(growing, &seed): (&Growing, &f64)| GrowthResolution::new(model, q0, growing, seed, duration);
        let found = growing.iter().zip(&seeds).map(growth);
        following.growths = known.map_or_else(|| found.collect(), |known| known.growths.clone());
        let of_vibrations = spectrum.modes.iter().zip(&sizes).filter(|(_, size)| **size > 0.0);
        following.excited =
            of_vibrations.map(|(mode, &size)| scaled(&mode.shape, size, mode.frequency)).collect();
        following
            .excited
            .extend(growing.iter().zip(seeds).map(|(one, seed)| scaled(&one.shape, seed, one.speed)));
        Ok(following)
    }

    /// Vibrations that the state `q0` contains, during this time, whatever excites others later.
    pub(super) fn of_start<M: Model>(
        model: &mut M,
        duration: f64,
        q0: &[f64],
        spectrum: &Spectrum,
        [loosest, wanted]: [f64; 2],
    ) -> Self {
        let of_drive = model.facts().shortest_period / STEPS_OF_A_PERIOD;
        let mut following = Self { of_drive, rate: spectrum.rate(), loosest, wanted, ..Self::nothing() };
        let sizes: Vec<f64> = spectrum.modes.iter().map(|mode| mode.size).collect();
        following.add(model, duration, q0, spectrum, &sizes);
        following
    }

    /// Adds the vibrations that a later state of the motion contains, and what grows from it within this time near an equilibrium.
    pub(super) fn add_state<M: Model>(
        &mut self,
        model: &mut M,
        t: f64,
        [duration, time]: [f64; 2],
        [q, v]: [&[f64]; 2],
    ) {
        let Some(spectrum) = Spectrum::fast(model, t, [q, v]) else { return };
        let sizes: Vec<f64> = spectrum.modes.iter().map(|mode| mode.size).collect();
        let is_near = self.add(model, duration, q, &spectrum, &sizes);
        if !is_near || time == 0.0 {
            return;
        }
        let growing = match spectrum.growing().is_empty() {
            true => Vec::new(),
            false => growing(model, t, [q, v], time, &spectrum),
        };
        let growths = growing.iter().map(|growing| {
            // What the start excites, and steps may have lost since.
            let parts =
                self.excited.iter().map(|(shape, speed)| (amplitude(&growing.of_places, shape), *speed));
            let parts: Vec<(f64, f64)> = parts.collect();
            let seed = parts.iter().map(|(size, _)| size).sum::<f64>().max(growing.size);
            let mut growth = GrowthResolution::new(model, q, growing, seed, time);
            for (size, speed) in parts {
                growth.follow_from(size / seed, speed, self.wanted);
            }
            growth
        });
        let growths: Vec<GrowthResolution> = growths.collect();
        self.later.extend(growths.into_iter().max_by(GrowthResolution::by_exponent));
    }

    /// Whether they are small.
    fn add<M: Model>(
        &mut self,
        model: &mut M,
        duration: f64,
        q: &[f64],
        spectrum: &Spectrum,
        sizes: &[f64],
    ) -> bool {
        let oscillates =
            |(mode, size): &(&Vibration, &f64)| mode.frequency > 0.0 && **size > 0.0 && !mode.is_overdamped();
        let mut elastic = Matrix::zeros(q.len(), q.len());
        model.elastic_tangent(q, &mut elastic);
        let followed = spectrum.modes.iter().zip(sizes).filter(oscillates).map(|(mode, &size)| {
            let reach = (mode.reach(model, q, size) / model.facts().length).min(FARTHEST);
            let life = 2.0 / (E * mode.damping.abs());
            Followed {
                frequency: mode.frequency,
                reach,
                radians: (mode.frequency * duration.min(life)).max(1.0),
                angle: mode.frequency * duration,
                elastic_share: mode.elastic(&elastic) / mode.frequency.powi(2),
            }
        });
        let followed: Vec<Followed> = followed.collect();
        let is_near = followed.iter().map(|vibration| vibration.reach).sum::<f64>() < NEAR_EQUILIBRIUM;
        self.vibrations.push(followed);
        is_near
    }

    /// A doubt about a motion that begins at an unstable equilibrium, or stays near one.
    pub(super) fn doubt(&self) -> Option<String> {
        let first =
            self.growths.iter().copied().max_by(GrowthResolution::by_exponent).filter(|_| self.begins_near);
        GrowthResolution::doubt(first.as_slice(), self.wanted)
            .or_else(|| GrowthResolution::doubt(&self.later, self.wanted))
    }

    fn growing(&self) -> impl Iterator<Item = &GrowthResolution> {
        self.growths.iter().chain(&self.later)
    }

    /// Error of all vibrations together for steps of this size, relative to the length. Unresolved vibrations
    /// are lost completely, in every run alike.
    pub(super) fn error_of_steps(&self, integrator: &Integrator, step: f64) -> f64 {
        let part = |vibration: &Followed| {
            let of_a_radian = integrator.error_of_a_radian(vibration.frequency, step);
            vibration.reach * (vibration.radians * of_a_radian).min(1.0)
        };
        let of_state = |vibrations: &Vec<Followed>| vibrations.iter().map(part).sum();
        let of_vibrations = self.vibrations.iter().map(of_state).fold(0.0, f64::max);
        self.growing().map(|growth| growth.error_of_steps(integrator, step)).fold(of_vibrations, f64::max)
    }

    /// Error of the tip, relative to the length, if the elastic part of the frequency of the largest vibration has this relative error, and
    /// the others are lost. `most` is the largest error of deflections.
    pub(super) fn late_at_most(&self, relative: f64, most: f64) -> f64 {
        let largest = |vibrations: &Vec<Followed>| {
            vibrations.iter().map(|vibration| vibration.reach).fold(0.0, f64::max)
        };
        let all =
            |vibrations: &Vec<Followed>| vibrations.iter().map(|vibration| vibration.reach).sum::<f64>();
        let others = self.vibrations.iter().map(|vibrations| all(vibrations) - largest(vibrations));
        let others = others.fold(0.0, f64::max).min(most);
        self.error_of_frequencies(relative, &[], most) + others
    }

    /// Error of the tip, relative to the length, if the elastic parts of all frequencies have this relative error, and vibrations with one of
    /// some `known` frequencies at least that which belongs to it. `most` is the largest error of deflections.
    pub(super) fn error_of_frequencies(&self, relative: f64, known: &[(f64, f64)], most: f64) -> f64 {
        let error_of = |frequency: f64| {
            let away = |(of, _): &&(f64, f64)| (of / frequency).ln().abs();
            known.iter().min_by(|a, b| away(a).total_cmp(&away(b))).map_or(0.0, |(_, error)| *error)
        };
        // Within less than a radian, the effect of a wrong frequency is of second order in the angle.
        let part = |vibration: &Followed| {
            let seen = vibration.angle.min(1.0).powi(2);
            let relative = (vibration.elastic_share * relative).max(error_of(vibration.frequency));
            vibration.reach * (vibration.radians * seen * relative).min(1.0)
        };
        let of_vibrations =
            self.vibrations.iter().map(|vibrations| vibrations.iter().map(part).sum()).fold(0.0, f64::max);
        let of_growth = self.growing().map(|growth| growth.error_of_frequencies(relative, most));
        of_growth.fold(of_vibrations.min(most), f64::max)
    }

    /// Highest visible frequency, in rad/s; zero if there is none.
    pub(super) fn highest(&self) -> f64 {
        let of_vibrations = self.visible().map(|vibration| vibration.frequency).fold(0.0, f64::max);
        self.growing().map(|growth| growth.visible_speed(self.wanted)).fold(of_vibrations, f64::max)
    }

    /// Step, in seconds, by which the local errors of all visible vibrations are within `tolerance`.
    pub(super) fn accurate_step(&self, integrator: &Integrator, tolerance: f64) -> f64 {
        let of_vibration = |vibration: &Followed| {
            integrator.step * integrator.shorter((tolerance / vibration.reach).min(1.0)) / vibration.frequency
        };
        self.visible().map(of_vibration).fold(f64::INFINITY, f64::min)
    }

    /// Longest step, in seconds, for which the error of each vibration stays within its share of `tolerance`.
    pub(super) fn longest_step(&self, integrator: &Integrator, tolerance: f64) -> f64 {
        // Two runs must not have the same steps, which would have the same errors: limits of the steps depend on the tolerance too.
        let shorter = integrator.shorter((tolerance / self.loosest).min(1.0));
        let of_vibration = |vibration: &Followed| {
            let allowed = ERROR_SHARE * self.wanted * (tolerance / self.loosest)
                / (vibration.reach * vibration.radians);
            integrator.step_of_error(allowed).min(integrator.longest * shorter) / vibration.frequency
        };
        let of_all = self.of_drive.min(integrator.stability / self.rate) * shorter;
        let tightening = tolerance / self.loosest;
        let of_growth = self.growing().map(|growth| growth.longest_step(integrator, self.wanted, tightening));
        self.visible().map(of_vibration).fold(of_growth.fold(of_all, f64::min), f64::min)
    }

    /// The same vibrations for all runs of a request, to make the runs comparable: of each state the largest ones. Those that
    /// together reach no farther than a part of what was asked need not be resolved.
    fn visible(&self) -> impl Iterator<Item = &Followed> {
        let visible = NEGLECTED_MOTION * self.wanted;
        self.vibrations.iter().flat_map(move |vibrations| {
            let mut sorted: Vec<&Followed> = vibrations.iter().collect();
            sorted.sort_by(|a, b| a.reach.total_cmp(&b.reach));
            let mut together = 0.0;
            sorted.into_iter().skip_while(move |vibration| {
                together += vibration.reach;
                together <= visible
            })
        })
    }
}

/// A displacement of this size along a shape, with its speed.
fn scaled(shape: &[f64], size: f64, speed: f64) -> (Vec<f64>, f64) {
    (shape.iter().map(|x| x * size).collect(), speed)
}

/// What grows from a state within this time: what grows at rest where it does not move, unless its accelerations prevent it, as those of
/// free fall do.
fn growing<M: Model>(
    model: &mut M,
    t: f64,
    [q, v]: [&[f64]; 2],
    time: f64,
    spectrum: &Spectrum,
) -> Vec<Growing> {
    let moves = v.iter().any(|v| *v != 0.0);
    if model.facts().constraints() > 0 {
        return spectrum.growing();
    }
    let at_rest = if moves { Vec::new() } else { spectrum.growing() };
    let mut a = vec![0.0; q.len()];
    let is_known = !moves && at_rest.is_empty()
        || model.set_time(t).is_err()
        || model.forward_dynamics(q, v, &mut a, &mut ForwardScratch::new(q.len())).is_err();
    if is_known {
        return at_rest;
    }
    let found = Growing::about(model, [q, v, &a], time);
    if moves || found.is_empty() { found } else { at_rest }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// One vibration of this frequency that lasts for a second.
    fn following(frequency: f64, reach: f64) -> Following {
        let radians = frequency.max(1.0);
        let vibration = Followed { frequency, reach, radians, angle: frequency, elastic_share: 1.0 };
        Following { vibrations: vec![vec![vibration]], wanted: 1e-3, loosest: 1.5e-3, ..Following::nothing() }
    }

    #[test]
    fn wrong_frequencies_are_late_by_at_least_what_they_change_of_a_vibration() {
        for frequency in [1e-3, 0.1, 0.9, 1.0, 3.0, 40.0] {
            for relative in [1e-3, 1e-2, 0.1] {
                let steps = 1000;
                let apart = (0..=steps).map(|i| {
                    let angle = frequency * f64::from(i) / f64::from(steps);
                    (((1.0 + relative) * angle).cos() - angle.cos()).abs()
                });
                let exact = apart.fold(0.0, f64::max);
                let estimated = following(frequency, 0.1).error_of_frequencies(relative, &[], f64::INFINITY);
                // Up to terms of second order in the relative change, and half the difference after the phase is lost.
                assert!(
                    estimated >= 0.1 * exact.min(1.0) / (1.0 + relative),
                    "{frequency} {relative}: {estimated} for {exact}"
                );
            }
        }
    }

    #[test]
    fn what_hardly_turns_is_not_late() {
        // A free body, whose frequencies are rounding.
        assert!(following(1e-6, FARTHEST).error_of_frequencies(0.5, &[], f64::INFINITY) < 1e-11);
    }

    #[test]
    fn what_is_late_is_at_most_the_error_of_deflections() {
        assert_eq!(following(40.0, 0.1).error_of_frequencies(0.5, &[], f64::INFINITY), 0.1);
        assert_eq!(following(40.0, 0.1).error_of_frequencies(0.5, &[], 1e-4), 1e-4);
    }

    #[test]
    fn a_vibration_is_as_late_as_its_own_frequency_is_wrong() {
        let errors = [(3.0, 1e-6), (40.0, 1e-3)];
        let of =
            |frequency: f64| following(frequency, 0.1).error_of_frequencies(1e-5, &errors, f64::INFINITY);
        assert!((of(3.0) / (0.1 * 3.0 * 1e-5) - 1.0).abs() < 1e-9);
        assert!((of(41.0) / (0.1 * 41.0 * 1e-3) - 1.0).abs() < 1e-9);
    }

    #[test]
    fn steps_of_a_vibration_have_the_error_that_the_first_run_may_have() {
        let following = following(40.0, 0.1);
        let step = following.longest_step(&super::super::integrator::RADAU, following.loosest);
        let lost = following.error_of_steps(&super::super::integrator::RADAU, step);
        assert!((lost / (ERROR_SHARE * following.wanted) - 1.0).abs() < 1e-9, "{lost}");
    }
}
