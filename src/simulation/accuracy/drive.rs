//! Vibrations about the start that loads and the base motion excite: the response of each mode, uncoupled
//! from the others, to modal forces that are linear between sample times.

use super::features::{Features, Sample};
use super::inputs::{Given, Held};
use crate::analysis::growing::{Growing, amplitude};
use crate::analysis::spectrum::{Spectrum, Vibration};
use crate::error::Interrupted;
use crate::model::Model;

/// Minimum number of samples of the excitation over the whole time.
const SAMPLES: f64 = 500.0;

/// Minimum number where the features of the excitation are known, in all and within its shortest period.
const FEW_SAMPLES: f64 = 100.0;
const LOOKS_OF_A_PERIOD: f64 = 8.0;

/// Minimum number of samples of each part between known features of the excitation.
const SAMPLES_OF_A_PART: f64 = 4.0;

/// After this number of samples (some tenths of a second of work), parts shorter than the resolution of
/// `SAMPLES` are merged.
const MAX_SAMPLES: usize = 20_000;

/// Excitation of a model.
pub(super) struct Drive {
    /// Largest modal amplitude of each vibration.
    pub(super) sizes: Vec<f64>,
    /// Largest amplitude that forces excite of what grows.
    pub(super) grown: Vec<f64>,
    /// Longest step, in seconds, that misses no feature of the excitation, if steps end at `ends`.
    pub(super) longest_step: f64,
    /// Times of jumps and of short pulses.
    pub(super) ends: Vec<f64>,
}

impl Drive {
    /// Excitation of a model in the state `q0` over `t_span`. Changes that move the tip by less than
    /// `visible`, relative to the length, do not limit steps. `monitor` is called regularly with the start
    /// time and may stop the search. With `finds`, the features of the excitation by functions are found; otherwise steps end at all jumps
    /// already, and fewer samples suffice for the amplitudes.
    pub(super) fn new<M: Model>(
        model: &mut M,
        given: Given<'_>,
        (spectrum, growing): (&Spectrum, &[Growing]),
        (visible, finds): (f64, bool),
        monitor: &mut dyn FnMut(f64) -> Result<(), Interrupted>,
    ) -> Result<Self, Interrupted> {
        let Given { t_span: (t0, t_end), start: [q0, _], held, .. } = given;
        let modes = &spectrum.modes;
        let finds = finds && model.facts().has_functions;
        let of_periods = LOOKS_OF_A_PERIOD * (t_end - t0) / model.facts().shortest_period;
        let looks = if finds { SAMPLES } else { of_periods.clamp(FEW_SAMPLES, SAMPLES) };
        let between_looks = (t_end - t0) / looks;
        let weights: Vec<f64> = modes.iter().map(|mode| softness(mode, model, q0) / visible).collect();
        let mut forces = Forces::new(q0, growing, held);
        let mut motion: Vec<Oscillation> = modes.iter().map(Oscillation::new).collect();
        let mut features =
            Features { weights, duration: t_end - t0, longest_step: f64::INFINITY, ends: Vec::new() };
        let (mut t, mut looks) = (t0, 0);
        let mut before = Sample { t: t0, forces: forces.at(model, modes, [t, t])? };
        while t < t_end {
            let shortest = if looks < MAX_SAMPLES { 0.0 } else { SAMPLES_OF_A_PART * between_looks };
            let of_inputs = held.map_or(f64::INFINITY, |held| held.horizon(t));
            let end = model.horizon(t).min(of_inputs).max(t + shortest).min(t_end);
            let number = ((end - t) / between_looks).ceil().max(SAMPLES_OF_A_PART);
            let step = (end - t) / number;
            let mut at = |t: f64| {
                monitor(t0)?;
                // At the end, inputs are those before it.
                let with_inputs_of = t.min(end - 0.5 * step);
                Ok(Sample { t, forces: forces.at(model, modes, [t, with_inputs_of])? })
            };
            let mut part = vec![before];
            for i in 1..=number as usize {
                part.push(at((t + step * i as f64).min(end))?);
            }
            looks += part.len();
            // Steps end at both ends of a part, and within a short part they sample it as often as these looks.
            if finds && number > SAMPLES_OF_A_PART {
                features.find(&mut part, &mut at)?;
            }
            for (k, (oscillation, mode)) in motion.iter_mut().zip(modes).enumerate() {
                for (from, to) in part.iter().zip(&part[1..]) {
                    oscillation.step(mode, to.t - from.t, [from.forces[k], to.forces[k]]);
                }
            }
            t = end;
            before = match held {
                // Inputs jump at the end of their interval.
                Some(_) if t < t_end => Sample { t, forces: forces.at(model, modes, [t, t])? },
                _ => part.pop().expect("there was one at the start"),
            };
        }
        let Features { longest_step, ends, .. } = features;
        Ok(Self {
            sizes: motion.into_iter().map(|oscillation| oscillation.largest).collect(),
            grown: forces.grown,
            longest_step,
            ends,
        })
    }
}

/// Displacement of the tip under a unit modal force, relative to the length; zero for modes without restoring
/// force.
fn softness<M: Model>(mode: &Vibration, model: &mut M, q0: &[f64]) -> f64 {
    let of_one = mode.frequency.powi(-2);
    if of_one.is_finite() { mode.reach(model, q0, of_one) / model.facts().length } else { 0.0 }
}

/// Modal forces on a model at rest in its initial shape.
struct Forces<'a> {
    q0: &'a [f64],
    rest: Vec<f64>,
    tau: Vec<f64>,
    growing: &'a [Growing],
    grown: Vec<f64>,
    held: Option<&'a Held>,
}

impl<'a> Forces<'a> {
    fn new(q0: &'a [f64], growing: &'a [Growing], held: Option<&'a Held>) -> Self {
        let [rest, tau] = [(); 2].map(|()| vec![0.0; q0.len()]);
        Self { q0, rest, tau, growing, grown: vec![0.0; growing.len()], held }
    }

    /// At a time, with the inputs of another one.
    fn at<M: Model>(
        &mut self,
        model: &mut M,
        modes: &[Vibration],
        [t, with_inputs_of]: [f64; 2],
    ) -> Result<Vec<f64>, Interrupted> {
        if let Some(held) = self.held {
            held.set(model, with_inputs_of);
        }
        model.set_time(t)?;
        model.inverse_dynamics(self.q0, &self.rest, &self.rest, &mut self.tau);
        for (grown, growing) in self.grown.iter_mut().zip(self.growing) {
            *grown = grown.max(amplitude(&growing.of_forces, &self.tau));
        }
        let along = |mode: &Vibration| -mode.shape.iter().zip(&self.tau).map(|(x, tau)| x * tau).sum::<f64>();
        Ok(modes.iter().map(along).collect())
    }
}

/// `x'' + c x' + w^2 x = f(t)`.
struct Oscillation {
    x: f64,
    v: f64,
    /// Largest amplitude about the static displacement under the force.
    largest: f64,
}

impl Oscillation {
    fn new(mode: &Vibration) -> Self {
        Self { x: 0.0, v: mode.velocity, largest: 0.0 }
    }

    /// Exact step for a force linear in time.
    fn step(&mut self, mode: &Vibration, h: f64, [from, to]: [f64; 2]) {
        if mode.frequency == 0.0 || mode.is_overdamped() {
            return;
        }
        let (square, half) = (mode.frequency.powi(2), 0.5 * mode.damping);
        let slope = (to - from) / h / square;
        let offset = from / square - mode.damping / square * slope;
        let (x, v) = (self.x - offset, self.v - slope);
        // About the displacement that follows the force, or about that under the force at the start: within a jump the vibration
        // does not follow the force.
        let about_start = (self.x - from / square).hypot(self.v / mode.frequency);
        self.largest = self.largest.max(x.hypot(v / mode.frequency).min(about_start));
        let frequency = (square - half * half).sqrt();
        let (sine, cosine) = (frequency * h).sin_cos();
        let decay = (-half * h).exp();
        let sine = if frequency > 0.0 { sine / frequency } else { h };
        self.x = decay * (x * cosine + (v + half * x) * sine) + offset + slope * h;
        self.v = decay * (v * cosine - (square * x + half * v) * sine) + slope;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const STEPS: usize = 1000;

    fn vibration() -> Vibration {
        Vibration {
            frequency: 3.0,
            damping: 0.4,
            shape: vec![1.0],
            momentum: vec![1.0],
            velocity: 0.2,
            size: 0.0,
        }
    }

    #[test]
    fn a_jump_excites_twice_nothing_but_its_own_displacement() {
        let mode = Vibration { damping: 0.0, velocity: 0.0, ..vibration() };
        let mut motion = Oscillation::new(&mode);
        for [h, from, to] in [[1.0, 0.0, 0.0], [1e-9, 0.0, 9.0], [1.0, 9.0, 9.0], [1.0, 9.0, 9.0]] {
            motion.step(&mode, h, [from, to]);
        }
        assert!((motion.largest - 1.0).abs() < 1e-6, "{}", motion.largest);
    }

    #[test]
    fn an_oscillation_under_a_straight_line_is_exact() {
        let (mode, force) = (vibration(), |t: f64| 1.0 + 2.0 * t);
        let (mut whole, mut parts) = (Oscillation::new(&mode), Oscillation::new(&mode));
        whole.step(&mode, 2.0, [force(0.0), force(2.0)]);
        for i in 0..STEPS {
            let t = |i: usize| 2.0 * i as f64 / STEPS as f64;
            parts.step(&mode, t(1), [force(t(i)), force(t(i + 1))]);
        }
        assert!((whole.x - parts.x).abs() < 1e-12 && (whole.v - parts.v).abs() < 1e-12);
        // The differential equation itself, by finite differences.
        let h = 1e-4;
        let at = |t: f64| {
            let mut motion = Oscillation::new(&mode);
            motion.step(&mode, t, [force(0.0), force(t)]);
            motion
        };
        let (before, here, after) = (at(1.0 - h), at(1.0), at(1.0 + h));
        assert!(((after.x - before.x) / (2.0 * h) - here.v).abs() < 1e-6);
        let a = (after.v - before.v) / (2.0 * h);
        assert!((a + mode.damping * here.v + mode.frequency.powi(2) * here.x - force(1.0)).abs() < 1e-6);
    }
}
