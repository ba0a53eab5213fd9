//! Equilibria of models: statics.
//!
//! [`equilibrium`] finds one, by following the path of growing loads, by letting a shape go, or by Newton's method nearby;
//! [`continuation`] follows paths through limit points and from bifurcations. Both tell how stable what they found is.
//!
//! `equations` are the forces under a part of the loads, `corrector` is Newton's method that stays on its path, `path` follows
//! it, `descent` lets go, `stability` judges.

mod corrector;
mod descent;
mod equations;
mod options;
mod outcome;
mod path;
mod stability;

pub use equations::Counters;
pub use options::{ContinuationOptions, MAX_STOPS, Options, Start};
pub use outcome::{Continuation, Equilibrium, Status};
pub use path::{CriticalKind, CriticalPoint, Path};
pub use stability::Stability;

use corrector::{Corrector, State};
use descent::Descent;
use equations::Equations;
use path::{Course, End, Follower};
use stability::{Judgement, Stiffness};

use crate::error::{Interrupted, InvalidInput};
use crate::linalg::{Matrix, norm};
use crate::model::Model;
use crate::roots;

/// What a search may ask before every evaluation: whether to go on.
pub type Monitor<'a> = &'a mut dyn FnMut() -> Result<(), Interrupted>;

/// An equilibrium of `model`, at the time last set. Some tens of evaluations of its forces and tangent for moderate bending,
/// some hundreds for very large one. The result holds the last good state whatever happens.
///
/// Fails before any evaluation when an option is wrong, or when the model does not resolve the start.
pub fn equilibrium(
    model: &mut dyn Model,
    options: &Options,
    monitor: Monitor<'_>,
) -> Result<Result<Equilibrium, Interrupted>, InvalidInput> {
    options.check(model.n())?;
    if let Start::Descent(q0) | Start::Newton(q0) = &options.start {
        model.check_shape(q0, "q0")?;
    }
    let mut equations = Equations::new(model, monitor);
    Ok(match &options.start {
        Start::Unloaded { stops } => load(&mut equations, stops, options),
        Start::Descent(q0) => let_go(&mut equations, q0, options),
        Start::Newton(q0) => newton(&mut equations, q0, options),
    })
}

/// The path of equilibria of `model` over the load factor, at the time last set.
///
/// Fails before any evaluation when an option is wrong, or when the model does not resolve the start.
pub fn continuation(
    model: &mut dyn Model,
    options: &ContinuationOptions,
    monitor: Monitor<'_>,
) -> Result<Result<Continuation, Interrupted>, InvalidInput> {
    options.check(model.n())?;
    if let Some(q0) = &options.q0 {
        model.check_shape(q0, "q0")?;
    }
    let mut equations = Equations::new(model, monitor);
    Ok(follow(&mut equations, options))
}

fn follow(equations: &mut Equations<'_>, options: &ContinuationOptions) -> Result<Continuation, Interrupted> {
    let course = Course {
        bounds: options.bounds,
        stops: vec![options.bounds[1]],
        max_step: options.max_step,
        max_steps: options.max_steps,
        tolerance: options.tolerance,
    };
    let q = options.q0.clone().unwrap_or_else(|| vec![0.0; equations.n()]);
    let start = State { q, load_factor: options.load_factor };
    let mut follower = Follower::new(equations, course);
    let (status, load_factor) = match follower.start(start, options.direction.as_deref())? {
        None => (Status::NoStart, options.load_factor),
        Some(mut place) => {
            let end = follower.follow(&mut place)?;
            (Status::of_continuation(end), place.state.load_factor)
        }
    };
    let path = follower.path;
    let message = outcome::message(status, load_factor, None, &path);
    Ok(Continuation { path, status, message, counters: equations.counters })
}

impl Status {
    fn of_continuation(end: End) -> Self {
        match end {
            End::UpperBound | End::LowerBound => Self::Finished,
            End::StepTooSmall => Self::StepTooSmall,
            End::TooManySteps => Self::TooManySteps,
        }
    }
}

/// By the path of growing loads; where that ends early, by letting go.
fn load(equations: &mut Equations<'_>, stops: &[f64], options: &Options) -> Result<Equilibrium, Interrupted> {
    let course = Course {
        bounds: [f64::NEG_INFINITY, 1.0],
        stops: stops.to_vec(),
        max_step: f64::INFINITY,
        max_steps: options.max_steps,
        tolerance: options.tolerance,
    };
    let n = equations.n();
    let mut follower = Follower::new(equations, course);
    let start = State { q: vec![0.0; n], load_factor: 0.0 };
    let Some(mut place) = follower.start(start, None)? else {
        // Unloaded it has no unique shape, as a pendulum: it is let go under the whole load.
        return let_go(equations, &vec![0.0; n], options);
    };
    let end = follower.follow(&mut place)?;
    let path = follower.path;
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
    let released = let_go(equations, &place.state.q, options)?;
    if released.status.is_success() {
        let judgement = released
            .stability
            .map(|stability| Judgement { stability, counts_velocities: released.counts_velocities });
        let message = outcome::message(Status::LetGo, reached, judgement, &path);
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

/// Downhill from a shape.
fn let_go(equations: &mut Equations<'_>, q0: &[f64], options: &Options) -> Result<Equilibrium, Interrupted> {
    let mut state = State { q: q0.to_vec(), load_factor: 1.0 };
    let descent = descent::descend(equations, &mut state, options.tolerance, options.max_iterations)?;
    let (status, step_norm, residual_norm) = match descent {
        Descent::Converged { step_norm, residual_norm } => (Status::Converged, step_norm, residual_norm),
        Descent::IterationLimit => (Status::IterationLimit, f64::NAN, f64::NAN),
        Descent::Stalled => (Status::Stalled, f64::NAN, f64::NAN),
        Descent::NonFinite => (Status::NonFinite, f64::NAN, f64::NAN),
    };
    judge(equations, Found { status, state, step_norm, residual_norm }, Path::default())
}

/// The equations at a fixed load factor as a system for [`roots::Newton`], in scaled coordinates.
struct Nearby<'a, 'b> {
    equations: &'a mut Equations<'b>,
    state: State,
    load: Vec<f64>,
}

impl Nearby<'_, '_> {
    fn set(&mut self, x: &[f64]) {
        for i in 0..x.len() {
            self.state.q[i] = x[i] * self.equations.sizes[i];
        }
    }
}

impl roots::System for Nearby<'_, '_> {
    fn unknowns(&self) -> usize {
        self.load.len()
    }

    fn residual(&mut self, x: &[f64], residual: &mut [f64]) -> Result<(), Interrupted> {
        self.set(x);
        self.equations.residual(&self.state.q, self.state.load_factor, residual, &mut self.load)
    }

    fn jacobian(&mut self, x: &[f64], jacobian: &mut Matrix) -> Result<(), Interrupted> {
        self.set(x);
        self.equations.tangent(&self.state.q, self.state.load_factor, jacobian);
        Ok(())
    }
}

/// To the nearest equilibrium, stable or not.
fn newton(equations: &mut Equations<'_>, q0: &[f64], options: &Options) -> Result<Equilibrium, Interrupted> {
    let n = equations.n();
    let search = roots::Options {
        method: roots::Method::TrustRegion,
        residual_tolerance: 0.0,
        step_tolerance: roots::StepTolerance {
            absolute: options.tolerance / (n as f64).sqrt(),
            relative: 0.0,
        },
        max_iterations: options.max_iterations,
        ..roots::Options::default()
    };
    let mut x: Vec<f64> = q0.iter().zip(&equations.sizes).map(|(q, size)| q / size).collect();
    let state = State { q: q0.to_vec(), load_factor: 1.0 };
    let mut system = Nearby { equations, state, load: vec![0.0; n] };
    let outcome = roots::Newton::new(n, n).solve(&mut system, &mut x, &search)?;
    system.set(&x);
    let state = system.state;
    equations.counters.iterations += outcome.iterations;
    let status = if outcome.status.is_success() { Status::Converged } else { Status::Newton(outcome.status) };
    let found = Found {
        status,
        state,
        step_norm: if outcome.iterations == 0 { 0.0 } else { outcome.step_norm },
        residual_norm: outcome.residual_norm,
    };
    judge(equations, found, Path::default())
}

/// What a search found, before it is judged.
struct Found {
    status: Status,
    state: State,
    step_norm: f64,
    residual_norm: f64,
}

/// Adds what the tangent says.
fn judge(equations: &mut Equations<'_>, found: Found, path: Path) -> Result<Equilibrium, Interrupted> {
    let Found { mut status, state, step_norm, residual_norm } = found;
    let shortage = if status.is_success() { equations.shortage_of_nodes(&state.q) } else { None };
    if shortage.is_some() {
        status = Status::Unresolved;
    }
    let mut corrector = Corrector::new(equations.n());
    corrector.evaluate(equations, &state)?;
    let stiffness = Stiffness::new(equations, &corrector.tangent);
    let judgement = stiffness.stability(equations, &state.q, &corrector.tangent);
    let load_factor = state.load_factor;
    let message = match shortage {
        Some(shortage) => outcome::unresolved(shortage),
        None => outcome::message(status, load_factor, judgement, &path),
    };
    let judgement = judgement.filter(|_| status.is_success());
    Ok(Equilibrium {
        message,
        load_factor,
        q: state.q,
        status,
        residual_norm: if residual_norm.is_nan() { norm(&corrector.residual) } else { residual_norm },
        step_norm,
        stability: judgement.map(|judgement| judgement.stability),
        counts_velocities: judgement.is_some_and(|judgement| judgement.counts_velocities),
        lowest: stiffness.lowest,
        path,
        counters: equations.counters,
    })
}
