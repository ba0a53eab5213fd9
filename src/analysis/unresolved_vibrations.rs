//! Vibrations that fixed steps do not resolve, and the resulting error of the tip.
//!
//! Average acceleration lowers the frequency w of a vibration to `(2 / h) atan(w h / 2)` for steps of size h
//! (Hughes 2000, section 9.1); other members of the family have similar errors or damp the vibration. The
//! phase error grows with time until the vibration has decayed. The motion itself shows how strong a
//! vibration is, whatever its cause: the modal acceleration over the squared frequency is its distance from
//! equilibrium if the vibration is slow compared with its excitation. A fast vibration follows its excitation
//! almost without acceleration, and its estimate is accordingly small.

use crate::analysis::spectrum::Spectrum;
use crate::error::Number;
use crate::model::Model;

/// Errors of the tip above this fraction of the length cause a warning.
const WORTH_A_WARNING: f64 = 1e-2;

/// Models with more coordinates are not checked: their spectrum would cost more than a short run.
const MOST_COORDINATES: usize = 100;

/// Smallest number of steps in a period with which average acceleration resolves a vibration: the error of its frequency is then at most
/// 3 %.
const RESOLVED: f64 = 10.0;

/// Below this half angle of a step, the series of the arc tangent is accurate to 1e-6, whereas the difference
/// would be dominated by rounding.
const SMALL_ANGLE: f64 = 1e-3;

/// Error of average acceleration in the frequency of a vibration, in rad/s: `w - (2 / h) atan(w h / 2)`.
fn drift(frequency: f64, dt: f64) -> f64 {
    let angle = 0.5 * frequency * dt;
    let part = if angle < SMALL_ANGLE { angle * angle / 3.0 } else { 1.0 - angle.atan() / angle };
    frequency * part
}

/// Vibrations of a model about its start, and their strength so far.
#[derive(Clone, Debug)]
pub(crate) struct UnresolvedVibrations {
    dt: f64,
    /// The step as given, which may be longer than the run.
    given: f64,
    t_span: (f64, f64),
    vibrations: Vec<Vibration>,
}

#[derive(Clone, Debug)]
struct Vibration {
    /// Frequency in rad/s.
    frequency: f64,
    /// Rates of decay and of phase error, in 1/s.
    decay: f64,
    drift: f64,
    /// Time during which the error grows, and [`growth`](Self::growth) within it.
    lasting: f64,
    most: f64,
    shape: Vec<f64>,
    /// Weights that turn accelerations into the modal distance from equilibrium: mass times mass-normalised
    /// shape over the squared frequency.
    weights: Vec<f64>,
    /// Largest expected error at the end of the run, as a modal coordinate, and the modal distance that
    /// causes it.
    error: f64,
    distance: f64,
}

/// Error after a time, relative to the initial amplitude.
fn grown(time: f64, decay: f64, drift: f64) -> f64 {
    (-decay * time).exp() * drift * time
}

impl Vibration {
    /// Largest error within a time, relative to the initial amplitude: it grows with the phase error until
    /// the phase is lost, and decays with the vibration.
    fn growth(&self, time: f64) -> f64 {
        if time >= self.lasting { self.most } else { grown(time, self.decay, self.drift) }
    }
}

impl UnresolvedVibrations {
    /// Vibrations of a run from the state (q, v, a) with steps of size `dt`. `None` for large models, for constrained
    /// models and for models without a spectrum at the start.
    pub(crate) fn new<M: Model>(
        model: &mut M,
        t_span: (f64, f64),
        start: [&[f64]; 3],
        dt: f64,
    ) -> Option<Self> {
        let n = model.facts().n;
        // A run that is shorter than a step is a step.
        let (given, dt) = (dt, dt.min(t_span.1 - t_span.0));
        // The spectrum describes a model with open loops and does not apply to closed ones.
        if n > MOST_COORDINATES || model.facts().constraints() > 0 {
            return None;
        }
        let spectrum = Spectrum::by_tangent(model, t_span.0, start)?;
        let oscillates =
            |mode: &&crate::analysis::spectrum::Vibration| mode.frequency > 0.0 && !mode.is_overdamped();
        let vibrations = spectrum.modes.iter().filter(oscillates).map(|mode| {
            let square = mode.frequency * mode.frequency;
            let (decay, drift) = (0.5 * mode.damping.max(0.0), drift(mode.frequency, dt));
            let lasting = (1.0 / decay).min(2.0 / drift);
            Vibration {
                frequency: mode.frequency,
                decay,
                drift,
                lasting,
                most: grown(lasting, decay, drift),
                shape: mode.shape.clone(),
                weights: mode.momentum.iter().map(|momentum| momentum / square).collect(),
                error: 0.0,
                distance: 0.0,
            }
        });
        let mut unresolved = Self { dt, given, t_span, vibrations: vibrations.collect() };
        unresolved.step(t_span.0, start[2]);
        Some(unresolved)
    }

    /// Updates the error estimates with the accelerations after a step.
    pub(crate) fn step(&mut self, t: f64, a: &[f64]) {
        let left = self.t_span.1 - t;
        for vibration in &mut self.vibrations {
            let distance = vibration.weights.iter().zip(a).map(|(weight, a)| weight * a).sum::<f64>().abs();
            if vibration.most * distance > vibration.error {
                let error = distance * vibration.growth(left);
                if error > vibration.error {
                    (vibration.error, vibration.distance) = (error, distance);
                }
            }
        }
    }

    /// A warning about the vibration with the largest error of the tip, if that error is large.
    pub(crate) fn verdict<M: Model>(&self, model: &mut M, q0: &[f64]) -> Option<String> {
        let length = model.facts().length;
        let moved = |vibration: &Vibration| {
            let moved: Vec<f64> =
                q0.iter().zip(&vibration.shape).map(|(q, x)| q + vibration.distance * x).collect();
            model.moved(q0, &moved) / length
        };
        let visible = self.vibrations.iter().filter(|vibration| vibration.distance > 0.0);
        let movements: Vec<(f64, &Vibration)> = visible.clone().map(moved).zip(visible).collect();
        let error_of = |(moved, vibration): &(f64, &Vibration)| moved * vibration.error / vibration.distance;
        let worst = movements.iter().max_by(|a, b| error_of(a).total_cmp(&error_of(b)))?;
        let (error, (moved, vibration)) = (error_of(worst), worst);
        if error <= WORTH_A_WARNING {
            return None;
        }
        let hertz = vibration.frequency / std::f64::consts::TAU;
        // For short steps the phase drift is w^3 h^2 / 12; aim for half the error that causes a warning.
        let time = self.t_span.1 - self.t_span.0;
        let enough = |(moved, vibration): &(f64, &Vibration)| {
            let drift = 0.5 * WORTH_A_WARNING / (moved * time.min(1.0 / vibration.decay));
            (12.0 * drift / vibration.frequency.powi(3)).sqrt()
        };
        let step = movements.iter().map(enough).fold(self.dt, f64::min);
        let per_period = 1.0 / (hertz * self.dt);
        let longer = match self.given > self.dt {
            true => format!(" (the whole run, shorter than `dt` of {} s)", Number(self.given)),
            false => String::new(),
        };
        let (moves, wrong) = (of_length(*moved, ""), of_length(error, "about "));
        let happens = match per_period < RESOLVED {
            true => format!(
                "does not resolve a vibration of {hertz:.3} Hz that moves the tip by {moves}: the error of the tip is {wrong}"
            ),
            false => format!(
                "makes a vibration of {hertz:.3} Hz, which moves the tip by {moves}, slightly too slow, even with {per_period:.0} steps \
                 per period: over the run this adds up to an error of the tip of {wrong}"
            ),
        };
        Some(format!(
            "The step of {} s{longer} {happens}. For an error below {:.1} %, take steps of {step:.1e} s, adaptive ones, or \
             method \"auto\".",
            Number(self.dt),
            50.0 * WORTH_A_WARNING
        ))
    }
}

/// A displacement relative to the length in words. Beyond the length linear vibrations are no measure.
fn of_length(moved: f64, about: &str) -> String {
    if moved > 1.0 {
        "more than the length".to_owned()
    } else {
        format!("{about}{:.1} % of the length", 100.0 * moved)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slow_vibrations_do_not_drift_by_rounding() {
        for frequency in [1e-12, 1e-8, 1e-3, 1.0, 1.9, 2.1, 100.0] {
            let small = frequency * (0.5 * frequency * 1e-3_f64).powi(2) / 3.0;
            let found = drift(frequency, 1e-3);
            assert!(found > 0.0 && (found - small).abs() < 2e-3 * small, "{frequency}: {found} {small}");
        }
    }
}
