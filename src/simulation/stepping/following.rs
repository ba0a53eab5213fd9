//! Steps of fixed size over which commanded lengths of tendons jump, such as inputs set from step to step. Changes of the active set
//! could follow each other endlessly at one time. Therefore a tendon pulls over the whole step, so that it has its length at the end,
//! or not at all, and each active set is tried once: first by Bard's rule, which changes the largest violation, then by Murty's, which
//! changes the first one (Murty 1974, "Note on a Bard-type scheme for solving the complementarity problem").

use crate::model::constraint::one_sided::{ACTIVATION_EXCESS, TAUT, most_switches};

/// A tendon counts as pushing if it does so by more than this part of the largest tension in the step.
const PUSHING_FORCE: f64 = 1e-10;

/// Violations at the end of a step with an active set: the largest push, in units of the largest tension, and the largest excess of a
/// length, in units of the length of what the tendon joins.
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd)]
pub(super) struct Misfit {
    push: f64,
    pub(super) excess: f64,
}

/// The active sets that were tried for a step.
#[derive(Debug)]
pub(super) struct Search {
    tried: Vec<Vec<bool>>,
    best: Option<(Misfit, Vec<bool>)>,
}

impl Search {
    /// A search that starts with this set.
    pub(super) fn new(active: &[bool]) -> Self {
        Self { tried: vec![active.to_vec()], best: None }
    }

    /// The set to be tried next.
    pub(super) fn active(&self) -> &[bool] {
        self.tried.last().expect("there is a first one")
    }

    /// The set with the smallest violations, if a step could be made with any.
    pub(super) fn best(&self) -> Option<&(Misfit, Vec<bool>)> {
        self.best.as_ref()
    }

    /// Judges the end of a step with the set, by tensions and excesses of lengths; `None` if the step could not be made. Returns
    /// whether the set fits.
    pub(super) fn fits(&mut self, end: Option<[&[f64]; 2]>) -> bool {
        let Some([pulls, excesses]) = end else { return false };
        // Newton's method leaves small gaps of active constraints.
        let allowed = |is_active: bool| if is_active { TAUT } else { ACTIVATION_EXCESS };
        let excesses = excesses.iter().zip(self.active()).map(|(by, &is_active)| by - allowed(is_active));
        let misfit = Misfit { push: largest(pushes(pulls).into_iter()), excess: largest(excesses) };
        if self.best.as_ref().is_none_or(|(best, _)| misfit < *best) {
            self.best = Some((misfit, self.active().to_vec()));
        }
        misfit.push <= 0.0 && misfit.excess <= 0.0
    }

    /// Proceeds to a similar set that was not tried yet. False if there is none, or enough were tried.
    pub(super) fn next(&mut self, end: Option<[&[f64]; 2]>) -> bool {
        if self.tried.len() > most_switches(self.active().len()) {
            return false;
        }
        let set = candidates(self.active(), end).into_iter().find(|set| !self.tried.contains(set));
        set.map(|set| self.tried.push(set)).is_some()
    }
}

/// How hard tendons push, beyond rounding.
fn pushes(pulls: &[f64]) -> Vec<f64> {
    let largest = pulls.iter().fold(f64::MIN_POSITIVE, |largest, pull| largest.max(pull.abs()));
    pulls.iter().map(|pull| -pull / largest - PUSHING_FORCE).collect()
}

/// The largest of the positive values, or zero.
fn largest(values: impl Iterator<Item = f64>) -> f64 {
    values.fold(0.0, f64::max)
}

/// Sets that may fit better than the one with this end, or than one with which the step could not be made.
fn candidates(active: &[bool], end: Option<[&[f64]; 2]>) -> Vec<Vec<bool>> {
    let with = |change: &dyn Fn(usize) -> bool| -> Vec<bool> {
        active.iter().enumerate().map(|(i, &is_active)| is_active != change(i)).collect()
    };
    // The last resort, in which no tendon pushes.
    let none = vec![false; active.len()];
    let Some([pulls, excesses]) = end else {
        // Too many or the wrong tendons are taut.
        let released = (0..active.len()).rev().filter(|&i| active[i]);
        return released.map(|i| with(&|j| i == j)).chain([none]).collect();
    };
    let pushes = pushes(pulls);
    let is_passed = |i: usize| !active[i] && excesses[i] > ACTIVATION_EXCESS;
    let is_pushing = |i: usize| active[i] && pushes[i] > 0.0;
    let hardest =
        (0..active.len()).filter(|&i| is_pushing(i)).max_by(|&i, &j| pushes[i].total_cmp(&pushes[j]));
    let mut sets = Vec::new();
    if (0..active.len()).any(is_passed) {
        sets.push(with(&is_passed));
    } else if let Some(hardest) = hardest {
        sets.push(with(&|i| i == hardest));
    }
    sets.extend((0..active.len()).filter(|&i| is_passed(i) || is_pushing(i)).map(|i| with(&|j| i == j)));
    sets.push(none);
    sets
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_set_is_tried_once_and_the_search_ends() {
        // Two tendons that conflict: if one is taut the other is too long, both cannot be taut, and without them both are too long.
        let mut search = Search::new(&[true, true]);
        let mut tried = 0;
        loop {
            tried += 1;
            let (pulls, excesses) = match search.active() {
                [true, true] => (None, [0.0; 2]),
                [true, false] => (Some([1.0, 0.0]), [0.0, 0.2]),
                [false, true] => (Some([0.0, 1.0]), [0.1, 0.0]),
                _ => (Some([0.0; 2]), [0.3, 0.3]),
            };
            let end = pulls.as_ref().map(|pulls| [&pulls[..], &excesses[..]]);
            assert!(!search.fits(end));
            if !search.next(end) {
                break;
            }
        }
        assert!(tried <= 4);
        let (misfit, set) = search.best().unwrap();
        assert_eq!(set, &[false, true]);
        assert!((misfit.excess - 0.1).abs() < 1e-9);
    }

    #[test]
    fn what_pushes_is_released_and_what_is_passed_pulls() {
        let mut search = Search::new(&[true, false]);
        let end = Some([&[-1.0, 0.0][..], &[0.0, 0.1][..]]);
        assert!(!search.fits(end));
        assert!(search.next(end));
        assert_eq!(search.active(), [true, true]);
        let end = Some([&[-1.0, 2.0][..], &[0.0; 2][..]]);
        assert!(!search.fits(end));
        assert!(search.next(end));
        assert_eq!(search.active(), [false, true]);
        assert!(search.fits(Some([&[0.0, 2.0], &[-0.1, 0.0]])));
    }
}
