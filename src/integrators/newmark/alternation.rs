//! Motions that grow only because steps exceed the limit of stability of a scheme.

use crate::error::Time;

/// Steps and growth from which on a motion counts as unstable: impacts may alternate a few times.
const FEWEST: usize = 8;
const LEAST_GROWTH: f64 = 100.0;

/// What grows counts once its acceleration exceeds this part of the largest one of any coordinate, so that rounding may alternate.
const GROWN: f64 = 1e-2;

/// Accelerations that change their signs with each step and grow. So does a vibration beyond the limit of stability: the largest eigenvalue
/// of its step is real and below -1 (Hughes 2000, section 9.1.2). No motion that steps resolve does.
#[derive(Debug)]
pub(super) struct Alternation {
    /// Accelerations at the start of the step.
    last: Vec<f64>,
    /// Number of the latest steps in each of which the sign has changed and the size has grown.
    steps: Vec<usize>,
    /// Largest acceleration before these steps.
    before: Vec<f64>,
    found: Option<Found>,
}

/// A coordinate that alternates, and the factor by which it grew in the step that ended there.
#[derive(Clone, Copy, Debug)]
struct Found {
    coordinate: usize,
    factor: f64,
    t: f64,
}

impl Alternation {
    pub(super) fn new(n: usize) -> Self {
        let zeros = || vec![0.0; n];
        Self { last: zeros(), steps: vec![0; n], before: zeros(), found: None }
    }

    /// After a step that ends at t with these accelerations.
    pub(super) fn step(&mut self, t: f64, a: &[f64]) {
        for (i, &new) in a.iter().enumerate() {
            let old = self.last[i];
            if old * new < 0.0 && new.abs() > old.abs() {
                self.steps[i] += 1;
                if self.steps[i] >= FEWEST && new.abs() > LEAST_GROWTH * self.before[i] && self.counts(new) {
                    self.found = Some(Found { coordinate: i, factor: (new / old).abs(), t });
                }
            } else {
                self.steps[i] = 0;
                self.before[i] = self.before[i].max(old.abs()).max(new.abs());
            }
        }
        self.last.copy_from_slice(a);
    }

    /// Whether an acceleration is large beside those of all coordinates before they grew.
    fn counts(&self, a: f64) -> bool {
        self.before.iter().all(|before| a.abs() >= GROWN * before)
    }

    /// What happened, if something has grown.
    pub(super) fn sentence(&self) -> Option<String> {
        let Found { coordinate, factor, t } = self.found?;
        Some(format!(
            "The steps are unstable: coordinate {coordinate} changes its sign with each of them and grows by a factor of {factor:.3}, until t = \
             {}. The result says nothing about the motion, unless its loads change their signs with every step, too.",
            Time(t)
        ))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Whether accelerations of one coordinate are unstable.
    fn is_unstable(a: impl Iterator<Item = f64>) -> bool {
        let mut alternation = Alternation::new(1);
        a.enumerate().for_each(|(i, a)| alternation.step(i as f64, &[a]));
        alternation.sentence().is_some()
    }

    #[test]
    fn what_alternates_and_grows_is_unstable() {
        let powers = |factor: f64, count: i32| (0..count).map(move |i| factor.powi(i));
        assert!(is_unstable(powers(-2.0, 20)));
        assert!(is_unstable(powers(-1.01, 600)));
        // A slow motion at first, and a shorter step at the end.
        assert!(is_unstable((0..100).map(|i| f64::from(i).cos()).chain(powers(-2.0, 20)).chain([0.0])));
        // Growth, decay, a vibration of four steps, and one that neither grows nor decays.
        for others in [powers(2.0, 900), powers(-0.5, 900), powers(-1.0, 900)] {
            assert!(!is_unstable(others));
        }
        assert!(!is_unstable((0..900).map(|i| f64::from(i).exp() * (1.5 * f64::from(i)).cos())));
        assert!(!is_unstable(powers(-1e10, 5)));
    }

    #[test]
    fn rounding_may_alternate() {
        let mut alternation = Alternation::new(2);
        (0..20).for_each(|i| alternation.step(f64::from(i), &[1.0, 1e-16 * (-2_f64).powi(i)]));
        assert!(alternation.sentence().is_none());
        (20..60).for_each(|i| alternation.step(f64::from(i), &[1.0, 1e-16 * (-2_f64).powi(i)]));
        assert!(alternation.sentence().is_some());
    }
}
