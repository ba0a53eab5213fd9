//! Statics: equilibria of models, and their stability.
//!
//! [`equilibrium`] finds an equilibrium by following the path of growing loads, by descent from a shape, or
//! by Newton's method nearby. [`continuation`] follows paths through limit points and from bifurcations. Both
//! report stability.
//!
//! `equations` contains the forces under a part of the load (`growth`), `corrector` Newton's method that
//! stays on its path, `path` continuation, `descent` the search for stable equilibria, `stability` the search
//! for critical points, `tendons` the detection of slack tendons, and `tied` models with closed loops.
//! [`crate::stability`] judges stability.
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

mod corrector;
mod descent;
mod equations;
mod growth;
mod options;
mod outcome;
mod path;
mod stability;
mod tendons;
mod tied;
mod tied_newton;

pub use equations::Counters;
pub use growth::InputPath;
pub use options::{ContinuationOptions, ITERATIONS_OF_CONTACT, MAX_STOPS, Options, Start};
pub use outcome::{Continuation, Equilibrium, Status};
pub use path::{CriticalKind, CriticalPoint, Path};
pub use tendons::Tendons;

use descent::Descent;
use equations::{Equations, State};
use growth::Growth;
use path::{Course, End, Follower};
use stability::Stiffness;

use crate::error::{Interrupted, InvalidInput, Unfinished};
use crate::linalg::{Matrix, norm};
use crate::model::Model;
use crate::roots;
pub use crate::stability::{Stability, Verdict};

/// Called before every evaluation; may stop a search.
pub type Monitor<'a> = &'a mut dyn FnMut() -> Result<(), Interrupted>;

/// Finds an equilibrium of `model`, at the time set last. Costs tens of evaluations of forces and tangent for
/// moderate bending, hundreds for very large bending. On failure the result holds the last valid state. An
/// interruption carries the last state and the path until then.
///
/// Fails before any evaluation if an option is invalid, or if the model does not resolve the start.
pub fn equilibrium(
    model: &mut dyn Model,
    options: &Options,
    monitor: Monitor<'_>,
) -> Result<Result<Equilibrium, Unfinished<Equilibrium>>, InvalidInput> {
    options.check(model.n())?;
    if let Start::Descent(q0) | Start::Newton(q0) = &options.start {
        model.check_shape(q0, "q0")?;
    }
    if model.constraints() > 0 {
        return tied::equilibrium(model, options, monitor);
    }
    let has_contact = model.has_contact();
    let mut equations = Equations::new(model, Growth::Loads, monitor);
    let found = match &options.start {
        Start::Unloaded { stops } => load(&mut equations, stops, options),
        Start::Descent(q0) if has_contact => lay(&mut equations, q0, options),
        Start::Descent(q0) => let_go(&mut equations, q0, options),
        Start::Newton(q0) => newton(&mut equations, q0, options),
    };
    Ok(found.map_err(|halted| halted.unfinished(model, &options.start)))
}

/// Follows the path of equilibria of `model` over the load factor, at the time set last. If inputs grow, the
/// model is left with those of the last point. An interruption carries the path until then.
///
/// Fails before any evaluation if an option is invalid, or if the model does not resolve the start.
pub fn continuation(
    model: &mut dyn Model,
    options: &ContinuationOptions,
    monitor: Monitor<'_>,
) -> Result<Result<Continuation, Unfinished<Continuation>>, InvalidInput> {
    options.check(model.n(), model.inputs())?;
    if let Some(q0) = &options.q0 {
        model.check_shape(q0, "q0")?;
    }
    if model.constraints() > 0 {
        return tied::continuation(model, options, monitor);
    }
    let n = model.n();
    let mut equations = Equations::new(model, Growth::Loads, monitor);
    let grown = options.inputs.as_ref().map(|inputs| Growth::of_inputs(inputs, n));
    Ok(follow(&mut equations, options, grown))
}

/// Shape to which loads growing from zero lead, at the inputs of a load factor.
fn loaded(
    equations: &mut Equations<'_>,
    options: &ContinuationOptions,
) -> Result<Option<Vec<f64>>, Interrupted> {
    let search = Options { tol: options.tol, max_steps: options.max_steps, ..Options::default() };
    let found = load(equations, &[1.0], &search).map_err(|_| Interrupted)?;
    Ok(found.status.is_success().then_some(found.q))
}

fn follow(
    equations: &mut Equations<'_>,
    options: &ContinuationOptions,
    inputs: Option<Growth>,
) -> Result<Continuation, Unfinished<Continuation>> {
    let mut path = Path::default();
    let (status, load_factor) =
        follow_along(&mut path, equations, options, inputs).unwrap_or_else(|Interrupted| {
            (Status::Interrupted, path.load_factor.last().copied().unwrap_or(options.load_factor))
        });
    let message = outcome::message(status, load_factor, None, &path);
    let followed = Continuation { path, status, message, counters: equations.counters };
    if status == Status::Interrupted { Err(Unfinished::new(followed)) } else { Ok(followed) }
}

/// Fills a path as far as it can be followed; returns how it ends, and its last load factor.
fn follow_along(
    path: &mut Path,
    equations: &mut Equations<'_>,
    options: &ContinuationOptions,
    inputs: Option<Growth>,
) -> Result<(Status, f64), Interrupted> {
    let course = Course {
        bounds: options.bounds,
        stops: vec![options.bounds[1]],
        max_step: options.max_step,
        max_steps: options.max_steps,
        tolerance: options.tol,
    };
    let mut q = options.q0.clone().unwrap_or_else(|| vec![0.0; equations.n()]);
    if let Some(mut inputs) = inputs {
        equations.set_inputs_of(&mut inputs, options.load_factor)?;
        if options.q0.is_none()
            && let Some(loaded) = loaded(equations, options)?
        {
            q = loaded;
        }
        equations.grow(inputs);
    }
    let start = equations.state(q, options.load_factor)?;
    let mut follower = Follower::new(equations, course);
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
    if place.is_none() && options.q0.is_none() && follower.flaw.is_none() {
        // Newton's method alone does not find springs at rest beyond stops, from before these.
        let mut settled = start;
        let max_iter = Options::default().max_iter;
        let ended = descent::descend(follower.equations, &mut settled, options.tol, max_iter)?;
        if matches!(ended, Descent::Converged { .. }) {
            place = follower.start(settled, options.direction.as_deref())?;
        }
    }
    Ok(match place {
        None => (follower.flaw.map_or(Status::NoStart, Status::Flawed), options.load_factor),
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
            End::Flawed(flaw) => Self::Flawed(flaw),
        }
    }
}

/// Follows the path of growing loads; if the path ends early, releases the model there.
fn load(equations: &mut Equations<'_>, stops: &[f64], options: &Options) -> Result<Equilibrium, Halted> {
    let course = Course {
        bounds: [f64::NEG_INFINITY, 1.0],
        stops: stops.to_vec(),
        max_step: f64::INFINITY,
        max_steps: options.max_steps,
        tolerance: options.tol,
    };
    let n = equations.n();
    let start = equations.state(vec![0.0; n], 0.0)?;
    let mut follower = Follower::new(equations, course);
    let Some(mut place) = follower.start(start, None)? else {
        // Without loads the shape is not unique, as for a pendulum: release it under the full load.
        return let_go(equations, &vec![0.0; n], options);
    };
    let followed = follower.follow(&mut place);
    let path = follower.path;
    let end = followed.map_err(|Interrupted| Halted::at(&place.state, &path, equations))?;
    if end == End::UpperBound {
        let found = Found {
            status: Status::Converged,
            state: place.state,
            step_norm: place.corrected.step_norm,
            residual_norm: place.corrected.residual_norm,
        };
        return judge(equations, found, path);
    }
    let reached = place.state.load_factor;
    let last = place.state.clone();
    let released = let_go(equations, &place.state.q, options).map_err(|halted| halted.along(&path))?;
    if released.status.is_success() {
        let message = outcome::message(Status::LetGo, reached, released.verdict, &path);
        return Ok(Equilibrium { status: Status::LetGo, message, path, ..released });
    }
    let found = Found {
        status: Status::of_continuation(end),
        state: last,
        step_norm: place.corrected.step_norm,
        residual_norm: place.corrected.residual_norm,
    };
    judge(equations, found, path)
}

/// Number of descent iterations before Newton's method is tried, and the factor between successive tries.
const FIRST_LEG: usize = 50;
const LONGER_LEG: usize = 4;

/// Newton's result counts as the equilibrium of the descent if it is no farther away than this, in scaled
/// coordinates.
const NEARBY: f64 = 0.1;

/// Descent onto surfaces, with occasional attempts of Newton's method. If nothing determines where on a floor
/// a body lies, descent alone is slow. If the descent stalls, as it can at kinks when work is computed from
/// forces, it is repeated with the energies of overlaps, which handle kinks but are consistent with the
/// forces only up to the error of their integrals.
fn lay(equations: &mut Equations<'_>, q0: &[f64], options: &Options) -> Result<Equilibrium, Halted> {
    let has_ended = |found: &Equilibrium| !matches!(found.status, Status::Stalled | Status::IterationLimit);
    let mut first = None;
    for knows_overlaps in [false, true] {
        equations.knows_overlaps = knows_overlaps;
        let (mut q, mut left, mut leg) = (q0.to_vec(), options.max_iter, FIRST_LEG);
        loop {
            let max_iter = leg.min(left);
            let laid = let_go(equations, &q, &Options { max_iter, ..options.clone() })?;
            if has_ended(&laid) {
                return Ok(laid);
            }
            let nearby = newton(equations, &laid.q, options)?;
            let moved =
                nearby.q.iter().zip(&laid.q).zip(&equations.sizes).map(|((a, b), size)| (a - b) / size);
            let is_near = norm(&moved.collect::<Vec<_>>()) <= NEARBY;
            // Other equilibria are left to the descent.
            let is_free = nearby.verdict.is_some_and(|verdict| verdict.stability == Stability::Neutral);
            let is_at_end = laid.status == Status::Stalled || max_iter == left;
            if nearby.status.is_success() && (is_at_end || is_near && is_free) {
                return Ok(nearby);
            }
            (left, leg) = (left - max_iter, LONGER_LEG * leg);
            q.copy_from_slice(&laid.q);
            if is_at_end {
                first.get_or_insert(laid);
                break;
            }
        }
    }
    Ok(first.expect("both ways end"))
}

/// Descent from a shape.
fn let_go(equations: &mut Equations<'_>, q0: &[f64], options: &Options) -> Result<Equilibrium, Halted> {
    let mut state = equations.state(q0.to_vec(), 1.0)?;
    let descent = descent::descend(equations, &mut state, options.tol, options.max_iter)
        .map_err(|Interrupted| Halted::at(&state, &Path::default(), equations))?;
    let (status, step_norm, residual_norm) = match descent {
        Descent::Converged { step_norm, residual_norm } => (Status::Converged, step_norm, residual_norm),
        Descent::IterationLimit => (Status::IterationLimit, f64::NAN, f64::NAN),
        Descent::Stalled => (Status::Stalled, f64::NAN, f64::NAN),
        Descent::Flawed(flaw) => (Status::Flawed(flaw), f64::NAN, f64::NAN),
        Descent::NonFinite => (Status::NonFinite, f64::NAN, f64::NAN),
    };
    judge(equations, Found { status, state, step_norm, residual_norm }, Path::default())
}

/// The equations at a fixed load factor, in scaled coordinates, as a system for [`roots::Newton`].
struct Nearby<'a, 'b> {
    equations: &'a mut Equations<'b>,
    q: Vec<f64>,
    load: Vec<f64>,
}

impl Nearby<'_, '_> {
    fn set(&mut self, x: &[f64]) {
        for i in 0..x.len() {
            self.q[i] = x[i] * self.equations.sizes[i];
        }
    }
}

impl roots::System for Nearby<'_, '_> {
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
fn newton(equations: &mut Equations<'_>, q0: &[f64], options: &Options) -> Result<Equilibrium, Halted> {
    let n = equations.n();
    let search = roots::Options {
        method: roots::Method::TrustRegion,
        residual_tolerance: 0.0,
        step_tolerance: roots::StepTolerance { absolute: options.tol / (n as f64).sqrt(), relative: 0.0 },
        max_iter: options.max_iter,
        ..roots::Options::default()
    };
    let mut x: Vec<f64> = q0.iter().zip(&equations.sizes).map(|(q, size)| q / size).collect();
    let mut system = Nearby { equations, q: q0.to_vec(), load: vec![0.0; n] };
    let solved = roots::Newton::new(n, n).solve(&mut system, &mut x, &search);
    system.set(&x);
    let mut state = State { q: system.q, load_factor: 1.0, forces: Vec::new() };
    let outcome = solved.map_err(|unfinished| {
        equations.counters.iterations += unfinished.into_inner().iterations;
        Halted::at(&state, &Path::default(), equations)
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
    // Rounding of the shape decides the forces of stiff springs: those of the state tell the residual.
    let residual_norm = if state.forces.is_empty() { outcome.residual_norm } else { f64::NAN };
    judge(equations, Found { status, state, step_norm, residual_norm }, Path::default())
}

/// Result of a search, before stability is judged.
struct Found {
    status: Status,
    state: State,
    step_norm: f64,
    residual_norm: f64,
}

/// An interrupted search, and what it had reached by then, if anything.
struct Halted(Option<Box<Reached>>);

struct Reached {
    q: Vec<f64>,
    load_factor: f64,
    path: Path,
    counters: Counters,
}

impl From<Interrupted> for Halted {
    fn from(_: Interrupted) -> Self {
        Self(None)
    }
}

impl Halted {
    fn at(state: &State, path: &Path, equations: &Equations<'_>) -> Self {
        let mut q = state.q.clone();
        equations.wrap(&mut q);
        let (path, counters) = (path.clone(), equations.counters);
        Self::with(Reached { q, load_factor: state.load_factor, path, counters })
    }

    fn with(reached: Reached) -> Self {
        Self(Some(Box::new(reached)))
    }

    /// The same after a path of loads.
    fn along(self, path: &Path) -> Self {
        Self(self.0.map(|reached| Box::new(Reached { path: path.clone(), ..*reached })))
    }

    /// The result until the interruption, with what is left of the forces. Evaluates them once.
    fn unfinished(self, model: &mut dyn Model, start: &Start) -> Unfinished<Equilibrium> {
        let n = model.n();
        let Reached { q, load_factor, path, counters } = self.0.map_or_else(
            || Reached {
                q: start.shape(n),
                load_factor: if matches!(start, Start::Unloaded { .. }) { 0.0 } else { 1.0 },
                path: Path::default(),
                counters: Counters::default(),
            },
            |reached| *reached,
        );
        let mut never = || Ok(());
        let mut equations = Equations::new(model, Growth::Loads, &mut never);
        let [mut residual, mut load] = [vec![0.0; n], vec![0.0; n]];
        // A function of time that has failed is not called again.
        let evaluated = equations.residual(&q, load_factor, &mut residual, &mut load);
        Unfinished::new(Equilibrium {
            message: outcome::message(Status::Interrupted, load_factor, None, &path),
            q,
            load_factor,
            status: Status::Interrupted,
            residual_norm: evaluated.map_or(f64::NAN, |()| norm(&residual)),
            step_norm: f64::NAN,
            verdict: None,
            lowest: f64::NAN,
            path,
            counters,
        })
    }
}

/// Adds stability from the tangent.
fn judge(equations: &mut Equations<'_>, found: Found, path: Path) -> Result<Equilibrium, Halted> {
    let Found { mut status, state, step_norm, residual_norm } = found;
    if status.is_success()
        && let Some(flaw) = equations.flaw(&state.q).or_else(|| equations.sunk(&state.q))
    {
        status = Status::Flawed(flaw);
    }
    let linear = equations.linearise(&state).map_err(|Interrupted| Halted::at(&state, &path, equations))?;
    let stiffness = linear.as_ref().map(Stiffness::new);
    let verdict = match (&linear, &stiffness) {
        (Some(linear), Some(stiffness)) if status.is_success() => equations
            .verdict(&state, linear, stiffness)
            .map_err(|Interrupted| Halted::at(&state, &path, equations))?,
        _ => None,
    };
    let State { mut q, load_factor, .. } = state;
    equations.wrap(&mut q);
    let own_norm = linear.as_ref().map_or(f64::NAN, |linear| linear.residual_norm);
    Ok(Equilibrium {
        message: outcome::message(status, load_factor, verdict, &path),
        load_factor,
        q,
        status,
        residual_norm: if residual_norm.is_nan() { own_norm } else { residual_norm },
        step_norm,
        verdict,
        lowest: stiffness.map_or(f64::NAN, |stiffness| stiffness.lowest),
        path,
        counters: equations.counters,
    })
}
