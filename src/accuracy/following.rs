//! Vibrations that the steps have to follow, and how long steps may be that do.
//!
//! An implicit method that damps what it steps over says nothing about it: two runs that step over the same vibration
//! agree with each other, and not with the truth. What can be seen of the tip is followed from the start, therefore,
//! and the vibrations that can be are known beforehand: those that the start sets off, and those that loads and a
//! moving base do, by the linear response of each of them to what drives the model.

use std::f64::consts::E;

use super::drive::Drive;
use super::integrator::Integrator;
use crate::error::Interrupted;
use crate::model::Model;
use crate::spectrum::{Spectrum, Vibration};

/// Vibrations whose tip moves by less than this part of the tolerance need not be resolved.
const VISIBLE: f64 = 0.1;

/// Of the tolerance of a run each vibration gets this part.
const SHARE: f64 = 0.5;

/// The tip cannot be farther off than this, relative to the length.
const FARTHEST: f64 = 2.0;

/// Steps in each period of what is known to drive the model, at least.
const STEPS_OF_A_PERIOD: f64 = 4.0;

/// One vibration that is to be followed.
#[derive(Clone, Copy, Debug)]
struct Followed {
    /// In rad/s.
    frequency: f64,
    /// How far it moves the tip, relative to the length.
    reach: f64,
    /// Over how many radians its error adds up: of the whole time, or until it has died away.
    radians: f64,
}

/// What is to be followed.
#[derive(Clone, Debug)]
pub(super) struct Following {
    /// Those of each state that was looked at.
    vibrations: Vec<Vec<Followed>>,
    /// Longest step, in seconds, that passes over nothing that drives the model.
    of_drive: f64,
    /// The largest rate, in 1/s: an explicit method's estimate of its error lets longer steps than stable ones pass,
    /// which do harm in time.
    rate: f64,
    /// Tolerance of the first run.
    loosest: f64,
}

impl Following {
    /// Nothing.
    pub(super) fn nothing() -> Self {
        Self { vibrations: Vec::new(), of_drive: f64::INFINITY, rate: 0.0, loosest: 0.0 }
    }

    /// What the state `q0` sets off, with the vibrations about it, and what drives the model over `t_span`. `loosest`
    /// is the tolerance of the first run. `monitor` sees the start now and then and may stop it.
    pub(super) fn new<M: Model>(
        model: &mut M,
        t_span: (f64, f64),
        q0: &[f64],
        spectrum: &Spectrum,
        loosest: f64,
        monitor: &mut dyn FnMut(f64) -> Result<(), Interrupted>,
    ) -> Result<Self, Interrupted> {
        let mut of_drive = model.shortest_period() / STEPS_OF_A_PERIOD;
        let mut sizes: Vec<f64> = spectrum.modes.iter().map(|mode| mode.size).collect();
        if model.varies_in_time() {
            let drive = Drive::new(model, t_span, q0, spectrum, VISIBLE * loosest, monitor)?;
            for (size, driven) in sizes.iter_mut().zip(drive.sizes) {
                *size = size.max(driven);
            }
            of_drive = of_drive.min(drive.longest_step);
        }
        let mut following = Self { vibrations: Vec::new(), of_drive, rate: spectrum.rate(), loosest };
        following.add(model, t_span.1 - t_span.0, q0, spectrum, &sizes);
        Ok(following)
    }

    /// What a state on the way has set off.
    pub(super) fn look<M: Model>(&mut self, model: &mut M, t: f64, duration: f64, [q, v]: [&[f64]; 2]) {
        if let Some(spectrum) = Spectrum::new(model, t, q, v) {
            let sizes: Vec<f64> = spectrum.modes.iter().map(|mode| mode.size).collect();
            self.add(model, duration, q, &spectrum, &sizes);
        }
    }

    fn add<M: Model>(&mut self, model: &mut M, duration: f64, q: &[f64], spectrum: &Spectrum, sizes: &[f64]) {
        let oscillates =
            |(mode, size): &(&Vibration, &f64)| mode.frequency > 0.0 && **size > 0.0 && !mode.is_overdamped();
        let followed = spectrum.modes.iter().zip(sizes).filter(oscillates).map(|(mode, &size)| {
            let reach = (mode.reach(model, q, size) / model.length()).min(FARTHEST);
            let life = 2.0 / (E * mode.damping.abs());
            Followed {
                frequency: mode.frequency,
                reach,
                radians: (mode.frequency * duration.min(life)).max(1.0),
            }
        });
        self.vibrations.push(followed.collect());
    }

    /// What steps of this size leave of all vibrations together, relative to the length: of those that are stepped
    /// over all of it is lost, in every run alike.
    pub(super) fn lost(&self, integrator: &Integrator, step: f64) -> f64 {
        let part = |vibration: &Followed| {
            let of_a_radian = integrator.error_of_a_radian(vibration.frequency, step);
            vibration.reach * (vibration.radians * of_a_radian).min(1.0)
        };
        let of_state = |vibrations: &Vec<Followed>| vibrations.iter().map(part).sum();
        self.vibrations.iter().map(of_state).fold(0.0, f64::max)
    }

    /// The highest frequency, in rad/s, that is visible at this tolerance; zero if there is none.
    pub(super) fn highest(&self, tolerance: f64) -> f64 {
        self.visible(tolerance).map(|vibration| vibration.frequency).fold(0.0, f64::max)
    }

    /// The longest step, in seconds, with which no vibration leaves an error of more than its share of `tolerance`.
    pub(super) fn longest_step(&self, integrator: &Integrator, tolerance: f64) -> f64 {
        // Two runs must not have the same steps, whatever limits them: they would share the same errors.
        let shorter = integrator.shorter((tolerance / self.loosest).min(1.0));
        let of_vibration = |vibration: &Followed| {
            let allowed = SHARE * tolerance / (vibration.reach * vibration.radians);
            integrator.step_of_error(allowed).min(integrator.longest * shorter) / vibration.frequency
        };
        let of_all = self.of_drive.min(integrator.stability / self.rate) * shorter;
        self.visible(tolerance).map(of_vibration).fold(of_all, f64::min)
    }

    /// The same vibrations for all runs of a request, so that they can be compared.
    fn visible(&self, tolerance: f64) -> impl Iterator<Item = &Followed> {
        let visible = VISIBLE * tolerance.max(self.loosest);
        self.vibrations.iter().flatten().filter(move |vibration| vibration.reach > visible)
    }
}
