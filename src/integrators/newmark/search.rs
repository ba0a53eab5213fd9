//! Line search along an increment of Newton's method for models with contact.
//!
//! With a fixed normal force of friction, contact and friction forces have a convex potential of the
//! velocities (Castro, Permenter and Han 2022), whose derivative along the increment is the work of the
//! residual. This work decreases along the increment and vanishes at the minimum. A length is accepted if
//! little of the work is left, before or beyond the minimum (Matthies and Strang 1979). The size of the next
//! increment is not a suitable measure, because it jumps when friction reverses.

/// Largest remaining work beyond the minimum, relative to that at the start (Matthies and Strang 1979, section 5).
const LARGEST_REMAINING_WORK: f64 = 0.5;

/// Work up to this multiple of that at the start is taken for that of a potential that still falls.
const MOST_WORK: f64 = 2.0;

/// A length that is too long is multiplied by a factor between one minus this and this.
const LARGEST_LENGTH_FACTOR: f64 = 0.9;

/// Number of lengths after which they are halved instead.
const MOST_LENGTHS: usize = 12;

/// A search along one increment, by the work of the residual in it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Search {
    /// Work at the start; without a positive one there is no minimum along the increment.
    work: f64,
    lengths: usize,
}

impl Search {
    /// From the work at the start of the increment.
    pub(super) fn new(work: f64) -> Self {
        Self { work, lengths: 0 }
    }

    /// Whether the work decreases along the increment, so that it has a minimum there.
    pub(super) fn has_minimum(&self) -> bool {
        self.work > 0.0
    }

    /// Whether a length with this remaining work is accepted.
    pub(super) fn is_done(&self, work: f64) -> bool {
        self.has_minimum() && (-LARGEST_REMAINING_WORK * self.work..=self.work).contains(&work)
    }

    /// Whether a potential falls faster with this work than at the start, but not so much faster that the length may lead beyond a ridge.
    pub(super) fn still_falls(&self, work: f64) -> bool {
        self.has_minimum() && work > self.work && work <= MOST_WORK * self.work
    }

    /// The next length after one that is not accepted: the zero of the work by linear interpolation.
    pub(super) fn shorter(&mut self, length: f64, work: f64) -> f64 {
        self.lengths += 1;
        if self.work <= 0.0 || self.lengths > MOST_LENGTHS || !work.is_finite() {
            return 0.5 * length;
        }
        length
            * (self.work / (self.work + work.abs())).clamp(1.0 - LARGEST_LENGTH_FACTOR, LARGEST_LENGTH_FACTOR)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Looks for the minimum of a potential, by its derivative downhill; returns the length and how many were tried.
    fn search(derivative: impl Fn(f64) -> f64) -> (f64, usize) {
        let mut search = Search::new(derivative(0.0));
        let mut length = 1.0;
        for tried in 1..=MOST_LENGTHS {
            let work = derivative(length);
            if search.is_done(work) {
                return (length, tried);
            }
            length = search.shorter(length, work);
        }
        panic!("no length is good");
    }

    #[test]
    fn increments_that_do_not_reach_the_minimum_or_pass_it_a_little_are_whole() {
        assert_eq!(search(|x| 1.0 - 0.3 * x), (1.0, 1));
        assert_eq!(search(|x| 1.0 - 1.4 * x), (1.0, 1));
    }

    #[test]
    fn friction_that_reverses_and_walls_are_found_within_a_few_lengths() {
        // Sliding that would stop at a place is pushed back beyond it as hard as before.
        for place in [0.9, 0.3, 0.05, 0.01] {
            let (length, tried) = search(|x| if x < place { 1.0 } else { -9.0 });
            assert!(length < place && tried <= 4, "{place}: {length} after {tried}");
        }
        // A wall a thousand times as stiff as what moves against it.
        let wall = |x: f64| 1.0 - x - 1e3 * (x - 0.4).max(0.0);
        let (length, tried) = search(wall);
        assert!(wall(length) >= -LARGEST_REMAINING_WORK && tried <= 6, "{length} after {tried}");
    }

    #[test]
    fn without_a_minimum_ahead_lengths_are_halved() {
        let mut search = Search::new(-1.0);
        assert!(!search.is_done(0.0));
        assert_eq!([search.shorter(1.0, -2.0), search.shorter(0.5, f64::NAN)], [0.5, 0.25]);
    }
}
