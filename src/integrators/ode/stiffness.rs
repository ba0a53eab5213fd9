//! Detects steps limited by stability instead of accuracy, by the test of the codes DOPRI5 and DOP853 (Hairer
//! and Wanner 1996, section IV.2, "Stiffness detection"). The last two stages are evaluated at the same time,
//! so that `|f(y1) - f(y2)| / |y1 - y2|` estimates the dominant eigenvalue lambda. A step limited by accuracy
//! keeps `h |lambda|` inside the stability region.

use crate::numerics::tape::Tape;

/// Number of accepted steps between two tests.
const INTERVAL: usize = 1000;
/// This many steps at the stability limit make a problem stiff...
const STEPS_AT_LIMIT: u32 = 15;
/// ...unless this many consecutive steps are not at the limit.
const STEPS_BELOW_LIMIT: u32 = 6;

/// Counts the steps at the stability limit.
#[derive(Clone, Debug, Default)]
pub(super) struct StiffnessTest {
    suspicions: u32,
    acquittals: u32,
}

impl StiffnessTest {
    /// Serialises the counters.
    pub(super) fn serialise(&mut self, tape: &mut Tape<'_>) {
        tape.small_count(&mut self.suspicions);
        tape.small_count(&mut self.acquittals);
    }

    /// Whether to test the accepted step with this number.
    pub(super) fn is_due(&self, accepted: usize) -> bool {
        self.suspicions > 0 || accepted.is_multiple_of(INTERVAL)
    }

    /// Updates the counters with a step; true if the problem is found to be stiff. `arguments` and `values`
    /// are (y, f(t, y)) of the last two stages.
    pub(super) fn observe(
        &mut self,
        h_abs: f64,
        arguments: (&[f64], &[f64]),
        values: (&[f64], &[f64]),
        stability_limit: f64,
    ) -> bool {
        let distance_squared =
            |(a, b): (&[f64], &[f64])| a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum::<f64>();
        let denominator = distance_squared(arguments);
        if denominator > 0.0 && h_abs * (distance_squared(values) / denominator).sqrt() > stability_limit {
            self.acquittals = 0;
            self.suspicions += 1;
            self.suspicions >= STEPS_AT_LIMIT
        } else {
            self.acquittals += 1;
            if self.acquittals == STEPS_BELOW_LIMIT {
                *self = Self::default();
            }
            false
        }
    }
}
