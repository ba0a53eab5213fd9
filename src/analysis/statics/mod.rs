//! Statics: equilibria of models, and their stability.
//!
//! [`equilibrium`] finds an equilibrium by following the path of growing loads, by a search from a shape, or
//! by Newton's method nearby. [`continuation`] follows paths through limit points and from bifurcations. Both
//! report stability.
//!
//! `equations` contains the forces at a load factor (`load_parameter`), `corrector` Newton's method that
//! stays on its path, `path` continuation, `search` the search for equilibria from a shape (with contacts, by `stiffness_continuation`), `descent` that under
//! loads without a potential, `stability` the search for critical points, `tendons` the detection of slack
//! tendons, `tied` and `tied_newton` models with closed loops, and `space_error` and `error_along` the error due to the finite number of modes.
//! [`crate::analysis::stability`] judges stability.
//!
//! ```
//! use lissom::robot::{Rod, RobotModel};
//! use lissom::rod::Segment;
//! use lissom::statics::{Options, equilibrium};
//!
//! let segment = Segment { modes: [0, 3, 0, 0, 0, 0], ..Segment::straight(1.0, 1e-3, 210e9, 80e9, 7800.0) };
//! let mut wire = RobotModel::of_rod(&Rod::new(vec![segment]))?;
//! let sagging = equilibrium(&mut wire, &Options::default(), &mut || Ok(()))?.expect("nothing interrupts it");
//! assert!((sagging.q[0] - 0.238_212).abs() < 1e-5); // radians per metre
//! # Ok::<(), lissom::error::InvalidInput>(())
//! ```

mod as_springs;
mod corrector;
mod descent;
mod equations;
mod error_along;
mod interrupted;
mod load_parameter;
mod options;
mod outcome;
mod path;
mod search;
mod space_error;
mod stability;
mod stiffness_continuation;
mod tendons;
mod tied;
mod tied_newton;
mod tunnelling;

pub use equations::Counters;
pub use error_along::error_along;
pub use interrupted::Monitor;
pub use load_parameter::InputPath;
pub use options::{ContinuationOptions, MAX_STOPS, Options, Start};
pub use outcome::{Continuation, Equilibrium, Status};
pub use path::{CriticalKind, CriticalPoint, Path};
pub use space_error::{Effort, Estimate, LARGE, Rest, SpaceError, error_at_rest, is_at_rest, space_error};
pub use tendons::Tendons;

use as_springs::AsSprings;
use descent::Descent;
use equations::{Equations, State};
use interrupted::{InterruptedSearch, Reached};
use load_parameter::LoadParameter;
use path::{End, Follower, PathLimits};
use search::Ended;
use stability::Stiffness;
use tunnelling::Passage;

pub use crate::analysis::stability::{Stability, Verdict};
use crate::error::{Interrupted, InvalidInput, Unfinished};
use crate::model::{Static, chart};
use crate::numerics::linalg::{Matrix, norm};
use crate::numerics::roots;

/// Finds an equilibrium of `model`, at the time set last. Costs tens of evaluations of forces and tangent for
/// moderate bending, hundreds for very large bending. On failure the result holds the last valid state. An
/// interruption carries the last state and the path until then.
///
/// Fails before any evaluation if an option is invalid, or if the model does not resolve the start.
pub fn equilibrium(
    model: &mut dyn Static,
    options: &Options,
    monitor: Monitor<'_>,
) -> Result<Result<Equilibrium, Unfinished<Equilibrium>>, InvalidInput> {
    options.check(model.facts().n)?;
    if let Start::Descent(q0) | Start::Newton(q0) = &options.start {
        model.check_shape(q0, "q0")?;
    }
    let found = search_with_options(model, options, monitor)?.map(|found| advised(model, found));
    Ok(found.map_err(|interrupted| {
        if model.facts().constraints() == 0 {
            return interrupted.unfinished(model, &options.start);
        }
        let near = options.start.shape(model.facts().n);
        interrupted.unfinished(&mut AsSprings::new(model, &near), &options.start)
    }))
}

/// The same with its deepest overlap, and with advice on contacts, stops and tendons.
fn advised(model: &mut dyn Static, mut found: Equilibrium) -> Equilibrium {
    found.deepest = model.deepest_overlap(&found.q);
    let last = [&found.q[..]];
    let failed: &[&[f64]] = if found.status.is_success() { &[] } else { &last[..] };
    found.message += &model.advice_at_end(failed, found.deepest);
    found
}

fn search_with_options(
    model: &mut dyn Static,
    options: &Options,
    monitor: Monitor<'_>,
) -> Result<Result<Equilibrium, InterruptedSearch>, InvalidInput> {
    let rest = vec![0.0; model.facts().n];
    match &options.start {
        Start::Unloaded { stops } if tied::is_closed_at_rest(model) => {
            Ok(load(model, stops, options, monitor))
        }
        Start::Unloaded { .. } => {
            let start = tied::closed(model, &rest)?;
            Ok(release(model, &start, options, true, monitor))
        }
        Start::Descent(q0) => {
            let start = tied::closed(model, q0)?;
            Ok(release(model, &start, options, true, monitor))
        }
        Start::Newton(q0) => {
            let mut tried = Counters::default();
            let mut first = None;
            // With tendons that may be slack or taut, the search determines the active ones.
            if !model.facts().is_one_sided {
                match near(model, q0, options, &mut *monitor) {
                    Ok(found) if !found.status.is_success() => (tried, first) = (found.counters, Some(found)),
                    Ok(found) if !is_free(model, [q0, &found.q]) => tried = found.counters,
                    Ok(found) => return Ok(Ok(found)),
                    Err(interrupted) => return Ok(Err(interrupted)),
                }
            }
            let start = tied::closed(model, q0)?;
            Ok(release(model, &start, options, false, monitor).map(|searched| {
                let counters = tried + searched.counters;
                let found = match first {
                    Some(first) if !searched.status.is_success() => first,
                    _ => searched,
                };
                Equilibrium { counters, ..found }
            }))
        }
    }
}

/// Follows the path of equilibria of `model` over the load factor, at the time set last. If inputs grow, the
/// model is left with those of the last point. An interruption carries the path until then.
///
/// Fails before any evaluation if an option is invalid, or if the model does not resolve the start.
pub fn continuation(
    model: &mut dyn Static,
    options: &ContinuationOptions,
    monitor: Monitor<'_>,
) -> Result<Result<Continuation, Unfinished<Continuation>>, InvalidInput> {
    options.check(model.facts().n, model.facts().inputs())?;
    if let Some(q0) = &options.q0 {
        model.check_shape(q0, "q0")?;
    }
    let (mut options, mut counters) = (options.clone(), Counters::default());
    if let (Some(inputs), None) = (&options.inputs, &options.q0) {
        let search = Options {
            tol: options.tol,
            max_steps: options.max_steps,
            stability: false,
            ..Options::default()
        };
        let set = LoadParameter::of_inputs(inputs, model.facts().n).set(model, options.load_factor);
        let found = match set {
            Ok(()) => search_with_options(model, &search, &mut *monitor)?,
            Err(interrupted) => Err(interrupted.into()),
        };
        let Ok(found) = found else { return Ok(Err(not_begun(model, &options))) };
        counters = found.counters;
        options.q0 = found.status.is_success().then_some(found.q);
    }
    Ok(match model.facts().constraints() {
        0 => follow(model, &options, counters, monitor),
        _ => tied::continuation(model, &options, counters, monitor)?,
    })
}

/// A continuation that was interrupted before its path began.
fn not_begun(model: &dyn Static, options: &ContinuationOptions) -> Unfinished<Continuation> {
    let (status, path) = (Status::Interrupted, Path::default());
    let message = outcome::message(model, status, options.load_factor, true, None, &path);
    Unfinished::new(Continuation { path, status, message, counters: Counters::default() })
}

/// Follows a path of equilibria of a model without constraints. `counters` is what its start has cost.
fn follow(
    model: &mut dyn Static,
    options: &ContinuationOptions,
    counters: Counters,
    monitor: Monitor<'_>,
) -> Result<Continuation, Unfinished<Continuation>> {
    let n = model.facts().n;
    let near = options.q0.clone().unwrap_or_else(|| vec![0.0; n]);
    let load_parameter =
        options.inputs.as_ref().map_or(LoadParameter::Loads, |inputs| LoadParameter::of_inputs(inputs, n));
    let mut equations = Equations::new(model, load_parameter, &near, monitor);
    equations.counters = counters;
    equations.judges = options.stability;
    let mut path = Path::default();
    let (status, load_factor) =
        follow_along(&mut path, &mut equations, near, options).unwrap_or_else(|Interrupted| {
            (Status::Interrupted, path.load_factor.last().copied().unwrap_or(options.load_factor))
        });
    let mut message = outcome::message(equations.model, status, load_factor, true, None, &path);
    if let (Status::Invalid(_), Some(last)) = (status, path.q.chunks_exact(n).next_back()) {
        let deepest = equations.model.deepest_overlap(last);
        message += &equations.model.advice_at_end(&[last], deepest);
    }
    let followed = Continuation { path, status, message, counters: equations.counters };
    if status == Status::Interrupted { Err(Unfinished::new(followed)) } else { Ok(followed) }
}

/// Fills a path as far as it can be followed; returns how it ends, and its last load factor.
fn follow_along(
    path: &mut Path,
    equations: &mut Equations<'_>,
    near: Vec<f64>,
    options: &ContinuationOptions,
) -> Result<(Status, f64), Interrupted> {
    let limits = PathLimits {
        bounds: options.bounds,
        stops: vec![options.bounds[1]],
        max_step: options.max_step,
        max_steps: options.max_steps,
        tolerance: options.tol,
    };
    let start = equations.state(near, options.load_factor)?;
    let mut follower = Follower::new(equations, limits);
    let end = follow_from(&mut follower, start, options);
    *path = follower.path;
    end
}

fn follow_from(
    follower: &mut Follower<'_, '_>,
    start: State,
    options: &ContinuationOptions,
) -> Result<(Status, f64), Interrupted> {
    let mut place = follower.start(start.clone(), options.direction.as_deref())?;
    if place.is_none() && options.q0.is_none() && follower.invalid_shape.is_none() {
        // Newton's method alone does not find springs at rest beyond stops, from before these.
        let mut state = start;
        let max_iter = Options::default().max_iter;
        let ended = descent::descend(follower.equations, &mut state, options.tol, max_iter)?;
        if matches!(ended, Descent::Converged { .. }) {
            place = follower.start(state, options.direction.as_deref())?;
        }
    }
    Ok(match place {
        None => (follower.invalid_shape.map_or(Status::NoStart, Status::Invalid), options.load_factor),
        Some(mut place) => {
            let end = follower.follow(&mut place)?;
            (Status::of_continuation(end), place.state.load_factor)
        }
    })
}

impl Status {
    fn of_continuation(end: End) -> Self {
        match end {
            End::UpperBound | End::LowerBound => Self::Finished,
            End::StepTooSmall => Self::StepTooSmall,
            End::TooManySteps => Self::TooManySteps,
            End::Invalid(invalid_shape) => Self::Invalid(invalid_shape),
        }
    }
}

/// Largest relative change of forces that balances them in an equilibrium (`search::balance`): above the residual of converged shapes, 1e-10
/// of the largest forces, and below any missing force.
const BALANCED_FORCES: f64 = 1e-4;

/// Follows the path of growing loads; if the path ends early, releases the model there.
fn load(
    model: &mut dyn Static,
    stops: &[f64],
    options: &Options,
    monitor: Monitor<'_>,
) -> Result<Equilibrium, InterruptedSearch> {
    let rest = vec![0.0; model.facts().n];
    // Only the end of the path is judged: a verdict on each of its points would cost more than the points.
    let unjudged = Options { stability: false, ..options.clone() };
    let followed = if model.facts().constraints() > 0 {
        model.release_open(&rest, None);
        let mut with_springs = AsSprings::new(model, &rest);
        let mut equations = judging(&mut with_springs, &rest, &unjudged, &mut *monitor);
        follow_loads(&mut equations, stops, options)?
    } else {
        let mut equations = judging(model, &rest, &unjudged, &mut *monitor);
        follow_loads(&mut equations, stops, options)?
    };
    // Without loads the shape is not unique, as for a pendulum: it is released under the full load.
    let Some(Followed { found, end, path, counters }) = followed else {
        return release(model, &rest, options, true, monitor);
    };
    let reached = found.state.load_factor;
    let mut state = found.state.clone();
    if end == End::UpperBound {
        if is_balanced(model, &state.q, &mut *monitor)? {
            return judged_at_end(model, found, path, counters, options, monitor);
        }
        // Such as one at which a tendon would have to push.
        state.load_factor = 1.0;
    }
    let released = release(model, &state.q, options, true, &mut *monitor)
        .map_err(|interrupted| interrupted.along(&path))?;
    if released.status.is_success() {
        let status = if end == End::UpperBound { Status::Converged } else { Status::Released };
        let message = outcome::message(model, status, reached, options.stability, released.verdict, &path);
        return Ok(Equilibrium { status, message, path, counters: counters + released.counters, ..released });
    }
    if end == End::UpperBound {
        return Ok(Equilibrium { path, counters: counters + released.counters, ..released });
    }
    judged_at_end(model, found, path, counters + released.counters, options, monitor)
}

/// Adds stability of the last point of a path of loads, and to that point.
fn judged_at_end(
    model: &mut dyn Static,
    found: Found,
    path: Path,
    counters: Counters,
    options: &Options,
    monitor: Monitor<'_>,
) -> Result<Equilibrium, InterruptedSearch> {
    let mut equilibrium = judged(model, found, path, counters, options, monitor)?;
    if let Some(last) = equilibrium.path.stability.last_mut() {
        *last = equilibrium.verdict.map(|verdict| verdict.stability);
    }
    Ok(equilibrium)
}

/// The end of a path of loads.
struct Followed {
    found: Found,
    end: End,
    path: Path,
    counters: Counters,
}

/// Follows the path of growing loads to its end; `None` if there is no unique shape without loads.
fn follow_loads(
    equations: &mut Equations<'_>,
    stops: &[f64],
    options: &Options,
) -> Result<Option<Followed>, InterruptedSearch> {
    let limits = PathLimits {
        bounds: [f64::NEG_INFINITY, 1.0],
        stops: stops.to_vec(),
        max_step: f64::INFINITY,
        max_steps: options.max_steps,
        tolerance: options.tol,
    };
    let start = equations.state(vec![0.0; equations.n()], 0.0)?;
    let mut follower = Follower::new(equations, limits);
    let Some(mut place) = follower.start(start, None)? else { return Ok(None) };
    let followed = follower.follow(&mut place);
    let path = follower.path;
    let end = followed.map_err(|Interrupted| InterruptedSearch::at(&place.state, &path, equations))?;
    let status = if end == End::UpperBound { Status::Converged } else { Status::of_continuation(end) };
    let found = Found::new(status, place.state, place.corrected.step_norm, place.corrected.residual_norm);
    Ok(Some(Followed { found, end, path, counters: equations.counters }))
}

/// Whether all forces of a shape balance, measured by true moments, which do not vanish where rotation vectors are singular.
fn is_balanced(model: &mut dyn Static, q: &[f64], monitor: Monitor<'_>) -> Result<bool, Interrupted> {
    // Only rotation vectors have singularities, and only constraints can have inadmissible signs.
    let is_regular = model.facts().rotation_vectors.is_empty() && model.facts().constraints() == 0;
    Ok(is_regular || search::error_of_balance(model, q, monitor)? <= BALANCED_FORCES)
}

/// Searches the equilibrium at which a released shape comes to rest; leaves saddles if it has to be stable.
fn release(
    model: &mut dyn Static,
    q0: &[f64],
    options: &Options,
    is_stable: bool,
    monitor: Monitor<'_>,
) -> Result<Equilibrium, InterruptedSearch> {
    let mut tried = Counters::default();
    if is_stable && model.facts().springs > 0 {
        // For large turns, the second derivatives of supports' moments differ from those that the search assumes.
        let descended = without_potential(model, q0, options, &mut *monitor)?;
        if descended.status.is_success() {
            return Ok(descended);
        }
        tried = descended.counters;
    }
    if is_stable && model.facts().has_tendon_friction && !model.facts().is_one_sided {
        return without_potential(model, q0, options, monitor);
    }
    let goal = search::Goal { tolerance: options.tol, max_iter: options.max_iter, is_stable };
    let search::Found { q, ended, step_norm, residual_norm, multipliers, counters } =
        search::search(model, q0, goal, &mut *monitor)?;
    let counters = tried + counters;
    let status = match ended {
        Ended::Converged => Status::Converged,
        Ended::IterationLimit => Status::IterationLimit,
        Ended::Stalled => Status::Stalled,
        Ended::Unheld => Status::Unheld,
        Ended::Invalid(invalid_shape) => Status::Invalid(invalid_shape),
        Ended::NonFinite => Status::NonFinite,
        Ended::WithoutPotential => {
            let mut descended = without_potential(model, &q, options, monitor)?;
            descended.counters = counters + descended.counters;
            return Ok(descended);
        }
    };
    if model.facts().is_one_sided {
        model.release(&multipliers);
    }
    let state = State { q, load_factor: 1.0, forces: Vec::new() };
    judged(
        model,
        Found { multipliers: Some(multipliers), ..Found::new(status, state, step_norm, residual_norm) },
        Path::default(),
        counters,
        options,
        monitor,
    )
}

/// Descent under loads without a potential, such as follower loads. Its end is tested by true moments: at a turn of 2 pi the generalised
/// forces of rotation vectors vanish under any moment; the descent then continues from the folded shape.
fn without_potential(
    model: &mut dyn Static,
    q0: &[f64],
    options: &Options,
    monitor: Monitor<'_>,
) -> Result<Equilibrium, InterruptedSearch> {
    until_balanced(model, q0, monitor, |model, q, monitor| {
        let has_contact = model.facts().has_contact;
        let of = |equations: &mut Equations<'_>| match has_contact {
            true => descend_onto_surfaces(equations, q, options),
            false => descend_from(equations, q, options),
        };
        if model.facts().constraints() == 0 {
            return of(&mut judging(model, q, options, monitor));
        }
        let mut with_springs = AsSprings::new(model, q);
        let found = of(&mut judging(&mut with_springs, q, options, &mut *monitor))?;
        let found = tied::judged(model, found, None, options);
        match found.status {
            Status::Stalled | Status::IterationLimit => beside(model, found, options, monitor),
            _ => Ok(found),
        }
    })
}

/// The equilibrium that Newton's method finds close to the end of a descent, if any. With almost rigid springs in place of loops, rounding
/// of forces can stop a descent although an equilibrium is closer than 1e-7; Newton's method on shape and multipliers finds it.
fn beside(
    model: &mut dyn Static,
    found: Equilibrium,
    options: &Options,
    monitor: Monitor<'_>,
) -> Result<Equilibrium, InterruptedSearch> {
    let nearby = near(model, &found.q, options, monitor)?;
    let ends = [&found.q[..], &nearby.q[..]];
    let counters = found.counters + nearby.counters;
    let is_found = nearby.status.is_success() && apart(model, ends) <= NEARBY && is_free(model, ends);
    Ok(Equilibrium { counters, ..if is_found { nearby } else { found } })
}

/// Whether surfaces neither pass through each other nor are sunk on the straight path between two shapes: Newton's method does not look.
fn is_free(model: &mut dyn Static, ends: [&[f64]; 2]) -> bool {
    let length = apart(model, ends);
    Passage::between(model, ends, length) == Passage::Free
}

/// Length of the step between two shapes, in sizes of coordinates.
fn apart(model: &mut dyn Static, [from, to]: [&[f64]; 2]) -> f64 {
    let mut sizes = vec![0.0; from.len()];
    model.sizes(from, &mut sizes);
    let step = chart::step_between(&model.facts().rotation_vectors, from, to);
    norm(&step.iter().zip(&sizes).map(|(x, size)| x / size).collect::<Vec<_>>())
}

/// Repeats a search from its folded last shape until that is in equilibrium by true moments.
fn until_balanced(
    model: &mut dyn Static,
    q0: &[f64],
    monitor: Monitor<'_>,
    mut search: impl FnMut(&mut dyn Static, &[f64], Monitor<'_>) -> Result<Equilibrium, InterruptedSearch>,
) -> Result<Equilibrium, InterruptedSearch> {
    /// Maximum number of repetitions; one is usually enough.
    const MAX_REPETITIONS: usize = 4;
    let mut q = q0.to_vec();
    let mut counters = Counters::default();
    for time in 1..=MAX_REPETITIONS {
        chart::fold(&model.facts().rotation_vectors, &mut q);
        let found = search(model, &q, &mut *monitor)?;
        counters = counters + found.counters;
        let found = Equilibrium { counters, ..found };
        if !found.status.is_success() || is_balanced(model, &found.q, &mut *monitor)? {
            return Ok(found);
        }
        if time == MAX_REPETITIONS {
            let message =
                outcome::message(model, Status::Stalled, found.load_factor, true, None, &found.path);
            return Ok(Equilibrium { status: Status::Stalled, message, ..found });
        }
        q = found.q;
    }
    unreachable!("the last search is returned")
}

/// Finds the equilibrium nearest to a shape, stable or not, by Newton's method.
fn near(
    model: &mut dyn Static,
    q0: &[f64],
    options: &Options,
    monitor: Monitor<'_>,
) -> Result<Equilibrium, InterruptedSearch> {
    until_balanced(model, q0, &mut *monitor, |model, q, monitor| {
        if model.facts().constraints() == 0 {
            return newton(&mut judging(model, q, options, monitor), q, options);
        }
        // Newton's method on shape and multipliers, which closes the loops, suffices from nearby.
        let approached = tied_newton::approach(model, q, options, &mut *monitor)?;
        if let Some(found) = approached.judged(model, options) {
            return Ok(found);
        }
        let counters = approached.counters();
        judged(model, approached.into(), Path::default(), counters, options, monitor)
    })
}

/// Number of descent iterations before Newton's method is tried, and the factor between successive tries.
const FIRST_ITERATIONS: usize = 50;
const ITERATIONS_FACTOR: usize = 4;

/// Newton's result counts as the equilibrium of the descent if it is no farther away than this, in scaled
/// coordinates.
const NEARBY: f64 = 0.1;

/// Descent onto surfaces, with occasional attempts of Newton's method. If nothing determines where on a floor
/// a body lies, descent alone is slow. If the descent stalls, as it can at kinks when work is computed from
/// forces, it is repeated with the energies of overlaps, which handle kinks but are consistent with the
/// forces only up to the error of their integrals.
fn descend_onto_surfaces(
    equations: &mut Equations<'_>,
    q0: &[f64],
    options: &Options,
) -> Result<Equilibrium, InterruptedSearch> {
    let has_ended = |found: &Equilibrium| !matches!(found.status, Status::Stalled | Status::IterationLimit);
    let mut first = None;
    for knows_overlaps in [false, true] {
        equations.knows_overlaps = knows_overlaps;
        let (mut q, mut left, mut length) = (q0.to_vec(), options.max_iter, FIRST_ITERATIONS);
        loop {
            let max_iter = length.min(left);
            let descended = descend_from(equations, &q, &Options { max_iter, ..options.clone() })?;
            if has_ended(&descended) {
                return Ok(descended);
            }
            let nearby = newton(equations, &descended.q, options)?;
            let ends = [&descended.q[..], &nearby.q[..]];
            let moved = nearby.q.iter().zip(&descended.q).zip(&equations.sizes);
            let distance = norm(&moved.map(|((a, b), size)| (a - b) / size).collect::<Vec<_>>());
            // Other equilibria are left to the descent.
            let mut is_neutral = || -> Result<bool, Interrupted> {
                let state = equations.state(nearby.q.clone(), 1.0)?;
                let verdict = equations.verdict(&state)?;
                Ok(verdict.is_some_and(|verdict| verdict.stability == Stability::Neutral))
            };
            let is_at_end = descended.status == Status::Stalled || max_iter == left;
            let is_end = nearby.status.is_success() && (is_at_end || distance <= NEARBY && is_neutral()?);
            if is_end && equations.passage(ends, distance) == Passage::Free {
                return Ok(nearby);
            }
            (left, length) = (left - max_iter, ITERATIONS_FACTOR * length);
            q.copy_from_slice(&descended.q);
            if is_at_end {
                first.get_or_insert(descended);
                break;
            }
        }
    }
    Ok(first.expect("both ways end"))
}

/// Descent from a shape.
fn descend_from(
    equations: &mut Equations<'_>,
    q0: &[f64],
    options: &Options,
) -> Result<Equilibrium, InterruptedSearch> {
    let mut state = equations.state(q0.to_vec(), 1.0)?;
    let descent = descent::descend(equations, &mut state, options.tol, options.max_iter)
        .map_err(|Interrupted| InterruptedSearch::at(&state, &Path::default(), equations))?;
    let (status, step_norm, residual_norm) = match descent {
        Descent::Converged { step_norm, residual_norm } => (Status::Converged, step_norm, residual_norm),
        Descent::IterationLimit => (Status::IterationLimit, f64::NAN, f64::NAN),
        Descent::Stalled => (Status::Stalled, f64::NAN, f64::NAN),
        Descent::Invalid(invalid_shape) => (Status::Invalid(invalid_shape), f64::NAN, f64::NAN),
        Descent::NonFinite => (Status::NonFinite, f64::NAN, f64::NAN),
    };
    judge(equations, Found::new(status, state, step_norm, residual_norm), Path::default())
}

/// The equations at a fixed load factor, in scaled coordinates, as a system for [`roots::Newton`].
struct FixedLoadSystem<'a, 'b> {
    equations: &'a mut Equations<'b>,
    q: Vec<f64>,
    load: Vec<f64>,
}

impl FixedLoadSystem<'_, '_> {
    fn set(&mut self, x: &[f64]) {
        for i in 0..x.len() {
            self.q[i] = x[i] * self.equations.sizes[i];
        }
    }
}

impl roots::NonlinearSystem for FixedLoadSystem<'_, '_> {
    fn unknowns(&self) -> usize {
        self.load.len()
    }

    fn residual(&mut self, x: &[f64], residual: &mut [f64]) -> Result<(), Interrupted> {
        self.set(x);
        self.equations.residual(&self.q, 1.0, residual, &mut self.load)
    }

    fn jacobian(&mut self, x: &[f64], jacobian: &mut Matrix) -> Result<(), Interrupted> {
        self.set(x);
        self.equations.tangent(&self.q, 1.0, jacobian)
    }
}

/// Finds the nearest equilibrium, stable or not.
fn newton(
    equations: &mut Equations<'_>,
    q0: &[f64],
    options: &Options,
) -> Result<Equilibrium, InterruptedSearch> {
    let n = equations.n();
    let search = roots::Options {
        method: roots::Method::TrustRegion,
        residual_tolerance: 0.0,
        step_tolerance: roots::StepTolerance { absolute: options.tol / (n as f64).sqrt(), relative: 0.0 },
        max_iter: options.max_iter,
        ..roots::Options::default()
    };
    let mut x: Vec<f64> = q0.iter().zip(&equations.sizes).map(|(q, size)| q / size).collect();
    let mut system = FixedLoadSystem { equations, q: q0.to_vec(), load: vec![0.0; n] };
    let solved = roots::Newton::new(n, n).solve(&mut system, &mut x, &search);
    system.set(&x);
    let mut state = State { q: system.q, load_factor: 1.0, forces: Vec::new() };
    let outcome = solved.map_err(|unfinished| {
        equations.counters.iterations += unfinished.into_inner().iterations;
        InterruptedSearch::at(&state, &Path::default(), equations)
    })?;
    state = equations.state(state.q, 1.0)?;
    equations.counters.iterations += outcome.iterations;
    let mut step_norm = if outcome.iterations == 0 { 0.0 } else { outcome.step_norm };
    let mut status =
        if outcome.status.is_success() { Status::Converged } else { Status::Newton(outcome.status) };
    if !status.is_success()
        && let Some(linear) = equations.linearise(&state)?
        && let Some(next) = corrector::newton_step(&linear)
        && next <= options.tol
    {
        // With stiff tendons and joints, rounding of the shape causes forces that no step can reduce.
        (status, step_norm) = (Status::Converged, next);
    }
    // Far away from the start, fading forces do not prove an equilibrium.
    let apart = state.q.iter().zip(q0).zip(&equations.sizes).map(|((q, q0), size)| (q - q0) / size);
    if status.is_success() && norm(&apart.collect::<Vec<_>>()) > search::UNSUPPORTED_STEP {
        status = Status::Unheld;
    }
    // The forces of stiff springs by the shape are rounding: the residual uses those of the state.
    let residual_norm = if state.forces.is_empty() { outcome.residual_norm } else { f64::NAN };
    judge(equations, Found::new(status, state, step_norm, residual_norm), Path::default())
}

/// Result of a search, before stability is judged.
struct Found {
    status: Status,
    state: State,
    step_norm: f64,
    residual_norm: f64,
    /// Multipliers of the constraints, if known.
    multipliers: Option<Vec<f64>>,
}

impl Found {
    fn new(status: Status, state: State, step_norm: f64, residual_norm: f64) -> Self {
        Self { status, state, step_norm, residual_norm, multipliers: None }
    }
}

/// The equations under full loads near a shape.
fn judging<'a>(
    model: &'a mut dyn Static,
    near: &[f64],
    options: &Options,
    monitor: Monitor<'a>,
) -> Equations<'a> {
    let mut equations = Equations::new(model, LoadParameter::Loads, near, monitor);
    equations.judges = options.stability;
    equations
}

/// Adds stability; for a model with constraints, by motions that satisfy them.
fn judged(
    model: &mut dyn Static,
    found: Found,
    path: Path,
    counters: Counters,
    options: &Options,
    monitor: Monitor<'_>,
) -> Result<Equilibrium, InterruptedSearch> {
    let (q, multipliers) = (found.state.q.clone(), found.multipliers.clone());
    let equilibrium = if model.facts().constraints() > 0 {
        let mut with_springs = AsSprings::new(model, &q);
        // Only motions that keep the loops closed decide stability.
        let quiet = Options { stability: false, ..options.clone() };
        judge(&mut judging(&mut with_springs, &q, &quiet, monitor), found, path)
    } else {
        judge(&mut judging(model, &q, options, monitor), found, path)
    };
    let equilibrium = equilibrium.map_err(|interrupted| interrupted.after(counters))?;
    let counters = counters + equilibrium.counters;
    Ok(Equilibrium { counters, ..tied::judged(model, equilibrium, multipliers.as_deref(), options) })
}

/// Adds stability from the tangent.
fn judge(equations: &mut Equations<'_>, found: Found, path: Path) -> Result<Equilibrium, InterruptedSearch> {
    let Found { mut status, mut state, step_norm, residual_norm, .. } = found;
    if state.forces.is_empty() {
        let q = state.q.clone();
        state = equations.state(state.q, state.load_factor).map_err(|Interrupted| {
            InterruptedSearch::with(Reached {
                q,
                load_factor: state.load_factor,
                path: path.clone(),
                counters: Counters::default(),
            })
        })?;
    }
    if status.is_success()
        && let Some(invalid_shape) =
            equations.invalid_shape(&state.q).or_else(|| equations.deep_penetration(&state.q))
    {
        status = Status::Invalid(invalid_shape);
    }
    let linear =
        equations.linearise(&state).map_err(|Interrupted| InterruptedSearch::at(&state, &path, equations))?;
    let stiffness = linear.as_ref().map(Stiffness::new);
    let verdict = if status.is_success() {
        equations.judgement(&state).map_err(|Interrupted| InterruptedSearch::at(&state, &path, equations))?
    } else {
        None
    };
    let State { mut q, load_factor, .. } = state;
    equations.wrap(&mut q);
    let norm_of_state = linear.as_ref().map_or(f64::NAN, |linear| linear.residual_norm);
    Ok(Equilibrium {
        message: outcome::message(equations.model, status, load_factor, equations.judges, verdict, &path),
        load_factor,
        q,
        status,
        residual_norm: if residual_norm.is_nan() { norm_of_state } else { residual_norm },
        step_norm,
        verdict,
        lowest: stiffness.map_or(f64::NAN, |stiffness| stiffness.lowest),
        path,
        deepest: None,
        counters: equations.counters,
    })
}
