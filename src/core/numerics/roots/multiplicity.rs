//! Detection of multiple roots by their linear convergence, and acceleration.

/// Estimates farther than this from an integer are not settled.
const SETTLED: f64 = 0.3;

/// Below, the root counts as simple: Newton's step converges quadratically and needs no acceleration.
const SIMPLE: f64 = 1.5;

/// Larger multiplicities cannot be distinguished from slow progress.
const LARGEST: f64 = 20.0;

/// Tracks Newton's correction `u(x) = J^-1 R`. Near a root of multiplicity p, `u = (x - root) / p`, so that u
/// decreases along a step by `1/p` of the step's length, and `p u` is the step to the root (Schroeder 1870;
/// Traub 1964, section 7.3; with p from the last two corrections this is the secant method for `u = 0`).
#[derive(Clone, Debug)]
pub(super) struct Multiplicity {
    correction: Vec<f64>,
    taken: Vec<f64>,
    armed: bool,
    estimates: [f64; 2],
}

impl Multiplicity {
    pub(super) fn new(unknowns: usize) -> Self {
        Self {
            correction: vec![0.0; unknowns],
            taken: vec![0.0; unknowns],
            armed: false,
            estimates: [f64::NAN; 2],
        }
    }

    /// Clears data of an earlier search.
    pub(super) fn reset(&mut self) {
        self.armed = false;
        self.estimates = [f64::NAN; 2];
    }

    /// Adds the Newton step at an iterate.
    pub(super) fn observe(&mut self, newton: &[f64], x_scale: &[f64]) {
        if self.armed {
            let (mut square, mut fall) = (0.0, 0.0);
            for j in 0..newton.len() {
                let weight = 1.0 / (x_scale[j] * x_scale[j]);
                square += weight * self.taken[j] * self.taken[j];
                fall += weight * self.taken[j] * (self.correction[j] - newton[j]);
            }
            self.estimates = [self.estimates[1], square / fall];
        }
        self.correction.copy_from_slice(newton);
        self.armed = false;
    }

    /// Adds the step taken from this iterate.
    pub(super) fn took(&mut self, step: &[f64]) {
        self.taken.copy_from_slice(step);
        self.armed = true;
    }

    /// Factor by which to lengthen the Newton step, if any.
    pub(super) fn overrelaxation(&self) -> Option<f64> {
        let estimate = self.estimates[1];
        (SIMPLE..=LARGEST).contains(&estimate).then_some(estimate)
    }

    /// The multiplicity, if the last two estimates agree on an integer above one. After an accelerated step,
    /// whose predecessors started far away, the last estimate alone decides.
    pub(super) fn settled(&self, accelerated: bool) -> Option<usize> {
        let [before, last] = self.estimates;
        let integer = last.round();
        let agree = (last - integer).abs() <= SETTLED && (accelerated || (before - integer).abs() <= SETTLED);
        (agree && (2.0..=LARGEST).contains(&integer)).then_some(integer as usize)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_root_of_multiplicity_three_is_recognised() {
        // Steps of a third of the distance to the root at zero, from 9.
        let mut multiplicity = Multiplicity::new(1);
        let mut x = 9.0;
        for _ in 0..3 {
            multiplicity.observe(&[-x / 3.0], &[1.0]);
            multiplicity.took(&[-x / 3.0]);
            x -= x / 3.0;
        }
        assert_eq!(multiplicity.settled(false), Some(3));
        assert!((multiplicity.overrelaxation().unwrap() - 3.0).abs() < 1e-12);
    }

    #[test]
    fn quadratic_convergence_is_a_simple_root() {
        let mut multiplicity = Multiplicity::new(1);
        for step in [1e-1, 1e-2, 1e-4] {
            multiplicity.observe(&[step], &[1.0]);
            multiplicity.took(&[step]);
        }
        assert_eq!(multiplicity.settled(false), None);
        assert_eq!(multiplicity.overrelaxation(), None);
    }
}
