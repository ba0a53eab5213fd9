//! Error of the time steps, measured by pairs of runs and reduced to the requested accuracy.

use super::paths::{distances, grows, largest, range};
use super::run::{Plan, Run, SMALLEST_RUN_TOLERANCE, TIGHTENING, first_tolerance, tightening};
use crate::error::{Interrupted, InvalidInput};
use crate::model::Model;
use crate::simulation::simulate::Status;

/// If the accuracy was not met, the next run aims at this fraction of it, with a tolerance reduced at most by
/// `SMALLEST_FACTOR`.
const TARGET_FRACTION: f64 = 0.5;
const SMALLEST_FACTOR: f64 = 1e-3;

/// Two runs are comparable if the expected gain in accuracy, from their numbers of steps, is at least this:
/// then their difference bounds the error of the better run. Otherwise the better run is repeated with enough
/// steps for `ENOUGH_GAIN`.
pub(super) const LEAST_GAIN: f64 = 2.0;
const ENOUGH_GAIN: f64 = 4.0;

/// The estimated error of the better of two runs is this factor times their difference, over the square root
/// of the expected gain. The estimate is not less than the median by proportionality, and not less than the
/// true error in 99 of 100 random motions (`benches/python/accuracy/honesty.py`).
pub(super) const SAFETY: f64 = 2.5;

/// Smallest error attributed to a run, relative to its tolerance; closer agreement is chance.
pub(super) const SMALLEST_ERROR: f64 = 0.05;

/// A run whose energy drifts by this fraction of the moved energy is not trusted, whatever it agrees with.
const LARGE_DRIFT: f64 = 0.1;

/// Energies are compared at every n-th time, with this n.
const ENERGY_INTERVAL: usize = 4;

/// After a successful run of a method on trial, the next one may take this many times as many steps.
const WORTH_MORE: usize = 4;

/// A run with a larger tolerance, relative to the requested accuracy, that fails is repeated with this one.
const RETRY_TOLERANCE: f64 = 1.5;

/// Maximum number of runs, for motions that multiply every error.
const RUNS: usize = 6;

/// A looser run for comparison.
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

/// Runs with decreasing tolerances until the estimated error is below the requested one. The result contains
/// the estimate, a message and a status.
pub(super) fn to_accuracy<M: Model + Clone>(
    plan: &mut Plan<'_, M>,
    monitor: &mut dyn FnMut(f64) -> Result<(), Interrupted>,
) -> Result<Run, InvalidInput> {
    let wanted = plan.request.rtol;
    let first = first_tolerance(plan.model.facts()) * wanted;
    let (mut tolerance, mut longest_step) = (first, f64::INFINITY);
    let mut previous: Option<Looser> = None;
    let has_order = !plan.model.facts().has_one_sided_forces;
    let tightening = tightening(plan.model.facts());
    let (mut runs, mut has_looked) = (0, false);
    plan.most_steps = plan.choice.worth;
    loop {
        let mut run = plan.run(tolerance, longest_step, monitor)?;
        runs += 1;
        if !run.is_success() {
            if plan.switches(&run) {
                (previous, runs, longest_step) = (None, 0, f64::INFINITY);
                tolerance = first;
                continue;
            }
            if tolerance > RETRY_TOLERANCE * wanted && !run.simulation.status.is_interrupted() && runs < RUNS
            {
                // The failure may be due to the large errors of a loose tolerance.
                tolerance = RETRY_TOLERANCE * wanted;
                previous = None;
                continue;
            }
            return Ok(run);
        }
        // A method that has reached the end may use more steps for a higher accuracy.
        plan.most_steps = plan.most_steps.max(WORTH_MORE * run.simulation.statistics.counters.steps);
        let Some(looser) = previous.take() else {
            // From now on, steps resolve the vibrations that this run excited. Its own losses are contained in the difference to the next
            // run, which is then far more accurate, except with impacts: then this run is repeated.
            let follows = has_looked || plan.follows(&run);
            if follows || has_order {
                if has_order && plan.model.facts().has_dry_friction {
                    // Newton's method limits these steps, not the tolerance: the next run would have as many, and be repeated.
                    longest_step = longest_of_gain(plan, run.steps());
                }
                previous = Some(run.into());
                tolerance = (tolerance / tightening).max(SMALLEST_RUN_TOLERANCE);
            }
            has_looked = true;
            continue;
        };
        let integrator = plan.choice.integrator;
        let gain = integrator.gain([(looser.tolerance, looser.steps), (tolerance, run.steps())]);
        if run.steps() < looser.steps && runs < RUNS {
            // The looser run had difficulties.
            previous = Some(run.into());
            tolerance = (tolerance / tightening).max(SMALLEST_RUN_TOLERANCE);
            continue;
        }
        if gain < LEAST_GAIN && runs < RUNS {
            // Steps limited by something other than the tolerance have the same errors in both runs.
            longest_step = longest_of_gain(plan, looser.steps);
            previous = Some(looser);
            continue;
        }
        let error = error(plan, &run, &looser, gain);
        if error <= wanted || runs >= RUNS || tolerance <= SMALLEST_RUN_TOLERANCE || !error.is_finite() {
            conclude(&mut run, wanted, runs, error);
            return Ok(run);
        }
        // The next run is compared with this one, whose error is smaller than the estimate by this gain; with impacts the gain is
        // unknown.
        let gain = if has_order {
            (error / (TARGET_FRACTION * wanted)).powi(2) / gain
        } else {
            TIGHTENING * error / wanted
        };
        let factor = gain.powf(-1.0 / integrator.exponent).clamp(SMALLEST_FACTOR, 1.0 / tightening);
        previous = Some(run.into());
        tolerance = (tolerance * factor).max(SMALLEST_RUN_TOLERANCE);
    }
}

/// Longest step of a run that gains enough over one of this number of steps.
pub(super) fn longest_of_gain<M: Model + Clone>(plan: &Plan<'_, M>, steps: f64) -> f64 {
    plan.duration() / steps * plan.choice.integrator.shorter(1.0 / ENOUGH_GAIN)
}

/// Adds the estimated error to the run that is returned, with a message and, if it is too large, a status.
pub(super) fn conclude(run: &mut Run, wanted: f64, runs: usize, error: f64) {
    run.simulation.statistics.time_error = Some(error);
    run.simulation.message = if error <= wanted {
        format!("The time error is {error:.0e} of the length, {wanted:.0e} was asked for.")
    } else {
        run.simulation.status = Status::AccuracyNotReached;
        not_reached(wanted, runs, error)
    };
}

fn not_reached(wanted: f64, runs: usize, error: f64) -> String {
    format!(
        "The accuracy of {wanted:.0e} was not reached: after {runs} runs the time error is {error:.0e} of the length. The motion \
         multiplies errors, as chaotic ones do: shorten the time, or compare energies (`balance`) instead of states."
    )
}

/// Estimated error of a run compared with a looser one, relative to the length: the difference of the tips,
/// plus errors common to both runs, and at least the error that corresponds to the energy drift.
fn error<M: Model + Clone>(plan: &Plan<'_, M>, run: &Run, looser: &Looser, gain: f64) -> f64 {
    let apart = distances(&run.tips, &looser.tips);
    // If errors multiply, steps were hardly shorter, or impacts reduce the order, the remaining error may be as large as the
    // difference.
    let is_smooth = !plan.model.facts().has_one_sided_forces;
    let share = if is_smooth && gain >= LEAST_GAIN && !grows(&apart) { SAFETY / gain.sqrt() } else { SAFETY };
    let missed =
        plan.following.error_of_steps(plan.choice.integrator, plan.duration() / run.steps().max(1.0));
    let seen = share * largest(&apart) / plan.model.facts().length;
    (seen + missed + SMALLEST_ERROR * run.tolerance).max(error_of_energy_drift(plan, run))
}

/// Tip error that corresponds to a large energy drift of a run, as for a vibration, whose amplitude is
/// proportional to the square root of its energy. Smaller drifts are ignored: the balance itself has errors
/// where loads jump. Methods that damp unresolved vibrations lose most of the energy.
fn error_of_energy_drift<M: Model + Clone>(plan: &Plan<'_, M>, run: &Run) -> f64 {
    let balance = run.simulation.every(ENERGY_INTERVAL).balance(&mut plan.model.clone());
    let drift = balance.map_or(0.0, |balance| balance.drift());
    let lost = if drift > LARGE_DRIFT { 1.0 - (1.0 - drift.min(1.0)).sqrt() } else { 0.0 };
    lost * range(&run.tips, run.simulation.t.len()) / plan.model.facts().length
}
