//! Motions to a requested accuracy: chooses method and step sizes, and estimates the error that was reached.
//!
//! The error is measured at the tip: the largest distance, over the returned times, between the computed and
//! the exact position of the tip, relative to the length of the model. It has two parts: the error of the
//! steps in time, and the error of the finite number of modes and nodes in space.
//!
//! The time error is measured: every run is compared with a run at a tolerance five times tighter, and the
//! difference estimates the error (tolerance proportionality; Hairer, Norsett and Wanner 1993, section II.4).
//! Tolerances are tightened until the estimate meets the request. Vibrations that both runs would miss are
//! resolved by both, or included in the estimate. The space error is bounded by the static response to the forces
//! on modes that the model lacks, and by what the energy of this response does to frequencies (Rayleigh's
//! quotient). Where that bound leaves doubts, it is the difference to a run with two more modes of every strain
//! and more nodes, plus an estimate of what the finer model lacks. If additional nodes alone change the motion,
//! the number of nodes is increased.
//!
//! ```
//! use lissom::accuracy::{Inputs, Request, simulate_to_accuracy};
//! use lissom::pendulum::SpringPendulum;
//!
//! let pendulum = SpringPendulum::new(1.0, 1.0, 10.0, 9.81)?;
//! let request = Request::new(1e-4, 0.1);
//! let (motion, _) =
//!     simulate_to_accuracy(pendulum, (0.0, 1.0), [&[-0.7, 0.5], &[0.0; 2]], request, None, Inputs::Defaults, &mut |_| Ok(()))?;
//! assert!(motion.statistics.time_error.is_some_and(|error| error <= 1e-4));
//! # Ok::<(), lissom::error::InvalidInput>(())
//! ```

mod choice;
mod closed_loop;
mod drive;
mod features;
mod following;
mod growth_resolution;
mod inputs;
mod integrator;
mod linear;
mod missing;
mod modes;
mod paths;
mod request;
mod run;
mod side_by_side;
mod space;
mod time;
mod vibrations;

use std::time::Instant;

use crate::error::{Interrupted, InvalidInput};
use crate::model::{Model, rotation_vectors};

use crate::integrators::second_order;
use crate::simulation::simulate::{Simulation, check_control, grid};
use crate::simulation::stepping::{Start, check_span};

pub use inputs::Inputs;
pub use modes::{Modes, Purpose, Search, choose_modes, in_words};
pub use request::{DEFAULT_MAX_STEPS, DEFAULT_RTOL, Request};
pub use side_by_side::AccurateRun;
pub use vibrations::choose_modes_for_vibrations;

use inputs::{Given, Held, Recording};
use run::{Motion, Plan};

/// Computes the free motion of `model` from `q0`, `v0` over `t_span` to an accuracy. Also returns a model
/// with more quadrature nodes, if the number of nodes was open and the accuracy required more. `t_eval` are
/// the increasing times of the result. A controller of the `inputs` is called once for each of its intervals. `monitor` is called with the time after every accepted step of every
/// run and may stop the computation.
///
/// The statistics contain the estimated errors and the counters of the returned run; the wall time includes
/// all runs. If the accuracy was not reached, the status says so.
pub fn simulate_to_accuracy<M: Model + Clone>(
    mut model: M,
    t_span: (f64, f64),
    [q0, v0]: [&[f64]; 2],
    request: Request,
    t_eval: Option<&[f64]>,
    inputs: Inputs<'_>,
    monitor: &mut dyn FnMut(f64) -> Result<(), Interrupted>,
) -> Result<(Simulation, Option<M>), InvalidInput> {
    let clock = Instant::now();
    let wanted = wanted(model.facts().n, t_span, [q0, v0], request, t_eval)?;
    if let Some(step) = inputs.step() {
        check_control(step, t_span)?;
    }
    let start = fitted(&mut model, t_span.0, [q0, v0])?;
    let compared = paths::with_more_times(&wanted, t_span);
    let given = Given { t_span, start: [&start.q, &start.v], held: None, t_eval: Some(&compared) };
    let width = model.facts().inputs();
    let Motion { mut simulation, reason, factor } = match inputs {
        Inputs::Controller(control) => {
            let recording = Recording::new(control, width, t_span.0);
            closed_loop::motion(&mut model, given, request, recording, monitor)?
        }
        Inputs::Rows { step, values } => {
            let held = Held::new(step, values, width, t_span.0);
            motion(&mut model, Given { held: Some(&held), ..given }, request, monitor)?
        }
        Inputs::Defaults => motion(&mut model, given, request, monitor)?,
    };
    if factor > 1 {
        simulation
            .message
            .push_str(&format!(" The number of nodes was raised to {factor} times the default."));
    }
    if !request.space_error {
        simulation.message.push_str(" The space error is not estimated.");
    }
    simulation.message.push(' ');
    simulation.message.push_str(&reason);
    if model.facts().constraints() > 0 && simulation.status.is_success() {
        simulation.message.push_str(IN_LOOPS);
    }
    if start.moved > 0.0 {
        simulation.message.push_str(&Start::sentence(start.moved));
    }
    if let Some(doubt) = &simulation.doubt {
        simulation.message.push(' ');
        simulation.message.push_str(doubt);
    }
    simulation.statistics.wall_time = clock.elapsed().as_secs_f64();
    if compared.len() > wanted.len() {
        simulation.keep(&wanted);
    }
    model.end_steps_at(&[]);
    let defaults = model.facts().default_inputs.clone();
    model.set_inputs(&defaults);
    Ok((simulation, (factor > 1).then_some(model)))
}

/// The motion under inputs that are known, and the model with the nodes that it takes.
fn motion<M: Model + Clone>(
    model: &mut M,
    given: Given<'_>,
    request: Request,
    monitor: &mut dyn FnMut(f64) -> Result<(), Interrupted>,
) -> Result<Motion, InvalidInput> {
    let original = model.clone();
    let mut factor = 1;
    loop {
        let mut plan = Plan::new(model, given, request, None, monitor)?;
        let mut run = time::to_accuracy(&mut plan, monitor)?;
        if run.is_success() && request.space_error {
            space::add_error(&plan, &mut run, monitor)?;
        }
        match space::with_nodes(&plan, &run, (&original, 2 * factor), monitor)? {
            Some(more_nodes) => {
                factor *= 2;
                *model = more_nodes;
            }
            None => {
                let found = plan.following.doubt().filter(|_| run.is_success());
                let doubts: Vec<String> = run.simulation.doubt.take().into_iter().chain(found).collect();
                run.simulation.doubt = (!doubts.is_empty()).then(|| doubts.join(" "));
                return Ok(Motion { simulation: run.simulation, reason: plan.choice.reason, factor });
            }
        }
    }
}

/// What is not estimated of a motion with closed loops, or with tendons that do not stretch.
const IN_LOOPS: &str = " The errors are those of places on the links; those of the forces in closed loops and of tensions are not estimated.";

/// Initial state projected onto closed loops, with rotation vectors no longer than pi: near a full turn the rates of a longer vector
/// are not those of the motion, from which method and steps are chosen.
fn fitted<M: Model>(model: &mut M, t: f64, [q0, v0]: [&[f64]; 2]) -> Result<Start, InvalidInput> {
    let n = model.facts().n;
    let is_sensible = [q0, v0].iter().all(|values| values.len() == n && values.iter().all(|x| x.is_finite()));
    if !is_sensible {
        // Validation reports the problem.
        return Ok(Start { q: q0.to_vec(), v: v0.to_vec(), moved: 0.0 });
    }
    let mut start = Start::fitted(model, t, q0, v0)?;
    rotation_vectors::wrap(&model.facts().rotation_vectors, &mut start.q, &mut start.v, &mut []);
    Ok(start)
}

/// Rejects all arguments that [`simulate_to_accuracy`] would reject, before any evaluation of a motion;
/// returns the times of its result.
pub fn check<M: Model>(
    model: &mut M,
    t_span: (f64, f64),
    [q0, v0]: [&[f64]; 2],
    request: Request,
    t_eval: Option<&[f64]>,
    control_step: Option<f64>,
) -> Result<Vec<f64>, InvalidInput> {
    let times = wanted(model.facts().n, t_span, [q0, v0], request, t_eval)?;
    if let Some(step) = control_step {
        check_control(step, t_span)?;
    }
    second_order::check_times(&times, t_span)?;
    check_span(model.facts().time_span, t_span)?;
    model.check_shape(q0, "q0")?;
    Ok(times)
}

/// Times of the result.
fn wanted(
    n: usize,
    t_span: (f64, f64),
    [q0, v0]: [&[f64]; 2],
    request: Request,
    t_eval: Option<&[f64]>,
) -> Result<Vec<f64>, InvalidInput> {
    request.validate()?;
    second_order::check_start(n, t_span, q0, v0, request.dt)?;
    match t_eval {
        Some(times) => Ok(times.to_vec()),
        None => grid(n, t_span, request.dt),
    }
}
