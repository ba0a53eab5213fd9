//! Detection of iterates that repeat: full Newton steps may go round in a cycle for ever.

/// Iterates are the same if they differ by less than this part of the step between them.
const REPEATED: f64 = 1e-8;

/// Finds a cycle by comparing iterates with an earlier one, which is replaced after twice as many steps (Brent 1980).
#[derive(Clone, Debug)]
pub(super) struct Cycle {
    earlier: Vec<f64>,
    /// Steps before the earlier iterate, and since.
    before: usize,
    since: usize,
    period: Option<usize>,
}

impl Cycle {
    pub(super) fn new(unknowns: usize) -> Self {
        Self { earlier: vec![0.0; unknowns], before: 0, since: 0, period: None }
    }

    /// Clears data of an earlier search, and begins at its start.
    pub(super) fn reset(&mut self, x: &[f64]) {
        self.earlier.copy_from_slice(x);
        (self.before, self.since, self.period) = (0, 0, None);
    }

    /// Adds the iterate after a step with this scaled norm.
    pub(super) fn observe(&mut self, x: &[f64], x_scale: &[f64], step_norm: f64) {
        if self.period.is_some() {
            return;
        }
        self.since += 1;
        let near = REPEATED * step_norm;
        if x.iter()
            .zip(&self.earlier)
            .zip(x_scale)
            .all(|((x, earlier), scale)| (x - earlier).abs() <= near * scale)
        {
            // A step of no length is no cycle.
            self.period = (step_norm > 0.0).then_some(self.since);
        } else if self.since > self.before {
            self.earlier.copy_from_slice(x);
            (self.before, self.since) = (self.before + self.since, 0);
        }
    }

    /// After how many steps the iterates repeat, if they do.
    pub(super) fn period(&self) -> Option<usize> {
        self.period
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn period(iterates: impl Iterator<Item = f64>) -> Option<usize> {
        let mut cycle = Cycle::new(1);
        let mut last = 0.0;
        for (k, x) in iterates.enumerate() {
            if k == 0 {
                cycle.reset(&[x]);
            } else {
                cycle.observe(&[x], &[1.0], (x - last).abs());
            }
            last = x;
        }
        cycle.period()
    }

    #[test]
    fn cycles_are_found_and_nothing_else() {
        assert_eq!(period((0..50).map(|k| f64::from(k % 2))), Some(2));
        assert_eq!(period((0..50).map(|k| f64::from(k % 3))), Some(3));
        // After a beginning that does not repeat.
        assert_eq!(period((0..90).map(|k| f64::from(if k < 20 { 100 + k } else { k % 5 }))), Some(5));
        assert_eq!(period((0..50).map(f64::from)), None);
        assert_eq!(period((0..50).map(|k| 0.5_f64.powi(k))), None);
        assert_eq!(period((0..50).map(|_| 1.0)), None);
    }
}
