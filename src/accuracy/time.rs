//! The error that the steps leave: measured by two runs, and made as small as is asked for.

use super::paths::{distances, grows, largest, range};
use super::run::{FIRST_TOLERANCE, Plan, Run};
use crate::error::{Interrupted, InvalidInput};
use crate::model::Model;
use crate::simulate::Status;

/// Each run's tolerance over that of the next one, with which it is compared.
pub(super) const TIGHTENING: f64 = 5.0;

/// Where the accuracy was not met, the next run aims at this part of it, with a tolerance that is smaller by this
/// factor at most.
const AIM: f64 = 0.5;
const SMALLEST_FACTOR: f64 = 1e-3;

/// Two runs can be compared if the better one should have gained that much, by its steps: its error is their
/// difference then, at most. If not, it is repeated with so many more of them that it gains enough.
const LEAST_GAIN: f64 = 2.0;
const ENOUGH_GAIN: f64 = 4.0;

/// The error of the better one of two runs is taken for so many times their difference, over the root of what the
/// better one should have gained: not less than the median by proportionality, and not less than the truth in 99 of
/// 100 random motions (`benches/python/accuracy/honesty.py`).
const SAFETY: f64 = 2.5;

/// No run is better than this part of its tolerance, whatever it agrees with: more is luck.
const LUCK: f64 = 0.05;

/// A run that has lost or gained this part of the energy that moved is not trusted, whatever it agrees with.
const LARGE_DRIFT: f64 = 0.1;

/// Runs until an accuracy counts as out of reach, in motions that multiply every error.
const RUNS: usize = 6;

/// Tightest tolerance of a run; below, rounding rules.
const SMALLEST_RUN_TOLERANCE: f64 = 1e-13;

/// A run to compare with.
struct Looser {
    tolerance: f64,
    steps: f64,
    tips: Vec<[f64; 3]>,
}

impl From<Run> for Looser {
    fn from(run: Run) -> Self {
        Self { tolerance: run.tolerance, steps: run.steps(), tips: run.tips }
    }
}

/// Runs of ever tighter tolerances, until the estimated error of one is below the tolerance that is asked for. It has
/// the estimate, a message and a status that say what came of it.
pub(super) fn to_accuracy<M: Model + Clone>(
    plan: &mut Plan<'_, M>,
    monitor: &mut dyn FnMut(f64) -> Result<(), Interrupted>,
) -> Result<Run, InvalidInput> {
    let wanted = plan.request.rtol;
    let mut tolerance = FIRST_TOLERANCE * wanted;
    let mut longest_step = f64::INFINITY;
    let mut previous: Option<Looser> = None;
    let mut runs = 0;
    loop {
        let mut run = plan.run(tolerance, longest_step, monitor)?;
        runs += 1;
        if !run.is_success() {
            return Ok(run);
        }
        let Some(looser) = previous.take() else {
            // What has set off what it could not follow is no run to compare with.
            if runs > 1 || plan.follows(&run) {
                previous = Some(run.into());
                tolerance = (tolerance / TIGHTENING).max(SMALLEST_RUN_TOLERANCE);
            }
            continue;
        };
        let integrator = plan.choice.integrator;
        let gain = integrator.gain([(looser.tolerance, looser.steps), (tolerance, run.steps())]);
        if gain < LEAST_GAIN && runs < RUNS {
            // Steps that something else than the tolerance limits say nothing about the errors that they share.
            longest_step = plan.duration() / looser.steps * integrator.shorter(1.0 / ENOUGH_GAIN);
            previous = Some(looser);
            continue;
        }
        let error = error(plan, &run, &looser, gain);
        let is_met = error <= wanted;
        if is_met || runs >= RUNS || tolerance <= SMALLEST_RUN_TOLERANCE || !error.is_finite() {
            run.simulation.statistics.time_error = Some(error);
            run.simulation.message = if is_met {
                format!("The time error is {error:.0e} of the length, {wanted:.0e} was asked for.")
            } else {
                run.simulation.status = Status::AccuracyNotReached;
                format!(
                    "The accuracy of {wanted:.0e} was not reached: after {runs} runs the time error is {error:.0e} \
                     of the length. The motion multiplies errors, as chaotic ones do: shorten the time, or compare \
                     energies (`balance`) instead of states."
                )
            };
            return Ok(run);
        }
        // The next run is compared with this one, of which the error is smaller than that by this gain.
        let gain = (error / (AIM * wanted)).powi(2) / gain;
        let factor = gain.powf(-1.0 / integrator.exponent).clamp(SMALLEST_FACTOR, 1.0 / TIGHTENING);
        previous = Some(run.into());
        tolerance = (tolerance * factor).max(SMALLEST_RUN_TOLERANCE);
    }
}

/// The error of a run beside a looser one, relative to the length: of what the tips say, with what both runs miss
/// alike, and no less than goes with the energy that was lost.
fn error<M: Model + Clone>(plan: &Plan<'_, M>, run: &Run, looser: &Looser, gain: f64) -> f64 {
    let apart = distances(&run.tips, &looser.tips);
    // Where errors multiply, or the steps were hardly shorter, what is left of them need not be less.
    let share = if gain >= LEAST_GAIN && !grows(&apart) { SAFETY / gain.sqrt() } else { SAFETY };
    let missed = plan.following.lost(plan.choice.integrator, plan.duration() / run.steps().max(1.0));
    let seen = share * largest(&apart) / plan.model.length();
    (seen + missed + LUCK * run.tolerance).max(drained(plan, run))
}

/// The error of the tip that goes with the energy that a run has lost or gained, if that is much: as of a vibration,
/// whose amplitude goes with the root of its energy. The balance itself has errors where loads jump; methods that
/// damp what they step over lose most of it.
fn drained<M: Model + Clone>(plan: &Plan<'_, M>, run: &Run) -> f64 {
    let balance = run.simulation.balance(&mut plan.model.clone());
    let drift = balance.map_or(0.0, |balance| balance.drift());
    let lost = if drift > LARGE_DRIFT { 1.0 - (1.0 - drift.min(1.0)).sqrt() } else { 0.0 };
    lost * range(&run.tips, run.simulation.t.len()) / plan.model.length()
}
