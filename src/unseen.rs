//! Vibrations that fixed steps do not resolve, and the error of the tip that they cause.
//!
//! Average acceleration makes a vibration of frequency w slower: `(2 / h) atan(w h / 2)` with steps of size h (Hughes
//! 2000, section 9.1), and other members of the family are off by as much or damp it away. Until both have died down
//! the error of its phase grows with the time. How strong the vibrations are is seen in the motion itself, whatever
//! set them off: the accelerations of each, over the square of its frequency, are its distance from its equilibrium,
//! if it is slow beside what drives it; where it is fast, it follows almost without acceleration, and so counts as
//! little as it should.

use crate::error::Number;
use crate::linalg::Matrix;
use crate::model::Model;
use crate::spectrum::Spectrum;

/// Errors of the tip by this part of the length are worth a warning.
const WORTH_A_WARNING: f64 = 1e-2;

/// Models of more coordinates are not looked at: their spectrum would cost more than a short run.
const MOST_COORDINATES: usize = 100;

/// Below this half angle of a step the series of the arc tangent is exact to a part of 1e-6, and a difference would be rounding.
const SMALL_ANGLE: f64 = 1e-3;

/// By how much average acceleration makes a vibration slower, in rad/s: `w - (2 / h) atan(w h / 2)`.
fn drift(frequency: f64, dt: f64) -> f64 {
    let angle = 0.5 * frequency * dt;
    let part = if angle < SMALL_ANGLE { angle * angle / 3.0 } else { 1.0 - angle.atan() / angle };
    frequency * part
}

/// The vibrations of a model about its start, and how strong each was so far.
#[derive(Clone, Debug)]
pub(crate) struct Unseen {
    dt: f64,
    t_span: (f64, f64),
    vibrations: Vec<Vibration>,
}

#[derive(Clone, Debug)]
struct Vibration {
    /// In rad/s.
    frequency: f64,
    /// How fast it dies down, and how fast the phase goes wrong, in 1/s.
    decay: f64,
    drift: f64,
    shape: Vec<f64>,
    /// What makes accelerations its distance from equilibrium, with modal mass one: mass times shape over the square
    /// of the frequency.
    weights: Vec<f64>,
    /// The largest error so far that it will have come to at the end, as a modal coordinate, and the distance that it
    /// comes from.
    error: f64,
    distance: f64,
}

impl Vibration {
    /// The largest error, relative to the amplitude at the beginning, of this vibration in a time: it grows with the
    /// phase until that is lost, and dies down.
    fn growth(&self, time: f64) -> f64 {
        let at = time.min(1.0 / self.decay).min(2.0 / self.drift);
        (-self.decay * at).exp() * self.drift * at
    }
}

impl Unseen {
    /// Those of a run from `q0`, `v0` with steps of size `dt`. None of a model that is large or has no spectrum
    /// there, and none where nothing could be wrong.
    pub(crate) fn new<M: Model>(
        model: &mut M,
        t_span: (f64, f64),
        [q0, v0]: [&[f64]; 2],
        dt: f64,
    ) -> Option<Self> {
        let n = model.n();
        // The spectrum is that of a model whose loops are open: it says nothing of one that keeps them closed.
        if n > MOST_COORDINATES || model.constraints() > 0 {
            return None;
        }
        let spectrum = Spectrum::new(model, t_span.0, q0, v0)?;
        let mut mass = Matrix::zeros(n, n);
        model.mass_matrix(q0, &mut mass);
        let oscillates = |mode: &&crate::spectrum::Vibration| mode.frequency > 0.0 && !mode.is_overdamped();
        let vibrations = spectrum.modes.iter().filter(oscillates).map(|mode| {
            let square = mode.frequency * mode.frequency;
            let row = |i: usize| (0..n).map(|j| mass[(i, j)] * mode.shape[j]).sum::<f64>() / square;
            Vibration {
                frequency: mode.frequency,
                decay: 0.5 * mode.damping.max(0.0),
                drift: drift(mode.frequency, dt),
                shape: mode.shape.clone(),
                weights: (0..n).map(row).collect(),
                error: 0.0,
                distance: 0.0,
            }
        });
        let mut unseen = Self { dt, t_span, vibrations: vibrations.collect() };
        let mut a0 = vec![0.0; n];
        let mut scratch = crate::model::ForwardScratch::of(model);
        model.forward_dynamics(q0, v0, &mut a0, &mut scratch).ok()?;
        unseen.step(t_span.0, &a0);
        Some(unseen)
    }

    /// Takes note of the accelerations after a step.
    pub(crate) fn step(&mut self, t: f64, a: &[f64]) {
        let left = self.t_span.1 - t;
        for vibration in &mut self.vibrations {
            let distance = vibration.weights.iter().zip(a).map(|(weight, a)| weight * a).sum::<f64>().abs();
            // No growth is more than two.
            if 2.0 * distance > vibration.error {
                let error = distance * vibration.growth(left);
                if error > vibration.error {
                    (vibration.error, vibration.distance) = (error, distance);
                }
            }
        }
    }

    /// A warning about the vibration that causes the largest error of the tip, if that is large.
    pub(crate) fn verdict<M: Model>(&self, model: &mut M, q0: &[f64]) -> Option<String> {
        let length = model.length();
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
        // With short steps the drift of the phase is w^3 h^2 / 12: half of what is worth a warning.
        let time = self.t_span.1 - self.t_span.0;
        let enough = |(moved, vibration): &(f64, &Vibration)| {
            let drift = 0.5 * WORTH_A_WARNING / (moved * time.min(1.0 / vibration.decay));
            (12.0 * drift / vibration.frequency.powi(3)).sqrt()
        };
        let step = movements.iter().map(enough).fold(self.dt, f64::min);
        Some(format!(
            "The step of {} s does not resolve a vibration of {hertz:.3} Hz that moves the tip by {:.1} % of the length: the error of \
             the tip is about {:.1} % of the length. For an error below {:.1} %, take steps of {step:.1e} s, adaptive ones, or \
             method \"auto\".",
            Number(self.dt),
            100.0 * moved,
            100.0 * error,
            50.0 * WORTH_A_WARNING
        ))
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
