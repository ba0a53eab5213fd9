//! The motion during a step of fixed size that was repeated by shorter steps of another method.

use crate::integrators::radau;
use crate::simulation::balance::State;

/// Consecutive steps of Radau's method over the last step of fixed size; none if that was not repeated.
#[derive(Clone, Debug, Default)]
pub(super) struct ResolvedMotion {
    /// Number of coordinates.
    n: usize,
    /// Times at both ends of each step.
    t: Vec<[f64; 2]>,
    /// Displacements, velocities and accelerations at the start and at the end of each step. The next step may use other rotation vectors.
    motions: Vec<f64>,
}

/// The numbers of a motion: displacements, velocities, accelerations.
const KINDS: usize = 3;

impl ResolvedMotion {
    /// An empty motion of `n` coordinates.
    pub(super) fn new(n: usize) -> Self {
        Self { n, ..Self::default() }
    }

    /// Another step begins.
    pub(super) fn clear(&mut self) {
        self.t.clear();
        self.motions.clear();
    }

    /// Whether the step was not repeated.
    pub(super) fn is_empty(&self) -> bool {
        self.t.is_empty()
    }

    /// Adds the last step of the method.
    pub(super) fn add(&mut self, stepper: &radau::Stepper) {
        let ends = stepper.ends();
        self.t.push(ends.map(|(t, _)| t));
        for numbers in ends.into_iter().flat_map(|(_, motion)| motion) {
            self.motions.extend_from_slice(&numbers[..self.n]);
        }
    }

    /// Both ends of each of the steps.
    pub(super) fn steps(&self) -> impl Iterator<Item = [State<'_>; 2]> {
        self.t.iter().enumerate().map(|(step, times)| self.step(step, *times))
    }

    fn step(&self, step: usize, times: [f64; 2]) -> [State<'_>; 2] {
        let n = self.n;
        [0, 1].map(|end| {
            let [q, v, a] = [0, 1, 2].map(|kind| {
                let first = ((2 * step + end) * KINDS + kind) * n;
                &self.motions[first..first + n]
            });
            State { t: times[end], q, v, a }
        })
    }

    /// The state at a time within the step.
    ///
    /// # Panics
    /// If [there are no steps](Self::is_empty).
    pub(super) fn interpolate(&self, t: f64, [q, v, a]: [&mut [f64]; KINDS]) {
        let later = self.t.partition_point(|&[_, end]| end < t);
        let step = later.min(self.t.len() - 1);
        let ends = self.step(step, self.t[step]);
        radau::interpolate(ends.map(|State { t, q, v, a }| (t, [q, v, a])), t, [q, v, a]);
    }
}
