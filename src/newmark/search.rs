//! How far to go along an increment of Newton's method where surfaces touch.
//!
//! Pressing and rubbing surfaces, with the normal force of friction as it is, have a convex potential of the velocities (Castro,
//! Permenter and Han 2022), whose derivative along the increment is the work of the residual. That falls from where the increment
//! begins, through zero at the minimum. An increment is long enough when little of the work is left, or when it has grown no more
//! than that beyond the minimum (Matthies and Strang 1979). The size of the next increment is no measure of this: it jumps as
//! friction reverses.

/// So much of the work may be left beyond the minimum (Matthies and Strang 1979, section 5).
const BEYOND: f64 = 0.5;

/// A length that is too long is shortened to that part of it at least, and at most to the rest.
const LONGEST: f64 = 0.9;

/// After so many lengths they are halved.
const MOST_LENGTHS: usize = 12;

/// A search along one increment, by the work of the residual in it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Search {
    /// At the beginning; what is not above zero leads to no minimum.
    work: f64,
    lengths: usize,
}

impl Search {
    /// Before anything is known but the work where the increment begins.
    pub(super) fn new(work: f64) -> Self {
        Self { work, lengths: 0 }
    }

    /// Whether a length is good at which so much of the work is left.
    pub(super) fn is_done(&self, work: f64) -> bool {
        self.work > 0.0 && (-BEYOND * self.work..=self.work).contains(&work)
    }

    /// The next length to be tried after one that is not good: where the work vanishes if it falls evenly.
    pub(super) fn shorter(&mut self, length: f64, work: f64) -> f64 {
        self.lengths += 1;
        if self.work <= 0.0 || self.lengths > MOST_LENGTHS || !work.is_finite() {
            return 0.5 * length;
        }
        length * (self.work / (self.work + work.abs())).clamp(1.0 - LONGEST, LONGEST)
    }
}
