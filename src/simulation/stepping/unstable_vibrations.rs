//! Vibrations that grow from step to step in conditionally stable members of Newmark's family, because steps exceed the limit of
//! stability. The end of such a run is meaningless, however small its residuals.
//!
//! Whether a vibration grows follows from the spectral radius of its amplification matrix (Hughes 2000, section 9.1.2), at the start.
//! Whether it has grown shows in its modal acceleration at the end: at the limit of stability and beyond, it changes its sign with
//! each step, and the displacement is the acceleration times `(h / limit)^2`, damped or not. Nothing is computed between.

use crate::analysis::spectrum::{Spectrum, Vibration};
use crate::error::{Number, Time};
use crate::integrators::newmark::Scheme;
use crate::integrators::second_order;
use crate::model::Model;
use crate::numerics::linalg::dot;
use crate::numerics::tape::Tape;
use crate::simulation::balance::State;
use crate::simulation::stepping::{Status, Stop};

/// A vibration has grown if it moves the tip by this part of the length, or coordinates by their typical sizes.
const GROWN: f64 = 1e-2;

/// Vibrations that could have grown only by less than this factor since the start are attributed to the motion itself.
const LEAST_GROWTH: f64 = 100.0;

/// Displacements by which the motion of the tip is measured, relative to typical coordinates.
const SMALL: f64 = 1e-4;

/// Models with more coordinates are not checked: their spectrum would cost more than a short run.
const MOST_COORDINATES: usize = 256;

/// The vibrations that grow, about one state.
#[derive(Clone, Debug)]
pub(super) struct UnstableVibrations {
    dt: f64,
    limit: f64,
    modes: Vec<UnstableVibration>,
}

/// A vibration that grows.
#[derive(Clone, Debug)]
struct UnstableVibration {
    /// Frequency in rad/s.
    frequency: f64,
    /// Natural logarithm of the factor by which it grows in a step.
    rate: f64,
    /// Effect of a unit modal coordinate, by [`size`]; more than [`GROWN`] means that the vibration has grown.
    size: f64,
    /// Mass times mass-normalised shape.
    momentum: Vec<f64>,
}

impl UnstableVibrations {
    /// Vibrations about this state that grow in steps of the size `dt`. `None` if there are none: always for unconditionally stable
    /// schemes, and for models that are too large or have no spectrum there.
    pub(super) fn new<M: Model>(model: &mut M, state: State<'_>, scheme: Scheme, dt: f64) -> Option<Self> {
        let limit = scheme.stability_limit();
        if !limit.is_finite() || model.facts().n > MOST_COORDINATES {
            return None;
        }
        let State { t, q, v, a } = state;
        let spectrum = match model.facts().constraints() {
            0 => Spectrum::by_tangent(model, t, [q, v, a])?,
            _ => Spectrum::new(model, t, q, v)?,
        };
        let mut modes = Vec::new();
        for mode in spectrum.modes.into_iter().filter(|mode| mode.frequency * dt > limit) {
            let rate = scheme.amplification(mode.damping * dt, (mode.frequency * dt).powi(2)).ln();
            if rate > 0.0 {
                let size = size(model, q, &mode);
                modes.push(UnstableVibration {
                    frequency: mode.frequency,
                    rate,
                    size,
                    momentum: mode.momentum,
                });
            }
        }
        (!modes.is_empty()).then_some(Self { dt, limit, modes })
    }

    /// Why the motion ended, if one of the vibrations has grown within this number of steps.
    pub(super) fn stop(&self, state: State<'_>, steps: usize) -> Option<Stop> {
        let has_grown = |mode: &&UnstableVibration| {
            let amplitude = dot(&mode.momentum, state.a).abs() * (self.dt / self.limit).powi(2);
            let is_small = amplitude * mode.size <= GROWN;
            mode.rate * steps as f64 > LEAST_GROWTH.ln() && !is_small
        };
        let worst = self.modes.iter().filter(has_grown).max_by(|a, b| a.rate.total_cmp(&b.rate))?;
        let stable = self.limit / worst.frequency;
        let message = format!(
            "Steps of {} s are beyond the limit of stability of this method, {stable:.1e} s for the vibration of {:.3} Hz, which has grown \
             by a factor of {:.3} in each step until t = {}: the last state says nothing about the motion. Take steps below that \
             limit, or average acceleration (beta = 1/4, gamma = 1/2), which is stable with any.",
            Number(self.dt),
            worst.frequency / std::f64::consts::TAU,
            worst.rate.exp(),
            Time(state.t),
        );
        Some(Stop { status: Status::SecondOrder(second_order::Status::Unstable), message })
    }

    /// Without vibrations, to be filled from a memory.
    pub(super) fn empty(scheme: Scheme, dt: f64) -> Self {
        Self { dt, limit: scheme.stability_limit(), modes: Vec::new() }
    }

    /// Serialises all data that persist from step to step. `n` is the number of coordinates.
    pub(super) fn serialise(&mut self, n: usize, tape: &mut Tape<'_>) {
        let mut count = self.modes.len();
        tape.below(n + 1, &mut count);
        self.modes.resize_with(count, || UnstableVibration {
            frequency: 0.0,
            rate: 0.0,
            size: 0.0,
            momentum: vec![0.0; n],
        });
        for UnstableVibration { frequency, rate, size, momentum } in &mut self.modes {
            [frequency, rate, size].into_iter().for_each(|number| tape.number(number));
            tape.numbers(momentum);
        }
    }
}

/// Displacement of the tip by a unit modal coordinate, relative to the length, or [`GROWN`] times the change of coordinates relative to
/// their typical sizes, whichever is larger: rods that twist need not move their tips.
fn size<M: Model>(model: &mut M, q: &[f64], mode: &Vibration) -> f64 {
    let typical = &model.facts().typical_coordinates;
    let of_coordinates = mode.shape.iter().zip(typical).map(|(x, size)| (x / size).abs()).fold(0.0, f64::max);
    let little = SMALL / of_coordinates;
    let moved = mode.reach(model, q, little) / (little * model.facts().length);
    (GROWN * of_coordinates).max(moved)
}
