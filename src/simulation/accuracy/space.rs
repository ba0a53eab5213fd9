//! Error due to the finite number of modes and nodes: bounded by the forces on modes that are missing, or measured by a
//! run of a model with more modes and nodes.

use super::inputs::Given;
use super::missing::{by_nodes, finer};
use super::paths::{distances, largest};
use super::request::Request;
use super::run::{Plan, Run, TIGHTENING, TOO_MANY_STEPS, first_tolerance};
use crate::error::{Interrupted, InvalidInput};
use crate::model::Model;
use crate::simulation::simulate::Status;

/// Tolerance of the tightest run of a finer model, relative to the requested accuracy.
const TIGHTEST: f64 = 0.1;

/// Errors of the steps of a finer model that do not matter, relative to the requested accuracy.
const NEGLIGIBLE: f64 = 0.3;

/// Smallest error of a run, relative to its tolerance, that is assumed.
const SMALLEST_ERROR: f64 = 0.02;

/// A difference of models is attributed to modes if it exceeds the expected error of the steps by this factor.
const SIGNIFICANT_FACTOR: f64 = 3.0;

/// Tolerance of a first run that finds large errors at little cost, made if `TYPICAL_ERROR` times the bound by forces exceeds it: errors
/// are often at least this part of their bound.
const COARSE_TOLERANCE: f64 = 1e-3;
const TYPICAL_ERROR: f64 = 0.1;

/// Largest tolerance of a run that shows a static displacement: looser ones hardly save steps.
const LOOSEST: f64 = 1e-2;

/// If the change by nodes, estimated by forces, is smaller than this part of the largest accepted change, or larger than it divided by this,
/// no run is needed.
const DECISIVE_FACTOR: f64 = 0.3;

/// Change by additional nodes that requires them, relative to the requested accuracy.
const CHANGE_THAT_NEEDS_NODES: f64 = 0.3;

/// A space error above what was asked that forces and linear responses explain to this part needs no second run of the finer model.
const EXPLAINED_PART: f64 = 0.5;

/// A run of the finer model may take this many times the steps of the run, and this number in any case. Wires that lie on obstacles wriggle
/// in ever shorter waves as modes are added.
const MOST_STEPS: f64 = 4.0;
const FREE_STEPS: f64 = 1000.0;

/// Adds the space error to a run, or the reason why it is unknown. If the bound by forces is larger than what was
/// asked, simulates a finer model, with the method that suits that model, only as accurately as needed to distinguish errors
/// of modes from errors of steps.
pub(super) fn add_error<M: Model + Clone>(
    plan: &Plan<'_, M>,
    run: &mut Run,
    monitor: &mut dyn FnMut(f64) -> Result<(), Interrupted>,
) -> Result<(), InvalidInput> {
    let wanted = plan.request.rtol;
    let unknown = |run: &mut Run, why: &str| {
        run.simulation.message.push_str(&format!(" The space error is unknown: {why}."));
        Ok(())
    };
    let motion = (&run.simulation, &run.tips[..]);
    let late_at_most = |relative, most| plan.following.late_at_most(relative, most);
    let limits = [plan.choice.resolved, wanted];
    let mut finer = match finer(plan.model, motion, plan.given, &late_at_most, limits) {
        Ok(Some(finer)) => finer,
        Ok(None) => return Ok(()),
        Err(why) => return unknown(run, why),
    };
    if let Some(error) = finer.estimate.at_most.or(finer.estimate.of_linear()) {
        add_space_error(run, error, wanted);
        return Ok(());
    }
    let late = plan.following.error_of_frequencies(
        0.5 * finer.estimate.energy,
        &finer.frequencies,
        finer.estimate.by_deflection,
    );
    let bound = finer.estimate.bound(late).filter(|&error| error <= wanted);
    if let Some(error) = bound.or_else(|| finer.estimate.beyond(wanted, late)) {
        add_space_error(run, error, wanted);
        return Ok(());
    }
    // Without what wrong frequencies may add.
    let shown = finer.estimate.bound(0.0);
    let Some(mut model) = finer.model.take() else {
        return unknown(run, "with more modes the model would be too large");
    };
    let n = model.facts().n;
    let [q0, v0] = plan.given.start.map(|values| finer.embed(values, n));
    // Expected error of a run relative to its tolerance, from the runs of the coarse model.
    let part =
        run.simulation.statistics.time_error.map_or(1.0, |error| error / run.tolerance).max(SMALLEST_ERROR);
    let tightest = run.tolerance.min(TIGHTEST * wanted);
    let fit = (NEGLIGIBLE * wanted / part).min(first_tolerance(plan.model.facts()) * wanted).max(tightest);
    let is_large = finer.estimate.bound(late).is_none_or(|bound| TYPICAL_ERROR * bound > COARSE_TOLERANCE);
    let shows = (finer.estimate.finds / (SIGNIFICANT_FACTOR * part)).min(LOOSEST);
    let mut tolerance = fit.max(shows).max(if is_large { COARSE_TOLERANCE } else { 0.0 });
    let most_steps = plan.request.max_steps.min((MOST_STEPS * run.steps()).max(FREE_STEPS) as usize);
    let error = loop {
        let request = Request { rtol: tolerance, max_steps: most_steps, ..plan.request };
        let known = Some(&plan.following);
        let given = Given { start: [&q0, &v0], ..plan.given };
        let fine = Plan::new(&mut model, given, request, known, monitor)?;
        let other = fine.run(tolerance, f64::INFINITY, monitor)?;
        if !other.is_success() {
            if other.simulation.status.name() == "interrupted" {
                run.interrupt();
                return Ok(());
            }
            return unknown(run, why_failed(&other));
        }
        let apart = largest(&distances(&other.tips, &run.tips)) / plan.model.facts().length;
        let error = finer.estimate.error(apart);
        let is_explained = shown.is_some_and(|shown| shown >= EXPLAINED_PART * error);
        if error <= wanted
            || is_explained
            || apart > SIGNIFICANT_FACTOR * part * tolerance
            || tolerance <= tightest
        {
            break error;
        }
        tolerance = if tolerance > fit { fit } else { (tolerance / TIGHTENING).max(tightest) };
    };
    add_space_error(run, error, wanted);
    Ok(())
}

/// Why a run of the finer model tells nothing.
fn why_failed(finer: &Run) -> &'static str {
    if finer.simulation.status.name() == TOO_MANY_STEPS {
        "a model with more modes takes far more steps; simulate one and compare"
    } else {
        "the run with more modes failed"
    }
}

/// Adds the space error to a run, with a sentence about it.
fn add_space_error(run: &mut Run, error: f64, wanted: f64) {
    run.simulation.statistics.space_error = Some(error);
    let verdict = if error <= wanted {
        format!(" The space error is {error:.0e}.")
    } else {
        format!(" The modes of the model leave a space error of {error:.0e}: give it more, or more segments.")
    };
    run.simulation.message.push_str(&verdict);
}

/// The model with `factor` times as many nodes, if its motion differs in an otherwise identical run. Called
/// only if the space error is too large or unknown.
pub(super) fn with_nodes<M: Model + Clone>(
    plan: &Plan<'_, M>,
    run: &Run,
    (original, factor): (&M, usize),
    monitor: &mut dyn FnMut(f64) -> Result<(), Interrupted>,
) -> Result<Option<M>, InvalidInput> {
    let wanted = plan.request.rtol;
    let is_unresolved = run.simulation.status == Status::Unresolved;
    let is_met = run.simulation.statistics.space_error.is_some_and(|error| error <= wanted);
    let matters = run.is_success() && plan.request.space_error && !is_met;
    if !is_unresolved && !matters {
        return Ok(None);
    }
    let Some(mut model) = original.with_nodes_times(factor) else { return Ok(None) };
    if is_unresolved {
        return Ok(Some(model));
    }
    let largest_change = CHANGE_THAT_NEEDS_NODES * wanted;
    if let Some([moved, energy]) = by_nodes(plan.model, &mut model, &run.simulation) {
        let changed = moved + plan.following.error_of_frequencies(0.5 * energy, &[], f64::INFINITY);
        if changed <= DECISIVE_FACTOR * largest_change || changed >= largest_change / DECISIVE_FACTOR {
            return Ok((changed > largest_change).then_some(model));
        }
    }
    model.end_steps_at(&plan.following.ends);
    let (choice, following) = (plan.choice.clone(), plan.following.clone());
    let other = Plan { model: &model, choice, following, ..*plan };
    // At the tolerance of the run: if errors multiply, errors of looser steps would be attributed to the
    // nodes.
    let other = other.run(run.tolerance, f64::INFINITY, monitor)?;
    let changed = largest(&distances(&other.tips, &run.tips)) / plan.model.facts().length;
    Ok((other.is_success() && changed > largest_change).then_some(model))
}
