//! Linear response of a model about its start.
//!
//! In the linear theory of straight rods the static response of higher Legendre polynomials does not move the tip at all: what missing modes
//! change there is dynamic, by the inertia that couples them to the modes of the model, and it differs from vibration to vibration. The linear
//! responses of the model and of one with more modes, to the same start and loads, are exact sums of vibrations and show this difference. It is
//! the space error as far as the motion itself is linear.

use super::inputs::Given;
use super::paths::{distances, largest, range};
use crate::analysis::spectrum::{Spectrum, Vibration};
use crate::model::Model;
use crate::numerics::linalg::dot;

/// Largest number of times at which responses are compared.
const MAX_TIMES: usize = 128;

/// Largest model whose linear response is computed: a tenth of a second of work.
const MOST_COORDINATES: usize = 200;

/// Angle, in radians during the whole motion, below which a vibration counts as having it: formulas for springs serve rigid motions too.
const SLOWEST_ANGLE: f64 = 1e-2;

/// Displacement along a vibration by which its direction at the tip is found, relative to typical coordinates.
const DISPLACEMENT: f64 = 1e-5;

/// A motion is linear if its tip departs from the linear response by at most this part of its way.
const LARGEST_DEPARTURE: f64 = 0.1;

/// Steps that differ by less than this part are the same.
const SAME_STEP: f64 = 1e-9;

/// Below this half difference of exponents a vibration counts as critically damped, which is right to 1e-12; the quotient loses six digits there.
const CRITICAL_DAMPING: f64 = 1e-6;

/// Linear response of a model about its start.
pub(super) struct Response {
    /// Measured places at some times.
    pub(super) places: Vec<[f64; 3]>,
    times: usize,
    modes: Vec<Vibration>,
}

impl Response {
    /// At at most [`MAX_TIMES`] of the increasing `times`. `elastic` are the stiffnesses of the coordinates: `None` if one of them has none, as
    /// those of free joints, with closed loops, for large models, and where a function of time fails or a number is not finite.
    pub(super) fn new<M: Model>(
        model: &mut M,
        Given { start: [q0, v0], held, .. }: Given<'_>,
        times: &[f64],
        elastic: &[f64],
    ) -> Option<Self> {
        let (n, varies) = (model.facts().n, model.facts().varies_in_time || held.is_some());
        let is_held = model.facts().constraints() == 0 && elastic.iter().all(|k| *k > 0.0);
        if !is_held || n > MOST_COORDINATES {
            return None;
        }
        let times: Vec<f64> = times.iter().copied().step_by(stride(times.len())).collect();
        let rest = vec![0.0; n];
        let mut forces = Vec::new();
        for &t in &times[..if varies { times.len() } else { times.len().min(1) }] {
            if let Some(held) = held {
                held.set(model, t);
            }
            model.set_time(t).ok()?;
            let mut tau = vec![0.0; n];
            model.inverse_dynamics(q0, &rest, &rest, &mut tau);
            forces.push(tau);
        }
        if let Some(held) = held {
            held.set(model, *times.first()?);
        }
        let modes = Spectrum::fast(model, *times.first()?, [q0, v0])?.modes;
        let sizes = model.facts().typical_coordinates.clone();
        let mut from = Vec::new();
        model.places(q0, &mut from);
        let mut path: Vec<[f64; 3]> = from.iter().copied().cycle().take(from.len() * times.len()).collect();
        let duration = times[times.len() - 1] - times[0];
        for Vibration { frequency, damping, shape, velocity, .. } in &modes {
            let forces: Vec<f64> = forces.iter().map(|tau| -dot(tau, shape)).collect();
            let square = frequency.max(SLOWEST_ANGLE / duration).powi(2);
            let response = response([square, *damping, *velocity], &forces, &times);
            let largest = shape.iter().zip(&sizes).map(|(x, size)| (x / size).abs()).fold(0.0, f64::max);
            let step = DISPLACEMENT / largest;
            let mut to = Vec::new();
            model.places(&q0.iter().zip(shape).map(|(q, x)| q + step * x).collect::<Vec<_>>(), &mut to);
            for (places, x) in path.chunks_exact_mut(from.len()).zip(response) {
                for (place, (from, to)) in places.iter_mut().zip(from.iter().zip(&to)) {
                    (0..3).for_each(|i| place[i] += x / step * (to[i] - from[i]));
                }
            }
        }
        let is_finite = path.iter().flatten().all(|x| x.is_finite());
        is_finite.then_some(Self { places: path, times: times.len(), modes })
    }

    /// Frequencies of the vibrations, with their relative differences from those of the same shapes in a finer model, in which the
    /// coordinates of this one have these places.
    pub(super) fn errors_of_frequencies(&self, fine: &Self, places: &[usize]) -> Vec<(f64, f64)> {
        let of_vibration = |mode: &Vibration| {
            let overlap = |fine: &&Vibration| {
                places.iter().zip(&mode.shape).map(|(&place, x)| fine.momentum[place] * x).sum::<f64>().abs()
            };
            let same = fine.modes.iter().max_by(|a, b| overlap(a).total_cmp(&overlap(b)))?;
            (mode.frequency > 0.0).then(|| (mode.frequency, (same.frequency / mode.frequency - 1.0).abs()))
        };
        self.modes.iter().filter_map(of_vibration).collect()
    }

    /// Whether the places of a motion at all times, of which these are some, follow this response.
    pub(super) fn describes(&self, times: usize, places: &[[f64; 3]]) -> bool {
        let number = places.len() / times.max(1);
        if number == 0 {
            return false;
        }
        let some: Vec<[f64; 3]> =
            places.chunks_exact(number).step_by(stride(times)).flatten().copied().collect();
        largest(&distances(&some, &self.places)) <= LARGEST_DEPARTURE * range(&some, self.times)
    }
}

/// Distance, in times, of those at which responses are compared.
fn stride(times: usize) -> usize {
    times.div_ceil(MAX_TIMES).max(1)
}

/// `x'' + c x' + w^2 x = f(t)` from zero with a velocity, for forces linear between the times, or a constant one.
fn response([square, damping, velocity]: [f64; 3], forces: &[f64], times: &[f64]) -> Vec<f64> {
    let force = |i: usize| if forces.len() > 1 { forces[i] } else { forces[0] };
    let (mut x, mut v) = (0.0, velocity);
    let mut path = vec![x];
    let (mut step, mut free) = (0.0_f64, [[0.0; 2]; 2]);
    for i in 1..times.len() {
        let h = times[i] - times[i - 1];
        if (h - step).abs() > SAME_STEP * h {
            (step, free) = (h, transition(square, damping, h));
        }
        let slope = (force(i) - force(i - 1)) / h / square;
        let offset = force(i - 1) / square - damping / square * slope;
        let (from, speed) = (x - offset, v - slope);
        x = free[0][0] * from + free[0][1] * speed + offset + slope * h;
        v = free[1][0] * from + free[1][1] * speed + slope;
        path.push(x);
    }
    path
}

/// Exact step of `x'' + c x' + w^2 x = 0`: the matrix of place and velocity.
fn transition(square: f64, damping: f64, h: f64) -> [[f64; 2]; 2] {
    let half = 0.5 * damping;
    let discriminant = square - half * half;
    let (cosine, sine) = if discriminant > 0.0 {
        let (frequency, decay) = (discriminant.sqrt(), (-half * h).exp());
        let (sine, cosine) = (frequency * h).sin_cos();
        (decay * cosine, decay * sine / frequency)
    } else {
        // Without overflow: both rates are negative.
        let rate = (-discriminant).sqrt();
        let [slow, fast] = [(-half + rate) * h, (-half - rate) * h];
        let sine = if rate * h > CRITICAL_DAMPING {
            0.5 * (slow.exp() - fast.exp()) / rate
        } else {
            h * (-half * h).exp()
        };
        (0.5 * (slow.exp() + fast.exp()), sine)
    };
    [[cosine + half * sine, sine], [-square * sine, cosine - half * sine]]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_step_is_that_of_two_halves_and_satisfies_the_equation() {
        for (square, damping) in [(9.0, 0.4), (9.0, 6.0), (9.0, 50.0), (1e-4, 0.0)] {
            let [whole, half] = [0.8, 0.4].map(|h| transition(square, damping, h));
            for i in 0..2 {
                for j in 0..2 {
                    let twice: f64 = (0..2).map(|k| half[i][k] * half[k][j]).sum();
                    assert!((twice - whole[i][j]).abs() < 1e-12, "{square} {damping}");
                }
            }
            let h = 1e-5;
            let small = transition(square, damping, h);
            assert!((small[0][1] / h - 1.0).abs() < 1e-3 && (small[1][0] / h + square).abs() < 1e-2 * square);
            assert!(((small[1][1] - 1.0) / h + damping).abs() < 1e-2 * damping.max(1.0));
        }
    }

    #[test]
    fn a_response_oscillates_about_its_static_displacement_and_follows_a_ramp() {
        let times: Vec<f64> = (0..=100).map(|i| f64::from(i) * 0.1).collect();
        let constant = response([4.0, 0.0, 0.0], &[2.0], &times);
        for (x, t) in constant.iter().zip(&times) {
            assert!((x - 0.5 * (1.0 - (2.0 * t).cos())).abs() < 1e-12);
        }
        let ramp: Vec<f64> = times.iter().map(|t| 3.0 * t).collect();
        let slow = response([1e4, 300.0, 0.0], &ramp, &times);
        assert!((slow[100] - slow[99] - 0.1 * 3.0 / 1e4).abs() < 1e-9);
    }
}
